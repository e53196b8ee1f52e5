"""Light fields of holoscopic (integral, plenoptic) cameras: render, convert, refocus, estimate depth, score.

    import holo

    scene = holo.Scene.gallery("garden")                        # or holo.Scene.open("scene.glb")
    result = holo.render(scene, views=(9, 9), lenses=(200, 300), layers=["depth", "disparity"])
    result.light_field.refocus(disparity=0.5)                   # an image in focus where disparity is 0.5 px
    estimate = result.light_field.disparity()
    holo.evaluate(estimate, result.disparity)

Arrays are those of numpy. A light field has the axes (v, u, t, s, c): row and column of the microlens (the pixel of a
view), row and column of the view (the pixel behind a microlens), channel. Pairs in Python are rows first, as in numpy;
text such as "60x40" is columns x rows, as on the command line. Options have the names and defaults of the command line.
Lengths are in meters unless a name says otherwise; disparities are in pixels between horizontally adjacent views,
positive nearer than the focus distance; light is linear unless an array holds integers.
"""

from . import _embree

_embree.find()

from ._holo import PlenopticCamera, Rig, __version__  # noqa: E402
from .camera_array import (  # noqa: E402
    CameraArray,
    Correspondences,
    DepthEstimate,
    Pinhole,
    SynthesizedImage,
    place_cameras,
)
from .dataset import Dataset, Job  # noqa: E402
from .display import Display  # noqa: E402
from .errors import Error, HoloWarning, OutOfMemoryError, UsageError  # noqa: E402
from .exporting import export, export_targets  # noqa: E402
from .images import read_image, write_image  # noqa: E402
from .light_field import LightField, open  # noqa: E402, A004
from .metrics import compare, evaluate  # noqa: E402
from .optics import optics  # noqa: E402
from .plenoptic import (  # noqa: E402
    Calibration,
    Decoded,
    calibrate,
    calibration_benchmark,
    decode,
    demosaic,
    develop,
    sensor_models,
)
from ._settings import Settings  # noqa: E402
from .rendering import Pose, RawRendering, Rendering, render, render_raw, render_to  # noqa: E402
from .scene import Mesh, Scene  # noqa: E402

__all__ = [
    "CameraArray",
    "Correspondences",
    "Dataset",
    "Calibration",
    "Decoded",
    "DepthEstimate",
    "Display",
    "Error",
    "HoloWarning",
    "Job",
    "LightField",
    "Mesh",
    "OutOfMemoryError",
    "Pinhole",
    "PlenopticCamera",
    "Pose",
    "RawRendering",
    "Rendering",
    "Rig",
    "Scene",
    "SynthesizedImage",
    "UsageError",
    "__version__",
    "compare",
    "calibrate",
    "calibration_benchmark",
    "decode",
    "demosaic",
    "develop",
    "evaluate",
    "export",
    "export_targets",
    "open",
    "optics",
    "place_cameras",
    "read_image",
    "render",
    "render_raw",
    "Settings",
    "render_to",
    "sensor_models",
    "write_image",
]
