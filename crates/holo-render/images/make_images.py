"""Renders the images of ../README.md. Needs Python 3.9 with numpy and pillow (10.1 or newer), and the `holo` program.

Usage: make_images.py HOLO [--draft] [NAME ...]

HOLO is the program (target/release/holo). Every image has a function of its name below; without names all are
rendered, in about twenty minutes on one idle core. `--draft` renders with an eighth of the samples. Scenes are built
in a temporary folder with scene.py and arranged by sheet.py; more shapes and file formats are in tests/radiance. The
same program gives the same pixels on every run; another version of pillow may choose other palettes.
"""
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[2] / "tests" / "radiance")]
sys.dont_write_bytecode = True

from files import write_hdr  # noqa: E402
from make_scenes import ball, box, lathe, looking, rectangle, rounded, tiles, torus, turned_y  # noqa: E402
from scene import Scene, uv_ball  # noqa: E402
from sheet import compose, encode, letters, read_pfm  # noqa: E402

HOLO = ""
DRAFT = False
FOLDER = Path()


def run(scene, *flags):
    """Renders a scene into a new folder; returns the folder."""
    folder = Path(tempfile.mkdtemp(dir=FOLDER))
    scene.write(folder / "scene.glb")
    command = [HOLO, "render", folder / "scene.glb", "--out", folder, "--threads", "1", "--quiet", *flags]
    command = [str(part) for part in command]
    done = subprocess.run(command, capture_output=True, text=True)
    said = (done.stdout + done.stderr).strip()
    if done.returncode or said:
        print(" ".join(command), said, sep="\n", file=sys.stderr)
    done.check_returncode()
    return folder


def render(scene, size, samples, *flags, error=0.015):
    """Renders one view to an image with at most `samples` per pixel, fewer where the relative standard error is below
    `error`. By default the exposure is 0 (radiance 1 is white)."""
    samples = max(16, samples // 8) if DRAFT else samples
    flags = flags if "--exposure" in flags else (*flags, "--exposure", 0)
    flags = flags if error is None else (*flags, "--target-error", error)
    folder = run(scene, "--views", 1, "--lenses", f"{size[0]}x{size[1]}", "--spp", samples, "--write", "el", *flags)
    return Image.open(folder / "scene_el.png").convert("RGB")


def directions(height, width):
    """The directions of the texels of an environment map."""
    v, u = (np.arange(height) + 0.5) / height, (np.arange(width) + 0.5) / width
    polar, azimuth = (v * math.pi)[:, None], ((u - 0.5) * 2 * math.pi)[None, :]
    return np.stack(np.broadcast_arrays(np.sin(polar) * np.cos(azimuth), np.cos(polar), np.sin(polar) * np.sin(azimuth)), axis=-1)


def soft_box(direction, towards, half_width, half_height, edge=0.04):
    """1 inside a rectangle that faces the origin from `towards` (half sizes as tangents), 0 outside, soft between."""
    towards = np.array(towards, float) / np.linalg.norm(towards)
    right = np.cross([0, 1, 0], towards)
    right /= np.linalg.norm(right)
    along = np.maximum(direction @ towards, 1e-6)
    x, y = np.abs(direction @ right) / along, np.abs(direction @ np.cross(towards, right)) / along
    inside = np.clip((half_width - x) / edge, 0, 1) * np.clip((half_height - y) / edge, 0, 1)
    return (inside * (direction @ towards > 0))[..., None]


def studio(lamps=1.0):
    """Two lamps before gray walls, as an environment map; returns its path."""
    d = directions(128, 256)
    walls = np.array([0.30, 0.31, 0.33]) * (0.75 + 0.45 * d[..., 1:2])
    shine = 5.5 * soft_box(d, (-1.0, 1.1, 1.0), 0.45, 0.45) + 2.5 * soft_box(d, (1.0, 0.45, 0.55), 0.18, 0.6)
    path = FOLDER / "studio.hdr"
    write_hdr(path, walls + lamps * shine * np.array([1.0, 0.97, 0.92]))
    return path


def board(scene, half=4.0, repeat=4.0, light=(226, 214, 190), dark=(120, 128, 148), y=0.0):
    """A tiled floor."""
    floor = scene.matt(texture=scene.texture(tiles(192, 6, light, dark)))
    scene.add(rectangle([-half, y, half], [2 * half, 0, 0], [0, 0, -2 * half], repeat), floor)


def lights():
    size = (240, 170)

    def still_life(lamp):
        scene = Scene()
        board(scene, 3.0, 1.5)
        stripes = np.array([[(200, 60, 50), (235, 225, 205)][y // 16 % 2] for y in range(128)], np.uint8)[:, None].repeat(8, axis=1)
        scene.add(uv_ball(0.5, 64, 32), scene.matt(texture=scene.texture(stripes)), [-0.55, 0.5, 0.1])
        scene.add(turned_y(box([-0.3, 0, -0.3], [0.3, 1.1, 0.3]), 30), scene.matt((0.35, 0.5, 0.7)), [0.6, 0, -0.3])
        lamp(scene)
        scene.camera([0, 2.1, 4.2], [0, 0.42, 0], 30, size)
        return render(scene, size, 128, "--integrator", "direct", "--sky", "0.1,0.115,0.15")

    spot = {"type": "spot", "intensity": 42.0, "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.3}}
    compose("lights", [[
        (still_life(lambda scene: scene.light({"type": "point", "intensity": 11.0}, translation=[0.1, 1.9, 0.9])), "point"),
        (still_life(lambda scene: scene.light(spot, translation=[-1.8, 3.2, 1.8], rotation=looking([1.8, -2.9, -1.8]))), "spot"),
        (still_life(lambda scene: scene.sun([0.9, -1.0, -0.5], 2.9)), "directional"),
    ]])


def sun():
    size = (240, 170)
    row = []
    for degrees in [0, 0.5, 5]:
        scene = Scene()
        scene.add(rectangle([-4, 0, 4], [8, 0, 0], [0, 0, -8]), scene.matt((0.75, 0.72, 0.66)))
        post = scene.matt((0.7, 0.35, 0.2))
        scene.add(box([-0.05, 0, -0.05], [0.05, 1.3, 0.05]), post, [-0.95, 0, 0.0])
        scene.add(box([-0.05, 1.3, -0.4], [0.05, 1.4, 0.4]), post, [-0.95, 0, 0.0])
        scene.add(ball(0.2, 64, 32), scene.matt((0.3, 0.5, 0.4)), [-0.55, 0.2, 0.75])
        scene.sun([1.0, -0.85, 0.12], 2.6, (1, 0.97, 0.9), degrees)
        scene.camera([0.1, 3.2, 3.9], [-0.1, 0.58, 0.05], 28, size)
        picture = render(scene, size, 256, "--integrator", "direct", "--sky", "0.1,0.13,0.18")
        row.append((picture, "parallel light: 0°" if degrees == 0 else f"{degrees}°" + " (the real sun)" * (degrees == 0.5)))
    compose("sun", [row])


def ball_row(materials, spread=1.12, size=(732, 132), samples=384, shape=None):
    """A row of balls on a board in front of the lamps of the studio."""
    scene = Scene()
    board(scene, 8.0, 8.0, y=-0.5)
    for k, material in enumerate(materials):
        scene.add(shape or ball(0.5, 96, 48), material(scene), [(k - (len(materials) - 1) / 2) * spread, 0, 0])
    scene.camera([0, 2.6, 13], [0, -0.02, 0], 5.9, size)
    return render(scene, size, samples, "--sky", studio())


def metal():
    numbers = [0, 0.2, 0.4, 0.6, 0.8, 1]
    rough = [lambda scene, r=r: scene.material((0.95, 0.68, 0.32), 1.0, r) for r in numbers]
    shares = [lambda scene, m=m: scene.material((0.95, 0.68, 0.32), m, 0.25) for m in numbers]
    compose("metal", [
        [(ball_row(rough), "metallicFactor 1; roughnessFactor " + ", ".join(map(str, numbers)))],
        [(ball_row(shares), "roughnessFactor 0.25; metallicFactor " + ", ".join(map(str, numbers)))],
    ])


def coat():
    numbers = [0, 0.2, 0.4, 0.6, 0.8, 1]
    row = [lambda scene, r=r: scene.material((0.5, 0.04, 0.03), 0.0, r) for r in numbers]
    compose("coat", [[(ball_row(row), "metallicFactor 0; roughnessFactor " + ", ".join(map(str, numbers)))]])


def specular():
    def coat(**extensions):
        return lambda scene: scene.material((0.015, 0.04, 0.12), 0.0, 0.1, extensions=extensions)

    indices = [1, 1.2, 1.33, 1.5, 1.8, 2.4]
    factors = [0, 0.2, 0.4, 0.6, 0.8, 1]
    tints = [(1, 1, 1), (1, 0.04, 0.02), (1, 0.6, 0.02), (0.05, 0.8, 0.1), (0.05, 0.25, 1), (1, 0.05, 0.7)]
    compose("specular", [
        [(ball_row([coat(ior={"ior": n}) for n in indices]), "ior " + ", ".join(map(str, indices)))],
        [(ball_row([coat(specular={"specularFactor": f}) for f in factors]), "specularFactor " + ", ".join(map(str, factors)))],
        [(ball_row([coat(specular={"specularColorFactor": list(c)}, ior={"ior": 2.4}) for c in tints]),
          "ior 2.4; specularColorFactor white, red, yellow, green, blue, magenta")],
    ])


def layers_of(*variants):
    """Materials of `ball_row`: (base color, metallic, roughness, extensions)."""
    return [lambda scene, v=v: scene.material(v[0], v[1], v[2], extensions=v[3]) for v in variants]


def clearcoat():
    numbers = [0, 0.2, 0.4, 0.6, 0.8, 1]
    red, gold = (0.5, 0.04, 0.03), (0.95, 0.68, 0.32)
    factor = layers_of(*((red, 0.0, 0.7, {"clearcoat": {"clearcoatFactor": f}}) for f in numbers))
    rough = layers_of(*((gold, 1.0, 0.5, {"clearcoat": {"clearcoatFactor": 1, "clearcoatRoughnessFactor": r}}) for r in numbers))
    compose("clearcoat", [
        [(ball_row(factor), "roughnessFactor 0.7; clearcoatFactor " + ", ".join(map(str, numbers)))],
        [(ball_row(rough), "metal, roughnessFactor 0.5; clearcoatRoughnessFactor " + ", ".join(map(str, numbers)))],
    ])


def sheen():
    numbers = [0.1, 0.2, 0.4, 0.6, 0.8, 1]
    row = layers_of(*(((0.12, 0.02, 0.1), 0.0, 0.9, {"sheen": {"sheenColorFactor": [0.9, 0.75, 0.9], "sheenRoughnessFactor": r}}) for r in numbers))
    compose("sheen", [[(ball_row(row), "sheenRoughnessFactor " + ", ".join(map(str, numbers)))]])


def anisotropy():
    strengths, degrees = [0, 0.2, 0.4, 0.6, 0.8, 1], [0, 30, 60, 90, 120, 150]
    metal = ((0.8, 0.8, 0.82), 1.0, 0.25)
    first = layers_of(*((*metal, {"anisotropy": {"anisotropyStrength": s}}) for s in strengths))
    second = layers_of(*((*metal, {"anisotropy": {"anisotropyStrength": 0.8, "anisotropyRotation": math.radians(d)}}) for d in degrees))
    compose("anisotropy", [
        [(ball_row(first, shape=uv_ball(0.5, 96, 48)), "anisotropyStrength " + ", ".join(map(str, strengths)))],
        [(ball_row(second, shape=uv_ball(0.5, 96, 48)), "anisotropyStrength 0.8; anisotropyRotation " + ", ".join(map(str, degrees)) + "°")],
    ])


def iridescence():
    sizes = [150, 250, 350, 450, 600, 800]
    film = [{"iridescence": {"iridescenceFactor": 1, "iridescenceIor": 1.33, "iridescenceThicknessMaximum": s}} for s in sizes]
    compose("iridescence", [
        [(ball_row(layers_of(*(((0.02, 0.02, 0.02), 0.0, 0.1, f) for f in film))), "iridescenceIor 1.33; thickness " + ", ".join(map(str, sizes)) + " nm")],
        [(ball_row(layers_of(*(((0.7, 0.7, 0.7), 1.0, 0.2, f) for f in film))), "metal; the same films")],
    ])


def dispersion():
    size = (240, 170)

    def globe(value):
        def fill(scene):
            extensions = {"transmission": {"transmissionFactor": 1.0}, "volume": {"thicknessFactor": 1.0}, "dispersion": {"dispersion": value}}
            scene.add(ball(0.5, 128, 64), scene.material(roughness=0.0, extensions=extensions), [0, 0.502, 0])
        return glass_stage(fill, size, 512)

    compose("dispersion", [[(globe(value), f"dispersion {value}") for value in [0, 0.5, 2]]])


def diffuse_transmission():
    numbers = [0, 0.2, 0.4, 0.6, 0.8, 1]
    size = (732, 132)
    scene = Scene()
    board(scene, 8.0, 8.0, y=-0.5)
    for k, factor in enumerate(numbers):
        through = {"diffuseTransmissionFactor": factor, "diffuseTransmissionColorFactor": [0.9, 0.5, 0.15]}
        leaf = scene.material((0.25, 0.5, 0.12), roughness=0.8, extensions={"diffuse_transmission": through})
        scene.add(rectangle([-0.45, -0.48, 0], [0.9, 0, 0], [0, 0.96, 0]), leaf, [(k - 2.5) * 1.12, 0, 0])
    scene.sun([0.3, -0.8, 1.0], 3.0)
    scene.camera([0, 2.6, 13], [0, -0.02, 0], 5.9, size)
    picture = render(scene, size, 256, "--sky", "0.2,0.22,0.27")
    compose("diffuse_transmission", [[(picture, "lit from behind; diffuseTransmissionFactor " + ", ".join(map(str, numbers)))]])


def glass_stage(fill, size, samples, camera=([0, 0.75, 5.2], [0, 0.62, 0], 19.5)):
    """Letters on a wall behind the objects that `fill` adds to the board."""
    scene = Scene()
    board(scene, 4.0, 4.0)
    wall = Image.new("RGB", (512, 256), (236, 228, 208))
    draw = ImageDraw.Draw(wall)
    draw.rectangle([0, 0, 512, 110], fill=(120, 160, 190))
    draw.text((256, 168), "HOLO", fill=(170, 50, 35), font=ImageFont.load_default(110), anchor="mm")
    scene.add(rectangle([-1.5, 0, -1.5], [3, 0, 0], [0, 1.5, 0], 1.0), scene.matt(texture=scene.texture(wall)))
    fill(scene)
    scene.camera(*camera, size)
    return render(scene, size, samples, "--sky", studio(0.2), "--exposure", 1.0)


def glass():
    size = (240, 170)

    def globe(**glass):
        return glass_stage(lambda scene: scene.add(ball(0.5, 128, 64), scene.glass(**glass), [0, 0.502, 0]), size, 512)

    def pane(roughness):
        shape = rectangle([-0.5, 0, 0], [1, 0, 0], [0, 1.0, 0])
        return glass_stage(lambda scene: scene.add(shape, scene.glass((0.75, 0.93, 0.82), roughness), [0.25, 0.002, -0.3]), size, 512)

    compose("glass", [
        [(pane(0.0), "thin pane, roughness 0"), (pane(0.25), "thin pane, roughness 0.25"), (globe(), "ball with a thin wall")],
        [(globe(volume={}), "volume, ior 1.5"), (globe(volume={}, ior=1.1), "volume, ior 1.1"),
         (globe(volume={}, roughness=0.25), "volume, ior 1.5, roughness 0.25")],
    ])


def absorption():
    size = (363, 190)
    volume = {"attenuationDistance": 0.25, "attenuationColor": [0.85, 0.45, 0.15]}
    depths = [0.1, 0.2, 0.4, 0.8, 1.6]

    def blocks(scene):
        amber = scene.glass(volume=volume)
        for k, depth in enumerate(depths):
            scene.add(box([-0.16, 0, 0], [0.16, 0.8, depth]), amber, [(k - 2) * 0.4, 0.002, -0.9])

    def balls(scene):
        emerald = scene.glass(volume={"attenuationDistance": 0.5, "attenuationColor": [0.25, 0.8, 0.45]})
        for k, radius in enumerate([0.12, 0.2, 0.32, 0.5]):
            scene.add(ball(radius, 96, 48), emerald, [[-1.05, -0.68, -0.1, 0.78][k], radius + 0.002, 0])

    camera = ([0, 0.9, 6.5], [0, 0.5, 0], 13.5)
    compose("absorption", [[
        (glass_stage(blocks, size, 384, camera), "slabs 0.1, 0.2, 0.4, 0.8, 1.6 m thick"),
        (glass_stage(balls, size, 384, camera), "balls of diameter 0.24, 0.4, 0.64, 1 m"),
    ]])


def room(scene, left=(0.7, 0.16, 0.12), right=(0.14, 0.35, 0.65)):
    """A box of 2 x 2 x 2 m without the side towards the camera."""
    white = scene.matt((0.76, 0.75, 0.72))
    scene.add(rectangle([-1, 0, 1], [2, 0, 0], [0, 0, -2]), white)
    scene.add(rectangle([-1, 2, -1], [2, 0, 0], [0, 0, 2]), white)
    scene.add(rectangle([-1, 0, -1], [2, 0, 0], [0, 2, 0]), white)
    scene.add(rectangle([-1, 0, 1], [0, 0, -2], [0, 2, 0]), scene.matt(left))
    scene.add(rectangle([1, 0, -1], [0, 0, 2], [0, 2, 0]), scene.matt(right))
    return white


ROOM_CAMERA = ([0, 1, 5.1], [0, 1, 0], 29.5)


def emission():
    size = (240, 200)

    def lit(lamp, samples):
        scene = Scene()
        white = room(scene, (0.6, 0.58, 0.52), (0.35, 0.45, 0.5))
        scene.add(turned_y(box([-0.28, 0, -0.28], [0.28, 0.9, 0.28]), 20), white, [-0.35, 0, -0.3])
        scene.add(ball(0.3, 64, 32), white, [0.42, 0.3, 0.25])
        lamp(scene)
        scene.camera(*ROOM_CAMERA, size)
        return render(scene, size, samples)

    def panel(double_sided):
        shape = rectangle([-0.45, 1.55, -0.4], [0.9, 0, 0], [0, 0, 0.8])
        return lambda scene: scene.add(shape, scene.glow((1, 0.86, 0.66), 6.0, double_sided=double_sided))

    def ring(scene):
        positions, normals, _, triangles = torus(0.36, 0.045, 64, 16)
        upright = lambda v: v[:, [0, 2, 1]] * [1, -1, 1]
        scene.add((upright(positions), upright(normals), None, triangles), scene.glow((0.55, 0.8, 1), 9.0), [-0.35, 1.4, -0.5])
        sign = letters("open", (256, 128), (255, 120, 30), (0, 0, 0), 100)
        scene.add(rectangle([0.05, 0.85, -0.6], [0.85, 0, 0], [0, 0.42, 0], 1.0), scene.glow((1, 1, 1), 8.0, scene.texture(sign)))

    compose("emission", [[
        (lit(panel(False), 768), "a panel that glows downwards"),
        (lit(panel(True), 768), "the same, doubleSided"),
        (lit(ring, 768), "a ring; a sign (emissiveTexture)"),
    ]])


def evening():
    """A low warm sun in a clear sky over dark ground."""
    d = directions(128, 256)
    up = d[..., 1:2]
    above = np.array([0.95, 0.62, 0.4]) + (np.array([0.16, 0.28, 0.6]) - np.array([0.95, 0.62, 0.4])) * np.sqrt(np.clip(up, 0, 1))
    sky = np.where(up > 0, above * 0.8, np.array([0.14, 0.11, 0.08]))
    sun_at = np.array([-0.8, 0.45, 0.55])
    angle = np.arccos(np.clip(d @ (sun_at / np.linalg.norm(sun_at)), -1, 1))[..., None]
    return sky + np.array([1.0, 0.72, 0.42]) * 22 * np.exp(-0.5 * (angle / math.radians(6.0)) ** 2)


def environment():
    size = (363, 180)
    path = FOLDER / "evening.hdr"
    image = evening()
    write_hdr(path, image)

    def set_of_balls(sky):
        scene = Scene()
        board(scene, 30.0, 30.0)
        made = [scene.material((0.95, 0.95, 0.95), 1.0, 0.0), scene.matt((0.8, 0.8, 0.8)), scene.material((0.06, 0.3, 0.12), 0.0, 0.15),
                scene.material((0.95, 0.62, 0.45), 1.0, 0.35)]
        for k, material in enumerate(made):
            scene.add(ball(0.45, 96, 48), material, [(k - 1.5) * 1.0, 0.45, 0])
        scene.camera([0, 0.75, 8.4], [0, 0.56, 0], 14.4, size)
        return render(scene, size, 384, "--sky", sky)

    compose("environment", [
        [(set_of_balls(path), "--sky evening.hdr: mirror, matt, varnish, copper"), (set_of_balls("0.45,0.5,0.6"), "--sky 0.45,0.5,0.6")],
        [(encode(image * 0.8).resize((732, 150)), "the map: -X at the left edge, -Z at 1/4, +X in the middle, +Z at 3/4 of the width")],
    ])


def leaf():
    """RGBA: a leaf with veins whose alpha fades towards its edge; also green outside, so that no other color bleeds in."""
    size = 256
    y, x = (np.mgrid[0:size, 0:size] + 0.5) / size
    along, across = 1 - y, np.abs(x - 0.5)
    half = 0.42 * np.sin(math.pi * np.clip(along, 0, 1) ** 0.8) ** 0.9
    edge = half - across
    alpha = np.clip(edge / 0.16 + 0.25, 0, 1)
    veins = np.minimum(np.abs((along - across * 1.1) * 9 % 1 - 0.5) * 0.22, across)
    shade = np.clip(veins / 0.012, 0.0, 1.0)[..., None]
    color = np.array([86, 148, 48]) * shade + np.array([168, 196, 110]) * (1 - shade)
    return np.rint(np.concatenate([color, (alpha * 255)[..., None]], axis=-1)).astype(np.uint8)


def alpha():
    size = (240, 190)
    row = []
    for mode, caption in [("OPAQUE", "OPAQUE"), ("MASK", "MASK, alphaCutoff 0.5"), ("BLEND", "BLEND")]:
        scene = Scene()
        scene.add(rectangle([-4, 0, 4], [8, 0, 0], [0, 0, -8]), scene.matt((0.72, 0.7, 0.66)))
        entry = {"alphaMode": mode} | ({"alphaCutoff": 0.5} if mode == "MASK" else {})
        material = scene.matt(texture=scene.texture(leaf()), **entry)
        for angle, lean in [(-50, 0.25), (5, -0.15), (60, 0.2)]:
            a = math.radians(angle)
            right, up = np.array([math.cos(a), -math.sin(a), 0.0]), np.array([math.sin(a), math.cos(a), lean])
            foot = np.array([0.0, 0.45, 0.0])
            scene.add(rectangle(foot - 0.45 * right, 0.9 * right, 1.15 * up, 1.0), material)
        scene.add(box([-0.03, 0, -0.03], [0.03, 0.5, 0.03]), scene.matt((0.35, 0.22, 0.1)))
        scene.sun([0.85, -0.8, -0.55], 2.6)
        scene.camera([0.25, 2.6, 4.4], [0.25, 0.55, -0.1], 28, size)
        row.append((render(scene, size, 256, "--sky", "0.16,0.18,0.22"), caption))
    compose("alpha", [row])


def studs(count, size=512):
    """A normal map of round studs on a plate: flattened half-balls."""
    y, x = (np.mgrid[0:size, 0:size] + 0.5) / size * count % 1 - 0.5
    r = np.hypot(x, y)
    slope = np.where(r < 0.36, 1.4 * (r / 0.36) * np.clip((0.36 - r) / 0.05, 0, 1), 0.0)
    # Right and up in the image; the surface falls away from the middle of a stud.
    normal = np.stack([slope * x / np.maximum(r, 1e-9), -slope * y / np.maximum(r, 1e-9), np.ones_like(x)], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    return np.rint((normal * 0.5 + 0.5) * 255).astype(np.uint8)


def normal_map():
    size = (240, 180)
    row = []
    for scale, caption in [(None, "no normalTexture"), (1.0, "normalTexture, scale 1"), (0.4, "scale 0.4")]:
        scene = Scene()

        def dressed(repeat, **surface):
            entry = {}
            if scale is not None:
                info = {"index": scene.texture(studs(1, 128)), "scale": scale, "extensions": {"KHR_texture_transform": {"scale": repeat}}}
                entry["normalTexture"] = info
            return scene.material(**surface, **entry)

        scene.add(rectangle([-1.6, 0, -0.6], [3.2, 0, 0], [0, 2.0, 0], 1.0), dressed([16, 10], color=(0.7, 0.66, 0.58), roughness=0.7))
        scene.add(rectangle([-1.6, 0, 1.4], [3.2, 0, 0], [0, 0, -2.0], 1.0), scene.matt((0.5, 0.5, 0.52)))
        scene.add(uv_ball(0.55, 96, 48), dressed([20, 10], color=(0.95, 0.7, 0.4), metallic=1.0, roughness=0.3), [0.55, 0.55, 0.1])
        scene.light({"type": "point", "intensity": 3.2}, translation=[-1.1, 1.55, 0.3])
        scene.camera([0, 1.0, 4.4], [0, 0.75, 0], 23, size)
        row.append((render(scene, size, 512, "--sky", "0.18,0.19,0.22", "--no-indirect"), caption))
    compose("normal_map", [row])


def card():
    """A test card: letters on four colored fields."""
    picture = Image.new("RGB", (256, 256))
    draw = ImageDraw.Draw(picture)
    font = ImageFont.load_default(100)
    fields = [("A", (196, 70, 58)), ("B", (222, 178, 70)), ("C", (70, 130, 180)), ("D", (96, 150, 84))]
    for k, (letter, color) in enumerate(fields):
        x, y = k % 2 * 128, k // 2 * 128
        draw.rectangle([x, y, x + 127, y + 127], fill=color)
        draw.text((x + 64, y + 64), letter, fill=(250, 246, 235), font=font, anchor="mm")
    draw.rectangle([0, 0, 255, 255], outline=(30, 30, 30), width=6)
    return picture


def coordinates():
    size = (180, 150)

    def shown(texture, colors=None, second=None):
        scene = Scene()
        used = {} if texture is None else {"texture": {"index": scene.texture(card()), **texture}}
        scene.add(rectangle([-0.5, 0, 0], [1, 0, 0], [0, 1, 0], 1.0), scene.matt(**used), second=second, colors=colors)
        scene.add(rectangle([-3, 0, 2], [6, 0, 0], [0, 0, -4]), scene.matt((0.5, 0.5, 0.5)))
        scene.sun([0.3, -0.6, -1.0], 2.4)
        scene.sun([-0.7, -1.0, -0.6], 0.9)
        scene.camera([0.35, 0.9, 3.4], [0, 0.46, 0], 22.5, size)
        return render(scene, size, 128, "--integrator", "direct", "--sky", "0.03,0.03,0.03")

    def transform(**values):
        return {"extensions": {"KHR_texture_transform": values}}

    tinted = [[0.9, 0.9, 0.9, 1], [0.8, 0.02, 0.01, 1], [0.9, 0.6, 0.03, 1], [0.02, 0.1, 0.7, 1]]
    # Mirrored, and only the upper half of the card.
    other = [[1, 0.5], [0, 0.5], [0, 0], [1, 0]]
    compose("coordinates", [
        [(shown({}), "TEXCOORD_0"), (shown(transform(scale=[3, 2])), "scale 3, 2"),
         (shown(transform(offset=[0.5, 0])), "offset 0.5, 0"), (shown(transform(rotation=math.radians(30))), "rotation 30°")],
        [(shown({"texCoord": 1}, second=other), "texCoord 1: other UVs"), (shown({"texCoord": 1} | transform(scale=[2, 2]), second=other), "texCoord 1 and scale 2"),
         (shown(None, tinted), "COLOR_0"), (shown({}, tinted), "texture times COLOR_0")],
    ])


def indirect():
    size = (240, 200)
    row = []
    # No target error: it would treat pixels as black whose first samples are, at the border of lamp and ceiling.
    for flags, samples, error, caption in [
        (["--integrator", "direct"], 128, None, "--integrator direct"),
        (["--no-indirect"], 128, None, "--no-indirect"),
        ([], 1024, 0.015, "the default: path"),
    ]:
        scene = Scene()
        white = room(scene)
        scene.add(turned_y(box([-0.28, 0, -0.28], [0.28, 1.1, 0.28]), 20), white, [-0.4, 0, -0.35])
        scene.add(ball(0.36, 96, 48), scene.material((0.93, 0.93, 0.93), 1.0, 0.0), [0.42, 0.36, 0.2])
        scene.add(rectangle([-0.6, 1.99, -0.6], [1.2, 0, 0], [0, 0, 1.2]), scene.glow((1, 0.92, 0.8), 3.2))
        scene.camera(*ROOM_CAMERA, size)
        row.append((render(scene, size, samples, *flags, error=error), caption))
    compose("indirect", [row])


def unlit():
    size = (240, 170)
    row = []
    for shown, caption in [(False, "a lit card"), (True, "KHR_materials_unlit")]:
        scene = Scene()
        board(scene, 3.0, 1.5)
        texture = scene.texture(card())
        material = scene.material(texture=texture, extensions={"unlit": {}}) if shown else scene.matt(texture=texture)
        scene.add(turned_y(rectangle([-0.5, 0, 0], [1, 0, 0], [0, 1, 0], 1.0), -15), material, [0.25, 0.01, -0.1])
        scene.add(ball(0.33, 64, 32), scene.matt((0.8, 0.8, 0.78)), [-0.55, 0.33, 0.35])
        scene.sun([1.0, -0.75, -0.75], 2.4)
        scene.camera([-0.1, 1.5, 4.4], [0.1, 0.43, 0], 23, size)
        row.append((render(scene, size, 256, "--sky", "0.1,0.12,0.15"), caption))
    compose("unlit", [row])


def toys(size):
    """Objects of several materials under a constant sky."""
    scene = Scene()
    floor = scene.matt(texture=scene.texture(tiles(192, 6, (226, 214, 190), (120, 128, 148))))
    scene.add(rectangle([-2.2, 0, 1.6], [4.4, 0, 0], [0, 0, -3.6], 1.2), floor)
    scene.add(ball(0.5, 24, 12), scene.material((0.7, 0.07, 0.05), 0.0, 0.2), [-0.75, 0.5, 0.1])
    blue = scene.matt((0.2, 0.35, 0.75))
    scene.add(turned_y(box([-0.3, 0, -0.3], [0.3, 0.9, 0.3]), 35), blue, [0.35, 0, -0.6])
    scene.add(box([-0.25, 0, -0.25], [0.25, 0.35, 0.25]), blue, [0.35, 0, 0.65])
    vase = rounded([(0, 0), (0.2, 0.02), (0.32, 0.25), (0.16, 0.62), (0.12, 0.8), (0.2, 0.95), (0, 1.0)], 6)
    scene.add(lathe(vase, 48), scene.material((0.95, 0.68, 0.32), 1.0, 0.25), [1.2, 0, 0])
    scene.sun([0.6, -1.0, -0.5], 2.4, degrees=0.5)
    scene.camera([0, 1.7, 4.4], [0.1, 0.5, 0], 26, size)
    return scene


def layers():
    size = (180, 130)
    names = "color,depth,ray-length,disparity,geometric-normal,shading-normal,albedo,object-id,material-id,hit-mask"
    samples = 64 if DRAFT else 512
    # The second of two views at a baseline of 20 mm is the central one.
    folder = run(toys(size), "--views", 2, "--lenses", f"{size[0]}x{size[1]}", "--spp", samples, "--baseline-m", 0.02, "--layers", names, "--sky", "0.5,0.6,0.75", "--no-indirect")
    layer = {name: read_pfm(folder / f"scene_{name.replace('-', '_')}.pfm") for name in names.split(",")}
    seen = layer["hit-mask"][..., 0] > 0

    def gray(values, near_bright):
        low, high = values[seen].min(), values[seen].max()
        part = (values - low) / (high - low)
        part = np.where(seen[..., None], 0.1 + 0.9 * (1 - part if near_bright else part), 0.0)
        return Image.fromarray(np.rint(part * 255).astype(np.uint8).repeat(3, axis=-1))

    def numbers(values):
        palette = np.array([(0, 0, 0), (150, 150, 150), (214, 80, 60), (70, 120, 200), (120, 190, 230), (230, 180, 70), (110, 170, 90)], np.uint8)
        return Image.fromarray(palette[values[..., 0].astype(int)])

    def normal(values):
        return Image.fromarray(np.rint(np.where(seen[..., None], values * 0.5 + 0.5, 0.0) * 255).astype(np.uint8))

    compose("layers", [
        [(encode(layer["color"]), "color"), (gray(layer["depth"], True), "depth"), (gray(layer["ray-length"], True), "ray-length"),
         (gray(layer["disparity"], False), "disparity"), (encode(layer["albedo"]), "albedo")],
        [(normal(layer["geometric-normal"]), "geometric-normal"), (normal(layer["shading-normal"]), "shading-normal"),
         (numbers(layer["object-id"]), "object-id"), (numbers(layer["material-id"]), "material-id"),
         (Image.fromarray((seen[..., None] * np.full(3, 255)).astype(np.uint8)), "hit-mask")],
    ])


def projection():
    lenses = (120, 85)
    rows = [[], []]
    for kind in ["perspective", "orthographic"]:
        scene = Scene()
        board(scene, 6.0, 6.0)
        colors = [(0.75, 0.3, 0.2), (0.85, 0.65, 0.25), (0.35, 0.55, 0.3), (0.25, 0.45, 0.7)]
        stuff = [scene.matt(color) for color in colors]
        for k in range(4):
            for x in (-0.75, 0.75):
                scene.add(box([-0.14, 0, -0.14], [0.14, 1.3, 0.14]), stuff[k], [x, 0, 0.9 - 1.3 * k])
        scene.sun([0.5, -1.0, -0.4], 2.6)
        scene.camera([0, 1.9, 5.0], [0, 0.6, 0], 28, lenses)
        flags = ["--sky", "0.35,0.4,0.5", "--projection", kind, "--focus-m", 4.6, "--integrator", "direct"]
        size = (363, 257)
        rows[0].append((render(scene, size, 128, *flags), f"one view, {kind}"))
        # Magnified by nearest neighbor, so that the pixels of the raw image are visible.
        folder = run(scene, "--views", 15, "--lenses", f"{lenses[0]}x{lenses[1]}", "--spp", 16, "--baseline-m", 0.03, "--write", "el", "--exposure", 0, *flags)
        raw = Image.open(folder / "scene_el.png").convert("RGB")
        column, row = (27, 13) if kind == "perspective" else (31, 18)
        crop = raw.crop((15 * column, 15 * row, 15 * (column + 12), 15 * (row + 8)))
        rows[1].append((crop.resize((360, 240), Image.Resampling.NEAREST), "raw image: 12 x 8 lenses of 15 x 15 views"))
    compose("projection", rows)


def instances():
    size = (732, 250)
    scene = Scene()
    rng = np.random.default_rng(5)

    def ground(x, z):
        return 0.5 * np.sin(0.35 * x + 0.6) * np.cos(0.3 * z) + 0.02 * z

    steps = 120
    x, z = np.meshgrid(np.linspace(-22, 22, steps + 1), np.linspace(-36, 6, steps + 1))
    positions = np.stack([x, ground(x, z), z], axis=-1).reshape(-1, 3)
    corner = (np.arange(steps)[:, None] * (steps + 1) + np.arange(steps)).ravel()
    triangles = np.concatenate([np.stack([corner, corner + steps + 1, corner + steps + 2], 1), np.stack([corner, corner + steps + 2, corner + 1], 1)])
    scene.add((positions, None, None, triangles), scene.matt((0.16, 0.2, 0.07)))

    petals = [scene.matt(color) for color in [(0.85, 0.12, 0.1), (0.9, 0.6, 0.1), (0.75, 0.7, 0.85), (0.35, 0.2, 0.6)]]
    green = scene.matt((0.14, 0.32, 0.08))
    heart = scene.matt((0.5, 0.36, 0.05))

    def petal_ring(count):
        """Petals around the y axis, curved, of 8 x 4 cells each."""
        s, t = np.meshgrid(np.linspace(0, 1, 9), np.linspace(-1, 1, 5), indexing="ij")
        along, across = 0.06 + 0.3 * s, 0.12 * np.sqrt(np.clip(np.sin(math.pi * (0.08 + 0.9 * s)), 0, 1)) * t
        height = 0.09 * np.sin(2.0 * s) - 0.05 * t * t
        index = (np.arange(8)[:, None] * 5 + np.arange(4)).ravel()
        cells = np.concatenate([np.stack([index, index + 5, index + 6], 1), np.stack([index, index + 6, index + 1], 1)])
        points, faces = [], []
        for k in range(count):
            a = 2 * math.pi * k / count
            c, sn = math.cos(a), math.sin(a)
            faces.append(cells + 45 * k)
            points.append(np.stack([along * c - across * sn, 0.62 + height, along * sn + across * c], axis=-1).reshape(-1, 3))
        return np.concatenate(points), None, None, np.concatenate(faces)

    stem = lathe(np.array([(0.018, 0.0), (0.014, 0.3), (0.012, 0.62), (0.0, 0.63)]), 8)
    leaf_shape = (np.array([[0, 0.05, 0], [0.2, 0.28, 0.05], [0.34, 0.22, 0.0], [0.2, 0.26, -0.05], [-0.2, 0.33, 0.05], [-0.36, 0.3, 0.0], [-0.2, 0.31, -0.05]]),
                  None, None, np.array([[0, 1, 2], [0, 2, 3], [0, 5, 4], [0, 6, 5]]))
    parts = [(stem, green), (leaf_shape, green), (tuple(a if a is None or k > 1 else a + np.array([0, 0.64, 0]) * (k == 0) for k, a in enumerate(ball(0.09, 16, 8))), heart)]
    flowers = []
    for petal in petals:
        primitives = []
        for shape, material in [*parts, (petal_ring(9), petal)]:
            mesh = scene.mesh(shape, material)
            primitives += scene.glb.document["meshes"].pop(mesh)["primitives"]
        flowers.append(scene.glb.append("meshes", {"primitives": primitives}))
    each = sum(len(shape[3]) for shape, _ in parts) + len(petal_ring(9)[3])

    count = 40_000
    places = np.stack([rng.uniform(-21, 21, count), rng.uniform(-35, 3.2, count)], axis=1)
    # Each kind of flower grows in patches.
    patch = np.sin(0.7 * places[:, 0] + 1.3 * np.sin(0.5 * places[:, 1])) + 0.8 * np.sin(0.9 * places[:, 1] + 1.0) + rng.normal(0, 0.35, count)
    kinds = np.digitize(patch, [-0.7, 0.1, 0.9])
    for (x, z), kind in zip(places, kinds):
        turn, tilt, scale = rng.uniform(0, math.pi), rng.normal(0, 0.1), rng.uniform(0.7, 1.25)
        quaternion = [math.sin(tilt) * math.cos(turn), math.sin(turn) * math.cos(tilt), math.sin(tilt) * -math.sin(turn), math.cos(turn) * math.cos(tilt)]
        scene.place(flowers[kind], [x, ground(x, z), z], rotation=quaternion, scale=[scale] * 3)
    scene.sun([0.7, -0.75, -0.45], 2.0, (1, 0.95, 0.85), degrees=0.5)
    scene.camera([0, 2.3, 7.6], [0, 0.6, -1.2], 19, size)
    caption = f"{count:,} flowers of {each:,} triangles: {count * each / 1e6:.1f} million in the world, {4 * each:,} in the file"
    compose("instances", [[(render(scene, size, 64, "--integrator", "direct", "--sky", "0.36,0.45,0.58", "--exposure", 0.4), caption)]])


PICTURES = [lights, sun, metal, coat, specular, clearcoat, sheen, anisotropy, iridescence, glass, dispersion, absorption, diffuse_transmission, emission, environment, alpha, normal_map, coordinates, indirect, unlit, layers, projection, instances]


def main():
    global HOLO, DRAFT, FOLDER
    arguments = [a for a in sys.argv[1:] if a != "--draft"]
    DRAFT = len(arguments) < len(sys.argv) - 1
    names = [picture.__name__ for picture in PICTURES]
    if not arguments or any(name not in names for name in arguments[1:]):
        sys.exit(f"{__doc__}\nNames: {', '.join(names)}")
    HOLO = arguments[0]
    with tempfile.TemporaryDirectory() as folder:
        FOLDER = Path(folder)
        for picture in PICTURES:
            if not arguments[1:] or picture.__name__ in arguments[1:]:
                picture()


if __name__ == "__main__":
    main()
