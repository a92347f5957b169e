"""Rows of what goes wrong on a wire: a camera that is killed, silent, restarted, changed; a second client."""
import os
import signal
import subprocess
import time

from head import Head, Receiver
from streams import SCALE, counts


def watch(bench, head):
    receiver = Receiver(bench.binary, "watch", f"gige:{head.address}", "--json", *SCALE)
    receiver.first_frame()
    time.sleep(1)
    return receiver


def is_invalid(line):
    return line.get("event") == "invalid"


def ordered(receiver):
    numbers = [frame["sequence"] for frame in receiver.frames()]
    return "numbers rise" if all(a < b for a, b in zip(numbers, numbers[1:])) else "NUMBERS DO NOT RISE"


def killed(bench, times):
    """From the kill to the word of it, and from the return to the next diameter."""
    said, back = [], []
    with Head(bench.binary, bench.small) as head:
        head.set(AcquisitionFrameRate=30)
        receiver = watch(bench, head)
        for _ in range(times):
            at = head.kill()
            said.append(receiver.wait_for(is_invalid, at)[0] - at)
            time.sleep(1)
            begun = head.start()
            back.append(receiver.first_frame(begun)[0] - begun)
            time.sleep(1)
        end = receiver.end()
    bench.row(
        f"camera killed and published again, {times} times",
        f"said after {most(said)}, measured again after {most(back)}; disappeared {end['disappeared']}, {ordered(receiver)}",
    )


def most(times_s):
    return f"{min(times_s):.2f} to {max(times_s):.2f} s"


def silent(bench, seconds):
    """A camera that stands still as a whole (SIGSTOP), as with its cable pulled, and goes on."""
    with Head(bench.binary, bench.small) as head:
        head.set(AcquisitionFrameRate=30)
        receiver = watch(bench, head)
        head.process.send_signal(signal.SIGSTOP)
        at = time.monotonic()
        said = receiver.wait_for(is_invalid, at)[0] - at
        time.sleep(seconds - (time.monotonic() - at))
        head.process.send_signal(signal.SIGCONT)
        at = time.monotonic()
        back = receiver.first_frame(at)[0] - at
        time.sleep(1)
        end = receiver.end()
    bench.row(f"camera silent for {seconds} s", f"said after {said:.2f} s, measured again {back:.2f} s after its return; disappeared {end['disappeared']}, {ordered(receiver)}")


def second_client(bench):
    """The second one is refused; the first one loses nothing."""
    with Head(bench.binary, bench.small) as head:
        head.set(AcquisitionFrameRate=50)
        receiver = watch(bench, head)
        codes = []
        for _ in range(3):
            done = subprocess.run([bench.binary, "measure", f"gige:{head.address}"], capture_output=True, text=True, timeout=30, check=False)
            codes.append((done.returncode, "busy" in done.stderr))
            time.sleep(0.5)
        end = receiver.end()
    bench.row("second client, three times", f"exit code and \"busy\": {codes}; the first: {counts(end)}")


def changed(bench):
    """Another size from frame to frame, and another size or format after a return."""
    with Head(bench.binary, bench.small) as head:
        head.set(AcquisitionFrameRate=30, FaultWrongSize=5)
        receiver = watch(bench, head)
        time.sleep(3)
        end = receiver.end()
        sizes = {frame["columns"] for frame in receiver.frames()}
    bench.row("every fifth frame of another size", f"{counts(end)}; columns measured: {sizes}")
    with open(bench.small, encoding="utf-8") as file:
        text = file.read()
    variants = {"size": text.replace("rows = 512", "rows = 448"), "format": text + '\n[sensor]\nformat = "mono16"\n'}
    for name, variant in variants.items():
        assert variant != text
        other = os.path.join(bench.folder, f"other_{name}.toml")
        with open(other, "w", encoding="utf-8") as file:
            file.write(variant)
        with Head(bench.binary, bench.small) as head:
            head.set(AcquisitionFrameRate=30)
            receiver = watch(bench, head)
            head.kill()
            time.sleep(0.5)
            head.config = other
            begun = head.start()
            receiver.process.wait(20)
            took = time.monotonic() - begun
            receiver.end()
            words = " ".join("".join(line for _, line in receiver.words).split())
        said = words[words.find("it came back") :][:160] if "it came back" in words else words[-160:]
        bench.row(f"{name} changed while the camera was away", f"exit {receiver.process.returncode} after {took:.2f} s: {said}")
