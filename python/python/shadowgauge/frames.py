"""Frames, and where they come from: files, a folder that a camera fills, anything that Python iterates."""

from __future__ import annotations

import os
import re
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from . import _shadowgauge
from .errors import FrameError

#: Extensions of images that are read.
EXTENSIONS = frozenset({".png", ".tif", ".tiff", ".bmp", ".pgm", ".jpg", ".jpeg"})


@dataclass(frozen=True)
class Frame:
    """An array with what is known of it."""

    #: Grey values, rows x columns.
    pixels: np.ndarray
    #: ``frame_id``, ``t_ns``, ``z_mm``, ``angle_deg``, ``sweep_deg``, ``exposure_us``; those left out are 0.
    meta: dict[str, Any] = field(default_factory=dict)
    #: Its name in results; its number without one.
    name: str | None = None
    #: Bits of the grey values; without them as the command line takes a file that states none.
    bits: int | None = None


def read_image(path: str | os.PathLike[str], bits: int | None = None) -> Frame:
    """Reads an image of any format that the program reads, in linear grey."""
    path = Path(path)
    try:
        pixels, found, _ = _shadowgauge.decode(path.read_bytes(), bits)
    except FrameError as error:
        raise FrameError(f"{path}: {error}") from None
    number = re.search(r"(\d+)$", path.stem)
    return Frame(pixels, {"frame_id": int(number.group()) if number else 0}, path.stem, found)


def _natural(path: Path) -> list[Any]:
    """Sorts ``frame9`` before ``frame10``."""
    return [(int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", path.name) if part]


def follow_folder(
    path: str | os.PathLike[str], *, idle_s: float | None = None, poll_s: float = 0.05
) -> Iterator[Frame]:
    """Frames of a folder in the natural order of their names, and then those that a camera adds.

    A file is read once its size has stayed the same over a poll. Ends after ``idle_s`` seconds
    without a new file; never without it.
    """
    folder = Path(path)
    if not folder.is_dir():
        raise NotADirectoryError(f"{folder}: no folder to follow")
    done: set[Path] = set()
    sizes: dict[Path, int] = {}
    last = time.monotonic()
    while True:
        there = [p for p in folder.iterdir() if p.suffix.lower() in EXTENSIONS and not p.name.startswith(".")]
        new = sorted((p for p in there if p not in done), key=_natural)
        for file in new:
            size = file.stat().st_size
            if size > 0 and sizes.get(file) == size:
                done.add(file)
                last = time.monotonic()
                yield read_image(file)
            else:
                sizes[file] = size
        if idle_s is not None and time.monotonic() - last > idle_s:
            return
        time.sleep(poll_s)
