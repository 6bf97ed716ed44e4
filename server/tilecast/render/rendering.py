"""One image in the making: which chunk comes next, what a result changes, and when it is enough. No threads,
no files: the caller hands in results one at a time, in any order."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ..scene.schema import Stop
from .error import ErrorEstimate
from .film import Film
from .plan import Chunk, Plan, Tile

Event = dict[str, Any]

PILOT = 16  # samples before `relative_mse` may stop an image: so few have often not met the light at all

_log = logging.getLogger(__name__)


@dataclass
class ChunkResult:
    """What a chunk gives: the sums of its samples (float64 [2, h, w, 3], even and odd samples apart), camera,
    bounce and shadow rays traced, and the seconds of work."""
    sums: np.ndarray
    rays: tuple[int, int, int]
    seconds: float


class Rendering:
    """The making of one image after `plan`.

    `stop.relative_mse` ends it at a checkpoint: the first from 16 samples on at which the upper end of the
    error's interval is below the limit. Sums beyond a checkpoint are held back until it is decided, so the
    image is the same however the chunks ran. `stop.seconds` hands out no new chunk after that time; what is
    done is kept, and every pixel has its first samples. Time counts while chunks are in flight: an image that
    is paused does not use up its seconds.
    """

    def __init__(self, plan: Plan, stop: Stop | None = None, clock: Callable[[], float] = time.monotonic):
        self.plan = plan
        self.film = Film(plan)
        self.stop = stop or Stop()
        self.curve: list[dict[str, Any]] = []
        self._stopped = False  # by relative_mse
        self._chunks = iter(plan.chunks())
        self._next: Chunk | None = None  # taken from _chunks, not yet handed out
        self._again: list[Chunk] = []  # given back
        self._in_flight: set[tuple[int, int]] = set()  # (tile, range)
        self._clock = clock
        self._since = 0.0  # when the first of those in flight went out
        self._seconds = 0.0  # before that
        if self.stop.relative_mse is not None:
            self.film.limit = self._limit_after(0)

    # --- Handing out

    def next_chunk(self) -> Chunk | None:
        """The next chunk to render; None where there is nothing to hand out now. There may be again after a
        result."""
        if self._stopped:
            return None
        # A chunk that was given back is not new: without it, what has been done since might never be added.
        chunk = self._again.pop(0) if self._again else self._upcoming()
        if chunk is not None:
            if not self._in_flight:
                self._since = self._clock()
            self._in_flight.add((chunk.tile.index, chunk.range))
        return chunk

    def _upcoming(self) -> Chunk | None:
        while self._next is None or self._next.range < self.film.tile_version(self._next.tile):
            self._next = next(self._chunks, None)
            if self._next is None:
                return None
        if self._next.range > self.film.limit:  # one range ahead of an open decision is enough to keep everyone busy
            return None
        if self._next.range > 0 and self._expired():
            return None
        chunk, self._next = self._next, None
        return chunk

    def give_back(self, chunk: Chunk) -> None:
        """Takes back a chunk that was handed out and has no result; it is handed out again first."""
        if self._landed(chunk):
            self._again.append(chunk)

    def _landed(self, chunk: Chunk) -> bool:
        key = chunk.tile.index, chunk.range
        if key not in self._in_flight:
            return False
        self._in_flight.remove(key)
        if not self._in_flight:
            self._seconds += self._clock() - self._since
        return True

    @property
    def finished(self) -> bool:
        """Whether the image is all that it will be."""
        if self._in_flight or self._again:
            return False
        begun = self.film.tiles_begun == len(self.plan.tiles)
        return self._stopped or (begun and (self._complete() or self._expired()))

    def _complete(self) -> bool:
        return self.film.samples == self.plan.width * self.plan.height * self.plan.samples

    def _expired(self) -> bool:
        return self.stop.seconds is not None and self.seconds >= self.stop.seconds

    # --- Results

    def add(self, chunk: Chunk, result: ChunkResult) -> list[Event]:
        """Takes a result; the events that follow from it: tiles that have changed, points of the error
        curve."""
        self._landed(chunk)
        if self._stopped:
            return []
        events = [self.tile_event(chunk.tile)] if self.film.add(chunk, result.sums, result.rays, result.seconds) else []
        if self._expired():
            events += self._tile_events(self.film.allow(len(self.plan.ranges)))
        return events + self._checkpoints()

    def _checkpoints(self) -> list[Event]:
        """Draws the points of the curve that all tiles have reached, and decides whether to go on."""
        events: list[Event] = []
        while len(self.curve) < self.film.checkpoints_done and not self._stopped:
            at = len(self.curve)
            point = {"seconds": self.seconds, "samples": self._checkpoint_samples(at),
                     **self.film.error(at).to_json()}
            self.curve.append(point)
            events.append({"type": "error", **point})
            events += self._decide()
        return events

    def _decide(self) -> list[Event]:
        """Whether the last point of the curve is enough; the tiles that change where it is not."""
        target, point = self.stop.relative_mse, self.curve[-1]
        if target is None:
            return []
        if point["samples"] >= PILOT and point["high"] <= target and self.film.limit < len(self.plan.ranges):
            self._stopped = True
            self._again.clear()
            self.film.drop_waiting()
            return []
        return self._tile_events(self.film.allow(max(self.film.limit, self._limit_after(len(self.curve)))))

    def _limit_after(self, decided: int) -> int:
        """The ranges that may be added once so many checkpoints are decided: up to the next that could end
        the image."""
        for at in range(decided, len(self.plan.checkpoints)):
            if self._checkpoint_samples(at) >= PILOT:
                return self.plan.checkpoints[at] + 1
        return len(self.plan.ranges)

    def _checkpoint_samples(self, at: int) -> int:
        return self.plan.samples_after(self.plan.checkpoints[at] + 1)

    def tile_event(self, tile: Tile) -> Event:
        """The event that says how a tile stands."""
        return {"type": "tile", "column": tile.column, "row": tile.row, "x": tile.x, "y": tile.y, "width": tile.width,
                "height": tile.height, "version": self.film.tile_version(tile),
                "samples": self.film.tile_samples(tile), "relative_mse": self.film.tile_error(tile)}

    def _tile_events(self, tiles: Iterable[Tile]) -> list[Event]:
        return [self.tile_event(tile) for tile in tiles]

    def restore(self, tiles: Mapping[int, bytes], seconds: float = 0.0,
                curve: Iterable[Mapping[str, Any]] = ()) -> list[Event]:
        """Takes up a rendering from stored tiles (tile index -> `film.save_tile`), the seconds that it had
        used and the points of its curve. To be called before the first chunk is handed out. A stored tile
        that is damaged is rendered again, to the same bits. Returns events of points that the stored curve
        did not have yet."""
        for index, data in tiles.items():
            try:
                self.film.load_tile(self.plan.tiles[index], data)
            except ValueError as problem:
                _log.warning("%s; it is rendered again", problem)
        self._seconds = seconds
        known = {point["samples"]: dict(point) for point in curve}
        for at in range(self.film.checkpoints_done):
            point = known.get(self._checkpoint_samples(at))
            if point is None or self._stopped:
                break
            self.curve.append({key: value for key, value in point.items() if key != "type"})
            self._decide()
        return self._checkpoints()

    # --- How it stands

    @property
    def seconds(self) -> float:
        """Wall time with chunks in flight."""
        return self._seconds + (self._clock() - self._since if self._in_flight else 0.0)

    @property
    def progress(self) -> float:
        """0 to 1: of the samples that are expected to be needed, or of the time that is given, whichever is
        further."""
        if self.finished:
            return 1.0
        done = self._part_of_samples()
        if self.stop.seconds is not None:
            done = max(done, self.seconds / self.stop.seconds)
        return min(done, 1.0)

    @property
    def seconds_left(self) -> float | None:
        """Wall time to the end at the present pace; None before there is a pace."""
        if self.finished:
            return 0.0
        done = self._part_of_samples()
        left = [self.seconds * (1 - done) / done] if done > 0 else []
        if self.stop.seconds is not None:
            left.append(max(self.stop.seconds - self.seconds, 0.0))
        return max(min(left), 0.0) if left else None

    def _part_of_samples(self) -> float:
        needed = self.plan.samples
        if self.stop.relative_mse is not None and self.curve:
            # The error falls as 1 / samples; the stop waits for a checkpoint.
            point = self.curve[-1]
            enough = max(point["samples"] * point["high"] / self.stop.relative_mse, PILOT)
            needed = next((samples for at in range(len(self.curve), len(self.plan.checkpoints))
                           if (samples := self._checkpoint_samples(at)) >= enough), needed)
        return min(self.film.samples / (self.plan.width * self.plan.height * needed), 1.0)

    def statistics(self, facts: Mapping[str, Any] | None = None, write: float = 0.0) -> dict[str, Any]:
        """The statistics of the image as `--stats` writes them. `facts` are those of the scene
        (`Compiled.facts`), `write` the seconds that writing the image took."""
        facts = dict(facts or {})
        pixels = self.plan.width * self.plan.height
        samples = self.film.samples / pixels
        rays, seconds = self.film.rays, self.seconds
        last = self.curve[-1] if self.curve else {}
        return {
            "seconds": {"load": 0.0, "compile": 0.0, **facts.pop("seconds", {}), "render": seconds, "write": write,
                        "work": self.film.seconds},  # work: of all threads together
            "samples": int(samples) if samples == int(samples) else samples,
            "rays": dict(zip(("camera", "bounce", "shadow"), rays)),
            "rays_per_second": sum(rays) / seconds if seconds > 0 else 0.0,
            "error": {field.name: last.get(field.name) for field in fields(ErrorEstimate)},
            "curve": [dict(point) for point in self.curve],
            "width": self.plan.width, "height": self.plan.height, "tile_size": self.plan.tile_size,
            **facts,
        }
