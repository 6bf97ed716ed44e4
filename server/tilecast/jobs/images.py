"""Pictures of jobs, as they stand: from memory while they render, from their blobs otherwise."""

import threading
from collections import OrderedDict
from collections.abc import Callable
from contextlib import suppress
from typing import TypeVar

import numpy as np
import structlog

from tilecast.jobs.blobs import Blobs, pixels_key, thumbnail_key, tile_key, variance_key
from tilecast.jobs.faults import NoSuchJob, NotYet
from tilecast.jobs.first_hits import FirstHits
from tilecast.jobs.records import Job
from tilecast.jobs.state import State
from tilecast.jobs.store import Store
from tilecast.jobs.work import JobWork, job_plan
from tilecast.render import film, output, plan
from tilecast.render.display import shown
from tilecast.render.layers import Layers, error_layers, first_hit_layers

log = structlog.get_logger()

_KEPT_BYTES = 128 * 2**20

Value = TypeVar("Value")


class Images:
    """Finds the pixels of a job and encodes them. Keeps the pictures that were asked for last."""

    def __init__(self, store: Store, blobs: Blobs, live: Callable[[str], JobWork | None], first_hits: FirstHits):
        self._store = store
        self._blobs = blobs
        self._live = live
        self._first_hits = first_hits
        self._lock = threading.Lock()
        self._kept: OrderedDict[tuple, bytes] = OrderedDict()

    def tile_version(self, job: Job, column: int, row: int) -> int | None:
        """How many sample ranges are in this tile; None where the image has no such tile."""
        tile = _tile(job, column, row)
        if tile is None:
            return None
        live = self._live_tile(job, tile)
        return live[1] if live else self._store.tile_version(job.id, tile.index)

    def tile(self, job: Job, column: int, row: int, format: str) -> tuple[bytes, int]:
        """One tile as "png" or "f16", and its version; black, and 0, where it cannot be read. Raises `NoSuchJob`."""
        tile = _tile(job, column, row)
        pixels, version = self._while_it_stands(
            job, lambda job: self._live_tile(job, tile) or self._stored_tile(job, tile)
        )
        pixels = shown(pixels, self._facts(job))
        return output.to_png(pixels) if format == "png" else output.to_f16(pixels), version

    def _live_tile(self, job: Job, tile: plan.Tile) -> tuple[np.ndarray, int] | None:
        work = self._live(job.id)
        return work.tile(tile) if work else None

    def image(self, job: Job, kind: str) -> bytes:
        """The whole picture as "png", "exr" (with layers), "thumbnail" (a small PNG) or "error" (a map of it, PNG).

        Raises `NoSuchJob`."""
        key = (job.id, job.event, kind)
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
                return self._kept[key]
        data = self._while_it_stands(job, lambda job: self._encode(job, kind))
        with self._lock:
            self._kept[key] = data
            while sum(map(len, self._kept.values())) > _KEPT_BYTES:
                self._kept.popitem(last=False)
        return data

    def _while_it_stands(self, job: Job, read: Callable[[Job], Value]) -> Value:
        """What `read` finds of the job. It raises `FileNotFoundError` where the job ended after its row was read, and its
        tiles gave way to the finished image: then it reads again, by the row as it is now."""
        while True:
            try:
                return read(job)
            except FileNotFoundError:
                if not self._has_changed(job):
                    raise
                job = self._store.get(job.id)
                if job is None:
                    raise NoSuchJob("The job was deleted while its picture was read.") from None

    def _has_changed(self, job: Job) -> bool:
        now = self._store.get(job.id)
        return now is None or (now.state, now.event) != (job.state, job.event)

    def _encode(self, job: Job, kind: str) -> bytes:
        if kind == "thumbnail":
            if job.state is State.DONE:
                try:
                    return self._blobs.get(thumbnail_key(job.id))
                except FileNotFoundError:
                    log.warning("thumbnail_missing", job=job.id)
            return output.thumbnail(shown(self._pixels(job), self._facts(job)))
        if kind == "exr":
            return output.to_exr(self._pixels(job), metadata(job), self._layers(job))
        if kind == "error":
            return output.error_png(self._pixels(job), self._variance(job))
        return output.to_png(shown(self._pixels(job), self._facts(job)))

    def _facts(self, job: Job) -> dict | None:
        """Of the scene; `job` may have been read before they were stored."""
        work = self._live(job.id)
        return work.facts if work and work.facts else job.facts

    def _layers(self, job: Job) -> Layers:
        """What can be had for an EXR. A scene that failed is not asked again what the camera sees: it may be what
        kills the workers."""
        layers: Layers = {}
        with suppress(NotYet):
            layers |= error_layers(self._pixels(job), self._variance(job), self._sample_counts(job))
        hits = self._first_hits.get(job) if job.state is not State.FAILED else None
        return layers if hits is None else layers | first_hit_layers(hits)

    def _pixels(self, job: Job) -> np.ndarray:
        if job.state is State.DONE:
            return self._blobs.get_array(pixels_key(job.id))
        work = self._live(job.id)
        if work is not None and (pixels := work.pixels()) is not None:
            return pixels
        return self._stored(job).pixels()

    def _variance(self, job: Job) -> np.ndarray:
        """float32 [height, width, 3]. Raises `NotYet` where an earlier version finished the job, without it."""
        if job.state is State.DONE:
            try:
                return self._blobs.get_array(variance_key(job.id))
            except FileNotFoundError:
                raise NotYet("This job was finished before errors were kept for each pixel.") from None
        work = self._live(job.id)
        if work is not None and (variance := work.variance()) is not None:
            return variance
        return self._stored(job).variance()

    def _sample_counts(self, job: Job) -> np.ndarray:
        """uint32 [height, width]."""
        counts = np.zeros((job.height, job.width), np.uint32)
        for row in self._store.tiles(job.id):
            tile = job_plan(job).tiles[row.index]
            counts[tile.window] = row.samples
        return counts

    def _stored(self, job: Job) -> film.Film:
        """What is stored of a job that is neither finished nor under way."""
        drawn = film.Film(job_plan(job))
        for row in self._store.tiles(job.id):
            self._load(drawn, job, drawn.plan.tiles[row.index], row.version)
        return drawn

    def _load(self, drawn: film.Film, job: Job, tile: plan.Tile, version: int) -> None:
        """What was damaged is black until it is rendered again. Raises `FileNotFoundError` where the job has changed."""
        try:
            drawn.load_tile(tile, self._blobs.get(tile_key(job.id, tile.index, version)))
        except (FileNotFoundError, ValueError) as error:
            if isinstance(error, FileNotFoundError) and self._has_changed(job):
                raise
            log.info("tile_unreadable", job=job.id, tile=tile.index, version=version)

    def _stored_tile(self, job: Job, tile: plan.Tile) -> tuple[np.ndarray, int]:
        version = self._store.tile_version(job.id, tile.index)
        if job.state is State.DONE:
            return self._crop(job, tile), version
        drawn = film.Film(job_plan(job))
        if version:
            self._load(drawn, job, tile, version)
        return drawn.tile_pixels(tile), drawn.tile_version(tile)

    def _crop(self, job: Job, tile: plan.Tile) -> np.ndarray:
        """A tile of a finished image, read row by row: the image may be too large to be read for each tile."""
        key = pixels_key(job.id)
        start = self._blobs.size(key) - job.width * job.height * _PIXEL_BYTES  # after the header
        starts = [
            start + ((tile.y + row) * job.width + tile.x) * _PIXEL_BYTES for row in range(tile.height)
        ]
        rows = self._blobs.ranges(key, starts, tile.width * _PIXEL_BYTES)
        return np.frombuffer(b"".join(rows), "<f4").reshape(tile.height, tile.width, 3)


_PIXEL_BYTES = 3 * 4


def _tile(job: Job, column: int, row: int) -> plan.Tile | None:
    whole = job_plan(job)
    if not (0 <= column < whole.columns and 0 <= row < whole.rows):
        return None
    return whole.tiles[row * whole.columns + column]


def metadata(job: Job) -> dict[str, str]:
    """What an EXR file says about its origin."""
    return {"Software": "Tilecast", "tilecast:job": job.id, "tilecast:name": job.name, "tilecast:scene": job.scene}
