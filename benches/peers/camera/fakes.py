"""Fake cameras that are not ours, as sources of this program: that of PyPI viva-genicam, and Aravis'."""
import json
import os
import subprocess
import sys
import time

from head import Receiver

# What is grey in the XML of the fake (0.10.0).
FORMATS = ("Mono8", "Mono16")

# The fake runs in a process of its own.
FAKE = """
import sys
from viva_genicam.testing import FakeGigeCamera
address, pixel_format, resend, drops = sys.argv[1:]
drops = [tuple(map(int, pair.split(":"))) for pair in drops.split(",") if pair]
fake = FakeGigeCamera(width=320, height=240, fps=50, bind_ip=address, pixel_format=pixel_format, packet_resend=resend == "1", drop_packets=drops or None)
fake.start()
print("ready", flush=True)
sys.stdin.read()
"""


class Fake:
    """A fake camera of viva-genicam."""

    def __init__(self, python, address, pixel_format="Mono8", resend=True, drops=""):
        self.address = address
        command = [python, "-c", FAKE, address, pixel_format, str(int(resend)), drops]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        if self.process.stdout.readline().strip() != "ready":
            raise RuntimeError(self.process.stderr.read()[-300:])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()


def seen(bench, fake, seconds):
    """Counts of a watch, its frames' sequence numbers, and reasons of gaps and of invalid readings."""
    receiver = Receiver(bench.binary, "watch", f"gige:{fake.address}", "--json")
    receiver.first_frame()
    time.sleep(seconds)
    end = receiver.end()
    reasons = sorted({str(line.get("why"))[:90] for _, line in receiver.lines if line.get("event") in ("gap", "invalid")})
    numbers = [frame["sequence"] for frame in receiver.frames()]
    rises = all(a < b for a, b in zip(numbers, numbers[1:]))
    return end, rises, {frame["columns"] for frame in receiver.frames()}, reasons


def viva(bench):
    python = os.environ.get("GENICAM_PYTHON", sys.executable)
    probe = subprocess.run([python, "-c", "import viva_genicam.testing"], capture_output=True, check=False)
    if probe.returncode != 0:
        return bench.skip("fake camera of viva-genicam", f"{python} has no PyPI viva-genicam (GENICAM_PYTHON names one that has)")
    host = iter(f"127.61.0.{number}" for number in range(1, 200))
    for pixel_format in FORMATS:
        with Fake(python, next(host), pixel_format) as fake:
            end, rises, columns, reasons = seen(bench, fake, 2)
        bench.row(f"viva's fake, {pixel_format}", told(end, rises, columns, reasons))
    drops = ",".join(f"{block}:{packet}" for block in range(5, 80, 7) for packet in (1, 2))
    with Fake(python, next(host), drops=drops) as fake:
        # the fake never sends them, also when they are asked for
        end, rises, columns, reasons = seen(bench, fake, 3)
    bench.row("viva's fake, 22 packets of 11 frames never sent", told(end, rises, columns, reasons))
    with Fake(python, next(host), "Mono12") as fake:
        done = subprocess.run([bench.binary, "measure", f"gige:{fake.address}"], capture_output=True, text=True, check=False)
    words = " ".join(done.stderr.replace("│", " ").split())
    return bench.row("viva's fake, Mono12 (not in its XML)", f"exit {done.returncode}: {words[:110]}")


def told(end, rises, columns, reasons):
    keys = ("delivered", "dropped", "incomplete", "lost", "repeated", "disappeared")
    numbers = ", ".join(f"{end.get(key)} {key}" for key in keys)
    return f"{numbers}; numbers {'rise' if rises else 'DO NOT RISE'}; {columns} columns; {json.dumps(reasons, ensure_ascii=False)}"
