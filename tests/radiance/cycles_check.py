"""Compares a reference of this folder with Blender's Cycles, object by object.

    cycles_check.py SCENE.glb REFERENCE.pfm [--environment FILE.hdr] [--spp 1024] [--bounces 7]

Prints for every object the mean radiance of its inner pixels (their eight neighbors show the same object) here and there. `--bounces` is
Cycles': scattering events - 1. Blender's importer reads the file; what it understands otherwise than glTF says is set right, see `repair`.
Needs bpy 5.0, OpenEXR and numpy.
"""
import argparse
import math
import os
import tempfile

import bpy
import numpy as np
import OpenEXR

from files import Glb, read_pfm

WIDTH, HEIGHT = 99, 66


def principled(material):
    return next((n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED"), None)


def repair(material, entry):
    """Single scattering, Beer-Lambert absorption, front-only emission, panes that bend no ray, textures interpolated in linear light."""
    nodes, links, shader = material.node_tree.nodes, material.node_tree.links, principled(material)
    shader.distribution = "GGX"
    output = next(n for n in nodes if n.type == "OUTPUT_MATERIAL" and n.is_active_output)
    extensions = entry.get("extensions", {})
    for node in [n for n in nodes if n.type == "TEX_IMAGE"]:
        image = node.image
        width, height = image.size
        codes = np.array(image.pixels[:], np.float64).reshape(height, width, 4)[..., :3]
        linear = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
        exact = bpy.data.images.new(image.name + " linear", width, height, float_buffer=True)
        exact.colorspace_settings.name = "Linear Rec.709"
        exact.pixels[:] = np.concatenate([linear, np.ones((height, width, 1))], axis=2).astype(np.float32).ravel()
        node.image = exact
    if "KHR_materials_emissive_strength" in extensions:
        strength = shader.inputs["Emission Strength"].default_value
        side, front = nodes.new("ShaderNodeNewGeometry"), nodes.new("ShaderNodeMath")
        front.operation, front.inputs[0].default_value, front.use_clamp = "MULTIPLY_ADD", -strength, False
        front.inputs[2].default_value = strength
        links.new(side.outputs["Backfacing"], front.inputs[1])
        links.new(front.outputs[0], shader.inputs["Emission Strength"])
    if "KHR_materials_transmission" not in extensions:
        return
    volume = extensions.get("KHR_materials_volume", {})
    for link in list(output.inputs["Volume"].links):
        links.remove(link)
    if volume.get("thicknessFactor", 0) > 0:
        sigma = -np.log(volume.get("attenuationColor", [1] * 3)) / volume.get("attenuationDistance", math.inf)
        if sigma.max() > 0:
            absorption = nodes.new("ShaderNodeVolumeAbsorption")
            absorption.inputs["Density"].default_value = float(sigma.max())
            absorption.inputs["Color"].default_value = [*(1 - sigma / sigma.max()).tolist(), 1]
            links.new(absorption.outputs[0], output.inputs["Volume"])
    else:
        mixed, gloss, through, fresnel = (nodes.new(f"ShaderNode{n}") for n in ("MixShader", "BsdfGlossy", "BsdfRefraction", "Fresnel"))
        gloss.inputs["Roughness"].default_value = through.inputs["Roughness"].default_value = 0
        gloss.inputs["Color"].default_value = [1, 1, 1, 1]
        # An index of exactly 1 would make it transparent to shadow rays.
        through.inputs["IOR"].default_value = 1.0001
        through.inputs["Color"].default_value = entry["pbrMetallicRoughness"]["baseColorFactor"]
        # Fresnel's node inverts its index on the back of a surface; here both sides are outside.
        side, back, index = nodes.new("ShaderNodeNewGeometry"), nodes.new("ShaderNodeMath"), extensions["KHR_materials_ior"]["ior"]
        back.operation, back.inputs[1].default_value, back.inputs[2].default_value = "MULTIPLY_ADD", 1 / index - index, index
        links.new(side.outputs["Backfacing"], back.inputs[0])
        links.new(back.outputs[0], fresnel.inputs["IOR"])
        links.new(fresnel.outputs[0], mixed.inputs[0])
        links.new(through.outputs[0], mixed.inputs[1])
        links.new(gloss.outputs[0], mixed.inputs[2])
        links.new(mixed.outputs[0], output.inputs["Surface"])


def surround(scene, environment):
    world = bpy.data.worlds.new("surround")
    scene.world, world.use_nodes = world, True
    background = world.node_tree.nodes["Background"]
    if environment:
        # Blender's longitude is ours: the image needs no turn.
        texture = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
        texture.image = bpy.data.images.load(os.path.abspath(environment))
        world.node_tree.links.new(texture.outputs[0], background.inputs[0])
    else:
        background.inputs[0].default_value = (0.2, 0.24, 0.32, 1)


def configure(scene, bounces, width, height):
    """Paths without clamping, box filter, EXR of 32 bits."""
    scene.render.engine, scene.cycles.device = "CYCLES", "CPU"
    cycles = scene.cycles
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = bounces
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.min_light_bounces = 100
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.pixel_filter_type, cycles.light_sampling_threshold = "BOX", 0.0
    scene.render.filter_size = 1.0
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    scene.render.image_settings.media_type = "MULTI_LAYER_IMAGE"
    scene.render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    scene.render.image_settings.color_depth = "32"


def sharpen(lights):
    """Punctual lights without extent, as glTF has them."""
    for light in lights:
        light.use_shadow_jitter = False
        if light.type == "SUN":
            light.angle = 0.0
        else:
            light.shadow_soft_size = 0.0


def prepare(path, environment, bounces):
    """The scene, ready to be rendered as glTF has it, and the names of its objects in the order of their indices."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=os.path.abspath(path), import_shading="NORMALS", export_import_convert_lighting_mode="COMPAT")
    document = Glb(path).document
    entries = {m["name"]: m for m in document["materials"]}
    for material in bpy.data.materials:
        if material.name in entries:
            repair(material, entries[material.name])
    sharpen(bpy.data.lights)
    names = [n["name"] for n in document["nodes"] if "mesh" in n]
    for item in bpy.data.objects:
        if item.name in names:
            item.pass_index = names.index(item.name) + 1
    scene = bpy.context.scene
    scene.camera = next(o for o in bpy.data.objects if o.type == "CAMERA")
    surround(scene, environment)
    configure(scene, bounces, WIDTH, HEIGHT)
    layer = scene.view_layers[0]
    layer.use_pass_object_index = True
    return scene, names


def render_once(scene, path):
    """Every pass by name, rows from the top; `path` is the EXR file that is written on the way."""
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    parts = OpenEXR.File(path).parts
    return {part.name().split(".")[-1]: next(iter(part.channels.values())).pixels for part in parts}


def render(path, environment, spp, bounces):
    """Radiance and the index of the object seen at the center of every pixel, rows from the top."""
    scene, names = prepare(path, environment, bounces)
    folder = tempfile.mkdtemp()
    scene.cycles.samples = spp
    color = render_once(scene, os.path.join(folder, "color.exr"))["Combined"]
    scene.render.filter_size, scene.cycles.samples = 0.01, 1
    index = render_once(scene, os.path.join(folder, "index.exr"))["Object Index"]
    return color[..., :3].astype(np.float64), np.rint(index).astype(int), names


def inner(index):
    """Pixels whose neighbors show the same object."""
    edge = np.pad(index, 1, constant_values=-1)
    same = [edge[1 + dy : 1 + dy + HEIGHT, 1 + dx : 1 + dx + WIDTH] == index for dy in (-1, 0, 1) for dx in (-1, 0, 1)]
    return np.all(same, axis=0)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("reference")
    parser.add_argument("--environment")
    parser.add_argument("--spp", type=int, default=1024)
    parser.add_argument("--bounces", type=int, default=7)
    parser.add_argument("--save", help="keep Cycles' image and the objects' indices (.npz)")
    a = parser.parse_args()
    ours = read_pfm(a.reference).astype(np.float64)
    theirs, index, names = render(a.scene, a.environment, a.spp, a.bounces)
    if a.save:
        np.savez(a.save, color=theirs, index=index)
    clean = inner(index)
    print(f"{'object':16} pixels  Mitsuba (R G B)          Cycles / Mitsuba - 1, %")
    for k, name in enumerate(["surround", *names]):
        mask = clean & (index == k)
        if mask.sum() < 4:
            continue
        here, there = ours[mask].mean(axis=0), theirs[mask].mean(axis=0)
        change = 100 * (there / np.maximum(here, 1e-9) - 1)
        print(f"{name:16} {mask.sum():6}  {here[0]:.4f} {here[1]:.4f} {here[2]:.4f}   {change[0]:+7.2f} {change[1]:+7.2f} {change[2]:+7.2f}")


if __name__ == "__main__":
    main()
