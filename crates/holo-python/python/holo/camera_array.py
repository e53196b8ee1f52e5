"""The images of cameras anywhere: arrays, and what they see together."""

from __future__ import annotations

import math
import os
from typing import NamedTuple

import numpy as np

from . import _holo
from .errors import UsageError
from .rendering import Pose


class SynthesizedImage(NamedTuple):
    """The image of a camera that was synthesized from those of others.

    image: float32 in linear light, axes (row, column, channel). depth: m, axes (row, column). holes: True where no camera shows the
    point, axes (row, column).
    """

    image: np.ndarray
    depth: np.ndarray
    holes: np.ndarray


class Pinhole(NamedTuple):
    """A camera: axes right, up and back (rows of a 3 x 3 array) and position, m, in the world of glTF; focal length in pixels; rows
    and columns of its image."""

    axes: np.ndarray
    position_m: np.ndarray
    focal_px: float
    size: tuple[int, int]


class CameraArray:
    """A folder with the images of cameras anywhere, as `holo render --transforms` writes it, and NeRF and its successors read it."""

    def __init__(self, folder: str | os.PathLike, *, transforms_up: str = "z"):
        """Opens the folder; images are read one by one. transforms_up: the axis of the world of transforms.json that points up."""
        self._native = _holo.CameraFolder(folder, transforms_up)

    @property
    def names(self) -> list[str]:
        """The names of the cameras."""
        return self._native.names()

    def __len__(self) -> int:
        return len(self.names)

    def camera(self, k: int) -> Pinhole:
        """Camera k, from 0."""
        return _pinhole(self._native.camera(k))

    def image(self, k: int) -> np.ndarray:
        """The image of camera k: float32 in linear light, axes (row, column, channel)."""
        return self._native.image(k)

    def depth(self, k: int) -> np.ndarray | None:
        """The planar depth of camera k in meters, axes (row, column); None if the folder has none."""
        return self._native.depth(k)

    def view(self, pose: Pose | None = None) -> Pinhole:
        """The camera of a view at a pose; by default the one that is nearest to the middle of all cameras."""
        return _pinhole(self._native.view(_viewpoint(pose)))

    def refocus(
        self,
        distance_m: float | None = None,
        *,
        tilt_deg: tuple[float, float] = (0.0, 0.0),
        depth: np.ndarray | None = None,
        pose: Pose | None = None,
        aperture: str = "all",
        kernel: str = "cubic",
    ) -> np.ndarray:
        """The image of a wide aperture, sharp on a plane or everywhere: the mean of all images (synthetic aperture).

        distance_m: of the plane from the view, m. tilt_deg: its right side moves away by the first angle, its upper side by the
        second. depth: of every pixel of the view instead, m, axes (row, column). pose: of the view; by default that of the camera
        nearest to the middle of all. aperture: "all", or "disc:D", "square:D", "gaussian:D" around the view, D in meters. kernel:
        "cubic" or "bilinear".

        Returns float32 in linear light, axes (row, column, channel); NaN where no camera sees the surface.
        """
        if (distance_m is None) == (depth is None):
            raise UsageError("give one of distance_m= and depth=")
        request = {
            "distance_m": None if distance_m is None else float(distance_m),
            "tilt_rad": tuple(math.radians(angle) for angle in tilt_deg),
            "depth_m": None if depth is None else np.asarray(depth, dtype=np.float32),
            "aperture": aperture,
            "kernel": kernel,
        }
        return self._native.refocus(_viewpoint(pose), request)

    def synthesize(self, pose: Pose, *, kernel: str = "cubic") -> SynthesizedImage:
        """The image of a camera at a pose, from the images and depths of those nearest to it."""
        return SynthesizedImage(*self._native.synthesize(_viewpoint(pose), kernel))

    def __repr__(self) -> str:
        return f"CameraArray({len(self)} cameras)"


def _pinhole(numbers) -> Pinhole:
    axes, position_m, focal_px, size = numbers
    return Pinhole(np.array(axes), np.array(position_m), focal_px, tuple(size))


def _viewpoint(pose: Pose | None):
    return (None, None, None) if pose is None else (pose.eye, pose.target, pose.up)
