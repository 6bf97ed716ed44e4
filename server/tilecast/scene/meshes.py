"""Mesh files as arrays, through trimesh."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import PurePosixPath
from typing import Any, NamedTuple

import numpy as np

from .errors import SceneError
from .glb import check_glb
from .obj import tidy_obj
from .ply import check_ply

_MOST_VERTICES = 2**32 - 1  # indices have 32 bits
_MOST_UV = 1e6


class Triangles(NamedTuple):
    vertices: np.ndarray
    """float64 [n, 3]"""
    faces: np.ndarray
    """uint32 [m, 3]"""
    uvs: np.ndarray | None = None
    """float32 [m, 3, 2]: texture coordinates of the faces' corners, v upwards"""


def load(data: bytes, file: str, with_uvs: bool = False, most: int | None = None) -> Triangles:
    """The triangles in the bytes of a PLY, OBJ, STL or GLB file, `most` at most; `with_uvs`: with texture coordinates, if
    there are any.

    Faces of more corners are cut into triangles. Vertices are as the file has them: an STL repeats them for
    each face, others along the seams of a texture, and the core knows equal places for one. What is not a
    mesh is refused with a SceneError without a path.
    """
    kind = PurePosixPath(file).suffix[1:].lower()
    if not data:
        raise SceneError("", f"names the file {file!r}, which is empty")
    vertices, faces, uvs = _read(data, kind, file, with_uvs, most)
    if not len(vertices) or not len(faces):
        raise SceneError("", f"names the file {file!r}, which holds no faces: it is cut off, or of another format")
    if len(vertices) > _MOST_VERTICES:
        raise SceneError("", f"names the file {file!r}, which holds more than {_MOST_VERTICES} vertices")
    wrong = np.flatnonzero(((faces < 0) | (faces >= len(vertices))).any(axis=1))
    if len(wrong):
        raise SceneError("", f"names the file {file!r}, whose face {wrong[0]} has a corner beyond its "
                             f"{len(vertices)} vertices")
    wrong = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    if len(wrong):
        raise SceneError("", f"names the file {file!r}, whose vertex {wrong[0]} is NaN or infinite")
    return Triangles(vertices, faces.astype(np.uint32), None if uvs is None else uvs[faces])


def _read(data: bytes, kind: str, file: str, with_uvs: bool,
          most: int | None) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    import trimesh  # late: it takes longer to import than most scenes to compile

    def corrupt(why: object) -> SceneError:
        text = " ".join(str(why).split())[:200]
        return SceneError("", f"names the file {file!r}, which is not a readable {kind.upper()} mesh: {text}")

    try:
        if kind == "obj":
            data = tidy_obj(data)
        elif kind == "ply":
            check_ply(data)
        elif kind == "glb":
            check_glb(data)
    except ValueError as error:
        raise corrupt(error) from None
    try:
        with np.errstate(all="ignore"):
            # process=False: nothing is merged, dropped or moved by a tolerance. An STL has no materials to
            # skip; with those of a GLB it skips the texture coordinates.
            skip = {} if kind == "stl" or (kind == "glb" and with_uvs) else {"skip_materials": True}
            loaded = trimesh.load_scene(io.BytesIO(data), file_type=kind, process=False, **skip)
            count = _count(loaded)
            if most is not None and count > most:  # before they are multiplied out
                raise SceneError("", f"names the file {file!r}, which holds {count:,} triangles, more than the {most:,} that "
                                     "are allowed here")
            uvs = _uvs(loaded) if with_uvs else None
            for geometry in loaded.geometry.values():
                if isinstance(geometry, trimesh.Trimesh):
                    geometry.visual = trimesh.visual.ColorVisuals()  # to copy texture coordinates it wants Pillow
            mesh = loaded.to_mesh()
            vertices = np.array(mesh.vertices, np.float64)
            faces = np.array(mesh.faces, np.int64)
    except SceneError:
        raise
    except Exception as error:  # a loader that meets garbage raises anything, from KeyError to MemoryError
        raise corrupt(f"{type(error).__name__}: {error}") from None
    if vertices.ndim != 2 or vertices.shape[1] != 3 or faces.ndim != 2 or faces.shape[1] != 3:
        if vertices.size and faces.size:
            raise corrupt("its vertices or faces are not triples")
        return np.empty((0, 3)), np.empty((0, 3), np.int64), None
    if uvs is not None and len(uvs) != len(vertices):
        raise corrupt("it has texture coordinates for some of its vertices only")
    if uvs is not None and not (np.abs(uvs) <= _MOST_UV).all():  # NaN too
        raise corrupt(f"it has texture coordinates that are beyond {_MOST_UV:g}")
    return vertices, faces, uvs


def _placed(loaded: Any) -> Iterator[Any]:
    """The mesh of each of a scene's nodes, in the order of to_mesh()."""
    import trimesh

    geometries = (loaded.geometry[loaded.graph[node][1]] for node in loaded.graph.nodes_geometry)
    return (geometry for geometry in geometries if isinstance(geometry, trimesh.Trimesh))


def _count(loaded: Any) -> int:
    """The triangles of a scene's nodes, which may share them."""
    return sum(len(mesh.faces) for mesh in _placed(loaded))


def _uvs(loaded: Any) -> np.ndarray | None:
    """Texture coordinates of a scene's vertices in the order in which to_mesh() puts them together: float32 [n, 2]; None
    where there are none."""
    found = []
    for mesh in _placed(loaded):
        uv = getattr(mesh.visual, "uv", None)
        if uv is not None and np.shape(uv) == (len(mesh.vertices), 2):
            found.append(np.asarray(uv, np.float32))
    return np.concatenate(found) if found else None
