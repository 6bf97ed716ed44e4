"""The files that a scene names, meshes and images: which they are, how they are opened, and how they get other
names."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from . import geometry, schema
from .checks import materials, walk
from .errors import SceneError
from .paths import text
from .textures import textures

OpenFile = Callable[[str], bytes]


def files(scene: schema.Scene) -> dict[str, str]:
    """The files of a scene, used or not: JSON path of the key -> file."""
    found = {text((*path, "file")): node.file for path, node in walk(scene)
             if isinstance(node, schema.Mesh) and node.file is not None}
    for path, material in materials(scene, walk(scene)):
        found |= {text((*path, *at, "file")): texture.file for at, texture in textures(material) if hasattr(texture, "file")}
    if isinstance(scene.background, schema.ImageBackground):
        found["background.file"] = scene.background.file
    return found


def renamed(scene: schema.Scene, names: Mapping[str, str]) -> dict[str, Any]:
    """The scene as a JSON document (what was left out stays left out) in which every file that is a key
    of `names` has the name given there."""
    document = to_json(scene)

    def rename(value: Any) -> None:
        if isinstance(value, dict):
            # Only these have both keys; a name under `objects` is never a text.
            if value.get("type") in ("mesh", "image") and isinstance(value.get("file"), str):
                value["file"] = names.get(value["file"], value["file"])
            value = list(value.values())
        if isinstance(value, list):
            for inner in value:
                if isinstance(inner, (dict, list)):
                    rename(inner)

    rename(document)
    return document


def to_json(scene: schema.Scene) -> dict[str, Any]:
    """The scene as a JSON document, without what was left out of it."""
    return scene.model_dump(mode="json", exclude_unset=True)


def digest(scene: schema.Scene, open_file: OpenFile | None = None) -> str:
    """SHA-256 (hex) of all that an image of this scene depends on: equal for equal scenes however they were
    written down. With `open_file` the contents of files count; without, their names, which is right for
    assets."""
    document = scene.model_dump(mode="json")
    state = hashlib.sha256(json.dumps(document, sort_keys=True, separators=(",", ":")).encode())
    for path, file in sorted(files(scene).items()) if open_file else ():
        state.update(hashlib.sha256(read_file(open_file, file, path)).digest())
    return state.hexdigest()


def read_file(open_file: OpenFile, file: str, path: str) -> bytes:
    """The bytes of a file; what is wrong with it is told at the path that names it."""
    try:
        return open_file(file)
    except SceneError as error:
        raise SceneError(path, error.message) from None
    except FileNotFoundError:
        raise SceneError(path, f"names the file {file!r}, which is not there") from None


def folder_opener(folder: Path) -> OpenFile:
    """Opens files below `folder` and nowhere else, symbolic links followed. The errors are SceneErrors
    without a path, which `compile` puts in."""
    root = Path(folder).resolve()

    def open_file(file: str) -> bytes:
        problem = geometry.check_file(file, geometry.MESHES + geometry.IMAGES)
        if problem:
            raise SceneError("", problem)
        try:
            path = (root / file).resolve()
            if not path.is_relative_to(root):
                raise SceneError("", f"names the file {file!r}, which leads out of the scene's folder {root}")
            if path.exists() and not (path.is_file() or path.is_dir()):  # a pipe: reading would wait for a writer
                raise SceneError("", f"names {file!r}, which is no regular file")
            return path.read_bytes()
        except FileNotFoundError:
            raise SceneError("", f"names the file {file!r}, which is not in {root}") from None
        except RuntimeError:  # of resolve(), before Python 3.13
            raise SceneError("", f"names the file {file!r}, a symbolic link that leads to itself") from None
        except OSError as error:
            raise SceneError("", f"names the file {file!r}, which cannot be read: {error.strerror}") from None

    return open_file
