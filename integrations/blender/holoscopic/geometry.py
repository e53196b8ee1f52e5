# SPDX-License-Identifier: GPL-3.0-or-later
"""The numbers of a rig before anything is rendered: sizes, baseline, disparity. Nothing of Blender is used here."""

import math

# (width, height) in pixels.
SENSORS = {"hd": (1920, 1080), "4k": (3840, 2160), "8k": (7952, 5304), "uhd8k": (7680, 4320)}

# The f-number whose aperture the views share without a baseline of their own.
F_NUMBER = 5.0


def lenses(sensor, views):
    """Microlenses (columns, rows) of a sensor of (width, height) pixels: the pixels of a view (Eq. 1)."""
    return (sensor[0] // max(views[0], 1), sensor[1] // max(views[1], 1))


def automatic_baseline_m(focal_m, f_number, views):
    """The distance between adjacent views that share the aperture of an f/`f_number` lens, m."""
    count = max(views)
    return focal_m / f_number / (count - 1) if count > 1 else 0.0


def automatic_focus_m(near_m, far_m):
    """The harmonic mean of the nearest and the farthest depth, m: disparities are symmetric about 0."""
    return 2.0 / (1.0 / near_m + (1.0 / far_m if math.isfinite(far_m) else 0.0))


def disparity_px(depth_m, focus_m, baseline_m, focal_m, sensor_m, pixels):
    """Pixels between adjacent views at a depth (Eq. 3); `sensor_m` and `pixels` are those of the larger image side."""
    inverse = 1.0 / depth_m if math.isfinite(depth_m) else 0.0
    return baseline_m * focal_m / sensor_m * pixels * (inverse - (1.0 / focus_m if math.isfinite(focus_m) else 0.0))


def rig_of_disparities(low_px, high_px, near_m, far_m, focal_m, sensor_m, pixels):
    """Baseline and focus distance, m, at which the depths have the disparities `high_px` (near) to `low_px` (far)."""
    near, far = 1.0 / near_m, 1.0 / far_m if math.isfinite(far_m) else 0.0
    baseline_m = (high_px - low_px) / (near - far) / (focal_m / sensor_m * pixels)
    inverse = far - low_px / (high_px - low_px) * (near - far)
    return baseline_m, 1.0 / inverse if inverse > 0.0 else math.inf


def samples_text(spp):
    """The text of `--spp`: a whole number, or below 1 the nearest of 1/2, 1/4, ... 1/64 (on a logarithmic scale)."""
    if spp >= 1.0:
        return str(round(spp))
    power = min(round(-math.log2(max(spp, 1 / 64))), 6)
    return f"1/{2**power}" if power else "1"
