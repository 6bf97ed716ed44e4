"""GLB files that trimesh would misread without a word (glTF 2.0, Khronos Group, 2021): compressed, sparse or normalised
positions, and fans of triangles."""

from __future__ import annotations

import json
import struct
from typing import Any

_TRIANGLE_FAN = 6
_COMPRESSED = ("KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression")


def check_glb(data: bytes) -> None:
    """Raises `ValueError` where trimesh would take the file for another mesh; what else is wrong it tells itself."""
    document = _document(data)
    required = document.get("extensionsRequired")
    for extension in _COMPRESSED:
        if extension in (required if isinstance(required, list) else ()):
            raise ValueError(f"it is compressed ({extension}): save it without compression")
    accessors = _objects(document.get("accessors"))
    for m, mesh in enumerate(_objects(document.get("meshes"))):
        for p, primitive in enumerate(_objects(mesh.get("primitives"))):
            at = f"meshes[{m}].primitives[{p}]"
            if primitive.get("mode") == _TRIANGLE_FAN:
                raise ValueError(f"{at} is a fan of triangles, which is not understood: save it as single triangles")
            attributes = primitive.get("attributes")
            places = attributes.get("POSITION") if isinstance(attributes, dict) else None
            for what, index in (("positions", places), ("indices", primitive.get("indices"))):
                if not isinstance(index, int) or not 0 <= index < len(accessors):
                    continue
                accessor = accessors[index]
                if accessor.get("sparse") is not None or accessor.get("bufferView") is None:
                    raise ValueError(f"the {what} of {at} are sparse, which is not understood: save them in full")
                if accessor.get("normalized"):
                    raise ValueError(f"the {what} of {at} are normalised integers (KHR_mesh_quantization), which is not "
                                     "understood: save them as floats")


def _document(data: bytes) -> dict[str, Any]:
    """The JSON of a GLB; empty where there is none."""
    if len(data) < 20 or data[:4] != b"glTF" or data[16:20] != b"JSON":
        return {}
    length, = struct.unpack("<I", data[12:16])
    try:
        document = json.loads(data[20:20 + length])
    except (ValueError, RecursionError):
        return {}
    return document if isinstance(document, dict) else {}


def _objects(value: Any) -> list[dict[str, Any]]:
    return [item if isinstance(item, dict) else {} for item in value] if isinstance(value, list) else []
