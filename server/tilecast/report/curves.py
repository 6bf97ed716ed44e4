"""The error of a scene's images against their run time, and whether what they say of it is true.

    report = error_against_time("scene.json", seeds=6)     # plain JSON values
    print(curve_table(report))

The same seeds are rendered up to the same checkpoints, powers of two fixed beforehand; what is said is a mean over
seeds, and its 95% confidence interval comes from their scatter. The values of a variation take turns, forwards and
backwards: what slows the machine down for a while then slows all of them.
"""

from __future__ import annotations

import os
import platform
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

from ..scene.errors import SceneError
from . import estimates
from .heavy_tails import reasons
from .references import Error, References, read_references
from .renders import Render, SceneRenders
from .variation import Variation

LEVELS = (1e-2, 1e-3)  # of the relative MSE, whose times are told
REFERENCE_FACTOR = 8  # times the samples of the last checkpoint: a reference's error is well below that one's
_MOST_SAMPLES = 2**24  # that a scene may ask for
# Samples that are chosen from what is seen have a bias, however small.
_FOR_REFERENCES = ("render.adaptive=false", "render.contrast=null")

Step = Callable[[str, float], None]


@dataclass(frozen=True)
class Run:
    """One image: its error by references, and by itself (`render.error`)."""
    seed: int
    samples: float
    seconds: float
    cpu_seconds: float
    true: Error
    estimated: dict[str, Any]

    @property
    def covered(self) -> bool:
        """Whether the image's own 95% interval holds its true relative error."""
        return self.estimated["low"] <= self.true.relative_mse <= self.estimated["high"]

    def to_json(self) -> dict[str, Any]:
        return {"seed": self.seed, "seconds": self.seconds, "cpu_seconds": self.cpu_seconds, "mse": self.true.mse,
                "relative_mse": self.true.relative_mse, "estimated": self.estimated}


def error_against_time(source: str | Path | dict[str, Any], *, variation: Variation | None = None,
                       settings: Sequence[str] = (), seeds: int = 6, reference_files: Sequence[Path] = (),
                       reference_samples: int | None = None, threads: int | None = None,
                       on_step: Step = lambda what, seconds: None) -> dict[str, Any]:
    """The report, as plain JSON values:

    machine: threads used, cores, processor, system;
    curves: one, or one for each value of the variation (`label`, `value`), each with
      width, height, seeds, seconds {load, compile} (medians);
      references {files, or samples and seeds and seconds; mse and relative_mse of their mean};
      points: for each checkpoint samples, seconds and cpu_seconds of rendering (medians over seeds); mse and
        relative_mse {mean, low, high}; estimated: means of what the images say themselves {mse, relative_mse, low,
        high}; predicted_over_true {mean, low, high} and covered (how many of the seeds' intervals hold the truth),
        both of the relative MSE; efficiency, 1 / (mse seconds); top: the part of the squared error in a thousandth
        of the pixels; runs, one for each seed;
      slope {seconds, samples}: of the relative MSE on logarithmic axes {value, standard_error};
      time_to: a level of the relative MSE -> {seconds, how: measured, within or extrapolated}, see
        `estimates.time_to`;
      heavy_tailed: why the images' own estimates cannot be trusted here; empty where they can.

    SceneError, before anything is rendered, where a value, a checkpoint or a reference does not fit.
    `on_step(what, seconds)` is called after each part.
    """
    threads = threads or len(os.sched_getaffinity(0))
    prepared = prepare(source, variation, settings, seeds, reference_files, threads)
    values = [[setting] for setting in variation.settings] if variation else [[]]
    labels = variation.labels if variation else [""]
    renders, checkpoints = prepared.renders, prepared.checkpoints
    measured_seeds = {seed for of in renders for seed in of.seeds(seeds)}
    if reference_files:
        found = [(references, {"files": [path.name for path in reference_files]}) for references in prepared.references]
    else:
        samples = [reference_samples or min(REFERENCE_FACTOR * at[-1], _MOST_SAMPLES) for at in checkpoints]
        if variation and variation.keeps_expectation:
            shared = SceneRenders(source, [*settings, *_FOR_REFERENCES], threads)
            found = [rendered_references(shared, max(samples), "", on_step, measured_seeds)] * len(values)
        else:
            found = [rendered_references(SceneRenders(source, [*settings, *value, *_FOR_REFERENCES], threads), count,
                                         label, on_step, measured_seeds) for value, count, label in zip(values, samples, labels)]
    runs: list[list[list[Run]]] = [[] for _ in values]
    for turn in range(seeds):
        for at in list(range(len(values)))[::-1 if turn % 2 else 1]:
            seed = renders[at].seeds(seeds)[turn]
            runs[at].append(measured(renders[at], found[at][0], seed, checkpoints[at]))
            on_step(_step(labels[at], f"seed {turn + 1} of {seeds}, {checkpoints[at][0]} to {checkpoints[at][-1]} "
                                      "samples"), sum(run.seconds for run in runs[at][-1]))
    curves = [{"label": label, "value": value, "width": of.document.image.width, "height": of.document.image.height,
               "seeds": of.seeds(seeds),
               "seconds": {"load": median(of.load_seconds), "compile": median(of.compile_seconds)},
               "references": {**facts, **(references.own_error() or {})}, **summary(of_seeds)}
              for label, value, of, (references, facts), of_seeds
              in zip(labels, variation.values if variation else [None], renders, found, runs)]
    return {"machine": machine(threads), "curves": curves}


@dataclass(frozen=True)
class Prepared:
    """For each value: its renders, checkpoints and, where they come from files, references."""
    renders: list[SceneRenders]
    checkpoints: list[list[int]]
    references: list[References]


def prepare(source: str | Path | dict[str, Any], variation: Variation | None, settings: Sequence[str], seeds: int,
            reference_files: Sequence[Path], threads: int | None) -> Prepared:
    """All that can be wrong with the call of `error_against_time`, before anything is rendered: SceneError."""
    if seeds < 2:
        raise SceneError("", f"two seeds at least are needed for a confidence interval, got {seeds}")
    values = [[setting] for setting in variation.settings] if variation else [[]]
    renders = [SceneRenders(source, [*settings, *value], threads) for value in values]
    checkpoints = [_checkpoints(of) for of in renders]
    references = [read_references(reference_files, of.document.image.width, of.document.image.height, of.seeds(seeds))
                  for of in renders] if reference_files else []
    return Prepared(renders, checkpoints, references)


def _checkpoints(renders: SceneRenders) -> list[int]:
    found = renders.checkpoints
    if len(found) < 2:
        raise SceneError("render.samples", "must be at least 3 for an error against run time (two checkpoints, of "
                                           f"which 2 is the first), got {renders.document.render.samples}")
    return found


def rendered_references(renders: SceneRenders, samples: int, label: str, on_step: Step,
                        measured_seeds: Collection[int]) -> tuple[References, dict[str, Any]]:
    """Two independent renders with so many samples, and what is to be said of them."""
    images, seconds, seeds = [], 0.0, renders.reference_seeds(measured_seeds)
    for number, seed in enumerate(seeds, 1):
        taken = renders(seed, samples)
        images.append(taken.pixels)
        seconds += taken.seconds
        on_step(_step(label, f"reference {number} of 2, {samples} samples"), taken.seconds)
    return References(images, seeds), {"samples": samples, "seeds": seeds, "seconds": seconds}


def _step(label: str, what: str) -> str:
    return f"{label}: {what}" if label else what


def measured(render: Render, references: References, seed: int, checkpoints: Sequence[int]) -> list[Run]:
    """One seed at all checkpoints."""
    runs = []
    for samples in checkpoints:
        taken = render(seed, samples)
        if references.holds(taken.pixels) and taken.error["mse"] > 0:
            raise SceneError("", f"a reference is the image of seed {seed} itself, bit for bit: give references other seeds")
        runs.append(Run(seed, taken.samples, taken.seconds, taken.cpu_seconds, references.error(taken.pixels),
                        taken.error))
    return runs


def summary(runs: Sequence[Sequence[Run]]) -> dict[str, Any]:
    """What runs[seed][checkpoint] amount to: points, slope, time_to, heavy_tailed."""
    points = [_point(list(at)) for at in zip(*runs)]
    errors = [[run.true.relative_mse for run in seed] for seed in runs]
    seconds = [point["seconds"] for point in points]
    slopes = {"seconds": estimates.slope(seconds, errors),
              "samples": estimates.slope([point["samples"] for point in points], errors)}
    means = [point["relative_mse"]["mean"] for point in points]
    return {"points": points,
            "slope": {key: found.to_json() if found else None for key, found in slopes.items()},
            "time_to": {f"{level:g}": estimates.time_to(level, seconds, means, slopes["seconds"]) for level in LEVELS},
            "heavy_tailed": reasons(points)}


def _point(runs: Sequence[Run]) -> dict[str, Any]:
    """One checkpoint over all seeds."""
    seconds = median(run.seconds for run in runs)
    mse = estimates.band([run.true.mse for run in runs])
    relative = [run.true.relative_mse for run in runs]
    ratio = estimates.quotient([run.estimated["relative_mse"] for run in runs], relative)
    keys = ("mse", "relative_mse", "low", "high")
    return {"samples": median(run.samples for run in runs), "seconds": seconds,
            "cpu_seconds": median(run.cpu_seconds for run in runs),
            "mse": mse.to_json(), "relative_mse": estimates.band(relative).to_json(),
            "estimated": {key: sum(run.estimated[key] for run in runs) / len(runs) for key in keys},
            "predicted_over_true": ratio.to_json() if ratio else None,
            "covered": sum(run.covered for run in runs),
            "efficiency": 1 / (mse.mean * seconds) if mse.mean > 0 and seconds > 0 else None,
            "top": sum(run.true.top for run in runs) / len(runs),
            "runs": [run.to_json() for run in runs]}


def machine(threads: int) -> dict[str, Any]:
    """What the times were measured on."""
    return {"threads": threads, "cores": os.cpu_count(), "processor": _processor(), "system": platform.platform(),
            "python": platform.python_version()}


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:  # not Linux
        return platform.processor()
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")),
                platform.processor())
