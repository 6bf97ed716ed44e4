"""What the squared error of each pixel is divided by, where the true image R is not known: R^2 + 0.01.

What stands for R must not share the pixel's own noise. Samples of light are skewed: a bright one raises a pixel's
brightness and its estimated variance together, and dividing by the noisy I hides the error of just those pixels that
have most of it. So R is looked for in three steps, each by the local linear filter of J.-S. Lee (Digital Image
Enhancement and Noise Filtering by Use of Local Statistics, PAMI 1980): from the mean of a 9 x 9 window without the
pixel towards the mean of its eight neighbours, and from there towards I, each time by the part of their squared
difference in the window that noise does not explain. In the last step the pixel's own variance counts as well as the
window's: where it is an outlier, nothing of I is used. As the variance falls, R becomes I.

The last step can also be taken towards the pixel's mean over a part of the samples: what is found so is independent
of the variance that the other part tells (Chernozhukov et al., Double/Debiased Machine Learning, 2018: cross-fitting).

What stands for R still has noise, of a variance V that is known. As f(r) = 1 / (r^2 + 0.01) is convex where light is
not black, f then comes out too large by f'' V / 2, the fraction f (4 r^2 f - 1) V; it is divided by 1 + that. Of V
only the part counts that is independent of the variance that is weighted: the neighbours', and the pixel's own where
R was found from another part of the samples.
"""

from __future__ import annotations

import functools

import numpy as np

FLOOR = 0.01  # added to R^2, so that black pixels count
_RADIUS = 4  # of the window: 9 x 9 pixels
_CAUTION = 1.5  # times the noise: what the neighbours must differ by from the window to count as structure
_NEAR, _WIDE = 1 / 8, 1 / 80  # of a pixel's noise: that of the mean of its neighbours, and of its window


def weights(means: np.ndarray, variances: np.ndarray) -> np.ndarray:
    """1 / (R^2 + 0.01) of the pixels of a tile, float64 [k, 3, h, w], from their means and estimated variances, the
    same shape. First those over all samples; then those over parts of the samples, by each of which R is found anew."""
    whole, count = means[0], len(means)
    windows = window_mean(np.concatenate([whole[None], variances]).reshape(-1, *whole.shape[1:]))
    windows = windows.reshape(count + 1, *whole.shape)
    around = windows[1:]
    wide, near = _without_centre(windows[0], whole), _neighbour_mean(whole)
    noise = around[0].sum(axis=0, keepdims=True)
    # The neighbours are 8 of the window's 80.
    nearer = _gain((near - wide)[None], _CAUTION * (_NEAR - _WIDE) * noise)[0]
    local = wide + nearer * (near - wide)
    local_variance = _without_centre(around[0], variances[0]) * (_WIDE + nearer * (_NEAR - _WIDE))
    own = np.maximum(variances.sum(axis=1), around.sum(axis=1))
    own = _gain(means - local, own + _NEAR * noise)
    found = local + own * (means - local)
    left = local_variance * (1 - own) ** 2
    left[1:] += own[1:] ** 2 * around[1:]
    result = 1 / (found * found + FLOOR)
    return result / (1 + np.maximum(result * (4 * found * found * result - 1) * left, 0))


def weight(mean: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """The same from all samples alone; float64 [3, h, w]."""
    return weights(mean[None], variance[None])[0]


def _gain(off: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """The part of the square of `off` [k, 3, h, w] in each window that `noise` [k, h, w] does not explain;
    [k, 1, h, w], one for all channels."""
    total = window_mean((off * off).sum(axis=1))
    return (np.maximum(total - noise, 0) / np.where(total > 0, total, 1))[:, None]


def _without_centre(means: np.ndarray, image: np.ndarray) -> np.ndarray:
    """The window means of an image without the pixels themselves; a single pixel's is 0."""
    counts = _window_counts(*image.shape[1:])
    return (means * counts - image) / np.maximum(counts - 1, 1)


def _neighbour_mean(image: np.ndarray) -> np.ndarray:
    """The mean of up to eight neighbours of each pixel, without itself; a single pixel's is 0."""
    return _neighbour_sum(image) / _neighbour_counts(*image.shape[1:])


@functools.lru_cache(maxsize=64)
def _neighbour_counts(height: int, width: int) -> np.ndarray:
    """Neighbours of each pixel, and 1 for a single one; [1, height, width]."""
    return np.maximum(_neighbour_sum(np.ones((1, height, width))), 1)


def _neighbour_sum(image: np.ndarray) -> np.ndarray:
    padded = _padded(image, 1)
    beside = padded[:, :, :-2] + padded[:, :, 2:]
    three = beside + padded[:, :, 1:-1]
    return three[:, :-2] + beside[:, 1:-1] + three[:, 2:]


@functools.lru_cache(maxsize=64)
def _window_counts(height: int, width: int) -> np.ndarray:
    """Pixels of each window, cut at the edges; [height, width]."""
    return np.multiply.outer(*(
        np.minimum(np.arange(length) + _RADIUS, length - 1) - np.maximum(np.arange(length) - _RADIUS, 0) + 1
        for length in (height, width)))


def window_mean(image: np.ndarray) -> np.ndarray:
    """The mean over 9 x 9 pixels around each, cut at the edges; float64 [c, h, w]. By doubling (2, 4, 8, then
    the 9th): fast in numpy, and without the cancellation of running sums, in which one bright pixel would
    drown all after it."""
    height, width = image.shape[1:]
    padded = _padded(image, _RADIUS)
    two = padded[:, :-1] + padded[:, 1:]
    four = two[:, :-2] + two[:, 2:]
    rows = four[:, :-4][:, :height] + four[:, 4:][:, :height] + padded[:, 2 * _RADIUS:]
    two = rows[:, :, :-1] + rows[:, :, 1:]
    four = two[:, :, :-2] + two[:, :, 2:]
    return (four[:, :, :-4][:, :, :width] + four[:, :, 4:][:, :, :width] + rows[:, :, 2 * _RADIUS:]) \
        / _window_counts(height, width)


def _padded(image: np.ndarray, by: int) -> np.ndarray:
    """With zeros all around; np.pad takes longer than all else on a small tile."""
    count, height, width = image.shape
    padded = np.zeros((count, height + 2 * by, width + 2 * by))
    padded[:, by:by + height, by:by + width] = image
    return padded
