"""What a few independent runs say about an expectation: bands, quotients, shares, slopes, and when a level is reached.

Errors are positive and spread over decades, so a band about a mean m with standard error s is m exp(+-t s / m): the
usual m +- t s to first order, symmetric where errors are drawn on a logarithmic axis, and never below zero. Where
m is not positive (a product of noise can be so by chance) it is m +- t s.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..render.error import NORMAL_95



@dataclass(frozen=True)
class Band:
    """A figure with its 95% confidence interval."""
    mean: float
    low: float
    high: float

    def to_json(self) -> dict[str, float]:
        return {"mean": self.mean, "low": self.low, "high": self.high}


@dataclass(frozen=True)
class Slope:
    """Of a straight line on logarithmic axes; None where nothing can be fitted."""
    value: float
    standard_error: float

    def to_json(self) -> dict[str, float]:
        return {"value": self.value, "standard_error": self.standard_error}


@functools.cache
def student_95(freedom: int) -> float:
    """What Student's t with so many degrees of freedom exceeds in absolute value 5% of the time. By bisection of
    the distribution's finite sums (Abramowitz and Stegun, 26.7.3 and 26.7.4)."""
    low, high = 0.0, 13.0  # 12.7 for one degree of freedom
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if _student_within(middle, freedom) < 0.95 else (low, middle)
    return high


def _student_within(t: float, freedom: int) -> float:
    """The probability of -t .. t."""
    angle = math.atan(t / math.sqrt(freedom))
    sine, cosine = math.sin(angle), math.cos(angle)
    odd = freedom % 2
    term, total = cosine if odd else 1.0, 0.0
    for k in range(freedom // 2):
        total += term
        term *= cosine**2 * (2 * k + 1 + odd) / (2 * k + 2 + odd)
    return 2 / math.pi * (angle + sine * total) if odd else sine * total


def band(values: Sequence[float]) -> Band:
    """The expectation of which these are independent draws, two at least."""
    values = np.asarray(values, np.float64)
    error = values.std(ddof=1) / math.sqrt(len(values))
    return _about(float(values.mean()), student_95(len(values) - 1) * float(error))


def quotient(over: Sequence[float], under: Sequence[float]) -> Band | None:
    """The quotient of two expectations from pairs of draws, two at least: of their means, with the scatter of over -
    quotient * under (Cochran, Sampling Techniques, 6.3). None where there is nothing to divide by."""
    over, under = np.asarray(over, np.float64), np.asarray(under, np.float64)
    if not under.mean() > 0:
        return None
    mean = float(over.mean() / under.mean())
    error = (over - mean * under).std(ddof=1) / math.sqrt(len(over)) / under.mean()
    return _about(mean, student_95(len(over) - 1) * float(error))


def _about(mean: float, width: float) -> Band:
    if mean > 0:
        return Band(mean, mean * math.exp(-width / mean), mean * math.exp(min(width / mean, 700)))
    return Band(mean, mean - width, mean + width)


def share(found: int, of: int) -> Band:
    """A probability from how often it came true, with Wilson's interval (1927)."""
    z, mean = NORMAL_95**2 / of, found / of
    middle, width = mean + z / 2, math.sqrt(z * (mean * (1 - mean) + z / 4))
    return Band(mean, max((middle - width) / (1 + z), 0.0), min((middle + width) / (1 + z), 1.0))


def slope(x: Sequence[float], runs: Sequence[Sequence[float]]) -> Slope | None:
    """Of log y over log x: a least squares line for each run, y[run][point], and the scatter of the lines' slopes.
    The points of one run are not independent of each other, runs are. Points at which a run is not positive are left
    out; None where fewer than two are left."""
    x, y = np.asarray(x, np.float64), np.asarray(runs, np.float64)
    kept = (x > 0) & (y > 0).all(axis=0)
    if len(set(x[kept])) < 2:
        return None
    x, y = np.log(x[kept]), np.log(y[:, kept])
    x -= x.mean()
    slopes = y @ x / (x @ x)
    return Slope(float(slopes.mean()), float(slopes.std(ddof=1) / math.sqrt(len(slopes))))


def time_to(level: float, seconds: Sequence[float], errors: Sequence[float],
            fitted: Slope | None) -> dict[str, Any] | None:
    """When an error has fallen to a level: {"seconds", "how"}. how: "measured", interpolated on logarithmic axes
    between checkpoints; "within", so small at the first checkpoint already; "extrapolated" from the last along the
    fitted slope. None where it does not fall towards it, or not in 10^300 seconds."""
    for k, error in enumerate(errors):
        if error > level:
            continue
        if k == 0:
            return {"seconds": seconds[0], "how": "within"}
        if error <= 0:
            return {"seconds": seconds[k], "how": "within"}
        part = math.log(errors[k - 1] / level) / math.log(errors[k - 1] / error)
        return {"seconds": seconds[k - 1] * (seconds[k] / seconds[k - 1]) ** part, "how": "measured"}
    if fitted is None or fitted.value > -0.1:  # ten times the error at best after 10^10 times the time: not falling
        return None
    exponent = math.log10(errors[-1] / level) / -fitted.value
    if exponent > 300 - max(math.log10(seconds[-1]), 0):  # no float holds it
        return None
    return {"seconds": seconds[-1] * 10**exponent, "how": "extrapolated"}
