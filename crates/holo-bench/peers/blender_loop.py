"""Times Blender's Cycles on a grid of views, one render per view, the method of add-ons for integral imaging.

    blender_loop.py SCENE.glb --out FOLDER [--side 3] [--samples 1,4,16] [--bounces 7] [--denoise oidn]

Run by `cargo xtask report --peers`. The output is described in `peer.py`; seconds are those of each *view*: rendering
and writing its file. The scene is kept in memory between views (`use_persistent_data`), without the overhead of an
add-on: the best case of that method. `--bounces` has the meaning of Cycles: the number of bounces - 1.
`tests/radiance/cycles_check.py` corrects where the importer deviates from glTF.
"""
import os
import time

import bpy

import peer

import cycles_check as cycles  # (peer extends the import path)
from blender_camera import denoise, place, second_camera
from files import write_pfm

FOCUS_M, BASELINE_M = 0.8, 0.002


def place_on_grid(camera, base, column, row, side):
    place(camera, base, (column - (side - 1) / 2) * BASELINE_M, ((side - 1) / 2 - row) * BASELINE_M, FOCUS_M)


def main():
    parser = peer.parser(__doc__, 3, "timed one by one")
    parser.add_argument("--seeds", type=int, default=3, help="images of the central view")
    parser.add_argument("--bounces", type=int, default=7)
    parser.add_argument("--denoise", choices=["off", "oidn"], default="off", help="OpenImageDenoise at its best setting")
    a = parser.parse_args()
    scene, _ = cycles.prepare(a.scene, None, a.bounces)
    scene.render.use_persistent_data = True
    denoise(scene, a.denoise)
    base, camera = scene.camera, second_camera(scene)
    for samples in a.samples:
        scene.cycles.samples = samples
        seconds, images = [], []
        # The first render fills the caches and is not counted.
        for k in [0, *range(a.side**2)]:
            place_on_grid(camera, base, k % a.side, k // a.side, a.side)
            path = os.path.join(a.out, f"blender_{a.denoise}_{a.bounces}_{samples}_{k}.exr")
            scene.render.filepath = path
            start = time.time()
            bpy.ops.render.render(write_still=True)
            seconds.append(time.time() - start)
            os.remove(path)
        for seed in range(a.seeds):
            place_on_grid(camera, base, a.side // 2, a.side // 2, a.side)
            scene.cycles.seed = 1 + seed
            path = os.path.join(a.out, f"blender_{a.denoise}_{a.bounces}_{samples}_{seed}")
            write_pfm(path + ".pfm", cycles.render_once(scene, path + ".exr")["Combined"][..., :3])
            images.append(path + ".pfm")
            os.remove(path + ".exr")
        peer.print_measurement(samples, seconds[1:], images)


if __name__ == "__main__":
    main()
