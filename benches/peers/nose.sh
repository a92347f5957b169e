#!/bin/sh
# Measures the same back-lit noses with this crate and as one would without it (OpenCV's LSD with total least squares, IPOL's
# LSD), in pairs in one run; prints one table. Makes its own venv.
#   benches/peers/nose.sh [NOSES]      (10 by default; cargo build --release first)
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
venv="${VENVS:-$root/target}/nose-peers-venv"
if [ ! -x "$venv/bin/python" ]; then
    python3 -m venv "$venv"
    "$venv/bin/pip" install -q -r "$here/requirements_nose.txt" || {
        echo "SKIPPED in part: not all of requirements_nose.txt installs here; each one alone:" >&2
        while read -r package; do
            "$venv/bin/pip" install -q "$package" || echo "SKIPPED: $package does not install" >&2
        done < "$here/requirements_nose.txt"
    }
fi
[ -x "$root/target/release/shadowgauge" ] || (cd "$root" && cargo build --release --locked)
exec "$venv/bin/python" "$here/nose_peers.py" --noses "${1:-10}" --binary "$root/target/release/shadowgauge"
