# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene as Blender evaluates it, as a `.glb` and a sky."""

import pathlib

import bpy

from . import lights, world

# glTF's lights without the factor of 683 lumens a watt: what Cycles and `holo` compute then agrees.
LIGHTING = "COMPAT"


class Exported:
    """A `.glb`, the value of `--sky`, and the name of the camera."""

    def __init__(self, glb, sky, camera):
        self.glb, self.sky, self.camera = glb, sky, camera


def write(context, folder):
    """Exports the current frame into a folder."""
    folder = pathlib.Path(folder)
    glb = folder / "scene.glb"
    with lights.AreaLights(context), lights.AdjustedLights(context):
        _gltf(context, glb)
    return Exported(glb, world.sky(context, folder), context.scene.camera.name)


def _gltf(context, path):
    if not hasattr(bpy.ops.export_scene, "gltf") or "io_scene_gltf2" not in context.preferences.addons:
        bpy.ops.preferences.addon_enable(module="io_scene_gltf2")
    wanted = dict(
        filepath=str(path),
        export_format="GLB",
        use_renderable=True,
        use_active_scene=True,
        export_cameras=True,
        export_lights=True,
        export_apply=True,
        export_gn_mesh=True,
        export_gpu_instances=True,
        export_animations=False,
        # For the angle of the sun.
        export_extras=True,
        export_current_frame=True,
        export_image_format="AUTO",
        export_import_convert_lighting_mode=LIGHTING,
    )
    # Names differ between versions of Blender.
    known = bpy.ops.export_scene.gltf.get_rna_type().properties.keys()
    bpy.ops.export_scene.gltf(**{name: value for name, value in wanted.items() if name in known})
