"""``python -m shadowgauge``: the program's command line.

One option is Python's own: ``study controllers --with module:Class`` compares a controller written in
Python with ours, on equal terms (``shadowgauge.controller``).
"""

from __future__ import annotations

import shlex
import signal
import sys

from . import _shadowgauge
from .controller import load


def own_controllers(words: list[str]) -> list[str]:
    """``--with module:Class`` of ``study controllers`` as the ``--with-command`` that it is."""
    if words[:2] != ["study", "controllers"]:
        return words
    given: list[str] = []
    rest = iter(words)
    for word in rest:
        name = next(rest, "") if word == "--with" else word.removeprefix("--with=")
        if word != "--with" and not word.startswith("--with="):
            given.append(word)
            continue
        try:
            load(name)
        except Exception as error:  # whatever a module of the user's does at its import
            sys.exit(f"--with {name}: {type(error).__name__}: {error}; right is module:Class of a controller in Python")
        program = f"{shlex.quote(sys.executable)} -m shadowgauge.serve {shlex.quote(name)}"
        given += ["--with-command", f"{name.rpartition(':')[2]}={program}"]
    return given


def main() -> None:
    """The program, by this process's arguments."""
    # The program has its own way with Ctrl-C and closed pipes; Python's would wait for it to end.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(_shadowgauge.command_line(["shadowgauge", *own_controllers(sys.argv[1:])]))


if __name__ == "__main__":
    main()
