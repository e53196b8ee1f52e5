"""Pickling of rigs; the class is native."""

from ._holo import Rig


def _rig_from_numbers(sizes, numbers, projection):
    focal, sensor, baseline_x, baseline_y, focus = numbers
    return Rig(
        *sizes,
        focal_length_m=focal,
        sensor_size_m=sensor,
        baseline_m=baseline_x,
        baseline_y_m=baseline_y,
        focus_distance_m=focus,
        projection=projection,
    )
