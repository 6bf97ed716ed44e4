"""Tilecast, a ray-tracing render server.

    import tilecast
    scene = tilecast.load("scenes/cornell.json")
    image = tilecast.render(scene, samples=64)
    hits = scene.closest(origins, directions)
"""

from __future__ import annotations

import importlib
from typing import Any

__all__ = ["SceneError", "load", "mesh", "render"]

_HOMES = {"SceneError": ".scene.errors", "load": ".scene.loading", "mesh": ".scene.loading"}


def __getattr__(name: str) -> Any:
    """The public names on first use: `import tilecast` alone, as every command does it, loads nothing."""
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name], __name__), name)
    if name == "render":
        return importlib.import_module(".render", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
