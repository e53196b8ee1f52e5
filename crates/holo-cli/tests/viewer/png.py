"""The pixels of an 8-bit grey or RGB PNG, with the standard library alone."""

import struct
import zlib


class Image:
    def __init__(self, path):
        with open(path, "rb") as file:
            data = file.read()
        assert data[:8] == b"\x89PNG\r\n\x1a\n", path
        at, packed = 8, b""
        while at < len(data):
            length, kind = struct.unpack_from(">I4s", data, at)
            body = data[at + 8 : at + 8 + length]
            if kind == b"IHDR":
                self.width, self.height, bits, colour, _, _, interlaced = struct.unpack(">IIBBBBB", body)
                assert (bits, interlaced) == (8, 0) and colour in (0, 2), path
                self.channels = 3 if colour == 2 else 1
            if kind == b"IDAT":
                packed += body
            at += 12 + length
        self.rows = unfiltered(zlib.decompress(packed), self.width * self.channels, self.height, self.channels)

    def at(self, column, row):
        """[red, green, blue]; grey is all three."""
        start = column * self.channels
        pixel = list(self.rows[row][start : start + self.channels])
        return pixel if self.channels == 3 else pixel * 3


def unfiltered(data, stride, height, step):
    rows, above = [], bytearray(stride)
    for number in range(height):
        kind = data[number * (stride + 1)]
        row = bytearray(data[number * (stride + 1) + 1 : (number + 1) * (stride + 1)])
        if kind == 2:
            row = bytearray((a + b) & 255 for a, b in zip(row, above))
        elif kind:
            for index in range(stride):
                left = row[index - step] if index >= step else 0
                corner = above[index - step] if index >= step else 0
                guess = (left, 0, (left + above[index]) // 2, paeth(left, above[index], corner))[kind - 1]
                row[index] = (row[index] + guess) & 255
        rows.append(row)
        above = row
    return rows


def paeth(left, above, corner):
    target = left + above - corner
    return min((abs(target - left), 0, left), (abs(target - above), 1, above), (abs(target - corner), 2, corner))[2]
