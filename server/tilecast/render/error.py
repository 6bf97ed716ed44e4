"""The error of an image, estimated from the image alone.

Even and odd samples make two independent images A and B (means of nA and nB samples). Of their weighted mean
I, over n samples, D^2 with D = A - B tells the error without a reference: v = D^2 nA nB / n^2 has the
expectation of (I - R)^2, for every pixel and channel, whatever the distribution. `mse` is the mean of v over
pixels and channels.

`relative_mse` is the mean of v / (R^2 + 0.01), with what `denominators` finds for the unknown R. That leaves a bias:
on six example scenes of 96 x 72 pixels (diffuse, glossy, glass, Whitted's) -4% to +4% at 64 samples, -9% to +6% at 16
and -26% to +28% at 4, lowest where brightness changes from one pixel to the next, highest where light is rare.

The 95% interval is for the true error of this very image, (I - R)^2 averaged. For each pixel and channel (I -
R)^2 - v is the product of the two halves' errors, (A - R)(B - R), so whatever their distribution the
difference has no bias, and the variance 4 tr(S^2) / 9 in the mean over 3 channels, S being the covariance of
a pixel's mean over the channels. From v averaged over the channels, E[v^2] = (2 tr(S^2) + tr(S)^2) / 9 >=
tr(S^2) / 3 where noise is normal, and more where it has long tails: so V = 4/3 v^2 is at least that variance,
and equal to it where noise is normal and of one colour. Pixels are independent, so their V add up, and the
interval is mse exp(+-1.96 sqrt(V) / mse): symmetric on the logarithmic axis on which errors are drawn. `low`
and `high` are those of `relative_mse`, in the same way from v divided by its denominator, with 3% of the estimate
as the standard deviation of its bias. Nothing here asks the samples of one half to be independent: low-discrepancy
ones are not.

`heavy_tailed` says that rare events carry the error, so that the estimate cannot be trusted; see `tails`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from . import denominators, tails

# Numbers that a tile contributes: sums over its pixels of v and v^2, both again relative, and what `tails` needs.
_SUMS = 4
PARTIALS = _SUMS + tails.PARTIALS
_BIAS = 0.03  # of the relative error, as a part of it: of the figures above, root mean square
NORMAL_95 = 1.959963984540054  # standard deviations either side of the mean that hold 95% of normal figures


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
    weight = denominators.weight(mean, variance)
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


def relative_sums(partials: np.ndarray) -> np.ndarray:
    """The relative squared error of each tile, summed over its pixels; from float64 [tiles, PARTIALS]."""
    return partials[:, 2]


def estimate(partials: np.ndarray, pixels: int) -> ErrorEstimate:
    """The estimate of an image of so many pixels from its tiles' partials, float64 [tiles, PARTIALS]."""
    square, square2, relative, relative2 = (math.fsum(column) for column in partials.T[:_SUMS])
    share = tails.tail_share(partials[:, _SUMS:].sum(axis=0))
    return ErrorEstimate(*_interval(square, square2, pixels), *_interval(relative, relative2, pixels, _BIAS),
                         None if share is None else share > tails.HEAVY, share)


def error_map(pixels: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """The relative squared error about each pixel, float32 [h, w]: the mean over 9 x 9 pixels of v / (R^2 + 0.01), as
    one pixel's v alone has one degree of freedom a channel, and says little. `pixels`: the image, `variance`: its v,
    float [h, w, 3]."""
    mean, v = (np.moveaxis(image.astype(np.float64), 2, 0) for image in (pixels, variance))
    return denominators.window_mean(v * denominators.weight(mean, v)).mean(axis=0).astype(np.float32)


def variance(sums: np.ndarray, samples: int) -> np.ndarray:
    """v of every pixel, float64 [h, w, 3], from `sums` as in `tile_partials`; 0 where one sample tells nothing."""
    return np.moveaxis(_mean_and_variance(sums, samples)[1], 0, 2) if samples > 1 else np.zeros(sums.shape[1:])


def _mean_and_variance(sums: np.ndarray, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Of sums [2, h, w, 3]: the mean, and v, which estimates its variance; float64 [3, h, w] each."""
    n_a, n_b = (samples + 1) // 2, samples // 2
    a, b = np.ascontiguousarray(np.moveaxis(sums, 3, 1))  # channel by channel: numpy sums over those three fast
    return (a + b) / samples, (a / n_a - b / n_b) ** 2 * (n_a * n_b / samples**2)


def _interval(total: float, total_of_squares: float, pixels: int, bias: float = 0.0) -> tuple[float, float, float]:
    """The mean of v over the pixels, and its interval; `bias` is a part of the mean."""
    if not total > 0:
        return total, total, total
    width = NORMAL_95 * math.hypot(math.sqrt(4 / 3 * total_of_squares) / total, bias)
    return total / pixels, total / pixels * math.exp(-width), total / pixels * math.exp(width)
