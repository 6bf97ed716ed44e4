"""Whether an error estimate rests on a few rare events, told by the image alone.

The estimate is unbiased whatever the distribution of the samples, but where rare bright samples carry the error, most
renders have met too few of them: the estimate is then mostly too low, now and then far too high, and the image's own
brightness, by which the relative error is divided, is not known either. A few pixels that hold most of the error are
no sign of this by themselves: the edges of a lamp do so in every image. Rare events show by not coming back.

So the samples of a checkpoint are taken in two parts, before and after a power of two, each with an even and an odd half:
two estimates a and b of the same variance, from different samples. The later part has at least half as many as the
earlier one: few have longer tails than many. The hundredth of all pixels in
which a is largest holds a share of the sum of a, and a share of the sum of b. With light-tailed noise both shares are
nearly the same, however unevenly the variance lies over the image; what b does not find there again is `tail_share`,
the larger of the two ways round.

No normal noise gives more than 0.484, whatever its variances: a pixel of variance s that is chosen where a > t^2 s
adds 2 t phi(t) s to the difference, phi being the normal density, and t phi(t) is largest at t = 1. Above 1/2 the noise
is not normal, and more than half of the error lies where it was not to be foreseen: the image is `heavy`. Samples whose
distribution has no finite variance come to more than 0.8 (Pareto, exponent 1.5), events that fewer than one pixel
in a hundred has met to nearly 1.

Tiles contribute histograms over the logarithm of a and of b (core/render/tails), which simply add up; within the bin in
which the hundredth ends, pixels count as equal.
"""

from __future__ import annotations

import numpy as np

from .. import _core

HEAVY = 0.5
_TOP = 0.01  # of all pixels
_BINS = _core.TAIL_BINS
PARTIALS = 6 * _BINS  # for each of a and b: pixels, their sum, and the sum of the other, by bin

partials = _core.tail_partials


def tail_share(total: np.ndarray) -> float | None:
    """0 to 1, from the sum of all tiles' partials; None where there are none."""
    if not total.any():
        return None
    return max(_unforeseen(*way) for way in total.reshape(2, 3, _BINS))


def _unforeseen(counts: np.ndarray, sums: np.ndarray, others: np.ndarray) -> float:
    """By how much the share of the top pixels in the sum that chose them is above that in the other."""
    if not sums.sum() > 0:
        return 0.0
    above = np.cumsum(counts[::-1])[::-1] - counts  # pixels in higher bins
    chosen = np.clip((counts.sum() * _TOP - above) / np.maximum(counts, 1), 0, 1)
    share = (chosen * sums).sum() / sums.sum()
    again = (chosen * others).sum() / others.sum() if others.sum() > 0 else 0.0
    return max(float(share - again), 0.0)
