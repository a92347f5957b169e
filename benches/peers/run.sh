#!/bin/sh
# Measures the same frames with this crate and with what else can be installed; prints one table. Makes its own venv.
#   benches/peers/run.sh [FRAMES]      (4 frames by default; cargo build --release first)
set -eu
here=$(cd "$(dirname "$0")" && pwd)
venv="$here/../../target/peers-venv"
if [ ! -x "$venv/bin/python" ]; then
    python3 -m venv "$venv"
    "$venv/bin/pip" install -q -r "$here/requirements.txt"
fi
exec "$venv/bin/python" "$here/peers.py" --frames "${1:-4}" --binary "$here/../../target/release/shadowgauge"
