"""`tilecast batch`: many scenes, an image each. What is done is skipped, so that an interrupted batch is
simply called again.

Beside each image NAME.png stands NAME.stats.json with the statistics, the digest of the scene and the digest
of the image. An image is done when both digests hold: the scene with its settings and meshes is the same, and
the image is the one that was written for it. Nothing depends on times, which copies and checkouts change, or
on metadata inside the image, which other programs drop.
"""

from __future__ import annotations

import functools
import hashlib
import json
import time
from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from . import options
from .failures import BAD_SCENE, FAILED, explain, fail, say


class Format(str, Enum):
    png = "png"
    exr = "exr"


def batch(
    scenes: Annotated[list[Path], typer.Argument(metavar="SCENE...", help="Scenes, JSON.", show_default=False)],
    output: Annotated[Path, typer.Option("--output", "-o", help="The folder of the images.", show_default=False)],
    format_: Annotated[Format, typer.Option("--format", help="Of the images.")] = Format.png,
    samples: options.Samples = None,
    seconds: options.Seconds = None,
    error: options.Error = None,
    size: options.Size = None,
    accelerator: options.Accelerator = None,
    integrator: options.Integrator = None,
    threads: options.Threads = None,
    seed: options.Seed = None,
    set_: options.Set = None,
    force: Annotated[bool, typer.Option("--force", help="Render what is done, too.")] = False,
    quiet: options.Quiet = False,
) -> None:
    """Render many scenes. Skips what is done, goes on after a failure; the status tells if any failed."""
    settings = options.settings(set_, samples=samples, seconds=seconds, error=error, size=size,
                                accelerator=accelerator, integrator=integrator, seed=seed)
    images = _images(scenes, output, format_.value)
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        fail(f"{output}: cannot be made a folder: {problem.strerror}")

    rendered = skipped = 0
    statuses = []
    for scene, image in images.items():
        try:
            if _render(scene, image, settings, threads, force, quiet):
                rendered += 1
            else:
                skipped += 1
        except Exception as problem:
            found = explain(scene, problem, settings)
            if found is None:
                raise
            say(found[0])
            statuses.append(found[1])
    if not quiet:
        typer.echo(f"{rendered} rendered, {skipped} skipped, {len(statuses)} failed", err=True)
    raise typer.Exit(max(statuses, default=0))


def _images(scenes: list[Path], folder: Path, suffix: str) -> dict[Path, Path]:
    """The image of each scene. Ends the command where two would be one, or where a scene would be
    overwritten."""
    images: dict[Path, Path] = {}
    taken: dict[Path, Path] = {}
    for scene in dict.fromkeys(scenes):
        image = folder / f"{scene.stem}.{suffix}"
        if image in taken:
            fail(f"{scene} and {taken[image]} would both be written to {image}; render them to two folders", BAD_SCENE)
        images[scene], taken[image] = image, scene
    sources = {scene.resolve() for scene in images}
    for scene, image in images.items():
        if _beside(image).resolve() in sources:
            fail(f"{_beside(image)} is a scene and would be overwritten; choose another folder", FAILED)
    return images


def _beside(image: Path) -> Path:
    return image.with_name(image.stem + ".stats.json")


def _render(scene: Path, image: Path, settings: list[str], threads: int | None, force: bool, quiet: bool) -> bool:
    """Renders one scene, if it is not done; whether it was rendered."""
    from ..render import output as files
    from ..render.local import encoded, render
    from ..scene import compile, digest, folder_opener
    from ..scene.loading import load_document
    from .progress import progress, report_end

    start = time.perf_counter()
    document, folder = load_document(scene, settings)
    open_file = functools.cache(folder_opener(folder))  # for the digest and for compiling
    content = digest(document, open_file)
    if not force and _done(image, content):
        if not quiet:
            typer.echo(f"{scene}: done already, {image}", err=True)
        return False
    loaded = time.perf_counter() - start
    compiled = compile(document, open_file)
    with progress(scene.name, quiet) as report:
        result = render(compiled, threads=threads, on_event=report)
    start = time.perf_counter()
    data = encoded(image.suffix, compiled, result, threads)
    files.write_file(image, data)
    stats = result.stats
    stats["seconds"]["load"] += loaded
    stats["seconds"]["write"] = time.perf_counter() - start
    stats |= {"scene_sha256": content, "image_sha256": hashlib.sha256(data).hexdigest()}
    files.write_file(_beside(image), (json.dumps(stats, indent=2) + "\n").encode())
    if not quiet:
        report_end(image, stats)
    return True


def _done(image: Path, content: str) -> bool:
    """Whether `image` was made from the scene with this digest, and is still what was made."""
    try:
        stats = json.loads(_beside(image).read_bytes())
        return (stats["scene_sha256"] == content
                and stats["image_sha256"] == hashlib.sha256(image.read_bytes()).hexdigest())
    except (OSError, ValueError, KeyError, TypeError):
        return False
