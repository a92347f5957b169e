"""The gauge by itself, and streams of frames."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from . import _shadowgauge
from ._shadowgauge import Edges, Measurement, Table
from .calibration import Calibration
from .errors import FrameRefused
from .frames import Frame


class Gauge:
    """The gauge. ``settings`` are the keys of ``[gauge]`` in a config (``shadowgauge schema`` prints
    them), checked once; with a calibration it expects the residual that its masters left."""

    __slots__ = ("_native",)

    def __init__(self, settings: dict[str, Any] | None = None, *, calibration: Calibration | None = None):
        native = calibration._native if calibration is not None else None
        self._native = _shadowgauge.Gauge(json.dumps(settings or {}), native)

    def edges(self, frame: np.ndarray, *, bits: int | None = None, full_scale: float | None = None) -> Edges:
        """Both edges of every column of a frame by itself. Raises FrameRefused where it shows no part."""
        return self._native.edges(frame, bits, full_scale)

    def measure(
        self,
        frame: np.ndarray,
        calibration: Calibration,
        *,
        bits: int | None = None,
        full_scale: float | None = None,
        **settings: Any,
    ) -> Measurement:
        """Largest and mean diameter of a frame by itself; ``settings`` are those of :class:`Stream`.
        Raises FrameRefused where it has none."""
        stream = _shadowgauge.Stream(self._native, calibration._native, json.dumps(settings), False)
        measured = stream.push(frame, None, None, bits, full_scale)
        return _accepted(measured)


def _accepted(measured: Measurement) -> Measurement:
    if measured.refusal is not None:
        refused = FrameRefused(measured.refusal)
        refused.measurement = measured
        raise refused
    return measured


class Stream:
    """Measures the frames of one camera one after another; tables, tracking and buffers are kept.

    In millimetres with a calibration, otherwise in pixels. ``settings`` are the options of ``measure``
    under the names of the library: ``tolerance``, ``station_mm``, ``vertical``, ``budget``, ``turn``, …
    """

    __slots__ = ("_native",)

    def __init__(
        self,
        gauge: Gauge,
        calibration: Calibration | None = None,
        *,
        keep_rows: bool = True,
        **settings: Any,
    ):
        native = calibration._native if calibration is not None else None
        self._native = _shadowgauge.Stream(gauge._native, native, json.dumps(settings), keep_rows)

    def push(
        self,
        frame: np.ndarray | Frame,
        *,
        name: str | None = None,
        bits: int | None = None,
        full_scale: float | None = None,
        **meta: Any,
    ) -> Measurement:
        """Measures a frame; ``meta`` is what is known of it (``frame_id``, ``t_ns``, ``z_mm``,
        ``angle_deg``, …). A frame without a diameter has a ``refusal`` and counts as a gap."""
        if isinstance(frame, Frame):
            given = {**frame.meta, **meta}
            return self._native.push(frame.pixels, given, name or frame.name, bits or frame.bits, full_scale)
        return self._native.push(frame, meta or None, name, bits, full_scale)

    def measure(self, source: Iterable[np.ndarray | Frame]) -> Iterator[Measurement]:
        """Measures the frames of anything that Python iterates: arrays, or :class:`Frame`. Arrays are
        numbered from 0. What the source raises ends the measurement."""
        for number, frame in enumerate(source):
            if isinstance(frame, Frame):
                yield self.push(frame)
            else:
                yield self.push(frame, frame_id=number)

    @property
    def edges(self) -> Edges | None:
        """Edges of the frame pushed last; None where it was refused."""
        return self._native.edges()

    def table(self) -> Table:
        """A row a frame so far, NaN and a ``flag`` for a frame without a diameter."""
        return self._native.table()

    def finish(self) -> dict[str, Any]:
        """Ends the stream: statistics, turn, conditions and warnings over all frames."""
        return json.loads(self._native.finish())
