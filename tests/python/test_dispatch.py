"""The dispatcher shares an executor by priority, fairly and in order of age."""

import threading
from concurrent.futures import ThreadPoolExecutor

import pytest
from works import Work, drain

from tilecast.render.dispatch import Dispatcher


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
