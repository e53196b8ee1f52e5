"""Renders: light fields and raw images of scenes."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _holo
from ._holo import PlenopticCamera, Rig
from ._options import tell, texts_of, with_signature
from ._settings import Settings
from .errors import UsageError
from .light_field import LightField
from .scene import Scene, as_scene

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .plenoptic import Decoded

Progress = Callable[[int, int], object]

Point = tuple[float, float, float]


@dataclass(frozen=True)
class Pose:
    """Where a camera stands in the world of the scene (+Y up, m): at eye, looking at target, with up upward in the image.

    Without target it looks at the middle of the scene. The settings eye, target and up of `render` say the same.
    """

    eye: Point
    target: Point | None = None
    up: Point | None = None


def _placed(pose, settings):
    """The settings with those of a pose."""
    if pose is None:
        return settings
    own = {name: getattr(pose, name) for name in ("eye", "target", "up") if getattr(pose, name) is not None}
    twice = [name for name in own if settings.get(name) is not None]
    if twice:
        raise UsageError(f"pose= and {twice[0]}= both place the camera; give one of them")
    return {**settings, **own}


def _layer(layers: dict[str, np.ndarray], name: str) -> np.ndarray:
    if name not in layers:
        raise UsageError(f"{name} was not rendered; render with layers=[{name!r}]")
    return layers[name]


@dataclass(repr=False)
class Rendering:
    """A light field that was rendered, with ground truth.

    color: linear radiance, float32; None with integrator="depth". `light_field` is the same and never None.
    layers: maps by their names on the command line, such as "depth" (m), "disparity" (px), "shading-normal"; of the
        central view with the axes (row, column[, channel]), with ground_truth="all" of all views with the axes (v, u, t,
        s[, c]).
    error: estimated relative standard error of color, axes (v, u, t, s), with layers=["error"].
    exposure_ev: the automatic exposure of integers, EV. seconds: wall-clock times. rays: numbers by kind.
    """

    color: LightField | None
    rig: Rig
    layers: dict[str, np.ndarray]
    central_layers: dict[str, np.ndarray]
    error: np.ndarray | None
    exposure_ev: float | None
    integrator: str
    why: str
    samples: int
    rays: dict[str, int] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)

    @property
    def light_field(self) -> LightField:
        """The color. UsageError if none was rendered, with integrator="depth"."""
        if self.color is None:
            raise UsageError('integrator="depth" renders no color; use layers')
        return self.color

    @property
    def depth(self) -> np.ndarray:
        """Depth along the optical axis in meters, infinite where nothing was hit. UsageError if it was not rendered."""
        return _layer(self.layers, "depth")

    @property
    def disparity(self) -> np.ndarray:
        """Disparity between horizontally adjacent views in pixels. UsageError if it was not rendered."""
        return _layer(self.layers, "disparity")

    def __repr__(self) -> str:
        return f"<Rendering: {self.color!r}, layers {', '.join(self.layers)}, {self.seconds.get('render', 0):.2f} s>"

    def _repr_png_(self) -> bytes | None:
        return None if self.color is None else self.color._repr_png_()


@dataclass(repr=False)
class RawRendering:
    """The raw image of a plenoptic camera.

    color: radiance times white image, float32, axes (row, column, channel); None with integrator="depth". `image` is the
        same and never None.
    layers: maps by their names on the command line, axes (row, column[, channel]).
    error: estimated relative standard error of the image, axes (row, column), with layers=["error"]; 0 for dark pixels.
    """

    color: np.ndarray | None
    camera: PlenopticCamera
    layers: dict[str, np.ndarray]
    integrator: str
    why: str
    rays: dict[str, int]
    error: np.ndarray | None = None

    @property
    def image(self) -> np.ndarray:
        """The color. UsageError if none was rendered, with integrator="depth"."""
        if self.color is None:
            raise UsageError('integrator="depth" renders no color; use layers')
        return self.color

    def decode(
        self, white: np.ndarray | None = None, *, views: int | None = None, depth: np.ndarray | None = None
    ) -> Decoded:
        """The views of the raw image; see `holo.decode`."""
        from .plenoptic import decode

        return decode(self.image, self.camera, white=white, views=views, depth=depth)

    def __repr__(self) -> str:
        return f"<RawRendering of {self.camera!r}, layers {', '.join(self.layers)}>"


@with_signature
def render(
    scene: Scene | str | os.PathLike,
    *,
    pose: Pose | None = None,
    progress: bool | Progress = False,
    backend: str = "auto",
    threads: int = 0,
    preset: str | None = None,
    **settings: Unpack[Settings],
) -> Rendering:
    """Renders a light field into memory.

    scene: a `Scene`, or the path of a glTF file. pose: where the camera stands, `holo.Pose(eye=, target=)`.
    progress: True for a bar of tqdm, or a function of (done, total). Ctrl-C stops the render.
    backend: "auto", "embree" or "bvh". threads: 0 for one per core.

    preset: settings with a name; those that are given replace its own.

    The settings are those of `holo render` with the same defaults, `_` for `-`; pairs are (rows, columns), and
    `help(holo.Settings)` has all of them:

    views: (T, S), 100 x 100. lenses: (V, U), the pixels of a view; lens_shifts: N x N positions of their array. sensor: instead of lenses, "hd", "4k", "8k" (the
        default), "uhd8k" or (rows, columns).
    spp: samples a pixel, 16. integrator: "auto", "depth", "direct", "path". seed. target_error. max_bounces.
    denoise: "off" or "views". reuse: "off" or "views". texture_filter: "footprint" or "off".
    sky: "auto", (r, g, b), a number, or the path of an environment map.
    baseline_m, f_number, focus_m ("auto" or meters), disparity (min, max in pixels), focal_mm, sensor_mm, projection,
        camera (name or number).
    eye, target (points of the scene, m), up, fov_deg (horizontal), fit_object (name): where the camera stands. ground: adds one.
    layers: names, such as ["depth", "disparity", "shading-normal", "visibility", "error", "all"]. ground_truth: "central" or "all".
    frame: number of a frame of the scene's animations, which is at frame / fps seconds; fps, 24; animation (name or number).
        With it the layers "optical-flow" (V, U, 2), px to the right and downward until the next frame, and "scene-flow"
        (V, U, 3), m in the world.
    light_units, solid_glass, material_variant, cull, transparent_shadows, no_indirect, no_roulette, indirect_limit,
        no_multiple_scattering: as on the command line.

    The same settings and seed give the same samples as the command line, for any number of threads.
    """
    _refuse(settings, ("write", "bit_depth", "mat_order", "sensor_model", "iso", "exposure", "tools"), "render_to")
    with _bar(progress) as report:
        result = _holo.render(as_scene(scene)._as_item(), None, texts_of(_placed(pose, settings)), preset, (backend, threads), report)
    tell(result["diagnostics"])
    central = result["central"]
    light_field = None
    if result["color"] is not None:
        span = _finite_range(central.get("disparity"))
        light_field = LightField(result["color"], result["rig"], is_srgb=False, disparity_range_px=span)
    return Rendering(
        color=light_field,
        rig=result["rig"],
        layers=result["all"] or central,
        central_layers=central,
        error=result["error"],
        exposure_ev=result["exposure_ev"],
        integrator=result["integrator"],
        why=result["why"],
        samples=result["samples"],
        rays=result["rays"],
        seconds=result["seconds"],
    )


@with_signature
def render_to(
    out: str | os.PathLike,
    scene: Scene | str | os.PathLike,
    *,
    camera_file: PlenopticCamera | str | os.PathLike | None = None,
    transforms: str | os.PathLike | None = None,
    transforms_up: str = "z",
    preset: str | None = None,
    pose: Pose | None = None,
    shard: str | None = None,
    overwrite: bool = False,
    checkpoint: float = 30.0,
    progress: bool | Progress = False,
    backend: str = "auto",
    threads: int = 0,
    **settings: Unpack[Settings],
) -> dict[str, Any]:
    """Renders into a folder: the same files, byte for byte, as `holo render SCENE --out OUT` with these settings.

    camera_file: a plenoptic camera; the folder then holds its raw image, and tools are the programs that it is also written
        for. transforms: a file of poses (transforms.json), whose world has the axis transforms_up upward: alone an image of a
        pinhole camera at each, with views or camera_file a folder for each.
    shard: "K/N" for one part of several machines. overwrite: replaces another image in the folder. checkpoint: seconds
    between those of an interrupted render, 0 for none.
    write: files, such as ["el", "vpi", "mat", "h5", "exr", "hci"]; further settings as in `render`. frame: also several, "0-47",
    a folder each (shard "K/N" is then every N-th); frames that are there are kept.

    Returns the report of `holo render --json`; of several frames or poses their reports in "frames", and in "files" the names
    of all their files in `out`.
    """
    camera = camera_file
    if camera is not None and not isinstance(camera, PlenopticCamera):
        camera = PlenopticCamera.open(os.fspath(camera))
    if camera is not None and (settings.get("focus_m", "auto") != "auto" or settings.get("f_number") is not None):
        focus = settings.get("focus_m")
        camera = camera.adjusted(focus_m=None if focus == "auto" else focus, f_number=settings.get("f_number"))
    request = {
        "out": os.fspath(out),
        "camera": camera,
        "transforms": None if transforms is None else os.fspath(transforms),
        "transforms_up": transforms_up,
        "preset": preset,
        "shard": shard,
        "overwrite": overwrite,
        "checkpoint_seconds": float(checkpoint),
    }
    with _bar(progress) as report:
        reports, kept, files, lines = _holo.render_folder(
            as_scene(scene)._as_item(), texts_of(_placed(pose, settings)), (backend, threads), request, report
        )
    tell(lines)
    reports = [json.loads(report) for report in reports]
    if len(reports) == 1 and kept == 0 and not {"pose", "frame"} & reports[0].keys():
        return reports[0]
    return {"made": len(reports), "kept": kept, "files": files, "frames": reports}


@with_signature
def render_raw(
    scene: Scene | str | os.PathLike,
    camera: PlenopticCamera | str,
    *,
    pose: Pose | None = None,
    progress: bool | Progress = False,
    backend: str = "auto",
    threads: int = 0,
    preset: str | None = None,
    **settings: Unpack[Settings],
) -> RawRendering:
    """Renders the raw image of a plenoptic camera into memory.

    camera: a `PlenopticCamera`, or the name of a preset or of a camera file. The scene's camera is where it stands.
    settings: spp, integrator, seed, sky, layers and the others of `render` that are not of a rig.
    """
    if not isinstance(camera, PlenopticCamera):
        camera = PlenopticCamera.open(os.fspath(camera))
    rig = ("views", "lenses", "sensor", "baseline_m", "f_number", "focus_m", "disparity", "focal_mm", "sensor_mm")
    _refuse(settings, rig, "PlenopticCamera.adjusted")
    with _bar(progress) as report:
        result = _holo.render(as_scene(scene)._as_item(), camera, texts_of(_placed(pose, settings)), preset, (backend, threads), report)
    tell(result["diagnostics"])
    color, error = result["color"], result["error"]
    return RawRendering(
        # A light field of one view.
        color=None if color is None else color[:, :, 0, 0, :],
        camera=camera,
        layers=result["central"],
        integrator=result["integrator"],
        why=result["why"],
        rays=result["rays"],
        error=None if error is None else error[:, :, 0, 0],
    )


def _refuse(settings, names, instead):
    for name in names:
        if settings.get(name) is not None:
            raise UsageError(f"{name}= has no effect here; use `{instead}`")


def _finite_range(disparity):
    if disparity is None:
        return None
    finite = disparity[np.isfinite(disparity)]
    return (float(finite.min()), float(finite.max())) if len(finite) and finite.min() < finite.max() else None


class _bar:
    """A function of (done, total) for `progress`, or None."""

    def __init__(self, progress):
        self.progress: Any = progress
        self.bar: Any = None

    def __enter__(self):
        if self.progress is True:
            try:
                from tqdm.auto import tqdm
            except ImportError:
                raise UsageError("progress=True shows a bar of tqdm: install it, or give a function of (done, total)") from None

            # Tiles, or thousandths of every frame and pose of several.
            self.bar = tqdm(unit="step")
            return self._step
        return self.progress or None

    def _step(self, done, total):
        self.bar.total = total
        self.bar.n = done
        self.bar.refresh()

    def __exit__(self, *_):
        if self.bar is not None:
            self.bar.close()
