"""The dispatcher keeps its promises when tasks, workers and works fail."""

import time
from concurrent.futures import CancelledError, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool

import pytest
from works import Task, Work

from tilecast.render.dispatch import Dispatcher


def fail(number):
    if number == 1:
        raise OSError(f"task {number} failed")
    return number


def test_a_failing_task_is_told_and_the_others_go_on(threads):
    work, healthy = Work("w", 3, run=fail), Work("healthy", 20)
    threads.add(work)
    threads.add(healthy)
    assert work.ended.wait(10) and healthy.ended.wait(10)
    assert sorted(work.results) == [(0, 0), (2, 2)]
    assert [(number, str(error)) for number, error in work.errors] == [(1, "task 1 failed")]
    assert len(healthy.results) == 20


def die(number):
    import os
    if number == 1:
        os._exit(9)
    return number


def test_a_dead_worker_is_a_failure_of_its_tasks():
    with ProcessPoolExecutor(1) as executor:
        dispatcher = Dispatcher(executor, 1)
        work = Work("w", 4, run=die)
        dispatcher.add(work)
        assert work.ended.wait(30)
        dispatcher.close()
    assert 1 in [number for number, _ in work.errors]
    assert all(isinstance(error, BrokenProcessPool) for _, error in work.errors)
    assert len(work.results) + len(work.errors) == 4


class Retrying(Work):
    """Gives a failed task again, alone, as the service does with suspects."""

    def __init__(self, *arguments, **keys):
        super().__init__(*arguments, **keys)
        self.again = []

    def next(self):
        return self.again.pop() if self.again else super().next()

    def failed(self, task, error):
        super().failed(task, error)
        if len(self.errors) < 3:
            self.again.append(Task(task.number, exclusive=True))


def test_a_failed_task_may_be_given_again(threads):
    work = Retrying("w", 4, run=fail)
    threads.add(work)
    assert work.ended.wait(10)
    assert [number for number, _ in work.errors] == [1, 1, 1]
    assert sorted(work.results) == [(0, 0), (2, 2), (3, 3)]


class Broken(Work):
    """Raises where `broken` says."""
    broken = ""

    def _maybe(self, method):
        if method in self.broken:
            raise ValueError(f"{method} is broken")

    def next(self):
        self._maybe("next")
        return super().next()

    def submit(self, executor, task):
        self._maybe("submit")
        return super().submit(executor, task)

    def done(self, task, result):
        self._maybe("done")
        super().done(task, result)

    def failed(self, task, error):
        super().failed(task, error)
        self._maybe("failed")

    def finished(self):
        super().finished()
        self._maybe("finished")


@pytest.mark.parametrize("broken, numbers", [("next", {None}), ("submit", {0, 1, 2}), ("done", {0, 1, 2}),
                                             ("next failed", {None}), ("done failed", {0}), ("finished", set())])
def test_a_work_that_raises_harms_no_other(threads, broken, numbers, caplog):
    work = Broken("broken")
    work.broken = broken
    threads.add(work)
    healthy = Work("healthy", 30)
    threads.add(healthy)
    assert healthy.ended.wait(10)
    deadline = time.monotonic() + 10
    while (len(work.errors) < len(numbers) or threads.remove("broken")) and time.monotonic() < deadline:
        time.sleep(0.01)
    assert numbers <= {number for number, _ in work.errors}
    assert all(str(error).endswith("is broken") for _, error in work.errors)
    later = Work("later", 3)
    threads.add(later)
    assert later.ended.wait(10)


def test_a_cancelled_future_is_a_failure(manual):
    executor, dispatcher = manual
    work = Work("w", 1)
    dispatcher.add(work)
    executor.wait(1)
    future, _, _ = executor.flying.pop()
    future.cancel()
    future.set_running_or_notify_cancel()
    assert work.ended.wait(10)
    assert isinstance(work.errors[0][1], CancelledError)
