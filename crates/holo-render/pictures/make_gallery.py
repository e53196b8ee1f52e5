"""Makes gallery.png: the central view of every scene of the gallery. Needs Python 3.9 with numpy and pillow (10.1 or newer).

Usage: make_gallery.py HOLO [--draft] [--keep FOLDER]

HOLO is the program (target/release/holo); its gallery is what is shown, in its order. `--draft` takes a sixth of the
samples. `--keep` leaves every picture as it was rendered in a folder. Some five minutes on two cores.
"""
import math
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
sys.dont_write_bytecode = True

from make_pictures import GAP, STRIP, coarser  # noqa: E402

COLUMNS = 5
# Rendered larger and reduced: more samples a pixel, and smooth edges.
TILE = (240, 160)
RENDERED = (360, 240)
LARGE = 600_000


def run(*command):
    return subprocess.run([str(part) for part in command], check=True, capture_output=True, text=True).stdout


def photograph(holo, name, samples, folder):
    """The view of the scene's camera, larger than a tile, with automatic exposure."""
    scene = folder / f"{name}.glb"
    run(holo, "scene", name, "--out", scene)
    size = f"{RENDERED[0]}x{RENDERED[1]}"
    flags = ["--views", 1, "--lenses", size, "--spp", samples, "--write", "el", "--quiet"]
    run(holo, "render", scene, "--out", folder / name, *flags)
    return Image.open(folder / name / "scene_el.png").convert("RGB")


def main():
    arguments = sys.argv[1:]
    draft = "--draft" in arguments
    keep = Path(arguments[arguments.index("--keep") + 1]) if "--keep" in arguments else None
    if not arguments or arguments[0].startswith("--"):
        sys.exit(__doc__)
    holo = arguments[0]
    names = run(holo, "scene").split()
    rows = math.ceil(len(names) / COLUMNS)
    width, height = TILE[0] + GAP, TILE[1] + STRIP + GAP
    page = Image.new("RGB", (COLUMNS * width - GAP, rows * height - GAP), "white")
    draw, font = ImageDraw.Draw(page), ImageFont.load_default(13)
    with tempfile.TemporaryDirectory() as folder:
        folder = keep or Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        for k, name in enumerate(names):
            x, y = k % COLUMNS * width, k // COLUMNS * height
            draw.text((x + 1, y + STRIP // 2 - 1), name, fill=(30, 30, 30), font=font, anchor="lm")
            picture = photograph(holo, name, 4 if draft else 24, folder)
            page.paste(picture.resize(TILE, Image.Resampling.BOX), (x, y + STRIP))
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
