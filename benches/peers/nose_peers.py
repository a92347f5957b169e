"""Back-lit noses as they are measured by this crate and without it: errors against the truth, ms an image.

`study nose --out` draws the noses (new, round, flat, dented, chipped, in any direction) with their truth. Every image is measured by
every method in turn, in one run on one thread; images stand decoded in memory. Methods:

- this crate, `tool nose --mode ml` and `--mode paper` (time by its own `--bench`);
- OpenCV's line segment detector, then a line through the pixels within 5 px of each segment by total least squares, weighted by
  the square of their gradient;
- IPOL's LSD (PyPI pylsd-nova), its two segments as they are.

All but the paper's mode are given the nominal radius alone, to find the centre; the paper's mode is given the included angle too.
The mean radius of the peers is that of the gradient's centre of mass along the radius, degree by degree.
"""

import argparse
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import time

try:
    import cv2
    import numpy as np
except ImportError as error:
    sys.exit(f"SKIPPED: {error}; pip install -r benches/peers/requirements_nose.txt")

try:
    from pylsd import lsd as ipol_lsd
except Exception as error:  # a library that does not load is no ImportError
    ipol_lsd = None
    print(f"SKIPPED: IPOL's LSD: {error!r}", file=sys.stderr)

NEAR_PX = 5.0
BEYOND_NOSE = 0.3
ANGLE_DEG = 2.0
ONE_THREAD = dict(os.environ, RAYON_NUM_THREADS="1")

TOOL = """nose_radius_mm = {radius_mm!r}
kappa_r_deg = 93.0
epsilon_r_deg = {epsilon_deg!r}
tip_direction = 3
numbering = "fanuc"
[image]
plus_x_deg = {plus_x_deg!r}
plus_z_deg = {plus_z_deg!r}
"""


def grey8(image):
    low, high = np.percentile(image[::7, ::7], [1, 99])
    return np.clip((image.astype(np.float32) - low) * (255.0 / (high - low)), 0, 255).astype(np.uint8)


def corner(segments, epsilon_deg):
    """The two longest segments at the insert's angle, each as (place, unit vector away from the corner, length)."""
    segments = np.asarray(segments, float).reshape(len(segments), -1)[:, :4]
    lengths = np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1])
    order = np.argsort(-lengths)[:16]
    best = None
    for k, i in enumerate(order):
        for j in order[k + 1 :]:
            p, q = segments[i], segments[j]
            u, v = p[2:] - p[:2], q[2:] - q[:2]
            cross = u[0] * v[1] - u[1] * v[0]
            if abs(cross) < 1e-6:
                continue
            w = q[:2] - p[:2]
            apex = p[:2] + (w[0] * v[1] - w[1] * v[0]) / cross * u
            edges = []
            for s in (p, q):
                middle = 0.5 * (s[:2] + s[2:])
                along = (s[2:] - s[:2]) / np.hypot(*(s[2:] - s[:2]))
                edges.append((middle, along if along @ (middle - apex) > 0 else -along))
            angle = math.degrees(math.acos(np.clip(edges[0][1] @ edges[1][1], -1, 1)))
            score = min(lengths[i], lengths[j])
            if abs(angle - epsilon_deg) < ANGLE_DEG and (best is None or score > best[0]):
                best = (score, edges, lengths[[i, j]])
    if best is None:
        raise ValueError("no two segments at the insert's angle")
    return best[1], best[2]


def total_least_squares(gradient2, edge, length, away_px):
    """A line through the pixels near a segment, weighted by the square of the gradient, beyond `away_px` of the corner's end."""
    middle, along = edge
    across = np.array([-along[1], along[0]])
    half = max(0.5 * length - away_px, 10.0)
    centre = middle + along * (0.5 * length - half)
    ends = [centre + along * a + across * b for a in (-half, half) for b in (-NEAR_PX, NEAR_PX)]
    low = np.floor(np.min(ends, axis=0)).astype(int).clip(0)
    high = np.ceil(np.max(ends, axis=0)).astype(int) + 1
    window = gradient2[low[1] : high[1], low[0] : high[0]]
    rows, columns = np.nonzero(window > 0)
    x, y = columns + low[0] - centre[0], rows + low[1] - centre[1]
    keep = (np.abs(x * along[0] + y * along[1]) <= half) & (np.abs(x * across[0] + y * across[1]) <= NEAR_PX)
    w, x, y = window[rows[keep], columns[keep]].astype(float), x[keep], y[keep]
    mx, my = np.average(x, weights=w), np.average(y, weights=w)
    x, y = x - mx, y - my
    angle = 0.5 * math.atan2(2 * (w * x * y).sum(), (w * x * x).sum() - (w * y * y).sum())
    found = np.array([math.cos(angle), math.sin(angle)])
    return centre + [mx, my], found if found @ along > 0 else -found


def gradients(image):
    x, y = cv2.Sobel(image, cv2.CV_32F, 1, 0), cv2.Sobel(image, cv2.CV_32F, 0, 1)
    return x * x + y * y


def nose_of(edges, gradient2, radius_px):
    """Angle, centre at the nominal radius from both lines, and mean radius about it."""
    normals, offsets = [], []
    inwards = edges[0][1] + edges[1][1]
    for place, along in edges:
        normal = np.array([-along[1], along[0]])
        normal = normal if normal @ inwards < 0 else -normal
        normals.append(normal)
        offsets.append(normal @ place - radius_px)
    centre = np.linalg.solve(np.array(normals), np.array(offsets))
    angle = math.degrees(math.acos(np.clip(edges[0][1] @ edges[1][1], -1, 1)))
    towards = math.atan2(*(-inwards)[::-1])
    half = 0.5 * math.radians(180 - angle)
    turns = towards + np.linspace(-half, half, 121)
    radii = radius_px + np.arange(-20.0, 12.01, 0.5)
    columns = (centre[0] + np.cos(turns)[:, None] * radii).astype(np.float32)
    rows = (centre[1] + np.sin(turns)[:, None] * radii).astype(np.float32)
    light = cv2.remap(gradient2, columns, rows, cv2.INTER_LINEAR)
    light = np.where(light > 0.1 * light.max(), light, 0)
    mean = (light * radii).sum(axis=1) / light.sum(axis=1)
    return angle, centre, float(mean.mean())


def by_opencv(image, known):
    segments = cv2.createLineSegmentDetector().detect(grey8(image))[0]
    edges, lengths = corner(segments, known["angle_deg"])
    gradient2 = gradients(image)
    gradient2[gradient2 < 0.01 * gradient2.max()] = 0
    away = BEYOND_NOSE * known["nominal_radius_px"]
    lines = [total_least_squares(gradient2, e, n, away) for e, n in zip(edges, lengths)]
    return nose_of(lines, gradient2, known["nominal_radius_px"])


def by_ipol(image, known):
    edges, _ = corner(ipol_lsd(grey8(image)), known["angle_deg"])
    return nose_of(edges, gradients(image), known["nominal_radius_px"])


def ours(binary, mode, folder, known, um_per_px, repeats):
    """A function of an image's path that gives the result and its own times."""

    def measure(path):
        first, second = known["edge_normals_deg"]
        turned = first + 0.5 * ((second - first) % 360.0) - 237.0
        text = TOOL.format(
            radius_mm=1e-3 * um_per_px * known["nominal_radius_px"],
            epsilon_deg=known["angle_deg"],
            plus_x_deg=(90.0 + turned) % 360.0,
            plus_z_deg=turned % 360.0,
        )
        tool = pathlib.Path(folder) / "tool.toml"
        tool.write_text(text)
        call = [binary, "tool", "nose", path, "--um-per-px", repr(um_per_px), "--tool", str(tool), "--mode", mode, "--json"]
        done = subprocess.run([*call, "--bench", str(repeats)], capture_output=True, text=True, env=ONE_THREAD)
        if done.returncode != 0:
            raise ValueError(done.stderr.strip())
        document = json.loads(done.stdout)
        image = document["images"][0]
        return (image["angle_deg"], np.array(image["centre_px"]), image["mean_radius_px"]), document["bench"]

    return measure


class Row:
    def __init__(self, name):
        self.name, self.errors, self.times, self.refused = name, [], [], 0

    def add(self, found, known, ms):
        angle, centre, mean = found
        off = [angle - known["angle_deg"], math.hypot(*(centre - known["centre_px"])), mean - known["mean_radius_px"]]
        self.errors.append([abs(e) for e in off])
        self.times.append(ms)

    def line(self):
        if not self.errors:
            return f"{self.name:44} {self.refused:7}  measured none"
        worst, rms = np.max(self.errors, axis=0), np.sqrt(np.mean(np.square(self.errors), axis=0))
        pairs = "  ".join(f"{w:9.5f} {r:9.5f}" for w, r in zip(worst, rms))
        return f"{self.name:44} {self.refused:7}  {pairs}  {np.median(self.times):9.1f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--binary", required=True)
    parser.add_argument("--noses", type=int, default=10, help="5 or more")
    parser.add_argument("--config", help="a TOML file as of `schema insert`; the camera of the paper by default")
    parser.add_argument("--um-per-px", type=float, default=2.415, help="that of the config")
    parser.add_argument("--repeats", type=int, default=3)
    args = parser.parse_args()
    cv2.setNumThreads(1)
    names = {"ml": "this crate, ml", "paper": "this crate, the paper's way", "opencv": f"OpenCV {cv2.__version__} LSD + TLS"}
    peers = {"opencv": by_opencv}
    if ipol_lsd is not None:
        names["ipol"], peers["ipol"] = "IPOL LSD (pylsd-nova)", by_ipol
    table = {key: Row(name) for key, name in names.items()}
    with tempfile.TemporaryDirectory() as folder:
        out = f"{folder}/noses"
        config = [args.config] if args.config else []
        draw = [args.binary, "study", "nose", *config, "--noses", str(args.noses), "--out", out, "--json"]
        subprocess.run(draw, check=True, capture_output=True)
        truths = json.load(open(f"{out}/truth.json"))
        for number, known in enumerate(truths):
            path = f"{out}/frames/{number:06}.png"
            image = cv2.imread(path, cv2.IMREAD_UNCHANGED)
            for key, row in table.items():
                try:
                    if key in peers:
                        times = []
                        for _ in range(args.repeats):
                            start = time.perf_counter()
                            found = peers[key](image, known)
                            times.append(1e3 * (time.perf_counter() - start))
                        row.add(found, known, float(np.median(times)))
                    else:
                        found, bench = ours(args.binary, key, folder, known, args.um_per_px, args.repeats)(path)
                        row.add(found, known, bench["ms_per_image_median"])
                except ValueError as error:
                    row.refused += 1
                    print(f"{row.name}, nose {number}: {error}", file=sys.stderr)
    columns = "  ".join(f"{name:>19}" for name in ("angle/deg", "centre/px", "mean radius/px"))
    print(f"{len(truths)} noses; errors: largest, rms; one thread, images in memory, median of {args.repeats}")
    print(f"{'method':44} {'refused':>7}  {columns}  {'ms/image':>9}")
    for row in table.values():
        print(row.line())


if __name__ == "__main__":
    main()
