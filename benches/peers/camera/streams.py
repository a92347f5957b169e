"""Rows of streams: frames published, received by this program, by telegenic and by Aravis, recorded and measured."""
import json
import os
import re
import subprocess
import tempfile
import time

from head import Client, Head, Receiver, cpu_s
from recording import checksums

SCALE = ("--um-per-px", "30")


def watched(bench, head, seconds, *more):
    """Watches a head for a time; counts of the end, CPU share of receiver and head, and the receiver."""
    receiver = Receiver(bench.binary, "watch", f"gige:{head.address}", "--json", *SCALE, *more)
    receiver.first_frame()
    begun, used = time.monotonic(), (receiver.used_s(), cpu_of(head))
    time.sleep(seconds)
    lasted = time.monotonic() - begun
    shares = [100 * (now - before) / lasted for now, before in zip((receiver.used_s(), cpu_of(head)), used)]
    return receiver.end(), shares, receiver


def cpu_of(head):
    return cpu_s(head.process.pid)


def accounted(end):
    return sum(end[key] for key in ("delivered", "dropped", "incomplete", "lost", "waiting"))


def counts(end):
    return (
        f"{accounted(end)} frames, {end['delivered']} taken, {end['measured']} measured, {end['dropped']} left out, "
        f"{end['incomplete']} incomplete, {end['lost']} lost"
    )


def telegenic(bench, head, seconds, *settings):
    """Checksums by block, and telegenic's counters."""
    command = [bench.telegenic, head.address, str(seconds), *settings]
    lines = subprocess.run(command, capture_output=True, text=True, check=True, timeout=seconds + 30).stdout.splitlines()
    sums = {int(block): int(value, 16) for block, value in (line.split() for line in lines[:-1])}
    return sums, json.loads(lines[-1])


def gaps(blocks):
    """Numbers between the first and the last that did not come."""
    return max(blocks) - min(blocks) + 1 - len(blocks) if blocks else 0


def received(bench, name, config, rate, seconds, pixel_format):
    """One stream by three receivers, and the bytes of two of them compared."""
    with Head(bench.binary, config) as head:
        head.set(AcquisitionFrameRate=rate, PixelFormat=pixel_format)
        end, shares, receiver = watched(bench, head, seconds)
        bench.row(f"{name}, {seconds} s, this program", f"{counts(end)}; p99 {end['latency_p99_ms']:.1f} ms; CPU {shares[0]:.0f} %, head {shares[1]:.0f} %")
    if bench.telegenic:
        with Head(bench.binary, config) as head:
            head.set(AcquisitionFrameRate=rate, PixelFormat=pixel_format)
            sums, stats = telegenic(bench, head, seconds)
        bench.row(f"{name}, {seconds} s, telegenic", f"{len(sums)} whole, {gaps(sums)} numbers missing, {stats}")
        bench.row(f"{name}, bytes", compared(bench, config, rate, pixel_format, sums))
    else:
        bench.skip(f"{name}, telegenic", "the crate could not be built")
    aravis(bench, name, config, rate, pixel_format)


def compared(bench, config, rate, pixel_format, theirs):
    """The first frames of a recording by this program beside those of telegenic, by CRC-32."""
    with tempfile.TemporaryDirectory(dir=bench.folder) as folder, Head(bench.binary, config) as head:
        head.set(AcquisitionFrameRate=rate, PixelFormat=pixel_format)
        path = os.path.join(folder, "some.mcap")
        watched(bench, head, 2, "--record", path)
        ours = checksums(path)
    both = [number for number in ours if number + 1 in theirs]
    same = sum(ours[number] == theirs[number + 1] for number in both)
    return f"{same} of {len(both)} frames equal to the bit (recorded {len(ours)})"


def aravis(bench, name, config, rate, pixel_format):
    if bench.missing("arv-camera-test-0.8"):
        return bench.skip(f"{name}, Aravis", "arv-camera-test-0.8 is not installed (scripts/install_camera_peers.sh)")
    with Head(bench.binary, config) as head:
        head.set(AcquisitionFrameRate=rate, PixelFormat=pixel_format)
        command = ["arv-camera-test-0.8", "--no-packet-socket", "-n", head.address, "-i", "60000", "-f", str(rate), "-a", "--duration=10"]
        text = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False).stdout
    found = dict(re.findall(r"(n_\w+)\s*=\s*(\d+)", text))
    keys = ("n_completed_buffers", "n_failures", "n_underruns", "n_missing_packets", "n_resent_packets")
    return bench.row(f"{name}, 10 s, Aravis", ", ".join(f"{key} {found[key]}" for key in keys if key in found) or text[-200:])


def measured(bench, seconds):
    """2048² Mono8 at 50 frames/s: published, received and measured; arrival to diameter."""
    with Head(bench.binary, bench.large) as head:
        head.set(AcquisitionFrameRate=50, PixelFormat="Mono8")
        end, shares, receiver = watched(bench, head, seconds)
    late = sorted(frame["latency_ms"] for frame in receiver.frames())
    p50, p99, most = late[len(late) // 2], late[int(0.99 * len(late))], late[-1]
    bench.row(
        f"2048² Mono8 at 50/s measured, {seconds} s",
        f"{counts(end)}; arrival to diameter {p50:.2f} ms, p99 {p99:.2f} ms, most {most:.1f} ms; CPU {shares[0]:.0f} %, head {shares[1]:.0f} %",
    )


def packet_loss(bench, seconds):
    """.5 % of the packets lost: with resend, and with a head that does not send again."""
    for again in (True, False):
        with Head(bench.binary, bench.large) as head:
            if not again and "FaultResendRefused" not in Client(head.address).all():
                return bench.skip("packet loss without resend", "this program's head has no FaultResendRefused")
        name = f"2048² Mono8 at 20/s, .5 % of packets lost, {'with' if again else 'without'} resend, {seconds} s"
        with Head(bench.binary, bench.large) as head:
            # packets of 8000 bytes: 524 a frame, so that without resend nine frames of ten are hit
            faults = {"FaultPacketLoss": 5, "FaultSeed": 7} | ({} if again else {"FaultResendRefused": 1})
            head.set(AcquisitionFrameRate=20, PixelFormat="Mono8", **faults)
            end, _, receiver = watched(bench, head, seconds)
            resent, sent = head.get("PacketsResent"), head.get("FramesSent")
        partial = sum(line["incomplete"] for _, line in receiver.lines if line.get("event") == "gap")
        bench.row(name, f"{counts(end)} ({partial} of them stated as gaps); head: {sent} frames, {resent} packets sent again")


def recorded(bench, seconds):
    """`watch --record` at 2048², 50 frames/s, of whole frames and of two windows of 64 rows."""
    record(bench, seconds, "watch --record")
    text = subprocess.run([bench.binary, "watch", "--help"], capture_output=True, text=True, check=True).stdout
    if "--windows" not in text:
        return bench.skip("watch --windows --record", "this program has no --windows")
    return record(bench, seconds, "watch --windows --record", "--windows", edges(bench))


def edges(bench):
    """UPPER,LOWER,ROWS about the edges of the still shaft, from one frame: the middle of its field and the diameter."""
    with Head(bench.binary, bench.large) as head:
        head.set(AcquisitionFrameRate=10, PixelFormat="Mono8")
        end, _, receiver = watched(bench, head, 1)
    half, middle, rows = receiver.frames()[0]["max_diameter_px"] / 2, 1024, 64
    return f"{middle - half - rows / 2:.0f},{middle + half - rows / 2:.0f},{rows}"


def record(bench, seconds, name, *more):
    """What recording takes of a core, and whether the replay is the same."""
    with tempfile.TemporaryDirectory(dir=bench.folder) as folder, Head(bench.binary, bench.large) as head:
        head.set(AcquisitionFrameRate=50, PixelFormat="Mono8")
        path = os.path.join(folder, "ten.mcap")
        end, shares, receiver = watched(bench, head, seconds, "--record", path, *more)
        words = "".join(line for _, line in receiver.words)
        left_out = re.search(r"(\d+) frames are not in the recording", words)
        bench.row(
            f"{name}, 2048² Mono8 at 50/s, {seconds} s",
            f"{counts(end)}; not recorded {left_out[1] if left_out else 0}; {os.path.getsize(path) / 2**20 / seconds:.0f} MiB/s; CPU {shares[0]:.0f} %",
        )
        live = {frame["sequence"]: frame for frame in receiver.frames()}
        for threads in ("1", "2"):
            command = [bench.binary, "measure", f"replay:{path}", "--json", *SCALE, "--threads", threads]
            text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
            frames = [line for line in map(json.loads, text.splitlines()) if "frame" in line]
            keys = ("max_diameter_mm", "u_max_mm", "mean_diameter_mm")
            pairs = [(frame, live[int(frame["frame"])]) for frame in frames if int(frame["frame"]) in live]
            same = sum(all(a.get(key) == b.get(key) for key in keys) for a, b in pairs)
            off = max(abs(a[keys[0]] - b[keys[0]]) for a, b in pairs)
            # what a stream has tracked so far follows from every frame: one that was left out live is measured here
            left = f"; largest difference {1e6 * off:.2g} nm, {end['dropped']} frames were left out live" if end["dropped"] else ""
            bench.row(f"its replay, {threads} thread(s)", f"{same} of {len(pairs)} diameters equal to the bit{left}")


def trigger(bench, count):
    """From the software trigger to the last packet of its frame, by a client of its own."""
    import socket
    import struct

    with Head(bench.binary, bench.small) as head:
        client = Client(head.address)
        client.control(2)
        here = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        here.bind(("127.0.0.1", 0))
        here.settimeout(2)
        client.command(0x82, struct.pack(">II", 0x0D18, 0x7F000001))
        client.command(0x82, struct.pack(">II", 0x0D00, here.getsockname()[1]))
        client.command(0x82, struct.pack(">II", 0x0D04, 60000))
        client.set("TriggerMode", "On")
        client.set("AcquisitionStart", 1)
        times = []
        for _ in range(count):
            begun = time.perf_counter()
            client.set("TriggerSoftware", 1)
            while here.recv(65536)[4] & 0x7F != 2:
                pass
            times.append(1e3 * (time.perf_counter() - begun))
            time.sleep(0.005)
    times.sort()
    bench.row(
        f"software trigger to frame, 512² Mono12, {count} triggers",
        f"median {times[count // 2]:.2f} ms, p99 {times[int(0.99 * count)]:.2f} ms, most {times[-1]:.2f} ms",
    )


def clock(bench, openings):
    """Bound of the map from the camera's clock to the host's, as each opening logs it."""
    bounds = []
    with Head(bench.binary, bench.small) as head:
        for _ in range(openings):
            receiver = Receiver(bench.binary, "-v", "watch", f"gige:{head.address}", "--json", *SCALE)
            receiver.first_frame()
            receiver.end()
            words = "".join(line for _, line in receiver.words)
            found = re.search(r"clock mapped within Some\(([\d.]+)\)|clock mapped within ([\d.]+)", words)
            if found:
                bounds.append(float(found[1] or found[2]))
    bounds.sort()
    bench.row(f"clock map, {openings} openings", f"bound least {bounds[0]:.1f} µs, median {bounds[len(bounds) // 2]:.1f} µs, most {bounds[-1]:.1f} µs")
