"""What a report says of an expectation, against tables, closed forms and repeated draws.

A 95% interval that is right covers 4,000 times between 93.3% and 96.7% with a probability of 1 - 1e-6 (4.9 standard
errors of 0.34%).
"""

import numpy as np
import pytest

from tilecast.report import estimates

DRAWS = 4000


@pytest.mark.parametrize("freedom, table", [(1, 12.706), (2, 4.303), (3, 3.182), (4, 2.776), (5, 2.571), (7, 2.365),
                                            (10, 2.228), (30, 2.042), (120, 1.980), (2001, 1.961)])
def test_students_t_is_that_of_the_tables(freedom, table):
    assert estimates.student_95(freedom) == pytest.approx(table, abs=5e-4)


@pytest.mark.parametrize("runs", [2, 6, 20])
def test_a_band_covers_the_mean(runs):
    values = np.random.default_rng(runs).normal(3.0, 0.1, (DRAWS, runs))
    bands = [estimates.band(row) for row in values]
    assert 0.933 < np.mean([found.low <= 3 <= found.high for found in bands]) < 0.967
    assert all(found.mean == pytest.approx(row.mean()) and found.low > 0 for found, row in zip(bands, values))


def test_a_band_of_what_is_not_positive_is_that_about_a_mean():
    found = estimates.band([-1.0, 1.0, -3.0])
    assert (found.mean, found.high + found.low) == (-1, -2)
    assert found.high + 1 == pytest.approx(4.303 * 2 / 3**0.5, rel=1e-3)
    assert estimates.band([0.0, 0.0]).to_json() == {"mean": 0, "low": 0, "high": 0}


def test_a_quotient_knows_that_its_parts_belong_together():
    """A band for each part alone would be ten times as wide."""
    generator = np.random.default_rng(1)
    under = generator.normal(2, 0.4, (DRAWS, 8))
    over = 0.9 * under + generator.normal(0, 0.04, under.shape)
    found = [estimates.quotient(*pair) for pair in zip(over, under)]
    assert np.mean([quotient.mean for quotient in found]) == pytest.approx(0.9, abs=1e-3)
    assert 0.933 < np.mean([quotient.low <= 0.9 <= quotient.high for quotient in found]) < 0.967
    assert np.median([quotient.high / quotient.mean for quotient in found]) < 1.03
    assert estimates.quotient([1, 2], [0, 0]) is None


@pytest.mark.parametrize("found, of", [(0, 6), (3, 6), (6, 6), (190, 200), (1, 2)])
def test_the_ends_of_a_share_are_where_the_normal_test_just_fails(found, of):
    share = estimates.share(found, of)
    assert share.mean == found / of
    for end in (share.low, share.high):  # Wilson: (share - p)^2 = 1.96^2 p (1 - p) / n
        assert (share.mean - end) ** 2 == pytest.approx(1.959963984540054**2 * end * (1 - end) / of, abs=1e-9)


def test_a_power_law_has_its_slope():
    x = [1, 2, 4, 8, 16]
    found = estimates.slope(x, [[3 * value**-1.5 for value in x]] * 2)
    assert (found.value, found.standard_error) == (pytest.approx(-1.5), pytest.approx(0, abs=1e-12))
    found = estimates.slope(x, [[value**-1.0 for value in x], [value**-2.0 for value in x]])
    assert (found.value, found.standard_error) == (pytest.approx(-1.5), pytest.approx(0.5))


def test_what_has_no_logarithm_is_left_out_of_a_slope():
    found = estimates.slope([1, 2, 4], [[1, -1, 1 / 4], [1, 1, 1 / 4]])
    assert found.value == pytest.approx(-1)
    assert estimates.slope([1, 2, 4], [[1, 0, 0], [1, 1, 0]]) is None
    assert estimates.slope([2, 2], [[1, 2], [2, 1]]) is None


def law(seconds):
    return 0.5 * np.asarray(seconds, float) ** -1.25


def test_a_level_within_the_measured_range_is_interpolated():
    seconds = [1, 2, 4, 8]
    found = estimates.time_to(0.1, seconds, law(seconds), None)
    assert found == {"seconds": pytest.approx(5**0.8), "how": "measured"}


def test_a_level_beyond_it_is_extrapolated_and_says_so():
    seconds = [1, 2, 4, 8]
    fitted = estimates.slope(seconds, [law(seconds)] * 2)
    found = estimates.time_to(1e-3, seconds, law(seconds), fitted)
    assert found == {"seconds": pytest.approx(500**0.8), "how": "extrapolated"}
    assert estimates.time_to(1e-3, seconds, law(seconds), None) is None
    assert estimates.time_to(1e-3, seconds, [0.1] * 4, estimates.Slope(-0.01, 0.0)) is None


def test_a_level_before_the_first_checkpoint_is_only_bounded():
    assert estimates.time_to(0.9, [1, 2], [0.5, 0.2], None) == {"seconds": 1, "how": "within"}
    assert estimates.time_to(0.1, [1, 2], [0.5, 0.0], None) == {"seconds": 2, "how": "within"}


def test_a_level_that_no_time_reaches_is_out_of_reach():
    assert estimates.time_to(1e-3, [1, 2], [1e50, 0.9e50], estimates.Slope(-0.11, 0.01)) is None
    assert estimates.time_to(1e-3, [1, 2], [1e20, 0.9e20], estimates.Slope(-0.11, 0.01))["seconds"] < 1e300
