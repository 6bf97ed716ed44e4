"""`tilecast render`: one scene, one image."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Annotated

import typer

from . import options
from .failures import BAD_SCENE, fail, failing, writable


def render(
    scene: Annotated[Path, typer.Argument(metavar="SCENE", help="A scene, JSON.", show_default=False)],
    output: Annotated[Path, typer.Option("--output", "-o", help="The image: .png or .exr.", show_default=False)],
    samples: options.Samples = None,
    seconds: options.Seconds = None,
    error: options.Error = None,
    size: options.Size = None,
    accelerator: options.Accelerator = None,
    integrator: options.Integrator = None,
    threads: options.Threads = None,
    seed: options.Seed = None,
    set_: options.Set = None,
    stats: Annotated[Path | None, typer.Option(metavar="FILE|-", show_default=False,
                                               help="Write the statistics as JSON; -: to standard output.")] = None,
    error_map: Annotated[Path | None, typer.Option(
        help="Write a map of where the error is to this file, PNG: the relative squared error from 1e-6 (black) to 1.",
        show_default=False)] = None,
    quiet: options.Quiet = False,
) -> None:
    """Render a scene to an image. An EXR also holds its error, samples, albedo, normals and depth, as layers."""
    settings = options.settings(set_, samples=samples, seconds=seconds, error=error, size=size,
                                accelerator=accelerator, integrator=integrator, seed=seed)
    if output.suffix.lower() not in (".png", ".exr"):
        raise typer.BadParameter(f"must end in .png or .exr, got {str(output)!r}", param_hint="--output")
    if error_map is not None and error_map.suffix.lower() != ".png":
        raise typer.BadParameter(f"must end in .png, got {str(error_map)!r}", param_hint="--error-map")
    to_screen = stats == Path("-")
    named = {scene.resolve(): "the scene"}
    for what, path in (("--output", output), ("--stats", None if to_screen else stats), ("--error-map", error_map)):
        if path is not None:
            writable(path)
            if (other := named.setdefault(path.resolve(), what)) != what:
                fail(f"{path}: {other} and {what} are the same file", BAD_SCENE)

    with failing(scene, settings):
        from ..scene.errors import SceneError
        from ..scene.loading import load
        compiled = load(scene, settings=settings)
        if error_map is not None and compiled.document.render.samples < 2:
            raise SceneError("render.samples", "must be at least 2 for an error map, got 1")

        from ..render import output as files
        from ..render.local import encoded
        from ..render.local import render as render_image
        from .progress import progress, report_end
        with progress(scene.name, quiet) as report:
            image = render_image(compiled, threads=threads, on_event=report)
        start = time.perf_counter()
        files.write_file(output, encoded(output.suffix, compiled, image, threads))
        if error_map:
            files.write_file(error_map, files.error_png(image.pixels, image.variance))
        image.stats["seconds"]["write"] = time.perf_counter() - start
        if stats:
            text = json.dumps(image.stats, indent=2) + "\n"
            if to_screen:
                typer.echo(text, nl=False)
            else:
                files.write_file(stats, text.encode())
    if not quiet:
        report_end(output, image.stats)
