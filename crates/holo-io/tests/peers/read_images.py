"""Reads images with programs other than holo, and prints every sample as hexadecimal bits, row by row.

usage: read_images.py FILE...   Needs Pillow or cv2 for PNG (cv2 alone has 16-bit color), OpenEXR for EXR, numpy.
Prints the line `-` for a file that no installed program can read.
"""

import sys

import numpy


def png(path):
    try:
        import cv2

        image = cv2.imread(path, cv2.IMREAD_UNCHANGED)
        if image.ndim == 3:
            image = image[:, :, [2, 1, 0, 3][: image.shape[2]]]
        return image
    except ImportError:
        pass
    from PIL import Image

    image = Image.open(path)
    # Pillow reads 16-bit color as 8 bits.
    if image.mode not in ("L", "LA", "RGB", "RGBA", "I;16", "I;16B"):
        return None
    header = open(path, "rb").read(26)
    if header[24] == 16 and image.mode not in ("I;16", "I;16B"):
        return None
    return numpy.asarray(image)


def exr(path):
    import OpenEXR

    channels = OpenEXR.File(path, separate_channels=True).channels()
    return [channels[name].pixels for name in sorted(channels)]


for path in sys.argv[1:]:
    if path.endswith(".png"):
        image = png(path)
        planes = None if image is None else [image.astype(">u2" if image.dtype.itemsize == 2 else "u1")]
    else:
        planes = [plane.astype(plane.dtype.newbyteorder(">")) for plane in exr(path)]
    print("-" if planes is None else "".join(plane.tobytes().hex() for plane in planes))
