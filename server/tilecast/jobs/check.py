"""Compiles a scene before its job is accepted, so that whoever sent it learns at once what is wrong with it."""

from concurrent.futures import Executor, Future
from typing import Any

from tilecast.jobs import worker
from tilecast.jobs.task import Task

# Ahead of everything: somebody waits for the answer.
_PRIORITY = 2**31


class Check:
    """A work of the dispatcher with one task. `facts` is its outcome: what `worker.prepare` returns or raises."""

    priority = _PRIORITY

    def __init__(self, key: str, owner: str, blobs_url: str, digest: str, max_triangles: int):
        self.key = key
        self.owner = owner
        self.facts: Future[dict[str, Any]] = Future()
        self._arguments = (blobs_url, digest, max_triangles)
        self._task: Task | None = Task()

    def next(self) -> Task | None:
        task, self._task = self._task, None
        return task

    def submit(self, executor: Executor, _task: Task) -> Future:
        return executor.submit(worker.prepare, *self._arguments, priority=1)

    def done(self, _task: Task, result: dict[str, Any]) -> None:
        self.facts.set_result(result)

    def failed(self, _task: Task | None, error: BaseException) -> None:
        self.facts.set_exception(error)

    def finished(self) -> None:
        """There was nothing but the one task."""
