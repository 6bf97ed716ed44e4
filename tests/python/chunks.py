"""Chunks without a scene: samples drawn from a known distribution, keyed by pixel and sample index as the
core's are."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tilecast.render.film import Film
from tilecast.render.plan import Chunk, Plan
from tilecast.render.rendering import ChunkResult

Image = np.ndarray  # float64 [samples, h, w, 3]: every sample of every pixel


def draw(plan: Plan, sampler: Callable[[np.random.Generator, tuple], np.ndarray], seed: int = 0) -> Image:
    return sampler(np.random.default_rng(seed), (plan.samples, plan.height, plan.width, 3))


def normal(generator: np.random.Generator, shape: tuple) -> np.ndarray:
    return generator.normal(0.5, 0.25, shape)


def chunk_sums(image: Image, chunk: Chunk) -> np.ndarray:
    """What the core gives: the sums of a chunk, even and odd sample indices apart."""
    tile = chunk.tile
    part = image[chunk.first:chunk.first + chunk.count, *tile.window]
    sums = np.zeros((2, tile.height, tile.width, 3))
    for index, sample in enumerate(part):  # one after the other, as the core adds
        sums[(chunk.first + index) % 2] += sample
    return sums


def result(image: Image, chunk: Chunk) -> ChunkResult:
    pixels = chunk.tile.width * chunk.tile.height * chunk.count
    return ChunkResult(chunk_sums(image, chunk), (pixels, 2 * pixels, 3 * pixels), 0.5)


def exposed(plan: Plan, image: Image, chunks=None) -> Film:
    """A film with the chunks added in the order given."""
    film = Film(plan)
    for chunk in plan.chunks() if chunks is None else chunks:
        film.add(chunk, chunk_sums(image, chunk))
    return film
