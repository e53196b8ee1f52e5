"""Times Blender's Cycles over a grid of views, one camera and one render a view: what add-ons for integral imaging do.

    blender_loop.py SCENE.glb --out FOLDER [--side 3] [--samples 1,4,16] [--bounces 7]

What `cargo xtask report --peers` runs; what is printed is told in `peer.py`, seconds of every *view*: rendering and writing its file. The
scene is kept in memory between views (`use_persistent_data`), without an add-on's own bookkeeping: the best case of that method.
`--bounces` is Cycles': scattering events - 1. What the importer understands otherwise than glTF says is set right
(`tests/radiance/cycles_check.py`).
"""
import os
import time

import bpy
from mathutils import Vector

import peer

import cycles_check as cycles  # (peer says where it is)
from files import write_pfm

FOCUS_M, BASELINE_M = 0.8, 0.002


def place(camera, base, column, row, side):
    """An off-axis view: moved along the sensor, its sensor shifted so that all views meet in the focus plane."""
    dx, dy = (column - (side - 1) / 2) * BASELINE_M, ((side - 1) / 2 - row) * BASELINE_M
    camera.location = base.matrix_world.translation + base.matrix_world.to_3x3() @ Vector((dx, dy, 0))
    shift = base.data.lens / base.data.sensor_width / FOCUS_M
    camera.data.shift_x, camera.data.shift_y = -dx * shift, -dy * shift


def main():
    parser = peer.parser(__doc__, 3, "timed one by one")
    parser.add_argument("--seeds", type=int, default=3, help="pictures of the central view")
    parser.add_argument("--bounces", type=int, default=7)
    a = parser.parse_args()
    scene, _ = cycles.prepare(a.scene, None, a.bounces)
    scene.render.use_persistent_data = True
    base = scene.camera
    camera = base.copy()
    camera.data = base.data.copy()
    scene.collection.objects.link(camera)
    scene.camera = camera
    for samples in a.samples:
        scene.cycles.samples = samples
        seconds, pictures = [], []
        # The first one fills the caches.
        for k in [0, *range(a.side**2)]:
            place(camera, base, k % a.side, k // a.side, a.side)
            path = os.path.join(a.out, f"blender_{a.bounces}_{samples}_{k}.exr")
            scene.render.filepath = path
            start = time.time()
            bpy.ops.render.render(write_still=True)
            seconds.append(time.time() - start)
            os.remove(path)
        for seed in range(a.seeds):
            place(camera, base, a.side // 2, a.side // 2, a.side)
            scene.cycles.seed = 1 + seed
            path = os.path.join(a.out, f"blender_{a.bounces}_{samples}_{seed}")
            write_pfm(path + ".pfm", cycles.render_once(scene, path + ".exr")["Combined"][..., :3])
            pictures.append(path + ".pfm")
            os.remove(path + ".exr")
        peer.tell(samples, seconds[1:], pictures)


if __name__ == "__main__":
    main()
