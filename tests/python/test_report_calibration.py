"""Calibration of estimates that are right, and of some that are not."""

import numpy as np
import pytest

from tilecast import SceneError
from tilecast.render import error
from tilecast.report.calibration import _true_errors, calibrate, calibration_table
from tilecast.report.renders import Taken

HEIGHT, WIDTH, RENDERS = 24, 32, 300
TRUTH = np.random.default_rng(0).uniform(0.2, 1.0, (HEIGHT, WIDTH, 3))


def grey(seed, samples=64):
    """An image of normal samples of one colour, and what it says of itself."""
    noise = np.random.default_rng(seed).standard_normal((2, HEIGHT, WIDTH, 1))
    sums = (samples / 2) * TRUTH + (samples / 2) ** 0.5 * 0.2 * TRUTH * noise  # of even and of odd samples
    found = error.estimate(np.array([error.tile_partials(sums, samples)]), HEIGHT * WIDTH)
    return Taken(np.float32((sums[0] + sums[1]) / samples), found.to_json(), samples, 1.0, 1.0)


def scaled(factor, width=1.0):
    """The same with all estimates multiplied, and intervals so many times as wide on a logarithmic axis."""
    def render(seed, samples):
        taken = grey(seed, samples)
        taken.error.update({key: factor * value for key, value in taken.error.items()
                            if isinstance(value, float) and key != "tail_share"})
        for of, low, high in (("mse", "mse_low", "mse_high"), ("relative_mse", "low", "high")):
            for end in (low, high):
                taken.error[end] = taken.error[of] * (taken.error[end] / taken.error[of]) ** width
        return taken
    return render


def test_a_right_estimate_is_not_called_wrong():
    """Coverage of 300 has a standard error of 1.3%."""
    done = []
    found = calibrate(grey, range(RENDERS), 64, done.append)
    assert done[-1] == found["renders"] == RENDERS and (found["width"], found["height"]) == (WIDTH, HEIGHT)
    for key in ("mse", "relative_mse"):
        assert found[key]["verdict"] in ("holds", "open")
        assert found[key]["coverage"]["mean"] == pytest.approx(0.95, abs=0.04)
        assert found[key]["predicted_over_true"]["mean"] == pytest.approx(1, abs=0.03)
        assert found[key]["above"] + found[key]["below"] == round(RENDERS * (1 - found[key]["coverage"]["mean"]))
    lines = calibration_table(found).splitlines()
    assert lines[0].startswith("300 renders of 32 x 24 pixels, 64 samples a pixel")
    assert [line[:12].strip() for line in lines[2:4]] == ["MSE", "relative MSE"]
    assert lines[4] == "0 of 300 images say themselves that they are heavy-tailed"


@pytest.mark.parametrize("factor, width", [(0.8, 1.0), (1.0, 0.5), (1.0, 2.0)])
def test_a_wrong_estimate_or_interval_fails(factor, width):
    found = calibrate(scaled(factor, width), range(RENDERS), 64)
    assert found["mse"]["verdict"] == found["relative_mse"]["verdict"] == "fails"


def test_the_others_stand_in_for_the_truth():
    """Against the truth itself: the difference has no bias, and scatters by sqrt(4 / 39) of one image's error."""
    images = [grey(seed).pixels for seed in range(40)]
    found = np.array([error.mse for error in _true_errors(images)])
    true = np.array([((image - TRUTH) ** 2).mean() for image in images])
    one = true.mean() * (4 / 39 / (HEIGHT * WIDTH)) ** 0.5
    assert np.abs(found - true).max() < 6 * one * 2  # the noise is proportional to the truth: uneven over the image


def test_few_renders_are_refused():
    with pytest.raises(ValueError, match="8 renders at least, got 7"):
        calibrate(grey, range(7), 4)


def test_one_sample_is_refused_before_anything_is_rendered():
    with pytest.raises(SceneError, match="render.samples: must be at least 2 for a calibration, got 1"):
        calibrate(None, range(8), 1)
