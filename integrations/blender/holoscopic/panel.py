# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel in the properties of a camera."""

import math

import bpy

from . import losses, properties


class HOLOSCOPIC_PT_camera(bpy.types.Panel):
    bl_label = "Holoscopic"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "data"

    @classmethod
    def poll(cls, context):
        return getattr(context, "camera", None) is not None

    def draw(self, context):
        layout, settings = self.layout, context.camera.holoscopic
        layout.use_property_split = True
        layout.prop(settings, "kind")
        if settings.kind == "PLENOPTIC":
            layout.prop(settings, "preset")
            if settings.preset == "OWN":
                layout.prop(settings, "camera_file")
        else:
            draw_rig(layout, settings)
        draw_optics(layout, context, settings)
        column = layout.column()
        column.prop(settings, "quality")
        if settings.quality == "SAMPLES":
            column.prop(settings, "spp")
            column.prop(settings, "denoise")
        column.prop(settings, "indirect")
        column.prop(settings, "directory")
        layout.label(text="Images are plain sRGB, as the view transform Standard: not AgX", icon="INFO")
        draw_losses(layout, context)
        row = layout.row(align=True)
        row.operator("render.holoscopic", icon="RENDER_STILL").animation = False
        row.operator("render.holoscopic", text="Animation", icon="RENDER_ANIMATION").animation = True


def draw_rig(layout, settings):
    layout.prop(settings, "sensor")
    if settings.sensor == "OTHER":
        layout.prop(settings, "width")
        layout.prop(settings, "height")
    layout.prop(settings, "views_x")
    layout.prop(settings, "views_y")
    columns, rows = settings.lenses()
    width, height = settings.sensor_px()
    column = layout.column()
    if columns == 0 or rows == 0:
        column.label(text=f"{width} x {height} px are too few for so many views", icon="ERROR")
        return
    used = columns * settings.views_x, rows * settings.views_y
    column.label(text=f"Elemental images: {columns} x {rows}, each {settings.views_x} x {settings.views_y} px")
    column.label(text=f"Viewpoint images: {settings.views_x * settings.views_y}, each {columns} x {rows} px")
    if used != (width, height):
        column.label(text=f"{used[0]} x {used[1]} px of the sensor are used")


def draw_optics(layout, context, settings):
    if settings.kind == "RIG":
        layout.prop(settings, "spacing")
        if settings.spacing == "OWN":
            layout.prop(settings, "baseline_mm")
        elif settings.spacing == "AUTO":
            layout.prop(settings, "f_number")
        else:
            layout.prop(settings, "disparity_min")
            layout.prop(settings, "disparity_max")
    if settings.kind == "PLENOPTIC" or settings.spacing != "DISPARITY":
        layout.prop(settings, "focus")
        if settings.focus == "OWN":
            layout.prop(settings, "focus_m")
    layout.prop(settings, "show_frustum")
    row = layout.row()
    row.operator("holoscopic.measure", icon="DRIVER_DISTANCE")
    column = layout.column()
    if settings.is_measured():
        column.label(text=f"Depths: {_meters(settings.near_m)} to {_meters(settings.far_m)}")
    item = getattr(context, "object", None)
    if settings.kind == "PLENOPTIC" or item is None or item.type != "CAMERA":
        return
    baseline_m, focus_m = properties.rig_of(item)
    if baseline_m is not None:
        column.label(text=f"Baseline: {baseline_m * 1000:.3g} mm")
    if focus_m:
        column.label(text=f"Focus: {_meters(focus_m)}")
    found = properties.disparities(item)
    if found is not None:
        column.label(text=f"Disparities: {found[0]:.2f} to {found[1]:.2f} px between adjacent views")
        if max(abs(found[0]), abs(found[1])) * (max(settings.views()) - 1) < 1.0:
            column.label(text="The views hardly differ: choose disparities or a larger baseline", icon="ERROR")


def draw_losses(layout, context):
    lost = losses.of_scene(context)
    if lost:
        box = layout.box()
        box.label(text="Not exported", icon="ERROR")
        for line in lost[:12]:
            box.label(text=line)
        if len(lost) > 12:
            box.label(text=f"and {len(lost) - 12} more")


def _meters(depth_m):
    return f"{depth_m:.3g} m" if math.isfinite(depth_m) else "infinity"


def register():
    bpy.utils.register_class(HOLOSCOPIC_PT_camera)


def unregister():
    bpy.utils.unregister_class(HOLOSCOPIC_PT_camera)
