# SPDX-License-Identifier: GPL-3.0-or-later
"""One image of a scene by Cycles and by holo, both in linear light."""

import pathlib

import bpy
import numpy as np

SAMPLES = 256


def cycles(folder):
    """The image of Cycles, float32, axes (row, column, channel)."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    settings = scene.cycles
    settings.samples = SAMPLES
    settings.use_adaptive_sampling = settings.use_denoising = False
    settings.max_bounces = settings.diffuse_bounces = settings.glossy_bounces = settings.transmission_bounces = 8
    settings.sample_clamp_indirect = settings.blur_glossy = 0.0
    settings.pixel_filter_type = "BOX"
    settings.filter_width = 1.0
    settings.light_sampling_threshold = 0.0
    image = scene.render.image_settings
    image.file_format, image.color_depth, image.color_mode = "OPEN_EXR", "32", "RGB"
    scene.render.filepath = str(folder / "cycles.exr")
    bpy.ops.render.render(write_still=True)
    loaded = bpy.data.images.load(scene.render.filepath)
    width, height = loaded.size
    pixels = np.empty(width * height * 4, np.float32)
    loaded.pixels.foreach_get(pixels)
    bpy.data.images.remove(loaded)
    return pixels.reshape(height, width, 4)[::-1, :, :3].copy()


def holo(folder, *options):
    """The central view of holo, rendered by the operator."""
    width, height = bpy.context.scene.render.resolution_x, bpy.context.scene.render.resolution_y
    camera = bpy.context.scene.camera.data.holoscopic
    camera.spacing, camera.baseline_mm, camera.denoise = "OWN", 0.001, False
    words = ["--layers=color", "--write=el", *options]
    result = bpy.ops.render.holoscopic(
        "EXEC_DEFAULT",
        directory=str(folder),
        views="1x1",
        lenses=f"{width}x{height}",
        spp=SAMPLES,
        options=" ".join(words),
    )
    assert result == {"FINISHED"}, result
    return read_pfm(folder / "scene_color.pfm")


def read_pfm(path):
    kind, size, scale, data = pathlib.Path(path).read_bytes().split(b"\n", 3)
    width, height = map(int, size.split())
    channels = 3 if kind == b"PF" else 1
    values = np.frombuffer(data, "<f4" if float(scale) < 0 else ">f4", width * height * channels)
    return values.reshape(height, width, channels)[::-1].copy()


def differences(image, reference):
    """Mean of the image over that of the reference, and RMSE over the mean of the reference, without the 1 % of pixels that
    differ most (edges, fireflies)."""
    error = np.sort(((image - reference) ** 2).mean(axis=2).ravel())
    error = error[: int(len(error) * 0.99)]
    mean = float(reference.mean())
    return float(image.mean()) / mean, float(np.sqrt(error.mean())) / mean


def side_by_side(path, rows):
    """Writes pairs of images below one another as a PNG, on the sRGB curve."""
    lines = [np.concatenate([tone(a), np.ones_like(a[:, :4]), tone(b)], axis=1) for a, b in rows]
    sheet = np.concatenate(lines, axis=0)[::-1]
    image = bpy.data.images.new("sheet", sheet.shape[1], sheet.shape[0])
    rgba = np.concatenate([sheet, np.ones_like(sheet[..., :1])], axis=2)
    image.pixels.foreach_set(rgba.astype(np.float32).ravel())
    image.filepath_raw, image.file_format = str(path), "PNG"
    image.save()


def tone(image):
    """The sRGB curve at one half of the range for the 98th percentile."""
    scaled = np.clip(image / max(np.percentile(image, 98), 1e-6), 0.0, 1.0)
    return np.where(scaled <= 0.0031308, 12.92 * scaled, 1.055 * scaled ** (1 / 2.4) - 0.055)
