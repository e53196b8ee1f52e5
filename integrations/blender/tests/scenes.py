# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes, one for everything that an export has to carry over. Each function fills the empty scene of Blender."""

import math

import bpy

SIZE = (96, 64)


def empty():
    """A new file with a camera that looks at the origin, a gray floor and a black world."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("World")
    world_color((0.0, 0.0, 0.0), 1.0)
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.render.resolution_percentage = 100
    camera = bpy.data.objects.new("Eye", bpy.data.cameras.new("Eye"))
    camera.location, camera.rotation_euler = (0.0, -6.0, 3.0), (math.radians(65), 0.0, 0.0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    bpy.ops.mesh.primitive_plane_add(size=10)
    bpy.context.object.data.materials.append(material("floor", (0.5, 0.5, 0.5)))
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.8, location=(0.0, 0.0, 0.8), segments=48, ring_count=24)
    bpy.ops.object.shade_smooth()
    ball = bpy.context.object
    ball.name = "Ball"
    ball.data.materials.append(material("ball", (0.7, 0.25, 0.1)))
    return ball


def material(name, color, **inputs):
    """A Principled BSDF without specular reflection unless inputs say otherwise."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*color, 1.0)
    shader.inputs["Roughness"].default_value = 1.0
    shader.inputs["Specular IOR Level"].default_value = 0.0
    for key, value in inputs.items():
        shader.inputs[key.replace("_", " ")].default_value = value
    return made


def world_color(color, strength):
    world = bpy.context.scene.world
    world.use_nodes = True
    shader = world.node_tree.nodes.get("Background") or world.node_tree.nodes.new("ShaderNodeBackground")
    output = world.node_tree.get_output_node("ALL") or world.node_tree.nodes.new("ShaderNodeOutputWorld")
    world.node_tree.links.new(shader.outputs[0], output.inputs["Surface"])
    shader.inputs["Color"].default_value = (*color, 1.0)
    shader.inputs["Strength"].default_value = strength
    return shader


def light(kind, energy, location=(2.0, -2.0, 4.0), rotation=(0.0, 0.0, 0.0), **more):
    data = bpy.data.lights.new(kind.title(), kind)
    data.energy = energy
    for name, value in more.items():
        setattr(data, name, value)
    item = bpy.data.objects.new(kind.title(), data)
    item.location, item.rotation_euler = location, rotation
    bpy.context.scene.collection.objects.link(item)
    return item


def sun():
    empty()
    light("SUN", 3.0, rotation=(0.5, 0.3, 0.0), angle=0.0, color=(1.0, 0.9, 0.7))


def soft_sun():
    empty()
    light("SUN", 3.0, rotation=(0.5, 0.3, 0.0), angle=0.2)


def point():
    empty()
    light("POINT", 500.0, shadow_soft_size=0.0)


def spot():
    empty()
    light("SPOT", 800.0, location=(0.0, 0.0, 5.0), shadow_soft_size=0.0, spot_size=1.0, spot_blend=0.15)


def area_square():
    empty()
    light("AREA", 200.0, rotation=(0.4, 0.4, 0.0), size=1.5, shape="SQUARE")


def area_scaled_rectangle():
    empty()
    item = light("AREA", 300.0, rotation=(0.4, 0.4, 0.2), size=1.0, size_y=0.5, shape="RECTANGLE")
    item.scale = (2.0, 1.5, 1.0)


def area_disk():
    empty()
    light("AREA", 200.0, rotation=(0.4, 0.4, 0.0), size=2.0, shape="DISK", color=(0.5, 0.8, 1.0))


def world_of_one_color():
    empty()
    world_color((0.4, 0.6, 1.0), 0.8)


def world_image():
    empty()
    shader = world_color((1.0, 1.0, 1.0), 1.5)
    width, height = 128, 64
    image = bpy.data.images.new("sky", width, height, float_buffer=True)
    pixels = []
    for row in range(height):
        for column in range(width):
            bright = 8.0 if 20 < column < 40 and row > 36 else 0.3
            pixels += [bright, 0.5 * row / height + 0.1, column / width, 1.0]
    image.pixels = pixels
    image.pack()
    tree = bpy.context.scene.world.node_tree
    texture, mapping = tree.nodes.new("ShaderNodeTexEnvironment"), tree.nodes.new("ShaderNodeMapping")
    place = tree.nodes.new("ShaderNodeTexCoord")
    texture.image = image
    mapping.inputs["Rotation"].default_value = (0.3, 0.0, 1.1)
    tree.links.new(place.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs[0], texture.inputs["Vector"])
    tree.links.new(texture.outputs[0], shader.inputs["Color"])


def emission():
    ball = empty()
    ball.data.materials.clear()
    ball.data.materials.append(
        material("lamp", (0.0, 0.0, 0.0), Emission_Color=(1.0, 0.6, 0.3, 1.0), Emission_Strength=5.0)
    )
    ball.location.z = 2.0


def metal():
    ball = empty()
    ball.data.materials.clear()
    ball.data.materials.append(material("metal", (0.9, 0.7, 0.4), Metallic=1.0, Roughness=0.4))
    world_color((0.6, 0.7, 0.9), 1.0)
    light("AREA", 200.0, rotation=(0.4, 0.4, 0.0), size=2.0, shape="SQUARE")


def plastic():
    ball = empty()
    ball.data.materials.clear()
    ball.data.materials.append(material("plastic", (0.1, 0.3, 0.7), Specular_IOR_Level=0.5, Roughness=0.3))
    world_color((0.6, 0.7, 0.9), 1.0)


def texture_and_modifiers():
    empty()
    bpy.ops.mesh.primitive_cube_add(size=0.8, location=(-2.4, 0.0, 0.5))
    cube = bpy.context.object
    image = bpy.data.images.new("checks", 32, 32)
    image.pixels = [
        channel
        for row in range(32)
        for column in range(32)
        for channel in ((0.9, 0.2, 0.1, 1.0) if (row // 8 + column // 8) % 2 else (0.1, 0.3, 0.8, 1.0))
    ]
    image.pack()
    made = material("checks", (1.0, 1.0, 1.0))
    node = made.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    made.node_tree.links.new(node.outputs[0], made.node_tree.nodes["Principled BSDF"].inputs["Base Color"])
    cube.data.materials.append(made)
    array = cube.modifiers.new("Array", "ARRAY")
    array.count, array.relative_offset_displace = 3, (1.8, 0.0, 0.0)
    bevel = cube.modifiers.new("Bevel", "BEVEL")
    bevel.width = 0.1
    world_color((1.0, 1.0, 1.0), 1.0)


def instances():
    empty()
    group = bpy.data.collections.new("Group")
    bpy.ops.mesh.primitive_cone_add(radius1=0.4, depth=0.8)
    cone = bpy.context.object
    cone.data.materials.append(material("cone", (0.2, 0.6, 0.3)))
    bpy.context.scene.collection.objects.unlink(cone)
    group.objects.link(cone)
    for x in (-2.0, 2.0):
        item = bpy.data.objects.new("Instance", None)
        item.instance_type, item.instance_collection = "COLLECTION", group
        item.location, item.rotation_euler = (x, 0.5, 0.4), (0.0, 0.0, x)
        bpy.context.scene.collection.objects.link(item)
    light("SUN", 3.0, rotation=(0.5, 0.3, 0.0), angle=0.0)
    world_color((0.2, 0.2, 0.25), 1.0)


ALL = (
    sun,
    soft_sun,
    point,
    spot,
    area_square,
    area_scaled_rectangle,
    area_disk,
    world_of_one_color,
    world_image,
    emission,
    metal,
    plastic,
    texture_and_modifiers,
    instances,
)
