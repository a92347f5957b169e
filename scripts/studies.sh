#!/bin/sh
# Long measurements: everything the README quotes that the tests only sample. Writes out/studies/ with date and commit.
set -eu
out=out/studies
mkdir -p "$out"
{
  echo "date:   $(date -u +%Y-%m-%dT%H:%M:%SZ)"
  echo "commit: $(git rev-parse HEAD 2>/dev/null || echo unknown)"
  echo "cpu:    $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1), $(nproc) cores"
} > "$out/provenance.txt"
cat "$out/provenance.txt"
bin=target/release/shadowgauge

echo "== main job, controllers side by side"
for controller in pid lsq none; do
  rm -rf "$out/run_$controller"
  "$bin" run configs/slender_shaft.toml --controller "$controller" --no-reference --out "$out/run_$controller" || true
done | tee "$out/controllers.txt"

echo "== main job, stated against actual uncertainty over seeds"
for seed in 1 2 3 4 5 6 7 8 9 10; do
  rm -rf "$out/seed_$seed"
  "$bin" run configs/slender_shaft.toml --seed "$seed" --passes 2 --no-reference --out "$out/seed_$seed" | grep -E '^ +[0-9]' | sed "s/^/seed $seed /"
done | tee "$out/seeds.txt"
