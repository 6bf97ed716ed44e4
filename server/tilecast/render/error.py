"""The error of an image, estimated from the image alone.

Even and odd samples make two independent images A and B (means of nA and nB samples). Of their weighted mean
I, over n samples, D^2 with D = A - B tells the error without a reference: v = D^2 nA nB / n^2 has the
expectation of (I - R)^2, for every pixel and channel, whatever the distribution. `mse` is the mean of v over
pixels and channels.

`relative_mse` is the mean of v / (R^2 + 0.01). Taking the noisy I for the unknown R would call pixels
finished that have not met the light yet, and noise in the denominator biases the quotient; so R is taken from
the neighbourhood, by the local linear filter of J.-S. Lee (Digital Image Enhancement and Noise Filtering by
Use of Local Statistics, PAMI 1980): towards the mean of a window where noise explains the window's variance,
I itself where it does not. As v falls, it becomes I. What is left of the bias: on the Cornell box the
estimate is 8% low at 4 samples, 4% at 16 and 1% at 64, where I for R makes it 46%, 18% and 5% low. The
interval does not cover this.

The 95% interval is for the true error of this very image, (I - R)^2 averaged. For each pixel and channel (I -
R)^2 - v is the product of the two halves' errors, (A - R)(B - R), so whatever their distribution the
difference has no bias, and the variance 4 tr(S^2) / 9 in the mean over 3 channels, S being the covariance of
a pixel's mean over the channels. From v averaged over the channels, E[v^2] = (2 tr(S^2) + tr(S)^2) / 9 >=
tr(S^2) / 3 where noise is normal, and more where it has long tails: so V = 4/3 v^2 is at least that variance,
and equal to it where noise is normal and of one colour. Pixels are independent, so their V add up, and the
interval is mse exp(+-1.96 sqrt(V) / mse): symmetric on the logarithmic axis on which errors are drawn. `low`
and `high` are those of `relative_mse`, in the same way from v divided by its denominator. Nothing here asks
the samples of one half to be independent: low-discrepancy ones are not.

`heavy_tailed` says that rare events carry the error, so that the estimate cannot be trusted; see `tails`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from . import tails

# Numbers that a tile contributes: sums over its pixels of v and v^2, both again relative, and what `tails` needs.
_SUMS = 4
PARTIALS = _SUMS + tails.PARTIALS
_FLOOR = 0.01  # added to R^2, so that black pixels count
_NORMAL_95 = 1.959963984540054
_RADIUS = 4  # of Lee's window: 9 x 9 pixels (see _window_mean)
_CAUTION = 1.5  # times the noise: what a window's variance must exceed to count as the image's own


@dataclass(frozen=True)
class ErrorEstimate:
    """Mean squared error over pixels and channels (linear RGB), with its 95% interval; and the same relative
    to the image: mean((I - R)^2 / (R^2 + 0.01)), whose interval is low .. high. `tail_share` is None where
    there are too few samples to tell."""
    mse: float
    mse_low: float
    mse_high: float
    relative_mse: float
    low: float
    high: float
    heavy_tailed: bool | None
    tail_share: float | None

    def to_json(self) -> dict[str, float | bool | None]:
        return asdict(self)


def tile_partials(sums: np.ndarray, samples: int, parts: Sequence[tuple[np.ndarray, int]] = (),
                  previous: np.ndarray | None = None) -> np.ndarray:
    """What a tile contributes to the estimate at a checkpoint: float64 [PARTIALS].

    `sums`: float64 [2, h, w, 3], even and odd samples apart, `samples` (at least 2) in all. `parts`: the same of
    the samples before the last range and of those in it. Where one of them has a single sample, the tail is taken
    from `previous`, the partials of the checkpoint before.
    """
    mean, variance = _mean_and_variance(sums, samples)
    weight = 1 / (_smoothed(mean, variance) ** 2 + _FLOOR)
    square = variance.sum(axis=0) / 3
    relative = (variance * weight).sum(axis=0) / 3
    found = np.zeros(PARTIALS) if previous is None else previous.copy()
    found[:_SUMS] = square.sum(), (square * square).sum(), relative.sum(), (relative * relative).sum()
    if parts and min(count for _, count in parts) >= 2:
        # Scaled by their samples, so that both estimate the variance of the whole.
        a, b = ((_mean_and_variance(part, count)[1] * weight).sum(axis=0) * (count / samples / 3)
                for part, count in parts)
        found[_SUMS:] = tails.partials(a, b)
    return found


def estimate(partials: np.ndarray, pixels: int) -> ErrorEstimate:
    """The estimate of an image of so many pixels from its tiles' partials, float64 [tiles, PARTIALS]."""
    square, square2, relative, relative2 = (math.fsum(column) for column in partials.T[:_SUMS])
    share = tails.tail_share(partials[:, _SUMS:].sum(axis=0))
    return ErrorEstimate(*_interval(square, square2, pixels), *_interval(relative, relative2, pixels),
                         None if share is None else share > tails.HEAVY, share)


def _mean_and_variance(sums: np.ndarray, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Of sums [2, h, w, 3]: the mean, and v, which estimates its variance; float64 [3, h, w] each."""
    n_a, n_b = (samples + 1) // 2, samples // 2
    a, b = np.ascontiguousarray(np.moveaxis(sums, 3, 1))  # channel by channel: numpy sums over those three fast
    return (a + b) / samples, (a / n_a - b / n_b) ** 2 * (n_a * n_b / samples**2)


def _interval(total: float, total_of_squares: float, pixels: int) -> tuple[float, float, float]:
    """The mean of v over the pixels, and its interval."""
    if not total > 0:
        return total, total, total
    width = _NORMAL_95 * math.sqrt(4 / 3 * total_of_squares) / total
    return total / pixels, total / pixels * math.exp(-width), total / pixels * math.exp(width)


def _smoothed(mean: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """Lee's estimate of the noiseless tile, float64 [3, h, w]. One gain for all channels, from their
    variances' sums."""
    local = _window_mean(mean)
    off = mean - local
    noise = _window_mean(variance.sum(axis=0, keepdims=True))
    total = _window_mean((off * off).sum(axis=0, keepdims=True))
    gain = np.maximum(total - _CAUTION * noise, 0) / np.where(total > 0, total, 1)
    return local + gain * off


def _window_mean(image: np.ndarray) -> np.ndarray:
    """The mean over 9 x 9 pixels around each, cut at the edges; float64 [c, h, w]. By doubling (2, 4, 8, then
    the 9th): fast in numpy, and without the cancellation of running sums, in which one bright pixel would
    drown all after it."""
    for axis in (1, 2):
        length = image.shape[axis]
        counts = np.minimum(np.arange(length) + _RADIUS, length - 1) - np.maximum(np.arange(length) - _RADIUS, 0) + 1
        padding = [(0, 0)] * 3
        padding[axis] = (_RADIUS, _RADIUS)
        padded = np.pad(image, padding)
        total = padded
        for step in (1, 2, 4):
            total = _part(total, axis, 0, -step) + _part(total, axis, step, None)
        total = _part(total, axis, 0, length) + _part(padded, axis, 2 * _RADIUS, None)
        image = total / counts.reshape([-1 if k == axis else 1 for k in range(3)])
    return image


def _part(image: np.ndarray, axis: int, start: int, stop: int | None) -> np.ndarray:
    return image[:, start:stop] if axis == 1 else image[:, :, start:stop]
