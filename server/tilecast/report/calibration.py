"""Whether images tell the truth about their own error: many independent renders of one scene, each with its estimate.

All other renders together are the reference of each, in two halves that are independent of it and of each other (see
`references`): no time goes into references, and with n renders their noise makes the truth's scatter about 1 / (2 n)
wider than it is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from statistics import median
from typing import Any

import numpy as np

from ..scene.errors import SceneError
from . import estimates
from .references import Error, References
from .renders import Render
from .text import aligned

FEWEST = 8
LONGEST_SIDE = 96  # pixels, and
SAMPLES = 64  # a pixel: enough to judge by, where nothing else is asked for
_COVERAGE, _RATIO = (0.94, 0.96), (0.95, 1.05)  # what a calibrated estimate keeps to
_MEASURES = {"mse": ("mse_low", "mse_high"), "relative_mse": ("low", "high")}  # and the ends of their intervals
_NAMES = {"mse": "MSE", "relative_mse": "relative MSE"}


def calibrate(render: Render, seeds: Sequence[int], samples: int,
              on_step: Callable[[int], None] = lambda done: None) -> dict[str, Any]:
    """For `mse` and `relative_mse`, as plain JSON values: coverage {mean, low, high} of the images' 95% intervals, with
    Wilson's interval; above and below, how often the truth lay beyond either end; predicted_over_true {mean, low,
    high}; width, the median of the interval's upper end over the estimate; verdict: "holds", "fails", or "open" where
    so few renders cannot tell. And heavy_tailed: how many images say so themselves. `on_step(done)` is called after
    each render. All images are kept in memory. ValueError for fewer than 8 seeds, SceneError for
    fewer than 2 samples."""
    if len(seeds) < FEWEST:
        raise ValueError(f"a calibration needs {FEWEST} renders at least, got {len(seeds)}")
    if samples < 2:
        raise SceneError("render.samples", f"must be at least 2 for a calibration, got {samples}")
    images, found = [], []
    for seed in seeds:
        taken = render(seed, samples)
        images.append(taken.pixels)
        found.append(taken.error)
        on_step(len(images))
    true = _true_errors(images)
    height, width = images[0].shape[:2]
    return {"renders": len(seeds), "samples": samples, "width": width, "height": height,
            "heavy_tailed": sum(error.get("heavy_tailed") is True for error in found),
            **{key: _judged([error[key] for error in found], [error[low] for error in found],
                            [error[high] for error in found], [getattr(error, key) for error in true])
               for key, (low, high) in _MEASURES.items()}}


def _true_errors(images: Sequence[np.ndarray]) -> list[Error]:
    sums = [np.sum(images[half::2], axis=0, dtype=np.float64) for half in range(2)]
    counts = [len(images[half::2]) for half in range(2)]
    found = []
    for at, image in enumerate(images):
        others = [(total - image) / (count - 1) if at % 2 == half else total / count
                  for half, (total, count) in enumerate(zip(sums, counts))]
        found.append(References(others).error(image))
    return found


def _judged(estimate: Sequence[float], low: Sequence[float], high: Sequence[float],
            true: Sequence[float]) -> dict[str, Any]:
    above = sum(truth > end for truth, end in zip(true, high))
    below = sum(truth < end for truth, end in zip(true, low))
    coverage = estimates.share(len(true) - above - below, len(true))
    ratio = estimates.quotient(estimate, true)
    widths = [end / value for end, value in zip(high, estimate) if value > 0]
    return {"coverage": coverage.to_json(), "above": above, "below": below,
            "predicted_over_true": ratio.to_json() if ratio else None, "width": median(widths) if widths else None,
            "verdict": _verdict([(coverage, _COVERAGE), *([(ratio, _RATIO)] if ratio else [])])}


def _verdict(judged: Sequence[tuple[estimates.Band, tuple[float, float]]]) -> str:
    if any(band.high < low or band.low > high for band, (low, high) in judged):
        return "fails"
    return "holds" if all(low <= band.mean <= high for band, (low, high) in judged) else "open"


def calibration_table(report: dict[str, Any]) -> str:
    """A line for each measure; confidence limits of 95% in brackets."""
    title = (f"{report['renders']} renders of {report['width']} x {report['height']} pixels, {report['samples']} "
             f"samples a pixel; held to: coverage {_COVERAGE[0]:.0%} to {_COVERAGE[1]:.0%}, predicted/true "
             f"{_RATIO[0]:g} to {_RATIO[1]:g}\n")
    rows = [("", "coverage of 95%", "", "truth above", "below", "predicted/true", "", "interval", "verdict")]
    for key, name in _NAMES.items():
        found = report[key]
        coverage, ratio = found["coverage"], found["predicted_over_true"]
        rows.append((name, f"{coverage['mean']:.1%}", f"({coverage['low']:.1%} to {coverage['high']:.1%})",
                     str(found["above"]), str(found["below"]),
                     f"{ratio['mean']:.3f}" if ratio else "-",
                     f"({ratio['low']:.3f} to {ratio['high']:.3f})" if ratio else "",
                     f"+-{found['width'] - 1:.1%}" if found["width"] else "-", found["verdict"]))
    return title + aligned(rows) + (f"{report['heavy_tailed']} of {report['renders']} images say themselves that they "
                                    "are heavy-tailed\n")
