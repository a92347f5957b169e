#!/bin/sh
# Long measurements: everything docs/accuracy.md quotes that the tests only sample. Writes out/studies/ with date and commit.
# All of them take about an hour; ONLY="coverage edges" runs those whose names match a word of it and leaves the others' results.
set -eu
out=out/studies
only=${ONLY:-}
[ -n "$only" ] || rm -rf "$out"
mkdir -p "$out"
{
  echo "date:   $(date -u +%Y-%m-%dT%H:%M:%SZ)"
  echo "commit: $(git rev-parse HEAD 2>/dev/null || echo unknown)"
  echo "cpu:    $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1), $(nproc) cores"
} | tee -a "$out/provenance.txt"
bin=target/release/shadowgauge
preset=configs/slender_shaft.toml

# wanted NAME: whether the study is to be run: all of them, or those that match a word of ONLY (a shell pattern).
wanted() {
  [ -n "$only" ] || return 0
  for word in $only; do
    # shellcheck disable=SC2254 # the word is a pattern
    case $1 in $word) return 0 ;; esac
  done
  return 1
}

# study NAME COMMAND…: prints and keeps what the command says; a study that ends red is said, and the others go on.
study() {
  name=$1; shift
  wanted "$name" || return 0
  echo; echo "== $name: $*"
  rm -rf "${out:?}/$name"
  began=$(date +%s)
  "$@" > "$out/$name.txt" 2> "$out/$name.log" || echo "(ended with exit code $?)" >> "$out/$name.txt"
  cat "$out/$name.txt"
  echo "-- $name: $(($(date +%s) - began)) s" | tee -a "$out/provenance.txt"
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
study edges cargo test --release --locked --lib gauge_edges -- --nocapture --test-threads 1
study render cargo test --release --locked --lib -- render_frames render_noise --nocapture --test-threads 1
study efficiency cargo test --release --locked --lib every_cell -- --ignored --nocapture
study reference_frames cargo test --release --locked --lib sixteen -- --ignored --nocapture
# 10^4 frames of 2048 x 2048 pixels, 12 bit, in memory: first frame, median, p99 on one thread and on two
study gauge_frames "$bin" render configs/bench_2048.toml --frames 8 --backend cpu --out "$out/gauge_frames"
for threads in 1 2; do
  study "gauge_bench_$threads" "$bin" measure "$out/gauge_frames/frames" --um-per-px file --threads "$threads" --bench 10000 --json
done
study edge_peers sh benches/peers/run.sh
study roi cargo test --release --locked --lib frames_a_second -- --ignored --nocapture --test-threads 1
# circles and lines of constructed cases (limit 1 nm) with their certificates; sizes and lobes over a turn
study form cargo test --release --locked --lib -- form_features form_turn --nocapture --test-threads 1
study uncertainty "$bin" study uncertainty --backend cpu
study coverage "$bin" study coverage --scenes 10000
study contamination "$bin" study contamination --frames 2300 --clean 10000 --out "$out/contamination"
if [ -n "${SHADOWGAUGE_WASHERS:-}" ]; then
  study washers_caliper cargo test --release --locked --test measure_washers -- --nocapture --test-threads 1
  study washers "$bin" study washers "$SHADOWGAUGE_WASHERS" --out "$out/washers"
else
  echo "SKIPPED: washers (SHADOWGAUGE_WASHERS is not set)" >&2
fi

# -- papers
study reproduce_003 "$bin" reproduce 003
study reproduce_000 "$bin" reproduce 000
study reproduce_004 "$bin" reproduce 004
study stability "$bin" study stability
study controllers "$bin" study controllers --out "$out/controllers"
grep -v -e '^repeatability_um' -e '^stock_form_um' -e '^force_spread' configs/controllers.toml > "$out/steady.toml"
study controllers_steady "$bin" study controllers "$out/steady.toml" --controllers model --shafts 1
study parts "$bin" study parts --out "$out/parts"
study parts_model "$bin" study parts --controller model --out "$out/parts_model"

# -- speed of the process: a pass of 1000 stations (limit 2 ms), genetic algorithm (limit 0.1 s) beside the exact method
study process_bench cargo bench --locked --bench process

# -- speed, beside the floor of a kernel that only writes a constant
study render_bench "$bin" render "$preset" --bench 50
for backend in vulkan cpu; do
  study "render_bench_2048_$backend" "$bin" render configs/bench_2048.toml --bench 200 --json --backend "$backend"
  study "render_windows_$backend" "$bin" render configs/bench_2048.toml --bench 500 --windows 32 --json --backend "$backend"
  study "render_everything_$backend" "$bin" render configs/bench_everything.toml --bench 50 --json --backend "$backend"
done
# 10^5 small frames: resident memory before, after 1 000 and after all of them
study render_memory "$bin" render configs/head_wire.toml --bench 100000 --windows 32 --json --backend cpu

# -- the renderer beside other ways, and EMVA 1288's reference implementation on rendered flat fields
study render_peers sh benches/peers/render.sh

# -- optics: every edge-spread family, corners, features of the shaft, views, motion
study optics cargo test --release --locked --lib -- optics_esf render_optics render_shaft --nocapture --test-threads 1
