"""What the camera of a job sees first, for its EXR: made when somebody asks for that, on the workers, and kept."""

import threading
from concurrent.futures import Executor, Future, InvalidStateError, TimeoutError
from contextlib import suppress

import numpy as np
import structlog

from tilecast.jobs import worker
from tilecast.jobs.blobs import Blobs, first_hits_key
from tilecast.jobs.faults import Fault, NoSuchJob, NotYet
from tilecast.jobs.records import Job
from tilecast.jobs.store import Store
from tilecast.render.dispatch import Dispatcher
from tilecast.render.plan import Tile, make_plan

log = structlog.get_logger()

_PRIORITY = 2**31  # ahead of everything: somebody waits for the answer
_PATIENCE = 60.0  # seconds


class _Work:
    """A work of the dispatcher with a task for each tile. `hits` is its outcome: float32 [height, width, 7]."""

    priority = _PRIORITY

    def __init__(self, job: Job, blobs_url: str, max_triangles: int):
        self.key = f"first-hits-{job.id}"
        self.owner = job.owner
        self.hits: Future[np.ndarray] = Future()
        self._scene = (blobs_url, job.scene, max_triangles)
        self._tiles = list(make_plan(job.width, job.height, 1).tiles)
        self._parts: list[tuple[Tile, np.ndarray]] = []
        self._size = job.height, job.width

    def next(self) -> Tile | None:
        return self._tiles.pop() if self._tiles else None

    def submit(self, executor: Executor, tile: Tile) -> Future:
        return executor.submit(worker.first_hits, *self._scene, tile, priority=1, needed=lambda: not self.hits.done())

    def done(self, tile: Tile, result: np.ndarray) -> None:
        self._parts.append((tile, result))

    def failed(self, _tile: Tile | None, error: BaseException) -> None:
        self._tiles.clear()
        with suppress(InvalidStateError):  # it is over already
            self.hits.set_exception(error)

    @property
    def tiles_made(self) -> int:
        return len(self._parts)

    def finished(self) -> None:
        if self.hits.done():
            return
        whole = np.empty((*self._size, self._parts[0][1].shape[2]), np.float32)
        for tile, part in self._parts:
            whole[tile.window] = part
        with suppress(InvalidStateError):
            self.hits.set_result(whole)


class FirstHits:
    """Finds them, or makes them through `dispatcher`, for as long as `store` knows the job."""

    def __init__(self, store: Store, blobs: Blobs, dispatcher: Dispatcher, max_triangles: int):
        self._store = store
        self._blobs = blobs
        self._dispatcher = dispatcher
        self._max_triangles = max_triangles
        self._lock = threading.Lock()
        self._under_way: dict[str, _Work] = {}

    def get(self, job: Job) -> np.ndarray | None:
        """float32 [height, width, 7]; None where they cannot be had. Raises `NotYet` where that takes long, and `NoSuchJob`
        where the job is deleted meanwhile."""
        try:
            return self._blobs.get_array(first_hits_key(job.id))
        except FileNotFoundError:
            pass
        with self._lock:
            work = self._under_way.get(job.id)
            if work is None:
                work = self._under_way[job.id] = _Work(job, self._blobs.url, self._max_triangles)
                work.hits.add_done_callback(lambda hits: self._keep(job, hits))
                self._dispatcher.add(work)
        before = work.tiles_made
        try:
            return work.hits.result(_PATIENCE)
        except TimeoutError:
            if work.tiles_made == before:
                self._end(work, NotYet("It takes too long to find what the camera sees."))
            raise NotYet("The layers of this EXR are still being made; ask for it again.") from None
        except NoSuchJob:
            raise
        except worker.Rejected as error:
            log.warning("first_hits_rejected", job=job.id, reason=repr(error))
            return None
        except Exception as error:  # a worker that died, a scheduler that went away
            log.warning("first_hits_failed", job=job.id, reason=repr(error))
            raise NotYet("The layers of this EXR could not be made just now; ask for it again.") from None

    def drop(self, job: str) -> None:
        """Make no more of them for a job that is deleted."""
        with self._lock:
            work = self._under_way.get(job)
        if work is not None:
            self._end(work, NoSuchJob("The job was deleted while its picture was made."))

    def _end(self, work: _Work, reason: Fault) -> None:
        self._dispatcher.remove(work.key)
        work.failed(None, reason)

    def _keep(self, job: Job, hits: Future[np.ndarray]) -> None:
        with self._lock:
            self._under_way.pop(job.id, None)
        if hits.exception() is None:
            self._blobs.put_array(first_hits_key(job.id), hits.result(), durable=False)
            if self._store.get(job.id) is None:  # deleted, perhaps before there was anything to delete
                self._blobs.delete(first_hits_key(job.id))
