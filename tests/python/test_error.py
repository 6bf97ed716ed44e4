"""The error estimate against distributions whose error is known.

200 images of each. The tolerances of predicted over true MSE are 5 standard errors. One image's log ratio
scatters by the interval's half width over 1.96, which is 0.036 for grey noise over 64 x 64 pixels (2 /
sqrt(4096), times the unevenness of its variance), so the mean of 200 by 0.0026. A 95% interval that is right
covers 200 times at least 0.95 - 3 sqrt(0.95 * 0.05 / 200) = 90.4% with a probability of 99.8%.
"""

import functools
from dataclasses import replace

import numpy as np
import pytest
from chunks import draw, exposed

from tilecast._core import error_weights, window_mean
from tilecast.render import error as estimation
from tilecast.render.error import weight
from tilecast.render.plan import make_plan

RUNS, SIZE = 200, 64

y, x = np.mgrid[:SIZE, :SIZE] / SIZE
TRUTH = np.stack([0.1 + x, 0.5 + 0.4 * np.sin(9 * y), 0.05 + 0.3 * (x > 0.5)], axis=2)
SPREAD = (0.05 + TRUTH) * [1.0, 0.5, 2.0]


def normal(generator, shape):
    """Channels independent."""
    return TRUTH + SPREAD * generator.standard_normal(shape)


def grey(generator, shape):
    """All channels share their noise, as with light of one colour."""
    return TRUTH + SPREAD * generator.standard_normal((*shape[:3], 1))


def exponential(generator, shape):
    return TRUTH * generator.exponential(size=(*shape[:3], 1))


def rare(generator, shape):
    """One sample in 64 meets the light; the others are black."""
    return TRUTH * (generator.random((*shape[:3], 1)) < 1 / 64) * 64


@functools.cache
def estimates(sampler, samples):
    """For each run: (mse, low, high, true) and the same relative."""
    plan = make_plan(SIZE, SIZE, samples, 32)
    wanted = plan.checkpoints[-2:]  # the last may need what the one before it found
    chunks = [replace(chunk, checkpoint=chunk.range in wanted) for chunk in plan.chunks()]
    found = []
    for seed in range(RUNS):
        film = exposed(plan, draw(plan, sampler, seed), chunks)
        error = film.error(len(wanted) - 1)
        square = (film.pixels().astype(np.float64) - TRUTH) ** 2
        found.append([(error.mse, error.mse_low, error.mse_high, square.mean()),
                      (error.relative_mse, error.low, error.high, (square / (TRUTH**2 + 0.01)).mean())])
    return np.array(found).transpose(1, 2, 0)


def coverage(low, high, true):
    return np.mean((low <= true) & (true <= high))


@pytest.mark.parametrize("sampler, samples", [
    (normal, 16), (normal, 5), (grey, 16), (exponential, 16), (rare, 16)])
def test_predicted_over_true_mse_is_one_and_the_interval_covers(sampler, samples):
    (mse, low, high, true), _ = estimates(sampler, samples)
    assert mse.mean() / true.mean() == pytest.approx(1, abs=0.013)
    assert 0.904 <= coverage(low, high, true)
    assert np.median(np.log(high / mse)) < 0.15  # and is not wide for nothing


@pytest.mark.parametrize("sampler, samples", [(normal, 16), (grey, 16), (exponential, 16), (rare, 16), (rare, 64)])
def test_predicted_over_true_relative_mse_is_within_five_per_cent(sampler, samples):
    _, (relative, _, _, true) = estimates(sampler, samples)
    assert relative.mean() / true.mean() == pytest.approx(1, abs=0.05)


@pytest.mark.parametrize("sampler", [normal, grey, exponential])
def test_the_interval_of_the_relative_error_covers(sampler):
    _, (_, low, high, true) = estimates(sampler, 64)
    assert 0.904 <= coverage(low, high, true)


def estimated(samples):
    """The estimate of an image of one tile, float64 [samples, h, w, 3], from two parts of as many samples."""
    half = len(samples) // 2
    return estimated_by([np.stack([part[::2].sum(axis=0), part[1::2].sum(axis=0)]) for part in (samples[:half], samples[half:])],
                        half)


def estimated_by(parts, samples):
    """The same from the sums of even and odd samples of two parts, float64 [2, h, w, 3], of so many samples each."""
    partials = estimation.tile_partials(parts[0] + parts[1], 2 * samples, [(part, samples) for part in parts])
    return estimation.estimate(partials[None], parts[0][0, :, :, 0].size)


def share_inside(sampler, exact, images):
    """How many of them, of 20 x 40 pixels and 16 samples, have their true error in their interval."""
    generator, inside = np.random.default_rng(1), 0
    for _ in range(images):
        samples = sampler(generator, (16, 20, 40, 3))
        found = estimated(samples)
        inside += found.mse_low <= ((samples.mean(axis=0) - exact) ** 2).mean() <= found.mse_high
    return inside / images


def coloured(generator, shape):
    """Noise of one channel, in which one pixel in twenty has ten times as much."""
    spread = np.where(np.arange(shape[2]) % 20 == 0, 5.0, 0.5)[:, None] * [1.0, 0.0, 0.0]
    return 0.5 + spread * generator.standard_normal(shape)


def edge(generator, shape):
    """Half of each sample's pixels are black, the others white."""
    return np.broadcast_to(generator.random((*shape[:3], 1)) < 0.5, shape) * 1.0


@pytest.mark.parametrize("sampler, exact", [
    (coloured, 0.5), (edge, 0.5), (lambda generator, shape: generator.exponential(size=shape), 1.0),
    (lambda generator, shape: (generator.random((*shape[:3], 1)) < 1 / 32) * np.full(3, 32.0), 1.0)],
    ids=["coloured", "edge", "exponential", "rare"])
def test_the_interval_is_neither_too_narrow_nor_too_wide(sampler, exact):
    """600 images of 20 x 40 pixels; a coverage of 95% scatters by 0.9%, and the logarithm of so few pixels' error is
    not quite normal."""
    assert share_inside(sampler, exact, 600) == pytest.approx(0.95, abs=0.03)


def spots(generator, shape):
    """Twelve pixels have as much noise as all others together."""
    spread = np.ones(800)
    spread[::67] = 8.0
    return 0.5 + spread.reshape(20, 40, 1) * generator.standard_normal((*shape[:3], 1)) * np.ones(3)


def test_the_interval_is_wide_enough_where_few_pixels_carry_the_noise():
    """What they tell of their own variance is known to a third only, which Student's distribution makes up for: without it
    it is 91%. The share of 1500 images scatters by 0.6%."""
    assert 0.92 <= share_inside(spots, 0.5, 1500) <= 0.97


def test_pixels_that_converge_faster_do_not_widen_the_interval():
    """In 24 pixels the later samples of each half make good much of what the earlier ones missed, as low-discrepancy points
    do at edges: so a part of the samples shows more of their noise than is left in the image. 1000 images; by the difference
    of the two parts the interval would be 1.5 times as wide as the deviation."""
    generator, logs = np.random.default_rng(3), []
    for _ in range(1000):
        first, last = generator.standard_normal((2, 2, 800, 1))  # mean errors of even and odd samples
        last[:, ::34] = -0.6 * first[:, ::34] + 0.8 * last[:, ::34]
        first[:, ::34] *= 8
        last[:, ::34] *= 8
        found = estimated_by([8 * (1 + part * np.ones(3)).reshape(2, 20, 40, 3) for part in (first, last)], 16)
        true = ((first + last).mean(axis=0) ** 2).mean() / 4
        logs.append((np.log(true / found.mse), np.log(found.mse_high / found.mse) / 1.96))
    off, widths = np.transpose(logs)
    assert 0.9 <= np.median(widths) / off.std() <= 1.25
    assert 0.93 <= np.mean(np.abs(off) < 1.96 * widths) <= 0.975


@pytest.mark.parametrize("first, last", [(8, 8), (16, 2), (5, 4)])
def test_parts_of_any_size_tell_the_interval(first, last):
    """Of normal noise of one colour: 4 / pixels is the square of the deviation."""
    generator, widths = np.random.default_rng(2), []
    for _ in range(50):
        samples = 0.5 + generator.standard_normal((first + last, 32, 32, 1)) * np.ones(3)
        parts = [(np.stack([part[::2].sum(axis=0), part[1::2].sum(axis=0)]), len(part))
                 for part in (samples[:first], samples[first:])]
        sums = np.stack([samples[::2].sum(axis=0), samples[1::2].sum(axis=0)])
        if first % 2:  # even indices of the second part are odd ones of the whole
            parts[1] = (parts[1][0][::-1], last)
        found = estimation.estimate(estimation.tile_partials(sums, first + last, parts)[None], 1024)
        widths.append(np.log(found.mse_high / found.mse) / 1.96)
    assert np.mean(widths) == pytest.approx(2 / 32, rel=0.05)


def test_the_first_checkpoint_has_an_interval_too():
    (mse, low, high, true), _ = estimates(grey, 2)
    assert mse.mean() / true.mean() == pytest.approx(1, abs=0.013)
    assert 0.904 <= coverage(low, high, true)


def test_light_that_few_have_met_is_not_taken_for_finished():
    """The stop of an image waits for 16 samples. Were I taken for R in
    the denominator, the pixels that have not met the light would hide the error of those that have."""
    _, (relative, _, _, true) = estimates(rare, 16)
    plan = make_plan(SIZE, SIZE, 16, 32)
    film = exposed(plan, draw(plan, rare))
    pixels = film.pixels().astype(np.float64)
    sums = [film._tiles[tile.index].sums for tile in plan.tiles]
    halves = np.zeros((2, SIZE, SIZE, 3))
    for tile, tile_sums in zip(plan.tiles, sums):
        halves[:, *tile.window] = tile_sums / 8
    naive = ((halves[0] - halves[1]) ** 2 / 4 / (pixels**2 + 0.01)).mean()
    assert naive < 0.5 * true.mean()
    assert relative.min() > 0.75 * true.mean()


def test_a_noiseless_image_has_no_error():
    plan = make_plan(SIZE, SIZE, 8, 32)
    error = exposed(plan, np.broadcast_to(TRUTH, (8, SIZE, SIZE, 3))).error(2)
    assert error.mse == error.mse_low == error.mse_high == 0
    assert error.relative_mse == error.low == error.high == 0


def test_one_sample_tells_nothing_of_its_error():
    plan = make_plan(SIZE, SIZE, 1)
    assert plan.checkpoints == ()
    assert exposed(plan, draw(plan, normal)).checkpoints_done == 0


@pytest.mark.parametrize("shape", [(1, 1), (3, 5), (9, 8), (16, 13), (64, 20)])
def test_the_window_mean_is_the_mean_over_the_window(shape):
    image = np.random.default_rng(0).random((2, *shape))
    image[0, 0, 0] = 1e12  # a bright pixel must not drown those outside of its windows
    means = window_mean(image)
    for row in range(shape[0]):
        for column in range(shape[1]):
            window = image[:, max(row - 4, 0):row + 5, max(column - 4, 0):column + 5]
            assert np.allclose(means[:, row, column], window.mean(axis=(1, 2)), rtol=1e-12)


def test_an_image_without_pixels_or_samples_is_no_crash():
    for size in ((0, 0), (0, 5), (5, 0)):
        empty = np.zeros((3, *size))
        assert weight(empty, empty).shape == window_mean(empty).shape == empty.shape
        assert not estimation.tile_partials(np.zeros((2, *size, 3)), 2).any()
    with pytest.raises(ValueError, match="there must be those over all samples"):
        error_weights(np.zeros((0, 3, 4, 4)), np.zeros((0, 3, 4, 4)))


def test_the_denominator_of_flat_light_is_exact_without_noise():
    for size in ((1, 1), (1, 2), (2, 3), (20, 20)):
        flat = np.full((3, *size), 0.7)
        assert np.allclose(weight(flat, np.zeros_like(flat)), 1 / 0.5, rtol=1e-12)


def test_the_denominator_becomes_that_of_the_image_as_noise_falls():
    image = np.moveaxis(TRUTH, 2, 0)
    exact = 1 / (image**2 + 0.01)
    assert np.allclose(weight(image, np.zeros_like(image)), exact, rtol=1e-9)
    assert np.abs(weight(image, np.full_like(image, 1e-6)) / exact - 1).max() < 0.02


def test_a_part_of_the_samples_gives_a_denominator_of_its_own():
    """The mean over one part is off by much in one pixel; what the other parts say of that pixel does not matter."""
    image, variance = np.full((3, 21, 21), 0.2), np.full((3, 21, 21), 1e-4)
    off = image.copy()
    off[:, 10, 10] = 5.0
    _, own, other = error_weights(np.array([image, off, image]), np.array([variance, variance, variance]))
    assert own[0, 10, 10] == pytest.approx(1 / 25, rel=0.05) and other[0, 10, 10] == pytest.approx(1 / 0.05, rel=0.05)


def test_a_bright_sample_does_not_hide_its_own_error():
    """One pixel of a grey tile has met a light that no other has: its denominator stays that of the grey."""
    image, variance = np.full((3, 21, 21), 0.2), np.full((3, 21, 21), 1e-6)
    image[:, 10, 10] += 50
    variance[:, 10, 10] = 50.0**2
    assert weight(image, variance)[:, 10, 10] == pytest.approx(1 / 0.05, rel=0.01)


def test_events_that_no_two_parts_share_leave_the_error_unsure():
    """12 events in 32 x 32 pixels, in each half and part 3, at places of their own: twelve are met 12 +- 3.5 times."""
    generator, halves = np.random.default_rng(0), np.zeros((4, 1024, 3))
    for event, place in enumerate(generator.choice(1024, 12, replace=False)):
        halves[event % 4, place] = 100.0
    first, last = (half.reshape(2, 32, 32, 3) for half in (halves[:2], halves[2:]))
    found = estimation.estimate(estimation.tile_partials(first + last, 32, [(first, 16), (last, 16)])[None], 1024)
    assert found.heavy_tailed
    for mean, low, high in ((found.mse, found.mse_low, found.mse_high), (found.relative_mse, found.low, found.high)):
        assert np.log(high / mean) > 1.96 / np.sqrt(12) and np.log(mean / low) > 1.96 / np.sqrt(12)


def test_events_that_come_back_in_no_pixel_twice_leave_the_error_unsure_without_a_label():
    """Both parts have met events in the same half of the samples of 64 pixels: they agree, and a . b is 0 in each."""
    halves = np.zeros((2, 1024, 3))
    halves[np.arange(64) % 2, np.arange(64)] = 100.0
    part = halves.reshape(2, 32, 32, 3) + 0.0
    last = part * np.random.default_rng(0).uniform(0.5, 1.5, (1, 32, 32, 1))
    found = estimation.estimate(estimation.tile_partials(part + last, 32, [(part, 16), (last, 16)])[None], 1024)
    assert found.heavy_tailed is False
    assert np.log(found.mse_high / found.mse) > 1.96 / 8 and np.log(found.high / found.relative_mse) > 1.96 / 8
