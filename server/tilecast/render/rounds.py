"""Which chunks an image is made of, round by round.

Without a goal for the error and without adaptive sampling there is one round, and the whole plan is in it. Otherwise
the first round is a pilot of 16 samples: so few have often not met the light at all, and nothing is decided on less.
What comes next is decided when every tile has reached the end of a round, from the film alone. The same decisions
follow after a restart, from the tiles that were stored; and the image depends on nobody's speed.

A goal for the error ends an image when its estimate lies below it. Where few pixels make the estimate unsure, it must
lie so far below that the upper end of its interval is at most half as much again as the goal. And nothing ends while
the image is labelled heavy-tailed (see `tails`): its estimate rests on a few rare events, and says too little most of
the time. Such an image goes on, with as many samples again each round, until the label is gone or the samples or seconds
that it may take are used up. An image without any noise may have met none of its light yet: where its paths go on from
what the camera sees, it takes a longer pilot. Only a goal of 1 or more it meets at once, since light that is missed makes
no error larger than that: (I - R)^2 < R^2 + 0.01 where 0 <= I <= R.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import takewhile
from typing import Any

import numpy as np

from .allocation import allocate, level_above, most_of, next_mean
from .error import NOISELESS, ErrorEstimate
from .film import Film
from .plan import MOST_IN_RANGE, Chunk, Tile

PILOT = 16  # samples
_LONG_PILOT = 1024  # of an image without noise
_KNOWN = 60  # samples after which tiles know their own noise, where no rare events carry it: a round to 64 ends short of it
_DOUBT = 1.5  # times the goal: what the upper end of the interval may be
_ALL = 63 / 64  # of the samples that tiles may share: what is left is less than a level for most of them


def reckoned(point: Mapping[str, Any]) -> float:
    """The relative MSE that decides whether an image has reached its goal, from a point of its error curve."""
    return max(point["relative_mse"], point["high"] / _DOUBT)


class Rounds:
    """`target`: the relative MSE at which the image is good enough. `adaptive`: whether tiles get different numbers of
    samples; the plan's are their mean over the image then."""

    def __init__(self, film: Film, target: float | None, adaptive: bool):
        self.film = film
        self.ended = False
        """No round comes after this one."""
        self._target = target
        self._adaptive = adaptive
        self._plan = plan = film.plan
        ranges = plan.ranges
        if target is not None or adaptive:
            ranges = tuple((first, count) for first, count in ranges if first < PILOT)
        self._goals = [sum(ranges[-1])] * len(plan.tiles)  # samples of each tile at the end of the round
        self._chunks = [len(ranges)] * len(plan.tiles)  # of each tile by then
        self._first = sum(index < len(ranges) for index in plan.checkpoints)  # checkpoints in the first round
        self._rows = [self._first] * len(plan.tiles)  # checkpoints of each tile by the end of this round
        self._begin(takewhile(lambda chunk: chunk.range < len(ranges), plan.chunks()))

    def _begin(self, chunks: Iterator[Chunk]) -> None:
        """A round with these chunks."""
        self._upcoming = chunks
        self._short = {tile.index for tile in self._plan.tiles if self._is_short(tile.index)}

    def _is_short(self, index: int) -> bool:
        return self.film.tile_samples(self._plan.tiles[index]) < self._goals[index]

    def next(self) -> Chunk | None:
        """The next chunk of the round that the film does not have; None where all are handed out."""
        return next((chunk for chunk in self._upcoming if chunk.range >= self.film.tile_version(chunk.tile)), None)

    def arrived(self, tile: Tile) -> None:
        """The film has more of this tile."""
        if not self._is_short(tile.index):
            self._short.discard(tile.index)

    @property
    def complete(self) -> bool:
        """Whether every tile has reached the end of the round."""
        return not self._short

    @property
    def mean(self) -> float:
        """Samples of a pixel at the end of the round, on average."""
        mean = self._samples() / (self._plan.width * self._plan.height)
        return int(mean) if mean == int(mean) else mean

    def _samples(self) -> int:
        """Of the whole image at the end of the round."""
        return sum(goal * tile.pixels for goal, tile in zip(self._goals, self._plan.tiles))

    def points(self, drawn: int) -> Iterator[tuple[float, ErrorEstimate]]:
        """The points of the error curve from the number `drawn` on that this round, or its beginning, has reached:
        samples of a pixel on average, and the estimate."""
        for at in range(drawn, min(self.film.checkpoints_done, self._first)):
            yield self._plan.samples_after(self._plan.checkpoints[at] + 1), self.film.error(at)
        if self.complete and max(self._rows) > self._first:
            yield self.mean, self.film.error_after(self._rows)

    def go_on(self, point: Mapping[str, Any] | None) -> None:
        """Begins the next round, or ends. To be called when the round is complete; `point`: the last of the error
        curve."""
        most, done = self._plan.samples, self.mean
        short = reckoned(point) / self._target if self._target is not None and point else None
        unsure = point is not None and (point["heavy_tailed"] is True or self._may_have_met_nothing(point))
        enough = short is not None and short <= 1 and done >= PILOT and not unsure
        if enough or done >= (most * _ALL if self._adaptive else most):
            self.ended = True
            return
        known = done >= _KNOWN and point is not None and point["heavy_tailed"] is False
        goals = self._next_goals(done, None if unsure else short, known)
        if goals == self._goals:  # what is left is less than a level of any tile
            self.ended = True
            return
        before, self._goals = self._goals, goals
        self._rows = [rows + (goal > done) for rows, goal, done in zip(self._rows, goals, before)]
        self._begin(iter(self._new_chunks(before)))

    def _may_have_met_nothing(self, point: Mapping[str, Any]) -> bool:
        if self._target is None or self._target >= 1 or point["relative_mse"] > NOISELESS or self.mean >= _LONG_PILOT:
            return False
        return self.film.rays_after(self._rows).sum() > self._samples()  # more than those of the camera

    def _next_goals(self, before: float, short: float | None, known: bool) -> list[int]:
        """The samples of each tile at the end of the next round, from their mean `before` it; `short`: how many times too
        large the error is."""
        plan = self._plan
        if not self._adaptive:
            return [next_mean(before, plan.samples, short)] * len(plan.tiles)
        shape = plan.rows, plan.columns
        pixels = np.array([tile.pixels for tile in plan.tiles]).reshape(shape)
        done = np.array(self._goals).reshape(shape)
        noise = self.film.relative_sums(self._rows).reshape(shape) * done
        cost = np.maximum(self.film.rays_after(self._rows).reshape(shape) / (pixels * done), 1) ** 2
        enough = (noise / done).sum() / most_of(short) if short is not None else 0.0
        goals = allocate(noise, cost, pixels, done, next_mean(before, plan.samples, None), plan.samples, known, enough)
        mean = min(math.floor(before * 65 / 64) + 1, plan.samples)  # at least
        if (goals * pixels).sum() < mean * pixels.sum():
            goals = allocate(noise, cost, pixels, done, mean, plan.samples, known)
        while (goals == done).all() and mean < plan.samples:  # few tiles: the mean falls between their levels
            mean = min(level_above(mean), plan.samples)
            goals = allocate(noise, cost, pixels, done, mean, plan.samples, known)
        return goals.ravel().tolist()

    def _new_chunks(self, before: list[int]) -> list[Chunk]:
        """From the samples of each tile `before` to the goals."""
        found = []
        for tile in self._plan.order:
            first, goal = before[tile.index], self._goals[tile.index]
            while first < goal:
                count = min(MOST_IN_RANGE, goal - first)
                found.append(Chunk(tile, self._chunks[tile.index], first, count, first + count == goal))
                self._chunks[tile.index] += 1
                first += count
        return found
