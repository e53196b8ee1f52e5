"""Displays that show a light field: a panel of pixels behind a sheet of lenses."""

from __future__ import annotations

import os

import numpy as np

from . import _holo
from .errors import UsageError
from .light_field import LightField


class Display:
    """A display of a file: its panel and lenses (TOML), or the `visual.json` of a Looking Glass."""

    def __init__(self, file: str | os.PathLike):
        """Reads the file."""
        self._native = _holo.Display(file)

    @property
    def name(self) -> str:
        """The name of the display, or its serial number."""
        return self._native.name()

    @property
    def panel_size(self) -> tuple[int, int]:
        """Rows and columns of the panel."""
        return self._native.sizes()[0]

    @property
    def size_m(self) -> tuple[float, float]:
        """Width and height, m."""
        return tuple(self._native.sizes()[1])

    def panel_image(
        self,
        light_field: LightField,
        disparity: float = 0.0,
        *,
        distance_m: float | None = None,
        to_scale: bool = False,
        row: int | None = None,
    ) -> np.ndarray:
        """The image for the panel: every pixel, or every stripe of it, gets the ray that it sends through its lens.

        disparity: between adjacent views in pixels of what appears in the plane of the lenses; distance_m: its distance from the cameras
        instead, which needs a rig. to_scale: the scene as a model, alike in all directions, which needs a rig too; without it the
        views fill the zone of the lenses. row: of views for cylindrical lenses; by default the middle.

        Returns float32 in linear light, axes (row, column, channel).
        """
        rig = light_field.rig
        if rig is None and (to_scale or distance_m is not None):
            raise UsageError("the rig is unknown, so to_scale= and distance_m= have no meaning")
        if distance_m is not None:
            disparity = rig.disparity_from_depth(distance_m)
        request = {
            "disparity_px": float(disparity),
            "rig": rig if to_scale else None,
            "row": row,
            "baseline_ratio": light_field._baseline_ratio(),
        }
        return self._native.panel_image(light_field.linear().array, request)

    def seen_from(
        self, panel_image: np.ndarray, eye_m: tuple[float, float, float], *, size: tuple[int, int] | None = None, rays: int = 16
    ) -> np.ndarray:
        """What an eye sees of the display, by rays through its lenses.

        eye_m: from the middle of the lenses to the right, up and to the viewer, m. size: rows and columns of the image, which is the
        rectangle of the display; by default about one pixel a lens. rays: across and down of a pixel.

        Returns float32 in linear light, axes (row, column, channel).
        """
        size = self._native.sizes()[2] if size is None else size
        image = np.asarray(panel_image, dtype=np.float32)
        return self._native.seen_from(image, tuple(map(float, eye_m)), tuple(size), rays)

    def __repr__(self) -> str:
        rows, columns = self.panel_size
        return f"Display({self.name!r}, {columns} x {rows} pixels)"
