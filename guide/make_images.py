"""Makes the images of the guide: `python guide/make_images.py [NAME ..]`, with the Python package installed.

All take twenty minutes on two cores."""

import pathlib
import subprocess
import sys
import tempfile

import holo
import numpy as np

OUT = pathlib.Path(__file__).parent / "src" / "images"


def srgb(image, ev):
    """8-bit codes of linear light."""
    return holo.LightField(image[:, :, None, None]).encode(exposure=ev).array[:, :, 0, 0]


def row(images, height, gap=8):
    """Images side by side, each enlarged or reduced to a height by the nearest pixels."""
    parts = []
    for image in images:
        scale = height / image.shape[0]
        at = [np.minimum((np.arange(round(n * scale)) + 0.5) / scale, n - 1).astype(int) for n in image.shape[:2]]
        parts += [image[at[0]][:, at[1]], np.full((height, gap, 3), 255, np.uint8)]
    return np.concatenate(parts[:-1], axis=1)


def gray(values, like=None):
    """Brightness between the least and the largest value of a map, or of another one."""
    like = values if like is None else like
    codes = np.clip((values - like.min()) / (like.max() - like.min()), 0, 1) * 255
    return np.repeat(codes.astype(np.uint8)[:, :, None], 3, axis=2)


def program(words):
    """Runs a command."""
    subprocess.run([sys.executable, "-m", "holo", *words.split()], check=True)


def field():
    scene = holo.Scene.gallery("garden")
    result = holo.render(scene, views=(20, 20), lenses=(265, 397), spp=8, disparity=(-1, 1), denoise="views")
    codes = result.light_field.encode()
    raw = codes.elemental_grid()[20 * 132 : 20 * 144, 20 * 216 : 20 * 228]
    images = [
        codes.central,
        raw,
        srgb(result.light_field.refocus(-0.85), result.exposure_ev),
        srgb(result.light_field.refocus(0.5), result.exposure_ev),
        gray(result.disparity),
    ]
    holo.write_image(OUT / "field.png", row(images, 265))


def first():
    """What the commands of the first chapter make."""
    options = dict(views=9, lenses=(80, 120), disparity=(-1, 1), spp=4, denoise="views", layers=["disparity"])
    result = holo.render(holo.Scene.gallery("garden"), **options)
    light_field, truth = result.light_field, result.disparity
    sharp = srgb(light_field.refocus(0.5), result.exposure_ev)
    images = [light_field.encode().central, sharp, gray(light_field.disparity(), truth), gray(truth)]
    holo.write_image(OUT / "first.png", row(images, 160))


def settings():
    """The presets."""
    options = dict(views=9, lenses=(120, 180), disparity=(-1, 1))
    presets = [dict(spp="1/16", denoise="views"), {}, dict(denoise="views", target_error="2%")]
    results = [holo.render(holo.Scene.gallery("garden"), **options, **preset) for preset in presets]
    holo.write_image(OUT / "settings.png", row([result.light_field.encode().central for result in results], 240))


def conventions():
    """A color for every microlens and a brightness for every view, as raw image and as grid of views."""
    v, u, t, s = np.mgrid[0:4, 0:6, 0:3, 0:3]
    color = np.stack([60 + 35 * u, 60 + 50 * v, np.full_like(u, 150)], axis=-1) * (0.6 + 0.05 * (3 * t + s))[..., None]
    samples = holo.LightField(color.astype(np.uint8), axes="vutsc")
    grids = [samples.elemental_grid(), samples.viewpoint_grid()]
    holo.write_image(OUT / "conventions.png", row([grid.repeat(18, axis=0).repeat(18, axis=1) for grid in grids], 216, 40))


def datasets():
    """The contact sheet of a small dataset."""
    with tempfile.TemporaryDirectory() as folder:
        program(f"dataset --out {folder}/data --scenes plaster,chess,garden,tiles --views 20 --sensor 3600x2400 --spp 2 --denoise views")
        sheet = holo.read_image(f"{folder}/data/contact_sheet_20x20.png")
    holo.write_image(OUT / "datasets.png", sheet)


def motion():
    """Frames of a pendulum, and the optical flow of the middle one: red to the right, green downward."""
    scene = holo.Scene.gallery("pendulum")
    options = dict(views=1, lenses=(160, 240), spp=64, integrator="direct")
    frames = [holo.render(scene, frame=frame, **options) for frame in (2, 6, 10)]
    images = [srgb(frame.light_field.central, frames[0].exposure_ev) for frame in frames]
    moved = holo.render(scene, views=1, lenses=(160, 240), frame=6, integrator="depth", layers=["optical-flow"])
    flow = np.nan_to_num(moved.layers["optical-flow"])
    codes = np.full((160, 240, 3), 128, np.uint8)
    codes[..., :2] = 128 + 127 * flow / abs(flow).max()
    holo.write_image(OUT / "motion.png", row([*images, codes], 160))


def others():
    """From a folder of the HCI benchmark to disparity."""
    with tempfile.TemporaryDirectory() as folder:
        options = dict(views=9, lenses=(160, 240), disparity=(-1, 1), spp=16, write=["hci", "disparity"])
        holo.render_to(f"{folder}/scene", holo.Scene.gallery("garden"), **options)
        light_field, truth = holo.open(f"{folder}/scene/hci"), holo.read_image(f"{folder}/scene/scene_disparity.pfm")
    raw = light_field.elemental_grid()[9 * 70 : 9 * 86, 9 * 100 : 9 * 124]
    images = [light_field.central, raw, gray(light_field.disparity(), truth), gray(truth)]
    holo.write_image(OUT / "others.png", row(images, 160))


def plenoptic():
    """The raw image of a camera with hexagonal microlenses, its white image, and a decoded view."""
    text = """
[sensor]
size_px = [960, 720]
pixel_um = 6.0
[mla]
grid = "hex-rows"
pitch_um = 60.0
gap_um = 300.0
focal_um = "pupil"
[main_lens]
focal_mm = 12.0
f_number = 5.0
focus_m = 1.0
"""
    camera = holo.PlenopticCamera.from_toml(text)
    raw = holo.render_raw(holo.Scene.gallery("garden"), camera, spp=32)
    white = camera.white_image()
    part = np.s_[300:380, 440:540]
    view = raw.decode().light_field.encode().central
    images = [srgb(raw.image, 1.0), srgb(raw.image, 1.0)[part], gray(white[part].squeeze()), view]
    holo.write_image(OUT / "plenoptic.png", row(images, 240))


def train():
    """A view, and some of its masks."""
    with tempfile.TemporaryDirectory() as folder:
        options = dict(views=9, lenses=(200, 200), disparity=(-1.5, 1.5), spp=4, denoise="views", write=["vpi", "disparity", "masks"])
        holo.render_to(folder, holo.Scene.gallery("chess"), **options)
        names = ("discontinuity", "occluded", "textureless", "reflective", "fine")
        masks = [holo.read_image(f"{folder}/masks/{name}.png") for name in names]
        view = holo.open(folder).central
    images = [view, *(gray((mask > 0).astype(float)) for mask in masks)]
    holo.write_image(OUT / "train.png", row(images, 200))


def accuracy():
    """One scene by this renderer and by Mitsuba 3, and twenty times their difference around gray."""
    folder = pathlib.Path(__file__).parents[1] / "tests" / "radiance"
    options = dict(views=1, lenses=(66, 99), spp=4096, focus_m=0.8, integrator="path", sky=(0.2, 0.24, 0.32), no_multiple_scattering=True)
    ours = holo.render(holo.Scene.open(folder / "metal_and_glass.glb"), **options).light_field.central
    theirs = holo.read_image(folder / "metal_and_glass_path.pfm")
    codes = [srgb(image, 0.0) for image in (ours, theirs)]
    difference = np.clip(128 + 20.0 * (codes[0].astype(int) - codes[1]), 0, 255).astype(np.uint8)
    holo.write_image(OUT / "accuracy.png", row([*codes, difference], 198))


def noise():
    scene = holo.Scene.gallery("glasses")
    options = dict(lenses=(160, 240), integrator="path")
    plain = holo.render(scene, views=(21, 21), spp=4, disparity=(-1, 1), **options)
    clean = holo.render(scene, views=(21, 21), spp=4, disparity=(-1, 1), denoise="views", **options)
    # The central view alone, with many samples.
    many = holo.render(scene, views=(1, 1), spp=1024, focus_m=plain.rig.focus_distance_m, **options)
    crop = np.s_[54:114, 80:158]
    views = [render.light_field.central for render in (plain, clean, many)]
    holo.write_image(OUT / "noise.png", row([srgb(view[crop], plain.exposure_ev) for view in views], 240))


def glass():
    """Micro-images in the corner of a sensor, behind a thin lens and behind glass."""
    text = """
[sensor]
size_px = [120, 120]
pixel_um = 10.0
offset_um = [13000.0, 8500.0]
[mla]
grid = "hex-rows"
pitch_um = 170.0
gap_um = 330.0
[main_lens]
focus_m = 1.5
"""
    tiles = []
    for lens in ("focal_mm = 50.0\nf_number = 2.03\nexit_pupil_mm = 55.214", 'prescription = "double-gauss"'):
        camera = holo.PlenopticCamera.from_toml(text + lens)
        raw = holo.render_raw(holo.Scene.gallery("chess"), camera, spp=64, integrator="direct", sky=1.0)
        tiles.append(srgb(raw.image, 5.0))
    holo.write_image(OUT / "glass.png", row(tiles, 360))


def array():
    """An array whose cameras deviate: one of them, all focused on the wall and along the ground, and a view between them."""
    scene = holo.Scene.gallery("garden")
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        words = (
            "array plane --count 9x9 --spacing-m 0.05 --radius-m 1.2 --target 0,0.2,0 --size 384x288 --fov-deg 45 --seed 1 "
            "--jitter-position-m 0.01 --jitter-rotation-deg 1 --jitter-focal 0.02 --jitter-gain 0.15 --jitter-color 0.1 --out"
        )
        program(f"{words} {folder / 'array.json'}")
        holo.render_to(folder / "array", scene, transforms=folder / "array.json", spp=16, layers=["depth"], exposure=0.0)
        cameras = holo.CameraArray(folder / "array")
        pose = holo.Pose(eye=(0.02, 0.22, 1.2), target=(0.02, 0.22, 0.0))
        above = holo.Pose(eye=(0.02, 0.35, 1.2), target=(0.02, 0.0, 0.2))
        images = [
            holo.read_image(folder / "array/images/camera_0031.png"),
            srgb(cameras.refocus(distance_m=1.48, pose=pose), 0.0),
            srgb(cameras.refocus(distance_m=1.06, tilt_deg=(0, 70.7), pose=above, aperture="disc:0.3"), 0.0),
            srgb(cameras.synthesize(pose).image, 0.0),
        ]
    holo.write_image(OUT / "array.png", row(images, 288))


def focused():
    """The raw image of a focused camera, a part of it, and the view in the middle."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "r12.toml"
        program(f"camera raytrix-r12-a --out {path}")
        text = path.read_text().replace("size_px = [4080, 3068]", "size_px = [1360, 1024]")
    camera = holo.PlenopticCamera.from_toml(text.replace("mla_distance_mm = 56.6871", "focus_m = 0.85"))
    raw = holo.render_raw(holo.Scene.gallery("dominoes"), camera, spp=16)
    view = raw.decode().light_field.view(2, 2)
    images = [raw.image, raw.image[300:428, 500:670], view]
    holo.write_image(OUT / "focused.png", row([srgb(image, 0.6) for image in images], 300))


def rigs():
    """Rigs at poses: their central views, and the points of the first in the images of the others."""
    scene = holo.Scene.gallery("garden")
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        words = (
            "array plane --count 3x1 --spacing-m 0.2 --radius-m 1.1 --target 0.05,0.15,0 --size 288x216 --fov-deg 34 --seed 2 "
            "--jitter-rotation-deg 3 --out"
        )
        program(f"{words} {folder / 'poses.json'}")
        options = dict(views=3, baseline_m=0.01, focus_m=1.4, spp=32, layers=["depth"], write=["vpi"], exposure=0.0)
        holo.render_to(folder / "rigs", scene, transforms=folder / "poses.json", **options)
        array = holo.CameraArray(folder / "rigs")
        first, *others = array.central
        images = [srgb(array.image(k), 1.0) for k in array.central]
        for other in others:
            found = array.correspondences(first, other)
            at = np.rint(found.places[found.visible]).astype(int)
            drawn = np.zeros_like(images[0])
            drawn[at[:, 0].clip(0, 215), at[:, 1].clip(0, 287)] = images[0][found.visible]
            images.append(drawn)
    holo.write_image(OUT / "rigs.png", row(images, 216))


def display():
    """What an eye sees of a panel behind round lenses, and behind slanted lenticular ones from two places."""
    views, lenses = (21, 21), (214, 380)
    field = holo.render(holo.Scene.gallery("garden"), views=views, lenses=lenses, spp=4, disparity=(-1, 1), denoise="views")
    head = "[panel]\nsize_px = [7680, 4320]\npixel_um = 50.0\nstripes = 'rgb'\n[lenses]\ngap_mm = 3.0\n"
    tail = "[viewer]\ndistance_m = 0.7\n"
    images = []
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "display.toml"
        for lens, x_m in (
            ("grid = 'square'\npitch_mm = 1.01\n", 0.0),
            ("grid = 'lenticular'\nslant_deg = 9.46\npitch_mm = 1.01\n", -0.09),
            ("grid = 'lenticular'\nslant_deg = 9.46\npitch_mm = 1.01\n", 0.09),
        ):
            file.write_text(head + lens + tail)
            shown = holo.Display(file)
            seen = shown.seen_from(shown.panel_image(field.light_field), (x_m, 0.0, 0.7), size=lenses)
            images.append(srgb(seen, field.exposure_ev))
    holo.write_image(OUT / "display.png", row(images, 214))


def depth():
    """Disparity: rendered, estimated from a cross, from six views, and from cameras of an array."""
    scene = holo.Scene.gallery("tiles")
    result = holo.render(scene, views=(9, 9), lenses=(200, 300), spp=16, disparity=(-1, 1), denoise="views")
    field, truth = result.light_field, result.disparity
    maps = [truth] + [field.disparity((-1.1, 1.1), subset=s) for s in ("cross", "4,4;0,0;8,1;1,8;7,7;4,1")]
    images = [gray(map, truth) for map in maps]
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        words = (
            "array plane --count 7x7 --spacing-m 0.013 --radius-m 0.62 --target 0.02,0.1,0 --size 300x200 --fov-deg 40 --seed 3 "
            "--jitter-rotation-deg 1 --jitter-focal 0.02 --out"
        )
        program(f"{words} {folder / 'array.json'}")
        holo.render_to(folder / "array", scene, transforms=folder / "array.json", spp=16, layers=["depth"], exposure=0.0)
        array = holo.CameraArray(folder / "array")
        inverse = [1 / array.depth(24), 1 / array.estimate_depth((0.3, 1.2), "camera_0024").depth]
        images.append(gray(inverse[1], inverse[0]))
    holo.write_image(OUT / "depth.png", row(images, 200))


def orthographic():
    """The central view and elemental images of a perspective rig and of a fly's-eye camera."""
    scene = holo.Scene.gallery("dominoes")
    options = dict(views=(15, 15), lenses=(240, 320), spp=4, denoise="views")
    images = []
    perspective = holo.render(scene, disparity=(-1, 1), **options)
    focus, baseline = perspective.rig.focus_distance_m, perspective.rig.baseline_m
    fly = holo.render(scene, projection="orthographic", focus_m=focus, baseline_m=baseline, **options)
    for result in (perspective, fly):
        codes = result.light_field.encode(exposure=perspective.exposure_ev)
        images += [codes.central, codes.elemental_grid()[15 * 140 : 15 * 150, 15 * 120 : 15 * 133]]
    holo.write_image(OUT / "orthographic.png", row(images, 240))


def generated():
    with tempfile.TemporaryDirectory() as folder:
        options = dict(recipe="mixed", seed=3, views=[3], lenses=(160, 160), spp=48)
        tiles = [job.light_field.central for job in holo.Dataset.generate(pathlib.Path(folder) / "set", count=20, **options)]
    rows = [np.concatenate(tiles[k : k + 5], axis=1) for k in range(0, 20, 5)]
    holo.write_image(OUT / "generated.png", np.concatenate(rows))


if __name__ == "__main__":
    OUT.mkdir(parents=True, exist_ok=True)
    every = (
        field, first, settings, conventions, noise, datasets, motion, others, plenoptic, train, accuracy,
        glass, array, focused, rigs, display, depth, orthographic, generated,
    )
    for make in every:
        if not sys.argv[1:] or make.__name__ in sys.argv[1:]:
            make()
