"""Reconstruction of the raw images of plenoptic cameras: `plenoptic.py HOLO FOLDER [SCENE [SAMPLES]]`.

The presets lytro-illum and raytrix-r12-a at a tenth of their width and height. Each image is rendered whole, killed and
continued, and in three parts; all must have the same bytes. Then its relative squared error against 4,096 samples,
before and after `--denoise views`, and the estimated one. Needs the Python package OpenEXR.
"""

import os
import re
import signal
import subprocess
import sys
import time

import numpy
import OpenEXR

holo, folder = os.path.abspath(sys.argv[1]), sys.argv[2]
scene, samples = (sys.argv[3:] + ["chess", "8"][len(sys.argv) - 3:])[:2]
REFERENCE = "4096"
LIGHT = ["--integrator", "path", "--max-bounces", "3", "--write", "raw", "--quiet"]


def run(*arguments):
    subprocess.run([holo, *arguments], check=True)


def render(out, *more):
    return [holo, "render", "scene.glb", "--camera-file", camera, *LIGHT, "--out", out, *more]


def timed(out, *more):
    start = time.monotonic()
    subprocess.run(render(out, *more), check=True)
    return time.monotonic() - start


def read(out):
    with OpenEXR.File(os.path.join(out, "raw.exr")) as file:
        channels = file.channels()
        pixels = channels["RGB"].pixels if "RGB" in channels else numpy.stack([channels[c].pixels for c in "RGB"], -1)
        return pixels.astype(float)


def killed_and_continued(out, *more):
    """Kills a render whenever its checkpoint has grown; returns the number of kills."""
    kills, before = 0, 0
    while True:
        process = subprocess.Popen(render(out, "--checkpoint", "0.5", *more))
        while process.poll() is None:
            found = [entry for entry in os.scandir(out) if "checkpoint" in entry.name] if os.path.isdir(out) else []
            size = max((entry.stat().st_size for entry in found), default=0)
            if kills < 3 and size > before:
                process.send_signal(signal.SIGKILL)
                process.wait()
                kills, before = kills + 1, size
            time.sleep(0.02)
        if process.returncode == 0:
            return kills
        if process.returncode != -signal.SIGKILL:
            raise SystemExit(f"holo ended with {process.returncode}")


def same(a, b, name):
    with open(os.path.join(a, name), "rb") as one, open(os.path.join(b, name), "rb") as other:
        return one.read() == other.read()


def squared_error(image, exact):
    """Relative squared errors without the worst pixel of a hundred, for pixels with light."""
    lit = exact.sum(-1) > 0
    exact, image = exact[lit], image[lit]
    errors = numpy.sort(((image - exact) ** 2 / (exact**2 + 0.01 * (exact**2).mean())).ravel())
    return errors[: len(errors) * 99 // 100].mean()


os.makedirs(folder, exist_ok=True)
os.chdir(folder)
run("scene", scene, "--out", "scene.glb", "--quiet")
for name in ("lytro-illum", "raytrix-r12-a"):
    text = subprocess.run([holo, "camera", name], check=True, capture_output=True, text=True).stdout
    size = [int(x) // 10 for x in re.search(r"size_px = \[(\d+), (\d+)\]", text).groups()]
    camera = f"{name}.toml"
    with open(camera, "w") as file:
        file.write(re.sub(r"size_px = \[.*?\]", f"size_px = {size}", text))
    how = ["--spp", samples, "--denoise", "views", "--layers", "error"]
    whole, again, merged = (f"{name}_{kind}" for kind in ("whole", "continued", "merged"))
    seconds = timed(whole, *how)
    plain_seconds = timed(f"{name}_plain", "--spp", samples)
    kills = killed_and_continued(again, *how)
    parts = [f"{name}_part{k}" for k in (1, 2, 3)]
    for k, part in enumerate(parts, 1):
        run(*render(part, *how, "--shard", f"{k}/3")[1:])
    run("merge", *parts, "--out", merged)
    equal = all(same(whole, other, file) for other in (again, merged) for file in ("raw.exr", "raw_error.pfm"))
    timed(f"{name}_exact", "--spp", REFERENCE, "--seed", "99", "--texture-filter", "off")
    exact = read(f"{name}_exact")
    before, after = squared_error(read(f"{name}_plain"), exact), squared_error(read(whole), exact)
    print(f"{name}, {size[0]} x {size[1]} pixels, {scene}, {samples} samples: killed {kills} times and in 3 parts, "
          f"{'the same bytes' if equal else 'OTHER BYTES'}; squared error {before:.5f} to {after:.6f}, a gain of "
          f"{before / after:.1f}; {plain_seconds:.1f} s to {seconds:.1f} s", flush=True)
    if not equal:
        sys.exit(1)
