#!/bin/sh
# Installs what the smoke test of the Python package runs in: NumPy and pytest from PyPI, in the virtual environment named
# by the argument, where they are not there and where it can. Always succeeds; the test then says SKIPPED.
set -u
venv="${1:?a folder for the virtual environment}"
if ! "$venv/bin/python" -c "import numpy, pytest" >/dev/null 2>&1; then
  echo "installing NumPy and pytest (PyPI) in $venv" >&2
  { python3 -m venv "$venv" && timeout 300 "$venv/bin/pip" install --quiet numpy pytest; } >/dev/null 2>&1 \
    || echo "SKIPPED: NumPy and pytest could not be installed: the Python package is not tested" >&2
fi
exit 0
