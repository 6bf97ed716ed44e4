"""One job in the dispatcher: hands its chunks out, takes their results, and knows what to do when a worker dies.

Three threads meet here. The dispatcher's calls `next`, `submit`, `done`, `failed` and `finished`. The journal's calls
`save` and `finalize`. The API's read pixels, and `settle` and `close` the work when the job is paused or cancelled. The
film is loaded when the first chunk is asked for, so that a long queue costs no memory.

When a worker dies, everything that it had is lost, and one of it is to blame. Each lost chunk is handed out again alone
(`exclusive`): the one that kills a worker then is guilty beyond doubt, and the others are cleared.
"""

import threading
from collections import deque
from concurrent.futures import BrokenExecutor, Executor, Future
from functools import lru_cache
from time import perf_counter
from typing import Any

import numpy as np
import structlog

from tilecast.jobs import state, worker
from tilecast.jobs.blobs import Blobs, pixels_key, thumbnail_key, tile_key, variance_key
from tilecast.jobs.engine import KilledWorker
from tilecast.jobs.records import Job, TileRow
from tilecast.jobs.store import Store
from tilecast.jobs.task import Listener, Task, finite
from tilecast.render.display import shown
from tilecast.render.film import as_float32
from tilecast.render.output import thumbnail
from tilecast.render.plan import Plan, Tile, make_plan
from tilecast.render.rendering import ChunkResult, Rendering
from tilecast.scene.schema import Stop

log = structlog.get_logger()

_SAVED_AT_ONCE = 64  # tiles
_TASK_SECONDS = 0.15  # that a task is meant to take: many chunks are far shorter than the way to a worker and back


def job_plan(job: Job) -> Plan:
    """The plan of a job, which never changes."""
    return _plan(job.width, job.height, job.samples, job.tile_size)


_plan = lru_cache(maxsize=64)(make_plan)


class JobWork:
    """A job as the dispatcher's protocol wants it; see the module."""

    def __init__(self, job: Job, store: Store, blobs: Blobs, max_triangles: int, listener: Listener):
        self.key = job.id
        self.owner = job.owner
        self.priority = job.priority
        self._job = job
        self._store = store
        self._blobs = blobs
        self._max_triangles = max_triangles
        self._listener = listener

        self._saving = threading.Lock()  # held while something is stored; taken before `_lock`
        self._lock = threading.Lock()  # guards what follows
        self._closed = False
        self._settled = False  # takes no more results
        self._complete = False  # every sample is in
        self._status = state.Status(state.State.RUNNING)
        self._rendering: Rendering | None = None
        self._facts: dict[str, Any] | None = job.facts
        self._prepared = job.facts is not None
        self._suspects: deque[Task] = deque()  # were in flight when a worker died
        self._on_trial = 0  # suspects in flight
        self._dirty: set[int] = set()  # tiles that are further than what is stored
        self._points: list[dict] = []  # of the error curve, not yet stored

    # --- The dispatcher's side

    def next(self) -> Task | None:
        with self._lock:
            if self._settled or self._status.state.final:
                return None
            if self._rendering is None:
                self._load()
                self._listener.happened(self, state.Started())
            if self._status.crashes:
                return self._next_suspect()
            if not self._prepared:
                self._prepared = True
                return Task()
            if self._facts is None:  # being compiled
                return None
            chunks = self._rendering.next_chunks(_TASK_SECONDS)
            return Task(chunks) if chunks else None

    def _next_suspect(self) -> Task | None:
        # Nothing else of a job under suspicion is handed out: it could cost others their chunks again.
        if not self._suspects:
            return None
        self._on_trial += 1
        return Task(self._suspects.popleft().chunks, exclusive=True)

    def submit(self, executor: Executor, task: Task) -> Future:
        scene = (self._blobs.url, self._job.scene, self._max_triangles)
        if not task.chunks:
            return executor.submit(worker.prepare, *scene, needed=self._is_needed)
        return executor.submit(worker.render, *scene, task.chunks, needed=self._is_needed)

    def _is_needed(self) -> bool:
        return not self._settled

    def done(self, task: Task, result: list[ChunkResult] | dict[str, Any]) -> None:
        with self._lock:
            if self._settled:
                return
            if task.exclusive:
                self._acquit()
            if not task.chunks:
                self._facts = result
                return
            for chunk, part in zip(task.chunks, result, strict=True):
                self._take(self._rendering.add(chunk, part))
        for part in result:
            self._listener.counted(part)
        self._listener.news(self)

    def _acquit(self) -> None:
        self._on_trial -= 1
        if self._status.crashes and not self._suspects and not self._on_trial:
            self._happened(state.Cleared())

    def failed(self, task: Task | None, error: BaseException) -> None:
        if task is not None and isinstance(error, (KilledWorker, BrokenExecutor)):
            self._listener.counted(None)
            with self._lock:
                self._on_trial -= task.exclusive
                self._suspects.append(task)
                self._happened(state.Crashed(alone=task.exclusive))
            return
        if isinstance(error, worker.Rejected):
            path, message = error.errors[0]
        else:
            path, message = "", f"the chunk could not be rendered: {type(error).__name__}: {error}"
            log.error("task_failed", job=self.key, exc_info=error)
        with self._lock:
            self._happened(state.Failed(path, message))

    def _happened(self, event: state.Event) -> None:
        # The journal will come to the same status. It is needed here at once: who is through gets no more chunks.
        if not self._status.state.final:
            self._status, _ = state.transition(self._status, event)
            self._listener.happened(self, event)

    def finished(self) -> None:
        with self._lock:
            if self._settled or self._status.state.final:
                return
            if not self._rendering.finished:
                self._happened(state.Failed("", "the rendering came to a halt before its end"))
                return
            self._complete = True
        self._listener.news(self)

    def _load(self) -> None:
        """Take up what is stored."""
        plan = job_plan(self._job)
        rows = self._store.tiles(self.key)
        stored = {}
        for row in rows:
            try:
                stored[row.index] = self._blobs.get(tile_key(self.key, row.index, row.version))
            except FileNotFoundError:
                log.warning("tile_missing", job=self.key, tile=row.index)
        curve = self._store.curve(self.key)
        rendering = Rendering(plan, Stop.model_validate(self._job.stop), adaptive=bool(self._job.adaptive))
        events = rendering.restore(stored, self._job.seconds, curve)
        film = rendering.film
        lost = [row.index for row in rows if film.tile_version(plan.tiles[row.index]) != row.version]
        if lost:
            log.warning("tiles_lost", job=self.key, tiles=lost)
            self._store.forget_tiles(self.key, lost, points_kept=len(rendering.curve) - len(events))
        self._rendering = rendering
        self._take(events)

    def _take(self, events: list[dict[str, Any]]) -> None:
        columns = self._rendering.plan.columns
        for event in events:
            if event["type"] == "tile":
                self._dirty.add(event["row"] * columns + event["column"])
            else:
                self._points.append(finite({key: value for key, value in event.items() if key != "type"}))

    # --- The journal's side

    def save(self) -> bool:
        """Store what is not stored yet; whether the image is complete and waits for `finalize`."""
        with self._saving:
            while self._save_some():
                pass
            return self._complete and not self._closed

    def _save_some(self) -> bool:
        with self._lock:
            if self._closed or not (self._dirty or self._points):
                return False
            film, plan = self._rendering.film, self._rendering.plan
            indices = sorted(self._dirty)[:_SAVED_AT_ONCE]
            tiles = [plan.tiles[index] for index in indices]
            rows = [
                TileRow(tile.index, film.tile_version(tile), film.tile_samples(tile), relative_mse=film.tile_error(tile))
                for tile in tiles
            ]
            data = [film.save_tile(tile) for tile in tiles]
            points, self._points = self._points, []
            self._dirty.difference_update(indices)
            values = self._columns(with_statistics=bool(points))
        try:
            for row, content in zip(rows, data):
                # Not forced to the disk: a tile that a power cut damages is rendered again, to the same bits.
                self._blobs.put(tile_key(self.key, row.index, row.version), content, durable=False)
            before = self._store.save_progress(self.key, rows, points, **values)
        except BaseException:
            with self._lock:
                self._dirty.update(indices)
                self._points[:0] = points
            raise
        if before is not None:
            old = [tile_key(self.key, row.index, version) for row, version in zip(rows, before)
                   if version not in (0, row.version)]
            self._blobs.delete(*old)
        return True

    def _columns(self, with_statistics: bool, write: float = 0.0) -> dict[str, Any]:
        """How the job stands, as columns of its row."""
        rendering = self._rendering
        values = {
            "progress": rendering.progress,
            "seconds": rendering.seconds,
            "seconds_left": rendering.seconds_left,
            "facts": self._facts,
        }
        if rendering.curve:
            values["relative_mse"] = rendering.curve[-1]["relative_mse"]
        if with_statistics:
            values["statistics"] = rendering.statistics(self._facts, write)
        return finite(values)

    def finalize(self) -> dict[str, Any] | None:
        """Store the finished image; the columns of the job's row that go with it, or None where it was closed."""
        pixels, variance = self.pixels(), self.variance()
        if pixels is None or variance is None:
            return None
        start = perf_counter()
        for key, image in ((pixels_key(self.key), pixels), (variance_key(self.key), variance)):
            self._blobs.put_array(key, as_float32(image).astype("<f4", copy=False))
        self._blobs.put(thumbnail_key(self.key), thumbnail(shown(pixels, self._facts)))
        with self._lock:
            return None if self._closed else self._columns(with_statistics=True, write=perf_counter() - start)

    # --- Anybody's side

    def settle(self) -> None:
        """Take nothing more, and store all that came in: the job is about to be paused or given up, or the server to
        stop. The image is still there to be seen."""
        with self._lock:
            self._settled = True
        try:
            self.save()
            with self._lock:
                begun = self._rendering is not None and not self._closed
                values = self._columns(with_statistics=True) if begun else None
            if values:
                self._store.set(self.key, **values)
        except Exception:
            log.warning("last_tiles_not_stored", job=self.key, exc_info=True)  # they will be rendered again

    def close(self) -> None:
        """Take and store nothing more, and let go of the image."""
        with self._saving, self._lock:
            self._settled = self._closed = True
            self._rendering = None

    @property
    def facts(self) -> dict[str, Any] | None:
        """Of the scene; None before it is compiled."""
        return self._facts

    def statistics(self) -> dict[str, Any] | None:
        """As they stand; None before anything was loaded."""
        with self._lock:
            return finite(self._rendering.statistics(self._facts)) if self._rendering else None

    def pixels(self) -> np.ndarray | None:
        """float32 [height, width, 3] as it stands; None before anything was loaded."""
        rendering = self._rendering
        return rendering.film.pixels() if rendering else None

    def variance(self) -> np.ndarray | None:
        """Of the pixels, float32 [height, width, 3]; None before anything was loaded."""
        rendering = self._rendering
        return rendering.film.variance() if rendering else None

    def tile(self, tile: Tile) -> tuple[np.ndarray, int] | None:
        """A tile's pixels, float32 [height, width, 3], and its version; None before anything was loaded."""
        rendering = self._rendering
        if rendering is None:
            return None
        # In this order: the pixels may be newer than the version says, never older.
        version = rendering.film.tile_version(tile)
        return rendering.film.tile_pixels(tile), version
