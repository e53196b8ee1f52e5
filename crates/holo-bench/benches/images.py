"""One row of the benchmark `images`: `images.py FOLDER ENTRY ROUNDS ROWS COLUMNS`; prints seconds, bytes, memory."""

import os
import sys
import time

import numpy

folder, entry, rounds, rows, columns = sys.argv[1], sys.argv[2], *map(int, sys.argv[3:])


def samples():
    return numpy.fromfile(os.path.join(folder, "image.raw"), "<u2").reshape(rows, columns, 3)


def status(name):
    for line in open("/proc/self/status"):
        if line.startswith(name):
            return int(line.split()[1]) * 1024


def prepare():
    """Returns the function to time and the file that it writes or reads."""
    if entry == "cv2":
        import cv2

        path = os.path.join(folder, "cv2.png")
        image = numpy.ascontiguousarray((samples() >> 8).astype(numpy.uint8)[:, :, ::-1])
        return lambda: cv2.imwrite(path, image), path
    if entry == "pillow":
        from PIL import Image

        path = os.path.join(folder, "pillow.png")
        image = Image.fromarray((samples() >> 8).astype(numpy.uint8))
        return lambda: image.save(path), path
    import OpenEXR

    if entry == "openexr-read":
        path = os.path.join(folder, "holo.exr")
        if not os.path.exists(path):
            path = os.path.join(folder, "openexr.exr")

        def read():
            with OpenEXR.File(path, separate_channels=True) as file:
                return file.channels()["R"].pixels[0, 0]

        return read, path
    path = os.path.join(folder, "openexr.exr")
    linear = samples().astype(numpy.float32) / numpy.float32(65535)
    half = (linear * linear).astype(numpy.float16)
    channels = {name: numpy.ascontiguousarray(half[:, :, i]) for i, name in enumerate("RGB")}
    del linear, half
    codec = OpenEXR.PIZ_COMPRESSION if entry.endswith("piz") else OpenEXR.ZIP_COMPRESSION
    header = {"compression": codec, "type": OpenEXR.scanlineimage}
    return lambda: OpenEXR.File(header, channels).write(path), path


work, path = prepare()
try:
    with open("/proc/self/clear_refs", "w") as file:
        file.write("5")
except OSError:
    pass
before = status("VmRSS:")
best = float("inf")
for _ in range(rounds):
    start = time.perf_counter()
    work()
    best = min(best, time.perf_counter() - start)
print(best, os.path.getsize(path), status("VmHWM:") - before)
