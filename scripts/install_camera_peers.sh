#!/bin/sh
# Installs what the tests hold the published camera and the receiver against: Aravis' tools (Debian packages
# aravis-tools-cli and aravis-tools), EMVA's GenApi and a fake camera (PyPI packages genicam and viva-genicam, in the
# virtual environment named by the argument), where they are not there and where it can. Always succeeds; the tests of
# cameras then say SKIPPED.
set -u
skip() { echo "SKIPPED: $1" >&2; }
venv="${1:?a folder for the virtual environment}"
if ! command -v arv-camera-test-0.8 >/dev/null 2>&1 || ! command -v arv-tool-0.8 >/dev/null 2>&1; then
  if [ "$(id -u)" = 0 ]; then as_root=""; elif sudo -n true >/dev/null 2>&1; then as_root="sudo -n"; else as_root="false"; fi
  export DEBIAN_FRONTEND=noninteractive
  echo "installing Aravis' tools (aravis-tools-cli, aravis-tools)" >&2
  # shellcheck disable=SC2086
  timeout 300 $as_root apt-get install -y -qq --no-install-recommends aravis-tools-cli aravis-tools >/dev/null 2>&1 \
    || { timeout 120 $as_root apt-get update -qq && timeout 300 $as_root apt-get install -y -qq --no-install-recommends aravis-tools-cli aravis-tools; } >/dev/null 2>&1 \
    || skip "Aravis' tools could not be installed: the published camera is not received by them"
fi
if ! "$venv/bin/python" -c "import genicam.genapi" >/dev/null 2>&1; then
  echo "installing EMVA's GenApi (PyPI genicam) in $venv" >&2
  { python3 -m venv "$venv" && timeout 300 "$venv/bin/pip" install --quiet genicam==1.6.0; } >/dev/null 2>&1 \
    || skip "EMVA's GenApi could not be installed: it does not read the published camera's XML"
fi
if ! "$venv/bin/python" -c "import viva_genicam.testing" >/dev/null 2>&1; then
  echo "installing the fake camera of viva-genicam (PyPI) in $venv" >&2
  { python3 -m venv "$venv" && timeout 300 "$venv/bin/pip" install --quiet viva-genicam==0.10.0; } >/dev/null 2>&1 \
    || skip "viva-genicam could not be installed: its fake camera is not received"
fi
exit 0
