"""Rare events are told from noise that is only uneven.

Two estimates of one variance from 65536 pixels: the share that 1% of them hold scatters by about 1 / sqrt(655) = 0.04
times itself, so that a limit of 0.5 lies 0.8 standard errors above the worst that normal noise can do on average, and
more than 5 above all but the neighbourhood of that worst case, which has a test of its own.
"""

import numpy as np
import pytest
from documents import diffuse, minimal

import tilecast
from tilecast.render import tails

PIXELS = 2**16


def share(*samples):
    """From two parts of the samples of each pixel, [n, pixels] each."""
    variances = [(part[::2].mean(axis=0) - part[1::2].mean(axis=0)) ** 2 for part in samples]
    return tails.tail_share(tails.partials(*variances))


def parts(draw, samples=16, seed=0):
    generator = np.random.default_rng(seed)
    return [draw(generator, (samples // 2, PIXELS)) for _ in range(2)]


@pytest.mark.parametrize("carriers", [0.001, 0.005, 0.01, 0.1, 1.0])
@pytest.mark.parametrize("spread", [3, 1000])
def test_normal_noise_is_not_heavy_however_uneven_its_variance(carriers, spread):
    sigma = np.where(np.arange(PIXELS) < carriers * PIXELS, spread, 1.0)
    assert share(*parts(lambda generator, shape: sigma * generator.standard_normal(shape))) < 0.42


def test_the_worst_that_normal_noise_can_do_is_what_it_was_derived_to_be():
    """Carriers of all variance of which one in three, those beyond one standard deviation, are the top hundredth."""
    sigma = np.arange(PIXELS) < 0.01 / 0.3173 * PIXELS
    found = [share(*parts(lambda generator, shape: sigma * generator.standard_normal(shape), seed=seed))
             for seed in range(8)]
    assert np.mean(found) == pytest.approx(2 * np.exp(-0.5) / np.sqrt(2 * np.pi), abs=0.03)


@pytest.mark.parametrize("draw, low, high", [
    (lambda generator, shape: generator.exponential(size=shape), 0, 0.2),
    (lambda generator, shape: np.exp(generator.standard_normal(shape)), 0, 0.4),
    (lambda generator, shape: generator.random(shape) < 1 / 64, 0, 0.3),
    (lambda generator, shape: generator.pareto(1.5, shape), 0.7, 1),  # no variance
    (lambda generator, shape: generator.random(shape) < 3e-4, 0.9, 1),  # few pixels have met it
    (lambda generator, shape: (generator.random(shape) < 1e-5) * 1e6 + generator.random(shape), 0.9, 1),
])
def test_long_tails_and_rare_events_are_told_from_light_tails(draw, low, high):
    assert low <= share(*parts(draw)) <= high


def test_tiles_add_up():
    a, b = np.random.default_rng(0).pareto(1.5, (2, 60, 40))
    whole = tails.partials(a, b)
    tiles = [tails.partials(a[rows, columns], b[rows, columns])
             for rows in (slice(0, 25), slice(25, 60)) for columns in (slice(0, 13), slice(13, 40))]
    assert np.allclose(np.sum(tiles, axis=0), whole, rtol=1e-12)


def test_no_noise_has_no_tail_and_no_samples_tell_nothing():
    assert tails.tail_share(tails.partials(np.zeros(9), np.zeros(9))) == 0
    assert tails.tail_share(np.zeros(tails.PARTIALS)) is None


# --- Scenes

def lamp(side, glass=False, **render):
    """A ball on a floor under a small square lamp of fixed power."""
    ball = {"object": {"type": "sphere", "radius": 1}, **({"material": {"type": "dielectric"}} if glass else {})}
    return minimal(image={"width": 64, "height": 48}, render=render,
                   scene=[ball, {"object": {"type": "box", "min": [-9, -2, -9], "max": [9, -1, 9]}}],
                   lights=[{"type": "area", "object": {"type": "rectangle", "size": [side, side]},
                            "radiance": [60 / side**2] * 3,
                            "transform": [{"rotate": [180, 0, 0]}, {"translate": [2, 4, 2]}]}])


@pytest.mark.parametrize("samples", [16, 17, 64])
@pytest.mark.parametrize("document", [lamp(0.1, next_event=False), lamp(0.8, glass=True)], ids=["chance", "caustic"])
def test_a_small_lamp_that_is_met_by_chance_is_labelled(document, samples):
    error = tilecast.render(tilecast.load(document), samples=samples).error
    assert error["heavy_tailed"] and error["tail_share"] > 0.9


@pytest.mark.parametrize("samples", [16, 64])
@pytest.mark.parametrize("document", [diffuse(), lamp(0.1), "scenes/cornell.json", "scenes/whitted.json"],
                         ids=["diffuse", "sampled", "cornell", "whitted"])
def test_ordinary_scenes_are_not(document, samples):
    scene = tilecast.load(document, settings=["image.width=64", "image.height=48"])
    error = tilecast.render(scene, samples=samples).error
    assert error["heavy_tailed"] is False


def test_two_samples_do_not_tell():
    error = tilecast.render(tilecast.load(diffuse()), samples=2).error
    assert error["heavy_tailed"] is None and error["tail_share"] is None and error["mse"] > 0
