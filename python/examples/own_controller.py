"""A controller of one's own in the closed loop: the next pass is cut from rendered, measured pixels.

    python own_controller.py CONFIG.toml
    python -m shadowgauge study controllers --shafts 2 --with own_controller:HalfTheError
"""

import sys

import numpy as np

import shadowgauge as sg


class HalfTheError:
    """Takes half of every station's error off the next pass, smoothed over three stations."""

    share = 0.5

    def begin(self, part: dict) -> None:
        """A new part: nothing is kept of the last one."""
        self.stations = len(part["station_z_mm"])

    def decide(self, measured: sg.MeasuredPass):
        """Offsets of the next pass, mm of diameter."""
        error_mm = measured.error_mm
        if np.isnan(error_mm).any():
            return sg.Hold(f"no reading at station {int(np.argmax(np.isnan(error_mm))) + 1}")
        padded = np.pad(error_mm, 1, mode="edge")
        smooth_mm = np.convolve(padded, np.full(3, 1 / 3), mode="valid")
        return measured.offset_mm + self.share * smooth_mm


def main(config: str) -> None:
    """Prints the largest error of every pass."""
    for result in sg.run(config, controller=HalfTheError()):
        stations = result.stations
        error_um = 1e3 * (stations["d_mm"] - stations["nominal_mm"])
        print(f"pass {result.number}: largest error {np.nanmax(np.abs(error_um)):.2f} µm, {result.frames} frames")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
