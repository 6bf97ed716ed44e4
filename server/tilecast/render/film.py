"""The image in the making: sums of samples, tile by tile.

The chunks of a tile are added in the order of their samples whatever the order in which they arrive, so the bits
of the image do not depend on threads, machines or tile size. What a tile holds is never changed in place but
replaced as a whole: a reader in another thread always sees one consistent state.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from .. import _core
from . import error
from .plan import MOST_IN_RANGE, Chunk, Plan, Tile

_FORMAT = 9  # of saved tiles, and of the way in which adaptive rounds decide: others do not fit it
MOST_FLOAT = float(np.finfo(np.float32).max)


def as_float32(values: np.ndarray) -> np.ndarray:
    """What is above the largest float becomes it: sums are finite, and images stay so."""
    return np.clip(values, -MOST_FLOAT, MOST_FLOAT).astype(np.float32)


@dataclass(frozen=True)
class _TileState:
    sums: np.ndarray | None = None  # float64 [2, h, w, 3]: even samples, odd samples; None: nothing yet
    lost: np.ndarray | None = None  # the same: what rounding took from the sums; None: they are of few chunks
    earlier: np.ndarray | None = None  # the sums at `split` samples: what came later is the error estimate's other part
    split: int = 0  # 0: there are none, as the sums themselves are the first part of what comes next
    coming: np.ndarray | None = None  # the sums at `start` samples, which are `earlier` once as many by half came later
    start: int = 0  # 0: there are none
    ranges: int = 0  # chunks added so far
    samples: int = 0  # of each pixel
    partials: np.ndarray = field(default_factory=lambda: np.empty((0, error.PARTIALS)))  # [checkpoints so far, n]
    checked: int = 0  # samples at the last checkpoint
    rays: tuple[int, int, int] = (0, 0, 0)  # camera, bounce, shadow
    rays_at: tuple[int, ...] = ()  # all of them at each checkpoint
    seconds: float = 0.0  # of work, over all threads


def _sum(state: _TileState, chunk: Chunk, sums: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
    """The sums with those of the next chunk, and what rounding took from them: it counts where chunks are many."""
    # The first sums are taken as they are, not added to zero: so -0.0 stays what it is, whatever the order.
    if state.sums is None:
        return sums, None
    if chunk.first < MOST_IN_RANGE:
        return state.sums + sums, None
    return _core.add_sums(state.sums, np.zeros_like(sums) if state.lost is None else state.lost, sums)


def _standing_partials(state: _TileState) -> np.ndarray:
    previous = state.partials[-1] if len(state.partials) else None
    if state.checked == state.samples:
        return previous
    parts = ((state.earlier, state.split), (state.sums - state.earlier, state.samples - state.split)) \
        if state.split else ()
    return error.tile_partials(state.sums, state.samples, parts, previous)


class Film:
    """The sums of every tile of a plan. `closely`: the error is estimated after short ranges as well, not at powers of
    two alone, which takes one more array to tell as well."""

    def __init__(self, plan: Plan, closely: bool = False):
        self.plan = plan
        self._closely = closely
        self.samples = 0  # taken, over all pixels
        self.tiles_begun = 0  # that have their first range
        self._tiles = [_TileState() for _ in plan.tiles]
        self._waiting: list[dict[int, tuple]] = [{} for _ in plan.tiles]  # by range, for those before them
        self._at_checkpoint: list[int] = []  # how many tiles have come to their first, second, ...

    def add(self, chunk: Chunk, sums: np.ndarray, rays: tuple[int, int, int] = (0, 0, 0),
            seconds: float = 0.0) -> bool:
        """Takes the sums of a chunk, float64 [2, h, w, 3]; whether the tile has changed by it. A chunk that
        comes twice counts once: its sums are the same each time."""
        tile = chunk.tile
        expected = (2, tile.height, tile.width, 3)
        if np.shape(sums) != expected:
            raise ValueError(f"the sums of a chunk of tile {tile.column}, {tile.row} must be {expected}, "
                             f"got {np.shape(sums)}")
        waiting = self._waiting[tile.index]
        if chunk.range >= self._tiles[tile.index].ranges:
            waiting.setdefault(chunk.range, (chunk, np.asarray(sums, np.float64), tuple(rays), seconds))
        state = self._tiles[tile.index]
        before = state.ranges
        while state.ranges in waiting:
            state = self._advanced(state, *waiting.pop(state.ranges))
        self._put(tile, state)
        return state.ranges > before

    def _advanced(self, state: _TileState, chunk: Chunk, sums: np.ndarray, rays: tuple, seconds: float) -> _TileState:
        """The state with the next chunk added."""
        if chunk.first != state.samples:
            raise ValueError(f"the next chunk of tile {chunk.tile.column}, {chunk.tile.row} must begin at sample "
                             f"{state.samples}, got {chunk.first}")
        done = state.samples + chunk.count
        total, lost = _sum(state, chunk, sums)
        earlier, split, coming, start = state.earlier, state.split, state.coming, state.start
        if split == 0:
            earlier, split = state.sums, state.samples
        if start > 0 and done - start >= start // 2:
            earlier, split, coming, start = coming, start, None, 0
        rays = tuple(a + b for a, b in zip(state.rays, rays))
        partials, rays_at = state.partials, state.rays_at
        if chunk.checkpoint:
            rays_at = (*rays_at, sum(rays))
            later = sums if split == state.samples else total - earlier
            parts = () if earlier is None else ((earlier, split), (later, done - split))
            row = error.tile_partials(total, done, parts, partials[-1] if len(partials) else None)
            partials = np.vstack([partials, row])
        checked = done if chunk.checkpoint else state.checked
        past_power = done.bit_length() > max(split, start).bit_length()
        if not self._closely and (past_power or done == self.plan.samples):
            earlier, split = None, 0  # the next part of the samples begins here
        elif past_power:
            coming, start = total, done  # or here, as soon as it is long enough to tell as much as what was before
        return _TileState(total, lost, earlier, split, coming, start, state.ranges + 1, done, partials, checked, rays,
                          rays_at, state.seconds + seconds)

    def _put(self, tile: Tile, state: _TileState) -> None:
        before = self._tiles[tile.index]
        self._tiles[tile.index] = state
        self.tiles_begun += before.ranges == 0 < state.ranges
        self.samples += tile.pixels * (state.samples - before.samples)
        for at in range(len(before.partials), len(state.partials)):
            if at == len(self._at_checkpoint):
                self._at_checkpoint.append(0)
            self._at_checkpoint[at] += 1

    # --- What is there

    @property
    def checkpoints_done(self) -> int:
        """Checkpoints that every tile has reached."""
        return next((k for k, tiles in enumerate(self._at_checkpoint) if tiles < len(self._tiles)),
                    len(self._at_checkpoint))

    def error(self, checkpoint: int) -> error.ErrorEstimate:
        """The estimate at a checkpoint that every tile has reached, counted from 0."""
        return self.error_after([checkpoint + 1] * len(self._tiles))

    def error_after(self, checkpoints: Sequence[int]) -> error.ErrorEstimate:
        """The estimate after so many checkpoints of each tile, at least one."""
        return error.estimate(self._partials_after(checkpoints), self.plan.width * self.plan.height)

    def standing_error(self) -> error.ErrorEstimate | None:
        """The estimate of the image as it stands, with the samples after the last checkpoints; None before every tile
        has two."""
        if min(state.samples for state in self._tiles) < 2:
            return None
        partials = np.array([_standing_partials(state) for state in self._tiles])
        return error.estimate(partials, self.plan.width * self.plan.height)

    def relative_sums(self, checkpoints: Sequence[int]) -> np.ndarray:
        """The relative squared error of each tile after so many of its checkpoints, summed over its pixels; float64
        [tiles]."""
        return error.relative_sums(self._partials_after(checkpoints))

    def rays_after(self, checkpoints: Sequence[int]) -> np.ndarray:
        """All rays of each tile up to so many of its checkpoints, float64 [tiles]."""
        return np.array([state.rays_at[count - 1] for state, count in zip(self._tiles, checkpoints)], np.float64)

    def _partials_after(self, checkpoints: Sequence[int]) -> np.ndarray:
        return np.array([state.partials[count - 1] for state, count in zip(self._tiles, checkpoints)])

    def tile_version(self, tile: Tile) -> int:
        """How often the tile has changed: the number of its chunks that are added."""
        return self._tiles[tile.index].ranges

    def tile_samples(self, tile: Tile) -> int:
        """Samples of each pixel of the tile."""
        return self._tiles[tile.index].samples

    def tile_pixels(self, tile: Tile) -> np.ndarray:
        """The tile as it stands: float32 [h, w, 3], linear RGB; 0 where there is no sample yet."""
        state = self._tiles[tile.index]
        if state.sums is None:
            return np.zeros((tile.height, tile.width, 3), np.float32)
        return as_float32((state.sums[0] + state.sums[1]) / state.samples)

    def pixels(self) -> np.ndarray:
        """The image as it stands: float32 [height, width, 3]."""
        image = np.zeros((self.plan.height, self.plan.width, 3), np.float32)
        for tile in self.plan.tiles:
            if self._tiles[tile.index].sums is not None:
                image[tile.window] = self.tile_pixels(tile)
        return image

    def variance(self) -> np.ndarray:
        """The estimated variance of each pixel as it stands, float32 [height, width, 3], or float64 where float32 cannot
        hold it; 0 where there are fewer than two samples."""
        image = np.zeros((self.plan.height, self.plan.width, 3))
        for tile in self.plan.tiles:
            state = self._tiles[tile.index]
            if state.sums is not None:
                image[tile.window] = error.variance(state.sums, state.samples)
        return image if image.max() > MOST_FLOAT else image.astype(np.float32)

    def sample_counts(self) -> np.ndarray:
        """The samples of each pixel as it stands, uint32 [height, width]."""
        counts = np.zeros((self.plan.height, self.plan.width), np.uint32)
        for tile in self.plan.tiles:
            counts[tile.window] = self.tile_samples(tile)
        return counts

    def tile_error(self, tile: Tile) -> float | None:
        """The relative MSE of the tile alone at its last checkpoint; None before there is one. The image's differs from
        the mean over its tiles by what parts of the samples tell of its bias, for which a tile is too small."""
        partials = self._tiles[tile.index].partials
        return float(error.relative_sums(partials[-1:])[0]) / tile.pixels if len(partials) else None

    @property
    def rays(self) -> tuple[int, int, int]:
        """Camera, bounce and shadow rays behind what is added."""
        return tuple(sum(state.rays[kind] for state in self._tiles) for kind in range(3))

    @property
    def seconds(self) -> float:
        """Work behind what is added, summed over all threads."""
        return sum(state.seconds for state in self._tiles)

    # --- Storing

    def save_tile(self, tile: Tile) -> bytes:
        """All that is needed to go on with this tile (an NPZ archive); the inverse of `load_tile`."""
        state = self._tiles[tile.index]
        if state.sums is None:
            raise ValueError(f"tile {tile.column}, {tile.row} has no samples to save yet")
        out = io.BytesIO()
        np.savez(out, format=np.int64(_FORMAT), tile=self._identity(tile), ranges=np.int64(state.ranges),
                 samples=np.int64(state.samples), sums=state.sums,
                 lost=np.empty(0) if state.lost is None else state.lost,
                 earlier=np.empty(0) if state.earlier is None else state.earlier, split=np.int64(state.split),
                 coming=np.empty(0) if state.coming is None else state.coming, start=np.int64(state.start),
                 partials=state.partials, checked=np.int64(state.checked),
                 rays=np.array(state.rays, np.int64), rays_at=np.array(state.rays_at, np.int64),
                 seconds=np.float64(state.seconds))
        return out.getvalue()

    def load_tile(self, tile: Tile, data: bytes) -> None:
        """Takes up what `save_tile` stored. ValueError where it is damaged or belongs to another plan or
        tile."""
        try:
            with np.load(io.BytesIO(data), allow_pickle=False) as stored:
                arrays = dict(stored)
            same = int(arrays["format"]) == _FORMAT and np.array_equal(arrays["tile"], self._identity(tile))
            lost, earlier, coming = (arrays[name] if arrays[name].size else None for name in ("lost", "earlier", "coming"))
            state = _TileState(arrays["sums"], lost, earlier, int(arrays["split"]), coming, int(arrays["start"]),
                               int(arrays["ranges"]), int(arrays["samples"]), arrays["partials"], int(arrays["checked"]),
                               tuple(arrays["rays"].tolist()), tuple(arrays["rays_at"].tolist()),
                               float(arrays["seconds"]))
        except Exception as problem:  # zipfile, zlib and numpy each have their own errors for damaged bytes
            raise ValueError(f"the stored tile {tile.column}, {tile.row} is damaged: {problem}") from problem
        shape = (2, tile.height, tile.width, 3)
        if not same or state.sums.shape != shape \
                or any(found is not None and found.shape != shape for found in (lost, earlier, coming)) \
                or not 0 <= state.split < state.samples or (earlier is None) != (state.split == 0) \
                or not 0 <= state.start <= state.samples or (coming is None) != (state.start == 0) \
                or state.partials.shape != (len(state.rays_at), error.PARTIALS):
            raise ValueError(f"the stored tile {tile.column}, {tile.row} belongs to another plan or tile")
        if self._tiles[tile.index].ranges:
            raise ValueError(f"tile {tile.column}, {tile.row} has samples already")
        self._put(tile, state)

    def _identity(self, tile: Tile) -> np.ndarray:
        return np.array([tile.x, tile.y, tile.width, tile.height, self.plan.samples], np.int64)
