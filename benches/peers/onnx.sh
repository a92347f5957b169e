#!/bin/sh
# Networks for the land of a flank: makes the test networks anew by ONNX's own package and compares them, byte by byte, with
# those of the tests; then builds the crate with the feature `onnx` and runs the tests that have it.
#   benches/peers/onnx.sh
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
venv="${VENVS:-$root/target}/onnx-peers-venv"
if [ ! -x "$venv/bin/python" ]; then
    python3 -m venv "$venv"
    "$venv/bin/pip" install -q -r "$here/requirements_onnx.txt"
fi
made="${VENVS:-$root/target}/onnx-made"
rm -rf "$made"
mkdir -p "$made"
cp "$root/tests/data/onnx/make.py" "$made/"
"$venv/bin/python" "$made/make.py"
for file in "$made"/*.onnx "$made"/*.csv; do
    cmp "$file" "$root/tests/data/onnx/$(basename "$file")"
done
echo "$(ls "$made"/*.onnx | wc -l) networks and the reference evaluator's answers are those of the tests"
cd "$root"
cargo test --release --locked --features onnx --lib -- \
    gauge::flank::network inside::flank::by_network inside::flank::feature cli::tool::flank::model
