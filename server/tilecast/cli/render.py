"""`tilecast render`: one scene, one image."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Annotated

import typer

from . import options
from .failures import failing, writable


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
    stats: Annotated[Path | None, typer.Option(help="Write the statistics to this file, JSON.",
                                               show_default=False)] = None,
    quiet: options.Quiet = False,
) -> None:
    """Render a scene to an image."""
    settings = options.settings(set_, samples=samples, seconds=seconds, error=error, size=size,
                                accelerator=accelerator, integrator=integrator, seed=seed)
    if output.suffix.lower() not in (".png", ".exr"):
        raise typer.BadParameter(f"must end in .png or .exr, got {str(output)!r}", param_hint="--output")
    for path in filter(None, (output, stats)):
        writable(path)

    with failing(scene, settings):
        from ..scene.loading import load
        compiled = load(scene, settings=settings)

        from ..render import output as files
        from ..render.local import render as render_image
        from .progress import progress, report_end
        with progress(scene.name, quiet) as report:
            image = render_image(compiled, threads=threads, on_event=report)
        start = time.perf_counter()
        files.write_file(output, files.encode(output.suffix, image.pixels, {"Software": "tilecast"}, image.stats))
        image.stats["seconds"]["write"] = time.perf_counter() - start
        if stats:
            files.write_file(stats, (json.dumps(image.stats, indent=2) + "\n").encode())
    if not quiet:
        report_end(output, image.stats)
