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
B's. R is not needed for that: let A1 and A2 be what the samples before a power of two and those from it on make of A, and
B1 and B2 of B: the last one that at least half as many came after. Then a = A1 - A2 and b = B1 - B2, scaled to the
variance of A and of B, have the expectation 0, and (a . b / 3)^2 that of tr(S^2) / 9, whatever the distribution, long
tails included. Pixels are independent, so the variances add up. What the two parts tell is taken as a fraction of the error that they tell, the mean of
(a^2 + b^2) / 4: low-discrepancy samples have less error together than so many independent ones. The interval is
mse exp(+-1.96 s), with that fraction's root for s: as that of a quotient of variances, it is nearly symmetric on the
logarithmic axis on which errors are drawn. Two or three samples have no such parts; there S comes from v, as if noise
were normal and of one colour: E[v^2] = 3/4 tr(S^2) / 9. Nothing here asks the samples of one half to be independent.
Where rare events carry the error the two parts meet few of them in the same pixel, or none, and their products say
that all is known. What says how many events there were is v^2, so there the interval is at least as wide as by v^2; and
elsewhere it is as wide where the products tell less than a quarter of that.

What is wrong with it: the noise of the parts, of half as many samples, lies in fewer pixels than that of the whole where
low-discrepancy points make smooth pixels clean first, and so the interval of `mse` is an eighth too wide in two of the
example scenes (4,000 renders of 36 rows: the truth is in 97.3% of them for lens, in 96.3% for cornell); and where few
pixels carry the noise, the deviation itself is known to a quarter, which leaves 93% for drilled-part-brass.

Images of few pixels are covered less often, since the deviation is itself known from so many: 59% of single pixels, 80%
of 2 x 2, 90% of 4 x 4, 94% of 8 x 8.

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
_SUMS = _core.ERROR_SUMS
_BIAS = 0.3  # of the relative error, as a part of it, times sqrt(n): root mean square over example scenes
_LARGEST = 2.0  # deviation that there is: of one pixel, whose two parts have one channel each
_SHARED = 4.0  # times the deviation by products: more by v^2 says that the parts share too few noisy pixels
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
    return partials[:, 3]


def estimate(partials: np.ndarray, pixels: int) -> ErrorEstimate:
    """The estimate of an image of so many pixels from its tiles' partials, float64 [tiles, PARTIALS]."""
    (square, square_products, squares, relative, products, parts, others, same, by_samples, of_squares,
     of_relative) = (math.fsum(column) for column in partials.T[:_SUMS])
    bias = _BIAS * by_samples / relative if relative > 0 else 0.0
    share = tails.tail_share(partials[:, _SUMS:].sum(axis=0)) if relative > NOISELESS * pixels else None
    heavy_tailed = None if share is None else share > tails.HEAVY
    floors = [_by_squares(square, of_squares), _by_squares(relative, of_relative)]
    if others > 0 and same > 0:
        relative *= math.sqrt(others / same)
    trusted = 1.0 if heavy_tailed else _SHARED
    return ErrorEstimate(*_interval(square, square_products, squares, pixels, floors[0], trusted),
                         *_interval(relative, products, parts, pixels, floors[1], trusted, bias), heavy_tailed, share)


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


def _by_squares(total: float, squares: float) -> float:
    """The deviation of the mean of v, as a part of it, from the sums of v and of v^2."""
    return math.sqrt(4 / 3 * squares) / total if total > 0 else 0.0


def _interval(total: float, products: float, parts: float, pixels: int, by_squares: float, trusted: float,
              bias: float = 0.0) -> tuple[float, float, float]:
    """The mean over the pixels of what adds up to `total`, and its interval: `products` is the variance of `parts`,
    `by_squares` the deviation by v^2, which counts where it is more than `trusted` times theirs; `bias` is another one.
    All are parts of the mean."""
    if not total > 0:
        return total, total, total
    deviation = math.sqrt(products) / parts if parts > 0 else _LARGEST
    if by_squares > trusted * deviation:
        deviation = min(by_squares, _LARGEST)
    width = NORMAL_95 * math.hypot(deviation, bias)
    return total / pixels, total / pixels * math.exp(-width), total / pixels * math.exp(width)
