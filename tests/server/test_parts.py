"""The smaller parts of `tilecast.jobs`, each alone."""

import asyncio
import hashlib
import pickle
import threading
import time
from collections.abc import Coroutine
from concurrent.futures import ThreadPoolExecutor

import pytest

from tilecast.jobs.blobs import Blobs, Mismatch, TooLarge, asset_key
from tilecast.jobs.hub import Hub
from tilecast.jobs.journal import Journal
from tilecast.jobs.task import finite
from tilecast.jobs.worker import Cache, Rejected


@pytest.fixture
def blobs(tmp_path):
    return Blobs((tmp_path / "blobs with spaces").as_uri())


def test_a_blob_comes_back_as_it_went_in(blobs):
    for durable in (True, False):
        blobs.put("a/b/c", b"\0\xff", durable=durable)
        assert blobs.get("a/b/c") == b"\0\xff" and blobs.size("a/b/c") == 2 and blobs.has("a/b/c")
    blobs.put("a/b/c", b"")
    assert blobs.get("a/b/c") == b""
    assert not blobs.has("a/b/d")
    with pytest.raises(FileNotFoundError):
        blobs.get("a/b/d")


def test_parts_of_a_blob_can_be_read(blobs):
    blobs.put("a", bytes(range(100)))
    assert blobs.ranges("a", [0, 50, 97], 3) == [b"\0\1\2", b"234", b"abc"]


def test_blobs_are_deleted_one_by_one_or_with_their_folder(blobs):
    for key in ("jobs/a/tiles/1", "jobs/a/tiles/2", "jobs/b/tiles/1"):
        blobs.put(key, b"x")
    blobs.delete("jobs/a/tiles/1", "jobs/a/tiles/9")
    assert sorted(blobs.keys("jobs")) == ["jobs/a/tiles/2", "jobs/b/tiles/1"]
    (blobs.folder / "jobs/a/tiles/3#1").write_bytes(b"what a kill leaves of a put")
    blobs.delete_all("jobs/a")
    blobs.delete_all("jobs/nothing")
    assert not (blobs.folder / "jobs/a").exists() and blobs.has("jobs/b/tiles/1")


def finished(coroutine: Coroutine):
    """What a coroutine gives. It runs in a thread of its own: a browser driven by the same process has a loop in this."""
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, coroutine).result()


def test_an_upload_is_seen_whole_or_not_at_all(blobs):
    data = b"x" * 10_000_000
    digest = hashlib.sha256(data).hexdigest()

    async def stream(length: int):
        for start in range(0, length, 65536):
            assert not blobs.has(asset_key(digest))
            yield data[start : min(start + 65536, length)]

    with pytest.raises(Mismatch):
        finished(blobs.upload(digest, stream(1000), len(data)))
    with pytest.raises(TooLarge):
        finished(blobs.upload(digest, stream(len(data)), len(data) - 1))
    assert finished(blobs.upload(digest, stream(len(data)), len(data)))
    assert blobs.get(asset_key(digest)) == data
    assert list(blobs.keys("uploads")) == []


def test_a_cache_makes_each_value_once_however_many_ask():
    cache, made = Cache(2), []

    def make() -> int:
        made.append(1)
        time.sleep(0.1)
        return 7

    results = []
    threads = [threading.Thread(target=lambda: results.append(cache.get("a", make))) for _ in range(10)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == [7] * 10 and len(made) == 1


def test_a_cache_forgets_what_was_used_longest_ago():
    cache, made = Cache(2), []

    def get(key: str) -> None:
        cache.get(key, lambda: made.append(key))

    for key in "abacab":
        get(key)
    assert made == ["a", "b", "c", "b"]


def test_a_cache_does_not_keep_failures():
    cache = Cache(2)
    with pytest.raises(ZeroDivisionError):
        cache.get("a", lambda: 1 // 0)
    assert cache.get("a", lambda: 5) == 5


def test_a_rejection_travels_between_processes():
    error = pickle.loads(pickle.dumps(Rejected([("camera.fov", "is wrong"), ("", "and so is all")])))
    assert error.errors == [("camera.fov", "is wrong"), ("", "and so is all")]
    assert str(error) == "camera.fov: is wrong; and so is all"


def test_a_journal_runs_what_is_left_in_order_and_once_a_key():
    journal, seen, gate = Journal(), [], threading.Event()
    journal.enter(gate.wait)
    for number in range(5):
        journal.enter(lambda number=number: seen.append(number))
        journal.enter(lambda: seen.append("key"), key="key")
    gate.set()
    journal.close()
    assert seen == [0, "key", 1, 2, 3, 4]


def test_a_journal_tries_again_what_failed(monkeypatch):
    monkeypatch.setattr("tilecast.jobs.journal._RETRY_SECONDS", 0.01)
    journal, tries, done = Journal(), [], threading.Event()

    def fail_twice() -> None:
        tries.append(1)
        if len(tries) < 3:
            raise OSError("the disk is full")

    journal.enter(fail_twice)
    journal.enter(done.set)
    assert done.wait(10)
    assert len(tries) == 3
    journal.enter(lambda: 1 // 0)
    began = time.monotonic()
    journal.close()
    assert time.monotonic() - began < 5


def test_a_hub_wakes_those_who_listen():
    hub, heard = Hub(), []
    stop = hub.listen("a", lambda: heard.append("a"))
    hub.listen("b", lambda: heard.append("b"))
    hub.notify("a")
    hub.notify("c")
    stop()
    stop()
    hub.notify("a")
    assert heard == ["a"] and len(hub) == 1
    hub.close()
    assert heard == ["a", "b"] and hub.closed


def test_json_says_nothing_of_infinity():
    inf, nan = float("inf"), float("nan")
    value = {"a": [1.5, inf, {"b": nan}], "c": (2, "x", None)}
    assert finite(value) == {"a": [1.5, None, {"b": None}], "c": [2, "x", None]}
