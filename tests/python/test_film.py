"""The film's bits depend on the samples alone: not on the order of arrival, the tiles, or a stop in
between."""

import io
import math
import random

import numpy as np
import pytest
from chunks import chunk_sums, draw, exposed, normal
from hypothesis import given, settings
from hypothesis import strategies as st

from tilecast.render.film import Film
from tilecast.render.plan import Chunk, make_plan

sizes = st.tuples(st.integers(1, 24), st.integers(1, 24), st.integers(1, 40))  # pixels, pixels, samples
tile_sizes = st.integers(4, 32)


@given(sizes, tile_sizes, st.randoms(use_true_random=False))
def test_the_order_of_arrival_changes_nothing(size, tile_size, shuffler):
    plan = make_plan(*size, tile_size)
    image = draw(plan, normal)
    first = exposed(plan, image)
    chunks = list(plan.chunks())
    shuffler.shuffle(chunks)
    second = exposed(plan, image, chunks)
    assert np.array_equal(first.pixels(), second.pixels())
    for tile in plan.tiles:
        assert first.save_tile(tile) == second.save_tile(tile)
    if plan.checkpoints:
        assert first.error(len(plan.checkpoints) - 1) == second.error(len(plan.checkpoints) - 1)


@given(sizes, tile_sizes, tile_sizes)
def test_the_tile_size_changes_no_pixel(size, one, other):
    plans = [make_plan(*size, tile_size) for tile_size in (one, other)]
    image = draw(plans[0], normal)
    assert np.array_equal(exposed(plans[0], image).pixels(), exposed(plans[1], image).pixels())


def test_the_pixels_are_the_mean_of_the_samples():
    plan = make_plan(20, 10, 37, 8)
    image = draw(plan, normal)
    film = exposed(plan, image)
    assert film.pixels().dtype == np.float32
    assert np.allclose(film.pixels(), image.mean(axis=0), rtol=1e-6)
    assert film.samples == 20 * 10 * 37


def test_what_has_no_sample_yet_is_black_and_grows_by_range():
    plan = make_plan(8, 4, 8, 4)
    left, right = plan.tiles
    image = draw(plan, normal)
    film = Film(plan)
    first, second = [Chunk(left, index, *plan.ranges[index]) for index in (0, 1)]
    assert not film.add(second, chunk_sums(image, second))  # kept aside: the first is not there
    assert film.tile_version(left) == 0 and not film.pixels().any()
    assert film.add(first, chunk_sums(image, first))
    assert (film.tile_version(left), film.tile_samples(left), film.tile_samples(right)) == (2, 4, 0)
    assert np.allclose(film.tile_pixels(left), image[:4, :, :4].mean(axis=0), rtol=1e-6)
    assert not film.tile_pixels(right).any()
    assert np.array_equal(film.pixels()[:, :4], film.tile_pixels(left))


def test_a_chunk_that_comes_twice_counts_once():
    plan = make_plan(4, 4, 8, 4)
    image = draw(plan, normal)
    chunks = list(plan.chunks())
    twice = exposed(plan, image, [*chunks, *chunks, chunks[1]])
    assert np.array_equal(twice.pixels(), exposed(plan, image).pixels())
    assert twice.samples == 4 * 4 * 8


@settings(max_examples=40)
@given(sizes, tile_sizes, st.integers(0, 10**6))
def test_a_tile_comes_back_from_its_bytes(size, tile_size, seed):
    plan = make_plan(*size, tile_size)
    image = draw(plan, normal)
    chunks = list(plan.chunks())
    film = Film(plan)
    for chunk in random.Random(seed).sample(chunks, len(chunks) // 2):
        film.add(chunk, chunk_sums(image, chunk), (1, 2, 3), 0.25)
    again = Film(plan)
    for tile in plan.tiles:
        if film.tile_version(tile):
            again.load_tile(tile, film.save_tile(tile))
    assert np.array_equal(film.pixels(), again.pixels())
    assert (film.samples, film.rays, film.seconds) == (again.samples, again.rays, again.seconds)
    for chunk in chunks:  # both go on to the same end; what is there already counts once
        for one in (film, again):
            one.add(chunk, chunk_sums(image, chunk), (1, 2, 3), 0.25)
    assert film.checkpoints_done == again.checkpoints_done == len(plan.checkpoints)
    whole = exposed(plan, image)
    assert np.array_equal(whole.pixels(), again.pixels()) and np.array_equal(whole.pixels(), film.pixels())
    assert [film.error(at) for at in range(len(plan.checkpoints))] == \
        [whole.error(at) for at in range(len(plan.checkpoints))] == \
        [again.error(at) for at in range(len(plan.checkpoints))]


def test_sums_of_many_chunks_do_not_stall_and_go_on_after_a_stop():
    plan = make_plan(1, 1, 1024 * 2000, 1)
    [tile] = plan.tiles
    film, stored, values = Film(plan), Film(plan), []
    for chunk in plan.chunks():
        values.append(0.7 * chunk.count)
        film.add(chunk, np.full((2, 1, 1, 3), values[-1]))
        if chunk.range == 1000:
            stored.load_tile(tile, film.save_tile(tile))
        elif chunk.range > 1000:
            stored.add(chunk, np.full((2, 1, 1, 3), values[-1]))
    sums = np.load(io.BytesIO(film.save_tile(tile)))["sums"]
    assert abs(sum(values) / math.fsum(values) - 1) > 1e-14  # one after the other they drift away
    assert (abs(sums / math.fsum(values) - 1) < 4e-16).all()
    assert film.save_tile(tile) == stored.save_tile(tile)


def test_a_short_range_behind_many_samples_does_not_look_like_rare_events():
    """Parts as unequal as 128 and 16 samples would: 16 of a skewed distribution have a longer tail, and the share that is
    not found again is 0.14 larger."""
    def tail_shares(seed):
        plan, generator, shares, first = make_plan(128, 128, 4096, 128), np.random.default_rng(seed), {}, 0
        film, [tile] = Film(plan, closely=True), plan.tiles
        for index, end in enumerate((2, 4, 8, 16, 32, 64, 128, 144, 160, 192, 256)):
            samples = generator.lognormal(0, 1.5, (2, (end - first) // 2, 128, 128, 1)).sum(1)
            film.add(Chunk(tile, index, first, end - first), np.broadcast_to(samples, (2, 128, 128, 3)))
            again = Film(plan, closely=True)
            again.load_tile(tile, film.save_tile(tile))
            shares[end], first = film.error_after([index + 1]).tail_share, end
            assert again.error_after([index + 1]).tail_share == shares[end]
            film = again
        return [shares[end] for end in (128, 144, 160, 192, 256)]

    shares = np.mean([tail_shares(seed) for seed in range(6)], 0)
    assert abs(shares[1:4] - shares[0]).max() < 0.03 and shares[4] < shares[0]


def test_bytes_of_another_tile_or_plan_and_damaged_ones_are_refused():
    plan = make_plan(8, 4, 8, 4)
    image = draw(plan, normal)
    film = exposed(plan, image)
    data = film.save_tile(plan.tiles[0])
    with pytest.raises(ValueError, match="belongs to another plan or tile"):
        Film(plan).load_tile(plan.tiles[1], data)
    with pytest.raises(ValueError, match="belongs to another plan or tile"):
        Film(make_plan(8, 4, 9, 4)).load_tile(plan.tiles[0], data)
    for broken in (b"", data[:-20], data[:200], data.replace(b"sums.npy", b"sumz.npy")):
        with pytest.raises(ValueError, match="is damaged"):
            Film(plan).load_tile(plan.tiles[0], broken)
    for at in range(0, len(data), 37):  # every flipped byte is found, or falls on one that means nothing
        flipped = bytearray(data)
        flipped[at] ^= 0x55
        fresh = Film(plan)
        try:
            fresh.load_tile(plan.tiles[0], bytes(flipped))
        except ValueError:
            continue
        assert np.array_equal(fresh.tile_pixels(plan.tiles[0]), film.tile_pixels(plan.tiles[0]))
    with pytest.raises(ValueError, match="has samples already"):
        film.load_tile(plan.tiles[0], data)
    with pytest.raises(ValueError, match="no samples to save"):
        Film(plan).save_tile(plan.tiles[0])


def test_sums_of_the_wrong_shape_are_refused():
    plan = make_plan(8, 4, 8, 4)
    with pytest.raises(ValueError, match=r"must be \(2, 4, 4, 3\), got \(2, 3, 4, 3\)"):
        Film(plan).add(next(plan.chunks()), np.zeros((2, 3, 4, 3)))


def test_tiles_may_have_different_samples_in_chunks_of_any_length():
    plan = make_plan(8, 4, 64, 4)
    left, right = plan.tiles
    image = draw(plan, normal)
    film = Film(plan)
    chunks = [Chunk(left, 0, 0, 16), Chunk(left, 1, 16, 6, False), Chunk(left, 2, 22, 10), Chunk(right, 0, 0, 48)]
    for chunk in reversed(chunks):
        film.add(chunk, chunk_sums(image, chunk))
    assert film.samples == 16 * (32 + 48) and film.checkpoints_done == 1
    assert np.allclose(film.pixels()[:, :4], image[:32, :, :4].mean(axis=0), rtol=1e-6)
    assert np.allclose(film.pixels()[:, 4:], image[:48, :, 4:].mean(axis=0), rtol=1e-6)
    halves = [image[:32, :, :4], image[:48, :, 4:]]
    square = [(half[::2].mean(axis=0) - half[1::2].mean(axis=0)) ** 2 / 4 for half in halves]
    assert film.error_after([2, 1]).mse == pytest.approx(np.mean(square))
    assert np.allclose(film.variance(), np.concatenate(square, axis=1), rtol=1e-5)
    assert (film.sample_counts() == [[32] * 4 + [48] * 4] * 4).all()
    with pytest.raises(ValueError, match="must begin at sample 32, got 48"):
        film.add(Chunk(left, 3, 48, 2), np.zeros((2, 4, 4, 3)))


def test_a_reader_sees_whole_states_while_the_film_grows():
    plan = make_plan(4, 4, 16, 4)
    image = draw(plan, normal)
    film = Film(plan)
    chunks = list(plan.chunks())
    film.add(chunks[0], chunk_sums(image, chunks[0]))
    state = film._tiles[0]
    before = state.sums.copy()
    for chunk in chunks[1:]:
        film.add(chunk, chunk_sums(image, chunk))
    assert np.array_equal(state.sums, before)  # replaced, not changed


def rare_events(plan, seed):
    """The sums of each chunk: light of 1 with a little noise, and three events of 3000 in a million samples."""
    generator = np.random.default_rng(seed)
    for chunk in plan.chunks():
        part, shape = chunk.count // 2, (2, plan.height, plan.width, 1)
        sums = part + generator.normal(0, 0.3 * math.sqrt(part), shape) + 3000 * generator.binomial(part, 3e-6, shape)
        yield chunk, np.broadcast_to(sums, (*shape[:3], 3))


def test_many_samples_are_compared_in_halves_and_no_longer_look_heavy_tailed():
    """At 2^15 samples a pixel has met 0.1 events: the last 1024 alone would call it heavy-tailed, and 95% of intervals
    hold the true error where the halves tell them."""
    plan = make_plan(64, 64, 2**15, 64)
    inside, truth = 0, 1 + 3e-6 * 3000
    for seed in range(8):
        film = Film(plan)
        for chunk, sums in rare_events(plan, seed):
            film.add(chunk, sums)
        error = film.error(len(plan.checkpoints) - 1)
        assert error.heavy_tailed is False and error.tail_share < 0.35
        inside += error.mse_low <= ((film.pixels().astype(float) - truth) ** 2).mean() <= error.mse_high
    assert inside >= 6


def test_what_many_samples_are_compared_with_goes_on_after_a_stop():
    plan = make_plan(8, 8, 5000, 8)
    [tile] = plan.tiles
    film = Film(plan)
    for chunk, sums in rare_events(plan, 0):
        again = Film(plan)
        if film.tile_version(tile):
            again.load_tile(tile, film.save_tile(tile))
        for one in (film, again):
            one.add(chunk, sums)
        assert film.save_tile(tile) == again.save_tile(tile)
