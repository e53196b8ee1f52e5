"""Scenes: glTF files, the gallery, and meshes of numpy arrays."""

from __future__ import annotations

import math
import os
import pathlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from . import _editing, _holo
from .errors import Error


@dataclass
class Mesh:
    """A triangle mesh with one material, in world coordinates: meters, +Y up.

    vertices: (N, 3). faces: (M, 3), indices of vertices, counterclockwise seen from the front.
    normals: (N, 3) of unit length for smooth shading; without them triangles are flat.
    colors: (N, 3) or (N, 4), linear factors of base_color from 0 to 1.
    base_color: linear RGB or RGBA. metallic, roughness, transmission: 0 to 1, as in glTF. emission: linear RGB radiance.
    """

    vertices: np.ndarray
    faces: np.ndarray
    normals: np.ndarray | None = None
    colors: np.ndarray | None = None
    base_color: tuple = (0.8, 0.8, 0.8)
    metallic: float = 0.0
    roughness: float = 1.0
    emission: tuple = (0.0, 0.0, 0.0)
    transmission: float = 0.0
    ior: float = 1.5
    double_sided: bool = False
    name: str = "mesh"

    def _as_item(self):
        def rows(array, dtype):
            return None if array is None else np.ascontiguousarray(array, dtype=dtype)

        colors = rows(self.colors, np.float32)
        if colors is not None and colors.ndim == 2 and colors.shape[1] == 3:
            colors = np.hstack([colors, np.ones((len(colors), 1), np.float32)])
        red, green, blue, *alpha = self.base_color
        return {
            "name": self.name,
            "vertices": rows(self.vertices, np.float32),
            "faces": rows(self.faces, np.uint32),
            "normals": rows(self.normals, np.float32),
            "colors": colors,
            "base_color": [float(red), float(green), float(blue), float(alpha[0]) if alpha else 1.0],
            "metallic": self.metallic,
            "roughness": self.roughness,
            "emission": [float(x) for x in self.emission],
            "transmission": self.transmission,
            "ior": self.ior,
            "double_sided": self.double_sided,
        }


@dataclass(frozen=True)
class Light:
    """A punctual light; see `Scene.from_meshes`."""

    kind: str
    intensity: tuple | float
    position: tuple = (0.0, 0.0, 0.0)
    direction: tuple = (0.0, -1.0, 0.0)

    def _as_item(self):
        numbers = {name: [float(x) for x in getattr(self, name)] for name in ("position", "direction")}
        rgb = [float(x) for x in np.broadcast_to(np.asarray(self.intensity, dtype=float), 3)]
        return {"kind": self.kind, "intensity": rgb, **numbers}


class Scene:
    """A scene that can be rendered: a glTF file, a scene of the gallery, or a `.glb` in memory.

    Made by `Scene.open`, `Scene.gallery`, `Scene.from_meshes` or `Scene.from_glb`. Holds the path or the bytes alone;
    every render reads it again.
    """

    __slots__ = ("_gallery", "_glb", "_path", "name")

    def __init__(
        self, name: str, path: pathlib.Path | None = None, glb: bytes | None = None, gallery: bool = False
    ) -> None:
        self.name, self._path, self._glb, self._gallery = name, path, glb, gallery

    @classmethod
    def open(cls, path: str | os.PathLike) -> Scene:
        """A scene of a `.glb` or `.gltf` file. What is wrong in the file is said when it is rendered."""
        path = pathlib.Path(path)
        if not path.is_file():
            raise Error(f"{path}: no such file")
        return cls(path.stem, path=path)

    @classmethod
    def gallery(cls, name: str) -> Scene:
        """One of the scenes that are built in: of `Scene.gallery_names()`, a stratified one ("backgammon", "dots", "pyramids",
        "stripes"), or an animated one ("pendulum", "turning_clockwork", "garden_walk")."""
        _holo.gallery_glb(name)
        return cls(name, gallery=True)

    @staticmethod
    def gallery_names() -> list[str]:
        """The names of the built-in scenes that a dataset has unless others are named."""
        return _holo.gallery_names()

    @classmethod
    def from_glb(cls, glb: bytes, name: str = "scene") -> Scene:
        """A scene of the bytes of a `.glb`."""
        return cls(name, glb=bytes(glb))

    @classmethod
    def from_meshes(
        cls,
        meshes: list[Mesh] | Mesh,
        *,
        camera: tuple | None = None,
        angle_of_view_deg: float = 40.0,
        up: tuple = (0.0, 1.0, 0.0),
        sun: tuple | None = None,
        sun_direction: tuple = (-0.4, -1.0, -0.3),
        points: Sequence[tuple] = (),
        name: str = "scene",
    ) -> Scene:
        """A scene of numpy arrays.

        camera: (eye, target), two points in meters; None: the renderer looks at the whole scene.
        angle_of_view_deg: the vertical angle of view.
        sun: linear RGB irradiance, or a number for white light, in lux: a white surface that faces 1 lux has the radiance
            1 / pi. Parallel light along sun_direction.
        points: point lights as (position, intensity in candela).
        """
        meshes = [meshes] if isinstance(meshes, Mesh) else list(meshes)
        lights = [] if sun is None else [Light("directional", sun, direction=sun_direction)]
        lights += [Light("point", intensity, position=position) for position, intensity in points]
        view = None
        if camera is not None:
            eye, target = ([float(x) for x in point] for point in camera)
            angle = math.radians(angle_of_view_deg)
            view = {"eye": eye, "target": target, "up": [float(x) for x in up], "vertical_angle_rad": angle}
        items = [mesh._as_item() for mesh in meshes]
        return cls(name, glb=bytes(_holo.meshes_to_glb(items, [light._as_item() for light in lights], view)))

    @property
    def materials(self) -> list[str]:
        """The names of the materials."""
        return [item.get("name", "") for item in _editing.document_of(self.to_glb()).get("materials", [])]

    @property
    def lights(self) -> list[str]:
        """The names of the punctual lights."""
        return [item.get("name", "") for item in _editing.lights_of(_editing.document_of(self.to_glb()))]

    @property
    def objects(self) -> list[str]:
        """The names of the nodes: objects, cameras and lights."""
        return [item.get("name", "") for item in _editing.document_of(self.to_glb()).get("nodes", [])]

    def with_material(
        self,
        name: str,
        *,
        base_color: tuple | None = None,
        metallic: float | None = None,
        roughness: float | None = None,
        emission: tuple | None = None,
    ) -> Scene:
        """The scene with a material changed: base_color, linear RGB or RGBA, instead of its color or texture; metallic and
        roughness, 0 to 1, times those of its texture; emission, linear RGB radiance."""

        def change(document):
            for item in _editing.named(document.get("materials", []), name, "material"):
                _editing.change_material(item, base_color, metallic, roughness, emission)

        return self._changed(change)

    def with_light(self, name: str, *, color: tuple | None = None, intensity: float | None = None) -> Scene:
        """The scene with a punctual light changed: color, linear RGB; intensity in candela, of a sun in lux."""

        def change(document):
            for item in _editing.named(_editing.lights_of(document), name, "light"):
                _editing.change_light(item, color, intensity)

        return self._changed(change)

    def with_object(
        self,
        name: str,
        *,
        translation: tuple | None = None,
        rotation: tuple | None = None,
        scale: tuple | None = None,
    ) -> Scene:
        """The scene with an object placed elsewhere, relative to its parent: translation in meters, rotation as a unit
        quaternion (x, y, z, w), scale along its axes."""

        def change(document):
            for item in _editing.named(document.get("nodes", []), name, "object"):
                _editing.change_node(item, translation, rotation, scale)

        return self._changed(change)

    def _changed(self, change) -> Scene:
        return Scene(self.name, glb=_editing.edited(self.to_glb(), change))

    @property
    def path(self) -> pathlib.Path | None:
        """The path of the file, if the scene is one."""
        return self._path

    def to_glb(self) -> bytes:
        """The bytes of the file, or of the `.glb` in memory."""
        if self._path is not None:
            return self._path.read_bytes()
        return bytes(_holo.gallery_glb(self.name)) if self._gallery else self._glb

    def save(self, path: str | os.PathLike) -> None:
        """Writes the `.glb`."""
        pathlib.Path(path).write_bytes(self.to_glb())

    def __repr__(self) -> str:
        if self._path is not None:
            return f"Scene.open({str(self._path)!r})"
        return f"Scene.gallery({self.name!r})" if self._gallery else f"<Scene {self.name!r}: {len(self._glb)} bytes>"

    def __reduce__(self):
        return (Scene, (self.name, self._path, self._glb, self._gallery))

    def _as_item(self):
        return {"name": self.name, "path": self._path, "glb": self._glb, "gallery": self._gallery}


def as_scene(scene) -> Scene:
    """A scene, or one of the path of a file."""
    return scene if isinstance(scene, Scene) else Scene.open(scene)
