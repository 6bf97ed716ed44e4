"""`tilecast report`: one scene with several values of one setting, measured side by side."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from . import options
from .failures import FAILED, fail, failing, say


def report(
    scene: Annotated[Path, typer.Argument(metavar="SCENE", help="A scene, JSON.", show_default=False)],
    vary: Annotated[str, typer.Option(
        metavar="KEY=A,B,C", help="The setting to vary and its values, as in render.accelerator=bvh,grid,octree.",
        show_default=False)],
    output: Annotated[Path | None, typer.Option(
        "--output", "-o", help="Write table.txt and report.json into this folder.", show_default=False)] = None,
    repeats: Annotated[int, typer.Option(min=1, help="Renders of each value; times are medians.")] = 3,
    samples: options.Samples = None,
    size: options.Size = None,
    threads: options.Threads = None,
    set_: options.Set = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Only the table, no progress.")] = False,
) -> None:
    """Measure a scene with several values of a setting: time, memory, work for each ray, error, pixels.

    Ends with status 1 where a picture changes that must not: by an accelerator, or from run to run."""
    settings = options.settings(set_, samples=samples, seconds=None, error=None, size=size, accelerator=None,
                                integrator=None, seed=None)

    if output is not None:
        try:
            output.mkdir(parents=True, exist_ok=True)
        except OSError as problem:
            fail(f"{output}: cannot be made a folder: {problem.strerror}")

    def on_run(label: str, repeat: int, seconds: float) -> None:
        if not quiet:
            typer.echo(f"{scene.name}: {label}, {repeat + 1} of {repeats}: {duration(seconds)}", err=True)

    with failing(scene):
        from ..report.measure import compare
        from ..report.table import table
        from ..report.variation import parse_variation
        from .progress import duration
        variation = parse_variation(vary)
        found = {"scene": scene.name, **compare(scene, variation, settings=settings, repeats=repeats, threads=threads,
                                                on_run=on_run)}
        text = table(found)
        typer.echo(text, nl=False)
        if output is not None:
            from ..render import output as files
            files.write_file(output / "table.txt", text.encode())
            files.write_file(output / "report.json", (json.dumps(found, indent=2) + "\n").encode())
    for fault in found["faults"]:
        say(f"{scene}: {fault}")
    if found["faults"]:
        raise typer.Exit(FAILED)
