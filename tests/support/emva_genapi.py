"""EMVA's own GenApi (PyPI genicam) on a published head: argument 1 is its address. Prints OK and what it read."""
import socket
import struct
import sys

import genicam.genapi as genapi


class Head:
    """Read and write memory, as GVCP lays them out."""

    def __init__(self, address):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.settimeout(5)
        self.socket.connect((address, 3956))
        self.number = 0

    def command(self, code, payload):
        self.number += 1
        self.socket.send(struct.pack(">BBHHH", 0x42, 1, code, len(payload), self.number) + payload)
        answer = self.socket.recv(2048)
        if answer[:2] != b"\0\0":
            raise RuntimeError(f"status {answer[:2].hex()} of command {code:#x} {payload.hex()}")
        return answer[8:]

    def read(self, address, length):
        data = b""
        while length > 0:
            piece = min(length, 512)
            data += self.command(0x84, struct.pack(">II", address, -(-piece // 4) * 4))[4 : 4 + piece]
            address, length = address + piece, length - piece
        return data


class Port(genapi.AbstractPort):
    def __init__(self, head):
        super().__init__()
        self.head = head

    def read(self, address, length):
        return self.head.read(address, length)

    def write(self, address, value):
        self.head.command(0x86, struct.pack(">I", address) + bytes(value))

    def get_access_mode(self):
        return genapi.EAccessMode.RW

    def is_open(self):
        return True


def frame(nodes, here):
    """The payload of the next frame of a stream with ids of 64 bits."""
    payload = b""
    while True:
        packet = here.recv(65536)
        if packet[4] & 0x7F == 3:
            payload += packet[20:]
        if packet[4] & 0x7F == 2:
            return payload


def main():
    head = Head(sys.argv[1])
    head.command(0x82, struct.pack(">II", 0x0A00, 2))
    _, address, length = head.read(0x0200, 512).split(b"\0")[0].decode().split(";")
    xml = head.read(int(address, 16), int(length, 16)).decode()
    nodes = genapi.NodeMap()
    nodes.load_xml_from_string(xml)
    port = Port(head)
    nodes.connect(port, "Device")
    names = [part.split("<")[0] for part in xml.split("<pFeature>")[1:]]
    readable = [n for n in names if nodes.get_node(n).node.get_access_mode() in (genapi.EAccessMode.RO, genapi.EAccessMode.RW)]
    for name in readable:
        getattr(nodes.get_node(name), "to_string", lambda: "")()
    nodes.Width.value = nodes.Width.max - 4
    assert nodes.OffsetX.max == 4, nodes.OffsetX.max
    nodes.OffsetX.value = 4
    nodes.CarriageZ.value = 17.5
    nodes.EncoderSelector.value = "Encoder1"
    assert nodes.EncoderValue.value == 17.5
    nodes.PixelFormat.value = "Mono12"
    before = nodes.PayloadSize.value
    nodes.PixelFormat.value = "Mono8"
    assert nodes.PayloadSize.value * 2 == before, (before, nodes.PayloadSize.value)
    nodes.TimestampLatch.execute()
    assert nodes.TimestampLatchValue.value > 0
    here = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    here.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4 << 20)
    here.bind(("127.0.0.1", 0))
    here.settimeout(20)
    nodes.GevSCDA.value = 0x7F000001
    nodes.GevSCPHostPort.value = here.getsockname()[1]
    nodes.GevSCPSPacketSize.value = 9000
    nodes.ChunkModeActive.value = True
    nodes.TriggerMode.value = "On"
    nodes.SpindleAngle.value = 33.5
    nodes.AcquisitionStart.execute()
    nodes.TriggerSoftware.execute()
    payload = frame(nodes, here)
    assert len(payload) == nodes.PayloadSize.value, (len(payload), nodes.PayloadSize.value)
    adapter = genapi.ChunkAdapterGEV(nodes)
    adapter.attach_buffer(payload, len(payload))
    assert (nodes.ChunkSpindleAngle.value, nodes.ChunkCarriageZ.value) == (33.5, 17.5)
    read = {}
    for encoder in ("Encoder0", "Encoder1"):
        nodes.ChunkEncoderSelector.value = encoder
        read[encoder] = nodes.ChunkEncoderValue.value
    assert read == {"Encoder0": 33.5, "Encoder1": 17.5}, read
    assert nodes.ChunkFrameID.value == 1
    print(f"OK {len(names)} features, {len(readable)} readable")


main()
