#!/bin/sh
# `serve` under load, on the loopback interface; Linux, Python 3, and Chromium where there is one. On quiet cores:
#   benches/serve/load.sh [--seconds 60] [--frames 100000] [--only stream|memory]      (cargo build --release first)
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
exec python3 -B "$here/load.py" --binary "${BIN:-$root/target/release/shadowgauge}" --root "$root" "$@"
