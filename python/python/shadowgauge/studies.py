"""Studies: what ``shadowgauge study`` computes, as Python values."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from typing import Any

from .errors import StudyError


def arguments(options: dict[str, Any]) -> list[str]:
    """Options of the command line: ``scenes=100`` is ``--scenes 100``, ``True`` a bare option, a list an
    option repeated."""
    given: list[str] = []
    for key, value in options.items():
        option = "--" + key.replace("_", "-")
        values = value if isinstance(value, (list, tuple)) else [value]
        for one in values:
            if one is True:
                given.append(option)
            elif one is not None and one is not False:
                given += [option, os.fspath(one) if isinstance(one, os.PathLike) else str(one)]
    return given


def command(*words: str, threads: int | None = None) -> subprocess.CompletedProcess[str]:
    """Runs the program's command line in a process of its own, so that Ctrl-C ends it at once."""
    environment = dict(os.environ)
    if threads is not None:
        environment["RAYON_NUM_THREADS"] = str(threads)
    line = [sys.executable, "-m", "shadowgauge", *words]
    return subprocess.run(line, capture_output=True, text=True, env=environment, check=False)


def study(name: str, *inputs: str | os.PathLike[str], threads: int | None = None, **options: Any) -> Any:
    """Runs a study of the program with its options, and returns what its ``--json`` prints.

    ``study("coverage", scenes=40, seed=7)`` is ``shadowgauge study coverage --scenes 40 --seed 7
    --json``. A limit of the study that is missed is in the result; a study that is refused or fails
    raises StudyError with the program's words.
    """
    words = ["study", name, *map(os.fspath, inputs), *arguments(options), "--json"]
    done = command(*words, threads=threads)
    if done.returncode not in (0, 1):
        error = StudyError(done.stderr.strip() or f"ended with exit code {done.returncode}")
        error.exit_code = done.returncode
        raise error
    return json.loads(done.stdout)
