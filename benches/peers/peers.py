"""The same frames through this crate and its peers: error against the truth, edges kept, edges per second.

Frames: 2048 x 2048, 8 bit, blur 1 px, bright 210 and dark 12 counts, 50 electrons a count, read noise 10 electrons. An
edge counts as kept where the method gives one within 1 px of the truth. Times are the least of --repeat, one thread, frame in memory.
As this crate follows its edges from frame to frame, every peer is given the rows around them only ("bands", found in every eighth row and
column, which is timed with it); on whole frames they take several to fifty times as long (--whole).
"""

import argparse
import csv
import json
import os
import subprocess
import tempfile
import time

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import cv2
import numpy as np
from PIL import Image
from scipy.special import erf, ndtr
from skimage import measure

cv2.setNumThreads(1)
N, DARK, LIGHT, SIGMA = 2048, 12.0, 210.0, 1.0


def truth(seed):
    c = np.arange(N)
    return (
        403.3 + 0.0031 * c + 0.3 * np.sin(c / 300 + seed),
        1643.7 - 0.0027 * c + 0.3 * np.cos(c / 270 + seed),
    )


def step(rows, x):
    """Light fraction of the pixels for a level edge at x, light towards larger rows."""
    g = lambda u: u * 0.5 * (1 + erf(u / (SIGMA * np.sqrt(2)))) + SIGMA * np.exp(-0.5 * (u / SIGMA) ** 2) / np.sqrt(2 * np.pi)
    return g(rows + 0.5 - x) - g(rows - 0.5 - x)


def frame(seed):
    rng = np.random.default_rng(seed)
    top, bottom = truth(seed)
    rows = np.arange(N, dtype=np.float64)[:, None]
    light = 1 - step(rows, top) + step(rows, bottom)
    electrons = 50 * (DARK + (LIGHT - DARK) * light)
    electrons += rng.normal(size=electrons.shape) * np.sqrt(electrons + 100)
    return np.clip(np.round(electrons / 50), 0, 255).astype(np.uint8)


HALF = 10
REACH = 24
WHOLE = False


def bands(image):
    """First and last row (exclusive) of the two stretches in which the edges lie."""
    if WHOLE:
        return [(0, N)]
    shadow = image[::8, ::8] < (DARK + LIGHT) / 2
    first, last = 8 * shadow.argmax(axis=0), N - 8 * shadow[::-1].argmax(axis=0)
    near = lambda low, high: (max(int(low) - REACH, 0), min(int(high) + REACH, N))
    return [near(first.min() - 8, first.max()), near(last.min() - 8, last.max())]


def in_bands(call):
    """Points of a method that knows nothing of bands."""

    def points(image):
        found = [(call(image[a:b]), a) for a, b in bands(image)]
        return np.concatenate([p + (a, 0) for p, a in found if len(p)])

    return points


def windows(image):
    """Windows of 21 pixels around the whole-pixel edges, from shadow to light: one column an edge, upper edges first."""
    (a, b), (c, d) = bands(image) if not WHOLE else [(0, N // 2), (N // 2, N)]
    threshold = (DARK + LIGHT) / 2
    first = a + (image[a:b] < threshold).argmax(axis=0)
    last = d - 1 - (image[c:d][::-1] < threshold).argmax(axis=0)
    k = np.arange(-HALF, HALF + 1)[:, None]
    columns = np.arange(N)
    up, down = image[first - k, columns], image[last + k, columns]
    return np.concatenate([up, down], axis=1).astype(np.float64), first, last


def solve_four(normal, right):
    """Symmetric 4 x 4 systems, all edges at once, by Cholesky's method: normal[i][j] and right[i] hold one number an edge."""
    low = [[None] * 4 for _ in range(4)]
    for i in range(4):
        for j in range(i + 1):
            rest = normal[i][j] - sum(low[i][k] * low[j][k] for k in range(j))
            low[i][j] = np.sqrt(rest) if i == j else rest / low[j][j]
    y = []
    for i in range(4):
        y.append((right[i] - sum(low[i][k] * y[k] for k in range(i))) / low[i][i])
    x = [None] * 4
    for i in reversed(range(4)):
        x[i] = (y[i] - sum(low[k][i] * x[k] for k in range(i + 1, 4))) / low[i][i]
    return x


def fit_erf(image):
    """Gauss-Newton for position, blur and both levels of all edges at once, pixel-integrated model, unweighted."""
    pixels, first, last = windows(image)
    borders = (np.arange(-HALF, HALF + 2) - 0.5)[:, None]
    dark, light = pixels[:5].mean(axis=0), pixels[-5:].mean(axis=0)
    x = HALF + 0.5 - (pixels.sum(axis=0) - (2 * HALF + 1) * dark) / (light - dark)
    sigma = np.full(2 * N, 1.0)
    for _ in range(3):
        u = borders - x
        t = u / sigma
        cdf, pdf = ndtr(t), np.exp(-0.5 * t * t) * 0.3989422804014327
        model = np.diff(u * cdf + sigma * pdf, axis=0)
        contrast = light - dark
        design = [-contrast * np.diff(cdf, axis=0), contrast * np.diff(pdf, axis=0), 1 - model, model]
        residual = pixels - dark - contrast * model
        over = lambda a, b: np.einsum("ke,ke->e", a, b)
        normal = [[over(design[i], design[j]) for j in range(i + 1)] for i in range(4)]
        move = solve_four(normal, [over(part, residual) for part in design])
        x = x + np.clip(move[0], -0.5, 0.5)
        sigma = np.clip(sigma + move[1], 0.3, 4)
        dark, light = dark + move[2], light + move[3]
    return [first - x[:N], last + x[N:]]


def by_points(points, seed):
    """Nearest points of a contour list (row, column) to the truth per column."""
    found = []
    for x in truth(seed):
        value = np.full(N, np.nan)
        column = np.round(points[:, 1]).astype(int).clip(0, N - 1)
        near = np.abs(points[:, 0] - x[column]) < 3
        rows, cols = points[near, 0], column[near]
        order = np.argsort(np.abs(points[near, 1] - cols))[::-1]
        value[cols[order]] = rows[order]
        found.append(value)
    return found


def contours(part):
    return np.concatenate(measure.find_contours(part, (DARK + LIGHT) / 2))


def pixel_contours(part):
    _, binary = cv2.threshold(part, int((DARK + LIGHT) / 2), 255, cv2.THRESH_BINARY)
    lists, _ = cv2.findContours(binary, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    return np.concatenate([c[:, 0, ::-1] for c in lists]).astype(float)


def devernay(part):
    """Canny edges, each moved to the vertex of the parabola through three gradient magnitudes across it; gradients only where edges are."""
    edges = cv2.Canny(part, 60, 150)
    lines = np.nonzero(edges.any(axis=1))[0]
    points = []
    for band in np.split(lines, np.nonzero(np.diff(lines) > 16)[0] + 1):
        top = max(band[0] - 8, 0)
        near = part[top : band[-1] + 9].astype(np.float32)
        smooth = cv2.GaussianBlur(near, (0, 0), 1.0)
        size = cv2.magnitude(cv2.Sobel(smooth, cv2.CV_32F, 1, 0), cv2.Sobel(smooth, cv2.CV_32F, 0, 1))
        rows, columns = np.nonzero(edges[top : top + len(near)])
        keep = (rows > 0) & (rows < len(near) - 1)
        rows, columns = rows[keep], columns[keep]
        a, b, c = size[rows - 1, columns], size[rows, columns], size[rows + 1, columns]
        bend = a - 2 * b + c
        shift = np.where(bend < 0, 0.5 * (a - c) / np.where(bend == 0, 1, bend), 0)
        points.append(np.stack([top + rows + np.clip(shift, -1, 1), columns.astype(float)], axis=1))
    return np.concatenate(points)


def partial_area(part):
    from subpixel_edges import subpixel_edges

    e = subpixel_edges(part.astype(float), 25, 0, 2)
    return np.stack([np.asarray(e.y), np.asarray(e.x)], axis=1)


def row(name, runs, seconds):
    errors = [np.concatenate([f - t for f, t in zip(found, truth(seed))]) for seed, found in runs]
    errors = np.concatenate(errors)
    kept = np.abs(errors) < 1
    rmse = np.sqrt(np.mean(errors[kept] ** 2)) if kept.any() else float("nan")
    return name, rmse, kept.mean(), 2 * N / seconds


def timed(call, images, repeat):
    """Results, and the least time of a frame: what another program takes from the machine only ever adds."""
    best, results = float("inf"), [call(image) for image in images]
    for image in images * repeat:
        start = time.perf_counter()
        call(image)
        best = min(best, time.perf_counter() - start)
    return results, best


def ours(binary, images):
    with tempfile.TemporaryDirectory() as folder:
        for i, image in enumerate(images):
            Image.fromarray(image).save(f"{folder}/{i:06d}.png")
        edges = f"{folder}/edges.csv"
        command = [binary, "measure", folder, "--json", "--threads", "1", "--edges", edges, "--bench", "2000"]
        bench = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)["bench"]
        runs = [(i, [np.full(N, np.nan), np.full(N, np.nan)]) for i in range(len(images))]
        with open(edges, newline="") as file:
            for r in csv.DictReader(file):
                if r["top_px"] and r["bottom_px"]:
                    i, c = int(r["frame"]), int(r["column"])
                    runs[i][1][0][c], runs[i][1][1][c] = float(r["top_px"]), float(r["bottom_px"])
    return row("this crate (u, chi2, flags)", runs, bench["ms_per_frame_min"] * 1e-3)


def rust_crate(binary, images):
    """The Rust crate subpixel-edge, in a project of its own, on the same bands."""
    with tempfile.TemporaryDirectory() as folder:
        parts = [(i, a, image[a:b]) for i, image in enumerate(images) for a, b in bands(image)]
        paths = [f"{folder}/{k:06d}.png" for k in range(len(parts))]
        for path, (_, _, part) in zip(paths, parts):
            Image.fromarray(part).save(path)
        command = [binary, f"{folder}/points.csv", *paths]
        seconds = float(subprocess.run(command, check=True, capture_output=True).stdout) * len(parts) / len(images)
        table = np.loadtxt(f"{folder}/points.csv", delimiter=",", skiprows=1, ndmin=2)
    points = [np.zeros((0, 2)) for _ in images]
    for k, (i, top, _) in enumerate(parts):
        points[i] = np.concatenate([points[i], table[table[:, 0] == k, 1:] + (top, 0)])
    return row("subpixel-edge (Rust crate)", [(i, by_points(p, i)) for i, p in enumerate(points)], seconds)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--frames", type=int, default=4)
    parser.add_argument("--binary", required=True)
    parser.add_argument("--rust-peer")
    parser.add_argument("--repeat", type=int, default=10)
    parser.add_argument("--whole", action="store_true", help="peers get whole frames")
    args = parser.parse_args()
    global WHOLE
    WHOLE = args.whole
    images = [frame(seed) for seed in range(args.frames)]
    table = [ours(args.binary, images)]
    found, seconds = timed(fit_erf, images, args.repeat)
    table.append(row("numpy/scipy erf fit, all free", list(enumerate(found)), seconds))
    peers = {
        "OpenCV Canny + Devernay": devernay,
        "scikit-image find_contours": contours,
        "subpixel-edges (partial area)": partial_area,
        "OpenCV findContours (pixels)": pixel_contours,
    }
    for name, call in peers.items():
        try:
            found, seconds = timed(in_bands(call), images, args.repeat)
        except Exception as error:  # a peer that does not run here is said to be missing, the others go on
            print(f"{name}: not measured ({error})")
            continue
        runs = [(seed, by_points(points, seed)) for seed, points in enumerate(found)]
        table.append(row(name, runs, seconds))
    if args.rust_peer:
        table.append(rust_crate(args.rust_peer, images))
    else:
        print("subpixel-edge (Rust crate): not measured (it was not built)")
    print("bounds: .01631 px (levels and sigma free), .01448 (sigma known), .01331 (all known)")
    print(f"{'method':34} {'RMSE px':>9} {'kept':>7} {'edges/s':>12} {'ours is faster by':>18}")
    for name, rmse, kept, speed in table:
        print(f"{name:34} {rmse:9.5f} {kept:7.4f} {speed:12.0f} {table[0][3] / speed:18.1f}")


if __name__ == "__main__":
    main()
