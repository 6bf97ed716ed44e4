"""Errors against references: unbiased by their noise, and what is refused."""


import numpy as np
import pytest
from documents import diffuse

from tilecast import SceneError, _images
from tilecast.render import output
from tilecast.render.local import encoded, render
from tilecast.report.curves import error_against_time
from tilecast.report.references import References, read_references
from tilecast.report.variation import parse_variation
from tilecast.scene.loading import load

SIZE = (40, 50, 3)
TRUTH = np.random.default_rng(0).uniform(0.2, 1.0, SIZE)


def noisy(generator, sigma):
    return TRUTH + sigma * generator.standard_normal(SIZE)


def test_two_noisy_references_do_not_bias_the_error():
    """References whose own error is 9 times the image's. A product has the variance 2 s^4 + s^2 (18 s^2) + 81 s^4 = 101
    s^4 for each of 6,000 values, so the mean of 100 images has a standard error of 1.3%."""
    generator, sigma = np.random.default_rng(1), 0.02
    found = [References([noisy(generator, 3 * sigma), noisy(generator, 3 * sigma)]).error(noisy(generator, sigma)).mse
             for _ in range(100)]
    assert np.mean(found) == pytest.approx(sigma**2, rel=0.065)  # five standard errors


def test_the_error_of_a_single_reference_adds_up():
    generator, sigma = np.random.default_rng(2), 0.02
    found = [References([noisy(generator, 3 * sigma)]).error(noisy(generator, sigma)).mse for _ in range(20)]
    assert np.mean(found) == pytest.approx(10 * sigma**2, rel=0.02)


def test_the_bias_of_the_relative_error_is_what_the_text_says():
    """With references as noisy as the image: 1.0%, which was 2.0% with the curvature's. 200 images of 6,000 values whose
    products have the variance 2 + 2 + 1 times the square of the noise's, uneven by f: a standard error of 0.3%. What the
    references say of it is three times as much, as their noise is that of the denominators."""
    generator, sigma = np.random.default_rng(3), 0.03
    f = 1 / (TRUTH**2 + 0.01)
    curvature = 8 * TRUTH**2 * f**3 - 2 * f**2  # f''
    true = (sigma**2 * f).mean()
    found = [References([noisy(generator, sigma), noisy(generator, sigma)]) for _ in range(200)]
    own = [references.own_error() for references in found]
    assert np.mean([of["relative_mse"] for of in own]) == pytest.approx(true / 2, rel=0.05)
    mean = np.mean([references.error(noisy(generator, sigma)).relative_mse for references in found])
    bias = (curvature * sigma**4 / 4).mean()
    assert 0.009 < bias / true < np.mean([of["relative_bias"] for of in own]) < 5 * bias / true
    assert mean == pytest.approx(true + bias, rel=5 * 0.003)


def test_the_part_of_the_error_in_few_pixels_is_told():
    references = References([TRUTH])
    assert references.error(TRUTH + 0.1).top == pytest.approx(2 / 2000)
    pixels = TRUTH.copy()
    pixels[3, 4] += 5
    assert references.error(pixels).top == 1
    assert references.error(TRUTH).top == references.error(TRUTH).mse == 0


def exr(path, pixels):
    path.write_bytes(output.to_exr(np.float32(pixels)))
    return path


def test_references_are_read_from_files(tmp_path):
    one, two = exr(tmp_path / "1.exr", TRUTH), exr(tmp_path / "2.exr", TRUTH + 1)
    found = read_references([one, two], 50, 40)
    assert np.array_equal(found.first, np.float32(TRUTH)) and np.array_equal(found.second, np.float32(TRUTH + 1))
    assert found.independent and not read_references([one], 50, 40).independent


def test_a_reference_that_does_not_fit_is_refused(tmp_path):
    one = exr(tmp_path / "1.exr", TRUTH)
    grey = tmp_path / "grey.exr"
    _images.write(str(grey), np.zeros((40, 50, 1), np.float32), ["Y"])
    (tmp_path / "text.exr").write_text("no image")
    png = tmp_path / "1.png"
    png.write_bytes(output.to_png(np.float32(TRUTH)))
    for paths, message in (
            ([tmp_path / "gone.exr"], "gone.exr is not there"),
            ([tmp_path], "must be an OpenEXR file"),
            ([png], "must be an OpenEXR file"),
            ([tmp_path / "text.exr"], "text.exr cannot be read"),
            ([grey], "must have the channels R, G and B, got Y"),
            ([exr(tmp_path / "nan.exr", np.where(TRUTH < 0.3, np.nan, TRUTH))], "NaN or infinite"),
            ([one, one], "independent renders, got .*1.exr twice"),
            ([one, exr(tmp_path / "copy.exr", TRUTH)], "are the same"),
            ([one, one, one], "one reference or two, got 3")):
        with pytest.raises(SceneError, match=message):
            read_references(paths, 50, 40)
    with pytest.raises(SceneError, match="must have the image's 40 x 50 pixels, got 50 x 40"):
        read_references([one], 40, 50)


@pytest.mark.parametrize("keys, message", [
    ({"seeds": 1}, "two seeds at least"),
    ({"settings": ["render.samples=2"]}, "render.samples: must be at least 3 for an error against run time")])
def test_what_gives_no_curve_is_refused(keys, message, monkeypatch):
    monkeypatch.setattr("tilecast.report.renders.render", None)  # nothing is rendered first
    with pytest.raises(SceneError, match=message):
        error_against_time(diffuse(8, 24, 16), **keys)


def test_references_of_seeds_that_are_measured_are_refused(tmp_path, monkeypatch):
    """The errors of two renders with one seed are the same, and vanish in their difference."""
    document = diffuse(8, 24, 16)
    files = []
    for number, seed in enumerate((0, 1, 7, 8, 7)):
        compiled = load(document, settings=[f"render.seed={seed}"])
        files.append(tmp_path / f"{number}.exr")
        image = render(compiled, samples=16 + number)
        files[-1].write_bytes(encoded(".exr", compiled, image))
    assert read_references(files[2:4], 24, 16).seeds == (7, 8)
    error_against_time(document, seeds=2, reference_files=files[2:4])
    monkeypatch.setattr("tilecast.report.renders.render", None)  # nothing is rendered first
    for references, message in ((files[1:3], "1.exr was rendered with seed 1, which is measured"),
                                ([files[2], files[4]], "independent renders: .* both have seed 7")):
        with pytest.raises(SceneError, match=message):
            error_against_time(document, seeds=2, reference_files=references)


def test_an_image_that_is_its_own_reference_is_refused(tmp_path):
    """Files of other programs, or of earlier versions, do not say their seeds."""
    document = diffuse(8, 24, 16)
    for seed in (0, 5):
        exr(tmp_path / f"{seed}.exr", render(load(document, settings=[f"render.seed={seed}"])).pixels)
    with pytest.raises(SceneError, match="a reference is the image of seed 0 itself, bit for bit"):
        error_against_time(document, seeds=2, reference_files=[tmp_path / "0.exr", tmp_path / "5.exr"])


def test_no_reference_has_a_seed_of_any_value():
    found = error_against_time(diffuse(4, 8, 8), seeds=2, variation=parse_variation("render.seed=0,2147483648"))
    measured = {seed for curve in found["curves"] for seed in curve["seeds"]}
    assert measured == {0, 1, 2**31, 2**31 + 1}
    for curve in found["curves"]:
        assert not measured & set(curve["references"]["seeds"]) and len(set(curve["references"]["seeds"])) == 2
