#!/bin/sh
# A forest from rendered flanks alone, with its errors on flanks that were left out: what a shipped one would be made by.
set -eu
cd "$(dirname "$0")/.."
BIN="${BIN:-target/release/shadowgauge}"
DIR="${DIR:-out/train_flank}"
FLANKS=24
rm -rf "$DIR"
mkdir -p "$DIR"
"$BIN" tool render-flank --random "$FLANKS" --size 600x400 --um-per-px 2 --seed 1 --out "$DIR/flanks"
"$BIN" tool train "$DIR/flanks" --um-per-px 2 --seed 1 --trained-on "$FLANKS rendered flanks" --out "$DIR/flank.forest"
