"""A builder of glTF scenes, and shapes for it."""
import math
import sys
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "tests" / "radiance"))
sys.dont_write_bytecode = True

from files import GlbWriter  # noqa: E402
from make_scenes import looking  # noqa: E402


class Scene:
    """A builder of .glb files. Materials have the names of glTF: see `material`."""

    def __init__(self):
        self.glb = GlbWriter()
        self.glb.document["asset"]["generator"] = "holo make_images.py"
        self.used = set()

    def texture(self, pixels):
        """An 8-bit RGB or RGBA image (an array or a PIL image) as a texture that repeats; returns its index."""
        data = BytesIO()
        (pixels if isinstance(pixels, Image.Image) else Image.fromarray(pixels)).save(data, "PNG")
        image = self.glb.append("images", {"bufferView": self.glb.view(data.getvalue()), "mimeType": "image/png"})
        if "samplers" not in self.glb.document:
            self.glb.append("samplers", {"magFilter": 9729, "minFilter": 9729, "wrapS": 10497, "wrapT": 10497})
        return self.glb.append("textures", {"source": image, "sampler": 0})

    def material(self, color=(1, 1, 1), metallic=0.0, roughness=1.0, texture=None, extensions=None, **entry):
        """`texture`: of the base color, an index or a texture info. `extensions`: without KHR_materials_."""
        color = [*color, 1.0] if len(color) == 3 else list(color)
        pbr = {"baseColorFactor": color, "metallicFactor": metallic, "roughnessFactor": roughness}
        if texture is not None:
            pbr["baseColorTexture"] = texture if isinstance(texture, dict) else {"index": texture}
        entry = {"pbrMetallicRoughness": pbr, "doubleSided": True} | entry
        if extensions:
            entry["extensions"] = {f"KHR_materials_{key}": value for key, value in extensions.items()}
            self.used |= set(entry["extensions"])
        return self.glb.append("materials", entry)

    def matt(self, color=(1, 1, 1), texture=None, **entry):
        """A Lambertian material."""
        return self.material(color, texture=texture, extensions={"specular": {"specularFactor": 0.0}}, **entry)

    def glass(self, color=(1, 1, 1), roughness=0.0, ior=1.5, volume=None):
        extensions = {"transmission": {"transmissionFactor": 1.0}, "ior": {"ior": ior}}
        if volume is not None:
            extensions["volume"] = {"thicknessFactor": 1.0, **volume}
        return self.material(color, roughness=roughness, extensions=extensions)

    def glow(self, color, strength, texture=None, double_sided=False):
        entry = {"emissiveFactor": list(color), "doubleSided": double_sided}
        if texture is not None:
            entry["emissiveTexture"] = {"index": texture}
        extensions = {"emissive_strength": {"emissiveStrength": strength}, "specular": {"specularFactor": 0.0}}
        return self.material((0, 0, 0) if texture is None else (0.02, 0.02, 0.02), extensions=extensions, **entry)

    def mesh(self, shape, material, second=None, colors=None):
        positions, normals, coordinates, triangles = shape
        attributes = {"POSITION": self.glb.accessor(positions)}
        more = {"NORMAL": normals, "TEXCOORD_0": coordinates, "TEXCOORD_1": second, "COLOR_0": colors}
        attributes |= {key: self.glb.accessor(np.asarray(values, float)) for key, values in more.items() if values is not None}
        primitive = {"attributes": attributes, "indices": self.glb.accessor(np.asarray(triangles).ravel()), "material": material}
        return self.glb.append("meshes", {"primitives": [primitive]})

    def place(self, mesh, at=(0, 0, 0), **transform):
        self.glb.append("nodes", {"mesh": mesh, "translation": [float(x) for x in at], **transform})

    def add(self, shape, material, at=(0, 0, 0), second=None, colors=None):
        self.place(self.mesh(shape, material, second, colors), at)

    def light(self, entry, **node):
        lights = self.glb.document.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {"lights": []})["lights"]
        lights.append(entry)
        self.used.add("KHR_lights_punctual")
        self.glb.append("nodes", {**node, "extensions": {"KHR_lights_punctual": {"light": len(lights) - 1}}})

    def sun(self, direction, intensity=3.0, color=(1, 1, 1), degrees=0.0):
        extras = {"extras": {"angular_diameter_rad": math.radians(degrees)}} if degrees else {}
        self.light({"type": "directional", "color": list(color), "intensity": intensity, **extras}, rotation=looking(direction))

    def camera(self, position, target, degrees, size):
        """`degrees`: vertical field of view; `size`: columns and rows of the image."""
        lens = {"yfov": math.radians(degrees), "aspectRatio": size[0] / size[1], "znear": 0.01}
        camera = self.glb.append("cameras", {"type": "perspective", "perspective": lens})
        self.glb.append("nodes", {"camera": camera, "translation": list(position), "rotation": looking(np.subtract(target, position))})

    def write(self, path):
        document = self.glb.document
        if "KHR_texture_transform" in str(document.get("materials")):
            self.used.add("KHR_texture_transform")
        document["extensionsUsed"] = sorted(self.used)
        document["scene"], document["scenes"] = 0, [{"nodes": list(range(len(document["nodes"])))}]
        self.glb.write(path)


def uv_ball(radius, segments, rings):
    """A ball with texture coordinates: u around, v from the top down."""
    v, u = np.meshgrid(np.arange(rings + 1) / rings, np.arange(segments + 1) / segments, indexing="ij")
    polar, around = math.pi * v, 2 * math.pi * (u - 0.25)
    normals = np.stack([np.sin(polar) * np.sin(around + math.pi / 2), np.cos(polar), np.sin(polar) * np.cos(around + math.pi / 2)], axis=-1).reshape(-1, 3)
    triangles = []
    for i in range(rings):
        for j in range(segments):
            a = i * (segments + 1) + j
            b, c, d = a + 1, a + segments + 2, a + segments + 1
            triangles += [[a, d, c]] * (i < rings - 1) + [[a, c, b]] * (i > 0)
    return radius * normals, normals, np.stack([u, v], axis=-1).reshape(-1, 2), np.array(triangles)
