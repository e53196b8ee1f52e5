"""Renders one glTF file with Cycles from the camera of a `parameters.cfg`, under a sky of radiance 1.

usage: render_in_cycles.py FILE.glb parameters.cfg OUT.exr SAMPLES [LIGHTS]

Cycles is asked for what glTF defines: no clamping, no blurred caustics, a box filter of one pixel, the same number of
bounces as `holo render`. LIGHTS is how the importer converts lights, COMPAT by default: 1 lux on white is 1/pi.
"""

import configparser
import math
import sys

import bpy
import addon_utils  # a module that `bpy` brings
from mathutils import Euler, Matrix, Vector

BOUNCES = 8


def camera(config):
    intrinsics, extrinsics = config["intrinsics"], config["extrinsics"]
    data = bpy.data.cameras.new("holo")
    data.sensor_fit = "AUTO"
    data.sensor_width = float(intrinsics["sensor_size_mm"])
    data.lens = float(intrinsics["focal_length_mm"])
    data.clip_start, data.clip_end = 1e-6, 1e9
    camera = bpy.data.objects.new("holo", data)
    bpy.context.scene.collection.objects.link(camera)
    position = Vector(float(extrinsics[f"center_cam_{axis}_m"]) for axis in "xyz")
    rotation = Euler([float(extrinsics[f"center_cam_r{axis}_rad"]) for axis in "xyz"], "XYZ")
    camera.matrix_world = Matrix.Translation(position) @ rotation.to_matrix().to_4x4()
    return camera


def without_animations():
    """Has the importer show the pose of the nodes, as glTF defines it, instead of a frame of an animation."""
    from io_scene_gltf2.io.imp.gltf2_io_gltf import glTFImporter

    read = glTFImporter.read

    def read_without(self):
        result = read(self)
        self.data.animations = []
        return result

    glTFImporter.read = read_without


def white_metal_by_default():
    """Gives meshes without a material the default of glTF, a rough white metal; Blender's is gray."""
    default = bpy.data.materials.new("glTF default")
    default.use_nodes = True
    shader = default.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (1, 1, 1, 1)
    shader.inputs["Metallic"].default_value = shader.inputs["Roughness"].default_value = 1
    for mesh in bpy.data.meshes:
        if not mesh.materials:
            mesh.materials.append(default)
        for slot, material in enumerate(mesh.materials):
            if material is None:
                mesh.materials[slot] = default


def main():
    scene_file, cfg, out, samples = sys.argv[1:5]
    lights = sys.argv[5] if len(sys.argv) > 5 else "COMPAT"
    config = configparser.ConfigParser()
    config.read(cfg)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon_utils.enable("cycles")
    without_animations()
    bpy.ops.import_scene.gltf(
        filepath=scene_file, import_shading="NORMALS", export_import_convert_lighting_mode=lights
    )
    scene = bpy.context.scene
    white_metal_by_default()
    scene.camera = camera(config)
    world = bpy.data.worlds.new("sky")
    scene.world = world
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs[0].default_value, background.inputs[1].default_value = (1, 1, 1, 1), 1
    render = scene.render
    render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples = int(samples)
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.sample_clamp_indirect = cycles.sample_clamp_direct = 0
    cycles.blur_glossy = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = BOUNCES
    cycles.transparent_max_bounces = 256
    cycles.pixel_filter_type = "BOX"
    cycles.filter_width = 1
    render.resolution_x = int(float(config["intrinsics"]["image_resolution_x_px"]))
    render.resolution_y = int(float(config["intrinsics"]["image_resolution_y_px"]))
    render.resolution_percentage = 100
    render.film_transparent = False
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    render.filepath = out
    render.use_file_extension = False
    assert math.isfinite(scene.camera.data.lens)
    bpy.ops.render.render(write_still=True)


main()
