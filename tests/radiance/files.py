"""The file formats of this folder, each as little of it as is used here: .glb, PNG (writing), .hdr, PFM. Needs numpy."""
import json
import struct
import zlib

import numpy as np

COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
NUMBERS = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}


class GlbWriter:
    """Gathers the parts of a .glb: one buffer, one view an accessor or image."""

    def __init__(self):
        self.document = {"asset": {"version": "2.0", "generator": "holo tests/radiance/make_scenes.py"}}
        self.buffer = bytearray()

    def append(self, kind, entry):
        """Appends to a top-level list; returns the index."""
        entries = self.document.setdefault(kind, [])
        entries.append(entry)
        return len(entries) - 1

    def view(self, data):
        """Appends bytes, aligned to four; returns the index of the view."""
        self.buffer += b"\0" * (-len(self.buffer) % 4)
        view = self.append("bufferViews", {"buffer": 0, "byteOffset": len(self.buffer), "byteLength": len(data)})
        self.buffer += data
        return view

    def accessor(self, values):
        """Appends an array of float32 rows or of indices; returns the index."""
        values = np.ascontiguousarray(values)
        if values.dtype.kind == "f":
            values, component = values.astype(np.float32), 5126
        else:
            values, component = values.astype(np.uint16), 5123
        kind = "SCALAR" if values.ndim == 1 else f"VEC{values.shape[1]}"
        entry = {"bufferView": self.view(values.tobytes()), "componentType": component, "count": len(values), "type": kind}
        if kind == "VEC3":
            entry |= {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
        return self.append("accessors", entry)

    def write(self, path):
        self.buffer += b"\0" * (-len(self.buffer) % 4)
        self.document["buffers"] = [{"byteLength": len(self.buffer)}]
        text = json.dumps(self.document, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text
        chunks += struct.pack("<I4s", len(self.buffer), b"BIN\0") + bytes(self.buffer)
        with open(path, "wb") as file:
            file.write(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


class Glb:
    """A .glb as `GlbWriter` writes it."""

    def __init__(self, path):
        with open(path, "rb") as file:
            raw = file.read()
        size = struct.unpack_from("<I", raw, 12)[0]
        self.document = json.loads(raw[20 : 20 + size])
        self.buffer = raw[28 + size :]

    def view(self, index):
        view = self.document["bufferViews"][index]
        return self.buffer[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]

    def accessor(self, index):
        entry = self.document["accessors"][index]
        values = np.frombuffer(self.view(entry["bufferView"]), NUMBERS[entry["componentType"]])
        return values.reshape(entry["count"], COMPONENTS[entry["type"]])


def rotation(quaternion):
    """Matrix of a unit quaternion x, y, z, w."""
    x, y, z, w = quaternion
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])


def png(pixels):
    """An 8-bit RGB image, axes (row, column, channel), as the bytes of a PNG."""
    height, width, _ = pixels.shape
    rows = np.concatenate([np.zeros((height, 1), np.uint8), pixels.reshape(height, -1)], axis=1)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows.tobytes(), 9)) + chunk(b"IEND", b"")


def rgbe(radiance):
    """The four bytes of every pixel: mantissas rounded, exponent shared and biased by 136."""
    brightest = radiance.max(axis=-1)
    _, exponent = np.frexp(brightest)
    mantissa = np.rint(np.ldexp(radiance, 8 - exponent[..., None]))
    # 255.5 and more rounds up to 256: the next exponent.
    over = mantissa.max(axis=-1) > 255
    exponent = exponent + over
    mantissa = np.rint(np.ldexp(radiance, 8 - exponent[..., None]))
    return np.concatenate([mantissa, exponent[..., None] + 128], axis=-1).astype(np.uint8)


def write_hdr(path, radiance):
    """Writes Radiance RGBE, run-length coded, rows from the top."""
    height, width, _ = radiance.shape
    out = bytearray(f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode())
    for row in rgbe(radiance):
        out += struct.pack(">BBH", 2, 2, width)
        for channel in row.T:
            out += run_length(bytes(channel))
    with open(path, "wb") as file:
        file.write(out)


def run_length(values):
    """Runs of 4 to 127 equal bytes as (128 + count, byte), anything else as (count, bytes)."""
    out, literal, k = bytearray(), bytearray(), 0

    def flush():
        for start in range(0, len(literal), 128):
            part = literal[start : start + 128]
            out.append(len(part))
            out.extend(part)
        literal.clear()

    while k < len(values):
        count = 1
        while k + count < len(values) and count < 127 and values[k + count] == values[k]:
            count += 1
        if count >= 4:
            flush()
            out += bytes([128 + count, values[k]])
        else:
            literal += values[k : k + count]
        k += count
    flush()
    return out


def read_hdr(path):
    """Reads what `write_hdr` wrote: float32, axes (row, column, channel). A value is mantissa * 2^(exponent - 136)."""
    with open(path, "rb") as file:
        raw = file.read()
    header, rest = raw.split(b"\n\n", 1)
    assert b"32-bit_rle_rgbe" in header
    size, data = rest.split(b"\n", 1)
    _, height, _, width = size.split()
    height, width, k = int(height), int(width), 0
    out = np.zeros((height, 4, width), np.uint8)
    for row in range(height):
        k += 4
        for channel in range(4):
            column = 0
            while column < width:
                count = data[k]
                if count > 128:
                    count -= 128
                    out[row, channel, column : column + count] = data[k + 1]
                    k += 2
                else:
                    out[row, channel, column : column + count] = np.frombuffer(data, np.uint8, count, k + 1)
                    k += 1 + count
                column += count
    out = out.transpose(0, 2, 1)
    return np.ldexp(out[..., :3].astype(np.float32), out[..., 3:].astype(np.int32) - 136).astype(np.float32)


def write_pfm(path, image):
    """Writes float32 RGB, axes (row, column, channel), little-endian, bottom row first."""
    height, width, _ = image.shape
    with open(path, "wb") as file:
        file.write(f"PF\n{width} {height}\n-1\n".encode() + image[::-1].astype("<f4").tobytes())


def read_pfm(path):
    """Reads what `write_pfm` wrote."""
    with open(path, "rb") as file:
        kind, size, scale, data = file.read().split(b"\n", 3)
    assert kind == b"PF" and float(scale) < 0
    width, height = map(int, size.split())
    return np.frombuffer(data, "<f4").reshape(height, width, 3)[::-1]
