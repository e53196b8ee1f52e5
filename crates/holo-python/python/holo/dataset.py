"""Datasets of `holo dataset`: jobs as a sequence, light fields read at access."""

from __future__ import annotations

import json
import os
import pathlib
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import Executor
from typing import Any, overload

import numpy as np

from . import _holo
from ._options import text_of, texts_of
from .errors import Error, UsageError
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

        The raw image of a plenoptic camera is decoded.
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
    def masks(self) -> dict[str, np.ndarray]:
        """The masks of `write=["masks"]` by name, such as "occluded": bool, axes (row, column)."""
        files = sorted((self.path / "masks").glob("*.png"))
        return {file.stem: read_image(file) > 0 for file in files if file.stem != "objects"}

    @property
    def objects(self) -> np.ndarray:
        """The number of the object that each pixel of the central view sees, from 1; 0 where nothing is hit. Of
        `write=["masks"]`; `manifest["settings"]["objects"]` has the names, from number 1."""
        return read_image(self.path / "masks" / "objects.png")

    @property
    def manifest(self) -> dict[str, Any]:
        """The manifest: rig, settings, digests of the files."""
        return json.loads((self.path / "manifest.json").read_text(encoding="utf-8"))

    def __repr__(self) -> str:
        what = f"camera {self.camera!r}" if self.views is None else f"{self.views[0]} x {self.views[1]} views"
        return f"<Job {self.scene!r}: {what} in {self.path}>"


def run_command(words: Sequence[str]) -> None:
    """Runs `holo` with these words in a process of its own, which has its own threads and its own handler of Ctrl-C."""
    done = subprocess.run([sys.executable, "-m", "holo", *words], capture_output=True, text=True)
    if done.returncode != 0:
        said = [line.removeprefix("holo: ") for line in done.stderr.splitlines() if line.startswith(("holo: ", "error: "))]
        raise (UsageError if done.returncode == 2 else Error)("\n".join(said) or done.stderr.strip())


def _words(
    out: str | os.PathLike,
    views: Sequence[int | tuple[int, int]] | None,
    cameras: Sequence[str | os.PathLike],
    preset: str | None,
    threads: int,
    settings: dict[str, Any],
) -> list[str]:
    """What `holo dataset` and `holo generate` have in common, as words of a command line."""
    words = ["--out", os.fspath(out), "--quiet"]
    if views is not None:
        words += ["--views", ",".join(text_of("views", count) for count in views)]
    if cameras:
        words += ["--camera-file", ",".join(os.fspath(camera) for camera in cameras)]
    if preset is not None:
        words += ["--preset", preset]
    if threads:
        words += ["--threads", str(threads)]
    for name, text in texts_of(settings).items():
        words += [f"--{name}"] if text == "true" else [] if text == "false" else [f"--{name}={text}"]
    return words


def _run(words: Sequence[str], executor: Executor | None, parts: int | None) -> None:
    """Runs a command, in parts if there is an executor."""
    if executor is not None:
        count = parts or getattr(executor, "_max_workers", None) or 8
        futures = [executor.submit(run_command, [*words, "--shard", f"{k + 1}/{count}"]) for k in range(count)]
        for future in futures:
            future.result()
    # Finds the jobs done, and writes what describes them all.
    run_command(words)


class Dataset(Sequence["Job"]):
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
        self.jobs: list[Job] = []
        for scene in (entry["name"] for entry in self.description["scenes"]):
            if scenes is None or scene in scenes:
                folder = self.path / scene
                self.jobs += [Job(folder / f"{size[1]}x{size[0]}", scene, size) for size in sizes]
                self.jobs += [Job(folder / name, scene, None, name) for name in names]

    @classmethod
    def render(
        cls,
        out: str | os.PathLike,
        *,
        scenes: Sequence[str] | None = None,
        glb: Sequence[str | os.PathLike] = (),
        views: Sequence[int | tuple[int, int]] | None = None,
        cameras: Sequence[str | os.PathLike] = (),
        preset: str | None = None,
        executor: Executor | None = None,
        parts: int | None = None,
        threads: int = 0,
        **settings: Any,
    ) -> Dataset:
        """Renders a dataset into a folder, as `holo dataset` does, and opens it. What is complete there is kept.

        scenes: of the gallery, all by default; [] for none. glb: files of your own. views: numbers of views, each one number
            or (rows, columns). cameras: plenoptic cameras instead of views, presets or camera files.
        preset: settings with a name, such as "hci" or "clean"; those that are given replace its own.
        executor: any `concurrent.futures.Executor` that runs the parts, such as `ProcessPoolExecutor`, or those of Dask
            (`client.get_executor()`), submitit and mpi4py. Its workers need this package, and see the folder out.
        parts: into how many parts the jobs are divided, one by default without an executor, else as many as it says it has
            workers, or 8. Every part is a process with threads threads, 0 for one per core.
        settings: those of `holo dataset`, `_` for `-`.

            with ProcessPoolExecutor(2) as pool:
                dataset = holo.Dataset.render("out", scenes=["garden", "chess"], views=[20], executor=pool, spp=4)
        """
        words = ["dataset"]
        if scenes is not None:
            words += ["--scenes", ",".join(scenes) or "none"]
        if glb:
            words += ["--glb", ",".join(os.fspath(path) for path in glb)]
        words += _words(out, views, cameras, preset, threads, settings)
        _run(words, executor, parts)
        return cls(out)

    @classmethod
    def generate(
        cls,
        out: str | os.PathLike,
        *,
        count: int,
        recipe: str | os.PathLike = "mixed",
        views: Sequence[int | tuple[int, int]] | None = None,
        cameras: Sequence[str | os.PathLike] = (),
        preset: str | None = None,
        executor: Executor | None = None,
        parts: int | None = None,
        threads: int = 0,
        **settings: Any,
    ) -> Dataset:
        """Draws scenes from a recipe and renders them into a folder, as `holo generate` does, and opens it. What is complete
        there is kept, so that a larger count adds scenes.

        count: the number of scenes; they are called "000000" and so on.
        recipe: "mixed", "hci-like", "thin-and-slanted", "specular", "plenoptic-raw", or a file (TOML) of your own.
        views, cameras, preset, executor, parts, threads: as of `render`; 9 x 9 views by default.
        settings: those of `holo generate`, `_` for `-`; `seed` is that of the scenes and of their samples.

            dataset = holo.Dataset.generate("out", count=100, recipe="hci-like", spp=4, integrator="direct")
        """
        words = ["generate", "--count", str(count), "--recipe", os.fspath(recipe)]
        words += _words(out, views, cameras, preset, threads, settings)
        _run(words, executor, parts)
        return cls(out)

    def __len__(self) -> int:
        return len(self.jobs)

    @overload
    def __getitem__(self, index: int) -> Job: ...

    @overload
    def __getitem__(self, index: slice) -> list[Job]: ...

    def __getitem__(self, index: int | slice) -> Job | list[Job]:
        return self.jobs[index]

    def __repr__(self) -> str:
        what = "raw images" if self.jobs and all(job.views is None for job in self.jobs) else "light fields"
        return f"<Dataset {self.path}: {len(self)} {what}>"
