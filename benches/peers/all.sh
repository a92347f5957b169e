#!/bin/sh
# Comparisons with what is not ours: all of them, or those that ONLY names (ONLY="camera").
#   ONLY=camera sh benches/peers/all.sh
set -eu
here=$(cd "$(dirname "$0")" && pwd)
wanted=" ${ONLY:-camera} "
case "$wanted" in *" camera "*) sh "$here/camera.sh" ;; esac
