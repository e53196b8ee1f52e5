# SPDX-License-Identifier: GPL-3.0-or-later
"""The plane of zero disparity and its frustum in the viewport."""

import math

import bpy

from . import properties

COLOR = (1.0, 0.55, 0.1, 0.9)

_handle = None


def lines(item, scene):
    """Pairs of points in world coordinates: the frustum to the focus plane, its outline, and a cross; empty without focus."""
    _, focus_m = properties.rig_of(item)
    if not focus_m or not math.isfinite(focus_m):
        return []
    corners = [corner / -corner.z * focus_m for corner in item.data.view_frame(scene=scene)]
    place = item.matrix_world.normalized()
    points, eye = [place @ corner for corner in corners], place.translation
    pairs = []
    for first, second in zip(points, points[1:] + points[:1]):
        pairs += [(first, second), (eye, first)]
    pairs += [(points[0], points[2]), (points[1], points[3])]
    return pairs


def _draw():
    import gpu
    from gpu_extras.batch import batch_for_shader

    item = bpy.context.scene.camera
    if item is None or item.type != "CAMERA" or not item.data.holoscopic.show_frustum:
        return
    pairs = lines(item, bpy.context.scene)
    if not pairs:
        return
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    batch = batch_for_shader(shader, "LINES", {"pos": [tuple(point) for pair in pairs for point in pair]})
    gpu.state.blend_set("ALPHA")
    shader.bind()
    shader.uniform_float("color", COLOR)
    batch.draw(shader)
    gpu.state.blend_set("NONE")


def register():
    global _handle
    if not bpy.app.background:
        _handle = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW")


def unregister():
    global _handle
    if _handle is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_handle, "WINDOW")
        _handle = None
