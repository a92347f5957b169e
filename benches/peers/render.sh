#!/bin/sh
# Renders the same frame with this crate and as one would without it, then checks rendered flat fields with the reference
# implementation of EMVA 1288. Makes its own venv.
#   benches/peers/render.sh      (cargo build --release first)
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root="$here/../.."
venv="${VENVS:-$root/target}/render-peers-venv"
if [ ! -x "$venv/bin/python" ]; then
    python3 -m venv "$venv"
    "$venv/bin/pip" install -q -r "$here/requirements_render.txt"
fi
"$venv/bin/python" "$here/render_peers.py" --binary "$root/target/release/shadowgauge" --config "$root/configs/bench_2048.toml"
exec "$venv/bin/python" "$here/photon_transfer.py" --binary "$root/target/release/shadowgauge"
