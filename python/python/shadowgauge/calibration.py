"""Calibrations: pixels to millimetres."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from pathlib import Path

from . import _shadowgauge
from ._shadowgauge import Edges
from .errors import CalibrationError


class Calibration:
    """Pixels to millimetres at 20 °C, with the uncertainties of both."""

    __slots__ = ("_native",)

    def __init__(self, native: _shadowgauge.Calibration):
        if not isinstance(native, _shadowgauge.Calibration):
            raise TypeError("use Calibration.from_scale, Calibration.load or Calibration.fit")
        self._native = native

    @classmethod
    def from_scale(cls, um_per_px: float) -> Calibration:
        """A bare scale in µm per pixel, without offset and uncertainty, as ``measure --um-per-px``."""
        return cls(_shadowgauge.Calibration.from_scale(um_per_px))

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Calibration:
        """A calibration file, as ``shadowgauge calibrate`` writes it."""
        text = Path(path).read_text(encoding="utf-8")
        try:
            return cls(_shadowgauge.Calibration.from_json(text))
        except CalibrationError as error:
            raise CalibrationError(f"{os.fspath(path)}: {error}") from None

    @classmethod
    def fit(cls, masters: Iterable[tuple[float, float, Sequence[Edges]]]) -> Calibration:
        """Scale and offset by master pins: ``(diameter_mm, expanded_u_mm, edges)`` of each, the
        certificate's U at k = 2 and the edges of the frames that show it."""
        return cls(_shadowgauge.Calibration.fit([(d, u, list(edges)) for d, u, edges in masters]))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes it as a calibration file, under a temporary name that is then renamed."""
        path = Path(path)
        temporary = path.with_name(f".tmp-{path.name}")
        temporary.write_text(self._native.to_json() + "\n", encoding="utf-8")
        temporary.replace(path)

    @property
    def scale_um_per_px(self) -> float:
        """Scale on the object, µm per pixel."""
        return self._native.scale_um_per_px

    @property
    def offset_um(self) -> float:
        """What both edges together add to every width, µm."""
        return self._native.offset_um

    @property
    def optics_id(self) -> str:
        """The optics that it belongs to; empty where none is named."""
        return self._native.optics_id

    def diameters(self, edges: Edges) -> _shadowgauge.Table:
        """The diameter of every column: ``column``, ``d_mm``, ``u_random_mm``, ``u_common_mm``, ``flag``."""
        return self._native.diameters(edges)

    def __repr__(self) -> str:
        return repr(self._native)
