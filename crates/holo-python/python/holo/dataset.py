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
    """A light field of a dataset: one scene with one number of views. Everything is read at access."""

    __slots__ = ("path", "scene", "views")

    def __init__(self, path: pathlib.Path, scene: str, views: tuple[int, int]):
        self.path, self.scene, self.views = path, scene, views

    @property
    def light_field(self) -> LightField:
        """The light field, read anew at every access: float32 if the folder has HDF5, else the integers of its images."""
        hdf5 = self.path / "scene_5d.h5"
        return open_light_field(hdf5 if hdf5.is_file() else self.path)

    def view(self, t: int, s: int) -> np.ndarray:
        """One view, axes (row, column, channel). Of HDF5 only the chunks of the view are read."""
        hdf5 = self.path / "scene_5d.h5"
        return _holo.Reader(hdf5 if hdf5.is_file() else self.path, None, None, None).read_view(t, s)

    @property
    def disparity(self) -> np.ndarray:
        """Disparity of the central view in pixels, float32, axes (row, column)."""
        return read_image(self.path / "scene_disparity.pfm")

    @property
    def depth(self) -> np.ndarray:
        """Depth of the central view in meters, float32, axes (row, column); infinite where nothing was hit."""
        return read_image(self.path / "scene_depth.pfm")

    @property
    def manifest(self) -> dict:
        """The manifest: rig, settings, digests of the files."""
        return json.loads((self.path / "manifest.json").read_text(encoding="utf-8"))

    def __repr__(self):
        return f"<Job {self.scene!r}: {self.views[0]} x {self.views[1]} views in {self.path}>"


class Dataset(Sequence):
    """The jobs of a folder that `holo dataset` wrote.

        for job in holo.Dataset("out"):
            print(job.scene, job.views, job.light_field.lenses)

    scenes, views: only those, such as scenes=["garden"], views=[(20, 20)].
    """

    def __init__(
        self,
        path: str | os.PathLike,
        *,
        scenes: Sequence[str] | None = None,
        views: Sequence[tuple[int, int]] | None = None,
    ):
        self.path = pathlib.Path(path)
        description = self.path / "dataset.json"
        if not description.is_file():
            raise Error(f"{self.path}: no dataset.json; is it a folder that `holo dataset` wrote?")
        self.description = json.loads(description.read_text(encoding="utf-8"))
        wanted = None if views is None else {tuple(size) for size in views}
        self.jobs = [
            Job(self.path / scene["name"] / f"{size[1]}x{size[0]}", scene["name"], size)
            for scene in self.description["scenes"]
            for size in ((shape["views"]["rows"], shape["views"]["columns"]) for shape in self.description[_SHAPES])
            if (scenes is None or scene["name"] in scenes) and (wanted is None or size in wanted)
        ]

    def __len__(self):
        return len(self.jobs)

    def __getitem__(self, index):
        return self.jobs[index]

    def __iter__(self) -> Iterator[Job]:
        return iter(self.jobs)

    def __repr__(self):
        return f"<Dataset {self.path}: {len(self)} light fields>"
