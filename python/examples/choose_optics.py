"""Chooses the magnification of a telecentric head for a part: for each, frames are rendered and
measured, and the errors of their diameters stand beside the truth.

    python choose_optics.py
"""

import sys

import numpy as np

import shadowgauge as sg

#: A part of Ø 6 mm before a small camera; only the magnification differs.
CONFIG = """
name = "choice of optics"
seed = 3
[part]
length_mm = 20.0
stock_diameter_mm = 6.4
nominal_diameter_mm = [6.0]
[scan]
fields = 1
angles = 3
[camera]
columns = 256
rows = 400
[optics]
magnification = {magnification}
[[masters.pins]]
diameter_mm = 5.0
expanded_u_mm = 0.0002
[[masters.pins]]
diameter_mm = 6.3
expanded_u_mm = 0.0002
"""


def errors_um(magnification: float) -> tuple[np.ndarray, np.ndarray]:
    """Errors of the mean width of every frame, µm, and their random standard uncertainties."""
    gauge = sg.Gauge()
    found = []
    for frame in sg.render(CONFIG.format(magnification=magnification)):
        edges = gauge.edges(frame.pixels, bits=frame.bits)
        true_px = np.mean(frame.true_bottom_px - frame.true_top_px)
        u_px = np.sqrt(np.nansum(edges.u_top_px**2 + edges.u_bottom_px**2)) / edges.valid
        found.append(((np.nanmean(edges.width_px) - true_px) * frame.true_um_per_px, u_px * frame.true_um_per_px))
    return tuple(np.array(found).T)


def main() -> None:
    """Prints a row a magnification."""
    print("magnification  rms error / µm   mean u / µm")
    for magnification in (0.1, 0.15, 0.2):
        error_um, u_um = errors_um(magnification)
        print(f"{magnification:13.3f}  {np.sqrt(np.mean(error_um**2)):14.4f}  {u_um.mean():12.4f}")


if __name__ == "__main__":
    sys.exit(main())
