#!/bin/sh
# The pictures of README.md and docs/: the charts of the demo's report and the contact sheet of what the renderer draws. The CPU path, so
# that they are the same on every machine. BIN=PROGRAM draws with another build.
set -eu
bin=${BIN:-target/release/shadowgauge}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$bin" demo --backend cpu --out "$work/demo"
for name in error_along_z convergence axis turn; do
  cp "$work/demo/plots/$name.svg" "docs/$name.svg"
done
"$bin" render --gallery "$work/gallery" --backend cpu
cp "$work/gallery/contact_sheet.png" docs/gallery.png
ls -l docs/*.svg docs/*.png
