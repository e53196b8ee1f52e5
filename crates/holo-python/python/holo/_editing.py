"""Changes of a `.glb` by the names of its materials, lights and objects."""

from __future__ import annotations

import copy
import difflib
import json
import struct

from .errors import Error, UsageError

_MAGIC = 0x46546C67
_JSON = 0x4E4F534A
_LIGHTS = "KHR_lights_punctual"
_EMISSIVE = "KHR_materials_emissive_strength"


def document_of(glb: bytes) -> dict:
    """The JSON of a `.glb`."""
    if len(glb) < 20 or struct.unpack_from("<I", glb)[0] != _MAGIC:
        raise Error("only scenes in one file, .glb, can be changed; convert the .gltf with its files to .glb")
    length, kind = struct.unpack_from("<II", glb, 12)
    if kind != _JSON:
        raise Error("the .glb does not begin with its JSON")
    return json.loads(glb[20 : 20 + length])


def with_document(glb: bytes, document: dict) -> bytes:
    """The `.glb` with another JSON."""
    (length,) = struct.unpack_from("<I", glb, 12)
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    rest = glb[20 + length :]
    return struct.pack("<III", _MAGIC, 2, 20 + len(text) + len(rest)) + struct.pack("<II", len(text), _JSON) + text + rest


def lights_of(document: dict) -> list[dict]:
    return document.get("extensions", {}).get(_LIGHTS, {}).get("lights", [])


def named(items: list[dict], name: str, what: str) -> list[dict]:
    """All items of this name."""
    found = [item for item in items if item.get("name") == name]
    if not found:
        names = sorted({item["name"] for item in items if item.get("name")})
        close = difflib.get_close_matches(name, names, 1)
        advice = f"; did you mean {close[0]!r}?" if close else f"; there are {', '.join(map(repr, names[:12])) or 'none'}"
        raise UsageError(f"the scene has no {what} {name!r}{advice}")
    return found


def _numbers(values, count, what):
    out = [float(value) for value in values]
    if len(out) != count:
        raise UsageError(f"{what} has {count} numbers, not {len(out)}")
    return out


def change_material(item: dict, base_color, metallic, roughness, emission) -> None:
    surface = item.setdefault("pbrMetallicRoughness", {})
    if base_color is not None:
        color = list(base_color)
        surface["baseColorFactor"] = _numbers(color if len(color) == 4 else [*color, 1.0], 4, "base_color")
        surface.pop("baseColorTexture", None)
    if metallic is not None:
        surface["metallicFactor"] = float(metallic)
    if roughness is not None:
        surface["roughnessFactor"] = float(roughness)
    if emission is not None:
        radiance = _numbers(emission, 3, "emission")
        strength = max(radiance)
        # Factors are from 0 to 1.
        item["emissiveFactor"] = [value / strength for value in radiance] if strength > 1 else radiance
        item.pop("emissiveTexture", None)
        extensions = item.setdefault("extensions", {})
        extensions.pop(_EMISSIVE, None)
        if strength > 1:
            extensions[_EMISSIVE] = {"emissiveStrength": strength}


def change_light(item: dict, color, intensity) -> None:
    if color is not None:
        item["color"] = _numbers(color, 3, "color")
    if intensity is not None:
        item["intensity"] = float(intensity)


def change_node(item: dict, translation, rotation, scale) -> None:
    if "matrix" in item:
        raise UsageError(f"{item.get('name')!r} is placed by a matrix; give it translation, rotation and scale in the program that made it")
    for key, values, count in (("translation", translation, 3), ("rotation", rotation, 4), ("scale", scale, 3)):
        if values is not None:
            item[key] = _numbers(values, count, key)


def edited(glb: bytes, change) -> bytes:
    """The `.glb` after `change` has changed its JSON."""
    document = copy.deepcopy(document_of(glb))
    change(document)
    if any(_EMISSIVE in item.get("extensions", {}) for item in document.get("materials", [])):
        used = document.setdefault("extensionsUsed", [])
        if _EMISSIVE not in used:
            used.append(_EMISSIVE)
    return with_document(glb, document)
