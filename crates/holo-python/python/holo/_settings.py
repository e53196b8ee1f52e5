"""The settings of renders. This file follows from the table of settings in holo-dataset: see its tests."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Literal, TypedDict


class Settings(TypedDict, total=False):
    """The settings of a render, as keywords of `render`, `render_to` and `render_raw`. Pairs are (rows, columns), text is columns x rows.

    light_units: Unit of the lights in the file: candela and lux of glTF, those of Blender's lighting mode "Standard" (683 times as bright), or `auto`, by generator and numbers. Default: gltf.
    solid_glass: Treat closed meshes with transmission but without a volume as solid glass; otherwise they are thin, like soap bubbles.
    material_variant: Name of a material variant of the file, as `holo info` lists them.
    camera: Name or number of the scene's camera [default: the first].
    eye: Place of the camera in the world of the file, m [default: that of the scene's camera].
    target: Point that the camera looks at, m [default: with `eye` the middle of the scene].
    up: Direction that is up in the image [default: 0,1,0].
    fov_deg: Horizontal angle of view, degrees [default: that of the scene's camera].
    fit_object: Name of an object that fills the view: the camera keeps its direction, or looks from `eye`, and moves along its line of sight.
    ground: Add a gray ground below the lowest point, which catches shadows.
    frame: Frame of the file's animations, or frames A-B, each in a folder of its own with the focus and exposure of the first [default: the scene at rest]. Frame N is at N / fps seconds.
    fps: Frames per second [default: 24].
    animation: Name or index of the animation to play [default: all of the file].
    views: Views, columns x rows, or one number for both. Default: 100x100.
    sensor: Sensor resolution in pixels: hd, 4k, 8k (7952x5304), uhd8k (7680x4320) or WIDTHxHEIGHT, less the rest when divided by the views. Default: 8k.
    lenses: Lenses, columns x rows: the microlenses, which are the pixels of one view. Replaces `sensor`.
    lens_shifts: Lens array shifting: N x N exposures, the microlens array moved by 1/N of its pitch, interleaved to N times as many lenses along both axes.
    f_number: f-number of the main lens, whose aperture the views sample. Default: 5.
    baseline_m: Baseline: distance between adjacent views, m.
    disparity: Smallest and largest disparity of the scene, px between adjacent views: focus distance and baseline follow.
    focus_m: Focus distance, m, `inf`, or `auto` (harmonic mean of nearest and farthest depth). Disparity is 0 there. Default: auto.
    focal_mm: Focal length, mm [default: from the angle of view of the scene's camera].
    sensor_mm: Sensor size: length of the larger image side, mm. Default: 36.
    projection: Projection of the views. Default: perspective.
    subset: Render only some of the views: the row and column of the central one (cross), with both diagonals (star), or a list of COLUMN,ROW. Writes them as hci/input_CamNNN.png, numbered as in the whole grid.
    integrator: Light transport. Default: auto.
    spp: Samples per pixel [default: 16, with the integrator depth 1]. With `denoise views` also 1/2, 1/4 .. 1/64: so many of the pixels have a sample, and all share them.
    target_error: Adaptive sampling: stop at this relative standard error of a pixel, such as 0.02 or 2%. `spp` is then the maximum [default: 1024; with `denoise views` 16, and the error is that after samples are shared].
    max_bounces: Maximum number of bounces of a light path. Default: 8.
    no_roulette: Disable Russian roulette: follow every path to its last bounce.
    no_indirect: Omit light that diffuse surfaces reflect to each other (with `integrator auto`).
    indirect_limit: Limit what a light path may add after its first hit: fewer bright specks, darker caustics [default: no limit].
    transparent_shadows: Let shadow rays pass straight through smooth glass: no noise behind windows, but no caustics of solid glass.
    no_multiple_scattering: Omit light that is scattered more than once in the roughness of a surface: rough metal gets darker.
    reuse: Share the light that rays find on diffuse surfaces between groups of 16 neighboring views. Their noise is lower, but the same: do not score or train stereo with it. Default: off.
    texture_filter: Average fine textures over the part of a pixel that a sample stands for: a small bias that more samples remove. No effect with `denoise views`. Default: footprint.
    spectral: Let the main lens of glass of a plenoptic camera refract red, green and blue light differently, at three times the cost.
    denoise: Reduce the noise of color by the samples of pixels that see the same point: a small bias that more samples remove. The noise that is left moves with the true disparity: do not score or train stereo with it. Default: off.
    cull: Hide the backs of surfaces that are not double-sided, as game engines do.
    sky: Environment light: linear radiance of a constant sky (one number is gray), an equirectangular map (.hdr, .exr; .png, .jpg as sRGB), or `auto`: black, and a soft sky for scenes without light. Default: auto.
    backdrop: Color behind the scene instead of the environment, linear RGB. It lights nothing.
    seed: Random seed. Default: 0.
    write: Files to write, separated by commas [default: vpi,el,mat, and disparity,depth unless `layers` names others; without color no vpi, el and mat. Of a plenoptic camera raw,raw-png,white,centers].
    layers: Layers (AOVs) to write as float maps (PFM), separated by commas [default: those of `write`]. Most describe the first surface, glass included, that the ray through the center of a pixel hits. scene_LAYER.pfm is of the central view (raw_LAYER.pfm of a plenoptic camera); with `ground-truth all` the folder LAYER has one of every view.
    ground_truth: Views for which ground truth is written. Default: central.
    exposure: Exposure compensation of 8- and 16-bit images in EV, or `auto`. Default: auto.
    bit_depth: Bits per channel of the raw PNGs and of scene_5d.mat. Default: 8.
    mat_order: Order of the array in scene_5d.mat: H(v,u,t,s,c), or LF(t,s,v,u,c) as in the Light Field Toolbox. Default: lenses.
    sensor_model: Also write the codes that this image sensor makes of the raw image: scene_raw.png, .dng, .json.
    iso: Film speed of that sensor [default: its base speed].
    tools: Programs that the raw image of a plenoptic camera is also written for, separated by commas: a folder each, with a README.txt.
    """

    light_units: Literal["gltf", "blender", "auto"] | None
    solid_glass: bool | None
    material_variant: str | None
    camera: str | None
    eye: tuple[float, float, float] | str | None
    target: tuple[float, float, float] | str | None
    up: tuple[float, float, float] | str | None
    fov_deg: float | None
    fit_object: str | None
    ground: bool | None
    frame: int | str | None
    fps: float | None
    animation: str | None
    views: int | tuple[int, int] | str | None
    sensor: str | tuple[int, int] | None
    lenses: int | tuple[int, int] | str | None
    lens_shifts: int | None
    f_number: float | None
    baseline_m: float | None
    disparity: tuple[float, float] | None
    focus_m: str | float | None
    focal_mm: float | None
    sensor_mm: float | None
    projection: Literal["perspective", "orthographic"] | None
    subset: str | None
    integrator: Literal["auto", "depth", "direct", "path"] | None
    spp: int | float | str | None
    target_error: float | None
    max_bounces: int | None
    no_roulette: bool | None
    no_indirect: bool | None
    indirect_limit: float | None
    transparent_shadows: bool | None
    no_multiple_scattering: bool | None
    reuse: Literal["off", "views"] | None
    texture_filter: Literal["off", "footprint"] | None
    spectral: bool | None
    denoise: Literal["off", "views"] | None
    cull: bool | None
    sky: str | float | tuple[float, float, float] | os.PathLike[str] | None
    backdrop: tuple[float, float, float] | float | str | None
    seed: int | None
    write: Sequence[Literal["vpi", "el", "disparity", "depth", "masks", "exr", "mat", "h5", "hci", "hci-highres", "raw", "raw-png", "white", "centers"]] | str | None
    layers: Sequence[Literal["color", "depth", "ray-length", "disparity", "geometric-normal", "shading-normal", "albedo", "object-id", "material-id", "hit-mask", "reflective", "all", "visibility", "optical-flow", "scene-flow", "lens-row", "lens-column", "lens-type", "white", "virtual-depth", "blur", "inverse-depth-mean", "inverse-depth-deviation", "coverage", "error"]] | str | None
    ground_truth: Literal["central", "all"] | None
    exposure: str | float | None
    bit_depth: int | None
    mat_order: Literal["lenses", "lftoolbox"] | None
    sensor_model: str | None
    iso: float | None
    tools: Sequence[Literal["lftoolbox", "plenopticam", "libpleno", "pip", "raytrix", "plenpy", "lytro"]] | str | None
