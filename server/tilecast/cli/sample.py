"""`tilecast sample`: one sample of one pixel, to see a failure again."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

import typer

from . import options
from .failures import failing


def sample(
    scene: Annotated[Path, typer.Argument(metavar="SCENE", help="A scene, JSON.", show_default=False)],
    pixel: Annotated[str, typer.Option(metavar="X,Y", help="From the top left, from 0.", show_default=False)],
    index: Annotated[int, typer.Option("--sample", min=0, max=2**32 - 1, help="From 0.", show_default=False)],
    size: options.Size = None,
    integrator: options.Integrator = None,
    seed: options.Seed = None,
    set_: options.Set = None,
) -> None:
    """Print the radiance of one sample of one pixel: red, green, blue."""
    match = re.fullmatch(r"(\d{1,5}),(\d{1,5})", pixel)
    if not match:
        raise typer.BadParameter(f"must be X,Y, as in 12,7, got {pixel!r}", param_hint="--pixel")
    settings = options.settings(set_, samples=None, seconds=None, error=None, size=size, accelerator=None,
                                integrator=integrator, seed=seed)
    with failing(scene):
        from ..render.one_sample import one_sample
        from ..scene.loading import load
        value = one_sample(load(scene, settings=settings), int(match[1]), int(match[2]), index)
    typer.echo(" ".join(map(repr, value.tolist())))
