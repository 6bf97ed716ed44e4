"""A plan covers the image once, in ranges fixed by the sample count."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tilecast.render.plan import make_plan

plans = st.builds(make_plan, st.integers(1, 60), st.integers(1, 60), st.integers(1, 5000),
                  st.one_of(st.none(), st.integers(3, 70)))


@given(plans)
def test_every_sample_of_every_pixel_is_in_exactly_one_chunk(plan):
    samples = np.zeros((plan.height, plan.width), np.int64)
    ends = {}
    for chunk in plan.chunks():
        tile = chunk.tile
        assert chunk.first == ends.get(tile.index, 0)  # the ranges of a tile come in order, without a gap
        ends[tile.index] = chunk.first + chunk.count
        assert (chunk.first, chunk.count) == plan.ranges[chunk.range]
        part = samples[tile.window]
        assert part.shape == (tile.height, tile.width)
        part += chunk.count
    assert (samples == plan.samples).all()


@given(plans)
def test_tiles_are_numbered_row_by_row_and_ordered_once(plan):
    assert [tile.index for tile in plan.tiles] == list(range(plan.columns * plan.rows))
    assert all(tile.index == tile.row * plan.columns + tile.column for tile in plan.tiles)
    assert sorted(tile.index for tile in plan.order) == list(range(len(plan.tiles)))


@pytest.mark.parametrize("samples, ranges", [
    (1, [(0, 1)]), (2, [(0, 2)]), (3, [(0, 2), (2, 1)]), (16, [(0, 2), (2, 2), (4, 4), (8, 8)]),
    (20, [(0, 2), (2, 2), (4, 4), (8, 8), (16, 4)]),
    (4000, [(0, 2), (2, 2), (4, 4), (8, 8), (16, 16), (32, 32), (64, 64), (128, 128), (256, 256), (512, 512),
            (1024, 1024), (2048, 1024), (3072, 928)])])
def test_ranges_double_up_to_their_limit(samples, ranges):
    assert list(make_plan(8, 8, samples).ranges) == ranges


@given(st.integers(1, 2**24))
def test_ranges_depend_on_the_samples_alone_and_share_their_beginning(samples):
    plan, longer = make_plan(8, 8, samples), make_plan(1000, 10, 2**24, 16)
    assert plan.ranges[:-1] == longer.ranges[:len(plan.ranges) - 1]
    assert all(count <= 1024 for _, count in plan.ranges)
    ends = [plan.samples_after(index + 1) for index in plan.checkpoints]
    assert all(end & (end - 1) == 0 for end in ends[:-1])
    assert ends == [] if samples == 1 else ends[-1] == samples


def test_tiles_go_from_the_centre_outwards():
    order = make_plan(160, 160, 1, 32).order
    assert (order[0].column, order[0].row) == (2, 2)
    assert {(tile.column, tile.row) for tile in order[:9]} == {(x, y) for x in (1, 2, 3) for y in (1, 2, 3)}
    rings = [max(abs(tile.column - 2), abs(tile.row - 2)) for tile in order]
    assert rings == sorted(rings)


@pytest.mark.parametrize("width, height, samples, size", [
    (256, 256, 1024, 32), (640, 480, 64, 64), (4096, 4096, 16, 128), (16384, 16384, 1, 128), (64, 48, 2**24, 16),
    (1, 1, 1, 16)])
def test_tiles_are_as_large_as_a_chunk_of_a_second_allows(width, height, samples, size):
    assert make_plan(width, height, samples).tile_size == size


@pytest.mark.parametrize("arguments", [(0, 1, 1), (1, 0, 1), (1, 1, 0), (1, 1, 1, 0)])
def test_an_image_without_pixels_is_refused(arguments):
    with pytest.raises(ValueError, match="at least one pixel"):
        make_plan(*arguments)
