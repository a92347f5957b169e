#!/bin/sh
# The published head, and this program as a receiver, before what is not ours: the crate telegenic (built as a project of
# its own below target/), Aravis' tools and PyPI viva-genicam (scripts/install_camera_peers.sh), where they can be had; and
# the figures of docs/cameras.md, "How well", on the loopback interface. Prints one table; Linux.
#   benches/peers/camera.sh [--short] [ROW...]      (cargo build --release first; rows: benches/peers/camera/run.py --help)
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
binary=${BIN:-$root/target/release/shadowgauge}
venv="$root/target/camera_peers"
sh "$root/scripts/install_camera_peers.sh" "$venv"
if [ -z "${GENICAM_PYTHON:-}" ] && [ -x "$venv/bin/python" ]; then GENICAM_PYTHON="$venv/bin/python"; fi
export GENICAM_PYTHON="${GENICAM_PYTHON:-python3}"
peer=${TELEGENIC:-$root/target/peers-camera/release/peer-telegenic}
if [ ! -x "$peer" ]; then
    CARGO_TARGET_DIR="$root/target/peers-camera" cargo build --release --locked -q --manifest-path "$here/camera_rust/Cargo.toml" || peer=
fi
exec python3 -B "$here/camera/run.py" --binary "$binary" ${peer:+--telegenic "$peer"} "$@"
