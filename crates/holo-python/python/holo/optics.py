"""What a camera will see before anything is rendered."""

from __future__ import annotations

from . import _holo
from ._holo import Rig
from ._options import texts_of


def optics(
    *,
    focal_mm: float,
    views=None,
    lenses=None,
    sensor=None,
    sensor_mm: float | None = None,
    f_number: float | None = None,
    baseline_m: float | None = None,
    focus_m: float | str | None = None,
    disparity: tuple[float, float] | None = None,
    lens_pitch_mm: float | None = None,
    depths_m: tuple[float, float] | None = None,
) -> Rig:
    """The rig of a camera that is planned without a scene, as `holo optics` makes it.

    depths_m: nearest and farthest depth, which an automatic focus or a range of disparities need.
    lens_pitch_mm: the distance between microlenses, instead of a number of views.

    `optics(...).optics(depths_m)` are depth of field, angles and sizes.
    """
    options = dict(
        focal_mm=focal_mm,
        views=views,
        lenses=lenses,
        sensor=sensor,
        sensor_mm=sensor_mm,
        f_number=f_number,
        baseline_m=baseline_m,
        focus_m=focus_m,
        disparity=disparity,
    )
    return _holo.planned_rig(texts_of(options), depths_m, lens_pitch_mm)
