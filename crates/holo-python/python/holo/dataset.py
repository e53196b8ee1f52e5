"""Datasets of `holo dataset`: jobs as a sequence, light fields read at access."""

from __future__ import annotations

import json
import os
import pathlib
from collections.abc import Iterator, Sequence

import numpy as np

from . import _holo
from .errors import Error
from .images import read_image
from .light_field import LightField, open as open_light_field


# The numbers of views and lenses in `dataset.json`.
_SHAPES = "splits"


class Job:
    """A light field or a raw image of a dataset: one scene with one camera. Everything is read at access.

    views: T rows and S columns of a rig; None for a plenoptic camera.
    camera: the name of the plenoptic camera; None for a rig.
    """

    __slots__ = ("path", "scene", "views", "camera")

    def __init__(self, path: pathlib.Path, scene: str, views: tuple[int, int] | None, camera: str | None = None):
        self.path, self.scene, self.views, self.camera = path, scene, views, camera

    @property
    def light_field(self) -> LightField:
        """The light field, read anew at every access: float32 if the folder has HDF5, else the integers of its images.

        The raw image of an unfocused plenoptic camera is decoded.
        """
        hdf5 = self.path / "scene_5d.h5"
        return open_light_field(hdf5 if hdf5.is_file() else self.path)

    def view(self, t: int, s: int) -> np.ndarray:
        """One view, axes (row, column, channel). Of HDF5 only the chunks of the view are read."""
        hdf5 = self.path / "scene_5d.h5"
        return _holo.Reader(hdf5 if hdf5.is_file() else self.path, None, None, None).read_view(t, s)

    @property
    def raw(self) -> np.ndarray:
        """The raw image of a plenoptic camera in linear light, axes (row, column, channel): float32, or uint16 of the PNG."""
        exr = self.path / "raw.exr"
        return read_image(exr if exr.is_file() else self.path / "raw_linear.png")

    @property
    def disparity(self) -> np.ndarray:
        """Disparity of the central view in pixels, float32, axes (row, column)."""
        return read_image(self.path / "scene_disparity.pfm")

    @property
    def depth(self) -> np.ndarray:
        """Depth of the central view, or of the pixels of a raw image, in meters, float32, axes (row, column); infinite where
        nothing was hit."""
        return read_image(self.path / ("scene_depth.pfm" if self.camera is None else "raw_depth.pfm"))

    @property
    def manifest(self) -> dict:
        """The manifest: rig, settings, digests of the files."""
        return json.loads((self.path / "manifest.json").read_text(encoding="utf-8"))

    def __repr__(self):
        what = f"camera {self.camera!r}" if self.views is None else f"{self.views[0]} x {self.views[1]} views"
        return f"<Job {self.scene!r}: {what} in {self.path}>"


class Dataset(Sequence):
    """The jobs of a folder that `holo dataset` wrote.

        for job in holo.Dataset("out"):
            print(job.scene, job.views, job.light_field.lenses)

    scenes, views, cameras: only those, such as scenes=["garden"], views=[(20, 20)], cameras=["lytro-illum"].
    A scene at several poses or frames is several scenes: "garden_left", "pendulum_0012".
    """

    def __init__(
        self,
        path: str | os.PathLike,
        *,
        scenes: Sequence[str] | None = None,
        views: Sequence[tuple[int, int]] | None = None,
        cameras: Sequence[str] | None = None,
    ):
        self.path = pathlib.Path(path)
        description = self.path / "dataset.json"
        if not description.is_file():
            raise Error(f"{self.path}: no dataset.json; is it a folder that `holo dataset` wrote?")
        self.description = json.loads(description.read_text(encoding="utf-8"))
        wanted = None if views is None else {tuple(size) for size in views}
        # Whoever names views or cameras wants no others.
        sizes = [(shape["views"]["rows"], shape["views"]["columns"]) for shape in self.description[_SHAPES]]
        sizes = [size for size in sizes if (size in wanted if wanted is not None else cameras is None)]
        names = [camera["name"] for camera in self.description.get("cameras", [])]
        names = [name for name in names if (name in cameras if cameras is not None else wanted is None)]
        self.jobs = []
        for scene in (entry["name"] for entry in self.description["scenes"]):
            if scenes is None or scene in scenes:
                folder = self.path / scene
                self.jobs += [Job(folder / f"{size[1]}x{size[0]}", scene, size) for size in sizes]
                self.jobs += [Job(folder / name, scene, None, name) for name in names]

    def __len__(self):
        return len(self.jobs)

    def __getitem__(self, index):
        return self.jobs[index]

    def __iter__(self) -> Iterator[Job]:
        return iter(self.jobs)

    def __repr__(self):
        what = "raw images" if self.jobs and all(job.views is None for job in self.jobs) else "light fields"
        return f"<Dataset {self.path}: {len(self)} {what}>"
