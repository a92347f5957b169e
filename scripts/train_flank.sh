#!/bin/sh
# The forest that the program brings along, from rendered flanks alone: draws them, trains, and compares the
# bytes with src/gauge/flank/flank.forest. With WRITE=1 it replaces that file (build anew afterwards).
set -eu
cd "$(dirname "$0")/.."
BIN="${BIN:-target/release/shadowgauge}"
DIR="${DIR:-out/train_flank}"
FLANKS=48
rm -rf "$DIR"
mkdir -p "$DIR"
"$BIN" tool render-flank --random "$FLANKS" --size 800x520 --um-per-px 2 --seed 1 --out "$DIR/flanks"
"$BIN" tool train "$DIR/flanks" --um-per-px 2 --seed 1 --trained-on "$FLANKS rendered flanks" --out "$DIR/flank.forest"
if [ "${WRITE:-}" = 1 ]; then
  cp "$DIR/flank.forest" src/gauge/flank/flank.forest
elif cmp "$DIR/flank.forest" src/gauge/flank/flank.forest; then
  echo "the shipped forest is the one of this script"
else
  echo "the shipped forest is another one than this script's: WRITE=1 sh scripts/train_flank.sh replaces it" >&2
  exit 1
fi
