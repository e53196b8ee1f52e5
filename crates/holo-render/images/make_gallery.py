"""Renders gallery.png: every scene of the gallery, and below each a crop of its raw image. Needs Python 3.9 with numpy
and pillow (10.1 or newer).

Usage: make_gallery.py HOLO [--draft] [--keep FOLDER]

HOLO is the program (target/release/holo), which lists the scenes. `--draft` renders with an eighth of the samples.
`--keep` copies the rendered images to a folder. Takes about ten minutes on two cores.
"""
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
sys.dont_write_bytecode = True

from sheet import GAP, STRIP, coarser  # noqa: E402

COLUMNS = 5
# Rendered larger and reduced: more samples per pixel, and smooth edges.
TILE = (240, 160)
RENDERED = (360, 240)
# The raw image of 20 x 20 views at 8K, of which the four middle rows of microlenses are rendered.
RAW = ["--sensor", "8k", "--views", 20, "--shard", "34/67"]
CROP = (240, 40)
LARGE = 700_000


def run(*command):
    return subprocess.run([str(part) for part in command], check=True, capture_output=True, text=True).stdout


def photograph(holo, name, samples, folder):
    """The view of the scene's camera, larger than a tile, with automatic exposure."""
    scene = folder / f"{name}.glb"
    run(holo, "scene", name, "--out", scene)
    size = f"{RENDERED[0]}x{RENDERED[1]}"
    flags = ["--views", 1, "--lenses", size, "--spp", samples, "--write", "el", "--quiet"]
    run(holo, "render", scene, "--out", folder / name, *flags)
    exposure = json.loads((folder / name / "manifest.json").read_text())["exposure_ev"]
    return Image.open(folder / name / "scene_el.png").convert("RGB"), exposure


def raw_crop(holo, name, samples, folder, exposure):
    """The middle of the raw image, a pixel a pixel, as bright as the photograph."""
    part = folder / f"{name}.raw"
    run(holo, "render", folder / f"{name}.glb", "--out", part, *RAW, "--spp", samples, "--write", "el", "--quiet")
    with open(part / "color.pfm", "rb") as file:
        assert file.readline() == b"PF\n"
        columns, rows = map(int, file.readline().split())
        assert float(file.readline()) < 0
        linear = np.fromfile(file, "<f4").reshape(rows, columns, 3)[::-1] * 2.0**exposure
    left = (columns - CROP[0]) // 2
    linear = np.clip(linear[: CROP[1], left : left + CROP[0]], 0, 1)
    codes = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return Image.fromarray((codes * 255 + 0.5).astype(np.uint8))


def main():
    arguments = sys.argv[1:]
    draft = "--draft" in arguments
    keep = Path(arguments[arguments.index("--keep") + 1]) if "--keep" in arguments else None
    if not arguments or arguments[0].startswith("--"):
        sys.exit(__doc__)
    holo = arguments[0]
    lines = [line.split(maxsplit=1) for line in run(holo, "scene").splitlines()]
    # The animated ones come last, with scenes of the others.
    names = [name for name, purpose in lines if not purpose.startswith("animated")]
    rows = math.ceil(len(names) / COLUMNS)
    width, height = TILE[0] + GAP, TILE[1] + STRIP + 2 + CROP[1] + GAP
    page = Image.new("RGB", (COLUMNS * width - GAP, rows * height - GAP), "white")
    draw, font = ImageDraw.Draw(page), ImageFont.load_default(13)
    with tempfile.TemporaryDirectory() as folder:
        folder = keep or Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        for k, name in enumerate(names):
            x, y = k % COLUMNS * width, k // COLUMNS * height
            draw.text((x + 1, y + STRIP // 2 - 1), name, fill=(30, 30, 30), font=font, anchor="lm")
            picture, exposure = photograph(holo, name, 32 if draft else 256, folder)
            page.paste(picture.resize(TILE, Image.Resampling.BOX), (x, y + STRIP))
            crop = raw_crop(holo, name, 4 if draft else 32, folder, exposure)
            page.paste(crop, (x, y + STRIP + TILE[1] + 2))
            print(name, flush=True)
    path = HERE / "gallery.png"
    tries = [lambda: page, lambda: coarser(page, 7), lambda: coarser(page, 6)]
    palette = page.quantize(256, method=Image.Quantize.MEDIANCUT, kmeans=2)
    tries += [lambda: page.quantize(256, palette=palette, dither=Image.Dither.FLOYDSTEINBERG)]
    for attempt in tries:
        attempt().save(path, optimize=True)
        if path.stat().st_size <= LARGE:
            break
    print(f"{path.name}: {page.width} x {page.height}, {path.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
