"""Shares an executor's slots among several works: by priority, then fairly between owners, then by age.

One thread hands out and takes back; everything that a work is asked happens on it. The executor decides
nothing: about two tasks a slot are in flight, and what comes next is chosen when a place is free. So a change
of priority, a pause or a removal takes effect within a task or two on every engine.
"""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Hashable
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from typing import Any, Protocol

_log = logging.getLogger(__name__)


class Work(Protocol):
    """Something that gives tasks, such as the rendering of a job. Its methods are called on the dispatcher's
    thread, one at a time, and may call the dispatcher."""

    key: Hashable
    priority: int
    owner: Hashable

    def next(self) -> Any | None:
        """The next task; None where there is none now. Asked again after each of the work's results. A task
        whose attribute `exclusive` is true is started only when nothing else is in flight, and nothing is
        started beside it."""

    def submit(self, executor: Executor, task: Any) -> Future:
        """Starts a task."""

    def done(self, task: Any, result: Any) -> None:
        """Takes the result of a task."""

    def failed(self, task: Any | None, error: BaseException) -> None:
        """A task has failed, in the executor (a dead worker among others: BrokenExecutor, KilledWorker) or
        because `submit` or `done` raised; task None: `next` raised, and the work is dropped. To try again,
        `next` gives it again."""

    def finished(self) -> None:
        """There is nothing to hand out and nothing in flight: the work is dropped, and may be added again."""


@dataclass(eq=False)
class _Entry:
    work: Work
    priority: int
    age: int  # counts up: lower is older
    paused: bool = False
    removed: bool = False
    dry: bool = False  # gave no task; asked again after a result
    in_flight: int = 0


@dataclass
class _Owner:
    in_flight: int = 0
    served: int = 0  # the turn at which it was last given a place


@dataclass(eq=False)
class _Flight:
    entry: _Entry
    task: Any
    exclusive: bool
    future: Future | None = None


class Dispatcher:
    """Feeds works to `executor`, which has `slots` threads or processes. All methods are thread-safe and
    return at once.

    After `remove`, results of the work that are still to come are thrown away; a callback that is running at
    that moment ends as usual."""

    def __init__(self, executor: Executor, slots: int):
        if slots < 1:
            raise ValueError(f"a dispatcher needs at least one slot, got {slots}")
        self._executor = executor
        self._slots = slots
        self._changed = threading.Condition()  # guards all below
        self._entries: dict[Hashable, _Entry] = {}
        self._owners: dict[Hashable, _Owner] = {}
        self._landed: deque[_Flight] = deque()
        self._flights = 0
        self._held: _Flight | None = None  # an exclusive task that waits for the others to end
        self._alone = False  # an exclusive task is in flight
        self._turn = 0
        self._news = False
        self._closed = False
        self._thread = threading.Thread(target=self._run, name="dispatcher", daemon=True)
        self._thread.start()

    # --- For everyone

    def add(self, work: Work) -> None:
        """Takes a work up. KeyError if there is one with its key."""
        with self._changed:
            if self._closed:
                raise RuntimeError("the dispatcher is closed")
            if work.key in self._entries:
                raise KeyError(f"there is a work {work.key!r} already")
            self._turn += 1
            self._entries[work.key] = _Entry(work, work.priority, self._turn)
            self._wake()

    def remove(self, key: Hashable) -> bool:
        """Drops a work; whether it was there."""
        with self._changed:
            entry = self._entries.pop(key, None)
            if entry is None:
                return False
            entry.removed = True
            if self._held and self._held.entry is entry:
                self._held = None
            self._forget_owner(entry)
            self._wake()
            return True

    def set_priority(self, key: Hashable, priority: int) -> bool:
        """Changes a work's priority, high first; whether it was there."""
        return self._set(key, priority=priority)

    def pause(self, key: Hashable) -> bool:
        """Hands out no more of a work; results still come. Whether it was there."""
        return self._set(key, paused=True)

    def resume(self, key: Hashable) -> bool:
        """The opposite of `pause`."""
        return self._set(key, paused=False)

    def set_slots(self, slots: int) -> None:
        """For an executor that grows or shrinks; with 0 nothing new is started."""
        with self._changed:
            self._slots = max(slots, 0)
            self._wake()

    def close(self) -> None:
        """Starts nothing more, throws away what is in flight and ends the thread."""
        with self._changed:
            self._closed = True
            for entry in self._entries.values():
                entry.removed = True
            self._entries.clear()
            self._held = None
            self._wake()
        if threading.current_thread() is not self._thread:
            self._thread.join()

    def _set(self, key: Hashable, **values: Any) -> bool:
        with self._changed:
            entry = self._entries.get(key)
            if entry is None:
                return False
            for name, value in values.items():
                setattr(entry, name, value)
            self._wake()
            return True

    def _wake(self) -> None:
        self._news = True
        self._changed.notify()

    # --- On the thread

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._news or self._landed)
                self._news = False
                landed, self._landed = self._landed, deque()
                if self._closed:
                    return
            for flight in landed:
                self._land(flight)
            while self._start_one():
                pass

    def _land(self, flight: _Flight) -> None:
        """Gives a result, or an error, to its work."""
        entry = flight.entry
        with self._changed:
            self._count(flight, -1)
            entry.dry = False
            removed = entry.removed
        if not removed:
            error = _error(flight.future)
            if error is None:
                error = _called(entry.work.done, flight.task, flight.future.result())
            if error is not None:
                self._fail(entry, flight.task, error)

    def _fail(self, entry: _Entry, task: Any | None, error: BaseException) -> None:
        problem = None if entry.removed else _called(entry.work.failed, task, error)
        if problem is not None:
            _log.error("work %r could not take the failure of a task and is dropped", entry.work.key, exc_info=problem)
        if problem is not None or task is None:
            self._drop(entry)

    def _drop(self, entry: _Entry) -> bool:
        """Forgets a work; whether it was still there."""
        with self._changed:
            if entry.removed:
                return False
            entry.removed = True
            del self._entries[entry.work.key]
            self._forget_owner(entry)
            return True

    def _start_one(self) -> bool:
        """Starts the next task; whether there may be more to start."""
        with self._changed:
            if self._closed or self._alone or self._flights >= 2 * self._slots:
                return False
            flight, self._held = self._held, None
            if flight is None:
                entry = self._choose()
                if entry is None:
                    return False
        if flight is None:
            flight = self._taken(entry)
            if flight is None:
                return True
        with self._changed:
            if flight.entry.removed:
                return True
            if flight.exclusive and self._flights:
                self._held = flight
                return False
            self._count(flight, +1)
        self._submit(flight)
        return True

    def _choose(self) -> _Entry | None:
        """The work whose turn it is."""
        ready = [entry for entry in self._entries.values() if not entry.paused and not entry.dry]

        def rank(entry: _Entry) -> tuple:
            owner = self._owners.setdefault(entry.work.owner, _Owner())
            return -entry.priority, owner.in_flight, owner.served, entry.age

        return min(ready, key=rank, default=None)

    def _taken(self, entry: _Entry) -> _Flight | None:
        """The next task of a work. Where there is none, it waits for its results, or is through."""
        try:
            task = entry.work.next()
        except BaseException as error:
            self._fail(entry, None, error)
            return None
        if task is not None:
            return _Flight(entry, task, bool(getattr(task, "exclusive", False)))
        with self._changed:
            entry.dry = True
            through = entry.in_flight == 0
        if through and self._drop(entry):
            problem = _called(entry.work.finished)
            if problem is not None:
                _log.error("work %r failed as it was finished", entry.work.key, exc_info=problem)
        return None

    def _submit(self, flight: _Flight) -> None:
        try:
            flight.future = flight.entry.work.submit(self._executor, flight.task)
        except BaseException as error:
            flight.future = Future()
            flight.future.set_exception(error)
        flight.future.add_done_callback(lambda _: self._arrived(flight))

    def _arrived(self, flight: _Flight) -> None:
        with self._changed:
            self._landed.append(flight)
            self._changed.notify()

    def _count(self, flight: _Flight, by: int) -> None:
        entry = flight.entry
        entry.in_flight += by
        self._flights += by
        owner = self._owners.setdefault(entry.work.owner, _Owner())
        owner.in_flight += by
        if flight.exclusive:
            self._alone = by > 0
        if by > 0:
            self._turn += 1
            owner.served = self._turn
        elif entry.removed:
            self._forget_owner(entry)

    def _forget_owner(self, entry: _Entry) -> None:
        name = entry.work.owner
        owner = self._owners.get(name)
        if owner and not owner.in_flight and all(other.work.owner != name for other in self._entries.values()):
            del self._owners[name]


def _error(future: Future) -> BaseException | None:
    """What a finished future failed with; cancelling counts."""
    try:
        return future.exception()
    except BaseException as cancelled:  # concurrent.futures and distributed each have their own CancelledError
        return cancelled


def _called(method: Any, *arguments: Any) -> BaseException | None:
    """Calls a work's method; what it raised. A work's mistake must not end the thread that serves all."""
    try:
        method(*arguments)
    except BaseException as error:
        return error
    return None
