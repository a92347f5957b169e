"""Controllers of one's own, in Python.

A controller is any object with ``decide(measured)``, which is called after every pass with a
:class:`MeasuredPass` and returns the offsets of the next one: a number a station, mm of diameter, or
``Hold("why")``. ``begin(part)``, where it has one, is called before the first pass with the keys of
``begin`` (docs/controllers.md). An offset is subtracted from the nominal diameter: a shaft that is
too thick needs a larger one. The guards of ``[control.guards]`` stand before what it returns.

``python -m shadowgauge.serve MODULE:CLASS`` is the same controller as a program on pipes.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Hold:
    """The offsets in force shall hold, and why."""

    reason: str


class MeasuredPass:
    """A pass that was cut and measured. Arrays have one value a station; NaN in a gap."""

    __slots__ = ("message", "station_nominal_mm")

    def __init__(self, message: dict[str, Any], relative_mm: list[float] | None = None):
        #: All keys of ``pass``, as docs/controllers.md lists them.
        self.message = message
        #: Nominal diameter r of every station, mm: of a stepped shaft each its own section's.
        self.station_nominal_mm = message["nominal_mm"] + (
            np.array(relative_mm) if relative_mm else np.zeros(len(message["stations"]))
        )

    def _values(self, key: str) -> np.ndarray:
        readings = [station["reading"].get("value") for station in self.message["stations"]]
        return np.array([np.nan if value is None else value[key] for value in readings])

    @property
    def number(self) -> int:
        """Number of the pass, from 1."""
        return self.message["pass"]

    @property
    def nominal_mm(self) -> float:
        """Nominal diameter of the pass, mm; of a stepped shaft that of its largest section."""
        return self.message["nominal_mm"]

    @property
    def z_mm(self) -> np.ndarray:
        """Middles of the stations, mm from the chuck face."""
        return np.array([station["z_mm"] for station in self.message["stations"]])

    @property
    def d_mm(self) -> np.ndarray:
        """Measured diameters, mm."""
        return self._values("d_mm")

    @property
    def u_random_mm(self) -> np.ndarray:
        """Their standard uncertainties that shrink with averaging, mm."""
        return self._values("u_random_mm")

    @property
    def u_common_mm(self) -> np.ndarray:
        """Their standard uncertainties that all readings of a calibration share, mm."""
        return self._values("u_common_mm")

    @property
    def error_mm(self) -> np.ndarray:
        """Error D - r of every station, mm of diameter."""
        return self.d_mm - self.station_nominal_mm

    @property
    def offset_mm(self) -> np.ndarray:
        """Offsets with which the pass was cut, mm of diameter."""
        return np.array(self.message["offsets_mm"])

    @property
    def held(self) -> str | None:
        """Why the offsets decided before were not put in force; None where they were."""
        return self.message["held"]

    @property
    def next(self) -> dict[str, Any] | None:
        """The pass that the offsets are for; None after the last one."""
        return self.message["next"]


def _reply(number: int, decided: Any) -> str:
    if isinstance(decided, Hold):
        return json.dumps({"pass": number, "hold": str(decided.reason)})
    if decided is None:
        raise TypeError("decide() returned None; right are offsets, a number a station, or Hold('why')")
    offsets = np.asarray(decided, dtype=float)
    if offsets.ndim != 1:
        raise TypeError(f"decide() returned an array of {offsets.ndim} dimensions; right is one, a number a station")
    return json.dumps({"pass": number, "offsets_mm": offsets.tolist()})


def answers(controller: Any) -> Callable[[str], str | None]:
    """The function of a line that stands for a controller: a line of the protocol in, the reply or None
    out."""
    if isinstance(controller, type):
        controller = controller()
    if not callable(getattr(controller, "decide", None)):
        raise TypeError(f"{controller!r} is no controller: it has no method decide(measured)")

    relative_mm: list[float] = []

    def answer(line: str) -> str | None:
        message = json.loads(line)
        if message["type"] == "begin":
            relative_mm[:] = message.get("station_relative_mm", [])
            if callable(getattr(controller, "begin", None)):
                controller.begin(message)
        elif message["type"] == "pass":
            return _reply(message["pass"], controller.decide(MeasuredPass(message, relative_mm)))
        return None

    return answer


def load(name: str) -> Any:
    """The controller of ``module:Class``; the working folder is looked in first, as Python does for a
    script."""
    module_name, _, attribute = name.partition(":")
    if not module_name or not attribute:
        raise ValueError(f"{name!r} names no controller; right is module:Class, as in mine:MyController")
    if os.getcwd() not in sys.path and "" not in sys.path:
        sys.path.insert(0, os.getcwd())
    found = getattr(importlib.import_module(module_name), attribute)
    return found() if isinstance(found, type) else found
