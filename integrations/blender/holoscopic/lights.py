# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights as glTF can say them: area lights as emissive meshes, the edges of spots, the angle of the sun."""

import math

import bpy
from mathutils import Matrix

# Corners of the polygon that takes the place of a disc; its area is that of the disc.
CORNERS = 64


# What the loader of `holo` reads of a sun beside glTF's own numbers.
ANGLE = "angular_diameter_rad"

# The part of Blender's edge of a spot over which glTF's edge has the same light: both go from 0 to 1 over the cosine, one
# as 3 x^2 - 2 x^3, the other as a square.
EDGE = 0.75


class AdjustedLights:
    """Changes spots and suns for the time of an export, so that what is written shines as in Blender."""

    def __init__(self, context):
        lights = {item.data for item in context.scene.objects if item.type == "LIGHT"}
        self.spots = [(light, light.spot_blend) for light in lights if light.type == "SPOT"]
        self.suns = [light for light in lights if light.type == "SUN" and light.angle > 0.0 and ANGLE not in light]

    def __enter__(self):
        for light, blend in self.spots:
            light.spot_blend = exported_blend(light.spot_size / 2, blend)
        for light in self.suns:
            light[ANGLE] = light.angle
        return self

    def __exit__(self, *_):
        for light, blend in self.spots:
            light.spot_blend = blend
        for light in self.suns:
            del light[ANGLE]


def exported_blend(half_angle, blend):
    """The blend with which the exporter, whose inner angle is (1 - blend) of the outer one, writes the edge of a spot."""
    outer = math.cos(half_angle)
    inner = math.acos(min(outer + EDGE * (1.0 - outer) * blend, 1.0))
    return 1.0 - inner / half_angle if half_angle > 0.0 else 0.0


class AreaLights:
    """Puts an emissive mesh where every area light is, for the time of an export."""

    def __init__(self, context):
        self.context, self.made = context, []

    def __enter__(self):
        depsgraph = self.context.evaluated_depsgraph_get()
        found = [
            (entry.object.name, entry.object.original.data, entry.matrix_world.copy())
            for entry in depsgraph.object_instances
            if entry.object.type == "LIGHT" and entry.object.data.type == "AREA" and not entry.object.hide_render
        ]
        for name, light, place in found:
            self._add(name, light, place)
        if self.made:
            self.context.view_layer.update()
        return self

    def _add(self, name, light, place):
        shape = outline(light)
        mesh = bpy.data.meshes.new(f"{name} (area light)")
        mesh.from_pydata(shape, [], [list(range(len(shape)))])
        mesh.materials.append(_material(name, radiance(light, place, shape)))
        item = bpy.data.objects.new(mesh.name, mesh)
        item.matrix_world = place
        self.context.scene.collection.objects.link(item)
        self.made.append(item)

    def __exit__(self, *_):
        for item in self.made:
            mesh = item.data
            material = mesh.materials[0]
            bpy.data.objects.remove(item)
            bpy.data.meshes.remove(mesh)
            bpy.data.materials.remove(material)


def outline(light):
    """The corners of an area light in its own coordinates; it shines along -Z, so they run clockwise seen from +Z."""
    width = light.size
    height = light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size
    if light.shape in ("SQUARE", "RECTANGLE"):
        x, y = width / 2, height / 2
        return [(-x, -y, 0.0), (-x, y, 0.0), (x, y, 0.0), (x, -y, 0.0)]
    step = 2 * math.pi / CORNERS
    # A polygon within the circle has less area than the circle.
    grown = math.sqrt(step / math.sin(step))
    return [
        (math.cos(-k * step) * grown * width / 2, math.sin(-k * step) * grown * height / 2, 0.0) for k in range(CORNERS)
    ]


def radiance(light, place, shape):
    """Linear RGB radiance: the power spread over area and hemisphere, P / (pi A). The power does not grow with the scale
    of the object."""
    points = [place @ Matrix.Translation(point).translation for point in shape]
    normal = sum(((a - points[0]).cross(b - points[0]) for a, b in zip(points[1:], points[2:])), points[0] * 0.0)
    area = normal.length / 2
    strength = light.energy * 2.0 ** getattr(light, "exposure", 0.0) / (math.pi * max(area, 1e-12))
    return [strength * channel for channel in light.color]


def _material(name, rgb):
    material = bpy.data.materials.new(f"{name} (area light)")
    material.use_nodes = True
    material.use_backface_culling = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    shader, output = nodes.new("ShaderNodeBsdfPrincipled"), nodes.new("ShaderNodeOutputMaterial")
    links.new(shader.outputs[0], output.inputs["Surface"])
    strength = max(rgb)
    shader.inputs["Base Color"].default_value = (0.0, 0.0, 0.0, 1.0)
    shader.inputs["Specular IOR Level"].default_value = 0.0
    shader.inputs["Emission Color"].default_value = (*[x / strength if strength else 0.0 for x in rgb], 1.0)
    shader.inputs["Emission Strength"].default_value = strength
    return material
