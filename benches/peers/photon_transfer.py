"""Photon transfer of rendered flat fields by the reference implementation of EMVA 1288 (PyPI `emva1288`).

Flat fields are the rows above and below a thin wire, rendered through `shadowgauge render` with photons set in the config; the
dark frame is the same with no photon. Prints what was set, what the reference implementation finds and the departure; ends red
beyond `--limit` (1 %). Rows are drawn so that those of the whole sensor have the stated deviations: without the wire's, their
shares scatter by 1 %, so that these two have twice the limit.
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image

SIZE = 512
# Rows of the wire (20 px) and its blur, left out.
WIRE = slice(230, 282)
ROWS = SIZE - (WIRE.stop - WIRE.start)
SET = {
    "gain": 1 / 2.5,
    "read": 6.0,
    "prnu": 0.01,
    "prnu_row": 0.003,
    "prnu_col": 0.004,
    "dsnu": 8.0,
    "dsnu_row": 3.0,
    "dsnu_col": 2.0,
    "qe": 0.6,
    "black": 64.0,
    "well": 9800.0,
}
OF_ROWS = ("prnu_row", "dsnu_row")
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
columns = {size}
rows = {size}
pixel_um = 3.0
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
dsnu_e = 8.0
[sensor.spatial]
dsnu_row_e = 3.0
dsnu_column_e = 2.0
prnu_row_rel = 0.003
prnu_column_rel = 0.004
[departures]
magnification_rel = 0.0
blur_rel = 0.0
gain_rel = 0.0
"""


def flats(binary, folder, photons, frames, seed=11):
    config = folder / f"p{photons:.0f}_{seed}.toml"
    config.write_text(TEMPLATE.format(size=SIZE, photons=photons, frames=frames, seed=seed))
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
        data = {
            "format": {"bits": 12, "width": SIZE, "height": ROWS},
            "name": "rendered flat fields",
            "width": SIZE,
            "height": ROWS,
            "temporal": temporal_data,
            "spatial": spatial_data,
        }
        results = Results1288(Data1288(data).data, loglevel=40)
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
        }
    worst = 0.0
    print(f"{'quantity':10} {'set':>10} {'emva1288':>10} {'departure':>10}")
    for key, value in found.items():
        departure = value / SET[key] - 1
        worst = max(worst, abs(departure) / (2 if key in OF_ROWS else 1))
        print(f"{key:10} {SET[key]:10.5f} {value:10.5f} {100 * departure:9.2f} %")
    print(f"linearity error {results.LE_min:.3f} to {results.LE_max:.3f} %")
    return 0 if worst <= args.limit else 1


if __name__ == "__main__":
    sys.exit(main())
