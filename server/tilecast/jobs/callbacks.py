"""Tells the addresses that jobs named when they end. The database knows which are due, so a restart forgets none."""

import asyncio
import threading
from collections.abc import Callable
from contextlib import suppress

import httpx2
import structlog

from tilecast.jobs.records import Job
from tilecast.jobs.store import Store

log = structlog.get_logger()

_PAUSES = (1.0, 5.0, 30.0, 120.0, 600.0)  # seconds between tries
_TIMEOUT = 10.0  # seconds, for an address to take a call
_AT_ONCE = 16  # calls


class Callbacks:
    """Posts ended jobs, as `describe` puts them, to their addresses; at least once, or not after six failures. An
    address that is slow holds up no other."""

    def __init__(self, store: Store, describe: Callable[[Job], dict]):
        self._store = store
        self._describe = describe
        self._loop = asyncio.new_event_loop()
        self._closing = asyncio.Event()
        self._calls: dict[str, asyncio.Task] = {}  # the last of each job
        self._slots = asyncio.Semaphore(_AT_ONCE)
        # No redirects: an address leads where it says, and nowhere else.
        self._client = httpx2.AsyncClient(timeout=_TIMEOUT, follow_redirects=False)
        due = store.callbacks_due()
        self._thread = threading.Thread(target=self._run, name="callbacks", daemon=True)
        self._thread.start()
        for job in due:
            self.add(job.id)

    def add(self, job: str) -> None:
        with suppress(RuntimeError):  # closed: the database remembers
            self._loop.call_soon_threadsafe(self._begin, job)

    def close(self) -> None:
        self._loop.call_soon_threadsafe(self._closing.set)
        self._thread.join()

    def _run(self) -> None:
        with asyncio.Runner(loop_factory=lambda: self._loop) as runner:
            runner.run(self._until_closed())

    async def _until_closed(self) -> None:
        await self._closing.wait()
        calls = asyncio.all_tasks() - {asyncio.current_task()}
        for call in calls:
            call.cancel()
        await asyncio.gather(*calls, return_exceptions=True)
        await self._client.aclose()

    def _begin(self, name: str) -> None:
        if not self._closing.is_set():
            call = self._calls[name] = self._loop.create_task(self._see_through(name, self._calls.get(name)))
            call.add_done_callback(lambda call: self._calls.pop(name) if self._calls.get(name) is call else None)

    async def _see_through(self, name: str, before: asyncio.Task | None) -> None:
        if before is not None:  # the ends of a job are told in their order
            await asyncio.wait([before])
        job, reason = None, None
        for pause in (*_PAUSES, 0.0):
            try:
                job = await asyncio.to_thread(self._store.get, name)
                if job is None or job.callback is None or not job.callback_due:
                    return
                async with self._slots, asyncio.timeout(_TIMEOUT):
                    await self._tell(job)
                await asyncio.to_thread(self._store.callback_told, job)
                return
            except Exception as error:
                reason = error
                await asyncio.sleep(pause)
        log.warning("callback_given_up", job=name, error=str(reason) or type(reason).__name__)
        if job is not None:
            await asyncio.to_thread(self._store.callback_told, job)

    async def _tell(self, job: Job) -> None:
        description = await asyncio.to_thread(self._describe, job)
        async with self._client.stream("POST", job.callback, json=description) as answer:  # whose body is not read
            answer.raise_for_status()
