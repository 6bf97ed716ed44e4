"""`tilecast report`: a scene's error against run time, and what else is measured of it."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from . import options
from .failures import FAILED, fail, failing, say


def report(
    scene: Annotated[Path | None, typer.Argument(metavar="SCENE", help="A scene, JSON.", show_default=False)] = None,
    output: Annotated[Path | None, typer.Option(
        "--output", "-o", help="Write table.txt, report.json, report.png and report.svg into this folder.",
        show_default=False)] = None,
    vary: Annotated[str | None, typer.Option(
        metavar="KEY=A,B,C", help="Compare the values of a setting, as in render.accelerator=bvh,grid,octree.",
        show_default=False)] = None,
    curves: Annotated[bool | None, typer.Option(
        "--curves/--no-curves", help="With --vary: error against run time for each value; if neither is said, for "
                                     "settings that change the noise.", show_default=False)] = None,
    seeds: Annotated[int, typer.Option(min=2, max=1000, help="Renders of each checkpoint.")] = 6,
    reference: Annotated[list[Path] | None, typer.Option(
        metavar="FILE.exr", help="What the error is measured against; twice for two independent renders, with other "
                                 "seeds than each other and those measured, which are the scene's and the following. "
                                 "If not given, two are rendered.", show_default=False)] = None,
    reference_samples: Annotated[int | None, typer.Option(
        min=1, max=2**24, help="For each pixel of a rendered reference; 8 times those of the image if not given.",
        show_default=False)] = None,
    repeats: Annotated[int, typer.Option(min=1, help="With --vary: renders of each value; times are medians.")] = 3,
    calibrate: Annotated[int | None, typer.Option(
        metavar="N", min=8, max=100_000, show_default=False,
        help="Ask N renders for their error instead, and how often they are right; small images of 64 samples where "
             "--size and --samples say nothing else.")] = None,
    tessellation: Annotated[bool, typer.Option(
        "--tessellation", help="The error of a sphere of triangles against the exact one, instead; no SCENE.")] = False,
    samples: options.Samples = None,
    size: options.Size = None,
    threads: options.Threads = None,
    set_: options.Set = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Only the table, no progress.")] = False,
) -> None:
    """Measure a scene's error against run time, by two long renders of its own: a table, a plot, and JSON.

    With --vary also time, memory, work for each ray and pixels, side by side; ends with status 1 where a picture
    changes that must not: by an accelerator, or from run to run."""
    settings = options.settings(set_, samples=samples, seconds=None, error=None, size=size, accelerator=None,
                                integrator=None, seed=None)
    modes = [name for name, asked in (("--vary", vary is not None), ("--calibrate", calibrate is not None),
                                      ("--tessellation", tessellation)) if asked]
    if len(modes) > 1:
        raise typer.BadParameter(f"cannot be had together with {modes[0]}", param_hint=modes[1])
    if (scene is None) != tessellation:
        raise typer.BadParameter("has no scene" if tessellation else "is missing",
                                 param_hint="--tessellation" if tessellation else "SCENE")
    if output is not None:
        try:
            output.mkdir(parents=True, exist_ok=True)
        except OSError as problem:
            fail(f"{output}: cannot be made a folder: {problem.strerror}")

    def tell(what: str) -> None:
        if not quiet:
            typer.echo(f"{scene.name}: {what}", err=True)

    with failing(scene or "--tessellation", settings):
        if tessellation:
            found, text, pictures = _tessellation(output)
        elif calibrate is not None:
            found, text, pictures = _calibration(scene, calibrate, settings, samples, size, threads, tell)
        else:
            found, text, pictures = _measured(
                scene, vary, curves, settings, repeats, output, tell, threads=threads, seeds=seeds,
                reference_files=reference or [], reference_samples=reference_samples)
        typer.echo(text, nl=False)
        if output is not None:
            from ..render import output as files
            files.write_file(output / "table.txt", text.encode())
            files.write_file(output / "report.json", (json.dumps(found, indent=2) + "\n").encode())
            for kind, data in pictures.items():
                files.write_file(output / f"report.{kind}", data)
    for fault in found.get("faults", []):
        say(f"{scene}: {fault}")
    if found.get("faults"):
        raise typer.Exit(FAILED)


_Found = tuple[dict[str, Any], str, dict[str, bytes]]  # the report, its table, and its plot by file format


def _measured(scene: Path, vary: str | None, curves: bool | None, settings: list[str], repeats: int,
              output: Path | None, tell: Callable[[str], None], **how: Any) -> _Found:
    """Error against run time; with a variation what its values cost, too."""
    from ..report.curves import error_against_time, prepare
    from ..report.curve_table import curve_table
    from ..report.measure import compare
    from ..report.table import table
    from ..report.variation import parse_variation
    from .progress import duration

    variation = parse_variation(vary) if vary is not None else None
    if curves is None:
        curves = variation is None or variation.wants_curves
    if output is not None and curves:
        _check_plot()
    found: dict[str, Any] = {"scene": scene.name}
    texts, pictures = [], {}
    if curves:  # before a comparison that may take hours
        prepare(scene, variation, settings, how["seeds"], how["reference_files"], how["threads"])
    if variation is not None:
        found |= compare(scene, variation, settings=settings, repeats=repeats, threads=how["threads"],
                         on_run=lambda label, repeat, seconds: tell(f"{label}, {repeat + 1} of {repeats}: "
                                                                    f"{duration(seconds)}"))
        texts.append(table(found))
    if curves:
        found |= error_against_time(scene, variation=variation, settings=settings, **how,
                                    on_step=lambda what, seconds: tell(f"{what}: {duration(seconds)}"))
        texts.append(curve_table(found))
        if output is not None:
            from ..report.plot import plot
            pictures = plot(found, scene.name + (f", {variation.key}" if variation else ""))
    return found, "\n".join(texts), pictures


def _calibration(scene: Path, renders: int, settings: list[str], samples: int | None, size: str | None,
                 threads: int | None, tell: Callable[[str], None]) -> _Found:
    """Of a small image, where no size is asked for."""
    from ..report import calibration
    from ..report.renders import SceneRenders

    take = SceneRenders(scene, settings, threads)
    if size is None:
        image = take.document.image
        scale = min(calibration.LONGEST_SIDE / max(image.width, image.height), 1)
        width, height = (max(round(side * scale), 1) for side in (image.width, image.height))
        take = SceneRenders(scene, [*settings, f"image.width={width}", f"image.height={height}"], threads)
    every = max(renders // 10, 1)
    found = calibration.calibrate(
        take, take.seeds(renders), calibration.SAMPLES if samples is None else take.document.render.samples,
        lambda done: tell(f"{done} of {renders} renders") if done % every == 0 else None)
    found = {"scene": scene.name, **found}
    return found, f"{scene.name}: {calibration.calibration_table(found)}", {}


def _tessellation(output: Path | None) -> _Found:
    from ..report.tessellation import tessellation, tessellation_table

    if output is not None:
        _check_plot()
    found = tessellation()
    pictures = {}
    if output is not None:
        from ..report.plot import plot_tessellation
        pictures = plot_tessellation(found)
    return found, tessellation_table(found), pictures


def _check_plot() -> None:
    """Ends the command where the plot cannot be drawn, before anything is measured for it."""
    from ..report.plot import missing

    if problem := missing():
        fail(problem)
