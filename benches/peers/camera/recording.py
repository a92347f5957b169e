"""Checksums of the images of a recording: uncompressed MCAP (https://mcap.dev/spec) with foxglove.RawImage in protobuf."""
import mmap
import struct
import zlib


def varint(data, at):
    value = shift = 0
    while True:
        byte = data[at]
        value |= (byte & 0x7F) << shift
        at, shift = at + 1, shift + 7
        if byte < 0x80:
            return value, at


def pixels(message):
    """Field 6 of foxglove.RawImage: the pixels."""
    at = 0
    while at < len(message):
        key, at = varint(message, at)
        field, kind = key >> 3, key & 7
        if kind == 2:
            length, at = varint(message, at)
            if field == 6:
                return message[at : at + length]
            at += length
        elif kind == 0:
            _, at = varint(message, at)
        else:
            at += 4 if kind == 5 else 8
    return None


def records(data, at, end):
    """Opcode and content of the records between two places."""
    while at + 9 <= end:
        opcode, length = struct.unpack_from("<BQ", data, at)
        yield opcode, at + 9, at + 9 + length
        at += 9 + length


def checksums(path):
    """CRC-32 of the pixels of every frame, by its sequence number."""
    sums, images = {}, None
    with open(path, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        for opcode, at, end in records(data, 8, len(data) - 8):
            if opcode != 6:
                continue
            # times, size and checksum of the uncompressed records, name of the compression, length of the records
            (name,) = struct.unpack_from("<I", data, at + 28)
            for inner, begin, stop in records(data, at + 40 + name, end):
                if inner == 4:
                    channel, _, length = struct.unpack_from("<HHI", data, begin)
                    if data[begin + 8 : begin + 8 + length].endswith(b"image"):
                        images = channel
                if inner == 5:
                    channel, sequence = struct.unpack_from("<HI", data, begin)
                    if channel == images:
                        sums[sequence] = zlib.crc32(pixels(memoryview(data)[begin + 22 : stop]))
    return sums
