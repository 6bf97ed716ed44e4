"""The error of an image, estimated from the image alone.

Even and odd samples make two independent images A and B (means of nA and nB samples). Of their weighted mean
I, over n samples, D^2 with D = A - B tells the error without a reference: v = D^2 nA nB / n^2 has the
expectation of (I - R)^2, for every pixel and channel, whatever the distribution, as long as both halves have no error in
common. Sobol points come in pairs: an odd number of them has less error than its halves tell (3 samples: 3/4 of it), and
what `render.contrast` skips tells nothing. `mse` is the mean of v over
pixels and channels.

`relative_mse` is the mean of v / (R^2 + 0.01), with what core/render/denominators finds for the unknown R: half way,
on the logarithmic axis, between two estimates. The one finds R from all samples and comes out too low, as R and v share
noise; the other finds it from other samples than v, and comes out too high, as a noisy R is too low more often than not.

The 95% interval is for the true error of this very image, (I - R)^2 averaged, R being the exact image; where nA = nB,
(I - R)^2 - v is the product of the two halves' errors, (A - R)(B - R). So the difference has no bias, and as the two
are independent its variance, averaged over 3 channels, is tr(S^2) / 9, S being the covariance of A's channels, and of
B's. Pixels are independent, so the variances add up. R is not needed for them: were noise normal and of one colour, the
expectation of v^2 would be 3/4 tr(S^2) / 9. By how much it is not is told by two parts of the samples: those before a power
of two, and those from it on (the last that at least half as many came after). What each makes of D, D1 = A1 - B1 and D2 =
A2 - B2, scaled so that the square estimates the variance of I, makes p = (2 D1 . D2 / 3)^2, whose expectation is tr(S^2) / 9
for independent samples of any distribution, long tails included; and a mean of D1^4, D2^4, D1^2 D2^2 and (D1 . D2)^2 with
the weights by which it is a third of v^2, for normal noise of any colours and for independent samples of any fourth
cumulant. So tr(S^2) / 9 is v^2 / 3 times the sum of p over that of these means. With p alone the interval would be too wide
where the noise of some pixels falls faster with the samples than that of others, as low-discrepancy points make it: each
part has half of them, and shows more of that noise than is left in the whole.

The interval is mse exp(+-1.96 s), s being the deviation as a part of `mse`: as that of a quotient of variances, it is nearly
symmetric on the logarithmic axis on which errors are drawn. Where few pixels carry the noise, s^2 itself is known but
badly, and Student's distribution makes the interval wider, with as many degrees of freedom as the sum of p has (its
variance from the pixels' own p^2, of which 8/9 is variance where noise is normal; F. E. Satterthwaite, An Approximate
Distribution of Estimates of Variance Components, 1946).

Two or three samples have no such parts; there noise is taken for normal and of one colour. Where rare events carry the error
the two parts meet few of them in the same pixel, or none, and their products say that all is known. What says how many
events there were is v^2, so there the interval is at least as wide as by v^2 / 3; and elsewhere it is as wide where the
products tell less than a quarter of that.

It holds the truth of 94% to 96% of the renders of ten example scenes, and of 97% for lens (36 rows, 64 samples a pixel;
`scenes/RESULTS.md`). Images of few pixels are covered less often, since the deviation is itself known from so many: 74% of
single pixels, 91% of 2 x 2, 94% of 4 x 4.

`low` and `high` are those of `relative_mse`, in the same way; its bias, which falls with the noise, counts as
0.3 / sqrt(n) of it in the standard deviation: see `scenes/RESULTS.md` for what it is.

`heavy_tailed` says that rare events carry the error, so that the estimate cannot be trusted; see `tails`. An image
without any noise cannot tell: it may be finished, or have met none of its light yet.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

import numpy as np

from .. import _core
from . import tails

PARTIALS = _core.ERROR_PARTIALS  # numbers that a tile contributes: sums over its pixels, and what `tails` needs
NOISELESS = 1e-24  # the relative MSE that rounding alone may leave
FLOOR = _core.ERROR_FLOOR  # added to R^2, so that black pixels count
_KIND = _core.ERROR_SUMS_OF_KIND  # first those of the squared error, then those of the relative one
_SUMS = _core.ERROR_SUMS
_BIAS = 0.3  # of the relative error, as a part of it, times sqrt(n): root mean square over example scenes
_LARGEST = 2.0  # deviation that there is: of one pixel, whose two parts have one channel each
_SHARED = 4.0  # times the deviation by p: more by v^2 says that the parts share too few noisy pixels
NORMAL_95 = 1.959963984540054  # standard deviations either side of the mean that hold 95% of normal figures

tile_partials = _core.error_partials


@dataclass(frozen=True)
class ErrorEstimate:
    """Mean squared error over pixels and channels (linear RGB), with its 95% interval; and the same relative
    to the image: mean((I - R)^2 / (R^2 + 0.01)), whose interval is low .. high. `heavy_tailed` and `tail_share` are None
    where there are too few samples to tell, or no noise."""
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


def relative_sums(partials: np.ndarray) -> np.ndarray:
    """The relative squared error of each tile, summed over its pixels; from float64 [tiles, PARTIALS]."""
    return partials[:, _KIND]


def estimate(partials: np.ndarray, pixels: int) -> ErrorEstimate:
    """The estimate of an image of so many pixels from its tiles' partials, float64 [tiles, PARTIALS]."""
    squared, relative = partials[:, :_KIND], partials[:, _KIND:2 * _KIND]
    others, same, by_samples = (math.fsum(column) for column in partials.T[2 * _KIND:_SUMS])
    total = math.fsum(relative[:, 0])
    share = tails.tail_share(partials[:, _SUMS:].sum(axis=0)) if total > NOISELESS * pixels else None
    heavy_tailed = None if share is None else share > tails.HEAVY
    bias = _BIAS * by_samples / total if total > 0 else 0.0
    factor = math.sqrt(others / same) if others > 0 and same > 0 else 1.0
    return ErrorEstimate(*_interval(squared, pixels, heavy_tailed), *_interval(relative, pixels, heavy_tailed, factor, bias),
                         heavy_tailed, share)


def weight(mean: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """1 / (R^2 + 0.01), R being the true image, of which `mean` and its estimated variance are known; float64
    [3, h, w]."""
    return _core.error_weights(mean[None], variance[None])[0]


def error_map(pixels: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """The relative squared error about each pixel, float32 [h, w]: the mean over 9 x 9 pixels of v / (R^2 + 0.01), as
    one pixel's v alone has one degree of freedom a channel, and says little. `pixels`: the image, `variance`: its v,
    float [h, w, 3]."""
    mean, v = (np.moveaxis(image.astype(np.float64), 2, 0) for image in (pixels, variance))
    return _core.window_mean(v * weight(mean, v)).mean(axis=0).astype(np.float32)


def variance(sums: np.ndarray, samples: int) -> np.ndarray:
    """v of every pixel, float64 [h, w, 3], from the sums of even and of odd samples, float64 [2, h, w, 3]; 0 where one
    sample tells nothing."""
    if samples < 2:
        return np.zeros(sums.shape[1:])
    even, odd = (samples + 1) // 2, samples // 2
    return (sums[0] / even - sums[1] / odd) ** 2 * (even * odd / samples**2)


def _deviation(sums: np.ndarray, heavy_tailed: bool | None) -> float:
    """That of log(true error) from log(estimate), to be taken for normal; from float64 [tiles, _KIND], of which the total
    is not 0."""
    v, squares, fourths, products, _ = (math.fsum(column) for column in sums.T)
    by_squares = math.sqrt(4 / 3 * squares) / v
    deviation = 0.0 if fourths > 0 else _LARGEST
    if products > 0 and fourths > 0:
        freedom = 9 / 4 / math.fsum((sums[:, 4] / products) ** 2)
        deviation = by_squares * math.sqrt(products / fourths) / 2 * _student(freedom)
    if by_squares > (1.0 if heavy_tailed else _SHARED) * deviation:
        deviation = by_squares
    return min(deviation, _LARGEST)


def _student(freedom: float) -> float:
    """By how much Student's t is wider than a normal figure, at 95% (Abramowitz and Stegun, 26.7.5)."""
    z, of = NORMAL_95, 1 / freedom
    return 1 + of * (z**2 + 1) / 4 + of**2 * (5 * z**4 + 16 * z**2 + 3) / 96


def _interval(sums: np.ndarray, pixels: int, heavy_tailed: bool | None, factor: float = 1.0,
              bias: float = 0.0) -> tuple[float, float, float]:
    """The mean over the pixels of one kind of error, float64 [tiles, _KIND], times `factor`; and its interval. `bias` is another
    deviation, a part of the mean like the others."""
    total = math.fsum(sums[:, 0])
    mean = total * factor / pixels
    if not total > 0:
        return mean, mean, mean
    width = NORMAL_95 * math.hypot(_deviation(sums, heavy_tailed), bias)
    return mean, mean * math.exp(-width), mean * math.exp(width)
