"""The dispatcher shares an executor by priority, fairly and in order of age, and keeps its promises when works fail."""

import threading
import time
from concurrent.futures import CancelledError, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field

import pytest

from tilecast.render.dispatch import Dispatcher


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


@pytest.fixture
def threads():
    with ThreadPoolExecutor(3) as executor:
        dispatcher = Dispatcher(executor, 3)
        yield dispatcher
        dispatcher.close()


@pytest.fixture
def manual():
    executor = Manual()
    dispatcher = Dispatcher(executor, 1)
    yield executor, dispatcher
    dispatcher.close()


def drain(executor, *works):
    while not all(work.ended.is_set() for work in works):
        if executor.flying:
            executor.end()
        time.sleep(0.001)


def test_every_task_of_every_work_is_done_once(threads):
    works = [Work(f"w{i}", count=50, owner=f"o{i % 2}") for i in range(6)]
    for work in works:
        threads.add(work)
    for work in works:
        assert work.ended.wait(20)
        assert sorted(work.results) == [(n, 10 * n) for n in range(50)]
        assert not work.errors


def test_a_work_without_tasks_is_finished_at_once(threads):
    work = Work("empty", count=0)
    threads.add(work)
    assert work.ended.wait(10)
    threads.add(work)  # it is gone, and may come again


def test_about_two_tasks_a_slot_are_in_flight(manual):
    executor, dispatcher = manual
    dispatcher.add(Work("w", count=100))
    executor.settled(2)
    dispatcher.set_slots(3)
    executor.settled(6)
    dispatcher.set_slots(0)
    for _ in range(6):
        executor.end()
    executor.settled(0)


def test_high_priority_goes_first(manual):
    executor, dispatcher = manual
    log = []
    low, high = Work("low", 4, 0, log=log), Work("high", 4, 5, log=log)
    dispatcher.add(low)
    executor.settled(2)
    dispatcher.add(high)
    drain(executor, low, high)
    assert [key for key, _ in log] == ["low"] * 2 + ["high"] * 4 + ["low"] * 2


def test_a_priority_that_changes_takes_effect_with_the_next_task(manual):
    executor, dispatcher = manual
    log = []
    one, two = Work("one", 6, 1, log=log), Work("two", 3, 0, log=log)
    dispatcher.add(one)
    dispatcher.add(two)
    executor.settled(2)
    assert dispatcher.set_priority("two", 9)
    drain(executor, one, two)
    assert [key for key, _ in log] == ["one"] * 2 + ["two"] * 3 + ["one"] * 4
    assert not dispatcher.set_priority("two", 1)


def test_owners_share_alike_and_works_of_one_owner_go_by_age(manual):
    executor, dispatcher = manual
    log = []
    works = [Work("a1", 6, owner="a", log=log), Work("a2", 6, owner="a", log=log), Work("b1", 6, owner="b", log=log)]
    dispatcher.pause("none")
    for work in works:
        dispatcher.add(work)
    drain(executor, *works)
    keys = [key for key, _ in log]
    assert keys.index("a2") > max(at for at, key in enumerate(keys) if key == "a1")
    together = keys[2:11]  # once both owners are there, every other task is b's, until b has no more
    assert 4 <= together.count("b1") <= 5
    assert sorted(keys) == ["a1"] * 6 + ["a2"] * 6 + ["b1"] * 6


def test_a_paused_work_stands_still_and_goes_on(manual):
    executor, dispatcher = manual
    work = Work("w", 5)
    dispatcher.add(work)
    executor.settled(2)
    assert dispatcher.pause("w")
    executor.end()
    executor.end()
    executor.settled(0)
    assert len(work.results) == 2 and not work.ended.is_set()
    assert dispatcher.resume("w")
    drain(executor, work)
    assert sorted(work.results) == [(n, 10 * n) for n in range(5)]


def test_results_of_a_removed_work_are_thrown_away(manual):
    executor, dispatcher = manual
    gone, other = Work("gone", 5), Work("other", 2)
    dispatcher.add(gone)
    executor.settled(2)
    assert dispatcher.remove("gone")
    assert not dispatcher.remove("gone")
    dispatcher.add(other)
    again = Work("gone", 1)  # the same key may come again while the old tasks are still in flight
    dispatcher.add(again)
    drain(executor, other, again)
    assert gone.results == [] and not gone.ended.is_set()
    assert len(other.results) == 2 and len(again.results) == 1


def test_a_key_is_there_once():
    with ThreadPoolExecutor(1) as executor:
        dispatcher = Dispatcher(executor, 1)
        block = threading.Event()
        work = Work("w", 2, run=lambda number: block.wait(10))
        dispatcher.add(work)
        with pytest.raises(KeyError, match="there is a work 'w' already"):
            dispatcher.add(work)
        block.set()
        assert work.ended.wait(10)
        dispatcher.close()
        with pytest.raises(RuntimeError, match="closed"):
            dispatcher.add(work)


def test_an_exclusive_task_runs_alone(manual):
    executor, dispatcher = manual
    dispatcher.set_slots(2)
    log = []
    suspect = Work("suspect", 3, 5, exclusive=frozenset([1]), log=log)
    other = Work("other", 8, 0, owner="b", log=log)
    dispatcher.add(suspect)
    dispatcher.add(other)
    executor.settled(1)  # the first task; the second, exclusive one waits for it, and nothing else starts
    executor.end()
    executor.settled(1)
    assert log == [("suspect", 0), ("suspect", 1)]
    executor.end()
    executor.settled(4)  # now everyone again
    drain(executor, suspect, other)
    assert len(suspect.results) == 3 and len(other.results) == 8


def test_removing_a_work_frees_the_place_its_exclusive_task_waits_for(manual):
    executor, dispatcher = manual
    dispatcher.set_slots(2)
    suspect, other = Work("suspect", 3, 5, exclusive=frozenset([1])), Work("other", 8, owner="b")
    dispatcher.add(suspect)
    dispatcher.add(other)
    executor.settled(1)
    dispatcher.remove("suspect")
    executor.settled(4)
    drain(executor, other)
    assert len(other.results) == 8


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


def test_a_work_may_call_the_dispatcher_from_its_own_methods(threads):
    class Chained(Work):
        def done(self, task, result):
            super().done(task, result)
            threads.pause(self.key)
            threads.set_priority(self.key, task.number)
            threads.resume(self.key)

        def finished(self):
            threads.add(second)
            super().finished()

    second = Work("second", 5)
    first = Chained("first", 5)
    threads.add(first)
    assert first.ended.wait(10) and second.ended.wait(10)
    assert len(second.results) == 5


def test_closing_starts_nothing_more_and_throws_away_what_is_in_flight(manual):
    executor, dispatcher = manual
    work = Work("w", 10)
    dispatcher.add(work)
    executor.settled(2)
    dispatcher.close()
    executor.end()
    executor.settled(1)
    assert work.results == []


def test_a_closing_from_within_a_callback_ends_the_thread():
    with ThreadPoolExecutor(1) as executor:
        dispatcher = Dispatcher(executor, 1)

        class Closing(Work):
            def done(self, task, result):
                super().done(task, result)
                dispatcher.close()

        work = Closing("w", 5)
        dispatcher.add(work)
        dispatcher._thread.join(10)
        assert not dispatcher._thread.is_alive()
        assert len(work.results) == 1


def test_a_thousand_works_of_many_owners_come_to_their_end(threads):
    works = [Work(f"w{i}", count=2, owner=f"o{i % 37}", priority=i % 3) for i in range(1000)]
    for work in works:
        threads.add(work)
    for work in works:
        assert work.ended.wait(60)
    assert not threads._owners and not threads._entries
