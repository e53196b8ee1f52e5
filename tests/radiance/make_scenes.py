"""Makes the scenes of this folder: `metal_and_glass.glb`, `window.glb` and `window_sky.hdr`. Needs numpy alone; always the same bytes
(but for what another version of zlib may make of the textures). Usage: make_scenes.py [FOLDER]
"""
import math
import os
import sys

import numpy as np

from files import GlbWriter, png, write_hdr

SENSOR_TO_FOCAL = 36.0 / 45.0  # width of the image over its distance


# Shapes: (positions, normals or None, texture coordinates or None, triangles), meters, counter-clockwise from outside.


def lathe(profile, segments):
    """Turns the points (radius, height), lowest first, around the y axis; smooth. Ends at radius 0 close it."""
    profile = np.array(profile, float)
    slope = np.gradient(profile, axis=0)
    across = np.stack([slope[:, 1], -slope[:, 0]], axis=1)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    across[profile[:, 0] == 0] = [[0, np.sign(a[1])] for a in across[profile[:, 0] == 0]]
    angle = np.arange(segments) * (2 * math.pi / segments)
    c, s = np.cos(angle), np.sin(angle)
    around = lambda r, y: np.stack([np.outer(r, c), np.repeat(y[:, None], segments, axis=1), -np.outer(r, s)], axis=-1).reshape(-1, 3)
    triangles = []
    for k in range(len(profile) - 1):
        for j in range(segments):
            a, b = k * segments + j, k * segments + (j + 1) % segments
            if profile[k, 0] > 0:
                triangles.append([a, b, b + segments])
            if profile[k + 1, 0] > 0:
                triangles.append([a, b + segments, a + segments])
    return around(profile[:, 0], profile[:, 1]), around(across[:, 0], across[:, 1]), None, np.array(triangles)


def ball(radius, segments, rings):
    angles = np.linspace(-math.pi / 2, math.pi / 2, rings + 1)
    profile = np.stack([radius * np.cos(angles), radius * np.sin(angles)], axis=1)
    profile[[0, -1], 0] = 0
    positions, _, _, triangles = lathe(profile, segments)
    return positions, positions / radius, None, triangles


def torus(radius, thickness, segments, rings):
    """Lies in the plane y = 0."""
    a, b = np.meshgrid(np.arange(segments) * 2 * math.pi / segments, np.arange(rings) * 2 * math.pi / rings, indexing="ij")
    normals = np.stack([np.cos(a) * np.cos(b), np.sin(b), -np.sin(a) * np.cos(b)], axis=-1)
    centers = radius * np.stack([np.cos(a), 0 * a, -np.sin(a)], axis=-1)
    i, j = np.meshgrid(np.arange(segments), np.arange(rings), indexing="ij")
    index = lambda i, j: (i % segments) * rings + j % rings
    corners = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)]
    triangles = np.stack([np.stack([corners[p] for p in t], axis=-1) for t in ([0, 1, 2], [0, 2, 3])], axis=2)
    return (centers + thickness * normals).reshape(-1, 3), normals.reshape(-1, 3), None, triangles.reshape(-1, 3)


def geodesic(radius, divisions):
    """An icosahedron, every edge halved `divisions` times, with flat faces."""
    g = (1 + math.sqrt(5)) / 2
    corners = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8),
             (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    positions = [np.array(c) / np.linalg.norm(c) for c in corners]
    for _ in range(divisions):
        middles, finer = {}, []

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                m = positions[a] + positions[b]
                middles[key] = len(positions)
                positions.append(m / np.linalg.norm(m))
            return middles[key]

        for a, b, c in faces:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        faces = finer
    return radius * np.array(positions), None, None, np.array(faces)


def prism(sides, radius, height, bevel):
    """An upright prism standing on y = 0 with bevelled rims and flat faces; closed."""
    rings = [(radius - bevel, 0.0), (radius, bevel), (radius, height - bevel), (radius - bevel, height)]
    angle = (np.arange(sides) + 0.5) * (2 * math.pi / sides)
    positions = [[r * math.cos(a), y, -r * math.sin(a)] for r, y in rings for a in angle]
    triangles = []
    for k in range(3):
        for j in range(sides):
            a, b = k * sides + j, k * sides + (j + 1) % sides
            triangles += [[a, b, b + sides], [a, b + sides, a + sides]]
    triangles += [[0, j + 1, j] for j in range(1, sides - 1)]
    top = 3 * sides
    triangles += [[top, top + j, top + j + 1] for j in range(1, sides - 1)]
    return np.array(positions), None, None, np.array(triangles)


def rectangle(corner, along, up, repeat=None):
    """A flat rectangle whose front is where `along` x `up` points; texture coordinates run along, and down against `up`."""
    corner, along, up = np.array(corner, float), np.array(along, float), np.array(up, float)
    positions = np.array([corner, corner + along, corner + along + up, corner + up])
    coordinates = None
    if repeat:
        coordinates = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], float) * repeat
    return positions, None, coordinates, np.array([[0, 1, 2], [0, 2, 3]])


def box(low, high):
    """A box with flat faces."""
    low, high = np.array(low, float), np.array(high, float)
    positions = np.array([[(low, high)[k >> axis & 1][axis] for axis in range(3)] for k in range(8)])
    quads = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    return positions, None, None, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def turned_y(shape, degrees):
    positions, normals, coordinates, triangles = shape
    a = math.radians(degrees)
    turn = np.array([[math.cos(a), 0, math.sin(a)], [0, 1, 0], [-math.sin(a), 0, math.cos(a)]])
    return positions @ turn.T, None if normals is None else normals @ turn.T, coordinates, triangles


# Textures: 8-bit sRGB codes.


def tiles(size, count, light, dark):
    """A board of soft-edged fields, each of a slightly different color."""
    y, x = (np.mgrid[0:size, 0:size] + 0.5) / size * count
    wave = np.clip(0.5 + 2.5 * np.sin(math.pi * x) * np.sin(math.pi * y), 0, 1)[..., None]
    shade = 1 - 0.25 * ((np.floor(x) * 3 + np.floor(y) * 5) % 7 / 7)[..., None]
    return np.rint((np.array(light) * wave + np.array(dark) * (1 - wave)) * shade).astype(np.uint8)


def stripes(size, count, colors):
    """Diagonal bands of several colors, darker towards the bottom."""
    y, x = (np.mgrid[0:size, 0:size] + 0.5) / size
    place = ((x + y) * count) % len(colors)
    lower = np.floor(place).astype(int)
    part = np.clip((place - lower - 0.7) / 0.3, 0, 1)[..., None]
    colors = np.array(colors, float)
    mixed = colors[lower] * (1 - part) + colors[(lower + 1) % len(colors)] * part
    return np.rint(mixed * (1 - 0.3 * y[..., None])).astype(np.uint8)


# The writer's side of scenes.


class SceneWriter:
    """A .glb with one mesh a material and one node a mesh."""

    def __init__(self):
        self.glb = GlbWriter()
        self.used = set()

    def material(self, name, color=(1, 1, 1), metallic=0.0, roughness=1.0, texture=None, emission=None, **extensions):
        pbr = {"baseColorFactor": [*color, 1.0], "metallicFactor": metallic, "roughnessFactor": roughness}
        if texture is not None:
            image = self.glb.append("images", {"bufferView": self.glb.view(png(texture)), "mimeType": "image/png"})
            if "samplers" not in self.glb.document:
                self.glb.append("samplers", {"magFilter": 9729, "minFilter": 9729, "wrapS": 10497, "wrapT": 10497})
            pbr["baseColorTexture"] = {"index": self.glb.append("textures", {"source": image, "sampler": 0})}
        entry = {"name": name, "pbrMetallicRoughness": pbr}
        if emission is not None:
            entry["emissiveFactor"], strength = emission
            extensions["emissive_strength"] = {"emissiveStrength": strength}
        else:
            entry["doubleSided"] = True
        if extensions:
            entry["extensions"] = {f"KHR_materials_{key}": value for key, value in extensions.items()}
            self.used |= set(entry["extensions"])
        return self.glb.append("materials", entry)

    def lambert(self, name, color=(1, 1, 1), texture=None):
        return self.material(name, color, texture=texture, specular={"specularFactor": 0.0})

    def add(self, name, shape, material, at=None):
        positions, normals, coordinates, triangles = shape
        attributes = {"POSITION": self.glb.accessor(positions)}
        if normals is not None:
            attributes["NORMAL"] = self.glb.accessor(normals)
        if coordinates is not None:
            attributes["TEXCOORD_0"] = self.glb.accessor(coordinates)
        primitive = {"attributes": attributes, "indices": self.glb.accessor(triangles.ravel()), "material": material}
        node = {"name": name, "mesh": self.glb.append("meshes", {"name": name, "primitives": [primitive]})}
        if at is not None:
            node["translation"] = list(at)
        self.glb.append("nodes", node)

    def light(self, name, entry, node):
        lights = self.glb.document.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {"lights": []})["lights"]
        lights.append({"name": name, **entry})
        self.used.add("KHR_lights_punctual")
        self.glb.append("nodes", {"name": name, **node, "extensions": {"KHR_lights_punctual": {"light": len(lights) - 1}}})

    def camera(self, position, target):
        half = SENSOR_TO_FOCAL / 2
        lens = {"yfov": 2 * math.atan(half / 1.5), "aspectRatio": 1.5, "znear": 0.01, "zfar": 100.0}
        camera = self.glb.append("cameras", {"name": "camera", "type": "perspective", "perspective": lens})
        node = {"name": "camera", "camera": camera, "translation": list(position), "rotation": looking(np.subtract(target, position))}
        self.glb.append("nodes", node)

    def write(self, path):
        document = self.glb.document
        document["extensionsUsed"] = sorted(self.used)
        document["scene"], document["scenes"] = 0, [{"nodes": list(range(len(document["nodes"])))}]
        self.glb.write(path)


def looking(direction):
    """The quaternion that turns -z to a direction and keeps x level."""
    d = np.array(direction, float)
    yaw = math.atan2(-d[0], -d[2])
    pitch = math.atan2(d[1], math.hypot(d[0], d[2]))
    sy, cy, sp, cp = math.sin(yaw / 2), math.cos(yaw / 2), math.sin(pitch / 2), math.cos(pitch / 2)
    return [cy * sp, sy * cp, -sy * sp, cy * cp]


def rounded(points, steps):
    """A smooth curve through the points (Catmull-Rom), `steps` pieces between neighbors."""
    p = np.array([points[0], *points, points[-1]], float)
    out = []
    for k in range(1, len(p) - 2):
        for t in np.arange(steps) / steps:
            a, b, c, d = p[k - 1 : k + 3]
            out.append(0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3))
    out.append(p[-2])
    out = np.array(out)
    out[[0, -1], 0] = 0
    return out


VASE = rounded([(0, 0.001), (0.036, 0.003), (0.05, 0.03), (0.042, 0.08), (0.022, 0.12), (0.02, 0.145), (0.03, 0.165), (0, 0.17)], 3)


def metal_and_glass(path):
    scene = SceneWriter()
    floor = scene.lambert("floor", texture=tiles(96, 6, (226, 214, 190), (120, 128, 148)))
    wall = scene.lambert("wall", (0.9, 0.9, 0.9), stripes(96, 8, [(214, 160, 120), (232, 224, 206), (130, 168, 178), (232, 224, 206)]))
    gold = scene.material("gold", (0.95, 0.68, 0.3), metallic=1.0, roughness=0.3)
    steel = scene.material("steel", (0.5, 0.6, 0.75), metallic=1.0, roughness=0.5)
    frosted = scene.material("frosted", roughness=0.3, transmission={"transmissionFactor": 1.0}, ior={"ior": 1.5}, volume={"thicknessFactor": 0.1})
    emerald = scene.material(
        "emerald", roughness=0.0, transmission={"transmissionFactor": 1.0}, ior={"ior": 1.5},
        volume={"thicknessFactor": 0.05, "attenuationDistance": 0.05, "attenuationColor": [0.25, 0.8, 0.45]},
    )
    pane = scene.material("pane", (0.95, 0.7, 0.5), roughness=0.0, transmission={"transmissionFactor": 1.0}, ior={"ior": 1.5})
    varnish = scene.material("varnish", (0.7, 0.07, 0.05), roughness=0.3)

    scene.add("floor", rectangle([-0.6, 0, 0.45], [1.2, 0, 0], [0, 0, -0.8], 2.0), floor)
    scene.add("wall", rectangle([-0.6, 0, -0.35], [1.2, 0, 0], [0, 0.6, 0], 1.0), wall)
    scene.add("gold vase", lathe(VASE, 40), gold, [-0.2, 0, -0.02])
    scene.add("steel ring", torus(0.052, 0.022, 40, 20), steel, [-0.075, 0.0225, 0.11])
    scene.add("steel ball", ball(0.055, 36, 18), steel, [-0.07, 0.0555, -0.14])
    scene.add("frosted gem", geodesic(0.05, 1), frosted, [0.055, 0.0505, 0.05])
    scene.add("emerald block", turned_y(prism(6, 0.04, 0.11, 0.006), 10), emerald, [0.185, 0.0005, 0.06])
    scene.add("pane", turned_y(rectangle([-0.07, 0.001, 0], [0.14, 0, 0], [0, 0.2, 0]), -25), pane, [0.22, 0, -0.12])
    scene.add("varnished ball", ball(0.05, 36, 18), varnish, [0.06, 0.0505, -0.13])
    scene.light("sun", {"type": "directional", "color": [1.0, 0.95, 0.85], "intensity": 1.6}, {"rotation": looking([0.45, -0.8, -0.5])})
    scene.light("lamp", {"type": "point", "color": [1.0, 0.8, 0.6], "intensity": 0.16}, {"translation": [0.3, 0.4, 0.3]})
    scene.camera([0.04, 0.3, 0.8], [0.005, 0.07, 0.0])
    scene.write(path)


def window_sky():
    """128 x 64: blue above, paler towards the horizon, brown below, a soft sun."""
    height, width = 64, 128
    v, u = (np.arange(height) + 0.5) / height, (np.arange(width) + 0.5) / width
    polar, azimuth = (v * math.pi)[:, None], ((u - 0.5) * 2 * math.pi)[None, :]
    direction = np.stack(np.broadcast_arrays(np.sin(polar) * np.cos(azimuth), np.cos(polar), np.sin(polar) * np.sin(azimuth)), axis=-1)
    up = direction[..., 1:2]
    above = np.array([0.9, 0.85, 0.75]) + (np.array([0.22, 0.36, 0.68]) - np.array([0.9, 0.85, 0.75])) * np.sqrt(np.clip(up, 0, 1))
    sky = np.where(up > 0, above * 0.6, np.array([0.16, 0.12, 0.08]) * (1 + 0.5 * up))
    sun = np.array([-0.62, 0.5, -0.25])
    angle = np.arccos(np.clip(direction @ (sun / np.linalg.norm(sun)), -1, 1))[..., None]
    return sky + np.array([1.0, 0.86, 0.66]) * 26 * np.exp(-0.5 * (angle / math.radians(5.0)) ** 2)


def window(path):
    scene = SceneWriter()
    floor = scene.lambert("table", texture=tiles(96, 4, (206, 168, 120), (150, 104, 66)))
    wall = scene.lambert("plaster", (0.78, 0.76, 0.7))
    frame = scene.lambert("frame", (0.85, 0.85, 0.82))
    blue = scene.material("blue varnish", (0.06, 0.16, 0.6), roughness=0.3)
    white = scene.material("white varnish", (0.8, 0.8, 0.78), roughness=0.6)
    copper = scene.material("copper", (0.95, 0.6, 0.45), metallic=1.0, roughness=0.3)
    tin = scene.material("tin", (0.75, 0.74, 0.7), metallic=1.0, roughness=0.5)
    panel = scene.material("panel", (0, 0, 0), emission=([1.0, 0.75, 0.5], 6.0), specular={"specularFactor": 0.0})
    bulb = scene.material("bulb", (0, 0, 0), emission=([0.6, 0.8, 1.0], 8.0), specular={"specularFactor": 0.0})

    scene.add("table", rectangle([-0.4, 0, 0.4], [0.9, 0, 0], [0, 0, -0.65], 1.5), floor)
    scene.add("wall", rectangle([-0.4, 0, -0.25], [0.9, 0, 0], [0, 0.16, 0]), wall)
    # The window in the plane x = -0.3: sill, lintel, posts and a cross.
    x0, x1 = -0.31, -0.29
    for name, low, high in [
        ("sill", [x0, 0.0005, -0.22], [x1, 0.06, 0.3]), ("lintel", [x0, 0.34, -0.22], [x1, 0.4, 0.3]),
        ("back post", [x0, 0.06, -0.22], [x1, 0.34, -0.16]), ("front post", [x0, 0.06, 0.24], [x1, 0.34, 0.3]),
        ("upright", [-0.305, 0.06, 0.03], [-0.295, 0.34, 0.05]), ("bar", [-0.304, 0.19, -0.16], [-0.296, 0.21, 0.24]),
    ]:
        scene.add(name, box(low, high), frame)
    scene.add("blue ball", ball(0.05, 36, 18), blue, [-0.1, 0.0505, 0.07])
    scene.add("copper vase", lathe(VASE, 40), copper, [-0.16, 0, -0.11])
    scene.add("tin ring", torus(0.05, 0.02, 40, 20), tin, [0.05, 0.0205, 0.13])
    scene.add("white cup", lathe(VASE * [0.9, 0.75], 32), white, [0.19, 0, 0.09])
    scene.add("block", turned_y(box([-0.035, 0, -0.035], [0.035, 0.09, 0.035]), 30), wall, [0.03, 0.0005, -0.05])
    # Its front looks down at the table and towards the camera; its back is dark.
    scene.add("panel", rectangle([0.12, 0.2, -0.16], [0.13, 0, -0.03], [0.0, 0.07, 0.05]), panel)
    scene.add("bulb", geodesic(0.016, 1), bulb, [0.2, 0.0165, -0.06])
    scene.camera([0.07, 0.3, 0.78], [-0.02, 0.09, 0.0])
    scene.write(path)


if __name__ == "__main__":
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.dirname(os.path.abspath(__file__))
    metal_and_glass(os.path.join(folder, "metal_and_glass.glb"))
    window(os.path.join(folder, "window.glb"))
    write_hdr(os.path.join(folder, "window_sky.hdr"), window_sky())
