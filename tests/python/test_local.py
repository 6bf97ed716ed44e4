"""Rendering on threads: the same pixels from any number of them, any tiles and any accelerator."""

import json
import threading

import numpy as np
import pytest
from documents import diffuse, minimal, quick

import tilecast
from tilecast import _core
from tilecast.render import local
from tilecast.render.rendering import Rendering
from tilecast.scene.schema import Stop

STATS = {"seconds": {"load", "compile", "render", "write"}, "samples": None, "rays": {"camera", "bounce", "shadow"},
         "rays_per_second": None, "error": {"mse", "relative_mse", "low", "high"}, "curve": None,
         "accelerator": {"kind", "nodes", "bytes", "seconds"}, "features": {"used", "left_out"}, "kernel": None}


def crowd() -> dict:
    """Instances of a mesh and of solids, enough for a hierarchy; nested groups."""
    rng = np.random.default_rng(1)
    document = quick(6, 72, 52)
    grain = {"type": "group", "of": [{"object": "pyramid", "transform": [{"translate": list(rng.normal(size=3))}]}
                                     for _ in range(12)] + [{"type": "sphere", "radius": 0.2}]}
    document["objects"]["grain"] = grain
    document["scene"] += [{"object": "grain", "material": name, "transform": [
        {"scale": float(rng.uniform(0.2, 0.5))}, {"rotate": list(rng.uniform(-180, 180, 3))},
        {"translate": list(rng.normal(size=3) * 2)}]} for name in ["brass", "glass"] * 10]
    return document


@pytest.fixture(scope="module")
def scene():
    return tilecast.load(crowd())


@pytest.fixture(scope="module")
def pixels(scene):
    return tilecast.render(scene, threads=1, tile_size=16).pixels


@pytest.mark.parametrize("threads", [1, 2, 3])
@pytest.mark.parametrize("tile_size", [16, 32, 64])
def test_threads_and_tiles_change_no_pixel(scene, pixels, threads, tile_size):
    image = tilecast.render(scene, threads=threads, tile_size=tile_size)
    assert image.pixels.shape == (52, 72, 3) and image.pixels.dtype == np.float32
    assert np.array_equal(image.pixels, pixels)
    assert pixels.std() > 0.01


@pytest.mark.parametrize("integrator", ["path", "whitted"])
def test_every_accelerator_gives_the_same_pixels(integrator):
    images = {}
    for accelerator in ("auto", *_core.ACCELERATORS):
        scene = tilecast.load(crowd(), settings=[f"render.accelerator={accelerator}", f"render.integrator={integrator}"])
        if accelerator != "auto":
            assert scene.scene.accelerator["kind"] == accelerator
        images[accelerator] = tilecast.render(scene, samples=4).pixels
    assert np.array_equal(images["none"], images["bvh"])
    assert np.array_equal(images["none"], images["auto"])


def test_the_seed_changes_the_noise_and_nothing_else():
    one, other = (tilecast.render(tilecast.load(diffuse(64, seed=seed))) for seed in (0, 1))
    assert not np.array_equal(one.pixels, other.pixels)
    difference = np.mean((one.pixels.astype(float) - other.pixels) ** 2)
    # Two independent images differ by the sum of their errors.
    assert sum(image.error["mse_low"] for image in (one, other)) < difference
    assert difference < sum(image.error["mse_high"] for image in (one, other))


def test_the_statistics_hold_every_field_of_the_contract(scene):
    image = tilecast.render(scene, samples=8)
    json.dumps(image.stats, allow_nan=False)
    for key, fields in STATS.items():
        assert key in image.stats
        if fields:
            assert fields <= set(image.stats[key]), key
    assert image.error == image.stats["error"]
    assert image.stats["samples"] == 8
    assert [point["samples"] for point in image.stats["curve"]] == [2, 4, 8]
    assert {"seconds", "samples", "relative_mse", "low", "high"} <= set(image.stats["curve"][0])
    assert image.stats["rays"]["camera"] == 72 * 52 * 8
    assert min(image.stats["rays"].values()) > 0
    used, left_out = (set(image.stats["features"][key]) for key in ("used", "left_out"))
    assert used | left_out == set(_core.FEATURES) and not used & left_out


def test_events_come_while_the_image_does(scene):
    events, threads = [], set()

    def on_event(event, rendering):
        assert isinstance(rendering, Rendering)
        threads.add(threading.get_ident())
        events.append(event)

    tilecast.render(scene, samples=4, on_event=on_event)
    assert len(threads) == 1 and threading.get_ident() not in threads
    assert {event["type"] for event in events} == {"tile", "error"}


def test_the_scene_s_own_stop_counts_unless_another_is_given():
    scene = tilecast.load(diffuse(4096, stop={"relative_mse": 1000.0}))
    assert tilecast.render(scene).stats["samples"] == 16
    assert tilecast.render(scene, samples=64, stop=Stop()).stats["samples"] == 64
    assert tilecast.render(scene, samples=2**20, stop=Stop(seconds=0.2)).stats["seconds"]["render"] < 10


def test_a_sample_that_is_not_finite_ends_the_render_with_its_place(scene):
    class Failing:
        width, height = 8, 8

        def render_chunks(self, chunks):
            raise _core.SampleError("a sample is not finite: pixel (1, 2), sample 3, seed 4")

    failing = local.Compiled(Failing(), scene.document, {})
    with pytest.raises(_core.SampleError, match=r"pixel \(1, 2\), sample 3, seed 4"):
        tilecast.render(failing)


def test_an_error_in_a_callback_ends_the_render(scene):
    def on_event(event, rendering):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        tilecast.render(scene, on_event=on_event)


def test_a_large_image_with_few_samples_is_rendered():
    scene = tilecast.load(minimal(image={"width": 1500, "height": 1}, background=[1, 1, 1]))
    assert (tilecast.render(scene, samples=1).pixels == 1).all()
    assert tilecast.render(scene, samples=1).error["mse"] is None


def test_the_error_that_is_told_is_the_error_that_is_there():
    """64 samples against other 4096: their own error adds 1 / 64."""
    reference = tilecast.render(tilecast.load(diffuse(4096, seed=1))).pixels.astype(float)
    image = tilecast.render(tilecast.load(diffuse(64)))
    square = np.mean((image.pixels - reference) ** 2) / (1 + 1 / 64)
    assert image.error["mse_low"] < square < image.error["mse_high"]
    relative = np.mean((image.pixels - reference) ** 2 / (reference**2 + 0.01)) / (1 + 1 / 64)
    assert image.error["low"] * 0.95 < relative < image.error["high"] * 1.05

    # An image of 1200 pixels is surely below a target when its estimate is 12% lower; levels lie at most an eighth apart,
    # the realised error scatters by 5%, and the estimate is as far from it as that.
    for adaptive in (False, True):
        scene = tilecast.load(diffuse(4096, adaptive=adaptive))
        image = tilecast.render(scene, stop=Stop(relative_mse=1e-4))
        assert 16 < image.stats["samples"] < 1024
        square = np.mean((image.pixels - reference) ** 2 / (reference**2 + 0.01)) / (1 + image.stats["samples"] / 4096)
        assert 0.65e-4 < square < 1.1e-4
