"""Error against run time of renders whose error and time are known on paper."""

import json

import numpy as np
import pytest

from tilecast.report import curves
from tilecast.report.curve_table import curve_table
from tilecast.report.plot import plot
from tilecast.report.references import References
from tilecast.report.renders import Taken

SIZE = (60, 80, 3)  # 14,400 values: one image's MSE scatters by sqrt(2 / 14,400) = 1.2%
TRUTH = np.random.default_rng(0).uniform(0.2, 1.0, SIZE)
SIGMA = 0.3 * (TRUTH**2 + 0.01) ** 0.5  # of one sample: a relative MSE of 0.09 / n
CHECKPOINTS = [4, 16, 64]
PER_SAMPLE = 0.01  # seconds


def known(seed, samples, noise=None, estimate=1.0, width=1.06):
    """An image of so many independent samples, which takes as many hundredths of a second."""
    generator = np.random.default_rng([seed, samples])
    noise = generator.standard_normal(SIZE) if noise is None else noise(generator)
    pixels = TRUTH + SIGMA * samples**-0.5 * noise
    relative, mse = (estimate * value / samples for value in (0.09, (SIGMA**2).mean()))
    return Taken(np.float32(pixels), {"mse": mse, "relative_mse": relative, "low": relative / width,
                                      "high": relative * width},
                 samples, PER_SAMPLE * samples, 2 * PER_SAMPLE * samples)


def references(sigma=0.0):
    generator = np.random.default_rng(99)
    return References([TRUTH + sigma * SIGMA * generator.standard_normal(SIZE) for _ in range(2)])


def summary(render=known, sigma=0.0, seeds=8, checkpoints=CHECKPOINTS):
    return curves.summary([curves.measured(render, references(sigma), seed, checkpoints) for seed in range(seeds)])


@pytest.mark.parametrize("sigma", [0.0, 0.1])  # of the references: 0.1 makes them as noisy as the image of 100 samples
def test_known_noise_has_its_error_slope_and_times(sigma):
    found = summary(sigma=sigma)
    for point, samples in zip(found["points"], CHECKPOINTS):
        assert (point["samples"], point["seconds"], point["cpu_seconds"]) == (
            samples, PER_SAMPLE * samples, 2 * PER_SAMPLE * samples)
        mse, relative = point["mse"], point["relative_mse"]
        assert mse["mean"] == pytest.approx((SIGMA**2).mean() / samples, rel=0.03)
        assert relative["mean"] == pytest.approx(0.09 / samples, rel=0.03)
        assert relative["low"] < relative["mean"] < relative["high"] < 1.05 * relative["mean"]
        assert point["efficiency"] == pytest.approx(1 / (mse["mean"] * PER_SAMPLE * samples))
        assert point["predicted_over_true"]["mean"] == pytest.approx(1, abs=0.03)
        assert point["covered"] >= 6 and len(point["runs"]) == 8
    for slope in found["slope"].values():
        assert slope["value"] == pytest.approx(-1, abs=5 * 0.006 + slope["standard_error"])
        assert 0 < slope["standard_error"] < 0.02
    first, second = found["time_to"]["0.01"], found["time_to"]["0.001"]
    assert (first["how"], second["how"]) == ("measured", "extrapolated")
    assert first["seconds"] == pytest.approx(0.09, rel=0.05) and second["seconds"] == pytest.approx(0.9, rel=0.1)
    assert found["heavy_tailed"] == []
    efficiencies = [point["efficiency"] for point in found["points"]]
    assert max(efficiencies) < 1.06 * min(efficiencies)  # flat, as the work of independent samples is


def test_a_false_estimate_is_told():
    found = summary(lambda seed, samples: known(seed, samples, estimate=0.5))
    assert found["points"][1]["predicted_over_true"]["mean"] == pytest.approx(0.5, abs=0.02)
    assert [point["covered"] for point in found["points"]] == [0, 0, 0]
    assert len(found["heavy_tailed"]) == 4  # at 16 and at 64 samples; 4 are too few to judge by
    assert found["heavy_tailed"][0].startswith("at 16 samples the estimate is 0.50 (0.4")
    assert found["heavy_tailed"][1] == "at 16 samples the 95% interval holds the error in 0 of 8 images"


def test_error_in_few_pixels_is_a_heavy_tail():
    def fireflies(generator):
        noise = np.zeros(SIZE)
        noise[generator.integers(60, size=3), generator.integers(80, size=3)] = 3 * (4800 / 3) ** 0.5 / 3
        return noise
    [reason] = summary(lambda seed, samples: known(seed, samples, fireflies, width=100))["heavy_tailed"]
    assert reason == "a thousandth of the pixels carries 100% of the squared error"


def test_what_images_say_of_themselves_counts():
    def label(seed, samples):
        taken = known(seed, samples)
        taken.error["heavy_tailed"] = seed < 5
        return taken
    assert summary(label)["heavy_tailed"] == ["5 of 8 images say so themselves"]


def report(*found):
    return {"machine": {"threads": 2}, "curves": [
        {"label": label, "value": value, "width": 80, "height": 60, "seeds": list(range(8)),
         "seconds": {"load": 0.001, "compile": 0.002},
         "references": {"samples": 1024, "relative_mse": 1e-5, "relative_bias": 0.0123}, **curve} for label, value, curve in found]}


def test_a_table_has_a_line_for_each_checkpoint_and_each_finding():
    lines = curve_table(report(("", None, summary()))).splitlines()
    assert lines[0] == "80 x 60 pixels, 8 seeds, 2 threads, load 0.001 s, compile 0.002 s"
    assert lines[1].startswith("references: two independent renders of 1024 samples a pixel; relative MSE of their ")
    head, *rows = lines[3:7]
    assert head.split() == "samples seconds CPU s MSE relative MSE predicted/true covered efficiency".split()
    assert [row.split()[:3] for row in rows] == [["4", "0.04", "0.08"], ["16", "0.16", "0.32"], ["64", "0.64", "1.28"]]
    assert len({len(row) for row in (head, *rows)}) == 1  # columns are aligned
    assert lines[8].startswith("slope of the relative MSE: -") and lines[8].endswith("(-1 for independent samples)")
    assert lines[9].startswith("relative MSE 0.01: after 0.0") and lines[10].endswith("s, extrapolated along the slope")
    assert lines[11] == "not heavy-tailed: the images' own estimates can be trusted"


def test_several_curves_stand_side_by_side():
    slow = summary(lambda seed, samples: known(seed, samples, estimate=0.5))
    text = curve_table(report(("render.a=1", 1, summary()), ("render.a=2", 2, slow)))
    assert [line.split()[0] for line in text.splitlines()[-2:]] == ["render.a=1", "render.a=2"]
    assert [line.split()[-1] for line in text.splitlines()[-2:]] == ["-", "heavy"]


def test_an_image_without_error_is_told_without_logarithms():
    found = summary(lambda seed, samples: known(seed, samples, noise=lambda _: np.zeros(SIZE), estimate=0.0), seeds=2)
    exact = {"points": found["points"], **{key: found[key] for key in ("slope", "time_to", "heavy_tailed")}}
    for point in exact["points"]:
        assert point["relative_mse"]["mean"] < 1e-12  # but for float32
    nothing = curves.summary([curves.measured(lambda seed, samples: Taken(TRUTH, {
        "mse": 0.0, "relative_mse": 0.0, "low": 0.0, "high": 0.0}, samples, 0.1, 0.1), references(), seed, CHECKPOINTS)
        for seed in range(2)])
    assert nothing["slope"] == {"seconds": None, "samples": None}
    assert nothing["time_to"]["0.01"] == {"seconds": 0.1, "how": "within"}
    assert [point["efficiency"] for point in nothing["points"]] == [None] * 3
    json.dumps(nothing, allow_nan=False)
    found = report(("", None, nothing))
    assert "slope" not in curve_table(found)
    assert plot(found, "nothing")["png"].startswith(b"\x89PNG")


def test_a_plot_is_a_png_and_an_svg_and_is_the_same_each_time():
    found = report(("render.a=1", 1, summary()), ("render.a=2", 2, summary(sigma=0.1)))
    first, second = plot(found, "two curves"), plot(found, "two curves")
    assert first == second and set(first) == {"png", "svg"}
    assert first["png"].startswith(b"\x89PNG") and b"</svg>" in first["svg"]


def test_references_no_better_than_the_images_are_told():
    found = report(("", None, summary()))
    references = found["curves"][0]["references"]
    assert curve_table(found).splitlines()[1].endswith("which biases no MSE below, and the relative ones by some 1.2% at most")
    references["relative_mse"] = 0.1
    assert curve_table(found).splitlines()[1].endswith("but the relative ones: it is no better than the images; give "
                                                       "references more samples")
