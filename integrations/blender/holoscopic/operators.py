# SPDX-License-Identifier: GPL-3.0-or-later
"""*Render Holoscopic*: export, render, load. Without a window it blocks; with one it can be canceled by Esc."""

import pathlib
import subprocess
import tempfile

import bpy
from bpy.props import BoolProperty, FloatProperty, StringProperty

from . import export, geometry, load, preferences, program, properties

# Seconds between two looks at the process.
INTERVAL = 0.2


class RENDER_OT_holoscopic(bpy.types.Operator):
    bl_idname = "render.holoscopic"
    bl_label = "Render Holoscopic"
    bl_description = "Export the scene, render it with holo, and load the images"

    directory: StringProperty(name="Output", subtype="DIR_PATH", description="Empty: that of the camera")
    sensor: StringProperty(name="Sensor", description="hd, 4k, 8k, uhd8k or WIDTHxHEIGHT; empty: that of the camera")
    views: StringProperty(name="Views", description="COLUMNSxROWS or one number for both; empty: those of the camera")
    lenses: StringProperty(name="Lenses", description="COLUMNSxROWS pixels of a view, instead of a sensor")
    spp: FloatProperty(name="Samples", default=0, min=0, description="0: the quality of the camera")
    animation: BoolProperty(name="Animation", description="All frames, each in a folder of its own")
    viewer: BoolProperty(name="Viewer", description="Open the light field in a browser afterwards")
    options: StringProperty(name="Options", description="More options of holo render, such as --seed=3")

    @classmethod
    def poll(cls, context):
        return context.scene.camera is not None

    def execute(self, context):
        try:
            for frame in self._begin(context):
                run = self._start(context, frame)
                self._finish(run)
        except (OSError, RuntimeError, ValueError) as why:
            self.report({"ERROR"}, str(why))
            return {"CANCELLED"}
        finally:
            self._end(context)
        return {"FINISHED"}

    def invoke(self, context, event):
        if bpy.app.background:
            return self.execute(context)
        try:
            self._frames = iter(self._begin(context))
            self._run = self._start(context, next(self._frames))
        except (OSError, RuntimeError, ValueError) as why:
            self.report({"ERROR"}, str(why))
            self._end(context)
            return {"CANCELLED"}
        manager = context.window_manager
        self._timer = manager.event_timer_add(INTERVAL, window=context.window)
        manager.progress_begin(0.0, 1.0)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self._run.stop()
            self.report({"INFO"}, "Stopped")
            return self._leave(context, {"CANCELLED"})
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        context.window_manager.progress_update(self._run.share)
        if self._run.is_running():
            return {"RUNNING_MODAL"}
        try:
            self._finish(self._run)
            frame = next(self._frames, None)
            if frame is not None:
                self._run = self._start(context, frame)
                return {"RUNNING_MODAL"}
        except (OSError, RuntimeError, ValueError) as why:
            self.report({"ERROR"}, str(why))
            return self._leave(context, {"CANCELLED"})
        return self._leave(context, {"FINISHED"})

    def _leave(self, context, result):
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        self._end(context)
        return result

    def _begin(self, context):
        """Finds the program and makes the folders; returns the frames."""
        self._frame = context.scene.frame_current
        self._program = preferences.find()
        settings = context.scene.camera.data.holoscopic
        self._out = pathlib.Path(bpy.path.abspath(self.directory or settings.directory))
        self._out.mkdir(parents=True, exist_ok=True)
        self._exports = tempfile.TemporaryDirectory(prefix="holoscopic-")
        scene = context.scene
        return range(scene.frame_start, scene.frame_end + 1, scene.frame_step) if self.animation else [self._frame]

    def _start(self, context, frame):
        if context.scene.frame_current != frame:
            context.scene.frame_set(frame)
        exported = export.write(context, self._exports.name)
        self._folder = self._out / f"frame_{frame:04d}" if self.animation else self._out
        camera = context.scene.camera
        options = plenoptic_options(camera) if camera.data.holoscopic.kind == "PLENOPTIC" else self._rig_options(camera)
        options |= quality_options(camera, self.spp)
        options["no-indirect"] = not camera.data.holoscopic.indirect
        line = program.words(self._program, exported, self._folder, options)
        return program.Run([*line, *self.options.split()])

    def _rig_options(self, camera):
        settings = camera.data.holoscopic
        options = {"views": self.views or "{}x{}".format(*settings.views())}
        if self.lenses:
            options["lenses"] = self.lenses
        else:
            width, height = settings.sensor_px()
            options["sensor"] = self.sensor or (f"{width}x{height}" if settings.sensor == "OTHER" else settings.sensor)
        if settings.spacing == "DISPARITY":
            options["disparity"] = f"{settings.disparity_min:.9g},{settings.disparity_max:.9g}"
        else:
            if settings.spacing == "OWN":
                options["baseline-m"] = f"{settings.baseline_mm / 1000.0:.9g}"
            else:
                options["f-number"] = f"{settings.f_number:.9g}"
            options["focus-m"] = focus_option(camera)
        return options

    def _finish(self, run):
        run.finish()
        for line in run.lines:
            if line.startswith("warning:"):
                self.report({"WARNING"}, line.removeprefix("warning:").strip())
        images = load.images(self._folder)
        if images and not bpy.app.background:
            show(images[0])
        if self.viewer and (self._folder / "scene_el.png").is_file():
            page = self._folder / "viewer.html"
            subprocess.run([self._program, "view", str(self._folder), "--out", str(page)], check=True)
            bpy.ops.wm.url_open(url=page.as_uri())

    def _end(self, context):
        if getattr(self, "_exports", None) is not None:
            self._exports.cleanup()
            self._exports = None
        if context.scene.frame_current != getattr(self, "_frame", context.scene.frame_current):
            context.scene.frame_set(self._frame)


def plenoptic_options(camera):
    """The options of a plenoptic camera."""
    settings = camera.data.holoscopic
    options = {"camera-file": settings.preset}
    if settings.preset == "OWN":
        if not settings.camera_file:
            raise ValueError("choose a camera file, or a model of the list")
        options["camera-file"] = bpy.path.abspath(settings.camera_file)
    if settings.focus != "AUTO":
        options["focus-m"] = focus_option(camera)
    return options


def quality_options(camera, spp=0):
    """The options of the quality; `spp`: samples a pixel instead."""
    settings = camera.data.holoscopic
    found = properties.QUALITIES[settings.quality][2]
    if found is not None and not spp:
        return dict(found)
    return {"spp": geometry.samples_text(spp or settings.spp), "denoise": "views" if settings.denoise else "off"}


def focus_option(camera):
    """The value of `--focus-m`: `holo` finds the automatic one itself."""
    focus = None if camera.data.holoscopic.focus == "AUTO" else properties.focus_of(camera)
    return "auto" if focus is None else f"{focus:.9g}"


def show(image):
    """Shows an image in the first image editor, if there is one."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "IMAGE_EDITOR":
                area.spaces.active.image = image
                return


def register():
    bpy.utils.register_class(RENDER_OT_holoscopic)


def unregister():
    bpy.utils.unregister_class(RENDER_OT_holoscopic)
