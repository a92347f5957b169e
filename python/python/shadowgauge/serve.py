"""A controller in Python as a program: ``python -m shadowgauge.serve MODULE:CLASS``.

It speaks the protocol of docs/controllers.md: lines of JSON on stdin and stdout. ``study controllers
--with MODULE:CLASS`` starts one a shaft.
"""

from __future__ import annotations

import json
import sys

from .controller import answers, load


def serve(name: str) -> None:
    """Answers the lines of stdin on stdout until they end."""
    replies = sys.stdout
    # What the controller prints is a remark.
    sys.stdout = sys.stderr
    answer = answers(load(name))
    for line in iter(sys.stdin.readline, ""):
        reply = answer(line)
        if reply is not None:
            replies.write(reply + "\n")
            replies.flush()
        if json.loads(line)["type"] == "end":
            return


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python -m shadowgauge.serve MODULE:CLASS")
    serve(sys.argv[1])
