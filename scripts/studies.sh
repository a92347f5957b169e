#!/bin/sh
# Long measurements: everything the README quotes that the tests only sample. Writes out/studies/ with date and commit.
set -eu
out=out/studies
rm -rf "$out"
mkdir -p "$out"
{
  echo "date:   $(date -u +%Y-%m-%dT%H:%M:%SZ)"
  echo "commit: $(git rev-parse HEAD 2>/dev/null || echo unknown)"
  echo "cpu:    $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1), $(nproc) cores"
} > "$out/provenance.txt"
cat "$out/provenance.txt"
bin=target/release/shadowgauge
preset=configs/slender_shaft.toml

# study NAME COMMAND…: prints and keeps what the command says; a study that ends red is said, and the others go on.
study() {
  name=$1; shift
  echo; echo "== $name: $*"
  "$@" > "$out/$name.txt" 2> "$out/$name.log" || echo "(ended with exit code $?)" >> "$out/$name.txt"
  cat "$out/$name.txt"
}

# -- main job, controllers side by side
for controller in pid lsq none; do
  study "run_$controller" "$bin" run "$preset" --controller "$controller" --no-reference --out "$out/run_$controller"
done
sed 's/controller = "pid"/controller = "lsq"\n\n[control.lsq]\nshapes = "quadratic"/' "$preset" > "$out/quadratic.toml"
study run_lsq_quadratic "$bin" run "$out/quadratic.toml" --no-reference --out "$out/run_lsq_quadratic"

# -- stated against actual uncertainty over seeds
for seed in 2 3 4 5 6 7 8 9; do
  study "seed_$seed" "$bin" run "$preset" --seed "$seed" --passes 2 --no-reference --out "$out/seed_$seed"
done

# -- edges: efficiency, honesty of u, phase bias, clipped light; real washers where they are
study edges cargo test --release --locked --test gauge_edges -- --nocapture --test-threads 1
study render cargo test --release --locked --test render_frames --test render_noise -- --nocapture --test-threads 1
if [ -n "${SHADOWGAUGE_WASHERS:-}" ]; then
  study washers cargo test --release --locked --test measure_washers --test ring_measure -- --nocapture --test-threads 1
else
  echo "SKIPPED: washers (SHADOWGAUGE_WASHERS is not set)" >&2
fi

# -- papers
study reproduce_003 "$bin" reproduce 003
study reproduce_000 "$bin" reproduce 000
study stability "$bin" study stability
study controllers "$bin" study controllers --out "$out/controllers"

# -- speed, beside the floor of a kernel that only writes a constant
study render_bench "$bin" render "$preset" --bench 50 --out "$out/render_bench"

# -- optics: every edge-spread family, corners, features of the shaft, views, motion
study optics cargo test --release --locked --test optics_esf --test render_optics --test render_shaft -- --nocapture --test-threads 1
