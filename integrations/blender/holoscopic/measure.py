# SPDX-License-Identifier: GPL-3.0-or-later
"""The nearest and the farthest point that a camera sees, by a grid of rays."""

import math

import bpy
from mathutils import Vector

# Rays along the larger side of the image.
RAYS = 64


def depths_m(context, item):
    """The smallest and the largest depth along the optical axis in meters; None if nothing is hit."""
    depsgraph = context.evaluated_depsgraph_get()
    corners = item.data.view_frame(scene=context.scene)
    right, bottom = corners[0] - corners[3], corners[1] - corners[0]
    steps = RAYS, max(2, round(RAYS * bottom.length / right.length))
    world = item.matrix_world.normalized()
    origin, back = world.translation, world.to_3x3() @ Vector((0.0, 0.0, 1.0))
    found = []
    for column in range(steps[0]):
        for row in range(steps[1]):
            x, y = (column + 0.5) / steps[0], (row + 0.5) / steps[1]
            direction = world.to_3x3() @ (corners[3] + x * right + y * bottom)
            hit, point, *_ = context.scene.ray_cast(depsgraph, origin, direction.normalized())
            if hit:
                found.append(-(point - origin).dot(back))
    return (min(found), max(found)) if found else None


class HOLOSCOPIC_OT_measure(bpy.types.Operator):
    bl_idname = "holoscopic.measure"
    bl_label = "Measure Depths"
    bl_description = "Find the nearest and the farthest point that the camera sees"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return _camera_of(context) is not None

    def execute(self, context):
        item = _camera_of(context)
        found = depths_m(context, item)
        if found is None:
            self.report({"WARNING"}, "The camera sees nothing")
            return {"CANCELLED"}
        settings = item.data.holoscopic
        settings.near_m, settings.far_m = found
        return {"FINISHED"}


def _camera_of(context):
    item = context.object if getattr(context, "object", None) else context.scene.camera
    return item if item is not None and item.type == "CAMERA" and not math.isnan(item.data.lens) else None


def register():
    bpy.utils.register_class(HOLOSCOPIC_OT_measure)


def unregister():
    bpy.utils.unregister_class(HOLOSCOPIC_OT_measure)
