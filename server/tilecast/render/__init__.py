"""From a compiled scene to an image: plan, dispatch, film, error estimate, image files.

Command line and server use the same parts; `local` puts them together on a thread pool. The package itself
can be called: `tilecast.render(scene, samples=64)` is `tilecast.render.local.render`.
"""

from __future__ import annotations

import sys
import types
from typing import Any


class _Package(types.ModuleType):
    """`tilecast.render` is a package by its folder and a function by the public interface; as a module that
    can be called it is both, whichever is imported first."""

    def __call__(self, *arguments: Any, **settings: Any) -> Any:
        from .local import render
        return render(*arguments, **settings)


sys.modules[__name__].__class__ = _Package
