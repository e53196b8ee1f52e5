"""Renders three scenes with Blender's Cycles, as folders of the HCI benchmark: images of another renderer to test networks on.

    pip install bpy==4.2.0
    python cycles_scenes.py OUT [--side 192] [--samples 64]

The truth is cast by Blender too: `gt_disp_lowres.pfm` of the central view, in px between neighboring views, larger where nearer.
"""

import argparse
import math
import pathlib
import random

import bpy
import numpy as np
from mathutils import Vector

VIEWS = 9
# The camera sees this far to each side, per meter of depth.
HALF_WIDTH = math.tan(math.radians(20))


def material(name, kind, scale, colors, roughness=0.6, metallic=0.0):
    """A procedural texture between two colors on a principled surface."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    surface = nodes["Principled BSDF"]
    surface.inputs["Roughness"].default_value, surface.inputs["Metallic"].default_value = roughness, metallic
    place, texture, ramp = (nodes.new(f"ShaderNode{what}") for what in ("TexCoord", f"Tex{kind}", "ValToRGB"))
    links.new(place.outputs["Object"], texture.inputs["Vector"])
    texture.inputs["Scale"].default_value = scale
    links.new(texture.outputs["Color" if kind == "Brick" else 0], ramp.inputs["Fac"])
    for element, color in zip(ramp.color_ramp.elements, colors):
        element.color = (*color, 1)
    ramp.color_ramp.elements[0].position, ramp.color_ramp.elements[1].position = 0.3, 0.7
    links.new(ramp.outputs["Color"], surface.inputs["Base Color"])
    return made


def put(add, surface, place, turn=(0, 0, 0), size=(1, 1, 1), smooth=False, **options):
    add(location=place, rotation=[math.radians(angle) for angle in turn], **options)
    made = bpy.context.object
    made.scale = size
    made.data.materials.append(surface)
    if smooth:
        bpy.ops.object.shade_smooth()
    return made


def light(kind, place, power, size=1.0, color=(1, 1, 1)):
    bpy.ops.object.light_add(type=kind, location=place)
    lamp = bpy.context.object
    lamp.data.energy, lamp.data.color = power, color
    if kind == "AREA":
        lamp.data.size = size
    lamp.rotation_euler = (Vector((0, 0, -3)) - Vector(place)).to_track_quat("-Z", "Y").to_euler()


mesh = bpy.ops.mesh


def heads():
    """Monkeys and beveled blocks before a wall of bricks."""
    wall = material("wall", "Brick", 4, [(0.5, 0.2, 0.1), (0.8, 0.7, 0.6)])
    put(mesh.primitive_plane_add, wall, (0, 0, -4.2), (0, 12, 0), size=(3, 3, 1))
    put(mesh.primitive_plane_add, material("floor", "Noise", 9, [(0.05, 0.1, 0.05), (0.6, 0.5, 0.3)]), (0, -0.9, -3), (-82, 0, 0), size=(3, 3, 1))
    for k, (x, z) in enumerate([(-0.7, -2.9), (0.1, -2.4), (0.75, -3.3)]):
        skin = material(f"skin {k}", ("Noise", "Voronoi", "Wave")[k], (12, 8, 3)[k], [(0.1, 0.1, 0.3 * k), (0.9, 0.6, 0.4)], 0.35)
        head = put(mesh.primitive_monkey_add, skin, (x, -0.25 + 0.25 * k, z), (-90 - 10 * k, 25 * k - 20, 10 * k), size=(0.38, 0.38, 0.38), smooth=True)
        head.modifiers.new("fine", "SUBSURF").render_levels = 2
        head.modifiers["fine"].levels = 2
        block = put(mesh.primitive_cube_add, wall, (0.9 * x + 0.3, -0.75, z + 0.3), (0, 30 * k + 10, 0), size=(0.2, 0.2, 0.2))
        block.modifiers.new("round", "BEVEL").width = 0.05
    light("AREA", (-2, 3, 0), 150, 2)
    light("POINT", (2, 1, -1), 60, color=(1, 0.8, 0.6))


def lattice():
    """Slanted planes behind bars and rings."""
    draw = random.Random(5)
    for k in range(4):
        kind = ("Voronoi", "Noise", "Checker", "Wave")[k]
        surface = material(f"plane {k}", kind, (7, 20, 11, 2)[k], [[draw.random() for _ in range(3)] for _ in range(2)])
        put(mesh.primitive_plane_add, surface, (-1.2 + 0.8 * k, 0.2, -3.6), (0, -55 + 35 * k, 8 * k), size=(0.9, 2, 1))
    put(mesh.primitive_plane_add, material("back", "Noise", 5, [(0.1, 0.2, 0.4), (0.7, 0.8, 0.9)]), (0, 0, -4.6), size=(4, 4, 1))
    bar = material("bar", "Noise", 25, [(0.15, 0.1, 0.05), (0.7, 0.6, 0.5)], 0.3, 0.4)
    for k in range(9):
        place = (-0.8 + 0.2 * k, 0, -2.3 - 0.05 * k)
        put(mesh.primitive_cylinder_add, bar, place, (90, 0, 12 * (k % 3 - 1)), radius=0.012 + 0.004 * (k % 3), depth=2.2)
    for k in range(3):
        ring = material(f"ring {k}", "Voronoi", 15, [(0.8, 0.2 * k, 0.1), (0.1, 0.3, 0.2)])
        put(mesh.primitive_torus_add, ring, (-0.5 + 0.5 * k, 0.4 - 0.4 * k, -2.8), (30 * k, 40, 0), major_radius=0.25, minor_radius=0.05)
    light("SUN", (1, 3, 2), 3)
    light("AREA", (-2, 0, -1), 40, 1, (0.7, 0.8, 1))


def pebbles():
    """Displaced balls, some of them glossy, on a hill."""
    draw = random.Random(9)
    ground = material("ground", "Noise", 6, [(0.2, 0.12, 0.05), (0.5, 0.6, 0.2)])
    put(mesh.primitive_plane_add, ground, (0, -0.6, -3.2), (-60, 0, 0), size=(4, 4, 1))
    relief = bpy.data.textures.new("relief", "CLOUDS")
    relief.noise_scale = 0.5
    for k in range(24):
        kind = draw.choice(("Noise", "Voronoi", "Wave", "Magic"))
        surface = material(f"pebble {k}", kind, draw.uniform(2, 14), [[draw.random() for _ in range(3)] for _ in range(2)], draw.choice((0.8, 0.5, 0.15)))
        row, size = k // 6, draw.uniform(0.12, 0.3)
        z = -2.2 - 0.5 * row
        place = ((k % 6 - 2.5) * 0.42 + draw.uniform(-0.1, 0.1), -0.55 + 0.33 * row + draw.uniform(0, 0.12), z)
        ball = put(mesh.primitive_ico_sphere_add, surface, place, [draw.uniform(0, 360) for _ in range(3)], size=(size, size, size), smooth=True, subdivisions=5)
        rough = ball.modifiers.new("rough", "DISPLACE")
        rough.texture, rough.strength = relief, draw.uniform(0, 0.5)
    light("SUN", (-2, 4, 1), 2.5, color=(1, 0.9, 0.8))
    bpy.context.scene.world.node_tree.nodes["Background"].inputs[1].default_value = 0.6


def empty(side, samples):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = samples, False, False
    scene.render.resolution_x = scene.render.resolution_y = side
    scene.render.filter_size = 1.0
    scene.view_settings.view_transform = "Standard"
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs[1].default_value = 0.3
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    camera.data.sensor_width, camera.data.lens = 2 * HALF_WIDTH * 50, 50
    scene.camera = camera
    return scene, camera


def depths(scene, side):
    """The depth of every pixel of the central view, by rays through pixel centers."""
    graph = bpy.context.evaluated_depsgraph_get()
    out = np.full((side, side), np.inf)
    for v in range(side):
        for u in range(side):
            x, y = ((2 * (u + 0.5) / side - 1) * HALF_WIDTH, (1 - 2 * (v + 0.5) / side) * HALF_WIDTH)
            hit, place, *_ = scene.ray_cast(graph, Vector((0, 0, 0)), Vector((x, y, -1)).normalized())
            out[v, u] = -place.z if hit else np.inf
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--side", type=int, default=192)
    parser.add_argument("--samples", type=int, default=24)
    options = parser.parse_args()
    for build in (heads, lattice, pebbles):
        folder = options.out / build.__name__
        folder.mkdir(parents=True, exist_ok=True)
        scene, camera = empty(options.side, options.samples)
        build()
        depth = depths(scene, options.side)
        near, far = (1 / np.percentile(depth[np.isfinite(depth)], share) for share in (1, 99))
        # Disparities from -1.5 to 1.5 px: they grow by `per` times the inverse depth.
        per, focus = 3 / (near - far), (near + far) / 2
        baseline = per * 2 * HALF_WIDTH / options.side
        disparity = (per * (1 / depth - focus)).astype("<f4")
        with open(folder / "gt_disp_lowres.pfm", "wb") as file:
            file.write(f"Pf\n{options.side} {options.side}\n-1\n".encode() + disparity[::-1].tobytes())
        for k in range(VIEWS * VIEWS):
            t, s = k // VIEWS - VIEWS // 2, k % VIEWS - VIEWS // 2
            camera.location = (s * baseline, -t * baseline, 0)
            # What lies in the plane of focus stays where it is.
            camera.data.shift_x, camera.data.shift_y = (step * baseline * focus / (2 * HALF_WIDTH) for step in (-s, t))
            scene.cycles.seed = k
            scene.render.filepath = str((folder / f"input_Cam{k:03}.png").resolve())
            bpy.ops.render.render(write_still=True)
        print(build.__name__, disparity.min(), disparity.max())


if __name__ == "__main__":
    main()
