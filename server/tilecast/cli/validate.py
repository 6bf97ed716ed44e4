"""`tilecast validate`: whether scenes can be rendered, and if not, where they are wrong."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..scene.errors import SceneError
from .failures import BAD_SCENE, explain, say


def validate(
    scenes: Annotated[list[Path], typer.Argument(metavar="SCENE...", help="Scenes, JSON.", show_default=False)],
    all_: Annotated[bool, typer.Option("--all", help="A line for each error, not only the first.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Say nothing but errors.")] = False,
) -> None:
    """Check scenes, their meshes and geometry included, without rendering them."""
    status = 0
    for scene in scenes:
        from ..scene.loading import load
        try:
            core = load(scene).scene
        except (SceneError, OSError, MemoryError) as error:
            if all_ and isinstance(error, SceneError):
                for path, message in error.errors:
                    say(f"{scene}: {path}: {message}" if path else f"{scene}: {message}")
                status = BAD_SCENE
            else:
                line, found = explain(scene, error)
                say(line)
                status = max(status, found)
        else:
            if not quiet:
                typer.echo(f"{scene}: valid ({core.width} x {core.height} pixels, {core.primitives:,} primitives)")
    raise typer.Exit(status)
