"""What can be said about files before they are loaded: by their names; and about a mesh whose faces stand in the
scene."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import PurePosixPath, PureWindowsPath

import numpy as np

MESHES = ("ply", "obj", "stl", "glb")
IMAGES = ("exr", "hdr", "png")

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
    try:
        indices = np.array(faces, np.int64)
    except OverflowError:  # an index beyond 64 bits: look for it one by one
        indices = np.clip(np.array(faces, object), -1, len(vertices)).astype(np.int64)
    wrong = np.argwhere((indices < 0) | (indices >= len(vertices)))
    if len(wrong):
        face, corner = map(int, wrong[0])
        return (("faces", face, corner),
                f"must be the index of one of the {len(vertices)} vertices (from 0), got {faces[face][corner]}")
    return None
