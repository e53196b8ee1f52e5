"""Where Blender shows the texels of an equirectangular world texture.

Run with a Python that has `bpy` (Blender 5.0). The image holds its own coordinates: red = cos(2 pi u), green =
sin(2 pi u), blue = v, with u from the left edge and v from the top edge, so that whatever is rendered says which place
of the image it came from. A camera with a very narrow angle looks along directions of the glTF frame; glTF (x, y, z) is
Blender (x, -z, y).
Expected is u = 1/2 + atan2(z, x) / (2 pi), v = acos(y) / pi in glTF coordinates: no further rotation.

Blender 5.0.1 (Cycles, CPU) printed:

glTF (1, 0, 0)     expected u 0.5000 v 0.5000   Blender u 0.5000 v 0.5000
glTF (-1, 0, 0)    expected u 0.0000 v 0.5000   Blender u 0.0000 v 0.5000
glTF (0, 0, 1)     expected u 0.7500 v 0.5000   Blender u 0.7500 v 0.5000
glTF (0, 0, -1)    expected u 0.2500 v 0.5000   Blender u 0.2500 v 0.5000
glTF (0.01, 1, 0)  expected u 0.5000 v 0.0032   Blender u 0.5001 v 0.0032
glTF (0, -1, 0.01) expected u 0.7500 v 0.9968   Blender u 0.7500 v 0.9968
glTF (1, 2, 3)     expected u 0.6988 v 0.3205   Blender u 0.6988 v 0.3205
glTF (-2, 1, 3)    expected u 0.8436 v 0.4139   Blender u 0.8436 v 0.4139
glTF (-3, -1, -1)  expected u 0.0512 v 0.5975   Blender u 0.0512 v 0.5975
glTF (2, -3, -1)   expected u 0.4262 v 0.7961   Blender u 0.4262 v 0.7961
largest deviation 0.00008; a texel is 0.00195 high
"""

import math
import os
import sys
import tempfile

import bpy
import numpy as np
from mathutils import Vector

WIDTH, HEIGHT = 1024, 512


def write_image(path):
    u = (np.arange(WIDTH) + 0.5) / WIDTH
    v = (np.arange(HEIGHT) + 0.5) / HEIGHT
    texels = np.ones((HEIGHT, WIDTH, 4), np.float32)
    texels[..., 0] = np.cos(2 * np.pi * u)
    texels[..., 1] = np.sin(2 * np.pi * u)
    texels[..., 2] = v[:, None]
    image = bpy.data.images.new("coordinates", WIDTH, HEIGHT, float_buffer=True, alpha=False)
    # Without this Blender writes sRGB codes.
    image.colorspace_settings.name = "Non-Color"
    # Blender counts rows from the bottom.
    image.pixels.foreach_set(texels[::-1].ravel())
    image.filepath_raw = path
    image.file_format = "OPEN_EXR"
    image.save()
    bpy.data.images.remove(image)


def surround(path):
    world = bpy.data.worlds.new("world")
    bpy.context.scene.world = world
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    texture = nodes.new("ShaderNodeTexEnvironment")
    texture.image = bpy.data.images.load(path)
    texture.image.colorspace_settings.name = "Non-Color"
    background = nodes.new("ShaderNodeBackground")
    output = nodes.new("ShaderNodeOutputWorld")
    links.new(texture.outputs["Color"], background.inputs["Color"])
    links.new(background.outputs["Background"], output.inputs["Surface"])


def look(direction, folder):
    """The mean radiance of 4 x 4 pixels along a direction of the glTF frame."""
    x, y, z = direction
    scene = bpy.context.scene
    scene.camera.rotation_euler = Vector((x, -z, y)).to_track_quat("-Z", "Y").to_euler()
    scene.render.filepath = os.path.join(folder, "seen.exr")
    bpy.ops.render.render(write_still=True)
    seen = bpy.data.images.load(scene.render.filepath)
    pixels = np.array(seen.pixels[:], np.float64).reshape(-1, 4)
    bpy.data.images.remove(seen)
    return pixels[:, :3].mean(axis=0)


def main():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 1
    scene.cycles.use_denoising = False
    scene.render.resolution_x = scene.render.resolution_y = 4
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    camera = bpy.data.cameras.new("camera")
    camera.angle = math.radians(0.01)
    scene.camera = bpy.data.objects.new("camera", camera)
    scene.collection.objects.link(scene.camera)

    # Exactly at a pole Blender mixes the top row with the bottom one: its bilinear filter goes around vertically too.
    directions = [(1, 0, 0), (-1, 0, 0), (0, 0, 1), (0, 0, -1), (0.01, 1, 0), (0, -1, 0.01)]
    directions += [(1, 2, 3), (-2, 1, 3), (-3, -1, -1), (2, -3, -1)]
    worst = 0.0
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "coordinates.exr")
        write_image(path)
        surround(path)
        for direction in directions:
            x, y, z = (c / math.hypot(*direction) for c in direction)
            u, v = 0.5 + math.atan2(z, x) / (2 * math.pi), math.acos(y) / math.pi
            red, green, blue = look(direction, folder)
            seen_u = math.atan2(green, red) / (2 * math.pi) % 1.0
            line = f"glTF {direction!s:13} expected u {u % 1.0:.4f} v {v:.4f}   Blender u {seen_u:.4f} v {blue:.4f}"
            around = abs(seen_u - u) % 1.0
            worst = max(worst, min(around, 1.0 - around), abs(blue - v))
            print(line)
    print(f"largest deviation {worst:.5f}; a texel is {1 / HEIGHT:.5f} high")
    return 0 if worst < 1.0 / HEIGHT else 1


if __name__ == "__main__":
    sys.exit(main())
