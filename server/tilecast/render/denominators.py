"""What the squared error of each pixel is divided by, where the true image R is not known: R^2 + 0.01.

What stands for R must not share the pixel's own noise. Samples of light are skewed: a bright one raises a pixel's
brightness and its estimated variance together, and dividing by the noisy I hides the error of just those pixels that
have most of it. So R is looked for in three steps, each by the local linear filter of J.-S. Lee (Digital Image
Enhancement and Noise Filtering by Use of Local Statistics, PAMI 1980): from the mean of a 9 x 9 window without the
pixel towards the mean of its eight neighbours, and from there towards I, each time by the part of their squared
difference in the window that noise does not explain. In the last step the pixel's own variance counts as well as the
window's: where it is an outlier, nothing of I is used. As the variance falls, R becomes I.

What stands for R still has noise, of a variance V that is known. As f(r) = 1 / (r^2 + 0.01) is convex where light is
not black, f then comes out too large by f'' V / 2, the fraction f (4 r^2 f - 1) V; it is divided by 1 + that.
"""

from __future__ import annotations

import numpy as np

FLOOR = 0.01  # added to R^2, so that black pixels count
_RADIUS = 4  # of the window: 9 x 9 pixels
_CAUTION = 1.5  # times the noise: what the neighbours must differ by from the window to count as structure
_APART = 9 / 8  # times the noise: the squared difference of a pixel and the mean of eight neighbours in flat light


def weight(mean: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """1 / (R^2 + 0.01) of a tile, float64 [3, h, w], from its pixels and their estimated variances, [3, h, w] each."""
    around = window_mean(variance)
    noise = around.sum(axis=0, keepdims=True)
    wide, near = _without_centre(window_mean(mean), mean), _neighbour_mean(mean)
    # The neighbours are 8 of the window's 80: their means differ by the noise times 1/8 - 1/80.
    nearer = _gain(near - wide, _CAUTION * (1 / 8 - 1 / 80) * noise)
    local = wide + nearer * (near - wide)
    own = np.maximum(variance.sum(axis=0, keepdims=True), noise)
    own = _gain(mean - local, _APART * own)
    found = local + own * (mean - local)
    left = _without_centre(around, variance) * (1 / 80 + nearer * (1 / 8 - 1 / 80)) * (1 - own) ** 2
    weights = 1 / (found * found + FLOOR)
    return weights / (1 + np.maximum(weights * (4 * found * found * weights - 1) * left, 0))


def _gain(off: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """The part of `off`'s square in each window that `noise` does not explain; [1, h, w], one for all channels."""
    total = window_mean((off * off).sum(axis=0, keepdims=True))
    return np.maximum(total - noise, 0) / np.where(total > 0, total, 1)


def _without_centre(means: np.ndarray, image: np.ndarray) -> np.ndarray:
    """The window means of an image without the pixels themselves; a single pixel's is 0."""
    counts = np.multiply.outer(*(_counts(length) for length in image.shape[1:]))
    return (means * counts - image) / np.maximum(counts - 1, 1)


def _neighbour_mean(image: np.ndarray) -> np.ndarray:
    """The mean of up to eight neighbours of each pixel, without itself; a single pixel's is 0."""
    return _neighbour_sum(image) / np.maximum(_neighbour_sum(np.ones((1, *image.shape[1:]))), 1)


def _neighbour_sum(image: np.ndarray) -> np.ndarray:
    padded = np.pad(image, ((0, 0), (1, 1), (1, 1)))
    beside = padded[:, :, :-2] + padded[:, :, 2:]
    three = beside + padded[:, :, 1:-1]
    return three[:, :-2] + beside[:, 1:-1] + three[:, 2:]


def _counts(length: int) -> np.ndarray:
    """Pixels of a window along an axis, cut at the edges."""
    return np.minimum(np.arange(length) + _RADIUS, length - 1) - np.maximum(np.arange(length) - _RADIUS, 0) + 1


def window_mean(image: np.ndarray) -> np.ndarray:
    """The mean over 9 x 9 pixels around each, cut at the edges; float64 [c, h, w]. By doubling (2, 4, 8, then
    the 9th): fast in numpy, and without the cancellation of running sums, in which one bright pixel would
    drown all after it."""
    for axis in (1, 2):
        length = image.shape[axis]
        shape = list(image.shape)
        shape[axis] += 2 * _RADIUS
        padded = np.zeros(shape)  # np.pad takes longer than all else on a small tile
        _part(padded, axis, _RADIUS, _RADIUS + length)[...] = image
        total = padded
        for step in (1, 2, 4):
            total = _part(total, axis, 0, -step) + _part(total, axis, step, None)
        total = _part(total, axis, 0, length) + _part(padded, axis, 2 * _RADIUS, None)
        image = total / _counts(length).reshape([-1 if k == axis else 1 for k in range(3)])
    return image


def _part(image: np.ndarray, axis: int, start: int, stop: int | None) -> np.ndarray:
    return image[:, start:stop] if axis == 1 else image[:, :, start:stop]
