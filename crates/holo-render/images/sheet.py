"""Contact sheets: images with captions, and conversions of images."""
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

HERE = Path(__file__).resolve().parent
GAP = 6
STRIP = 20
LARGE = 80_000


def read_pfm(path):
    """Reads a PFM image of one or three channels, top row first."""
    kind, size, scale, data = path.read_bytes().split(b"\n", 3)
    width, height = map(int, size.split())
    values = np.frombuffer(data, "<f4" if float(scale) < 0 else ">f4")
    return values.reshape(height, width, 3 if kind == b"PF" else 1)[::-1]


def compose(name, rows):
    """Writes rows of (image, caption) to a PNG file."""
    width = max(sum(picture.width + GAP for picture, _ in row) - GAP for row in rows)
    height = sum(max(picture.height for picture, _ in row) + STRIP + GAP for row in rows) - GAP
    page = Image.new("RGB", (width, height), "white")
    draw = ImageDraw.Draw(page)
    font = ImageFont.load_default(13)
    y = 0
    for row in rows:
        x = 0
        for picture, caption in row:
            # Text wider than its panel would run into the next one.
            assert draw.textlength(caption, font) <= picture.width + GAP, caption
            draw.text((x + 1, y + STRIP // 2 - 1), caption, fill=(30, 30, 30), font=font, anchor="lm")
            page.paste(picture, (x, y + STRIP))
            x += picture.width + GAP
        y += STRIP + max(picture.height for picture, _ in row) + GAP
    save(name, page)


def save(name, page):
    """Writes a PNG; if it is large, with fewer bits per channel or with a palette."""
    path = HERE / f"{name}.png"
    tries = [lambda: page, lambda: coarser(page, 7), lambda: coarser(page, 6)]
    tries += [lambda n=n: page.quantize(n, method=Image.Quantize.MEDIANCUT, kmeans=2) for n in (256, 128)]
    for attempt in tries:
        attempt().save(path, optimize=True)
        if path.stat().st_size <= LARGE:
            break
    print(f"{path.name}: {page.width} x {page.height}, {path.stat().st_size / 1000:.0f} kB", flush=True)


def coarser(page, bits):
    """Rounds all channels to a number of bits."""
    step = 1 << (8 - bits)
    values = (np.asarray(page).astype(int) + step // 2) // step * step
    return Image.fromarray(np.minimum(values, 255).astype(np.uint8))


def encode(linear):
    """Encodes linear values as an sRGB image."""
    linear = np.clip(linear, 0, 1)
    curve = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 0.0031308) ** (1 / 2.4) - 0.055)
    return Image.fromarray(np.rint(curve * 255).astype(np.uint8))


def letters(text, size, ink, paper, height):
    """An image of large letters."""
    picture = Image.new("RGB", size, paper)
    ImageDraw.Draw(picture).text((size[0] / 2, size[1] / 2), text, fill=ink, font=ImageFont.load_default(height), anchor="mm")
    return picture
