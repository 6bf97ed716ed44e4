"""Works for the dispatcher, and an executor whose tasks end when a test says so."""

from __future__ import annotations

import threading
import time
from concurrent.futures import Future
from dataclasses import dataclass, field


@dataclass
class Task:
    number: int
    exclusive: bool = False


@dataclass
class Work:
    """Gives `count` tasks, each of which calls `run`; writes down what it is told."""
    key: str
    count: int = 3
    priority: int = 0
    owner: str = "anyone"
    run: object = None
    exclusive: frozenset = frozenset()
    log: list = field(default_factory=list)
    given: int = 0
    results: list = field(default_factory=list)
    errors: list = field(default_factory=list)
    ended: threading.Event = field(default_factory=threading.Event)

    def next(self):
        if self.given == self.count:
            return None
        self.given += 1
        return Task(self.given - 1, self.given - 1 in self.exclusive)

    def submit(self, executor, task):
        self.log.append((self.key, task.number))
        return executor.submit(self.run or (lambda number: number * 10), task.number)

    def done(self, task, result):
        self.results.append((task.number, result))

    def failed(self, task, error):
        self.errors.append((task and task.number, error))

    def finished(self):
        self.ended.set()


class Manual:
    """An executor whose tasks end when the test says so."""

    def __init__(self):
        self.flying = []
        self.changed = threading.Condition()

    def submit(self, run, number):
        future = Future()
        with self.changed:
            self.flying.append((future, run, number))
            self.changed.notify_all()
        return future

    def wait(self, count):
        with self.changed:
            assert self.changed.wait_for(lambda: len(self.flying) >= count, 10), \
                f"{len(self.flying)} tasks in flight, expected {count}"

    def end(self, index=0):
        with self.changed:
            future, run, number = self.flying.pop(index)
        future.set_result(run(number))

    def settled(self, count):
        """Waits until so many are in flight, and sees that no more come."""
        self.wait(count)
        time.sleep(0.05)
        assert len(self.flying) == count


def drain(executor, *works):
    while not all(work.ended.is_set() for work in works):
        if executor.flying:
            executor.end()
        time.sleep(0.001)
