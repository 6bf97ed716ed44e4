"""The error of an image, estimated from the image alone.

Even and odd samples make two independent images A and B (means of nA and nB samples). Of their weighted mean
I, over n samples, D^2 with D = A - B tells the error without a reference: v = D^2 nA nB / n^2 has the
expectation of (I - R)^2, for every pixel and channel, whatever the distribution. `mse` is the mean of v over
pixels and channels.

`relative_mse` is the mean of v / (R^2 + 0.01). Taking the noisy I for the unknown R would call pixels
finished that have not met the light yet, and noise in the denominator biases the quotient; so R is taken from
the neighbourhood, by the local linear filter of J.-S. Lee (Digital Image Enhancement and Noise Filtering by
Use of Local Statistics, PAMI 1980): towards the mean of a window where noise explains the window's variance,
I itself where it does not. As v falls, it becomes I. The pixel itself is left out of that mean, and its own v
counts as noise where it is more than the window's: a bright sample that has raised v has raised I as well, and
would else excuse itself. What is left of the bias: on the Cornell box the estimate is some 4% low, where I for
R makes it 46% low at 4 samples, 18% at 16 and 5% at 64. Among scenes of glass and polished metal it comes to
0.7 to 1.25 of the error, and was 0.55 to 0.8 with the pixel in its own window. The interval does not cover
this.

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
    weight = _weight(mean, variance)
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


def tile_relative_mse(partials: np.ndarray, pixels: int) -> float:
    """Of one tile alone, from its partials."""
    return float(partials[2]) / pixels


def estimate(partials: np.ndarray, pixels: int) -> ErrorEstimate:
    """The estimate of an image of so many pixels from its tiles' partials, float64 [tiles, PARTIALS]."""
    square, square2, relative, relative2 = (math.fsum(column) for column in partials.T[:_SUMS])
    share = tails.tail_share(partials[:, _SUMS:].sum(axis=0))
    return ErrorEstimate(*_interval(square, square2, pixels), *_interval(relative, relative2, pixels),
                         None if share is None else share > tails.HEAVY, share)


def error_map(pixels: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """The relative squared error about each pixel, float32 [h, w]: the mean over 9 x 9 pixels of v / (R^2 + 0.01), as
    one pixel's v alone has one degree of freedom a channel, and says little. `pixels`: the image, `variance`: its v,
    float [h, w, 3]."""
    mean, v = (np.moveaxis(image.astype(np.float64), 2, 0) for image in (pixels, variance))
    return _window_mean(v * _weight(mean, v)).mean(axis=0).astype(np.float32)


def variance(sums: np.ndarray, samples: int) -> np.ndarray:
    """v of every pixel, float64 [h, w, 3], from `sums` as in `tile_partials`; 0 where one sample tells nothing."""
    return np.moveaxis(_mean_and_variance(sums, samples)[1], 0, 2) if samples > 1 else np.zeros(sums.shape[1:])


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


def _weight(mean: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """1 / (R^2 + 0.01) with Lee's estimate of the noiseless tile for R, float64 [3, h, w]. One gain for all channels,
    from their variances' sums."""
    local = _around(mean)
    off = mean - local
    own = variance.sum(axis=0, keepdims=True)
    noise = np.maximum(_around(own), own)
    total = _window_mean((off * off).sum(axis=0, keepdims=True))
    gain = np.maximum(total - _CAUTION * noise, 0) / np.where(total > 0, total, 1)
    square = (local + gain * off) ** 2
    # What is left of the noise in the window's mean raises the mean of 1 / R^2: to second order, by as much as this.
    left = (1 - gain) ** 2 * _around(variance) / np.maximum(_window_pixels(mean.shape) - 1, 1)
    return 1 / (square + _FLOOR + left * np.maximum(3 * square - _FLOOR, 0) / (square + _FLOOR))


def _around(image: np.ndarray) -> np.ndarray:
    """The mean over the window without its middle; float64 [c, h, w]. An image of one pixel is its own."""
    pixels = _window_pixels(image.shape)
    return np.where(pixels > 1, (_window_mean(image) * pixels - image) / np.maximum(pixels - 1, 1), image)


def _window_pixels(shape: tuple[int, ...]) -> np.ndarray:
    """In the window about each pixel of an image [c, h, w]."""
    return _lengths(shape[1])[:, None] * _lengths(shape[2])


def _lengths(length: int) -> np.ndarray:
    """Of the windows along an axis, cut at the edges."""
    at = np.arange(length)
    return np.minimum(at + _RADIUS, length - 1) - np.maximum(at - _RADIUS, 0) + 1


def _window_mean(image: np.ndarray) -> np.ndarray:
    """The mean over 9 x 9 pixels around each, cut at the edges; float64 [c, h, w]. By doubling (2, 4, 8, then
    the 9th): fast in numpy, and without the cancellation of running sums, in which one bright pixel would
    drown all after it."""
    for axis in (1, 2):
        length = image.shape[axis]
        padding = [(0, 0)] * 3
        padding[axis] = (_RADIUS, _RADIUS)
        padded = np.pad(image, padding)
        total = padded
        for step in (1, 2, 4):
            total = _part(total, axis, 0, -step) + _part(total, axis, step, None)
        total = _part(total, axis, 0, length) + _part(padded, axis, 2 * _RADIUS, None)
        image = total / _lengths(length).reshape([-1 if k == axis else 1 for k in range(3)])
    return image


def _part(image: np.ndarray, axis: int, start: int, stop: int | None) -> np.ndarray:
    return image[:, start:stop] if axis == 1 else image[:, :, start:stop]
