"""Where chunks run: Dask. A cluster of our own on this machine by default, or a running one by its address.

Our own is one worker process, with a thread a core, under a nanny that starts it anew when it dies; it listens on the
loopback interface alone. Dask runs whatever it is sent: only trusted users may reach a scheduler.

`Engine` is a `concurrent.futures.Executor`. What the dispatcher has to know is simple: a future ends with a result, with
what the function raised, or with `KilledWorker` where the worker process died. A lost connection is no failure: what was
under way is sent again when it is back.
"""

import asyncio
import os
import threading
from collections.abc import Callable
from concurrent.futures import CancelledError, Executor, Future
from pathlib import Path
from time import monotonic

import dask
import structlog
from distributed import Client, KilledWorker, LocalCluster, Nanny, Status
from distributed.comm import CommClosedError
from distributed.scheduler import DEFAULT_EXTENSIONS

from tilecast.jobs.faults import CannotStart

__all__ = ["Engine", "KilledWorker"]

log = structlog.get_logger()

_WATCH_SECONDS = 1.0
_CONNECT_SECONDS = 10.0
_RESTART_SECONDS = 30.0
_LOCAL_SETTINGS = {
    # The dispatcher decides what becomes of the victims of a dead worker, and hears of it at once.
    "distributed.scheduler.allowed-failures": 0,
    # Compiled scenes cannot be spilled, and a worker that pauses for its memory would never go on.
    "distributed.worker.memory.target": False,
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.pause": False,
    "distributed.worker.memory.terminate": 0.95,
    # The nanny is at work when a worker is lost, however long it takes: a cluster that loses patience would close it.
    "distributed.deploy.lost-worker-timeout": "365 days",
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.tick.limit": "30s",
    # Nothing is to be seen over HTTP.
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
}
_PRELOAD = "tilecast.jobs.worker"
_GIVEN_UP = (Status.closing, Status.closed, Status.failed)


class Engine(Executor):
    """Runs functions on the workers of a Dask cluster."""

    def __init__(self, scheduler: str | None, threads: int | None, folder: Path, stuck_seconds: float):
        """Start a cluster with `threads` threads (default: a thread a core), or connect to the one at `scheduler`.

        `folder` is for Dask's scratch files; `stuck_seconds`: how long a task may go on that nobody needs. Raises
        `CannotStart` where the scheduler does not answer.
        """
        self.on_slots: Callable[[int], None] = lambda slots: None
        """Called, on a thread of the engine's, when workers came or went."""
        self.workers: dict[str, int] = {}
        """The workers that were up a second ago: address -> threads."""
        self._address = scheduler
        self._threads = threads or len(os.sched_getaffinity(0))
        self._folder = folder
        self._lock = threading.Lock()
        self._waiting: list[Callable[[], None]] = []  # sent again when there is a connection
        self._under_way: set[_Outcome] = set()
        self._stuck_seconds = stuck_seconds
        self._not_restarted: set[str] = set()  # workers without a nanny, told of once
        self._closing = threading.Event()
        self._cluster = self._start_cluster() if scheduler is None else None
        try:
            self._client = self._connect()
            self.workers = self._client.nthreads()
        except (OSError, ValueError) as error:
            raise CannotStart(f"cannot reach the scheduler {scheduler}: {error}") from None
        self._watch = threading.Thread(target=self._watch_cluster, name="engine-watch", daemon=True)
        self._watch.start()

    def submit(
        self, function, /, *args, priority: int = 0, needed: Callable[[], bool] = lambda: True, **kwargs
    ) -> Future:
        """Run `function` on a worker. A higher `priority` overtakes what waits in the cluster.

        Where it still runs long after `needed` became false, its worker is restarted: a task that never ends, as where a
        ray meets 2^40 surfaces, cannot be interrupted."""
        outer = _Outcome(needed)
        self._under_way.add(outer)
        outer.add_done_callback(self._under_way.discard)

        def send() -> None:
            try:
                task = self._client.submit(function, *args, pure=False, priority=priority, **kwargs)
                # Not through client.get_executor(): where a result is lost with its worker before it was read, and the
                # task then fails, the future that it gives never ends. The coroutine lets go of `task` when it is
                # done: what is held would be computed again when its worker dies.
                outcome = asyncio.run_coroutine_threadsafe(task._result(), self._client.loop.asyncio_loop)
                outer.key = task.key
            except Exception:
                # The client was closed under our feet; the watch makes another one.
                log.warning("engine_unreachable", exc_info=True)
                self._send_later(send)
            else:
                outcome.add_done_callback(settle)

        def settle(outcome: Future) -> None:
            try:
                error = outcome.exception()
            except CancelledError:
                error = CancelledError()
            # The last: the scheduler, or the worker that had the result, was lost while it was fetched.
            if isinstance(error, (CancelledError, asyncio.CancelledError, CommClosedError)):
                self._send_later(send)
            elif outer.set_running_or_notify_cancel():
                if error is None:
                    outer.set_result(outcome.result())
                else:
                    outer.set_exception(error)

        send()
        return outer

    def slots(self) -> int:
        """How many tasks can run at once; of our own cluster: once its worker is up."""
        return self._threads if self._cluster else max(1, sum(self.workers.values()))

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Stop. Our own cluster ends with its worker process; what was under way is lost."""
        if self._closing.is_set():
            return
        self._closing.set()
        self._watch.join()
        self._client.close(timeout=5)
        if self._cluster is not None:
            self._cluster.close(timeout=10)

    def _send_later(self, send: Callable[[], None]) -> None:
        if not self._closing.is_set():
            with self._lock:
                self._waiting.append(send)

    def _start_cluster(self) -> LocalCluster:
        dask.config.set(_LOCAL_SETTINGS)
        preload = [_PRELOAD, *dask.config.get("distributed.worker.preload", [])]
        return LocalCluster(
            n_workers=1,
            threads_per_worker=self._threads,
            worker_class=Nanny,
            host="127.0.0.1",
            dashboard_address=None,
            scheduler_kwargs={"dashboard_address": "127.0.0.1:0",  # a port that somebody may hold, otherwise
                              "extensions": DEFAULT_EXTENSIONS | {"spans": _NoSpans}},
            local_directory=str(self._folder),
            preload=preload,
            preload_argv=[[] for _ in preload],
        )

    def _connect(self) -> Client:
        address = self._cluster or self._address
        client = Client(address, set_as_default=False, name="tilecast", timeout=_CONNECT_SECONDS)
        if self._cluster is None:
            allowed = client.run_on_scheduler(_allowed_failures)
            if allowed != 0:
                log.warning(
                    "scheduler_repeats_crashes",
                    allowed_failures=allowed,
                    advice="start the scheduler with DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES=0, "
                    "so that a scene that crashes its worker is found out at once",
                )
        return client

    def _watch_cluster(self) -> None:
        while not self._closing.wait(_WATCH_SECONDS):
            try:
                self._look_after()
            except Exception:
                self.workers = {}
                log.warning("engine_watch_failed", exc_info=True)

    def _look_after(self) -> None:
        """Connect again and send what a lost connection left behind; raise a new nanny where the old one gave up, as it
        does when its worker dies while it starts."""
        if self._client.status in ("closed", "closing"):
            self._client = self._connect()
        if self._client.status == "running":
            slots = self.slots()
            self.workers = self._client.nthreads()
            if self.slots() != slots:
                self.on_slots(self.slots())
            with self._lock:
                waiting, self._waiting = self._waiting, []
            for send in waiting:
                send()
            self._free_threads()
        else:
            self.workers = {}
        if self._cluster is not None:
            nannies = list(self._cluster.workers.values())
            if all(nanny.status in _GIVEN_UP for nanny in nannies):
                log.warning("nanny_replaced")
                self._cluster.scale(0)
                self._cluster.scale(1)


    def _free_threads(self) -> None:
        """Restart workers that have a thread at what nobody needs any more. Their other tasks end with `KilledWorker`."""
        now = monotonic()
        overdue = set()
        for outcome in list(self._under_way):
            if outcome.needed():
                outcome.unneeded_since = None
                continue
            outcome.unneeded_since = outcome.unneeded_since or now
            if now - outcome.unneeded_since > self._stuck_seconds:
                overdue.add(outcome.key)
        if not overdue:
            return
        found = self._client.run_on_scheduler(_workers_at, overdue)
        for worker in (worker for worker, nanny in found.items() if not nanny and worker not in self._not_restarted):
            self._not_restarted.add(worker)
            log.warning("worker_stuck", worker=worker, advice="start workers under a nanny, which can restart them")
        if stuck := [worker for worker, nanny in found.items() if nanny]:
            log.warning("worker_restarted", workers=stuck, reason="it was at chunks that nobody needs and that do not end")
            self._client.restart_workers(stuck, timeout=_RESTART_SECONDS, raise_for_error=False)


class _Outcome(Future):
    """What becomes of a task, for who submitted it."""

    def __init__(self, needed: Callable[[], bool]):
        super().__init__()
        self.needed = needed
        self.unneeded_since: float | None = None  # time.monotonic
        self.key: str | None = None  # of the task, as Dask knows it


class _NoSpans:
    """In the place of the scheduler's extension that keeps a span of each time that it had work, for ever."""

    def __init__(self, _scheduler: object):
        pass

    def __bool__(self) -> bool:
        return False  # it observes no tasks

    def heartbeat(self, _worker: object, _data: object) -> None:
        pass


def _workers_at(keys: set[str], dask_scheduler) -> dict[str, bool]:
    """The workers that have a thread at one of these tasks, by address; whether each has a nanny."""
    workers = dask_scheduler.workers.values()
    return {worker.address: worker.nanny is not None for worker in workers
            if any(task.key in keys for task in worker.executing)}


def _allowed_failures(dask_scheduler) -> int:
    return dask_scheduler.allowed_failures
