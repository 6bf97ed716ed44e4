"""One image in the making: what is handed out, what stops it, what a restart takes up."""

import json

import numpy as np
import pytest
from chunks import draw, exposed, normal, result
from hypothesis import given, settings
from hypothesis import strategies as st

from tilecast.render.film import Film
from tilecast.render.plan import make_plan
from tilecast.render.rendering import ChunkResult, Rendering
from tilecast.scene.schema import Stop

CONTRACT = {"seconds", "samples", "rays", "rays_per_second", "error", "curve"}  # what is left comes from the scene


LONGEST = make_plan(12, 12, 16 * 70, 5)  # as many samples as one tile may get


def uneven(generator, shape):
    """Noise in the upper left corner above all."""
    corner = np.add.outer(np.arange(12), np.arange(12)) < 9
    return 0.5 + generator.normal(0, 0.05, shape) * np.where(corner, 9, 1)[..., None]


class Clock:
    """Time that goes by when a chunk is rendered."""

    def __init__(self):
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def finish(rendering, image, in_flight=1, shuffler=None, clock=None, step=1.0):
    """Renders to the end with so many chunks in flight, results in any order; the events."""
    flying, events = [], []
    while True:
        while len(flying) < in_flight and (chunk := rendering.next_chunk()):
            flying.append(chunk)
        if not flying:
            assert rendering.finished
            return events
        chunk = flying.pop(shuffler.randrange(len(flying)) if shuffler else 0)
        if clock:
            clock.now += step
        events += rendering.add(chunk, result(image, chunk))


def test_an_image_is_rendered_to_its_last_sample():
    plan = make_plan(20, 12, 21, 8)
    image = draw(plan, normal)
    clock = Clock()
    rendering = Rendering(plan, clock=clock)
    assert not rendering.finished and rendering.progress == 0 and rendering.seconds_left is None
    events = finish(rendering, image, clock=clock)
    chunks = len(plan.tiles) * len(plan.ranges)
    assert rendering.finished and rendering.progress == 1 and rendering.seconds_left == 0
    assert rendering.seconds == chunks
    assert np.array_equal(rendering.film.pixels(), exposed(plan, image).pixels())
    tiles = [event for event in events if event["type"] == "tile"]
    assert len(tiles) == chunks
    assert tiles[-1]["samples"] == 21 and tiles[-1]["version"] == len(plan.ranges)
    assert set(tiles[0]) == {"type", "column", "row", "x", "y", "width", "height", "version", "samples",
                              "relative_mse"}
    assert np.mean([tile["relative_mse"] for tile in tiles[-len(plan.tiles):]]) > 0
    errors = [event for event in events if event["type"] == "error"]
    assert [event["samples"] for event in errors] == [2, 4, 8, 16, 21]
    assert {"seconds", "samples", "mse", "relative_mse", "low", "high"} <= set(errors[0])
    assert rendering.next_chunk() is None


@settings(max_examples=30)
@given(st.integers(1, 9), st.randoms(use_true_random=False), st.sampled_from([None, 0.02, 0.005, 1e-9]), st.booleans())
def test_the_image_and_its_curve_depend_on_no_order(in_flight, shuffler, target, adaptive):
    plan = make_plan(12, 12, 70, 5)
    image = draw(LONGEST, uneven) if adaptive else draw(plan, normal)
    stop = Stop(relative_mse=target)
    one, other = (Rendering(plan, stop, adaptive=adaptive) for _ in range(2))
    finish(one, image)
    finish(other, image, in_flight, shuffler)
    assert np.array_equal(one.film.pixels(), other.film.pixels())
    assert [{**point, "seconds": 0} for point in one.curve] == [{**point, "seconds": 0} for point in other.curve]


def test_an_image_stops_at_the_checkpoint_where_its_error_is_small_enough():
    plan = make_plan(16, 16, 1024, 8)
    image = draw(plan, normal)
    free = Rendering(plan)
    finish(free, image)
    target = free.curve[5]["relative_mse"] * 1.0001  # reached at 64 samples, or a little before
    assert all(point["relative_mse"] > target for point in free.curve[:5])
    rendering = Rendering(plan, Stop(relative_mse=target))
    finish(rendering, image, in_flight=6)
    assert rendering.finished and rendering.progress == 1
    samples = rendering.curve[-1]["samples"]
    assert 32 < samples <= 64 and samples % 4 == 0
    assert {rendering.film.tile_samples(tile) for tile in plan.tiles} == {samples}
    assert all(point["relative_mse"] > target for point in rendering.curve[:-1])
    assert rendering.curve[-1]["relative_mse"] <= target
    assert {2, 4, 8, 16, 32} <= {point["samples"] for point in rendering.curve}
    assert np.allclose(rendering.film.pixels(), image[:samples].mean(axis=0), rtol=1e-6)


@pytest.mark.parametrize("factor", [1.03, 1.3, 1.7, 2.9])
def test_the_error_reached_is_near_the_target(factor):
    """Normal noise: its error is that of 1 / samples. Levels lie an eighth of a power of two apart or less, and 64 x 64
    pixels of three channels scatter by sqrt(2 / 12288) = 0.013, and so does the estimate."""
    plan = make_plan(64, 64, 2048, 32)
    image = draw(plan, normal)
    goal = 0.25**2 / (0.5**2 + 0.01) / (64 * factor)
    rendering = Rendering(plan, Stop(relative_mse=goal))
    finish(rendering, image)
    square = (rendering.film.pixels().astype(float) - 0.5) ** 2 / 0.26
    assert 0.83 * goal < square.mean() < 1.05 * goal


def test_few_pixels_must_be_surer():
    """The interval of 16 grey pixels reaches to e^(1.96 * 2 / 4) = 2.7 times the estimate: that must be a little more than
    half the goal."""
    plan = make_plan(4, 4, 4096, 4)
    image = np.broadcast_to(0.5 + 0.25 * np.random.default_rng(0).standard_normal((4096, 4, 4, 1)), (4096, 4, 4, 3))
    goal = 0.25**2 / 0.26 / 128
    rendering = Rendering(plan, Stop(relative_mse=goal))
    finish(rendering, image)
    assert rendering.curve[-1]["high"] <= 1.5 * goal and rendering.curve[-1]["samples"] < 4096
    assert all(point["high"] > 1.5 * goal or point["relative_mse"] > goal for point in rendering.curve[:-1])
    assert rendering.curve[-1]["relative_mse"] < 0.9 * goal


def test_an_image_whose_error_rests_on_rare_events_is_not_taken_for_good_enough():
    """One sample in 2^14 is bright: a low estimate only says that few of them have been met. Without a goal out of
    reach, the image ends with the samples that it may have."""
    plan = make_plan(32, 32, 256, 16)
    generator = np.random.default_rng(3)
    image = 0.5 + 0.01 * generator.standard_normal((256, 32, 32, 3))
    image += 50 * (generator.random((256, 32, 32, 1)) < 2**-14)
    rendering = Rendering(plan, Stop(relative_mse=1.0))
    finish(rendering, image)
    assert all(point["heavy_tailed"] and point["high"] < 1.0 for point in rendering.curve[3:])
    assert [point["samples"] for point in rendering.curve] == [2, 4, 8, 16, 32, 64, 128, 256]


def test_nothing_stops_before_the_pilot():
    plan = make_plan(16, 16, 1024, 8)
    black = np.zeros((1024, 16, 16, 3))  # nobody has met the light
    rendering = Rendering(plan, Stop(relative_mse=1e6))
    finish(rendering, black)
    assert {rendering.film.tile_samples(tile) for tile in plan.tiles} == {16}


@pytest.mark.parametrize("settings", [{"stop": Stop(relative_mse=1.0)}, {"adaptive": True}])
def test_nothing_is_rendered_ahead_of_a_decision(settings):
    plan = make_plan(16, 16, 1024, 8)
    rendering = Rendering(plan, **settings)
    handed_out = []
    while (chunk := rendering.next_chunk()) is not None:
        handed_out.append(chunk)
    # The first decision is at 16 samples, after range 3.
    assert max(chunk.range for chunk in handed_out) == 3
    assert len(handed_out) == 4 * len(plan.tiles)


def test_time_stops_new_chunks_but_not_the_first_of_each_pixel():
    plan = make_plan(16, 16, 1024, 8)
    image = draw(plan, normal)
    for seconds, expected in ((1.0, {2}), (7.0, {4, 2})):
        clock = Clock()
        rendering = Rendering(plan, Stop(seconds=seconds), clock)
        finish(rendering, image, clock=clock)
        assert {rendering.film.tile_samples(tile) for tile in plan.tiles} == expected
        assert rendering.finished


@pytest.mark.parametrize("adaptive", [False, True])
def test_what_is_done_when_the_time_is_up_is_kept_in_spite_of_an_open_decision(adaptive):
    plan = make_plan(16, 8, 1024, 8)  # two tiles
    image = draw(plan, normal)
    clock = Clock()
    rendering = Rendering(plan, Stop(seconds=10.0, relative_mse=1e-9), clock, adaptive)
    chunks = {}
    while (chunk := rendering.next_chunk()) is not None:
        chunks[chunk.tile.index, chunk.range] = chunk
    for index in range(4):  # one tile as far as the pilot goes
        rendering.add(chunks[0, index], result(image, chunks[0, index]))
    clock.now += 20
    for index in range(4):
        rendering.add(chunks[1, index], result(image, chunks[1, index]))
    assert rendering.next_chunk() is None and rendering.finished
    assert [rendering.film.tile_samples(tile) for tile in plan.tiles] == [16, 16]


def test_time_that_is_paused_does_not_count():
    plan = make_plan(8, 8, 1024, 8)
    image = draw(plan, normal)
    clock = Clock()
    rendering = Rendering(plan, clock=clock)
    chunk = rendering.next_chunk()
    clock.now += 2
    rendering.add(chunk, result(image, chunk))
    clock.now += 1000
    assert rendering.seconds == 2
    chunk = rendering.next_chunk()
    clock.now += 3
    assert rendering.seconds == 5
    rendering.give_back(chunk)
    clock.now += 1000
    assert rendering.seconds == 5


def test_a_chunk_given_back_is_handed_out_again():
    plan = make_plan(16, 8, 8, 8)
    rendering = Rendering(plan)
    first, second = rendering.next_chunk(), rendering.next_chunk()
    rendering.give_back(first)
    rendering.give_back(first)
    assert not rendering.finished
    assert rendering.next_chunk() is first
    image = draw(plan, normal)
    rendering.add(first, result(image, first))
    rendering.give_back(second)
    finish(rendering, image)
    assert np.array_equal(rendering.film.pixels(), exposed(plan, image).pixels())


@settings(max_examples=40)
@given(st.randoms(use_true_random=False), st.sampled_from([None, 0.004]), st.booleans(), st.integers(1, 90))
def test_after_a_kill_at_any_point_the_same_image_comes(shuffler, target, adaptive, chunks):
    plan = make_plan(12, 12, 70, 5)
    image = draw(LONGEST, uneven) if adaptive else draw(plan, normal)
    stop = Stop(relative_mse=target)
    whole = Rendering(plan, stop, adaptive=adaptive)
    finish(whole, image)

    killed = Rendering(plan, stop, adaptive=adaptive)
    stored, events, flying = {}, [], []
    for _ in range(chunks):
        while len(flying) < 4 and (chunk := killed.next_chunk()):
            flying.append(chunk)
        if not flying:
            break
        chunk = flying.pop(shuffler.randrange(len(flying)))
        for event in killed.add(chunk, result(image, chunk)):
            events.append(event)
            if event["type"] == "tile":
                tile = plan.tiles[event["row"] * plan.columns + event["column"]]
                stored[tile.index] = killed.film.save_tile(tile)
    points = [event for event in events if event["type"] == "error"]

    again = Rendering(plan, stop, adaptive=adaptive)
    # The last point may be lost, if the kill fell between tile and point; a tile may be damaged.
    new = again.restore(stored, killed.seconds, points[:len(points) - shuffler.randrange(2)])
    assert all(event["type"] == "error" for event in new)
    finish(again, image, 3, shuffler)
    assert np.array_equal(again.film.pixels(), whole.film.pixels())
    assert [point["samples"] for point in again.curve] == [point["samples"] for point in whole.curve]
    assert [point["high"] for point in again.curve] == [point["high"] for point in whole.curve]


def test_a_damaged_tile_is_rendered_again(caplog):
    plan = make_plan(16, 8, 8, 8)
    image = draw(plan, normal)
    whole = Rendering(plan)
    finish(whole, image)
    stored = {tile.index: whole.film.save_tile(tile) for tile in plan.tiles}
    stored[1] = stored[1][:-50]
    again = Rendering(plan)
    again.restore(stored, 5.0, whole.curve)
    assert "is damaged" in caplog.text and "rendered again" in caplog.text
    assert not again.finished
    assert finish(again, image)
    assert np.array_equal(again.film.pixels(), whole.film.pixels())


def test_the_statistics_hold_the_contract():
    plan = make_plan(20, 12, 21, 8)
    clock = Clock()
    rendering = Rendering(plan, clock=clock)
    empty = rendering.statistics()
    assert CONTRACT <= set(empty) and empty["error"]["relative_mse"] is None
    finish(rendering, draw(plan, normal), clock=clock)
    stats = rendering.statistics({"seconds": {"load": 1.0, "compile": 2.0}, "kernel": "path"}, write=3.0)
    assert CONTRACT <= set(stats)
    chunks = len(plan.tiles) * len(plan.ranges)
    assert stats["seconds"] == {"load": 1.0, "compile": 2.0, "render": chunks, "write": 3.0, "work": 0.5 * chunks}
    camera = 20 * 12 * 21
    assert stats["rays"] == {"camera": camera, "bounce": 2 * camera, "shadow": 3 * camera}
    assert stats["rays_per_second"] == 6 * camera / chunks
    assert stats["samples"] == 21 and stats["kernel"] == "path"
    assert set(stats["error"]) >= {"mse", "relative_mse", "low", "high"}
    assert set(stats["curve"][0]) >= {"seconds", "samples", "relative_mse", "low", "high"}
    assert stats["error"]["low"] == stats["curve"][-1]["low"]
    json.dumps(stats, allow_nan=False)


def test_the_time_left_is_foreseen():
    plan = make_plan(16, 16, 1024, 8)
    image = draw(plan, normal)
    for stop, samples in ((None, 1024), (Stop(seconds=20.0), None)):
        clock = Clock()
        rendering = Rendering(plan, stop, clock)
        while rendering.seconds < 10:
            chunk = rendering.next_chunk()
            clock.now += chunk.count / 8
            rendering.add(chunk, result(image, chunk))
        assert 0 < rendering.progress < 1
        if stop:
            assert rendering.seconds_left == pytest.approx(20 - rendering.seconds)
        else:
            assert rendering.seconds_left == pytest.approx(4 * 1024 / 8 - rendering.seconds)
    free = Rendering(plan)
    finish(free, image)
    # The error is a quarter at four times the samples: at 64 samples, the end is foreseen at 256 / 1.3.
    rendering = Rendering(plan, Stop(relative_mse=free.curve[7]["relative_mse"] * 1.3))
    while len(rendering.curve) < 6:
        chunk = rendering.next_chunk()
        rendering.add(chunk, result(image, chunk))
    assert rendering.progress == pytest.approx(1.3 * 64 / 256, abs=0.1)


def test_a_film_of_the_plan_stands_behind_it():
    plan = make_plan(8, 8, 4)
    assert isinstance(Rendering(plan).film, Film) and Rendering(plan).plan is plan


def test_an_image_without_noise_may_have_met_nothing_yet_and_meets_no_goal_at_once():
    """One pixel meets light that is rare, after 40 samples; the others have all met what there is."""
    plan = make_plan(16, 16, 4096, 8)
    image = draw(plan, lambda generator, shape: np.full(shape, 0.5))
    image[40:, 3, 3] += 30 * (np.random.default_rng(1).random((4056, 1)) < 0.01)
    rendering = Rendering(plan, Stop(relative_mse=0.005))
    finish(rendering, image)
    first = [point for point in rendering.curve if point["samples"] <= 32]
    assert len(first) == 5 and all(point["relative_mse"] == 0 for point in first)
    assert all(point["heavy_tailed"] is None and point["tail_share"] is None for point in first)
    assert rendering.curve[-1]["samples"] > 64 and rendering.curve[-1]["relative_mse"] > 0
    for goal, samples in ((1.0, 16), (1e-3, 1024)):  # what is missed makes no relative error of 1
        rendering = Rendering(plan, Stop(relative_mse=goal))
        finish(rendering, np.full((4096, 16, 16, 3), 0.1))
        assert rendering.curve[-1]["samples"] == rendering.film.tile_samples(plan.tiles[0]) == samples


def test_what_only_the_camera_sees_has_no_light_to_miss():
    plan = make_plan(16, 16, 4096, 8)
    rendering = Rendering(plan, Stop(relative_mse=1e-3))
    while (chunk := rendering.next_chunk()) is not None:
        pixels = chunk.tile.width * chunk.tile.height * chunk.count
        sums = np.full((2, chunk.tile.height, chunk.tile.width, 3), 0.3 * chunk.count)
        rendering.add(chunk, ChunkResult(sums, (pixels, 0, 0), 0.0))
    assert rendering.finished and rendering.curve[-1]["samples"] == 16


@pytest.mark.parametrize("adaptive, seconds", [(False, 7.5), (False, 22.0), (False, 42.1), (True, 30.0)])
def test_an_image_whose_time_is_up_tells_its_own_error(adaptive, seconds):
    """Chunks of 1 second on 4 tiles; some tiles then have more samples than others, or more than at their last
    checkpoint. The true error of 64 x 64 pixels scatters by sqrt(2 / 12288) = 1.3%."""
    plan = make_plan(64, 64, 4096 if adaptive else 5000, 32)
    clock, generator = Clock(), np.random.default_rng(5)

    def ended(rendering):
        while (chunk := rendering.next_chunk()) is not None:
            clock.now += 1 if chunk.first < 1024 or adaptive else 0.25
            part, shape = chunk.count // 2, (2, chunk.tile.height, chunk.tile.width, 3)
            sums = 0.5 * part + 0.25 * np.sqrt(part) * generator.standard_normal(shape)
            rendering.add(chunk, ChunkResult(sums, (0, 0, 0), 0.0))
        assert rendering.finished
        return rendering

    rendering = ended(Rendering(plan, Stop(seconds=seconds), clock, adaptive))
    stats = rendering.statistics()
    true = ((rendering.film.pixels().astype(float) - 0.5) ** 2).mean()
    assert stats["samples"] == stats["curve"][-1]["samples"] and stats["error"]["mse"] == stats["curve"][-1]["mse"]
    assert stats["error"]["mse"] == pytest.approx(true, rel=0.08)
    assert stats["error"]["mse"] == pytest.approx(rendering.film.variance().mean(), rel=1e-5)
    assert stats["error"]["mse_low"] < true < stats["error"]["mse_high"]


def test_the_last_point_of_an_image_whose_time_is_up_comes_once():
    plan = make_plan(16, 16, 1024, 8)
    image = draw(plan, normal)
    clock = Clock()
    rendering = Rendering(plan, Stop(seconds=6.5), clock)
    points = [event for event in finish(rendering, image, clock=clock) if event["type"] == "error"]
    assert [point["samples"] for point in points] == [2, 3.5] == [point["samples"] for point in rendering.curve]
    stored = {tile.index: rendering.film.save_tile(tile) for tile in plan.tiles}
    again = Rendering(plan, Stop(seconds=6.5), clock)
    assert again.restore(stored, rendering.seconds, points) == [] and again.curve == rendering.curve
    lost = Rendering(plan, Stop(seconds=6.5), clock)
    [last] = lost.restore(stored, rendering.seconds, points[:1])
    assert {**last, "seconds": 0} == {**points[1], "seconds": 0}
