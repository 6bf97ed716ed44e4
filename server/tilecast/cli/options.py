"""The options that `render` and `batch` share, and what they set in a scene."""

from __future__ import annotations

import json
import re
from typing import Annotated, Any

import typer

Samples = Annotated[int | None, typer.Option("--samples", help="Samples for each pixel.", show_default=False)]
Seconds = Annotated[float | None, typer.Option("--seconds", help="Stop after this time.", show_default=False)]
Error = Annotated[float | None, typer.Option(
    "--error", help="Stop when the relative mean squared error is below this.", show_default=False)]
Size = Annotated[str | None, typer.Option("--size", metavar="WxH", help="Pixels.", show_default=False)]
Accelerator = Annotated[str | None, typer.Option(
    "--accelerator", help="auto, none, bvh, sbvh, grid, grid-two-level, octree, octree-balanced, bsp or bsp-median.",
    show_default=False)]
Integrator = Annotated[str | None, typer.Option(
    "--integrator", help="path, direct, whitted, ambient-occlusion, or a view: normals, depth, primitives, instances, "
                          "facing, cost.",
    show_default=False)]
Threads = Annotated[int | None, typer.Option("--threads", min=1, help="One a core by default.", show_default=False)]
Seed = Annotated[int | None, typer.Option("--seed", help="Of the random numbers.", show_default=False)]
Set = Annotated[list[str] | None, typer.Option(
    "--set", metavar="KEY=VALUE", help="Replace a value of the scene, as in camera.fov=50. May be repeated.",
    show_default=False)]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Say nothing but errors.")]


def settings(set_: list[str] | None, *, samples: int | None, seconds: float | None, error: float | None,
             size: str | None, accelerator: str | None, integrator: str | None, seed: int | None) -> list[str]:
    """The options as KEY=VALUE, so that the scene's own rules judge them. Those of `--set` come first: an
    option with a name of its own wins."""
    values: dict[str, Any] = {
        "render.samples": samples, "render.stop.seconds": seconds, "render.stop.relative_mse": error,
        "render.accelerator": accelerator, "render.integrator": integrator, "render.seed": seed}
    if size is not None:
        match = re.fullmatch(r"(\d{1,9})[xX](\d{1,9})", size)
        if not match:
            raise typer.BadParameter(f"must be WIDTHxHEIGHT, as in 640x480, got {size!r}", param_hint="--size")
        values |= {"image.width": int(match[1]), "image.height": int(match[2])}
    return [*(set_ or []), *(f"{key}={json.dumps(value)}" for key, value in values.items() if value is not None)]
