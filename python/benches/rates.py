"""How fast a 2048 x 2048 frame gets from NumPy to diameters, beside the program's own stream on the
same frame; import time; size of the installed library.

    python rates.py CONFIG.toml [FRAMES]          configs/bench_2048.toml of the project
"""

import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import shadowgauge as sg
from shadowgauge import _shadowgauge

#: Times that both streams are measured.
ROUNDS = 3


def program(*words: object) -> str:
    """Stdout of the program."""
    line = [sys.executable, "-m", "shadowgauge", *map(str, words)]
    return subprocess.run(line, check=True, capture_output=True, text=True).stdout


def python_ms(frame: sg.Frame, um_per_px: float, count: int) -> float:
    """Median of a frame in a stream, warm, ms."""
    stream = sg.Stream(sg.Gauge(), sg.Calibration.from_scale(um_per_px), keep_rows=False)
    times = []
    for number in range(count + 5):
        begun = time.perf_counter()
        stream.push(frame.pixels, bits=frame.bits, frame_id=number)
        times.append(1e3 * (time.perf_counter() - begun))
    return statistics.median(times[5:])


def main(config: str, count: str = "200") -> None:
    """Prints the figures, one a line."""
    with tempfile.TemporaryDirectory() as folder:
        program("render", config, "--out", f"{folder}/drawn", "--frames", 1)
        image = next(Path(folder).glob("drawn/frames/*.png"))
        frame = sg.read_image(image)
        scale = 17.4
        words = ["measure", image, "--um-per-px", scale, "--ignore-file-scale", "--bench", count, "--threads", 1, "--json"]
        # In turn, so that both meet the same load of the machine; the least of the medians is the least disturbed.
        rust_ms, own_ms = float("inf"), float("inf")
        for _ in range(ROUNDS):
            bench = json.loads(program(*words))["bench"]
            # The program times edges alone; a stream in Python gives all results, which take so many times as long.
            rust_ms = min(rust_ms, bench["ms_per_frame_median"] * bench["results_over_edges"])
            own_ms = min(own_ms, python_ms(frame, scale, int(count)))
    print(f"Rust stream    {rust_ms:.4f} ms a frame")
    print(f"Python stream  {own_ms:.4f} ms a frame, {own_ms / rust_ms:.3f} times as long")
    code = "import numpy, time; t = time.perf_counter(); import shadowgauge; print(time.perf_counter() - t)"
    took = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout
    print(f"import         {1e3 * float(took):.0f} ms after NumPy's")
    print(f"library        {Path(_shadowgauge.__file__).stat().st_size / 2**20:.1f} MiB")


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
