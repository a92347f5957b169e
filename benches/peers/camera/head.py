"""A published head as a process, and a small GVCP client that sets its features by its own XML."""
import os
import signal
import socket
import struct
import subprocess
import threading
import time
import xml.etree.ElementTree as tree

PORT = 3956
SCHEMA = "{http://www.genicam.org/GenApi/Version_1_1}"


def cpu_s(process_id):
    """CPU time that a process has used, s; 0 for one that is gone."""
    try:
        with open(f"/proc/{process_id}/stat", encoding="ascii") as file:
            fields = file.read().rsplit(")", 1)[1].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def resident_mib(process_id):
    """Resident memory of a process, MiB; 0 for one that is gone."""
    try:
        with open(f"/proc/{process_id}/statm", encoding="ascii") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20
    except OSError:
        return 0.0


class Client:
    """Reads and writes features of one camera."""

    def __init__(self, address):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.settimeout(2)
        self.socket.connect((address, PORT))
        self.number = 0
        self.nodes = None

    def command(self, code, payload):
        self.number = self.number % 0xFFFF + 1
        for _ in range(3):
            self.socket.send(struct.pack(">BBHHH", 0x42, 1, code, len(payload), self.number) + payload)
            try:
                answer = self.socket.recv(2048)
            except TimeoutError:
                continue
            if answer[:2] != b"\0\0":
                raise RuntimeError(f"status {answer[:2].hex()} of command {code:#x} {payload.hex()}")
            return answer[8:]
        raise TimeoutError(f"no answer to command {code:#x}")

    def read(self, address, length):
        data = b""
        while len(data) < length:
            piece = min(length - len(data), 512)
            data += self.command(0x84, struct.pack(">II", address + len(data), -(-piece // 4) * 4))[4 : 4 + piece]
        return data

    def control(self, privilege):
        """2 takes control, 0 gives it up."""
        self.command(0x82, struct.pack(">II", 0x0A00, privilege))

    def all(self):
        """Every node of the XML by its name."""
        if self.nodes is None:
            _, address, length = self.read(0x0200, 512).split(b"\0")[0].decode().split(";")
            xml = self.read(int(address, 16), int(length, 16)).decode()
            self.nodes = {node.get("Name"): node for node in tree.fromstring(xml)}
        return self.nodes

    def node(self, name):
        return self.all()[name]

    def register(self, name):
        """Address, bytes and whether it is a float."""
        register = self.all()[self.node(name).findtext(f"{SCHEMA}pValue")]
        length = int(register.findtext(f"{SCHEMA}Length"))
        return int(register.findtext(f"{SCHEMA}Address"), 16), length, register.tag.endswith("FloatReg")

    def set(self, name, value):
        entries = {e.get("Name"): int(e.findtext(f"{SCHEMA}Value")) for e in self.node(name).iter(f"{SCHEMA}EnumEntry")}
        value = entries.get(value, value)
        address, length, is_float = self.register(name)
        if is_float:
            self.command(0x86, struct.pack(">Id", address, value))
        elif length == 8:
            self.command(0x86, struct.pack(">IQ", address, int(value)))
        else:
            self.command(0x82, struct.pack(">II", address, int(value)))

    def get(self, name):
        address, length, is_float = self.register(name)
        data = self.read(address, length)
        return struct.unpack(">d" if is_float else ">Q" if length == 8 else ">I", data)[0]


class Head:
    """`shadowgauge publish` on an address of the loopback interface."""

    addresses = iter(f"127.60.{high}.{low}" for high in range(1, 255) for low in range(1, 255))

    def __init__(self, binary, config, address=None):
        self.binary, self.config = binary, config
        self.address = address or next(self.addresses)
        self.process = None
        self.start()

    def start(self):
        command = [self.binary, "publish", self.config, "--listen", self.address, "--backend", "cpu"]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        for line in self.process.stdout:
            if line.startswith("Ctrl-C"):
                return time.monotonic()
        raise RuntimeError("the head does not start")

    def set(self, **features):
        """Sets features as a client that then gives control up."""
        client = Client(self.address)
        client.control(2)
        for name, value in features.items():
            client.set(name, value)
        client.control(0)

    def get(self, name):
        return Client(self.address).get(name)

    def kill(self):
        self.process.kill()
        self.process.wait()
        return time.monotonic()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGCONT)
            self.process.send_signal(signal.SIGINT)
            try:
                self.process.wait(5)
            except subprocess.TimeoutExpired:
                self.process.kill()


class Receiver:
    """A command of the program whose lines of JSON are kept with the time at which they came."""

    def __init__(self, binary, *arguments):
        import json

        self.lines = []
        self.words = []
        self.process = subprocess.Popen(
            [binary, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**os.environ, "NO_COLOR": "1"}
        )

        def take():
            for line in self.process.stdout:
                self.lines.append((time.monotonic(), json.loads(line)))

        def hear():
            for line in self.process.stderr:
                self.words.append((time.monotonic(), line))

        self.threads = [threading.Thread(target=take, daemon=True), threading.Thread(target=hear, daemon=True)]
        for thread in self.threads:
            thread.start()

    def wait_for(self, is_it, since=0.0, within_s=30.0):
        """The first line from a time on that is it, with its time."""
        until = time.monotonic() + within_s
        seen = 0
        while time.monotonic() < until:
            for at, line in self.lines[seen:]:
                seen += 1
                if at >= since and is_it(line):
                    return at, line
            if self.process.poll() is not None and seen == len(self.lines):
                break
            time.sleep(0.002)
        raise TimeoutError("no such line; " + "".join(line for _, line in self.words)[-600:])

    def first_frame(self, since=0.0, within_s=30.0):
        return self.wait_for(lambda line: "event" not in line, since, within_s)

    def used_s(self):
        return cpu_s(self.process.pid)

    def end(self):
        """Ctrl-C; the line of the counts."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        self.process.wait(30)
        for thread in self.threads:
            thread.join(10)
        ends = [line for _, line in self.lines if line.get("event") == "end"]
        return ends[-1] if ends else {}

    def frames(self):
        return [line for _, line in self.lines if "event" not in line]
