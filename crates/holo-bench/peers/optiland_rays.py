"""Rays, pupils and distortion of objectives by Optiland, which the tests of holo's lenses are held to.

    pip install optiland==0.6.3
    holo camera double-gauss.toml > double-gauss.full.toml     # and so on: cameras with their surfaces
    python optiland_rays.py double-gauss.full.toml .. > crates/holo-core/src/plenoptic/prescription/tests/optiland.csv

A line `lens` has the focal length, the distances of the image and of the pupils from the last and the first surface, and the
f-number. A line `ray` has the ray in front of the lens and behind it: places in the plane of the first vertex and in one 1 mm behind
the last, and slopes per unit length along the axis towards the sensor. Millimeters; wavelengths in nanometers.
"""

import pathlib
import sys
import tomllib

import numpy as np
from optiland import optic
from optiland.materials import IdealMaterial
from optiland.rays import RealRays

WAVELENGTHS = (486.1327, 587.5618, 656.2725)


def index(surface, nm):
    """Of air, or Cauchy's equation with two terms through nd and nF - nC."""
    nd, vd = surface.get("nd", 1.0), surface.get("vd")
    if vd is None:
        return nd
    per = 1 / nm**2 - 1 / 587.5618**2
    return nd + (nd - 1) / vd / (1 / 486.1327**2 - 1 / 656.2725**2) * per


def lens(surfaces, nm):
    out = optic.Optic()
    out.surfaces.add(index=0, radius=np.inf, thickness=np.inf)
    for k, surface in enumerate(surfaces, 1):
        thickness = surface["thickness_mm"] if k < len(surfaces) else 1.0
        coefficients = [0.0] + [surface.get(f"a{power}", 0.0) for power in range(4, 20, 2)]
        shape = {"surface_type": "even_asphere", "coefficients": coefficients, "tol": 1e-14} if any(coefficients) else {}
        radius = surface["radius_mm"] or np.inf
        material = IdealMaterial(index(surface, nm))
        out.surfaces.add(
            index=k, radius=radius, conic=surface.get("conic", 0.0), thickness=thickness, material=material,
            is_stop=surface.get("stop", False), **shape,
        )
    out.surfaces.add(index=len(surfaces) + 1)
    stop = next(surface for surface in surfaces if surface.get("stop"))
    out.set_aperture(aperture_type="float_by_stop_size", value=2 * stop["semi_aperture_mm"])
    out.fields.set_type(field_type="angle")
    out.fields.add(y=0)
    out.wavelengths.add(value=nm / 1000, is_primary=True)
    return out


def main():
    random = np.random.default_rng(1)
    for path in sys.argv[1:]:
        name = pathlib.Path(path).name.split(".")[0]
        surfaces = tomllib.loads(pathlib.Path(path).read_text())["main_lens"]["surface"]
        for nm in WAVELENGTHS:
            system = lens(surfaces, nm)
            near = system.paraxial
            numbers = [near.f2(), near.F2(), near.EPL(), near.XPL(), near.EPD()]
            print("lens", name, nm, *[repr(float(np.ravel(x)[0])) for x in numbers], sep=",")
            # Rays to the middle of the entrance pupil and around it, from many directions.
            pupil, radius = float(np.ravel(near.EPL())[0]), float(np.ravel(near.EPD())[0]) / 2
            slope = random.uniform(-0.25, 0.25, (2, 40))
            in_pupil = random.uniform(-0.8, 0.8, (2, 40)) * radius
            place = in_pupil - slope * pupil
            n = 1 / np.sqrt(1 + (slope**2).sum(0))
            one = np.ones(40)
            rays = RealRays(*place, -10 * one, slope[0] * n, slope[1] * n, n, one, nm / 1000 * one)
            rays.x, rays.y = place - 10 * slope
            # Half of them come from below, where signs are others.
            system.surfaces.trace(rays)
            for k in range(40):
                behind = [rays.x[k], rays.y[k], rays.L[k] / rays.N[k], rays.M[k] / rays.N[k]]
                if np.isfinite(behind).all():
                    row = [*place[:, k], *slope[:, k], *behind]
                    print("ray", name, nm, *[repr(float(x)) for x in row], sep=",")


if __name__ == "__main__":
    main()
