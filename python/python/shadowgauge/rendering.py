"""Rendered frames with their truth."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from . import _shadowgauge
from .frames import Frame


@dataclass(frozen=True)
class RenderedFrame(Frame):
    """A rendered frame, and where its edges truly lie."""

    #: True row of the upper edge of every column, px.
    true_top_px: np.ndarray | None = None
    #: True row of the lower edge of every column, px.
    true_bottom_px: np.ndarray | None = None
    #: Pixel size on the object by the data sheets, µm.
    nominal_um_per_px: float = float("nan")
    #: True pixel size on the object, µm.
    true_um_per_px: float = float("nan")


def _config(config: str | os.PathLike[str]) -> tuple[os.PathLike[str] | str, str | None]:
    """A config's path, or the folder beside which a text's files lie, and the text."""
    if isinstance(config, str) and ("\n" in config or "=" in config):
        return Path("."), config
    return config, None


def render(
    config: str | os.PathLike[str],
    frames: int | None = None,
    *,
    noise: bool = True,
    seed: int | None = None,
    backend: str = "cpu",
) -> Iterator[RenderedFrame]:
    """Frames of a config's shaft (a path, or the text of one), as ``shadowgauge render`` draws them:
    one scan, or ``frames`` of it."""
    path, text = _config(config)
    scene = _shadowgauge.Scene(path, text, seed, backend)
    for index in range(len(scene) if frames is None else frames):
        pixels, bits, meta = scene.frame(index, noise)
        top, bottom = scene.true_edges(index)
        yield RenderedFrame(
            pixels, meta, f"{index:06}", bits, top, bottom, scene.nominal_um_per_px, scene.true_um_per_px
        )
