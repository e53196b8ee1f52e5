"""Makes plenoptic.png: `python3 make_plenoptic.py HOLO` with the program, numpy and OpenCV (`opencv-python-headless`)."""

import os
import subprocess
import sys
import tempfile

import cv2
import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))

# Preset, focus, m; the part of the raw image that is shown (x, y, width), and the width of a micro-image in its middle.
CAMERAS = [
    ("lytro-illum", "1.2", (3500, 2500, 120), 16),
    ("raytrix-r12-a", "1.2", (1900, 1500, 190), 26),
    ("h3dv", "1.0", (900, 520, 190), 30),
]
SIDE = 380


def shown(image, part):
    x, y, width = part
    crop = image[y : y + width, x : x + width]
    return cv2.resize(crop, (SIDE, SIDE), interpolation=cv2.INTER_NEAREST)


def around_center(centers, part, width):
    """The part around the micro-image whose center is nearest to the middle of another part."""
    x, y, size = part
    all_px = np.loadtxt(centers, delimiter=",", skiprows=1, usecols=(2, 3)) + 0.5
    nearest = all_px[np.argmin(((all_px - [x + size / 2, y + size / 2]) ** 2).sum(1))]
    return (*np.round(nearest - width / 2).astype(int), width)


def coded(linear, brightest):
    return np.uint8(255 * np.clip(linear / brightest, 0, 1) ** (1 / 2.2) + 0.5)


def main(holo):
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        scene = os.path.join(folder, "garden.glb")
        subprocess.run([holo, "scene", "garden", "--out", scene], check=True)
        for name, focus, part, width in CAMERAS:
            out = os.path.join(folder, name)
            camera = ["--camera-file", name, "--focus-m", focus]
            subprocess.run([holo, "render", scene, *camera, "--out", out, "--spp", "6", "--integrator", "direct", "--sky", "0.35,0.45,0.6",
                            "--write", "raw-png,white,centers",
                            "--quiet"], check=True)
            raw = cv2.imread(os.path.join(out, "raw_linear.png"), cv2.IMREAD_UNCHANGED) / 65535.0
            white = cv2.imread(os.path.join(out, "white.png"), cv2.IMREAD_UNCHANGED) / 65535.0
            raw = coded(raw, np.percentile(raw, 99.5))
            white = cv2.cvtColor(coded(white, 1.0), cv2.COLOR_GRAY2BGR)
            micro = around_center(os.path.join(out, "centers.csv"), part, width)
            tiles = [shown(raw, part), shown(white, part), shown(raw, micro)]
            view = np.full((SIDE, SIDE, 3), 255, np.uint8)
            decoded = os.path.join(folder, name + "-views")
            decode = [holo, "decode", os.path.join(out, "raw_linear.png"), "--camera-file", os.path.join(out, "camera.toml"),
                      "--out", decoded]
            if subprocess.run(decode, capture_output=True).returncode == 0:
                center = os.path.join(folder, name + ".png")
                size = subprocess.run([holo, "info", decoded], capture_output=True, text=True).stdout
                views = int(size.split(" views")[0].split()[-1])
                subprocess.run([holo, "extract", decoded, "--view", f"{views // 2},{views // 2}", "--out", center], check=True)
                image = cv2.imread(center, cv2.IMREAD_UNCHANGED)
                image = np.uint8(image / 257) if image.dtype == np.uint16 else image
                scale = SIDE / max(image.shape[:2])
                image = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
                top = (SIDE - image.shape[0]) // 2
                view[top : top + image.shape[0], : image.shape[1]] = image
            rows.append(np.hstack([np.pad(tile, ((4, 4), (4, 4), (0, 0)), constant_values=255) for tile in [*tiles, view]]))
    cv2.imwrite(os.path.join(HERE, "plenoptic.png"), np.vstack(rows))


if __name__ == "__main__":
    main(os.path.abspath(sys.argv[1]))
