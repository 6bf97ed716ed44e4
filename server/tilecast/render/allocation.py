"""How many samples each tile is to have: pure functions of what is known when a round of rendering has ended.

Uniform rounds give every tile the same. Adaptive ones follow Neyman ("On the Two Different Aspects of the
Representative Method", Journal of the Royal Statistical Society 97, 1934): the error of an image, the sum over its
tiles of s / n, is least for a given cost, the sum of c n, where n is in proportion to sqrt(s / c): s is the relative
variance of one sample of the tile, c what it costs. Rays are counted for that, which no clock disturbs: where a sample
takes more of them, each of them takes longer as well, being near more to hit. On twelve example scenes the square of a
sample's rays tells its time in tiles to a factor of 1.1 to 1.8 (standard deviation); their number to 1.1 to 2.4.

A tile whose samples decide how many more it gets is biased: one that has not met the light yet looks as if it were
finished, and stays too dark; one that met more of it than there is may look less noisy beside its mean, and stays too
bright. So nothing is decided before the pilot's samples, and no tile falls back behind an eighth of what the mean s would
get. Until a tile knows its noise, the tiles around it decide alone, of which its samples are independent; then seven
eighths of s are its own.

Counts of samples are levels: 2, 4, 8, 16, and then eight between a power of two and the next, so that both halves of
the samples are equal and low-discrepancy points come in balanced groups.
"""

from __future__ import annotations

import math

import numpy as np

_STEPS = 8  # levels from a power of two to the next
_OWN = 7 / 8  # of a tile's s: the rest comes from around it
_LEAST = 1 / 64  # of the mean s
_HALVINGS = 40  # of the logarithm of what all shares are multiplied by
_MOST = 16  # times the samples that a pixel has on average in the end


def level_below(samples: np.ndarray) -> np.ndarray:
    """The largest levels that are at most `samples`, which are at least 2; int64."""
    whole = np.floor(samples).astype(np.int64)
    _, exponent = np.frexp(whole.astype(np.float64))
    power = np.int64(1) << np.maximum(exponent - 1, 0).astype(np.int64)
    step = np.maximum(power, 2 * _STEPS) // _STEPS
    return np.where(whole < 2 * _STEPS, power, whole - whole % step)


def level_above(samples: int) -> int:
    """The smallest level above `samples`."""
    power = 1 << max(samples.bit_length() - 1, 0)
    return samples - samples % max(power // _STEPS, 2) + max(power // _STEPS, 2) if power >= 2 * _STEPS else 2 * power


def next_mean(samples: float, most: int, short: float | None) -> int:
    """Samples a pixel, on average, at the end of the next round: the next power of two, but at most `most`; and less
    where the error is near its goal, `short` (above 1) being how many times it is too large."""
    now = math.floor(samples * 17 / 16)  # adaptive rounds end a little short of their mean; the same level for others
    goal = 1 << now.bit_length()
    if short is not None:
        wanted = samples * most_of(short)
        if wanted < goal:
            goal = max(int(level_below(np.float64(wanted))), level_above(now))
    return min(goal, most)


def most_of(short: float) -> float:
    """Three quarters of the way to the goal on the logarithmic axis: the error falls at least as fast as 1 / samples,
    and this does not lead past the goal by much."""
    return math.sqrt(short) * math.sqrt(math.sqrt(short))


def allocate(noise: np.ndarray, cost: np.ndarray, pixels: np.ndarray, done: np.ndarray, mean: float, most: int,
             known: bool = True, enough: float = 0.0) -> np.ndarray:
    """The samples that each tile is to have, int64 [rows, columns]: `mean` for each pixel on average, or a little less;
    or as few as make the error, the sum of noise / samples, `enough`.

    `noise`: float64 [rows, columns], the sum over a tile's pixels of the relative variance of one sample; `cost`: of
    one sample of a pixel, positive; `pixels` and `done`: how many there are in each tile, and the samples of each that
    are in. `most`: see `next_mean`. `known`: whether each tile knows its own noise.
    """
    spread = np.sqrt(_smoothed(noise, pixels, known) / cost)
    budget = mean * pixels.sum()

    def given(factor: float) -> np.ndarray:
        wanted = np.clip(factor * spread, 2, min(_MOST * most, 2**31))
        return np.maximum(done, level_below(wanted))

    low, high = 1 / spread.max(), _MOST * most / spread.min()
    for _ in range(_HALVINGS):
        middle = math.sqrt(low * high)
        goals = given(middle)
        if (goals * pixels).sum() <= budget and (noise / goals).sum() >= enough:
            low = middle
        else:
            high = middle
    return given(low)


def _smoothed(noise: np.ndarray, pixels: np.ndarray, known: bool) -> np.ndarray:
    """s of a pixel of each tile, from its own and that of the up to 8 tiles around it; 1 everywhere in an image without
    noise."""
    mean = noise.sum() / pixels.sum()
    if not mean > 0 or noise.size == 1:
        return np.ones(noise.shape)
    s = _around(noise) / _around(pixels)
    if known:
        s = _OWN * noise / pixels + (1 - _OWN) * s
    return np.maximum(s, _LEAST * mean)


def _around(tiles: np.ndarray) -> np.ndarray:
    """The sum over the neighbours of each tile, without its own."""
    rows, columns = tiles.shape
    padded = np.pad(tiles, 1)
    return sum(padded[down:down + rows, right:right + columns]
               for down in range(3) for right in range(3) if (down, right) != (1, 1))
