# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own animations, exported as glTF: `holo render --frame N` sees what Blender has in frame N.

A bending, skinned column, a ball with an animated shape key, and a camera on a path. Depth is compared with rays that Blender
casts at its evaluated meshes.
"""

import math
import os
import subprocess

import bpy
import mathutils
import numpy as np
import pytest

import scenes

FRAMES = (1, 7, 12, 18, 24)


def keyed(thing, path, values):
    """Keys of a property at the first, the middle and the last frame, with Blender's own interpolation."""
    for frame, value in zip((1, 12, 24), values):
        setattr(thing, path, value)
        thing.keyframe_insert(data_path=path, frame=frame)


def column():
    """A column of 24 rings that follows two bones, the upper of which bends over."""
    armature = bpy.data.armatures.new("Bones")
    rig = bpy.data.objects.new("Rig", armature)
    bpy.context.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    for name, bottom, top in (("lower", 0.0, 1.0), ("upper", 1.0, 2.0)):
        bone = armature.edit_bones.new(name)
        bone.head, bone.tail = (0.0, 0.0, bottom), (0.0, 0.0, top)
    armature.edit_bones["upper"].parent = armature.edit_bones["lower"]
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.mesh.primitive_cylinder_add(vertices=32, radius=0.3, depth=2.0, location=(0.0, 0.0, 1.0))
    body = bpy.context.object
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide(number_cuts=6)
    bpy.ops.object.mode_set(mode="OBJECT")
    lower, upper = (body.vertex_groups.new(name=name) for name in ("lower", "upper"))
    for vertex in body.data.vertices:
        share = min(max((vertex.co.z + 0.4) / 0.8, 0.0), 1.0)
        lower.add([vertex.index], 1.0 - share, "REPLACE")
        upper.add([vertex.index], share, "REPLACE")
    body.parent = rig
    body.modifiers.new("Armature", "ARMATURE").object = rig
    bone = rig.pose.bones["upper"]
    bone.rotation_mode = "XYZ"
    keyed(bone, "rotation_euler", [(0.0, 0.0, 0.0), (0.9, 0.0, 0.4), (0.2, 0.7, 0.0)])
    keyed(rig, "location", [(0.0, 0.0, 0.0), (0.3, 0.2, 0.0), (0.6, 0.0, 0.2)])
    rig.location = (0.0, 0.0, 0.0)


def ball():
    """The ball of the scene grows to a spindle."""
    body = bpy.data.objects["Ball"]
    body.location = (-1.6, 0.3, 0.8)
    body.shape_key_add(name="Basis")
    spindle = body.shape_key_add(name="Spindle")
    for point in spindle.data:
        point.co = (point.co.x * 0.5, point.co.y * 0.5, point.co.z * 1.6)
    keyed(spindle, "value", [0.0, 0.8, 0.3])


@pytest.fixture
def animated(tmp_path):
    scenes.empty()
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end, scene.render.fps = 1, 24, 24
    column()
    ball()
    camera = scene.camera
    keyed(camera, "location", [(0.0, -6.0, 3.0), (1.5, -5.5, 2.6), (2.4, -5.0, 3.2)])
    turns = [(math.radians(x), 0.0, math.radians(z)) for x, z in ((65, 0), (68, 12), (64, 24))]
    keyed(camera, "rotation_euler", turns)
    path = tmp_path / "animated.glb"
    bpy.ops.export_scene.gltf(filepath=str(path), export_cameras=True, export_yup=True, export_animations=True)
    return path


def blender_depth(frame, size):
    """Planar depth by rays through the centers of pixels; infinity where nothing is."""
    scene = bpy.context.scene
    scene.frame_set(frame)
    graph = bpy.context.evaluated_depsgraph_get()
    camera = scene.camera.evaluated_get(graph)
    pose, columns, rows = camera.matrix_world, *size
    focal = camera.data.lens / camera.data.sensor_width * columns
    depth = np.full((rows, columns), np.inf)
    for v in range(rows):
        for u in range(columns):
            local = mathutils.Vector(((u + 0.5 - columns / 2) / focal, (rows / 2 - v - 0.5) / focal, -1.0))
            along = (pose.to_3x3() @ local).normalized()
            hit, place, *_ = scene.ray_cast(graph, pose.translation, along)
            if hit:
                depth[v, u] = -(pose.inverted() @ place).z
    return depth


def holo_depth(glb, frame, size, folder):
    arguments = ["--frame", frame, "--fps", 24, "--views", "1x1", "--lenses", f"{size[0]}x{size[1]}"]
    more = ["--integrator", "depth", "--layers", "depth", "--quiet"]
    words = [os.environ["HOLO"], "render", glb, "--out", folder, *arguments, *more]
    subprocess.run([str(word) for word in words], check=True)
    with open(folder / "scene_depth.pfm", "rb") as file:
        assert file.readline() == b"Pf\n"
        columns, rows = map(int, file.readline().split())
        file.readline()
        return np.fromfile(file, "<f4").reshape(rows, columns)[::-1]


def test_every_frame_is_blenders(animated, tmp_path):
    before = None
    for frame in FRAMES:
        expected = blender_depth(frame, scenes.SIZE)
        depth = holo_depth(animated, frame, scenes.SIZE, tmp_path / str(frame))
        both = np.isfinite(expected) & np.isfinite(depth)
        assert both.mean() > 0.5 and (np.isfinite(expected) == np.isfinite(depth)).mean() > 0.999
        error = np.abs(depth[both] / expected[both] - 1.0)
        # A ray beside an edge may pass it; everything else is the rounding of files and meshes to single precision.
        assert np.median(error) < 1e-6 and np.quantile(error, 0.99) < 1e-5, (frame, np.quantile(error, [0.5, 0.99, 1.0]))
        assert before is None or np.abs(np.where(both, depth - before, 0.0)).mean() > 0.02, "nothing moves"
        before = np.where(np.isfinite(depth), depth, 0.0)
