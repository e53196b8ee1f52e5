"""The geometric MTF of the double Gauss by Optiland, which `tests/all/sharpness.rs` holds an edge in a raw image to.

    pip install optiland==0.6.3
    holo camera glass.toml > glass.full.toml        # prescription double-gauss, close_to_f_number 2.8
    python optiland_mtf.py glass.full.toml

The lens is focused at 1.5 m and sees points 1.25 m away (both from its entrance pupil): on the axis, and 120 mm from it. A line has the
place of the image, whether points are spread along the radius or around the axis, and the modulation at 0, 2 .. 20 cycles/mm: `stop` is
Optiland's own, whose rays are uniform in the stop; the rays of `pupil` are uniform in the entrance pupil, as light from afar is.
"""

import pathlib
import sys
import tomllib

import numpy as np
from optiland import optic
from optiland.materials import IdealMaterial
from optiland.mtf import GeometricMTF

import optiland_rays

LINE_NM = 587.5618
# Those of red, green and blue with `--spectral`.
COLORS_NM = (611.4, 549.1, 464.3)
FOCUS_MM, DEPTH_MM, HEIGHT_MM = 1500.0, 1250.0, 1250.0 * 5 / 52


def camera(surfaces, nm, stop_share, aiming):
    """The lens with the array as its image surface: focused for light of the d line, traced at a wavelength."""
    near = optiland_rays.lens(surfaces, LINE_NM).paraxial
    focal, back, front, pupil = (float(np.ravel(x)[0]) for x in (near.f2(), near.F2(), near.F1(), near.EPL()))
    # That lens ends 1 mm behind its last surface. Newton: x x' = f^2.
    image = back + 1.0 + focal**2 / (front - (pupil - FOCUS_MM))
    system = optic.Optic()
    system.surfaces.add(index=0, radius=np.inf, thickness=DEPTH_MM - pupil)
    for k, surface in enumerate(surfaces, 1):
        system.surfaces.add(
            index=k, radius=surface["radius_mm"] or np.inf, aperture=2 * surface["semi_aperture_mm"],
            thickness=surface["thickness_mm"] if k < len(surfaces) else image,
            material=IdealMaterial(optiland_rays.index(surface, nm)), is_stop=surface.get("stop", False),
        )
    system.surfaces.add(index=len(surfaces) + 1)
    stop = next(surface for surface in surfaces if surface.get("stop"))
    system.set_aperture(aperture_type="float_by_stop_size", value=2 * stop_share * stop["semi_aperture_mm"])
    system.fields.set_type(field_type="object_height")
    system.fields.add(y=0)
    system.fields.add(y=HEIGHT_MM)
    system.wavelengths.add(value=nm / 1000, is_primary=True)
    system.ray_tracer.set_aiming(aiming)
    return system


def main():
    surfaces = tomllib.loads(pathlib.Path(sys.argv[1]).read_text())["main_lens"]["surface"]
    found = GeometricMTF(camera(surfaces, LINE_NM, 1.0, "iterative"), num_rays=400, num_points=201, max_freq=20.0, scale=False)
    for curves, data in zip(found.mtf, found.data):
        for name, curve in zip(("along", "around"), curves):
            print(f"stop {np.nanmean(data[0].y):.4f} mm {name}", *(f"{x:.4f}" for x in curve[::20]))
    for nm in (LINE_NM, *COLORS_NM):
        # More than the pupil: the stop ends them.
        system = camera(surfaces, nm, 1.03, "paraxial")
        for field in (0, 1):
            rays = system.trace(0, field, nm / 1000, 400, "uniform")
            is_lit = (np.asarray(rays.i) > 0) & np.isfinite(np.asarray(rays.y))
            for name, places in (("along", rays.y), ("around", rays.x)):
                places = np.asarray(places)[is_lit]
                curve = [abs(np.exp(2j * np.pi * per_mm * places).mean()) for per_mm in np.arange(0, 21, 2)]
                print(f"pupil {nm} nm field {field} {name} at {places.mean():.5f} mm", *(f"{x:.4f}" for x in curve))


if __name__ == "__main__":
    main()
