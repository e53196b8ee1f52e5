"""Two builds of `holo` by turns: what a change costs or gains.

    cargo xtask speed OLD [NEW] [--rounds N] [--only TEXT].. [--scenes all|NAME,..] [--fail-below RATIO] [--folder DIR]

OLD and NEW are programs, such as target/release/holo of two commits, built the same way; `cargo xtask speed` takes a
commit for either and builds it. Every job writes into a fresh folder:

    direct-100, direct-20      one sample a pixel, lights alone: the 8K sensor of 100 x 100 and 20 x 20 views
    direct-9                   9 x 9 views of 512 x 512 px
    path-100, path-20, path-9  the same, paths of 8 bounces
    raw-direct, raw-path       a raw image of the Lytro Illum
    pinholes                   400 images of 8 x 6 pixels, of cameras in a row: 400 small PNGs and 400 small PFMs
    views                      the 400 views of one light field, in the layout of the HCI benchmark
    8k                         one raw image of 7952 x 5304 pixels, 20 x 20 views: scene_el.png, scene_vpi.png, scene_5d.mat
    do-...                     the commands of README and guide that 0.2.0 has: those that read a light field (do-small-..: 9 x 9
                               views of 120 x 80 px, do-8k-..: 100 x 100 views of 79 x 53 px) read what the same program rendered

The first eight render scenes of the gallery (--scenes) and write one file, as it is in memory: scene_5d.mat, or the raw
image. Every round runs both programs, the
one that begins changes. Printed is the median over the rounds of the time of OLD over that of NEW (above 1: NEW is faster),
with the interval in which 95 % of the medians of resampled rounds lie, the peak of the memory of both, and the geometric
mean over the scenes. With
--fail-below the exit code is 1 if one of these means is below that. Times contain the start of the program and the syncs
of its files: compare on a disk like the one that matters (--folder, by default that of temporary files), and with nothing
else running. The first round is not counted.
"""
import argparse
import base64
import hashlib
import json
import math
import os
import platform
import random
import shutil
import statistics
import struct
import subprocess
import sys
import tempfile
import time

# Options that all versions since 0.2.0 have.
LIGHT = "--integrator direct --spp 1 --sky 1,1,1 --backend bvh --quiet"
RIG = "--views 20x20 --baseline-m 0.001"
FILES = {
    "pinholes": f"render scene.gltf --transforms poses.json --transforms-up y --layers color {LIGHT}",
    "views": f"render scene.gltf --lenses 8x6 {RIG} --write hci {LIGHT}",
    "8k": f"render scene.gltf --sensor 7952x5304 {RIG} --write el,vpi,mat {LIGHT}",
}

# One sample a pixel that shares nothing, of a scene of the gallery.
PLAIN = "render {scene}.glb --spp 1 --quiet"
CAMERAS = {
    "100": "--views 100x100 --sensor 8k --reuse off --write mat",
    "20": "--views 20x20 --sensor 8k --reuse off --write mat",
    "9": "--views 9x9 --lenses 512x512 --reuse off --write mat",
}
RENDERS = {
    f"{integrator}-{views}": f"{PLAIN} --integrator {integrator} {camera}"
    for integrator in ["direct", "path"]
    for views, camera in CAMERAS.items()
} | {
    f"raw-{integrator}": f"{PLAIN} --integrator {integrator} --camera-file lytro-illum --write raw"
    for integrator in ["direct", "path"]
}

SMALL = "--views 9 --lenses 120x80 --disparity -1,1"
LARGE = "--views 100x100"
# What is rendered before the commands, by each program in its own folder, which is {own}.
INPUTS = {
    "small": f"render garden.glb {SMALL} --spp 4 --denoise views --write el,vpi,h5,hci,disparity --out {{own}}/small",
    "8k": f"render garden.glb {LARGE} --integrator direct --spp 1 --write el,h5,disparity --out {{own}}/8k",
    "dataset": "dataset --scenes plaster,mountains --views 3,5 --sensor 120x80 --spp 1 --write el,h5,disparity,depth "
               "--out {own}/dataset",
}
READING = {
    "info": "info {own}/{size}",
    "refocus": "refocus {own}/{size} --disparity 0.5 --out {own}/out/sharp.png",
    "depth": "depth {own}/{size} --out {own}/out/estimate.pfm",
    "eval": "eval {own}/{size}/scene_disparity.pfm {own}/{size}/scene_disparity.pfm",
    "view": "view {own}/{size} --out {own}/out/viewer.html",
    "remap": "remap {own}/{size} {own}/out/vpi.png --to vpi",
    "extract": "extract {own}/{size} --view 4,4 --out {own}/out/view.png",
}
COMMANDS = {
    "do-scene": "scene garden --out {own}/out/garden.glb",
    "do-info": "info garden.glb",
    "do-small-render": f"render garden.glb {SMALL} --spp 4 --denoise views --write el,vpi,h5,disparity --out {{own}}/out",
    "do-8k-render": f"render garden.glb {LARGE} --integrator direct --spp 1 --out {{own}}/out",
    "do-clean": "render glasses.glb --views 9 --lenses 60x40 --disparity -1,1 --spp 4 --denoise views --layers color,error "
                "--write el --out {own}/out",
    "do-frames": "render pendulum.glb --frame 6-8 --views 3x3 --lenses 60x40 --spp 1 --integrator direct --write el,vpi "
                 "--out {own}/out",
    "do-raw": "render garden.glb --camera-file lytro-illum --spp 1 --write raw --out {own}/out",
    "do-animate": "animate {own}/small --path circle --out {own}/out/views.gif",
    "do-camera": "camera lytro-illum --out {own}/out/illum.toml",
    "do-optics": "optics --depths-m 2,6 --disparity -2,2 --views 9 --lenses 512x512",
    "do-white": "white --camera-file lytro-illum --f-numbers 4 --out {own}/out",
    "do-dataset": INPUTS["dataset"].replace("{own}/dataset", "{own}/out"),
    "do-verify": "verify {own}/dataset",
    "do-pack": "pack {own}/dataset --out {own}/out --fields el.png,disparity.pfm",
} | {
    f"do-{size}-{name}": line.replace("{size}", size)
    for size in ["small", "8k"] for name, line in READING.items() if (size, name) != ("8k", "depth")
}

# Grass, glass, lamps, and plain walls.
SCENES = ["garden", "glasses", "lanterns", "plaster"]


def write_scene(path):
    """A square of 1 m, 2 m in front of a camera, as glTF without other files."""
    corners = [(-0.5, -0.5, -2), (0.5, -0.5, -2), (0.5, 0.5, -2), (-0.5, 0.5, -2)]
    data = b"".join(struct.pack("<3f", *corner) for corner in corners) + struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    scene = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": len(data), "uri": uri}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 12},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
             "min": [-0.5, -0.5, -2], "max": [0.5, 0.5, -2]},
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.6, "aspectRatio": 1.5, "znear": 0.1}}],
        "nodes": [{"mesh": 0}, {"camera": 0}],
        "scenes": [{"nodes": [0, 1]}],
        "scene": 0,
    }
    with open(path, "w") as out:
        json.dump(scene, out)


def write_poses(path):
    """400 cameras in a row of 0.2 m that look along -Z."""
    def frame(number):
        x = (number - 200) * 0.0005
        return {"file_path": f"./view_{number:03}.png",
                "transform_matrix": [[1, 0, 0, x], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}
    with open(path, "w") as out:
        json.dump({"w": 8, "h": 6, "camera_angle_x": 0.7, "frames": [frame(number) for number in range(400)]}, out)


def run(program, line, folder):
    """The time of one run, s, and the peak of its memory, MB; what it wrote is removed."""
    own = os.path.join(folder, own_folder(program))
    out = os.path.join(own, "out")
    if "{own}/out/" in line:
        os.makedirs(out)
    command = [program, *line.replace("{own}", own).split()]
    with tempfile.TemporaryFile("w+") as said:
        start = time.perf_counter()
        process = subprocess.Popen(command, cwd=folder, stdout=said, stderr=said)
        _, status, usage = os.wait4(process.pid, 0)
        took = time.perf_counter() - start
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            said.seek(0)
            sys.exit(f"{' '.join(command)}: exit code {process.returncode}\n{said.read()}")
    shutil.rmtree(out, ignore_errors=True)
    # What this run has left to the disk is not the next one's.
    os.sync()
    return took, usage.ru_maxrss / 1000


def own_folder(program):
    """The name of the folder of what a program has rendered for its own commands."""
    return "own-" + hashlib.sha256(program.encode()).hexdigest()[:8]


def interval(ratios):
    """The median, and what 95 % of the medians of resampled rounds lie between."""
    chance = random.Random(0)
    medians = sorted(statistics.median(chance.choices(ratios, k=len(ratios))) for _ in range(10_000))
    return statistics.median(ratios), medians[250], medians[-251]


def processor():
    """The model of the processor."""
    try:
        with open("/proc/cpuinfo") as lines:
            for line in lines:
                if line.startswith("model name"):
                    return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def ratio(programs, line, folder, rounds):
    """The median of the time of OLD over that of NEW with its interval, both times, s, and both peaks of memory, MB."""
    runs = [[], []]
    for number in range(rounds + 1):
        for which in [0, 1] if number % 2 == 0 else [1, 0]:
            runs[which].append(run(programs[which], line, folder))
    old, new = ([took for took, _ in own[1:]] for own in runs)
    peaks = [max(peak for _, peak in own) for own in runs]
    return interval([a / b for a, b in zip(old, new)]), statistics.median(old), statistics.median(new), peaks


def jobs(programs, only, scenes, folder):
    """Names and command lines, by group; the files that they read are written into the folder."""
    wanted = [name for name in [*RENDERS, *FILES, *COMMANDS] if not only or any(text in name for text in only)]
    if not wanted:
        sys.exit(f"no job has {' or '.join(only)} in its name; they are {', '.join([*RENDERS, *FILES, *COMMANDS])}")
    write_scene(os.path.join(folder, "scene.gltf"))
    write_poses(os.path.join(folder, "poses.json"))
    posed = any(name in COMMANDS for name in wanted)
    if posed or any(name in RENDERS for name in wanted):
        for scene in {*scenes, *(["garden", "glasses", "pendulum"] if posed else [])}:
            written = subprocess.run([programs[0], "scene", scene, "--out", f"{scene}.glb"], cwd=folder,
                                     capture_output=True, text=True)
            if written.returncode != 0:
                sys.exit(f"{programs[0]} scene {scene}: {written.stderr}")
    if posed:
        for program in programs:
            for line in INPUTS.values():
                run(program, line, folder)
    into = " --out {own}/out"
    lines = {name: line + into for name, line in FILES.items()} | COMMANDS
    renders = {name: {scene: line.replace("{scene}", scene) + into for scene in scenes} for name, line in RENDERS.items()}
    return {name: renders[name] if name in renders else {"": lines[name]} for name in wanted}


def all_scenes(program):
    """The names of the scenes of the gallery that do not move."""
    lines = subprocess.run([program, "scene"], capture_output=True, text=True, check=True).stdout.splitlines()
    names = [line.split()[0] for line in lines if line.strip()]
    return [name for name in names if name not in {"pendulum", "turning_clockwork", "garden_walk", "window"}]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", metavar="OLD")
    parser.add_argument("new", metavar="NEW")
    parser.add_argument("--rounds", type=int, default=5, help="counted rounds [default: 5]")
    parser.add_argument("--only", action="append", help="jobs with this text in their names; may be repeated")
    parser.add_argument("--scenes", default=",".join(SCENES), help=f"names or `all` [default: {','.join(SCENES)}]")
    parser.add_argument("--fail-below", type=float, default=0.0, help="the least geometric mean of a job")
    parser.add_argument("--folder", help="where the folders are made [default: that of temporary files]")
    options = parser.parse_args()
    if options.rounds < 1:
        parser.error("--rounds is at least 1")
    programs = [os.path.abspath(options.old), os.path.abspath(options.new)]
    for name, program in zip(["OLD", "NEW"], programs):
        version = subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout.strip()
        print(f"{name}: {version}, {program}")
    print(f"{processor()}, {os.cpu_count()} cores; {options.rounds} rounds")
    scenes = all_scenes(programs[0]) if options.scenes == "all" else options.scenes.split(",")
    slower = []
    with tempfile.TemporaryDirectory(dir=options.folder) as folder:
        for job, lines in jobs(programs, options.only, scenes, folder).items():
            logarithms = []
            for scene, line in lines.items():
                (median, low, high), old, new, peaks = ratio(programs, line, folder, options.rounds)
                logarithms.append(math.log(median))
                print(f"{job:16} {scene:10} old {old:.3f} s, new {new:.3f} s, "
                      f"old/new {median:.3f} ({low:.3f} to {high:.3f}); {peaks[0]:.0f}, {peaks[1]:.0f} MB", flush=True)
            mean = math.exp(statistics.mean(logarithms))
            if len(lines) > 1:
                print(f"{job:16} geometric mean of {len(lines)} scenes: old/new {mean:.3f}", flush=True)
            if mean < options.fail_below:
                slower.append(f"{job}: {mean:.3f}")
    if slower:
        sys.exit(f"below {options.fail_below}: {', '.join(slower)}")


if __name__ == "__main__":
    main()
