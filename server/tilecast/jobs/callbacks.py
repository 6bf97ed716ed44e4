"""Tells the addresses that jobs named when they end. The database knows which are due, so a restart forgets none."""

import threading
import time
from collections.abc import Callable

import httpx2
import structlog

from tilecast.jobs.records import Job
from tilecast.jobs.store import Store

log = structlog.get_logger()

_PAUSES = (1.0, 5.0, 30.0, 120.0, 600.0)  # seconds between tries
_TIMEOUT = 10.0


class Callbacks:
    """Posts ended jobs, as `describe` puts them, to their addresses; at least once, or not after six failures."""

    def __init__(self, store: Store, describe: Callable[[Job], dict]):
        self._store = store
        self._describe = describe
        self._changed = threading.Condition()
        self._due: list[tuple[float, int, str]] = [(0.0, 0, job.id) for job in store.callbacks_due()]
        self._closing = False
        self._thread = threading.Thread(target=self._run, name="callbacks", daemon=True)
        self._thread.start()

    def add(self, job: str) -> None:
        self._schedule(0.0, 0, job)

    def close(self) -> None:
        with self._changed:
            self._closing = True
            self._changed.notify()
        self._thread.join(timeout=_TIMEOUT)

    def _schedule(self, pause: float, failures: int, job: str) -> None:
        with self._changed:
            self._due.append((time.monotonic() + pause, failures, job))
            self._changed.notify()

    def _run(self) -> None:
        # No redirects: an address leads where it says, and nowhere else.
        with httpx2.Client(timeout=_TIMEOUT, follow_redirects=False) as client:
            while (entry := self._next()) is not None:
                failures, name = entry
                try:
                    self._tell(client, name)
                except Exception as error:
                    self._failed(name, failures, error)

    def _next(self) -> tuple[int, str] | None:
        with self._changed:
            while not self._closing:
                now = time.monotonic()
                self._due.sort()
                if self._due and self._due[0][0] <= now:
                    _, failures, job = self._due.pop(0)
                    return failures, job
                self._changed.wait(self._due[0][0] - now if self._due else None)
        return None

    def _tell(self, client: httpx2.Client, name: str) -> None:
        job = self._store.get(name)
        if job is None or job.callback is None or not job.callback_due:
            return
        client.post(job.callback, json=self._describe(job)).raise_for_status()
        self._store.set(name, callback_due=False)

    def _failed(self, name: str, failures: int, error: Exception) -> None:
        if failures < len(_PAUSES):
            self._schedule(_PAUSES[failures], failures + 1, name)
            return
        log.warning("callback_given_up", job=name, error=str(error))
        self._store.set(name, callback_due=False)
