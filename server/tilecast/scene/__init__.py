"""Scenes: their format, what is refused and why, and their way into the core.

    scene = parse(text)                                    # schema.Scene, or SceneError with a JSON path
    compiled = compile(scene, folder_opener(folder))       # Compiled, immutable
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from . import schema
from .errors import SceneError
from .mesh_files import digest, files, folder_opener, renamed, to_json
from .overrides import override
from .parsing import parse, read
from .schema import json_schema as schema_json

if TYPE_CHECKING:
    from .compiler import Compiled, compile

__all__ = ["Compiled", "SceneError", "compile", "digest", "files", "folder_opener", "override", "parse", "read",
           "renamed", "schema", "schema_json", "to_json"]


def __getattr__(name: str) -> Any:
    """`compile` and `Compiled` on first use: judging a scene does not need the core."""
    if name in ("compile", "Compiled"):
        from . import compiler
        return getattr(compiler, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
