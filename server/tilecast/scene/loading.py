"""Scenes for Python and the command line: from a file or a dictionary to what can be rendered, in one
call."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from .. import _core
from . import schema
from .compiler import Compiled, compile
from .errors import SceneError
from .mesh_files import folder_opener
from .overrides import override
from .parsing import judge, parse, read


def load(source: str | Path | dict[str, Any], *, folder: str | Path | None = None,
         settings: Iterable[str] = ()) -> Compiled:
    """The compiled, immutable scene in a JSON file or a dictionary. `settings` ("render.samples=16") replace
    values of it. Mesh files are looked for in `folder`; if it is not given, beside the file, or in the
    current folder.

    SceneError, with the JSON path, if there is anything wrong; with the path "" if the file itself cannot be
    read.
    """
    start = time.perf_counter()
    scene, beside = load_document(source, settings)
    seconds = time.perf_counter() - start
    compiled = compile(scene, folder_opener(Path(folder) if folder is not None else beside))
    return dataclasses.replace(compiled, seconds={**compiled.seconds, "load": compiled.seconds["load"] + seconds})


def load_document(source: str | Path | dict[str, Any],
                  settings: Iterable[str] = ()) -> tuple[schema.Scene, Path]:
    """The checked scene, not compiled, and the folder that its mesh files are relative to."""
    if isinstance(source, dict):
        text, folder = source, Path()
    else:
        text, folder = _read_file(Path(source)), Path(source).parent
    document = read(text)
    # Settings bring values of their own, which have to go the same way as those of a file.
    return (parse(override(document, settings)) if (settings := list(settings)) else judge(document)), folder


def _read_file(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        raise SceneError("", f"the scene file cannot be read: {getattr(error, 'strerror', error)}") from None


def mesh(vertices: np.ndarray, faces: np.ndarray, accelerator: str = "auto") -> _core.Scene:
    """A scene of one mesh, for ray queries alone; see its `closest`, `occluded` and `crossings`.

    vertices: [n, 3] numbers, metres; faces: [m, 3] indices of vertices from 0, counter-clockwise from outside; arrays
    or lists. SceneError where they are no mesh.
    """
    points, indices = _numbers("vertices", vertices, "fiu", "numbers"), _numbers("faces", faces, "iu", "whole numbers")
    if indices.size and not (indices.min() >= 0 and indices.max() < len(points)):
        raise SceneError("faces", f"must be indices of the {len(points)} vertices (from 0), got "
                                  f"{indices.min()} to {indices.max()}")
    if not isinstance(accelerator, str):
        raise SceneError("accelerator", f"must be a text, got {type(accelerator).__name__}")
    try:
        builder = _core.SceneBuilder()
        handle = builder.mesh(points.astype(np.float64, copy=False), indices.astype(np.uint32, copy=False),
                              accelerator=_core.Accelerator(accelerator))
        grey = builder.material("diffuse")
        root = builder.group(np.array([handle], np.int32), np.eye(4)[None], np.array([grey], np.int32))
        return builder.build(root)
    except _core.Error as error:
        raise SceneError("", str(error)) from None


def _numbers(name: str, values: Any, kinds: str, wanted: str) -> np.ndarray:
    """An array [n, 3] of one of the kinds (numpy's letters)."""
    try:
        array = np.asarray(values)
    except ValueError:  # rows of several lengths
        raise SceneError(name, "must have shape [n, 3], got rows of several lengths") from None
    if array.ndim != 2 or array.shape[1] != 3:
        raise SceneError(name, f"must have shape [n, 3], got {list(array.shape)}")
    if array.dtype.kind not in kinds:
        raise SceneError(name, f"must be {wanted}, got {array.dtype}")
    return array
