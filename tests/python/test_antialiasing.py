"""Adaptive antialiasing: edges keep their samples, and what is even all around takes no more of them."""

import numpy as np
import pytest
from commands import run

import tilecast
from tilecast.render.local import Image

WHITTED = "scenes/whitted.json"
CONTRAST = 0.1


def image(contrast: float | None, **how) -> Image:
    settings = ["image.width=320", "image.height=240"]
    if contrast is not None:
        settings.append(f"render.contrast={contrast}")
    return tilecast.render(tilecast.load(WHITTED, settings=settings), samples=32, **how)


@pytest.fixture(scope="module")
def whole():
    return image(None)


@pytest.fixture(scope="module")
def sparing():
    return image(CONTRAST)


def test_edges_keep_their_samples(whole, sparing):
    same = (whole.pixels == sparing.pixels).all(axis=2)
    assert same.mean() < 0.7
    down, across = (np.abs(np.diff(whole.pixels, axis=axis)).max(axis=2) > 0.3 for axis in (0, 1))
    for kept in (same[:-1][down], same[1:][down], same[:, :-1][across], same[:, 1:][across]):
        assert len(kept) > 500 and kept.mean() > 0.995


def test_what_is_even_is_off_by_little(whole, sparing):
    """Much less than the noise that is left at the edges."""
    off = (whole.pixels - sparing.pixels) ** 2 / (whole.pixels**2 + 0.01)
    assert 0 < off.mean() < 0.1 * whole.error["relative_mse"]
    assert np.quantile(off, 0.999) < CONTRAST**2


def test_rays_are_saved(whole, sparing):
    assert sparing.stats["rays"]["camera"] < 0.65 * whole.stats["rays"]["camera"]


@pytest.mark.parametrize("how", [{"tile_size": 7}, {"tile_size": 64, "threads": 1}], ids=["small", "large"])
def test_tiles_do_not_show(sparing, how):
    assert np.array_equal(image(CONTRAST, **how).pixels, sparing.pixels)


def test_an_odd_number_of_samples_weighs_both_halves_right():
    """An even scene: all samples are the same, however many there are."""
    document = {"camera": {"position": [0, 0, 3], "target": [0, 0, 0]}, "image": {"width": 4, "height": 4},
                "background": [0.25, 0.5, 1.0], "render": {"integrator": "whitted", "contrast": 0.1}}
    for samples in (2, 7, 8, 11, 17, 25, 64):
        assert np.array_equal(tilecast.render(tilecast.load(document), samples=samples).pixels,
                              np.full((4, 4, 3), [0.25, 0.5, 1.0], np.float32))


def test_what_the_error_leaves_out_is_said(whole, sparing, tmp_path):
    """Pixels whose samples are alike are those whose error looks small."""
    assert sparing.stats["error_leaves_out"] == ["contrast"] and "error_leaves_out" not in whole.stats
    found = run("render", WHITTED, "-o", tmp_path / "out.png", "--size", "16x12", "--samples", 16, "--set",
                "render.contrast=0.1")
    assert found.returncode == 0 and "the error may be understated: it leaves out what render.contrast skips" in found.stderr
