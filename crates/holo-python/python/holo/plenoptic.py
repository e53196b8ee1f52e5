"""Raw images of plenoptic cameras: views, image sensors, color."""

from __future__ import annotations

import os
import pathlib
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from . import _holo
from ._holo import PlenopticCamera
from ._options import tell
from .errors import Error, UsageError
from .images import with_channel
from .light_field import LightField


class Decoded(NamedTuple):
    """The views of a raw image.

    light_field: radiance. weight: the light of the white image under each sample, axes (v, u, t, s). roll_rad: the
    rotation of the views, counterclockwise in the image. depth: of a focused camera, that of the central view along which the views
    were rendered, m, axes (row, column).
    """

    light_field: LightField
    weight: np.ndarray
    roll_rad: float
    depth: np.ndarray | None = None


class Calibration(NamedTuple):
    """A camera that was found by a white image.

    camera: the camera. count: the micro-images that were compared. rms_px, largest_px: the distances of their centers of
    light from those of the camera. radii_px: of the micro-images, of three types if they differ.
    """

    camera: PlenopticCamera
    count: int
    rms_px: float
    largest_px: float
    radii_px: list[float]


def calibrate(
    white: np.ndarray, camera: PlenopticCamera | None = None, *, pixel_um: float | None = None
) -> Calibration:
    """Finds the microlens array of a plenoptic camera by a white image: arrangement, pitch, rotation, place and scale.

    white: linear, axes (row, column[, channel]); the mean of several has less noise. camera: what is known but for the array.
    pixel_um: the width of a pixel, if nothing else is known; then depths cannot follow from disparities.
    """
    white = np.asarray(white, dtype=np.float32)
    if white.ndim == 3:
        white = white.mean(-1)
    if (camera is None) == (pixel_um is None):
        raise UsageError("give either camera or pixel_um")
    found = camera.calibrated(white) if camera else PlenopticCamera.of_white_image(white, pixel_um * 1e-6)
    if found is None:
        raise Error("the image has no square or hexagonal lattice of micro-images, 4 px apart or more and a dozen a side")
    return Calibration(found[0], *found[1])


def calibration_benchmark(
    out: str | os.PathLike,
    *,
    full: bool = False,
    cameras: Sequence[str] = (),
    samples: int = 16,
    overwrite: bool = False,
    progress: Callable[[int, int], object] | None = None,
) -> list[pathlib.Path]:
    """Renders boards and white images of several plenoptic cameras, with the truth, as `holo benchmark calibration` does.

    out: the folder; parts that are there are kept. full: sensors and boards of full size, else a quarter of the pixels. cameras: some
    of them, else all. samples: of a pixel. overwrite: replace other images. progress: called with the tiles of a board that are done,
    and all of them.

    Returns the folders that were written.
    """
    parts, lines = _holo.calibration_benchmark(pathlib.Path(out), full, list(cameras), samples, overwrite, progress)
    tell(lines)
    return [pathlib.Path(out) / part for part in parts]


def decode(
    raw: np.ndarray | str | os.PathLike,
    camera: PlenopticCamera | None = None,
    *,
    white: np.ndarray | str | os.PathLike | None = None,
    views: int | None = None,
    depth: np.ndarray | None = None,
) -> Decoded:
    """Decodes the raw image of a plenoptic camera to views. From micro-images of a focused one they are rendered along its depth.

    raw: linear, axes (row, column, channel), of the size of the sensor; or a file: an image in linear light, or .lfp, .lfr, .raw of
    a Lytro camera. camera: by default that of the Lytro's metadata. white: a white image, axes (row, column), or a file of one;
    by default that of the camera. views: the views an axis; by default those whose pixels are lit in every micro-image, of a focused camera
    five. depth: of a focused camera, that of every pixel of the raw image in meters, axes (row, column); by default it is estimated.
    """
    if isinstance(white, (str, os.PathLike)):
        white = _holo.read_white(white)
    white = None if white is None else np.asarray(white, dtype=np.float32)
    is_file = isinstance(raw, (str, os.PathLike))
    if camera is None:
        camera = PlenopticCamera.of_raw(raw) if is_file else None
        if camera is None:
            raise UsageError("the raw image does not describe its camera; give `camera`")
    if is_file:
        raw = camera.read_raw(raw, white)
    depth = None if depth is None else np.asarray(depth, dtype=np.float32)
    field, weight, rig, roll, found = camera.decode_arrays(np.asarray(raw, dtype=np.float32), white, views, depth)
    return Decoded(LightField(field, rig, is_srgb=False), weight[..., 0], roll, found)


def develop(
    image: np.ndarray,
    sensor_model: str | None = None,
    *,
    camera: PlenopticCamera | None = None,
    electrons_at_one: float | None = None,
    iso: float | None = None,
    time_s: float | None = None,
    camera_seed: int = 0,
    seed: int = 0,
    frame: int = 0,
    frames: int = 1,
    dark: bool = False,
) -> tuple[np.ndarray, dict[str, Any]]:
    """The codes that an image sensor makes of linear light, with its noise (EMVA 1288), as `holo develop` does.

    image: linear RGB or gray, axes (row, column[, channel]). sensor_model: one of `sensor_models()`, or the sensor of
    `camera`. electrons_at_one: electrons of a pixel of value 1; by default 99 % of the lit values stay below 80 % of
    saturation. frames: how many to take the mean of. dark: without light.

    Returns uint16 codes, axes (row, column) of a mosaic or a gray sensor, else (row, column, channel), and what they were
    made with.
    """
    image = np.asarray(image, dtype=np.float32)
    request = {
        "sensor_model": sensor_model,
        "camera": camera,
        "electrons_at_one": electrons_at_one,
        "iso": iso,
        "time_s": time_s,
        "camera_seed": camera_seed,
        "seed": seed,
        "frame": frame,
        "frames": frames,
        "dark": dark,
    }
    codes, info = _holo.develop(with_channel(image), request)
    return (codes[..., 0] if codes.shape[2] == 1 else codes), info


def demosaic(mosaic: np.ndarray, filter: str, method: str = "malvar") -> np.ndarray:  # noqa: A002
    """Three colors in every pixel of a mosaic.

    mosaic: axes (row, column). filter: "RGGB", "GRBG", "GBRG" or "BGGR". method: "bilinear", "malvar" or "ahd".

    Returns float32 in the units of the mosaic, axes (row, column, channel).
    """
    return _holo.demosaic(np.asarray(mosaic, dtype=np.float32), filter, method)


def sensor_models() -> dict[str, str]:
    """The names of the sensors with noise, and what they are."""
    return dict(_holo.names())
