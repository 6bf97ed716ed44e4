"""The service without HTTP: takes scenes in, sees their jobs through, and answers for them.

`Manager` is the shell around the state machine: it commits what the machine decides, then does what it commands. Its
methods may be called from any thread, but not from an event loop: they wait for the database.
"""

import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import structlog
from obstore.exceptions import BaseError

from tilecast.jobs import blobs as keys
from tilecast.jobs import state
from tilecast.jobs.blobs import Blobs
from tilecast.jobs.callbacks import Callbacks
from tilecast.jobs.engine import Engine
from tilecast.jobs.faults import NoSuchJob, Refused
from tilecast.jobs.first_hits import FirstHits
from tilecast.jobs.folder import lock_folder
from tilecast.jobs.hub import Hub
from tilecast.jobs.images import Images
from tilecast.jobs.intake import Intake, Order
from tilecast.jobs.journal import Journal
from tilecast.jobs.records import Job, Occurrence
from tilecast.jobs.settings import Settings
from tilecast.jobs.state import Command, State
from tilecast.jobs.store import Store
from tilecast.jobs.sweep import claim, sweep
from tilecast.jobs.work import JobWork, job_plan
from tilecast.render.dispatch import Dispatcher
from tilecast.render.plan import Tile
from tilecast.render.rendering import ChunkResult

log = structlog.get_logger()

__all__ = ["Manager", "Order"]


def _summary(job: Job) -> dict[str, Any]:
    return {"id": job.id, "name": job.name, "state": job.state}


class Manager:
    """Everything that runs, from the opening of the data folder to `close`."""

    def __init__(self, settings: Settings, describe: Callable[[Job], dict[str, Any]] = _summary):
        """Start, and go on with the jobs that the store knows. `describe`: a job as its callback is told.

        Raises `CannotStart`, or `OSError` where the data folder cannot be used.
        """
        self.settings = settings
        self.hub = Hub()
        self.counters: Counter[str] = Counter(chunks=0, rays=0, crashes=0, seconds=0)
        self._works: dict[str, JobWork] = {}
        self._locks = [threading.RLock() for _ in range(64)]  # by job: a transition and its commands are one
        self._closers: list[Callable[[], None]] = []
        try:
            self._start(describe)
        except BaseException:
            self.close()
            raise

    def _start(self, describe: Callable[[Job], dict[str, Any]]) -> None:
        settings = self.settings
        self._closers.append(lock_folder(settings.data).close)
        self.store = Store(settings.database_url)
        self._closers.append(self.store.close)
        self.blobs = Blobs(settings.blobs_url)
        try:
            claim(self.store, self.blobs)
            sweep(self.store, self.blobs)
        except BaseError as error:
            raise keys.cannot_keep(settings.blobs_url, error) from None
        self.engine = Engine(settings.scheduler, settings.threads, settings.data / "engine", settings.stuck_seconds)
        self._closers.append(self.engine.shutdown)
        self.callbacks = Callbacks(self.store, describe)
        self._closers.append(self.callbacks.close)
        self._journal = Journal()
        self._closers.append(self._journal.close)
        self._closers.append(self._close_works)
        self._dispatcher = Dispatcher(self.engine, self.engine.slots())
        self.engine.on_slots = self._dispatcher.set_slots
        self._closers.append(self._dispatcher.close)
        self._first_hits = FirstHits(self.store, self.blobs, self._dispatcher, settings.max_triangles)
        self.images = Images(self.store, self.blobs, self._works.get, self._first_hits)
        self._intake = Intake(settings, self.store, self.blobs, self._dispatcher)
        for job in self.store.with_states([State.QUEUED, State.RUNNING]):
            self._apply(job.id, state.Recovered())

    def close(self) -> None:
        """Stop, in the opposite order. What was rendered is stored; what was under way is rendered again next time."""
        self.hub.close()
        while self._closers:
            try:
                self._closers.pop()()
            except Exception:
                log.exception("closing_failed")

    def _close_works(self) -> None:
        for work in list(self._works.values()):
            work.settle()
            work.close()

    # --- What users do

    def submit(self, document: bytes | dict[str, Any], order: Order, body: bytes) -> tuple[Job, bool]:
        """Queue a scene. Returns its job, committed, and whether it is new. Raises `Fault`s."""
        job, new = self._intake.take(document, order, body)
        if new:
            with self._lock(job.id):
                # It is in the list since its commit: somebody may have been quicker with it than we are here.
                now = self.store.get(job.id)
                if now is not None and now.state is State.QUEUED and job.id not in self._works:
                    self._enqueue(now)
        return job, new

    def job(self, job_id: str) -> Job:
        """Raises `NoSuchJob`."""
        job = self.store.get(job_id)
        if job is None:
            raise NoSuchJob(f"There is no job {job_id[:64]!r}; it may have been deleted.")
        return job

    @contextmanager
    def held(self, job_id: str) -> Iterator[Job]:
        """The job as it stands, while no other user changes it. Raises `NoSuchJob`."""
        with self._lock(job_id):
            yield self.job(job_id)

    def pause(self, job_id: str) -> Job:
        return self._apply(job_id, state.Paused())

    def resume(self, job_id: str) -> Job:
        return self._apply(job_id, state.Resumed())

    def cancel(self, job_id: str) -> Job:
        return self._apply(job_id, state.Cancelled())

    def retry(self, job_id: str) -> Job:
        return self._apply(job_id, state.Retried())

    def set_priority(self, job_id: str, priority: int) -> Job:
        with self._lock(job_id):
            job = self.job(job_id)
            if job.state.final:
                raise Refused(f"the job has ended ({job.state}): its priority no longer matters")
            changed = self._commit(job, job.status, priority=priority)
            if (work := self._works.get(job_id)) is not None:
                work.priority = priority
                self._dispatcher.set_priority(job_id, priority)
            return changed

    def cancel_or_delete(self, job_id: str) -> Job | None:
        """Cancel a job that has not ended; delete one that has, and return None."""
        with self._lock(job_id):
            job = self.job(job_id)
            if not job.state.final:
                return self.cancel(job_id)
            self.store.delete(job_id)
            self._first_hits.drop(job_id)
            self.blobs.delete_all(keys.job_prefix(job_id))
            self._intake.release(job.scene)
        self.hub.notify(job_id)
        return None

    # --- What users see

    def since(self, job_id: str, event: int) -> list[Occurrence] | None:
        """What happened to a job after `event`, as events are told; None where the job is gone."""
        found = self.store.since(job_id, event)
        if not found or all(occurrence.type != "tile" for occurrence in found):
            return found
        job = self.store.get(job_id)
        if job is None:
            return None
        tiles = job_plan(job).tiles
        return [
            Occurrence(entry.event, entry.type, _tile_data(tiles[entry.data["index"]], **entry.data))
            if entry.type == "tile"
            else entry
            for entry in found
        ]

    def has_ended(self, job_id: str, event: int) -> bool:
        """Whether nothing will happen to a job after `event`, unless somebody retries it."""
        job = self.store.get(job_id)
        return job is None or (job.state.final and event >= job.event)

    def tiles(self, job_id: str) -> dict[str, Any]:
        """Sizes and versions of all tiles, for users."""
        job = self.job(job_id)
        plan = job_plan(job)
        known = {row.index: row for row in self.store.tiles(job_id)}
        listed = []
        for tile in plan.tiles:
            row = known.get(tile.index)
            listed.append(_tile_data(tile, row.version, row.samples, row.relative_mse) if row
                          else _tile_data(tile, 0, 0, None))
        return {"columns": plan.columns, "rows": plan.rows, "size": plan.tile_size, "tiles": listed}

    def statistics(self, job_id: str) -> dict[str, Any]:
        """As `--stats` writes them; of a job that was never begun, what its scene told."""
        job = self.job(job_id)
        work = self._works.get(job_id)
        return (work and work.statistics()) or job.statistics or job.facts or {}

    # --- What works tell (`work.Listener`)

    def happened(self, work: JobWork, event: state.Event) -> None:
        self._journal.enter(lambda: self._record(work, event))

    def news(self, work: JobWork) -> None:
        self._journal.enter(lambda: self._advance(work), key=work)

    def counted(self, result: ChunkResult | None) -> None:
        if result is None:
            self.counters["crashes"] += 1
        else:
            self.counters.update(chunks=1, rays=sum(result.rays), seconds=result.seconds)

    def _advance(self, work: JobWork) -> None:
        """Store what came in; finish the job when it is complete."""
        complete = work.save()
        self.hub.notify(work.key)
        if complete and (values := work.finalize()) is not None:
            self._record(work, state.Finished(), **values)

    def _record(self, work: JobWork, event: state.Event, **values: Any) -> None:
        """Apply what happened by itself: a user may have been quicker, and that is no error."""
        with self._lock(work.key):
            if self._works.get(work.key) is not work:
                return  # it was withdrawn
            try:
                self._apply(work.key, event, **values)
            except (Refused, NoSuchJob) as refusal:
                log.info("came_too_late", job=work.key, event=type(event).__name__, reason=str(refusal))

    # --- The shell around the state machine

    def _lock(self, job_id: str) -> threading.RLock:
        return self._locks[hash(job_id) % len(self._locks)]

    def _apply(self, job_id: str, event: state.Event, **values: Any) -> Job:
        """Commit what `event` makes of a job, then carry out the commands."""
        with self._lock(job_id):
            job = self.job(job_id)
            try:
                status, commands = state.transition(job.status, event)
            except state.Refused as refusal:
                raise Refused(str(refusal)) from None
            work = self._works.get(job_id) if Command.WITHDRAW in commands else None
            if work is not None:
                # Before the commit: no event of a job comes after its final state.
                self._dispatcher.remove(job_id)
                work.settle()
            try:
                if status != job.status:
                    job = self._commit(job, status, **values)
            except BaseException:
                if work is not None:
                    self._drop(job_id)
                    self._enqueue(job)
                raise
            for command in commands:
                self._carry_out(command, job)
            return job

    def _commit(self, job: Job, status: state.Status, **values: Any) -> Job:
        if status.state is State.RUNNING and job.started is None:
            values["started"] = time.time()
        if status.state.final and not job.state.final:
            values |= {"finished": time.time(), "callback_due": job.callback is not None}
        if job.state.final and not status.state.final:
            values["finished"] = None
        error = {"path": status.error_path or "", "message": status.error_message} if status.error_message else None
        data = {"state": status.state, "priority": values.get("priority", job.priority), "error": error}
        changed = self.store.change(job, status, data, **values)
        if changed is None:
            raise RuntimeError(f"job {job.id} was changed by somebody else: does another server use this database?")
        log.info("job", job=job.id, **{key: value for key, value in data.items() if value is not None})
        self.hub.notify(job.id)
        return changed

    def _carry_out(self, command: Command, job: Job) -> None:
        match command:
            case Command.ENQUEUE:
                self._enqueue(job)
            case Command.WITHDRAW:
                self._drop(job.id)
            case Command.CLEAN:
                self._drop(job.id)
                self.blobs.delete_all(f"{keys.job_prefix(job.id)}/tiles")
            case Command.CALL_BACK:
                if job.callback is not None:
                    self.callbacks.add(job.id)

    def _enqueue(self, job: Job) -> None:
        work = JobWork(job, self.store, self.blobs, self.settings.max_triangles, listener=self)
        self._works[job.id] = work
        self._dispatcher.add(work)

    def _drop(self, job_id: str) -> None:
        work = self._works.get(job_id)
        if work is not None:
            self._dispatcher.remove(job_id)
            work.close()
            del self._works[job_id]


def _tile_data(
    tile: Tile, version: int, samples: int, relative_mse: float | None, index: int | None = None
) -> dict[str, Any]:
    return {
        "column": tile.column,
        "row": tile.row,
        "x": tile.x,
        "y": tile.y,
        "width": tile.width,
        "height": tile.height,
        "version": version,
        "samples": samples,
        "relative_mse": relative_mse,
    }
