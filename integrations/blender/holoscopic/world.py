# SPDX-License-Identifier: GPL-3.0-or-later
"""The light of the world, as the option `--sky` of `holo`: a color, or an image of all directions."""

import math

import bpy

# Size of the image of a world that is more than a color, px.
WIDTH = 2048


def sky(context, folder):
    """The value of `--sky`. A world with textures is rendered into `folder` by Cycles, so that every node counts."""
    world = context.scene.world
    if world is None:
        return "0"
    color = _plain_color(world)
    if color is not None:
        return ",".join(f"{x:.9g}" for x in color)
    path = folder / "world.exr"
    _bake(context, world, path)
    return str(path)


def _plain_color(world):
    """The radiance of a world of one color; None if it depends on the direction."""
    if not world.use_nodes or world.node_tree is None:
        return tuple(world.color)
    output = world.node_tree.get_output_node("CYCLES") or world.node_tree.get_output_node("ALL")
    if output is None or not output.inputs["Surface"].is_linked:
        return (0.0, 0.0, 0.0)
    shader = output.inputs["Surface"].links[0].from_node
    if shader.type != "BACKGROUND":
        return None
    color, strength = shader.inputs["Color"], shader.inputs["Strength"]
    if color.is_linked or strength.is_linked:
        return None
    return tuple(x * strength.default_value for x in color.default_value[:3])


def _bake(context, world, path):
    """Renders a panorama of the world alone, in linear light."""
    scene = bpy.data.scenes.new("holoscopic world")
    camera = bpy.data.cameras.new("holoscopic world")
    item = bpy.data.objects.new("holoscopic world", camera)
    try:
        scene.world = world
        scene.collection.objects.link(item)
        scene.camera = item
        camera.type = "PANO"
        # Since Blender 5.0 the camera has what was of Cycles.
        owner = camera if hasattr(camera, "panorama_type") else camera.cycles
        owner.panorama_type = "EQUIRECTANGULAR"
        # Level, and so that the center of the image is the center of an environment texture.
        item.rotation_euler = (math.pi / 2, 0.0, -math.pi / 2)
        render = scene.render
        render.engine = "CYCLES"
        render.resolution_x, render.resolution_y, render.resolution_percentage = WIDTH, WIDTH // 2, 100
        render.film_transparent = False
        render.use_compositing = render.use_sequencer = False
        render.filepath = str(path)
        render.image_settings.file_format = "OPEN_EXR"
        render.image_settings.color_depth = "32"
        render.image_settings.color_mode = "RGB"
        scene.cycles.samples = 4
        scene.cycles.use_denoising = False
        scene.cycles.use_adaptive_sampling = False
        scene.cycles.pixel_filter_type = "BOX"
        bpy.ops.render.render(write_still=True, scene=scene.name)
    finally:
        bpy.data.objects.remove(item)
        bpy.data.cameras.remove(camera)
        bpy.data.scenes.remove(scene)
    if not path.is_file():
        raise RuntimeError("The image of the world could not be rendered")
