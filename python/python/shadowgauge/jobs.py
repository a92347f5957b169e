"""A config's job, pass after pass."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from . import _shadowgauge
from ._shadowgauge import Table
from .controller import answers
from .rendering import _config


@dataclass(frozen=True)
class PassResult:
    """A pass that was cut and measured."""

    #: Number of the pass, from 1.
    number: int
    #: Nominal diameter of the pass, mm.
    nominal_mm: float
    #: Frames taken.
    frames: int
    #: Why the offsets were held after it; None where new ones were put in force.
    held: str | None
    #: Why the next pass should not be cut before an inspection; None without a reason.
    alarm: str | None
    #: Remarks of the controller.
    notes: list[str]
    #: ``z_mm``, ``nominal_mm``, ``offset_mm``, ``d_mm``, ``u_random_mm``, ``u_common_mm``, ``flag``,
    #: and for comparison only ``true_mm``.
    stations: Table


def run(
    config: str | os.PathLike[str],
    *,
    controller: Any = None,
    name: str | None = None,
    seed: int | None = None,
    backend: str = "cpu",
) -> Iterator[PassResult]:
    """Cuts, renders, measures and corrects a config's job (a path, or the text of one), pass after pass.

    ``controller`` is the name of one of ours, a controller of your own (see
    :mod:`shadowgauge.controller`), or None for the config's. Nothing is written to disk: ``shadowgauge
    run`` writes run folders.
    """
    path, text = _config(config)
    if controller is None or isinstance(controller, str):
        native = _shadowgauge.Run(path, text, controller, None, seed, backend)
    else:
        own = controller if isinstance(controller, type) else type(controller)
        native = _shadowgauge.Run(path, text, name or own.__name__, answers(controller), seed, backend)
    return (PassResult(*result) for result in native)
