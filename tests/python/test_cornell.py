"""The Cornell box against an independent renderer's reference, and against itself without next-event estimation."""

import json
from pathlib import Path

import numpy as np
import pytest

import tilecast
from tilecast import _images
from tilecast.scene import override

ROOT = Path(__file__).resolve().parents[2]
SCENE = ROOT / "scenes" / "cornell.json"
REFERENCE = ROOT.parent / "shared" / "references" / "cornell-256.exr"
REFERENCE_MEAN = [0.24016, 0.14113, 0.05998]  # Mitsuba 3.9.1, 12,288 samples a pixel
REFERENCE_NOISE = 2.4e-6                      # its own mean squared error


@pytest.fixture(scope="module")
def image():
    """A quarter of the 1,024 samples that the bounds below are promised for."""
    return tilecast.render(tilecast.load(SCENE), samples=256)


def test_mean_of_each_channel_is_the_references(image):
    assert image.pixels.mean((0, 1)) == pytest.approx(REFERENCE_MEAN, rel=2e-3)


def test_estimated_error_is_small_and_true(image):
    assert image.error["mse"] < 6e-5
    if not REFERENCE.exists():  # a machine without it still has the test above
        return
    reference, channels, _ = _images.read(str(REFERENCE))
    assert channels == ["R", "G", "B"]
    mse = float(np.mean((image.pixels.astype(np.float64) - reference) ** 2))
    assert mse <= 6e-5
    assert image.error["mse"] == pytest.approx(mse - REFERENCE_NOISE, rel=0.1)


def test_paths_that_find_the_light_by_chance_agree():
    """Means with and without next-event estimation, within four standard errors of their difference."""
    means, variances = [], []
    for next_event in ("true", "false"):
        document = override(json.loads(SCENE.read_text()), ["image.width=64", "image.height=64",
                                                            f"render.next_event={next_event}", "render.seed=7"])
        scene = tilecast.load(document).scene
        count = 64 if next_event == "true" else 512
        halves = scene.render_chunk(0, 0, 64, 64, 0, count).sums / (count / 2)
        means.append(halves.mean((0, 1, 2)))
        variances.append(((halves[0] - halves[1]) ** 2 / 4).mean((0, 1)) / 64 ** 2)
    z = (means[0] - means[1]) / np.sqrt(variances[0] + variances[1])
    assert np.all(np.abs(z) < 4), z
