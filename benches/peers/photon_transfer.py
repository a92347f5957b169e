"""Photon transfer of rendered flat fields by the reference implementation of EMVA 1288 (PyPI `emva1288`).

Flat fields are the rows above and below a thin wire, rendered through `shadowgauge render` with photons set in the config; the
dark frame is the same with no photon. Prints what was set, what the reference implementation finds and the departure; ends red
beyond `--limit` (1 %; dark current 2 %, which is the slope of dark frames over five exposures). Rows are drawn so that those of
the whole sensor have the stated deviations. Without the wire's, their shares scatter by ½√(2·52/(rows·(rows - 52))): 1 % of 512
rows, a quarter of a per cent of 2048, so the sensor is tall and narrow. EMVA 1288 takes PRNU and DSNU as uncorrelated: of N
columns drawn apart, their product leaves DSNU/(PRNU·signal)/√N of the PRNU of columns, 0.3 % here (0.6 % at twice the DSNU).
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image

HEIGHT, WIDTH = 2048, 256
# Rows of the wire (20 px) and its blur, left out.
WIRE = slice(HEIGHT // 2 - 26, HEIGHT // 2 + 26)
ROWS = HEIGHT - (WIRE.stop - WIRE.start)
# Exposures at which dark current is found, s, and share of the full well that the light of each fills.
EXPOSURES = {0.02: 0.15, 0.04: 0.3, 0.06: 0.45, 0.08: 0.6, 0.1: 0.75}
SET = {
    "gain": 1 / 2.5,
    "read": 6.0,
    "prnu": 0.01,
    "prnu_row": 0.003,
    "prnu_col": 0.004,
    "dsnu": 4.0,
    "dsnu_row": 1.5,
    "dsnu_col": 1.0,
    "qe": 0.6,
    "black": 64.0,
    "well": 9800.0,
    "dark_mean": 2000.0,
    "dark_var": 2000.0,
}
TEMPLATE = """
seed = {seed}
[part]
length_mm = 4.0
stock_diameter_mm = 0.6
nominal_diameter_mm = [0.3]
aim_mm = 0.0
station_mm = 0.5
[scan]
fields = 1
angles = {frames}
[masters]
frames_each = 1
pins = [{{ diameter_mm = 0.2, expanded_u_mm = 0.0001 }}, {{ diameter_mm = 0.4, expanded_u_mm = 0.0001 }}]
[camera]
columns = {width}
rows = {height}
{exposure}pixel_um = 3.0
[optics]
magnification = 0.2
[light]
bright_photons = {photons}
shadow_counts = 64.0
[sensor]
electrons_per_count = 2.5
quantum_efficiency = 0.6
read_noise_e = 6.0
black_level_counts = 64.0
full_well_e = 9800.0
prnu_rel = 0.01
dsnu_e = 4.0
[sensor.spatial]
dsnu_row_e = 1.5
dsnu_column_e = 1.0
prnu_row_rel = 0.003
prnu_column_rel = 0.004
{dark}[departures]
magnification_rel = 0.0
blur_rel = 0.0
gain_rel = 0.0
"""


# Of the sensor and of the figure: no doubling between them.
SAME_TEMPERATURE = "measured_at_c = 25.0\ntemperature_c = 25.0\n"


def flats(binary, folder, photons, frames, seed=11, exposure_s=None):
    exposure, dark = "", ""
    if exposure_s is not None:
        exposure = f"exposure_us = {1e6 * exposure_s:.0f}\n"
        dark = f"[sensor.dark_current]\nelectrons_per_s = {SET['dark_mean']}\n{SAME_TEMPERATURE}"
    values = {"photons": photons, "frames": frames, "seed": seed, "exposure": exposure, "dark": dark}
    config = folder / f"p{photons:.0f}_{seed}.toml"
    config.write_text(TEMPLATE.format(height=HEIGHT, width=WIDTH, **values))
    out = folder / f"p{photons:.0f}_{seed}"
    command = [binary, "render", str(config), "--out", str(out), "--frames", str(frames), "--backend", "cpu"]
    subprocess.run(command, check=True, capture_output=True)
    files = sorted((out / "frames").glob("*.png"))
    return [np.delete(np.array(Image.open(f)).astype(np.int64), WIRE, axis=0) for f in files]


def sums(frames):
    """What emva1288 keeps of a stack of L frames: L, the sum S, and Σ(L·y - S)² = L(L·Σy² - S²), pixel by pixel."""
    stack = np.stack(frames)
    total = stack.sum(axis=0)
    count = len(frames)
    return {"L": count, "sum": total, "pvar": count * (count * (stack**2).sum(axis=0) - total**2)}


def pair(frames):
    """The same of two frames, added up over the pixels, and the difference of their means."""
    a, b = frames[:2]
    return {"sum": (a + b).sum(), "pvar": 2 * ((a - b) ** 2).sum(), "dmean": a.mean() - b.mean()}


def packed(temporal, spatial):
    """The dictionary that emva1288 takes."""
    return {
        "format": {"bits": 12, "width": WIDTH, "height": ROWS},
        "name": "rendered flat fields",
        "width": WIDTH,
        "height": ROWS,
        "temporal": temporal,
        "spatial": spatial,
    }


def dark_frames(binary, folder):
    """Pairs of dark and bright frames at every exposure, by nanoseconds."""
    found = {}
    for i, (seconds, fill) in enumerate(EXPOSURES.items()):
        photons = fill * SET["well"] / SET["qe"]
        pairs = {p: flats(binary, folder, p, 2, 200 + 2 * i + (p > 0), seconds) for p in (0.0, photons)}
        found[1e9 * seconds] = {p: pair(frames) for p, frames in pairs.items()}
    return found


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--binary", required=True)
    parser.add_argument("--limit", type=float, default=0.01)
    args = parser.parse_args()
    if not hasattr(np, "asfarray"):  # emva1288 1.0.2 was written for NumPy 1
        np.asfarray = lambda values: np.asarray(values, dtype=float)
    try:
        from emva1288.process.data import Data1288
        from emva1288.process.results import Results1288
    except ImportError as error:
        print(f"SKIPPED: {error}")
        return 0
    steps = 30
    top = 0.95 * SET["well"] / SET["qe"]
    photons = [0.0] + [top * (i + 1) / steps for i in range(steps + 2)]
    half = 0.5 * SET["well"] / SET["qe"]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        temporal_data, spatial_data = {}, {}
        dark = flats(args.binary, folder, 0.0, 60)
        bright = flats(args.binary, folder, half, 60)
        exposure = 1e6
        # A seed a level: one noise field in all of them would err alike in all of them.
        pairs = {p: flats(args.binary, folder, p, 2, 100 + i) for i, p in enumerate(photons[1:])}
        temporal_data[exposure] = {0.0: pair(dark), **{p: pair(f) for p, f in pairs.items()}}
        spatial_data[exposure] = {0.0: sums(dark), half: sums(bright)}
        data = packed(temporal_data, spatial_data)
        results = Results1288(Data1288(data).data, loglevel=40)
        over_time = packed(dark_frames(args.binary, folder), spatial_data)
        of_dark = Results1288(Data1288(over_time).data, loglevel=40)
        found = {
            "gain": results.K,
            "read": results.sigma_d,
            "prnu": results.PRNU1288 / 100,
            "prnu_row": results.PRNU1288_row / 100,
            "prnu_col": results.PRNU1288_col / 100,
            "dsnu": results.DSNU1288,
            "dsnu_row": results.DSNU1288_row,
            "dsnu_col": results.DSNU1288_col,
            "qe": results.QE / 100,
            "dark_mean": of_dark.u_I_mean,
            "dark_var": of_dark.u_I_var,
        }
    worst = 0.0
    print(f"{'quantity':10} {'set':>10} {'emva1288':>10} {'departure':>10}")
    for key, value in found.items():
        departure = value / SET[key] - 1
        worst = max(worst, abs(departure) / (2 if key.startswith("dark") else 1))
        print(f"{key:10} {SET[key]:10.5f} {value:10.5f} {100 * departure:9.2f} %")
    print(f"linearity error {results.LE_min:.3f} to {results.LE_max:.3f} %")
    return 0 if worst <= args.limit else 1


if __name__ == "__main__":
    sys.exit(main())
