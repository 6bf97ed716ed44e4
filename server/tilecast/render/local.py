"""Renders on the threads of this process: the road of the command line and of Python."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..scene.compiler import Compiled
from ..scene.schema import Stop
from .dispatch import Dispatcher
from .layers import FIRST_HIT_SAMPLES, error_layers, first_hit_layers
from .output import encode
from .plan import Chunk, Tile, make_plan
from .rendering import ChunkResult, Event, Rendering

_TASK_SECONDS = 0.01  # that a task is meant to take: the way to a thread and back is a hundredth of that


@dataclass(frozen=True)
class Image:
    """A rendered image: linear RGB, with its estimated error and the statistics of `--stats`."""
    pixels: np.ndarray
    """float32 [h, w, 3]"""
    variance: np.ndarray
    """float32 [h, w, 3], or float64 where float32 cannot hold it: estimated, of each pixel."""
    sample_counts: np.ndarray
    """uint32 [h, w]"""
    error: dict[str, float | None]
    stats: dict[str, Any]


def render(compiled: Compiled, *, samples: int | None = None, threads: int | None = None,
           on_event: Callable[[Event, Rendering], None] | None = None, stop: Stop | None = None,
           tile_size: int | None = None) -> Image:
    """Renders a scene; `samples` and `stop` come from the scene where they are not given, `threads` is one a
    core.

    `on_event(event, rendering)` is called on another thread for each tile and point of the error curve as it
    comes. Neither `threads` nor, unless the scene is sampled adaptively, `tile_size` changes a pixel. A sample that
    is NaN or infinite raises the core's SampleError.
    """
    document = compiled.document
    plan = make_plan(compiled.scene.width, compiled.scene.height,
                     document.render.samples if samples is None else samples, tile_size, document.render.adaptive)
    threads = threads or len(os.sched_getaffinity(0))
    work = _Work(compiled, Rendering(plan, document.render.stop if stop is None else stop,
                                         adaptive=document.render.adaptive), on_event)
    executor = ThreadPoolExecutor(threads, "render")
    dispatcher = Dispatcher(executor, threads)
    try:
        dispatcher.add(work)
        work.ended.wait()
    finally:
        dispatcher.close()
        executor.shutdown(cancel_futures=True)
    if work.error is not None:
        raise work.error
    stats = work.rendering.statistics(compiled.facts())
    film = work.rendering.film
    return Image(film.pixels(), film.variance(), film.sample_counts(), stats["error"], stats)


def render_chunks(compiled: Compiled, chunks: Sequence[Chunk]) -> list[ChunkResult]:
    """Renders chunks one after the other, on this thread. Each is said to take its share of the seconds by its samples."""
    start = time.perf_counter()
    found = compiled.scene.render_chunks([(chunk.tile.x, chunk.tile.y, chunk.tile.width, chunk.tile.height, chunk.first,
                                           chunk.count) for chunk in chunks])
    pace = (time.perf_counter() - start) / sum(chunk.samples for chunk in chunks)
    return [ChunkResult(sums.sums, sums.rays, pace * chunk.samples) for chunk, sums in zip(chunks, found, strict=True)]


def first_hits(compiled: Compiled, threads: int | None = None) -> np.ndarray:
    """What the camera sees first in each pixel, float32 [h, w, 7]: see the core's function of this name."""
    scene = compiled.scene
    plan = make_plan(scene.width, scene.height, 1)
    whole = np.empty((scene.height, scene.width, 7), np.float32)

    def fill(tile: Tile) -> None:
        whole[tile.window] = tile_first_hits(compiled, tile)

    with ThreadPoolExecutor(threads or len(os.sched_getaffinity(0)), "first-hits") as pool:
        for _ in pool.map(fill, plan.tiles):
            pass
    return whole


def encoded(suffix: str, compiled: Compiled, image: Image, threads: int | None = None) -> bytes:
    """The file of an image by its suffix (".png", ".exr"); an EXR has its layers."""
    layers = None
    if suffix.lower() == ".exr":
        layers = (error_layers(image.pixels, image.variance, image.sample_counts)
                  | first_hit_layers(first_hits(compiled, threads)))
    render = compiled.document.render
    metadata = {"Software": "tilecast", "tilecast:seed": str(render.seed),
                "tilecast:samples": f"{image.stats['samples']:g}"}
    return encode(suffix, image.pixels, metadata, image.stats, layers)


def tile_first_hits(compiled: Compiled, tile: Tile) -> np.ndarray:
    """The same of a tile, on this thread."""
    return compiled.scene.first_hits(tile.x, tile.y, tile.width, tile.height, FIRST_HIT_SAMPLES)


class _Work:
    """The one rendering, as the dispatcher sees it."""

    key = owner = "image"
    priority = 0

    def __init__(self, compiled: Compiled, rendering: Rendering,
                 on_event: Callable[[Event, Rendering], None] | None):
        self.compiled = compiled
        self.rendering = rendering
        self.on_event = on_event
        self.error: BaseException | None = None
        self.ended = threading.Event()

    def next(self) -> tuple[Chunk, ...] | None:
        return None if self.error else self.rendering.next_chunks(_TASK_SECONDS) or None

    def submit(self, executor: Executor, chunks: tuple[Chunk, ...]) -> Future:
        return executor.submit(render_chunks, self.compiled, chunks)

    def done(self, chunks: tuple[Chunk, ...], results: list[ChunkResult]) -> None:
        for chunk, result in zip(chunks, results, strict=True):
            for event in self.rendering.add(chunk, result):
                if self.on_event:
                    self.on_event(event, self.rendering)

    def failed(self, chunks: tuple[Chunk, ...] | None, error: BaseException) -> None:
        self.error = self.error or error
        self.ended.set()

    def finished(self) -> None:
        if self.error is None and not self.rendering.finished:
            self.error = RuntimeError("the rendering came to a halt before its end")
        self.ended.set()
