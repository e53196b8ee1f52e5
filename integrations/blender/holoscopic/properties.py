# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel sets for a camera; stored with the camera in the .blend file."""

import math

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from . import geometry

# Those of `holo camera`.
PRESETS = (
    ("lytro-illum", "Lytro Illum", "7728 x 5368 px, hexagonal array, unfocused"),
    ("lytro-f01", "Lytro F01", "3280 x 3280 px, hexagonal array, unfocused"),
    ("pleno-upcs", "Pleno-UPCS", "7728 x 5368 px"),
    ("raytrix-r8", "Raytrix R8", "3840 x 2160 px, three types of microlenses, focused"),
    ("raytrix-r12-a", "Raytrix R12", "4080 x 3068 px, three types of microlenses, focused"),
    ("raytrix-r29", "Raytrix R29", "6576 x 4384 px, three types of microlenses, focused"),
    ("hahne-arri", "Hahne, ARRI", "4008 x 2672 px, unfocused"),
    ("h3dv", "H3DV", "1920 x 1088 px, holoscopic video camera"),
    ("focused-p45", "Focused P45", "7240 x 5432 px, focused"),
    ("home-made", "Home-made", "6000 x 4000 px"),
    ("OWN", "Camera File", "A camera.toml of your own"),
)

# The words and sets of the page of `holo preview`.
QUALITIES = {
    "CLEAN": ("Clean", "About 2 % of noise", {"denoise": "views", "target-error": "2%"}),
    "DRAFT": ("Draft", "The fastest image", {"spp": "1/16", "denoise": "views"}),
    "SAMPLES": ("Samples a Pixel", "A number of samples", None),
    "REFERENCE": ("Reference", "1024 samples", {"spp": "1024", "denoise": "off", "reuse": "off"}),
}


class HoloscopicCamera(bpy.types.PropertyGroup):
    """The rig or the plenoptic camera that takes the place of a camera of Blender."""

    kind: EnumProperty(
        name="Camera",
        items=(
            ("RIG", "Rig of Views", "A grid of pinhole cameras: the raw image of an ideal holoscopic camera"),
            ("PLENOPTIC", "Plenoptic Camera", "Main lens, microlenses and sensor of a real camera"),
        ),
    )
    preset: EnumProperty(name="Model", items=PRESETS)
    camera_file: StringProperty(name="File", subtype="FILE_PATH", description="A camera.toml, as `holo camera` writes it")
    sensor: EnumProperty(
        name="Sensor",
        items=(
            ("hd", "HD", "1920 x 1080 px"),
            ("4k", "4K", "3840 x 2160 px"),
            ("8k", "8K", "7952 x 5304 px, that of the paper"),
            ("uhd8k", "UHD 8K", "7680 x 4320 px"),
            ("OTHER", "Other", "A size of your own"),
        ),
        default="8k",
    )
    width: IntProperty(name="Width", default=3000, min=1, subtype="PIXEL")
    height: IntProperty(name="Height", default=2000, min=1, subtype="PIXEL")
    views_x: IntProperty(name="Views X", default=100, min=1, soft_max=200)
    views_y: IntProperty(name="Y", default=100, min=1, soft_max=200)
    spacing: EnumProperty(
        name="Views Apart by",
        items=(
            ("AUTO", "f-Number", "The views share the aperture of a lens of this f-number"),
            ("DISPARITY", "Disparities", "Baseline and focus from the smallest and largest disparity"),
            ("OWN", "Baseline", "A distance between adjacent views"),
        ),
        default="DISPARITY",
    )
    f_number: FloatProperty(name="f-Number", default=geometry.F_NUMBER, min=0.1, soft_max=32.0)
    baseline_mm: FloatProperty(name="Baseline (mm)", default=1.0, min=0.0, precision=3)
    disparity_min: FloatProperty(name="Disparities (px)", default=-1.0)
    disparity_max: FloatProperty(name="Max", default=1.0)
    focus: EnumProperty(
        name="Focus",
        items=(
            ("AUTO", "Automatic", "Between the nearest and the farthest visible point"),
            ("OWN", "Distance", "A distance along the optical axis"),
            ("DOF", "Depth of Field", "The focus distance or object of the camera's depth of field"),
        ),
    )
    focus_m: FloatProperty(name="Distance", default=3.0, min=0.001, unit="LENGTH")
    quality: EnumProperty(
        name="Quality", items=[(key, name, words) for key, (name, words, _) in QUALITIES.items()], default="CLEAN"
    )
    spp: FloatProperty(
        name="Samples",
        default=16,
        min=1 / 64,
        soft_max=4096,
        step=100,
        precision=2,
        description="Samples per pixel; below 1, with Denoise, that part of the pixels has one: 1/2, 1/4, ... 1/64",
    )
    denoise: BoolProperty(name="Denoise", default=True, description="Reduce noise with the samples of neighboring views")
    indirect: BoolProperty(name="Indirect Light", default=True, description="Light between diffuse surfaces")
    directory: StringProperty(name="Output", default="//holoscopic", subtype="DIR_PATH")
    show_frustum: BoolProperty(
        name="Show in Viewport", default=True, description="Draw the plane of zero disparity and its frustum"
    )
    near_m: FloatProperty(default=0.0)
    far_m: FloatProperty(default=0.0)

    def sensor_px(self):
        """Width and height of the raw image, px."""
        return geometry.SENSORS.get(self.sensor, (self.width, self.height))

    def views(self):
        """Views, (columns, rows)."""
        return (self.views_x, self.views_y)

    def lenses(self):
        """Microlenses, (columns, rows): the pixels of a view."""
        return geometry.lenses(self.sensor_px(), self.views())

    def is_measured(self):
        """Whether the depths of the scene are known."""
        return self.near_m > 0.0

    def depths_m(self):
        """Nearest and farthest measured depth, m."""
        return self.near_m, self.far_m


def optics_m(camera):
    """Focal length and larger side of the sensor of a camera's data in meters, as glTF has them."""
    render = bpy.context.scene.render
    is_tall = render.resolution_y * render.pixel_aspect_y > render.resolution_x * render.pixel_aspect_x
    fit = camera.sensor_fit
    side = camera.sensor_height if fit == "VERTICAL" else camera.sensor_width
    ratio = (render.resolution_y * render.pixel_aspect_y) / (render.resolution_x * render.pixel_aspect_x)
    if fit == "VERTICAL" and not is_tall:
        side /= ratio
    elif fit == "HORIZONTAL" and is_tall:
        side *= ratio
    return camera.lens / 1000.0, side / 1000.0


def rig_of(item):
    """Baseline and focus distance of a camera object in meters, as far as they are known; None where they are not."""
    camera, settings = item.data, item.data.holoscopic
    focal_m, sensor_m = optics_m(camera)
    pixels = max(settings.lenses())
    measured = settings.is_measured()
    if settings.spacing == "DISPARITY":
        low, high = settings.disparity_min, settings.disparity_max
        if not measured or low >= high or settings.near_m >= settings.far_m:
            return None, None
        return geometry.rig_of_disparities(low, high, *settings.depths_m(), focal_m, sensor_m, pixels)
    baseline_m = settings.baseline_mm / 1000.0
    if settings.spacing == "AUTO":
        baseline_m = geometry.automatic_baseline_m(focal_m, settings.f_number, settings.views())
    return baseline_m, focus_of(item)


def focus_of(item):
    """The focus distance of a camera object in meters; None if it follows from a scene that is not measured."""
    camera, settings = item.data, item.data.holoscopic
    if settings.focus == "OWN":
        return settings.focus_m
    if settings.focus == "DOF":
        target = camera.dof.focus_object
        if target is None:
            return camera.dof.focus_distance
        return -(item.matrix_world.inverted() @ target.matrix_world.translation).z
    return geometry.automatic_focus_m(*settings.depths_m()) if settings.is_measured() else None


def disparities(item):
    """Disparities of the farthest and the nearest measured point, px; None if they are not known."""
    camera, settings = item.data, item.data.holoscopic
    baseline_m, focus_m = rig_of(item)
    if baseline_m is None or not focus_m or not settings.is_measured():
        return None
    focal_m, sensor_m = optics_m(camera)
    pixels = max(settings.lenses())
    near, far = (
        geometry.disparity_px(depth if depth < 1e12 else math.inf, focus_m, baseline_m, focal_m, sensor_m, pixels)
        for depth in settings.depths_m()
    )
    return far, near


def register():
    bpy.utils.register_class(HoloscopicCamera)
    bpy.types.Camera.holoscopic = PointerProperty(type=HoloscopicCamera)


def unregister():
    del bpy.types.Camera.holoscopic
    bpy.utils.unregister_class(HoloscopicCamera)
