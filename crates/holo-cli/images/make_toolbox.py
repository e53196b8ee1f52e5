"""Makes toolbox.png: what the commands that look at a light field write. Needs Python 3.9 with numpy and pillow (10.1 or newer).

Usage: make_toolbox.py HOLO [--draft] [--keep FOLDER]

HOLO is the program (target/release/holo). `--draft` takes a sixteenth of the samples. `--keep` leaves all files in a folder,
and uses the light field that is there. Some six minutes on two cores.
"""
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

HERE = Path(__file__).resolve().parent
TILE = (300, 200)
GAP, STRIP = 6, 18
LARGE = 800_000


def run(*command):
    subprocess.run([str(part) for part in command], check=True, capture_output=True)


def tile(path):
    return Image.open(path).convert("RGB").resize(TILE, Image.Resampling.LANCZOS)


def map_picture(path, low, high):
    """A float map as grey, brighter nearer."""
    with open(path, "rb") as file:
        assert file.readline() == b"Pf\n"
        columns, rows = map(int, file.readline().split())
        file.readline()
        values = np.fromfile(file, "<f4").reshape(rows, columns)[::-1]
    grey = np.clip((values - low) / (high - low), 0, 1) * 255
    return Image.fromarray(grey.astype(np.uint8)).convert("RGB").resize(TILE, Image.Resampling.LANCZOS)


def crop(path, left, top, times=1):
    size = (TILE[0] // times, TILE[1] // times)
    part = Image.open(path).convert("RGB").crop((left, top, left + size[0], top + size[1]))
    return part.resize(TILE, Image.Resampling.NEAREST)


def pictures(holo, folder, samples):
    scene, out = folder / "mountains.glb", folder / "out"
    if not out.is_dir():
        run(holo, "scene", "mountains", "--out", scene)
        rig = ["--lenses", "450x300", "--views", 9, "--baseline-m", 0.003]
        run(holo, "render", scene, "--out", out, *rig, "--spp", samples, "--no-indirect", "--quiet")
    range_px = (-1.05, 1.05)

    def made(name, *command):
        path = folder / name
        run(holo, *command, "--out", path)
        return path

    view = made("view.png", "extract", out, "--view", "4,4")
    yield "extract --view 4,4", tile(view)
    yield "refocus --disparity 0.8", tile(made("near.png", "refocus", out, "--disparity", 0.8))
    yield "refocus --disparity -0.95", tile(made("far.png", "refocus", out, "--disparity", -0.95))
    estimate = made("estimate.pfm", "depth", out)
    yield "depth", map_picture(estimate, *range_px)
    truth = out / "scene_disparity.pfm"
    run(holo, "eval", estimate, truth, "--error-map", folder / "error.png")
    yield "eval --error-map: blue too near, red too far", tile(folder / "error.png")
    yield "refocus --all-in-focus MAP", tile(made("sharp.png", "refocus", out, "--all-in-focus", estimate))
    yield "the raw image, three times", crop(out / "scene_el.png", 1800, 2170, 3)
    run(holo, "rotate-elements", out, folder / "display_el.png")
    yield "rotate-elements, three times", crop(folder / "display_el.png", 1800, 2170, 3)
    yield "quilt --tiles 3x3", tile(made("quilt.png", "quilt", out, "--tiles", "3x3"))
    epi = Image.open(made("epi.png", "epi", out, "--row", "215,4")).convert("RGB")
    strip = epi.resize((3 * TILE[0] + 2 * GAP, 9 * 6), Image.Resampling.NEAREST)
    yield "epi --row 215,4: one row of pixels, seen by nine views in turn; the steeper, the farther from the focus", strip


def main():
    arguments = sys.argv[1:]
    if not arguments or arguments[0].startswith("--"):
        sys.exit(__doc__)
    keep = Path(arguments[arguments.index("--keep") + 1]) if "--keep" in arguments else None
    font = ImageFont.load_default(12)
    with tempfile.TemporaryDirectory() as temporary:
        folder = keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        shown = list(pictures(arguments[0], folder, 4 if "--draft" in arguments else 64))
    page = Image.new("RGB", (3 * TILE[0] + 2 * GAP, 3 * (TILE[1] + STRIP + GAP) + STRIP + shown[-1][1].height), "white")
    draw = ImageDraw.Draw(page)
    for k, (label, picture) in enumerate(shown):
        x, y = k % 3 * (TILE[0] + GAP), k // 3 * (TILE[1] + STRIP + GAP)
        draw.text((x + 1, y + STRIP // 2 - 1), label, fill=(30, 30, 30), font=font, anchor="lm")
        page.paste(picture, (x, y + STRIP))
    path = HERE / "toolbox.png"
    page.save(path, optimize=True)
    if path.stat().st_size > LARGE:
        page.quantize(256, method=Image.Quantize.MEDIANCUT, kmeans=2, dither=Image.Dither.FLOYDSTEINBERG).save(path, optimize=True)
    print(f"{path.name}: {page.width} x {page.height}, {path.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
