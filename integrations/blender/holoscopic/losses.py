# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene has that glTF cannot say, or `holo` does not model, one line a thing."""

# Nodes between a texture and the Principled BSDF that the exporter understands.
_KNOWN = {
    "BSDF_PRINCIPLED",
    "EMISSION",
    "FRAME",
    "GROUP",
    "GROUP_INPUT",
    "GROUP_OUTPUT",
    "HUE_SAT",
    "MAPPING",
    "MATH",
    "MIX",
    "MIX_RGB",
    "MIX_SHADER",
    "NORMAL_MAP",
    "OUTPUT_MATERIAL",
    "REROUTE",
    "RGB",
    "SEPARATE_COLOR",
    "SEPRGB",
    "BSDF_TRANSPARENT",
    "BSDF_DIFFUSE",
    "TEX_COORD",
    "TEX_IMAGE",
    "UVMAP",
    "VALUE",
    "VERTEX_COLOR",
    "ATTRIBUTE",
    "BACKGROUND",
    "LIGHT_PATH",
    "CLAMP",
    "VECT_MATH",
}

_KINDS = {"VOLUME": "a volume", "CURVES": "hair", "LIGHT_PROBE": None, "POINTCLOUD": "a point cloud"}


def of_scene(context):
    """The lines, without doubles, in the order of the objects."""
    lines = []
    for item in context.scene.objects:
        if item.hide_render:
            continue
        kind = _KINDS.get(item.type)
        if kind:
            lines.append(f"{item.name}: {kind}")
        if item.type == "LIGHT":
            lines += _light(item)
        if item.type == "CAMERA" and item == context.scene.camera:
            lines += _camera(item)
        for modifier in item.modifiers:
            if modifier.type == "PARTICLE_SYSTEM" and modifier.show_render:
                lines.append(f"{item.name}: particles")
        for slot in item.material_slots:
            if slot.material is not None:
                lines += _material(slot.material)
    if context.scene.render.use_motion_blur:
        lines.append("Motion blur")
    return list(dict.fromkeys(lines))


def _light(item):
    light = item.data
    if light.use_nodes and light.node_tree and any(
        node.type not in ("EMISSION", "OUTPUT_LIGHT") for node in light.node_tree.nodes
    ):
        yield f"{item.name}: nodes of the light"
    if light.type == "AREA":
        if light.spread < 3.14:
            yield f"{item.name}: spread of the area light"
        yield f"{item.name}: an area light becomes a panel, which is visible and blocks other light"
    if light.type in ("POINT", "SPOT") and light.shadow_soft_size > 0.0:
        yield f"{item.name}: radius of the light; its shadows are hard"


def _camera(item):
    camera = item.data
    if camera.type != "PERSP":
        yield f"{item.name}: only perspective cameras are rendered"
    if camera.dof.use_dof and camera.holoscopic.kind == "RIG":
        yield f"{item.name}: depth of field; every view is sharp"


def _material(material):
    if not material.use_nodes or material.node_tree is None:
        return
    nodes = material.node_tree.nodes
    if not any(node.type in ("BSDF_PRINCIPLED", "EMISSION", "BACKGROUND") for node in nodes):
        yield f"{material.name}: a material without Principled BSDF"
    strange = sorted({node.bl_label for node in nodes if node.type not in _KNOWN})
    if strange:
        yield f"{material.name}: {', '.join(strange)}; bake it to an image"
    for node in nodes:
        if node.type == "OUTPUT_MATERIAL":
            if node.inputs["Volume"].is_linked:
                yield f"{material.name}: a volume"
            if node.inputs["Displacement"].is_linked:
                yield f"{material.name}: displacement"
