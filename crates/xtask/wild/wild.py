"""Renders every glTF file below a folder with `holo`, compares with Cycles where it is there, writes a table.

usage: wild.py FOLDER --holo PROGRAM --out FOLDER [--list FILE] [--blender FOLDER] [--samples N] [--size WxH]
               [--blender-python PROGRAM] [--jobs N] [--only TEXT]

A file is usable unless neither program loads it. Two images agree if the mean over blocks of 8 x 8 pixels of the
absolute difference of their means is at most 0.01, under a sky of radiance 1. Written are `results.json`,
`results.md` (every file that fails or differs), and `sheet.png` (ours, and below it Cycles').

With --list only the files of the list count, found by their SHA-256 anywhere below FOLDER; a line is
`sha256  repository  commit  path`.
"""

import argparse
import concurrent.futures
import hashlib
import json
import os
import pathlib
import shutil
import subprocess
import sys

import numpy as np
import OpenEXR
from PIL import Image, ImageDraw

BOUND = 0.01
BLOCK = 8
SECONDS = 300


def arguments():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--holo", required=True)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--list", type=pathlib.Path)
    parser.add_argument("--blender", type=pathlib.Path)
    parser.add_argument("--blender-python", default=sys.executable)
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--size", default="96x72")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--only", default="")
    return parser.parse_args()


def digest(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def wanted(options):
    """The files, each content once, with their names in the table."""
    named = {}
    if options.list:
        lines = [line.split(maxsplit=3) for line in options.list.read_text().splitlines() if line[:1] not in ("", "#")]
        named = {sha: f"{repository}: {path}" for sha, repository, _, path in lines}
    found, missing = {}, dict(named)
    for path in sorted(options.folder.rglob("*")):
        if path.suffix.lower() not in (".glb", ".gltf") or not path.is_file():
            continue
        sha = digest(path)
        missing.pop(sha, None)
        if sha in found or (named and sha not in named) or options.only not in str(path):
            continue
        found[sha] = (path, named.get(sha, str(path.relative_to(options.folder))))
    return list(found.items()), sorted(missing.values())


def run(command, environment=None):
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, env=environment)
    except subprocess.TimeoutExpired:
        return None, f"no end after {SECONDS} s"
    return done.returncode, done.stderr.strip() + "\n" + done.stdout.strip()


def pixels(path):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = file.channels()
        names = [next(n for n in channels if n == c or n.endswith(f"Combined.{c}")) for c in "RGB"]
        return np.stack([channels[name].pixels.astype(np.float64) for name in names], axis=-1)


def difference(ours, theirs):
    if ours.shape != theirs.shape:
        return float("inf")
    rows, columns = (n // BLOCK for n in ours.shape[:2])

    def blocks(image):
        # Caustics that one of two noisy images has by chance count up to twice the sky.
        image = np.clip(np.nan_to_num(image[: rows * BLOCK, : columns * BLOCK], nan=1e3), 0, 2)
        return image.reshape(rows, BLOCK, columns, BLOCK, 3).mean(axis=(1, 3))

    return float(np.abs(blocks(ours) - blocks(theirs)).mean())


def one(options, sha, path, name):
    folder = options.out / "renders" / sha[:16]
    folder.mkdir(parents=True, exist_ok=True)
    ours, theirs = folder / "ours", folder / f"cycles_{options.samples}.exr"
    result = {"name": name, "sha256": sha, "path": str(path)}
    command = [options.holo, "render", str(path), "--out", str(ours), "--views", "1x1", "--lenses", options.size]
    command += ["--spp", str(options.samples), "--sky", "1,1,1", "--integrator", "path", "--write", "exr"]
    command += ["--threads", "1"]
    shutil.rmtree(ours, ignore_errors=True)
    code, text = run(command)
    lines = [line for line in text.splitlines() if line.strip()]
    result["warnings"] = [line.removeprefix("warning: ") for line in lines if line.startswith("warning: ")]
    if code != 0:
        complaint = next((line for line in lines if line.startswith("holo:")), lines[0] if lines else f"exit {code}")
        crashed = code is None or code < 0 or code == 101
        result.update(state="crashed" if crashed else "refused", why=complaint)
    else:
        result.update(state="rendered")
    if options.blender:
        cfg = ours / "parameters.cfg"
        if code != 0:
            cfg = pathlib.Path(__file__).with_name("default.cfg")
        environment = os.environ | {"PYTHONPATH": str(options.blender)}
        script = pathlib.Path(__file__).with_name("render_in_cycles.py")
        if not theirs.exists():
            code_there, said = run([options.blender_python, str(script), str(path), str(cfg), str(theirs), str(options.samples)], environment)
            if not theirs.exists():
                result["cycles_said"] = f"exit {code_there}: " + "; ".join(said.strip().splitlines()[-3:])
        result["cycles"] = theirs.exists()
        if theirs.exists() and code == 0:
            result["difference"] = difference(pixels(ours / "scene_central.exr"), pixels(theirs))
    print(f"{result['state']:9} {result.get('difference', float('nan')):7.4f} {name}", flush=True)
    return result


def sheet(options, results):
    """A contact sheet: ours, and Cycles' below it."""
    width, height = map(int, options.size.split("x"))
    shown = [r for r in results if r["state"] == "rendered"]
    columns = min(max(len(shown), 1), 12)
    rows = (len(shown) + columns - 1) // columns
    image = Image.new("RGB", (columns * (width + 4), max(rows, 1) * (2 * height + 20)), "white")
    draw = ImageDraw.Draw(image)
    for k, result in enumerate(shown):
        x, y = k % columns * (width + 4), k // columns * (2 * height + 20)
        folder = options.out / "renders" / result["sha256"][:16]
        for path, down in [(folder / "ours" / "scene_central.exr", 0), (folder / f"cycles_{options.samples}.exr", height)]:
            if path.exists():
                linear = np.clip(pixels(path), 0, 1)
                srgb = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
                image.paste(Image.fromarray((srgb * 255 + 0.5).astype(np.uint8)), (x, y + down))
        far = result.get("difference", 0) > BOUND
        draw.text((x + 1, y + 2 * height + 2), pathlib.Path(result["name"]).stem[:16], fill="red" if far else "black")
    image.save(options.out / "sheet.png")


def report(options, results, missing):
    rendered = [r for r in results if r["state"] == "rendered"]
    usable = [r for r in results if r["state"] == "rendered" or r["state"] == "crashed" or r.get("cycles")]
    compared = [r for r in rendered if "difference" in r]
    agree = [r for r in compared if r["difference"] <= BOUND]

    def share(part, whole):
        return f"{len(part)} of {len(whole)}" + (f" ({100 * len(part) / len(whole):.1f} %)" if whole else "")

    lines = [
        f"{len(results)} files, {share(rendered, usable)} usable ones rendered, {share(agree, compared)} compared agree.",
        "",
        "| file | state | difference | why |",
        "|---|---|---|---|",
    ]
    far = [r for r in results if r["state"] != "rendered" or r.get("difference", 0) > BOUND]
    for r in sorted(far, key=lambda r: (r["state"], -r.get("difference", 0))):
        why = r.get("why") or "; ".join(r["warnings"])
        lines.append(f"| {r['name']} | {r['state']} | {r.get('difference', float('nan')):.4f} | {why.replace('|', '/')[:200]} |")
    failed = [r for r in results if "cycles_said" in r]
    if failed:
        lines += ["", f"{len(failed)} files that Cycles did not render:", ""]
        lines += [f"- {r['name']}: {r['cycles_said'][:200]}" for r in failed]
    if missing:
        lines += ["", f"{len(missing)} files of the list are not below the folder:", ""] + [f"- {name}" for name in missing]
    (options.out / "results.md").write_text("\n".join(lines) + "\n")
    (options.out / "results.json").write_text(json.dumps(results, indent=1) + "\n")
    print(lines[0])
    return all(r["state"] != "crashed" for r in results)


def main():
    options = arguments()
    options.out.mkdir(parents=True, exist_ok=True)
    files, missing = wanted(options)
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        jobs = [pool.submit(one, options, sha, path, name) for sha, (path, name) in files]
        results = [job.result() for job in jobs]
    sheet(options, results)
    sys.exit(0 if report(options, results, missing) else 1)


main()
