"""Renders the scenes of this folder with Mitsuba 3: references, their noise, the speed of a grid of views, checks of the conventions.

    mitsuba_reference.py SCENE.glb --out REFERENCE.pfm --depth 9 --spp 4096 --passes 8     central view, and its noise from two halves
    mitsuba_reference.py SCENE.glb --out LENS.pfm --lens 0.03 --depth 2 ..                 through a thin lens of this radius, m
    mitsuba_reference.py SCENE.glb --views 400 --spp 16 --repeat 3 --depth 9               prints Msamples/s at 79 x 53
    mitsuba_reference.py --check                                                           conventions against closed forms

`--environment FILE.hdr` or `--sky R,G,B` (default 0.2,0.24,0.32) says what surrounds the scene. `--depth` is Mitsuba's max_depth:
scattering events + 1. `--plugins mitsuba` takes Mitsuba's own nearest surfaces in place of glTF's: slightly other images, the same work.
Needs mitsuba 3.9, numpy, pillow, and an LLVM that Dr.Jit finds (`DRJIT_LIBLLVM_PATH`).
"""
import argparse
import io
import math
import os
import time

import numpy as np

import mitsuba as mi

mi.set_variant(os.environ.get("MITSUBA_VARIANT", "llvm_ad_rgb"))

import drjit as dr
from mitsuba import ScalarTransform4f as T
from PIL import Image

import gltf_bsdfs  # noqa: F401 (registers the plugins)
from files import Glb, read_hdr, rotation, write_pfm

FOCUS_M, BASELINE_M = 0.8, 0.002

# Mitsuba's rays start 9e-5 (1 + |p|) off a surface at p: in centimeters the 1 does not matter.
UNITS = 100.0


def linear(codes):
    """Linear light of 8-bit sRGB codes."""
    x = codes.astype(np.float64) / 255
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4).astype(np.float32)


def color(value):
    return {"type": "rgb", "value": [float(x) for x in value]}


def base_texture(glb, pbr):
    factor = np.array(pbr.get("baseColorFactor", [1, 1, 1, 1])[:3], np.float32)
    if "baseColorTexture" not in pbr:
        return color(factor)
    texture = glb.document["textures"][pbr["baseColorTexture"]["index"]]
    encoded = glb.view(glb.document["images"][texture["source"]]["bufferView"])
    texels = linear(np.array(Image.open(io.BytesIO(encoded)).convert("RGB"))) * factor
    # As numbers: linear before they are interpolated, and not in half precision.
    return {"type": "bitmap", "data": mi.TensorXf(texels), "raw": True, "format": "variant", "wrap_mode": "repeat"}


def surface(glb, material, plugins):
    """The description of a material for Mitsuba."""
    pbr = material.get("pbrMetallicRoughness", {})
    extension = lambda name: material.get("extensions", {}).get(f"KHR_materials_{name}", {})
    base, roughness = base_texture(glb, pbr), float(pbr.get("roughnessFactor", 1.0))
    alpha, ior = roughness * roughness, float(extension("ior").get("ior", 1.5))
    specular = float(extension("specular").get("specularFactor", 1.0))
    ours = plugins == "gltf"
    twosided = lambda inner: {"type": "twosided", "bsdf": inner}
    if pbr.get("metallicFactor", 1.0) == 1:
        if ours:
            return {"type": "gltf_metal", "base": base, "roughness": roughness}
        return twosided({"type": "roughconductor", "distribution": "ggx", "alpha": alpha, "material": "none", "specular_reflectance": base})
    if extension("transmission").get("transmissionFactor", 0) == 1:
        volume = extension("volume")
        thin = volume.get("thicknessFactor", 0) == 0
        if ours:
            absorption = -np.log(volume.get("attenuationColor", [1.0] * 3)) / (volume.get("attenuationDistance", math.inf) * UNITS)
            entry = {"type": "gltf_glass", "base": base, "roughness": roughness, "ior": ior, "thin": thin}
            return entry | {f"absorption_{c}": float(a) for c, a in zip("rgb", absorption)}
        if thin:
            return {"type": "thindielectric", "int_ior": ior, "ext_ior": 1.0, "specular_transmittance": base}
        if roughness > 0:
            return {"type": "roughdielectric", "distribution": "ggx", "alpha": alpha, "int_ior": ior, "ext_ior": 1.0}
        return {"type": "dielectric", "int_ior": ior, "ext_ior": 1.0}
    if specular == 0:
        return {"type": "gltf_lambert", "base": base} if ours else twosided({"type": "diffuse", "reflectance": base})
    if ours:
        return {"type": "gltf_varnish", "base": base, "roughness": roughness, "ior": ior, "specular": specular}
    plastic = {"type": "roughplastic", "distribution": "ggx", "alpha": alpha, "int_ior": ior, "ext_ior": 1.0, "nonlinear": True}
    return twosided(plastic | {"diffuse_reflectance": base})


def mesh(name, positions, normals, coordinates, triangles, bsdf, emission=None):
    """A shape from arrays; flat without normals."""
    props = mi.Properties()
    props["bsdf"] = mi.load_dict(bsdf)
    if emission is not None:
        props["emitter"] = mi.load_dict({"type": "area", "radiance": color(emission)})
    if normals is None:
        props["face_normals"] = True
    shape = mi.Mesh(name, len(positions), len(triangles), has_vertex_normals=normals is not None, has_vertex_texcoords=coordinates is not None, props=props)
    parameters = mi.traverse(shape)
    parameters["vertex_positions"] = positions.astype(np.float32).ravel()
    parameters["faces"] = triangles.astype(np.uint32).ravel()
    if normals is not None:
        parameters["vertex_normals"] = normals.astype(np.float32).ravel()
    if coordinates is not None:
        parameters["vertex_texcoords"] = coordinates.astype(np.float32).ravel()
    parameters.update()
    return shape


def shapes(glb, plugins):
    """Every node with a mesh, by name."""
    document, out = glb.document, {}
    for node in document["nodes"]:
        if "mesh" not in node:
            continue
        (primitive,) = document["meshes"][node["mesh"]]["primitives"]
        material = document["materials"][primitive["material"]]
        read = lambda key: glb.accessor(primitive["attributes"][key]) if key in primitive["attributes"] else None
        positions = (read("POSITION") + np.array(node.get("translation", [0, 0, 0]), np.float64)) * UNITS
        triangles = glb.accessor(primitive["indices"]).reshape(-1, 3)
        strength = material.get("extensions", {}).get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
        emission = np.array(material.get("emissiveFactor", [0, 0, 0])) * strength
        name = node["name"].replace(" ", "_")
        bsdf = surface(glb, material, plugins)
        out[name] = mesh(name, positions, read("NORMAL"), read("TEXCOORD_0"), triangles, bsdf, emission if emission.any() else None)
    return out


def punctual(glb):
    """The lights of KHR_lights_punctual: lux is irradiance, candela intensity."""
    document, out = glb.document, {}
    for node in document["nodes"]:
        placed = node.get("extensions", {}).get("KHR_lights_punctual")
        if placed is None:
            continue
        light = document["extensions"]["KHR_lights_punctual"]["lights"][placed["light"]]
        power = color(np.array(light.get("color", [1, 1, 1])) * light["intensity"])
        if light["type"] == "directional":
            direction = rotation(node["rotation"]) @ [0, 0, -1]
            out[f"light_{node['name']}"] = {"type": "directional", "direction": direction.tolist(), "irradiance": power}
        else:
            power["value"] = [x * UNITS**2 for x in power["value"]]
            position = [x * UNITS for x in node["translation"]]
            out[f"light_{node['name']}"] = {"type": "point", "position": position, "intensity": power}
    return out


def environment(radiance):
    """An emitter for a map by our convention: u = 1/2 + atan2(z, x) / (2 pi), v = acos(y) / pi, texels at their centers.

    Mitsuba has its first and last row *at* the poles. With twice the rows plus one, its knots fall on the borders and centers of ours,
    and bilinear interpolation is the same function. Its u is atan2(x', -z') / (2 pi): ours with x' = -z, z' = x.
    """
    rows = len(radiance)
    place = np.clip(np.arange(2 * rows + 1) / 2 - 0.5, 0, rows - 1)
    lower = np.minimum(place.astype(int), rows - 2)
    part = (place - lower)[:, None, None].astype(np.float32)
    finer = radiance[lower] * (1 - part) + radiance[lower + 1] * part
    turn = [[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]]
    return {"type": "envmap", "bitmap": mi.Bitmap(np.ascontiguousarray(finer, np.float32)), "to_world": T(turn)}


def camera(glb):
    """Position, axes (columns x, y, z) and the tangent of half the horizontal angle."""
    node = next(node for node in glb.document["nodes"] if "camera" in node)
    lens = glb.document["cameras"][node["camera"]]["perspective"]
    return np.array(node["translation"]), rotation(node["rotation"]), math.tan(lens["yfov"] / 2) * lens["aspectRatio"]


def sensor(pose, width, height, offset=(0.0, 0.0), lens_m=0.0):
    """A view of the off-axis rig, `offset` meters to the right and up of the center; or a lens in focus where the views are."""
    position, axes, tangent = pose
    origin = (position + axes @ [*offset, 0]) * UNITS
    shift = 1 / (2 * tangent * FOCUS_M)
    kind = {"type": "thinlens", "aperture_radius": lens_m * UNITS, "focus_distance": FOCUS_M * UNITS}
    if lens_m == 0:
        across, down = -offset[0] * shift, offset[1] * shift * width / height
        kind = {"type": "perspective", "principal_point_offset_x": across, "principal_point_offset_y": down}
    return kind | {
        "fov": 2 * math.degrees(math.atan(tangent)), "fov_axis": "x", "near_clip": 0.01,
        "to_world": T().look_at(origin=origin.tolist(), target=(origin - axes[:, 2]).tolist(), up=axes[:, 1].tolist()),
        "film": {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"}, "pixel_format": "rgb", "component_format": "float32"},
    }


def describe(path, surround, depth, plugins="gltf"):
    """The scene without a sensor, and the pose of its camera."""
    glb = Glb(path)
    scene = {"type": "scene", "integrator": {"type": "path", "max_depth": depth, "rr_depth": 100000}}
    return scene | shapes(glb, plugins) | punctual(glb) | {"surround": surround}, camera(glb)


def render_central(scene, pose, spp, passes, seed, sampler="multijitter", lens_m=0.0, width=99, height=66):
    """The mean of `passes` renders, in double precision, and of its two halves."""
    loaded = mi.load_dict(scene | {"sensor": sensor(pose, width, height, lens_m=lens_m) | {"sampler": {"type": sampler, "sample_count": spp}}})
    halves = np.zeros((2, height, width, 3))
    for k in range(passes):
        halves[k % 2] += np.array(mi.render(loaded, spp=spp, seed=seed + k), np.float64)
    halves /= passes / 2
    return halves.mean(axis=0), halves


def grid(scene, pose, views, width=79, height=53, sampler="independent"):
    """The scene with a square grid of views in one `batch`."""
    side = math.isqrt(views)
    film = {"type": "hdrfilm", "width": width * side * side, "height": height, "rfilter": {"type": "box"}, "pixel_format": "rgb"}
    batch = {"type": "batch", "film": film, "sampler": {"type": sampler}}
    for row in range(side):
        for column in range(side):
            offset = ((column - (side - 1) / 2) * BASELINE_M, ((side - 1) / 2 - row) * BASELINE_M)
            batch[f"view_{row * side + column:05d}"] = sensor(pose, width, height, offset)
    return mi.load_dict(scene | {"sensor": batch}), width * height * side * side


def check():
    """Conventions that have closed forms. Prints what it finds; stops at the first that is off."""
    def image(scene, spp=64, width=16, height=16, fov=40.0, origin=(0, 0, 0), target=(0, 0, -1), depth=9, up=(0, 1, 0)):
        camera = {"type": "perspective", "fov": fov, "near_clip": 1e-3, "to_world": T().look_at(origin=list(origin), target=list(target), up=list(up)),
                  "film": {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"}, "pixel_format": "rgb", "component_format": "float32"}}
        loaded = mi.load_dict({"type": "scene", "integrator": {"type": "path", "max_depth": depth, "rr_depth": 100000}, "sensor": camera} | scene)
        return np.array(mi.render(loaded, spp=spp))

    def report(name, found, expected, bound):
        error = np.max(np.abs(np.asarray(found, float) - np.asarray(expected, float)))
        print(f"{name}: off by {error:.2e} (bound {bound:.0e})", flush=True)
        assert error < bound, (found, expected)

    # Environment: bright texels where our formula has them, looked at from inside through a narrow lens.
    rows, columns = 16, 32
    radiance = np.random.default_rng(1).random((rows, columns, 3)).astype(np.float32)
    worst = 0.0
    for row, column in [(3, 5), (8, 0), (8, 31), (12, 20), (1, 9), (0, 16), (15, 3)]:
        for across, down in [(0.5, 0.5), (0.9, 0.7)]:
            u, v = (column + across) / columns, (row + down) / rows
            azimuth, polar = (u - 0.5) * 2 * math.pi, v * math.pi
            d = np.array([math.sin(polar) * math.cos(azimuth), math.cos(polar), math.sin(polar) * math.sin(azimuth)])
            found = image({"e": environment(radiance)}, target=d, fov=0.001, width=1, height=1, spp=16, up=(0, 1, 0.01)).reshape(3)
            x, y = u * columns - 0.5, min(max(v * rows - 0.5, 0), rows - 1)
            i, j = math.floor(x), min(int(y), rows - 2)
            fx, fy = x - i, y - j
            at = lambda j, i: radiance[j, i % columns].astype(float)
            expected = (at(j, i) * (1 - fx) + at(j, i + 1) * fx) * (1 - fy) + (at(j + 1, i) * (1 - fx) + at(j + 1, i + 1) * fx) * fy
            worst = max(worst, np.max(np.abs(found - expected)))
    report("environment map, 14 directions", worst, 0, 2e-4)

    # Energy: under a white sky whatever absorbs nothing and is lossless is invisible; single scattering loses its known share.
    sky = {"sky": {"type": "constant", "radiance": color([1, 1, 1])}}
    square = np.array([[-1, -1, -2.0], [1, -1, -2], [1, 1, -2], [-1, 1, -2]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    plane = lambda bsdf: {"p": mesh("p", square, None, None, faces, bsdf)} | sky
    report("white Lambert", image(plane({"type": "gltf_lambert", "base": color([1] * 3)}), spp=1024).mean(), 1, 5e-4)
    report("thin white pane", image(plane({"type": "gltf_glass", "base": color([1] * 3), "thin": True}), spp=1024).mean(), 1, 5e-4)
    for roughness in (0.3, 0.5):
        metal = mi.load_dict({"type": "gltf_metal", "base": color([1] * 3), "roughness": roughness})
        table, _ = gltf_bsdfs.albedo_table(roughness**2, 1.0, 1.0)
        for cosine in (1.0, 0.5, 0.15):
            expected = np.interp(cosine, np.linspace(0, 1, len(table)), table)
            found = drawn(metal, cosine)[0]
            report(f"white metal of roughness {roughness}, cosine {cosine}, reflects {found:.5f}", found, expected, 3e-4)
        varnish = mi.load_dict({"type": "gltf_varnish", "base": color([1] * 3), "roughness": roughness})
        for cosine in (1.0, 0.5, 0.15):
            report(f"white varnish of roughness {roughness}, cosine {cosine}, is lossless", drawn(varnish, cosine)[0], 1, 5e-4)

    # A slab of absorbing glass, seen at a right angle: R + (1-R)^2 t^2 R + ... reflected and (1-R)^2 t / (1 - R^2 t^2) transmitted.
    low, high = [-50, -50, -1], [50, 50, 1]
    corners = np.array([[(low, high)[k >> axis & 1][axis] for axis in range(3)] for k in range(8)], float)
    quads = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    box = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
    absorption = [0.05, 0.2, 0.6]
    glass = {"type": "gltf_glass", "base": color([1] * 3), "ior": 1.5} | {f"absorption_{c}": a for c, a in zip("rgb", absorption)}
    found = image({"s": mesh("s", corners, None, None, box, glass)} | sky, spp=65536, fov=0.5, depth=40, origin=(0, 0, 10)).mean(axis=(0, 1))
    r, t = 0.04, np.exp(-np.array(absorption) * 2)
    expected = r + (1 - r) ** 2 * t * t * r / (1 - r * r * t * t) + (1 - r) ** 2 * t / (1 - r * r * t * t)
    report("absorbing slab", found, expected, 1e-3)

    # Sampling agrees with density: directions drawn, against the density integrated, for every plugin from several directions.
    for name, extra in [("metal", {}), ("varnish", {}), ("glass", {})]:
        bsdf = mi.load_dict({"type": f"gltf_{name}", "base": color([0.5, 0.7, 0.9]), "roughness": 0.5} | extra)
        for cosine in (0.95, 0.4, -0.4, -0.95):
            worst = sampling_error(bsdf, cosine)
            report(f"{name} of roughness 0.5, cosine {cosine}: sampled against integrated value", worst, 0, 5e-4)


def arriving(cosine):
    """A ray that meets a surface at this cosine; below 0 at its back, after 0.1 m."""
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.n, si.sh_frame, si.t = mi.Normal3f(0, 0, 1), mi.Frame3f(mi.Normal3f(0, 0, 1)), mi.Float(0.1)
    si.wi = mi.Vector3f(math.sqrt(1 - cosine * cosine), 0, cosine)
    return si


def drawn(bsdf, cosine, count=1 << 22):
    """Means over samples: the weights of the three channels, and the share of directions that are any good."""
    random = mi.PCG32(size=count)
    bs, weight = bsdf.sample(mi.BSDFContext(), arriving(cosine), random.next_float32(), mi.Point2f(random.next_float32(), random.next_float32()), True)
    return np.array([dr.mean(c)[0] for c in weight] + [dr.mean(dr.select(bs.pdf > 0, mi.Float(1), 0))[0]])


def sampling_error(bsdf, cosine):
    """The largest difference between what samples give and the integral over the sphere of values and density."""
    side = 2048
    k = dr.arange(mi.UInt32, side * side)
    wo = mi.warp.square_to_uniform_sphere(mi.Point2f((mi.Float(k % side) + 0.5) / side, (mi.Float(k // side) + 0.5) / side))
    f, density = bsdf.eval_pdf(mi.BSDFContext(), arriving(cosine), wo, True)
    integrated = np.array([dr.mean(c)[0] for c in f] + [dr.mean(density)[0]]) * 4 * math.pi
    return np.max(np.abs(drawn(bsdf, cosine) - integrated))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", nargs="?")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--environment")
    parser.add_argument("--sky", default="0.2,0.24,0.32")
    parser.add_argument("--depth", type=int, default=9)
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--passes", type=int, default=2, help="renders that are averaged; an even number")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--sampler", choices=["multijitter", "independent"], default="multijitter", help="for the central view")
    parser.add_argument("--lens", type=float, default=0.0, help="radius of a thin lens, m; 0: a pinhole")
    parser.add_argument("--out")
    parser.add_argument("--views", type=int, help="a square number: measure the speed")
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--plugins", choices=["gltf", "mitsuba"], default="gltf")
    a = parser.parse_args()
    if a.check:
        return check()
    surround = environment(read_hdr(a.environment)) if a.environment else {"type": "constant", "radiance": color(a.sky.split(","))}
    scene, pose = describe(a.scene, surround, a.depth, a.plugins)
    if a.views:
        loaded, pixels = grid(scene, pose, a.views)
        np.array(mi.render(loaded, spp=a.spp, seed=99))
        times, processor = [], []
        for k in range(a.repeat):
            start, used = time.time(), time.process_time()
            np.array(mi.render(loaded, spp=a.spp, seed=k))
            times.append(time.time() - start)
            processor.append(time.process_time() - used)
        samples = pixels * a.spp / 1e6
        print(f"mitsuba views={a.views} spp={a.spp} max_depth={a.depth} plugins={a.plugins} seconds={min(times):.3f} "
              f"Msamples/s={samples / min(times):.3f} Msamples/processor-second={samples / min(processor):.3f}")
        return
    start = time.time()
    image, halves = render_central(scene, pose, a.spp, a.passes, a.seed, a.sampler, a.lens)
    seconds = time.time() - start
    difference = (halves[0] - halves[1]) / 2
    noise = math.sqrt(np.mean(difference**2))
    relative = np.mean(difference**2 / (image**2 + 0.01))
    print(f"{a.scene} max_depth={a.depth} samples={a.spp * a.passes} plugins={a.plugins} seconds={seconds:.0f} mean={image.mean():.5f} RMSE={noise:.5f} relMSE={relative:.2e} largest={np.abs(difference).max():.4f}")
    if a.out:
        write_pfm(a.out, image)


if __name__ == "__main__":
    main()
