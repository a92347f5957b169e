#!/bin/sh
# Accuracy, coverage and dirt in at most ten minutes on two cores, at fixed seeds: run before and after a change and compare.
# Writes out/studies_short/ with date and commit. BIN=PROGRAM measures with another build (the tests are always this tree's).
set -eu
out=${OUT:-out/studies_short}
bin=${BIN:-target/release/shadowgauge}
rm -rf "$out"
mkdir -p "$out"
{
  echo "date:   $(date -u +%Y-%m-%dT%H:%M:%SZ)"
  echo "commit: $(git rev-parse HEAD 2>/dev/null || echo unknown), program $bin"
  echo "cpu:    $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1), $(nproc) cores"
} | tee "$out/provenance.txt"

# study NAME COMMAND…: prints and keeps what the command prints; one that ends red is named, and the others go on.
study() {
  name=$1; shift
  echo; echo "== $name: $*"
  began=$(date +%s)
  "$@" > "$out/$name.txt" 2> "$out/$name.log" || echo "(ended with exit code $?)" >> "$out/$name.txt"
  cat "$out/$name.txt"
  echo "-- $name: $(($(date +%s) - began)) s" | tee -a "$out/provenance.txt"
}

# -- accuracy: the main job, edges against the bound, stated against actual u
study run "$bin" run configs/slender_shaft.toml --backend cpu --no-reference --out "$out/run"
[ -n "${BIN:-}" ] || study edges cargo test --release --locked --lib gauge_edges -- --nocapture --test-threads 1
study uncertainty "$bin" study uncertainty --backend cpu
# -- coverage: eight classes of 200 scenes from the budget's distributions, deviating and outside ones beside them
study coverage "$bin" study coverage --scenes 1600
# -- dirt: 600 frames a kind beside their clean twins, 3000 clean ones
study contamination "$bin" study contamination --frames 600 --clean 3000 --out "$out/contamination"
# -- real parts
if [ -n "${SHADOWGAUGE_WASHERS:-}" ]; then
  study washers "$bin" study washers "$SHADOWGAUGE_WASHERS" --out "$out/washers"
else
  echo "SKIPPED: washers (SHADOWGAUGE_WASHERS is not set)" >&2
fi
# -- speed, with the peer or floor that belongs to it
study frames "$bin" render configs/bench_2048.toml --frames 8 --backend cpu --format png8 --out "$out/frames"
study gauge_bench "$bin" measure "$out/frames/frames" --um-per-px file --threads 1 --bench 2000 --json
study render_bench "$bin" render configs/bench_2048.toml --bench 100 --json --backend cpu
