"""Writes the same numbers with every installed program, for tests/cross_reading.rs to read.

Usage: write_files.py FOLDER. Prints a line a file: its name, a tab, the program. A missing program is omitted; it is an
error if HOLO_REQUIRE_PEERS is 1.
"""

import importlib
import os
import sys

import numpy as np

folder = sys.argv[1]
SIZES = [(1, 1), (5, 7), (37, 23)]
SHAPES = [(1, 1, 1, 1, 1), (4, 3, 2, 5, 3), (2, 7, 3, 1, 1)]


def image(rows, columns, channels, top):
    row, column, channel = np.ogrid[:rows, :columns, :channels]
    return ((row * 8191 + column * 523 + channel * 97) % top).astype(np.int64)


def light_field(shape, top):
    v, u, t, s, c = np.ogrid[tuple(slice(n) for n in shape)]
    return (v * 97 + u * 31 + t * 11 + s * 5 + c * 3) % top


def has(module):
    try:
        return importlib.import_module(module)
    except ImportError:
        if os.environ.get("HOLO_REQUIRE_PEERS") == "1":
            raise
        return None


def report(name, program):
    print(f"{name}\t{program}")


cv2, pillow, exr = has("cv2"), has("PIL.Image"), has("OpenEXR")
scipy, h5py, hdf5storage = has("scipy.io"), has("h5py"), has("hdf5storage")

for rows, columns in SIZES:
    size = f"{rows}x{columns}"
    for channels in (1, 3, 4):
        for bits in (8, 16):
            kind = np.uint8 if bits == 8 else np.uint16
            numbers = image(rows, columns, channels, 1 << bits).astype(kind)
            if cv2:
                name = f"cv2_{size}_{channels}_{bits}.png"
                # OpenCV has blue first.
                swapped = numbers if channels == 1 else numbers[..., [2, 1, 0, 3][:channels]]
                assert cv2.imwrite(f"{folder}/{name}", swapped)
                report(name, "OpenCV " + cv2.__version__)
            if pillow and (bits == 8 or channels == 1):
                name = f"pillow_{size}_{channels}_{bits}.png"
                pillow.fromarray(numbers[..., 0] if channels == 1 else numbers).save(f"{folder}/{name}")
                report(name, "Pillow " + pillow.__version__)
            if pillow and bits == 8:
                name = f"pillow_{size}_{channels}.rgb"
                pillow.fromarray(numbers[..., 0] if channels == 1 else numbers).save(f"{folder}/{name}", "SGI")
                report(name, "Pillow " + pillow.__version__)
    if exr:
        for coding in ("NO", "RLE", "ZIPS", "ZIP", "PIZ"):
            for kind in ("half", "float"):
                numbers = image(rows, columns, 3, 2048)
                planes = {
                    name: np.ascontiguousarray(numbers[..., at].astype(np.float16 if kind == "half" else np.float32))
                    for at, name in enumerate("RGB")
                }
                header = {"compression": getattr(exr, coding + "_COMPRESSION"), "type": exr.scanlineimage}
                name = f"openexr_{size}_{coding.lower()}_{kind}.exr"
                exr.File(header, planes).write(f"{folder}/{name}")
                report(name, "OpenEXR")

for shape in SHAPES:
    size = "x".join(map(str, shape))
    for kind in ("uint8", "uint16", "float32", "float64"):
        H = light_field(shape, 256).astype(kind)
        if scipy:
            for compressed in (False, True):
                name = f"scipy_{size}_{kind}_{'zlib' if compressed else 'plain'}.mat"
                scipy.savemat(f"{folder}/{name}", {"H": H}, do_compression=compressed)
                report(name, "SciPy")
        if hdf5storage:
            name = f"hdf5storage_{size}_{kind}.mat"
            hdf5storage.savemat(f"{folder}/{name}", {"H": H}, format="7.3", store_python_metadata=False)
            report(name, "hdf5storage")
        if h5py:
            for storage in ({}, {"compression": "gzip", "shuffle": True}):
                name = f"h5py_{size}_{kind}_{'gzip' if storage else 'plain'}.h5"
                with h5py.File(f"{folder}/{name}", "w") as file:
                    file.create_dataset("H", data=H, **storage)
                    file.attrs["axes"] = "vutsc"
                report(name, "h5py " + h5py.__version__)
