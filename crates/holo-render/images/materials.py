"""The images of materials: metal, coats, layers, glass."""
import math

from PIL import Image, ImageDraw, ImageFont

from make_scenes import ball, box, rectangle
from scene import Scene, uv_ball
from sheet import compose
from stage import ball_row, board, render, studio

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
