"""Prints the trade-off of the paper (section V) as a table: more views of one sensor have fewer pixels and a smaller baseline.

Usage: tradeoff.py HOLO DATASET SCENE [SCENE ..]

HOLO is the program, DATASET a folder that `holo dataset` wrote with 20 to 100 views per axis. Needs numpy and pillow. For every
scene and view count: baseline, disparity range and depth of field of all views together (a blur of one pixel at 20 x 20 views);
PSNR and SSIM of the central view, enlarged to its size at 20 x 20 views, against that one; multi-view stereo from the raw image:
BadPix(0.07) beside that of the trivial baseline of a constant, and the median error of depth.
"""
import json
import subprocess
import sys
import tempfile
from configparser import ConfigParser
from pathlib import Path

import numpy as np
from PIL import Image

VIEW_COUNTS = [20, 40, 60, 80, 100]
LARGE = (397, 265)


def run(*command):
    return subprocess.run([str(part) for part in command], check=True, capture_output=True, text=True).stdout


def read_pfm(path):
    with open(path, "rb") as file:
        file.readline()
        columns, rows = map(int, file.readline().split())
        assert float(file.readline()) < 0
        return np.fromfile(file, "<f4").reshape(rows, columns)[::-1]


def inverse_depth(disparity_px, parameters):
    """Eq. 3 solved for 1/Z."""
    inside, outside = parameters["intrinsics"], parameters["extrinsics"]
    pixels = max(inside.getint("image_resolution_x_px"), inside.getint("image_resolution_y_px"))
    k = outside.getfloat("baseline_mm") / 1e3 * inside.getfloat("focal_length_mm") * pixels
    k /= inside.getfloat("sensor_size_mm")
    return disparity_px / k + 1 / outside.getfloat("focus_distance_m")


def row(holo, job, views, reference, folder):
    depth = read_pfm(job / "scene_depth.pfm")
    near, far = depth[np.isfinite(depth)].min(), depth[np.isfinite(depth)].max()
    # One pixel at 20 x 20 views, in pixels of this view count.
    circle = 20 / views
    optics = json.loads(run(holo, "optics", job, "--depths-m", f"{near},{far * 1.000001}", "--circle-px", circle, "--json"))
    view = folder / f"view{views}.png"
    run(holo, "extract", job, "--view", f"{views // 2},{views // 2}", "--out", view)
    Image.open(view).resize(LARGE, Image.Resampling.BICUBIC).save(view)
    likeness = json.loads(run(holo, "eval", view, reference or view, "--json"))
    estimate, truth = folder / f"estimate{views}.pfm", job / "scene_disparity.pfm"
    # The raw image alone, with the parameters beside it.
    run(holo, "depth", job / "scene_el.png", "--out", estimate, "--quiet")
    scores = json.loads(run(holo, "eval", estimate, truth, "--border", max(2, 15 * 20 // views), "--json"))
    parameters = ConfigParser()
    parameters.read(job / "parameters.cfg")
    estimated, true = (inverse_depth(read_pfm(path).astype(float), parameters) for path in (estimate, truth))
    error = np.median(np.abs(true / np.maximum(estimated, 1e-9) - 1)[np.isfinite(true) & (true > 0)])
    low, high = optics["disparity_px"]
    sharp = " to ".join(x if isinstance(x, str) else f"{x:.2f}" for x in optics["depth_of_field_m"])
    like = "" if reference is None else f"{likeness['psnr_db']:.1f} dB, {likeness['ssim']:.3f}"
    stereo = f"{scores['bad_pixels_0.07_percent']:.1f} % ({scores['best_constant_bad_pixels_percent']:.1f} %)"
    lenses = optics["lenses"]
    print(
        f"| {job.parent.name} | {views}x{views} | {lenses['columns']}x{lenses['rows']} | {optics['baseline_mm']:.3f} mm "
        f"| {low:.3f} to {high:.3f} px | {sharp} m | {like} | {stereo} | {100 * error:.2f} % |",
        flush=True,
    )
    return view


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    holo, dataset, scenes = sys.argv[1], Path(sys.argv[2]), sys.argv[3:]
    print("| scene | views | lenses | baseline | disparities | depth of field | enlarged view | BadPix(0.07) (constant) | depth error |")
    print("|---|---|---|---|---|---|---|---|---|")
    for scene in scenes:
        with tempfile.TemporaryDirectory() as folder:
            reference = None
            for views in VIEW_COUNTS:
                view = row(holo, dataset / scene / f"{views}x{views}", views, reference, Path(folder))
                reference = reference or view


if __name__ == "__main__":
    main()
