#!/bin/sh
# One report of each kind (measure with a refused frame and stations, runs of a plain and a stepped shaft, a calibration, heads side by
# side, a machine), then axe-core over them. BIN=PROGRAM takes
# another build; OUT=DIR another place.
set -eu
bin=${BIN:-target/release/shadowgauge}
out=${OUT:-out/reports_check}
rm -rf "$out"
mkdir -p "$out"
"$bin" render configs/small_shaft.toml --out "$out/frames" --frames 8 --backend cpu
# A frame without a part: what is refused is shown.
{ printf 'P2 320 200 255\n'; yes 255 | head -n 64000; } >"$out/white.pgm"
# Exit code 1 is a verdict.
"$bin" measure "$out/frames/frames" "$out/white.pgm" --um-per-px 30 --ignore-file-scale --tolerance "11±0.05" --station-mm 2 \
  --report "$out/measure.html" --csv "$out/diameters.csv" >"$out/measure.txt" || [ $? -eq 1 ]
"$bin" run configs/small_shaft.toml --out "$out/run" --backend cpu >"$out/run.txt" || [ $? -eq 1 ]
"$bin" calibrate configs/small_calibration.toml --out "$out/calibration.json" --backend cpu >"$out/calibrate.txt"
"$bin" run configs/stepped_shaft.toml --out "$out/stepped" --backend cpu >"$out/stepped.txt" || [ $? -eq 1 ]
"$bin" study head configs/head_telecentric_25.toml --report "$out/heads.html" >"$out/heads.txt"
"$bin" study machine configs/machine_001.toml --out "$out/machine" >"$out/machine.txt"
sh scripts/axe_reports.sh "$out/measure.html" "$out/run/report.html" "$out/stepped/report.html" "$out/calibration.html" "$out/heads.html" \
  "$out/machine/report.html"
