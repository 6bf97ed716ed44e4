"""What decides where samples lie and where paths end changes the noise, and not the image."""

import numpy as np
import pytest

import tilecast

CORNELL = "scenes/cornell.json"


@pytest.fixture(scope="module")
def image():
    def render(**settings):
        scene = tilecast.load(CORNELL, settings=["image.width=32", "image.height=32",
                                                 *(f"render.{key}={value}" for key, value in settings.items())])
        return tilecast.render(scene, samples=256)

    return render


@pytest.mark.parametrize("settings", [{"sampler": "independent"}, {"roulette": "false"}], ids=["sampler", "roulette"])
def test_the_image_stays_what_it_is(image, settings):
    one, other = image(), image(**settings)
    assert not np.array_equal(one.pixels, other.pixels)
    error = np.sqrt((one.variance + other.variance).sum(axis=(0, 1)))
    assert (np.abs((one.pixels - other.pixels).sum(axis=(0, 1))) < 5 * error).all()


def test_sobol_points_have_less_noise(image):
    assert image(sampler="independent").error["mse"] > 1.3 * image().error["mse"]


def test_roulette_saves_rays(image):
    assert image().stats["rays"]["bounce"] < 0.95 * image(roulette="false").stats["rays"]["bounce"]
