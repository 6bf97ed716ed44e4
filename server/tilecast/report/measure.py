"""One scene with several values of one setting: what each costs and what comes out, side by side.

Every value is loaded, built and rendered `repeats` times, forwards and backwards in turn: what slows the machine down
for a while then slows all of them. Times are medians. Rays are counted in runs of their own, since counting costs time.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

from ..render.local import render
from ..render.plan import make_plan
from ..scene.compiler import Compiled
from ..scene.loading import load, load_document
from .variation import Variation


@dataclass(frozen=True)
class _Run:
    stats: dict[str, Any]
    sha256: str  # of the float pixels


def compare(source: str | Path | dict[str, Any], variation: Variation, *, settings: Sequence[str] = (),
            repeats: int = 3, threads: int | None = None,
            on_run: Callable[[str, int, float], None] = lambda label, repeat, seconds: None) -> dict[str, Any]:
    """The report, as plain JSON values: `rows` has an entry for each value, in order. SceneError, before anything is
    rendered, if one of the values does not fit the scene. `on_run(label, repeat, seconds)` is called after each
    render.
    """
    threads = threads or len(os.sched_getaffinity(0))
    each = [[*settings, setting] for setting in variation.settings]
    documents = [load_document(source, found)[0] for found in each]
    runs: list[list[_Run]] = [[] for _ in each]
    costs: list[dict[str, float]] = [{} for _ in each]
    for repeat in range(repeats):
        for at in list(range(len(each)))[::-1 if repeat % 2 else 1]:
            compiled = load(source, settings=each[at])
            image = render(compiled, threads=threads)
            pixels = hashlib.sha256(repr(image.pixels.shape).encode() + image.pixels.tobytes()).hexdigest()
            runs[at].append(_Run(image.stats, pixels))
            costs[at] = costs[at] or _camera_cost(compiled, threads)
            on_run(variation.labels[at], repeat, image.stats["seconds"]["render"])
            del compiled, image  # before the next is built
    rows = [_row(*found) for found in zip(variation.values, runs, costs)]
    fastest = min(row["seconds"]["render"] for row in rows)
    for row in rows:
        row["ratio"] = row["seconds"]["render"] / fastest
        row["identical"] = row["repeatable"] and row["pixels_sha256"] == rows[0]["pixels_sha256"]
    return {"vary": variation.key, "repeats": repeats, "threads": threads, "rows": rows,
            "faults": _faults(variation, rows, documents)}


def _camera_cost(compiled: Compiled, threads: int) -> dict[str, float]:
    """Of a ray through the centre of each pixel, on average."""
    scene = compiled.scene
    tiles = make_plan(scene.width, scene.height, 1).tiles
    with ThreadPoolExecutor(threads) as pool:
        found = list(pool.map(lambda tile: scene.camera_cost(tile.x, tile.y, tile.width, tile.height), tiles))
    steps, tests = map(sum, zip(*found))
    pixels = scene.width * scene.height
    return {"steps": steps / pixels, "tests": tests / pixels}


def _row(value: Any, runs: list[_Run], cost: dict[str, float]) -> dict[str, Any]:
    stats = runs[0].stats
    seconds = {key: median(run.stats["seconds"][key] for run in runs) for key in ("load", "compile", "render")}
    seconds["build"] = median(run.stats["accelerator"]["seconds"] for run in runs)  # a part of compile
    return {"value": value, "seconds": seconds,
            "render_seconds": [run.stats["seconds"]["render"] for run in runs],
            "accelerator": {key: found for key, found in stats["accelerator"].items() if key != "seconds"},
            "camera_ray": cost, "width": stats["width"], "height": stats["height"], "samples": stats["samples"],
            "rays": stats["rays"], "error": stats["error"], "kernel": stats["kernel"],
            "pixels_sha256": runs[0].sha256, "repeatable": len({run.sha256 for run in runs}) == 1}


def _faults(variation: Variation, rows: list[dict[str, Any]], documents: list[Any]) -> list[str]:
    """What must not be: a picture that a repetition changes, or that depends on what is only there for speed."""
    if any(document.render.stop.seconds is not None for document in documents):
        return []  # how many samples there are depends on the clock
    faults = [f"{setting}: the pixels change from run to run"
              for setting, row in zip(variation.labels, rows) if not row["repeatable"]]
    costs = any(document.render.integrator == "cost" for document in documents)  # which are the accelerator's own
    if variation.keeps_pixels and not costs and not faults:
        faults = [f"{setting}: the pixels are not those of {variation.labels[0]}"
                  for setting, row in zip(variation.labels, rows) if not row["identical"]]
    return faults
