"""What the images of make_images.py share: rendering, a board under the lamps of a studio, a row of balls."""
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

from files import write_hdr
from make_scenes import ball, rectangle, tiles
from scene import Scene

# The program, whether drafts are enough, and a folder for scenes and renders: set by make_images.py.
HOLO = ""
DRAFT = False
FOLDER = Path()


def run(scene, *flags):
    """Renders a scene into a new folder; returns the folder."""
    folder = Path(tempfile.mkdtemp(dir=FOLDER))
    scene.write(folder / "scene.glb")
    command = [HOLO, "render", folder / "scene.glb", "--out", folder, "--threads", "1", "--quiet", *flags]
    command = [str(part) for part in command]
    done = subprocess.run(command, capture_output=True, text=True)
    said = (done.stdout + done.stderr).strip()
    if done.returncode or said:
        print(" ".join(command), said, sep="\n", file=sys.stderr)
    done.check_returncode()
    return folder


def render(scene, size, samples, *flags, error=0.015):
    """Renders one view to an image with at most `samples` per pixel, fewer where the relative standard error is below
    `error`. By default the exposure is 0 (radiance 1 is white)."""
    samples = max(16, samples // 8) if DRAFT else samples
    flags = flags if "--exposure" in flags else (*flags, "--exposure", 0)
    flags = flags if error is None else (*flags, "--target-error", error)
    folder = run(scene, "--views", 1, "--lenses", f"{size[0]}x{size[1]}", "--spp", samples, "--write", "el", *flags)
    return Image.open(folder / "scene_el.png").convert("RGB")


def directions(height, width):
    """The directions of the texels of an environment map."""
    v, u = (np.arange(height) + 0.5) / height, (np.arange(width) + 0.5) / width
    polar, azimuth = (v * math.pi)[:, None], ((u - 0.5) * 2 * math.pi)[None, :]
    return np.stack(np.broadcast_arrays(np.sin(polar) * np.cos(azimuth), np.cos(polar), np.sin(polar) * np.sin(azimuth)), axis=-1)


def soft_box(direction, towards, half_width, half_height, edge=0.04):
    """1 inside a rectangle that faces the origin from `towards` (half sizes as tangents), 0 outside, soft between."""
    towards = np.array(towards, float) / np.linalg.norm(towards)
    right = np.cross([0, 1, 0], towards)
    right /= np.linalg.norm(right)
    along = np.maximum(direction @ towards, 1e-6)
    x, y = np.abs(direction @ right) / along, np.abs(direction @ np.cross(towards, right)) / along
    inside = np.clip((half_width - x) / edge, 0, 1) * np.clip((half_height - y) / edge, 0, 1)
    return (inside * (direction @ towards > 0))[..., None]


def studio(lamps=1.0):
    """Two lamps before gray walls, as an environment map; returns its path."""
    d = directions(128, 256)
    walls = np.array([0.30, 0.31, 0.33]) * (0.75 + 0.45 * d[..., 1:2])
    shine = 5.5 * soft_box(d, (-1.0, 1.1, 1.0), 0.45, 0.45) + 2.5 * soft_box(d, (1.0, 0.45, 0.55), 0.18, 0.6)
    path = FOLDER / "studio.hdr"
    write_hdr(path, walls + lamps * shine * np.array([1.0, 0.97, 0.92]))
    return path


def board(scene, half=4.0, repeat=4.0, light=(226, 214, 190), dark=(120, 128, 148), y=0.0):
    """A tiled floor."""
    floor = scene.matt(texture=scene.texture(tiles(192, 6, light, dark)))
    scene.add(rectangle([-half, y, half], [2 * half, 0, 0], [0, 0, -2 * half], repeat), floor)


def ball_row(materials, spread=1.12, size=(732, 132), samples=384, shape=None):
    """A row of balls on a board in front of the lamps of the studio."""
    scene = Scene()
    board(scene, 8.0, 8.0, y=-0.5)
    for k, material in enumerate(materials):
        scene.add(shape or ball(0.5, 96, 48), material(scene), [(k - (len(materials) - 1) / 2) * spread, 0, 0])
    scene.camera([0, 2.6, 13], [0, -0.02, 0], 5.9, size)
    return render(scene, size, samples, "--sky", studio())
