"""Rows of the simulator source: a million windows measured one after another, and frames that are left out and counted."""
import json
import os
import subprocess
import threading
import time

from head import Receiver, cpu_s, resident_mib

# A shaft of 50 pixels in windows of 64 columns and 96 rows.
CONFIG = """name = "a million windows"
seed = 3

[part]
length_mm = 60.0
stock_diameter_mm = 2.0
nominal_diameter_mm = [1.5]
aim_mm = 0.0

[scan]
fields = {fields}
angles = {angles}

[camera]
columns = 64
rows = 96
frame_period_ms = {period_ms}

[optics]
magnification = 0.115
"""


def config(bench, frames, period_ms):
    path = os.path.join(bench.folder, f"windows_{frames}.toml")
    with open(path, "w", encoding="utf-8") as file:
        # a scan has 100 000 angles at most
        fields = -(-frames // 50_000)
        file.write(CONFIG.format(fields=fields, angles=frames // fields, period_ms=period_ms))
    return path


def blocked(bench, frames):
    """`measure sim:`: every frame in order; resident memory over the run."""
    command = [bench.binary, "measure", f"sim:{config(bench, frames, 0.5)}", "--um-per-px", "30", "--json"]
    begun = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    memory = []
    done = threading.Event()

    def look():
        while not done.wait(0.2):
            memory.append((time.monotonic() - begun, resident_mib(process.pid), cpu_s(process.pid)))

    threading.Thread(target=look, daemon=True).start()
    count = valid = 0
    last, in_order = -1, True
    for line in process.stdout:
        if line.startswith('{"frame') or '"sequence"' in line:
            frame = json.loads(line)
            count += 1
            valid += frame["valid"] > 0
            in_order &= int(frame["frame"]) == last + 1
            last = int(frame["frame"])
    words = process.stderr.read()
    process.wait()
    done.set()
    if process.returncode != 0:
        raise RuntimeError(words[-400:])
    settled = [mib for at, mib, _ in memory if at > 0.1 * memory[-1][0] and mib > 0]
    bench.row(
        f"{frames} frames of 64 x 96 through the simulator source, every one measured (block)",
        f"{count} came, {valid} with edges, {'in order' if in_order else 'NOT IN ORDER'}; resident {settled[0]:.1f} MiB at a tenth, "
        f"{max(settled):.1f} at most, {settled[-1]:.1f} at the end; {time.monotonic() - begun:.0f} s",
    )


def dropped(bench, seconds):
    """`watch sim:` at a rate that the gauge cannot keep up with: what is left out is counted."""
    receiver = Receiver(bench.binary, "watch", f"sim:{config(bench, 1000, 0.02)}", "--um-per-px", "30", "--json")
    receiver.first_frame()
    time.sleep(seconds)
    end = receiver.end()
    frames = receiver.frames()
    left_out = sum(frame["dropped"] for frame in frames)
    numbers = [frame["sequence"] for frame in frames]
    accounted = sum(end[key] for key in ("delivered", "dropped", "incomplete", "lost", "waiting"))
    gaps = numbers[-1] + 1 - len(numbers)
    bench.row(
        f"simulator source faster than the gauge, {seconds} s (drop oldest)",
        f"{accounted} frames: {end['delivered']} delivered, {end['dropped']} left out, {end['lost']} lost; "
        f"up to the last one measured {gaps} numbers are missing and {left_out} stated as left out",
    )
