"""Adaptive sampling: it spends samples where the error is, and what it must not do: make the image darker by taking
pixels for finished that have not met the light yet.

Samples are drawn as sums, chunk by chunk, keyed by tile and chunk.
"""

from functools import partial

import numpy as np
import pytest
from documents import minimal

import tilecast
from tilecast.render.allocation import allocate, level_above, level_below, next_mean
from tilecast.render.plan import make_plan
from tilecast.render.rendering import ChunkResult, Rendering
from tilecast.scene.schema import Stop

SIZE = 128


def rare(generator, chunk, part, probability=0.01):
    """Each sample meets the light with this probability; the mean is 1."""
    return generator.binomial(part, probability, (chunk.tile.height, chunk.tile.width, 1)) / probability


def rendered(sums, seed=0, samples=64, target=None, adaptive=True):
    """A rendering to its end; `sums(generator, chunk, n)` draws the sum of n samples of a chunk."""
    rendering = Rendering(make_plan(SIZE, SIZE, samples, adaptive=True), Stop(relative_mse=target), adaptive=adaptive)
    while (chunk := rendering.next_chunk()) is not None:
        generator = np.random.default_rng((seed, chunk.tile.index, chunk.range))
        halves = [np.broadcast_to(sums(generator, chunk, chunk.count // 2), (chunk.tile.height, chunk.tile.width, 3))
                  for _ in range(2)]
        rendering.add(chunk, ChunkResult(np.array(halves), (0, 0, 0), 0.0))
    assert rendering.finished
    return rendering


def mean_samples(rendering):
    return rendering.film.samples / SIZE**2


# --- Levels and shares

def test_levels_are_powers_of_two_and_eighths_between_them():
    levels = [2]
    while levels[-1] < 5000:
        levels.append(level_above(levels[-1]))
    assert levels[:14] == [2, 4, 8, 16, 18, 20, 22, 24, 26, 28, 30, 32, 36, 40] and 4096 in levels
    for samples in range(2, 5000):
        assert level_below(np.array([samples]))[0] == max(level for level in levels if level <= samples)
        assert level_above(samples) == min(level for level in levels if level > samples)


@pytest.mark.parametrize("samples, most, short, expected", [
    (16, 1024, None, 32), (31.7, 1024, None, 64), (64, 100, None, 100), (127.9, 1024, 1.01, 144),
    (64, 1024, 100.0, 128), (64, 1024, 1.01, 72),
    (64, 1024, 1.5, 80), (120, 1024, 1.01, 128), (16, 17, 1.01, 17)])
def test_the_next_round_ends_at_a_power_of_two_or_near_the_target(samples, most, short, expected):
    assert next_mean(samples, most, short) == expected


def test_a_round_ends_where_the_error_is_enough():
    generator = np.random.default_rng(0)
    noise, pixels, done = generator.lognormal(0, 2, (40, 40)), np.full((40, 40), 64), np.full((40, 40), 64)
    one = np.ones((40, 40))
    for enough in (0.9, 0.5, 0.2):
        goals = allocate(noise, one, pixels, done, 4096, 4096, enough=enough * (noise / done).sum())
        assert 1 <= (noise / goals).sum() / (enough * (noise / done).sum()) < 1.02
    assert allocate(noise, one, pixels, done, 128, 4096, enough=1e-9).mean() > 127  # the mean comes first


def test_a_tile_that_does_not_know_its_noise_is_judged_by_the_tiles_around_it():
    noise, pixels, done = np.ones((9, 9)), np.full((9, 9), 64), np.full((9, 9), 16)
    noise[4, 4] = 100.0
    goals = allocate(noise, np.ones((9, 9)), pixels, done, 64, 4096, known=False)
    others = np.ones((9, 9), bool)
    others[3:6, 3:6] = False
    assert len(set(goals[others])) == 1 and goals[4, 4] == goals[0, 0]
    assert (goals[3:6, 3:6] > goals[0, 0]).sum() == 8


def test_shares_follow_the_square_root_of_the_noise_and_keep_within_the_mean():
    noise, pixels, done = np.ones((8, 8)), np.full((8, 8), 256), np.full((8, 8), 16)
    noise[:, :4] = 16.0
    one = np.ones((8, 8))
    goals = allocate(noise * pixels, one, pixels, done, 160, 4096)
    assert (goals * pixels).sum() <= 160 * pixels.sum() and goals.mean() > 150
    assert goals[4, 0] / goals[4, 7] == pytest.approx(4, rel=1 / 8)
    assert (allocate(noise * pixels, one, pixels, goals, 200, 4096) >= goals).all()
    dear = allocate(one * pixels, np.where(np.arange(8) < 4, 4.0, 1.0) * one, pixels, done, 160, 4096)
    assert dear[4, 7] / dear[4, 0] == pytest.approx(2, rel=1 / 8)


def test_no_tile_is_left_behind_and_none_takes_all():
    noise, pixels, done = np.zeros((32, 32)), np.full((32, 32), 256), np.full((32, 32), 16)
    noise[16, 16] = 1e9
    goals = allocate(noise, np.ones((32, 32)), pixels, done, 256, 256)
    assert goals[0, 0] >= 16 and goals[16, 16] == 16 * 256 and (goals[15:18, 15:18] > 256).all()
    goals = allocate(noise, np.ones((32, 32)), pixels, done, 2**14, 2**14)
    assert goals[0, 0] > 2**14 / 16
    flat = allocate(np.zeros((4, 4)), np.ones((4, 4)), np.full((4, 4), 256), np.full((4, 4), 16), 100, 128)
    assert (flat == 96).all()  # the level below 100


# --- Bias

def test_light_that_few_have_met_is_not_made_darker():
    """16 samples of the pilot have met the light in 15% of the pixels. The mean of 16 images scatters by
    sqrt(99 / (16 * 64 * 128^2)) = 0.0024; the bias is bounded by 0.5%."""
    means = [rendered(rare, seed).film.pixels().mean() for seed in range(16)]
    assert abs(np.mean(means) - 1) < 0.005 + 3 * 0.0024


def test_light_that_is_seldom_met_even_by_many_samples_is_not_biased():
    """A pixel meets it every other time in 256 samples, a tile 8 times in the first 64. The mean of 16 images scatters
    by sqrt(499 / (16 * 256 * 128^2)) = 0.0027."""
    means = [rendered(partial(rare, probability=0.002), seed, samples=256).film.pixels().mean() for seed in range(16)]
    assert abs(np.mean(means) - 1) < 0.005 + 3 * 0.0027


def test_light_in_one_corner_that_few_have_met_is_not_made_darker():
    """Rare events in the left half, and noise that is nothing beside them elsewhere."""
    def sums(generator, chunk, part):
        if chunk.tile.x < SIZE // 2:
            return rare(generator, chunk, part)
        return part + generator.normal(0, 0.1 * np.sqrt(part), (chunk.tile.height, chunk.tile.width, 1))
    images = [rendered(sums, seed) for seed in range(16)]
    left = [image.film.pixels()[:, :SIZE // 2].mean() for image in images]
    assert abs(np.mean(left) - 1) < 0.005 + 3 * 0.0024
    assert np.mean([mean_samples(image) for image in images]) <= 64
    counts = images[0].film.sample_counts()
    assert counts[:, :SIZE // 2].min() > 64 > counts[:, SIZE // 2 + 16:].max()


# --- What it gains, and that it knows its error

def uneven(generator, chunk, part):
    """A quarter of the image has ten times the noise."""
    sigma = 0.5 if chunk.tile.x < SIZE // 2 and chunk.tile.y < SIZE // 2 else 0.05
    return 0.5 * part + generator.normal(0, sigma * np.sqrt(part), (chunk.tile.height, chunk.tile.width, 1))


def test_a_target_is_reached_with_fewer_samples():
    """Of sqrt(s): (1/4 + 3/4 / 10)^2 / (1/4 + 3/4 / 100) = 0.41 in theory, were it not for the pilot and the tiles
    beside the noisy ones."""
    target = 0.5**2 / 0.26 / 4 / 300
    uniform, adaptive = (rendered(uneven, 0, 4096, target, adaptive) for adaptive in (False, True))
    assert mean_samples(adaptive) < 0.6 * mean_samples(uniform)
    for rendering in (uniform, adaptive):
        true = ((rendering.film.pixels().astype(float) - 0.5) ** 2 / 0.26).mean()
        assert 0.8 * target < true < 1.03 * target


def test_the_error_of_an_adaptive_image_is_the_one_it_tells():
    ratios = []
    for seed in range(12):
        rendering = rendered(uneven, seed)
        true = ((rendering.film.pixels().astype(float) - 0.5) ** 2).mean()
        ratios.append(rendering.curve[-1]["mse"] / true)
        assert rendering.curve[-1]["samples"] == pytest.approx(mean_samples(rendering))
    # A ratio scatters by 2 sqrt(2 / 4096) = 0.044: its mean by 0.013
    assert np.mean(ratios) == pytest.approx(1, abs=0.04)


# --- Scenes

SCENE = minimal(image={"width": 96, "height": 64}, render={"adaptive": True, "samples": 48}, background=[0.2, 0.2, 0.2],
                scene=[{"object": {"type": "sphere", "radius": 1}}],
                lights=[{"type": "area", "object": {"type": "rectangle", "size": [1, 1]}, "radiance": [9, 9, 9],
                         "transform": [{"rotate": [180, 0, 0]}, {"translate": [0, 3, 0]}]}])


def test_threads_do_not_change_an_adaptive_image():
    scene = tilecast.load(SCENE)
    one, three = (tilecast.render(scene, threads=threads) for threads in (1, 3))
    assert np.array_equal(one.pixels, three.pixels) and np.array_equal(one.sample_counts, three.sample_counts)
    assert one.stats["samples"] <= 48 and one.stats["tile_size"] == 8
    assert one.sample_counts[0, 0] < 48 < one.sample_counts.max()  # the background has no noise


def test_adaptive_samples_lower_the_error():
    scene = tilecast.load(SCENE)
    uniform = tilecast.render(tilecast.load(SCENE, settings=["render.adaptive=false"]))
    assert tilecast.render(scene).error["relative_mse"] < 0.8 * uniform.error["relative_mse"]
