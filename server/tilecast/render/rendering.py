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
from .rounds import PILOT, Rounds, reckoned

Event = dict[str, Any]

_log = logging.getLogger(__name__)

_MOST_CHUNKS = 256  # that are handed out together


@dataclass
class ChunkResult:
    """What a chunk gives: the sums of its samples (float64 [2, h, w, 3], even and odd samples apart), camera,
    bounce and shadow rays traced, and the seconds of work."""
    sums: np.ndarray
    rays: tuple[int, int, int]
    seconds: float


class Rendering:
    """The making of one image after `plan`, round by round; see `rounds`.

    `stop.relative_mse` ends it with the first round after which the error is that low (see `rounds`), so the image is
    the same however the chunks ran. `stop.seconds` hands out no new chunk after that time; what is done is kept, and
    every pixel has its first samples. Time counts while chunks are in flight: an image that is paused does not use up
    its seconds.
    """

    def __init__(self, plan: Plan, stop: Stop | None = None, clock: Callable[[], float] = time.monotonic,
                 adaptive: bool = False):
        self.plan = plan
        self.stop = stop or Stop()
        self.film = Film(plan, closely=self.stop.relative_mse is not None or adaptive)
        self.curve: list[dict[str, Any]] = []
        self._rounds = Rounds(self.film, self.stop.relative_mse, adaptive)
        self._next: Chunk | None = None  # taken from the round, not yet handed out
        self._again: list[Chunk] = []  # given back
        self._in_flight: set[tuple[int, int]] = set()  # (tile, range)
        self._clock = clock
        self._since = 0.0  # when the first of those in flight went out
        self._seconds = 0.0  # before that
        self._work, self._worked = 0.0, 0  # seconds of all threads, and what they gave: samples of a pixel

    # --- Handing out

    def next_chunk(self) -> Chunk | None:
        """The next chunk to render; None where there is nothing to hand out now. There may be again after a
        result."""
        # A chunk that was given back is not new: without it, what has been done since might never be added.
        chunk = self._again.pop(0) if self._again else self._upcoming()
        if chunk is not None:
            if not self._in_flight:
                self._since = self._clock()
            self._in_flight.add((chunk.tile.index, chunk.range))
        return chunk

    def next_chunks(self, seconds: float) -> tuple[Chunk, ...]:
        """The next chunks to render, as many as take one thread about so many seconds, by what others took; one, as
        long as nobody knows. Empty where there is nothing to hand out now."""
        chunks: list[Chunk] = []
        samples = 0
        while len(chunks) < _MOST_CHUNKS and (chunk := self.next_chunk()) is not None:
            chunks.append(chunk)
            samples += chunk.samples
            if samples * self._work >= seconds * self._worked:
                break
        return tuple(chunks)

    def _upcoming(self) -> Chunk | None:
        if self._next is None:
            self._next = self._rounds.next()
        if self._next is None or (self._next.range > 0 and self._expired()):
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
        return self._rounds.ended or (begun and self._expired())

    def _expired(self) -> bool:
        return self.stop.seconds is not None and self.seconds >= self.stop.seconds

    # --- Results

    def add(self, chunk: Chunk, result: ChunkResult) -> list[Event]:
        """Takes a result; the events that follow from it: tiles that have changed, points of the error
        curve."""
        self._landed(chunk)
        self._work += result.seconds
        self._worked += chunk.samples
        events = []
        if self.film.add(chunk, result.sums, result.rays, result.seconds):
            self._rounds.arrived(chunk.tile)
            events.append(self.tile_event(chunk.tile))
        return events + self._advance({})

    def _advance(self, known: Mapping[float, Mapping[str, Any]]) -> list[Event]:
        """Draws the points of the curve that are reached, and begins the rounds that follow. Points that are `known`,
        by their samples, have their time already; the others are events."""
        events: list[Event] = []

        def draw(samples: float, estimate: ErrorEstimate) -> None:
            point = known.get(samples) if not events else None
            if point is None:
                point = {"seconds": self.seconds, "samples": samples, **estimate.to_json()}
                events.append({"type": "error", **point})
            self.curve.append({key: value for key, value in point.items() if key != "type"})

        while not self._rounds.ended:
            for samples, estimate in self._rounds.points(len(self.curve)):
                draw(samples, estimate)
            if not self._rounds.complete:
                break
            self._rounds.go_on(self.curve[-1] if self.curve else None)
        # Where the time was up between two points, the image that is there is none of theirs.
        if self.finished and self.curve and self.curve[-1]["samples"] != self.samples:
            draw(self.samples, self.film.standing_error())
        return events

    def tile_event(self, tile: Tile) -> Event:
        """The event that says how a tile stands."""
        return {"type": "tile", "column": tile.column, "row": tile.row, "x": tile.x, "y": tile.y, "width": tile.width,
                "height": tile.height, "version": self.film.tile_version(tile),
                "samples": self.film.tile_samples(tile), "relative_mse": self.film.tile_error(tile)}

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
        for tile in self.plan.tiles:
            self._rounds.arrived(tile)
        return self._advance({point["samples"]: point for point in curve})

    # --- How it stands

    @property
    def samples(self) -> float:
        """Of a pixel, on average."""
        mean = self.film.samples / (self.plan.width * self.plan.height)
        return int(mean) if mean == int(mean) else mean

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
            point = self.curve[-1]  # the error falls as 1 / samples
            times = max(reckoned(point) / self.stop.relative_mse, 0 if point["heavy_tailed"] is False else 2)
            needed = min(max(point["samples"] * times, PILOT), needed)
        return min(self.samples / needed, 1.0)

    def statistics(self, facts: Mapping[str, Any] | None = None, write: float = 0.0) -> dict[str, Any]:
        """The statistics of the image as `--stats` writes them. `facts` are those of the scene
        (`Compiled.facts`), `write` the seconds that writing the image took."""
        facts = dict(facts or {})
        rays, seconds = self.film.rays, self.seconds
        last = self.curve[-1] if self.curve else {}
        return {
            "seconds": {"load": 0.0, "compile": 0.0, **facts.pop("seconds", {}), "render": seconds, "write": write,
                        "work": self.film.seconds},  # work: of all threads together
            "samples": self.samples,
            "rays": dict(zip(("camera", "bounce", "shadow"), rays)),
            "rays_per_second": sum(rays) / seconds if seconds > 0 else 0.0,
            "error": {field.name: last.get(field.name) for field in fields(ErrorEstimate)},
            "curve": [dict(point) for point in self.curve],
            "width": self.plan.width, "height": self.plan.height, "tile_size": self.plan.tile_size,
            **facts,
        }
