"""Scores of disparity maps and images."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from . import _holo
from ._holo import Rig
from .images import with_channel


class ImageScore(NamedTuple):
    """How much an image differs from another."""

    psnr_db: float
    ssim: float


def evaluate(
    estimate: np.ndarray,
    truth: np.ndarray,
    *,
    border: int = 15,
    mask: np.ndarray | None = None,
    rig: Rig | None = None,
    regions: Mapping[str, np.ndarray] | None = None,
) -> dict[str, float]:
    """Scores a disparity map against ground truth with the metrics of the HCI 4D light field benchmark.

    estimate, truth: disparity in pixels, axes (row, column); what is not finite is counted and not compared. A truth with
        a multiple of the rows and columns is one of high resolution, to which the estimate is enlarged.
    border: pixels at every side that are not compared, as in the benchmark and in `holo eval`.
    mask: True where pixels are compared, axes (row, column).
    rig: adds the median angle between surface normals.
    regions: masks by name that are scored too, such as those of `Job.masks`: thinning of "fine", fattening of
    "fine_surrounding", bumpiness and median angles of "plane" and "smooth"; of the stratified scenes thinning of "spikes",
    fattening of "between_spikes", the error of "boxes", missed "dots", bumpiness of "relief" and "base"; BadPix(0.07) of any other.

    Returns the quantities of `holo eval --json`: BadPix at 0.01, 0.03 and 0.07 px in percent, MSE x 100, Q25 x 100,
    bumpiness, mean absolute and root mean squared error in pixels, BadPix(0.07) of the best constant and of the best
    plane, the border, numbers of pixels.
    """
    mask = None if mask is None else np.ascontiguousarray(mask, dtype=bool)
    masks = [(name, np.ascontiguousarray(region, dtype=bool)) for name, region in (regions or {}).items()]
    return _holo.evaluate(_map(estimate), _map(truth), border, mask, rig, masks)


def compare(image: np.ndarray, reference: np.ndarray, *, data_range: float | None = None) -> ImageScore:
    """PSNR in dB and SSIM (Wang et al., 2004) of an image, axes (row, column) or (row, column, channel).

    data_range: the largest possible difference; by default that of the integers, 1 for floats.
    """
    return ImageScore(*_holo.compare(with_channel(image), with_channel(reference), data_range))


def _map(values):
    return np.asarray(values, dtype=np.float32)
