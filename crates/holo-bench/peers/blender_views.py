"""Renders views of a scene with Blender's Cycles, with and without OpenImageDenoise, and times them.

    blender_views.py SCENE.glb --out FOLDER --size 79x53 --focal 1.39 --focus 0.8 --view 0.1,0.1 [--view X,Y ..]
                     --samples 16,64 --reference 1024 [--bounces 7]

Run by `cargo xtask report --peers`. `--focal` is in widths of the sensor, `--view` the place of the camera to the right
and up of the scene's, in meters. Prints a line for each image, with fields separated by tabs: number of the view;
`reference`, `off` or `oidn`; samples; seconds of rendering, with its file; the image (PFM, linear RGB). References
are two of each view, not denoised, from other seeds. The scene is kept in memory between images
(`use_persistent_data`); materials and lights are those of Blender's importer, lights without extent.
"""
import os
import time

import bpy

import peer

import cycles_check as cycles  # (peer extends the import path)
from blender_camera import denoise, place, second_camera
from files import write_pfm


def numbers(separator, kind):
    return lambda text: [kind(n) for n in text.split(separator)]


def load(path, bounces, size):
    """The scene of a file, and its camera."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(
        filepath=os.path.abspath(path), import_shading="NORMALS", export_import_convert_lighting_mode="COMPAT"
    )
    cycles.sharpen(bpy.data.lights)
    scene = bpy.context.scene
    scene.camera = next(o for o in bpy.data.objects if o.type == "CAMERA")
    cycles.configure(scene, bounces, *size)
    scene.render.use_persistent_data = True
    return scene


def main():
    parser = peer.parser(__doc__)
    parser.add_argument("--size", type=numbers("x", int), required=True)
    parser.add_argument("--focal", type=float, required=True)
    parser.add_argument("--focus", type=float, required=True)
    parser.add_argument("--view", type=numbers(",", float), action="append", required=True)
    parser.add_argument("--reference", type=int, required=True, help="samples of each of the two references")
    parser.add_argument("--bounces", type=int, default=7)
    a = parser.parse_args()
    scene = load(a.scene, a.bounces, a.size)
    base = scene.camera
    base.data.sensor_fit, base.data.sensor_width, base.data.lens = "HORIZONTAL", 36.0, 36.0 * a.focal
    camera = second_camera(scene)

    def render(view, kind, samples, seed):
        scene.cycles.samples, scene.cycles.seed = samples, seed
        path = os.path.join(a.out, f"view_{view}_{kind}_{samples}_{seed}")
        start = time.time()
        color = cycles.render_once(scene, path + ".exr")["Combined"][..., :3]
        seconds = time.time() - start
        os.remove(path + ".exr")
        write_pfm(path + ".pfm", color)
        return view, kind, samples, f"{seconds:.6f}", path + ".pfm"

    for view, (x, y) in enumerate(a.view):
        place(camera, base, x, y, a.focus)
        for method in ["off", "oidn"]:
            denoise(scene, method)
            # The first image after a change fills the caches and is not counted.
            render(view, method, 1, 0)
            for samples in a.samples:
                print(*render(view, method, samples, 1), sep="\t", flush=True)
        denoise(scene, "off")
        for seed in (2, 3):
            print(*render(view, "reference", a.reference, seed), sep="\t", flush=True)


if __name__ == "__main__":
    main()
