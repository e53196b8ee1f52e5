"""The images of cameras anywhere: arrays, and what they see together."""

from __future__ import annotations

import math
import os
import pathlib
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


class Correspondences(NamedTuple):
    """Where another camera sees the points of a camera's pixels.

    places: row and column there, whole in the middle of a pixel, axes (row, column, 2); NaN behind it. depth: there, m, axes
    (row, column). visible: True where the point is in the image and not hidden; within a pixel of an edge both may be right.
    """

    places: np.ndarray
    depth: np.ndarray
    visible: np.ndarray


class DepthEstimate(NamedTuple):
    """The depth of a camera, estimated from others: depth in meters and confidence from 0 to 1, axes (row, column); and from how many
    other cameras."""

    depth: np.ndarray
    confidence: np.ndarray
    cameras: int


class Pinhole(NamedTuple):
    """A camera: axes right, up and back (rows of a 3 x 3 array) and position, m, in the world of glTF; focal length in pixels; rows
    and columns of its image; the row and the column where it sees along its axis."""

    axes: np.ndarray
    position_m: np.ndarray
    focal_px: float
    size: tuple[int, int]
    principal_point: tuple[float, float]


def place_cameras(
    surface: str,
    count: int | tuple[int, int],
    out: str | os.PathLike = "transforms.json",
    *,
    spacing_m: float | tuple[float, float] = 0.1,
    radius_m: float = 1.0,
    target: tuple[float, float, float] = (0.0, 0.0, 0.0),
    span_deg: float = 360.0,
    elevation_deg: tuple[float, float] = (0.0, 80.0),
    size: tuple[int, int] = (800, 800),
    fov_deg: float = 40.0,
    jitter_position_m: float = 0.0,
    jitter_rotation_deg: float = 0.0,
    jitter_focal: float = 0.0,
    jitter_gain: float = 0.0,
    jitter_color: float = 0.0,
    jitter_time_s: float = 0.0,
    seed: int = 0,
    transforms_up: str = "z",
) -> pathlib.Path:
    """Places cameras on a "plane", a "cylinder" or a "sphere" around a target, as `holo array` does; returns the file, which
    `render_to(transforms=...)` takes.

    count: cameras in one row, or (rows, columns); on a sphere their number. spacing_m: between neighbors along rows, or (along rows,
    along columns); of a cylinder between rows. radius_m: distance from the target, which lies in the world of glTF (+Y up). span_deg:
    the angle of a cylinder. elevation_deg: lowest and highest on a sphere. size: rows and columns of every image. fov_deg: its
    horizontal angle of view. jitter_position_m, jitter_rotation_deg, jitter_focal, jitter_gain, jitter_color: standard deviations,
    of lengths along and about each axis, the last three relative; jitter_time_s: cameras see a moving scene up to so much later. The
    file has what came of them and the seed. transforms_up: the axis that points up in the world of the file.
    """
    if surface == "sphere" and not isinstance(count, int):
        raise UsageError("count of a sphere is one number: its cameras are in no rows")
    along, down = spacing_m if isinstance(spacing_m, tuple) else (spacing_m, spacing_m)
    jitter = [jitter_position_m, math.radians(jitter_rotation_deg), jitter_focal, jitter_gain, jitter_color, jitter_time_s]
    request = {
        "surface": surface,
        "count": (1, count) if isinstance(count, int) else count,
        "spacing_m": [along, down],
        "span_rad": math.radians(span_deg),
        "elevation_rad": [math.radians(angle) for angle in elevation_deg],
        "target_m": list(target),
        "radius_m": radius_m,
        "size": size,
        "angle_rad": math.radians(fov_deg),
        "jitter": jitter,
        "seed": seed,
    }
    _holo.place_cameras(request, pathlib.Path(out), transforms_up)
    return pathlib.Path(out)


class CameraArray:
    """A folder with the images of cameras anywhere, as `holo render --transforms` writes it, and NeRF and its successors read it.

    Of light fields at poses every view is a camera, `NAME:S,T` for view column S and row T.
    """

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

    @property
    def central(self) -> list[int]:
        """The numbers of the cameras in the middle: the central view of every light field, and every camera with its own image."""
        return self._native.central_cameras()

    def position(self, name: str) -> int:
        """The number of the camera with this name; of a light field that of its central view."""
        k = self._native.position(name)
        if k is None:
            raise UsageError(f"there is no camera {name!r}; names has all")
        return k

    def correspondences(self, first: int | str, second: int | str) -> Correspondences:
        """Where the second camera sees the points of the pixels of the first; cameras are numbers or names."""
        first, second = (self.position(camera) if isinstance(camera, str) else camera for camera in (first, second))
        return Correspondences(*self._native.correspondences(first, second))

    def estimate_depth(
        self, depths_m: tuple[float, float], camera: int | str | None = None, *, effort: str = "balanced"
    ) -> DepthEstimate:
        """The depth of a camera, estimated from those in a plane with it, which may be turned and have other focal lengths.

        depths_m: nearest and farthest depth to search; the farthest may be infinite. camera: a number or a name; by default the one
        nearest to the middle of all. effort: "draft", "fast", "balanced" or "thorough".
        """
        k = self.position(camera) if isinstance(camera, str) else camera
        return DepthEstimate(*self._native.estimate_depth(k, tuple(map(float, depths_m)), effort))

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
    axes, position_m, focal_px, size, principal_point = numbers
    return Pinhole(np.array(axes), np.array(position_m), focal_px, tuple(size), tuple(principal_point))


def _viewpoint(pose: Pose | None):
    return (None, None, None) if pose is None else (pose.eye, pose.target, pose.up)
