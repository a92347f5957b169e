#!/bin/sh
# Every page and flow of `serve` in a headless Chromium: upload -> compensation -> program, start run -> watch -> report, calibrate ->
# history, live; then each page at 1280 and 390 px, light and dark: axe-core, no sideways scroll, no shift of the layout, first paint,
# weight, no other host asked. Pictures of all of them go to OUT.
#   BIN=PROGRAM OUT=DIR AXE=axe.min.js sh scripts/pages_check.sh
# Needs Chromium (Debian: apt-get install chromium) and Node 18 or newer; axe-core from AXE or by npm. Where Chromium or Node is missing it
# prints SKIPPED and ends well; REQUIRE_AXE=1 makes that, and a missing axe-core, an error.
set -eu
bin=${BIN:-target/release/shadowgauge}
out=${OUT:-out/pages_check}

skipped() {
  echo "SKIPPED: pages are not $1: $2" >&2
  [ "${REQUIRE_AXE:-0}" != 1 ] || exit 1
}

browser=
for name in chromium chromium-browser google-chrome; do
  if command -v "$name" >/dev/null 2>&1; then browser=$name; break; fi
done
[ -n "$browser" ] || { skipped "driven" "no Chromium (apt-get install chromium)"; exit 0; }
command -v node >/dev/null 2>&1 || { skipped "driven" "no Node (apt-get install nodejs)"; exit 0; }

rm -rf "$out"
mkdir -p "$out/runs"
axe=${AXE:-}
if [ -z "$axe" ]; then
  if (cd "$out" && npm pack --silent axe-core@4 >/dev/null 2>&1 && tar xzf axe-core-*.tgz); then axe=$out/package/axe.min.js
  else skipped "checked by axe-core" "npm cannot fetch it, and AXE names no axe.min.js"; fi
fi

# Images of a nose and a flank, and a job of two passes in seconds.
"$bin" tool render configs/tool/insert.toml --out "$out/insert" >/dev/null
"$bin" tool render-flank configs/tool/flank.toml --out "$out/flank" >/dev/null
cp configs/small_shaft.toml "$out/job.toml"
work=$out/work.json
here=$(pwd)
case $out in /*) at=$out ;; *) at=$here/$out ;; esac
printf '{"job": "%s", "nose": "%s", "flank": "%s", "modes": ["compensated", "batch", "plain"], "calibrations": 3}\n' "$at/job.toml" "$at/insert/frames/000000.png" "$at/flank/000000.png" >"$work"

"$bin" serve --listen 127.0.0.1:0 --runs "$out/runs" --store "$out/store.sqlite" --source "sim:configs/small_shaft.toml" -- --um-per-px 30 \
  >"$out/address.txt" 2>"$out/serve.log" &
server=$!
trap 'kill "$server" 2>/dev/null || true' EXIT
for _ in $(seq 100); do
  url=$(head -n 1 "$out/address.txt")
  [ -z "$url" ] || break
  sleep 0.1
done
[ -n "$url" ] || { cat "$out/serve.log" >&2; exit 1; }
node scripts/pages/check.mjs all "$url" "$browser" "$work" "$out/pictures" ${axe:+"$axe"}
