#!/bin/sh
# Installs LinuxCNC's stand-alone interpreter (rs274, Debian package linuxcnc-uspace) where it is not there and where it
# can: as root, with passwordless sudo, or not at all. Always succeeds; the tests of the NC programs then say SKIPPED.
set -u
command -v rs274 >/dev/null 2>&1 && exit 0
skip() { echo "SKIPPED: $1; NC programs are not read by LinuxCNC's interpreter (package linuxcnc-uspace)" >&2; exit 0; }
command -v apt-get >/dev/null 2>&1 || skip "no apt-get"
if [ "$(id -u)" = 0 ]; then as_root=""; elif sudo -n true >/dev/null 2>&1; then as_root="sudo -n"; else
  skip "neither root nor sudo to install it"
fi
export DEBIAN_FRONTEND=noninteractive
candidate() { apt-cache policy linuxcnc-uspace 2>/dev/null | sed -n 's/^ *Candidate: *//p' | grep -v none; }
# shellcheck disable=SC2086
if [ -z "$(candidate)" ]; then $as_root apt-get update -qq >/dev/null 2>&1; fi
[ -n "$(candidate)" ] || skip "no package linuxcnc-uspace here"
echo "installing LinuxCNC's interpreter (linuxcnc-uspace)" >&2
# shellcheck disable=SC2086
timeout 300 $as_root apt-get install -y -qq --no-install-recommends linuxcnc-uspace >/dev/null 2>&1 \
  || skip "it could not be installed"
exit 0
