"""What can be said about files before they are loaded: by their names; and about a mesh whose faces stand in the
scene."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import PurePosixPath, PureWindowsPath

import numpy as np

MESHES = ("ply", "obj", "stl", "glb")
IMAGES = ("exr", "hdr", "png", "jpg", "jpeg")

_ASSET = re.compile(r"sha256:[0-9a-f]{64}\.[a-z]+")


def is_asset(file: str) -> bool:
    """Whether `file` names an uploaded asset by its hash and not a file beside the scene."""
    return _ASSET.fullmatch(file) is not None


def check_file(file: str, formats: Sequence[str]) -> str | None:
    """What is wrong with the name of a file of one of the formats; None if nothing is."""
    if not file.isprintable():
        return "must be a file name without control characters"
    if "://" in file:
        return f"must be a file and not an address, got {file!r}"
    path = PurePosixPath(file)
    if path.is_absolute() or PureWindowsPath(file).is_absolute() or "\\" in file or ".." in path.parts:
        return f"must be relative to the scene's folder and stay inside it, with forward slashes, got {file!r}"
    if path.suffix[1:].lower() not in formats:
        return f"must end in {', '.join('.' + name for name in formats)}, got {file!r}"
    if file.startswith("sha256:") and not is_asset(file):
        return f"must be sha256:<64 hex digits>.<extension>, got {file!r}"
    return None


def check_faces(vertices: list[list[float]], faces: list[list[int]]) -> tuple[tuple[str | int, ...], str] | None:
    """What is wrong with inline faces, as (path below the mesh, message); None if nothing is."""
    if not faces:
        return ("faces",), "must not be empty: a mesh has at least one face"
    return _check_indices("faces", faces, len(vertices), "vertices")


def check_uvs(vertices: list | None, faces: list | None, uvs: list | None, uv_faces: list | None
              ) -> tuple[tuple[str | int, ...], str] | None:
    """The same of inline texture coordinates."""
    if uvs is None:
        return None if uv_faces is None else (("uv_faces",), "needs uvs as well")
    if vertices is None:
        return ("uvs",), "belong to vertices and faces in place: a file brings its own"
    if uv_faces is None:
        if len(uvs) != len(vertices):
            return ("uvs",), (f"must be as many as the {len(vertices)} vertices where there are no uv_faces, "
                              f"got {len(uvs)}")
        return None
    if len(uv_faces) != len(faces):
        return ("uv_faces",), f"must be as many as the {len(faces)} faces, got {len(uv_faces)}"
    return _check_indices("uv_faces", uv_faces, len(uvs), "uvs")


def _check_indices(key: str, faces: list[list[int]], count: int, what: str) -> tuple[tuple[str | int, ...], str] | None:
    try:
        indices = np.array(faces, np.int64)
    except OverflowError:  # an index beyond 64 bits: look for it one by one
        indices = np.clip(np.array(faces, object), -1, count).astype(np.int64)
    wrong = np.argwhere((indices < 0) | (indices >= count))
    if len(wrong):
        face, corner = map(int, wrong[0])
        return ((key, face, corner),
                f"must be the index of one of the {count} {what} (from 0), got {faces[face][corner]}")
    return None
