"""Images in files."""

from __future__ import annotations

import os

import numpy as np

from . import _holo


def read_image(path: str | os.PathLike) -> np.ndarray:
    """Reads a PNG, TIFF, PFM or OpenEXR image.

    Returns the samples as they are in the file, axes (row, column, channel); of OpenEXR the channels R, G and B. A map of
    one channel, such as disparity, has the axes (row, column).
    """
    image = _holo.read_image(path)
    return image[..., 0] if image.shape[2] == 1 else image


def write_image(path: str | os.PathLike, image: np.ndarray) -> None:
    """Writes an image, axes (row, column) or (row, column, channel): uint8 and uint16 into PNG or TIFF, float32 into PFM."""
    _holo.write_image(path, with_channel(image))


def with_channel(image) -> np.ndarray:
    """An image, axes (row, column) or (row, column, channel), with all three."""
    image = np.asarray(image)
    return image[..., None] if image.ndim == 2 else image
