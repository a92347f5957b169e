"""What the tests of the wheel share."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "python" / "examples"
SMALL = ROOT / "configs" / "small_shaft.toml"


def shadow(rows=140, columns=64, dtype=np.uint8, dark=12, bright=210, top=40.5, bottom=99.5):
    """A sharp shadow from row 40.5 to row 99.5: 59 pixels."""
    row = np.arange(rows)
    inside = (row > top) & (row < bottom)
    return np.repeat(np.where(inside, dark, bright).astype(dtype)[:, None], columns, axis=1)


@pytest.fixture
def frame():
    return shadow()


def python(*words, cwd=None, **options):
    """Runs this Python."""
    line = [sys.executable, *map(str, words)]
    return subprocess.run(line, capture_output=True, text=True, cwd=cwd, check=False, timeout=500, **options)


def program(*words, cwd=None):
    """Runs the program's command line in this Python."""
    return python("-m", "shadowgauge", *words, cwd=cwd)
