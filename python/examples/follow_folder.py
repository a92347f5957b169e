"""Follows a folder that a camera fills: every frame is measured as it comes; at the end there is a
pandas table, and a plot where matplotlib is installed.

    python follow_folder.py FOLDER UM_PER_PX [IDLE_S]
"""

import sys
from pathlib import Path

import pandas as pd

import shadowgauge as sg


def follow(folder: str, um_per_px: float, idle_s: float) -> pd.DataFrame:
    """A row a frame."""
    stream = sg.Stream(sg.Gauge(), sg.Calibration.from_scale(um_per_px))
    for measured in stream.measure(sg.follow_folder(folder, idle_s=idle_s)):
        print(measured)
    return pd.DataFrame(dict(stream.table()))


def plot(table: pd.DataFrame, path: Path) -> bool:
    """Diameter over the frames with its standard uncertainty; False without matplotlib."""
    try:
        import matplotlib
    except ImportError:
        return False
    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots()
    axes.errorbar(table["frame_id"], table["max_diameter_mm"], yerr=table["u_max_mm"], fmt="o")
    axes.set(xlabel="frame", ylabel="largest diameter / mm")
    figure.savefig(path)
    return True


def main(folder: str, um_per_px: str, idle_s: str = "2") -> None:
    """Prints the table; the plot is diameters.svg in the working folder."""
    table = follow(folder, float(um_per_px), float(idle_s))
    print(table.to_string(index=False))
    if plot(table, Path("diameters.svg")):
        print("diameters.svg")


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
