"""The plan of an image: tiles times ranges of samples. It depends on the image and the sample count alone,
never on who renders it, and so every checkpoint of the error lies at the same place in every run."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

MOST_IN_RANGE = 1024  # samples; longer chunks would make pausing and retrying coarse
_CHUNK_SAMPLES = 2**20  # of a whole chunk: about a second of one core
_SMALLEST_TILE, _LARGEST_TILE, _MANY_TILES = 16, 128, 64
_SHORT_CHUNK, _FEWEST_TILES = 2**15, 16  # samples: a few milliseconds where paths are cheap, so that sharing out costs
_SMALLEST_ADAPTIVE, _LARGEST_ADAPTIVE, _MOST_ADAPTIVE = 8, 64, 4096


@dataclass(frozen=True)
class Tile:
    """A rectangle of the image, in pixels from the top left; `index` counts row by row."""
    index: int
    column: int
    row: int
    x: int
    y: int
    width: int
    height: int

    @property
    def pixels(self) -> int:
        """How many there are in it."""
        return self.width * self.height

    @property
    def window(self) -> tuple[slice, slice]:
        """Its rows and columns: image[tile.window] is the tile's part of an image [height, width, ...]."""
        return slice(self.y, self.y + self.height), slice(self.x, self.x + self.width)


@dataclass(frozen=True)
class Chunk:
    """The unit of work: samples first .. first + count - 1 of every pixel of a tile. `range` counts the chunks of
    the tile; `checkpoint`: after it the tile's error is estimated."""
    tile: Tile
    range: int
    first: int
    count: int
    checkpoint: bool = True

    @property
    def samples(self) -> int:
        """Over all its pixels."""
        return self.tile.pixels * self.count


@dataclass(frozen=True)
class Plan:
    """See `make_plan`. Tiles on the right and lower edge are cut to the image."""
    width: int
    height: int
    samples: int
    tile_size: int

    @property
    def columns(self) -> int:
        return -(-self.width // self.tile_size)

    @property
    def rows(self) -> int:
        return -(-self.height // self.tile_size)

    @property
    def count(self) -> int:
        """Of tiles."""
        return self.columns * self.rows

    @cached_property
    def tiles(self) -> tuple[Tile, ...]:
        """All tiles, row by row: tiles[i].index == i."""
        size = self.tile_size
        return tuple(
            Tile(row * self.columns + column, column, row, column * size, row * size,
                 min(size, self.width - column * size), min(size, self.height - row * size))
            for row in range(self.rows) for column in range(self.columns))

    @cached_property
    def ranges(self) -> tuple[tuple[int, int], ...]:
        """(first, count) of each range of samples: [0, 2) [2, 4) [4, 8) [8, 16) ..., none longer than 1024,
        the last cut at `samples`. The halves of an error estimate are even and odd samples, hence the two in
        the first."""
        found = []
        first = 0
        while first < self.samples:
            count = min(max(first, 2), MOST_IN_RANGE, self.samples - first)
            found.append((first, count))
            first += count
        return tuple(found)

    @cached_property
    def checkpoints(self) -> tuple[int, ...]:
        """The ranges after which the error is estimated: those that end at a power of two, and the last."""
        ends = [first + count for first, count in self.ranges]
        return tuple(index for index, end in enumerate(ends)
                     if end & (end - 1) == 0 and end > 1 or (index == len(ends) - 1 and end > 1))

    def samples_after(self, ranges: int) -> int:
        """Samples in the first so many ranges."""
        return sum(self.ranges[ranges - 1]) if ranges else 0

    @cached_property
    def order(self) -> tuple[Tile, ...]:
        """The tiles from the centre of the image outwards, in rings that each turn once around."""
        def ring_then_angle(tile: Tile) -> tuple[float, float]:
            right = tile.column - (self.columns - 1) / 2
            down = tile.row - (self.rows - 1) / 2
            return math.ceil(max(abs(right), abs(down))), math.atan2(down, right)
        return tuple(sorted(self.tiles, key=ring_then_angle))

    def chunks(self) -> Iterator[Chunk]:
        """All chunks: every tile's first range, then every tile's second, ..."""
        checkpoints = set(self.checkpoints)
        for index, (first, count) in enumerate(self.ranges):
            for tile in self.order:
                yield Chunk(tile, index, first, count, index in checkpoints)


def make_plan(width: int, height: int, samples: int, tile_size: int | None = None, adaptive: bool = False) -> Plan:
    """The plan of an image of width x height pixels with `samples` for each. The tile size only decides how
    the work is cut; without one, it is the largest power of two from 16 to 128 that keeps chunks near a
    second and leaves some 64 tiles to share out, or 16 where chunks would be short. Adaptive sampling decides by tiles:
    theirs is the smallest from 8 to 64 that makes no more than 4096 of them."""
    if min(width, height, samples) < 1 or (tile_size is not None and tile_size < 1):
        raise ValueError(f"an image needs at least one pixel, sample and pixel a tile, got {width} x {height}, "
                         f"{samples} samples, tiles of {tile_size}")
    if tile_size is None and adaptive:
        tile_size = _SMALLEST_ADAPTIVE
        while tile_size < _LARGEST_ADAPTIVE and Plan(width, height, samples, tile_size).count > _MOST_ADAPTIVE:
            tile_size *= 2
    elif tile_size is None:
        longest = max(count for _, count in Plan(width, height, samples, _LARGEST_TILE).ranges)
        pixels = min(_CHUNK_SAMPLES / longest, width * height / _MANY_TILES)
        tile_size = _SMALLEST_TILE
        few = min(_SHORT_CHUNK / longest, width * height / _FEWEST_TILES)
        while tile_size < _LARGEST_TILE and (2 * tile_size) ** 2 <= max(pixels, few):
            tile_size *= 2
    return Plan(width, height, samples, tile_size)
