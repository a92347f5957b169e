"""Frames as they are rendered without this crate, beside it: edge error against the truth, ms a frame with noise.

The scene is configs/bench_2048.toml's: 2048 x 2048, 12 bit, a level cylinder, Gaussian blur. An edge's place is read off a noise-free
frame as the light above it, Σ(I - shadow)/contrast, which blur and pixel area leave where the geometry is. Times are the median.
"""

import argparse
import csv
import json
import subprocess
import tempfile
import time

import cv2
import numpy as np
from PIL import Image
from scipy.special import erf

SHADOW, BRIGHT, BLACK, ELECTRONS, READ = 110.0, 3100.0, 64.0, 2.6, 2.4


def noisy(counts, rng):
    electrons = np.maximum(counts - BLACK, 0) * ELECTRONS
    spread = np.sqrt(electrons + READ * READ) / ELECTRONS
    counts = counts + rng.standard_normal(counts.shape, dtype=np.float32) * spread
    return np.clip(np.rint(counts), 0, 4095).astype(np.uint16)


def polygon(top, bottom, rows, sigma):
    """A polygon filled at eight times the resolution, reduced by averaging, then blurred: OpenCV's way."""
    columns = len(top)
    fine = 8 * (np.arange(columns) + 0.5) - 0.5
    at = lambda row: 8 * (row + 0.5) - 0.5
    along = np.concatenate([[0], fine, [8 * columns - 1]])
    ends = lambda row: np.concatenate([row[:1], row, row[-1:]])
    upper = np.stack([along, at(ends(top))], axis=1)
    lower = np.stack([along[::-1], at(ends(bottom))[::-1]], axis=1)
    image = np.full((8 * rows, 8 * columns), 255, np.uint8)
    cv2.fillPoly(image, [np.rint(np.concatenate([upper, lower])).astype(np.int32)], 0)
    light = cv2.resize(image, (columns, rows), interpolation=cv2.INTER_AREA).astype(np.float32) / 255
    return SHADOW + (BRIGHT - SHADOW) * cv2.GaussianBlur(light, (0, 0), sigma)


def direct(top, bottom, rows, sigma):
    """Error function of the distance at every pixel's centre."""
    y = np.arange(rows, dtype=np.float32)[:, None]
    s = np.float32(sigma * np.sqrt(2))
    light = 1 - 0.5 * (1 + erf((y - top.astype(np.float32)) / s)) + 0.5 * (1 + erf((y - bottom.astype(np.float32)) / s))
    return SHADOW + (BRIGHT - SHADOW) * light


def edge_error(counts, top, bottom):
    light = (counts.astype(np.float64) - SHADOW) / (BRIGHT - SHADOW)
    middle = int((top.mean() + bottom.mean()) / 2)
    upper = light[:middle].sum(axis=0) - 0.5 - top
    lower = (len(light) - 0.5) - light[middle:].sum(axis=0) - bottom
    both = np.concatenate([upper, -lower])
    return both.mean(), np.abs(both).max()


def truth(folder):
    rows = list(csv.DictReader(open(f"{folder}/truth.csv", newline="")))
    first = [r for r in rows if r["frame"] == "000000"]
    return np.array([float(r["top_px"]) for r in first]), np.array([float(r["bottom_px"]) for r in first])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--binary", required=True)
    parser.add_argument("--config", required=True)
    parser.add_argument("--frames", type=int, default=10)
    args = parser.parse_args()
    table = []
    with tempfile.TemporaryDirectory() as folder:
        out = f"{folder}/out"
        common = [args.binary, "render", args.config]
        subprocess.run([*common, "--out", out, "--frames", "1", "--format", "f32", "--no-noise", "--backend", "cpu"], check=True, capture_output=True)
        top, bottom = truth(out)
        sigma = json.load(open(f"{out}/truth.json"))["esf"]["gaussian"]["sigma_px"]
        ours = np.array(Image.open(f"{out}/frames/000000.tif"))
        for backend in ("cpu", "vulkan"):
            bench = subprocess.run([*common, "--bench", str(5 * args.frames), "--json", "--backend", backend], capture_output=True)
            if bench.returncode != 0:
                print(f"SKIPPED: this crate by {backend}: {bench.stderr.decode().strip()}")
                continue
            report = json.loads(bench.stdout)
            table.append((f"this crate, {report['adapter']}", *edge_error(ours, top, bottom), report["ms_per_frame_median"]))
    for name, draw in (("OpenCV polygon 8 x finer, blur, noise", polygon), ("numpy erf at every pixel, noise", direct)):
        rng, times = np.random.default_rng(1), []
        for _ in range(args.frames):
            start = time.perf_counter()
            noisy(draw(top, bottom, len(ours), sigma), rng)
            times.append(1e3 * (time.perf_counter() - start))
        table.append((name, *edge_error(draw(top, bottom, len(ours), sigma), top, bottom), float(np.median(times))))
    print(f"{'renderer':46} {'mean edge error px':>19} {'worst px':>10} {'ms a frame':>11}")
    for name, mean, worst, ms in table:
        print(f"{name:46} {mean:19.2e} {worst:10.2e} {ms:11.2f}")


if __name__ == "__main__":
    main()
