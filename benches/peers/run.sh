#!/bin/sh
# Measures the same frames with this crate and with what else can be installed; prints one table. Makes its own venv and
# builds the Rust peer as a project of its own, both below target/.
#   benches/peers/run.sh [FRAMES]      (4 frames by default)
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
venv="${VENVS:-$root/target}/peers-venv"
if [ ! -x "$venv/bin/python" ]; then
    python3 -m venv "$venv"
    "$venv/bin/pip" install -q -r "$here/requirements.txt"
fi
[ -x "$root/target/release/shadowgauge" ] || (cd "$root" && cargo build --release --locked)
peer="$root/target/peers-rust/release/peer-subpixel-edge"
if [ ! -x "$peer" ]; then
    CARGO_TARGET_DIR="$root/target/peers-rust" cargo build --release -q --manifest-path "$here/rust/Cargo.toml" || peer=
fi
exec "$venv/bin/python" "$here/peers.py" --frames "${1:-4}" --binary "$root/target/release/shadowgauge" ${peer:+--rust-peer "$peer"}
