"""Server-sent events: live, replayed, bounded."""

import json
import threading
from collections.abc import Iterator

import httpx2
from servers import long_scene, scene, until


def listen(server, job, last: str | None = None) -> Iterator[httpx2.ServerSentEvent]:
    headers = {} if last is None else {"Last-Event-ID": last}
    with server.client.stream("GET", job["links"]["events"], headers=headers) as stream:
        assert stream.headers["content-type"].startswith("text/event-stream")
        yield from (event for event in httpx2.EventSource(stream) if event.id)


def test_a_job_is_told_from_its_first_tile_to_its_last_state(server):
    job = server.submit(long_scene())
    events = list(listen(server, job))
    numbers = [int(event.id) for event in events]
    assert numbers == sorted(set(numbers))
    assert (events[0].event, json.loads(events[0].data)["state"]) == ("state", "queued")
    assert (events[-1].event, json.loads(events[-1].data)["state"]) == ("state", "done")
    states = [json.loads(event.data)["state"] for event in events if event.event == "state"]
    assert states == ["queued", "running", "done"]

    versions: dict[tuple, int] = {}
    for event in events:
        if event.event == "tile":
            tile = json.loads(event.data)
            assert tile.keys() == {"column", "row", "x", "y", "width", "height", "version", "samples",
                                   "relative_mse"}
            place = (tile["column"], tile["row"])
            assert tile["version"] > versions.get(place, 0)
            versions[place] = tile["version"]
    assert len(versions) == job["tiles"]["columns"] * job["tiles"]["rows"]
    assert len(set(versions.values())) == 1

    points = [json.loads(event.data) for event in events if event.event == "error"]
    assert [point["samples"] for point in points] == [2**k for k in range(1, 11)]
    assert points == server.client.get(job["links"]["curve"]).json()["curve"]
    assert points[0].keys() >= {"seconds", "samples", "mse", "relative_mse", "low", "high"}


def test_who_comes_late_hears_the_same_in_the_end(server):
    job = server.reach(server.submit(scene(samples=16)), "done")
    events = list(listen(server, job))
    tiles = [json.loads(event.data) for event in events if event.event == "tile"]
    count = job["tiles"]["columns"] * job["tiles"]["rows"]
    # Of each tile, the latest version alone.
    assert len(tiles) == count and all(tile["samples"] == 16 for tile in tiles)
    assert len(events) <= count + 4 + 3


def test_a_broken_stream_goes_on_where_it_broke(server):
    job = server.submit(long_scene(seed=2))
    heard = []
    for event in listen(server, job):
        heard.append(event)
        if len(heard) == 10:
            break
    rest = list(listen(server, job, heard[-1].id))
    assert all(int(event.id) > int(heard[-1].id) for event in rest)
    assert json.loads(rest[-1].data)["state"] == "done"
    latest = {}
    for event in heard + rest:
        if event.event == "tile":
            tile = json.loads(event.data)
            latest[tile["column"], tile["row"]] = tile["samples"]
    assert len(latest) == job["tiles"]["columns"] * job["tiles"]["rows"] and set(latest.values()) == {1024}


def test_who_has_heard_everything_is_sent_away(server):
    job = server.reach(server.submit(scene()), "done")
    last = list(listen(server, job))[-1].id
    answer = server.client.get(job["links"]["events"], headers={"Last-Event-ID": last})
    assert (answer.status_code, answer.content) == (204, b"")


def test_changes_by_users_are_told(server):
    job = server.submit(long_scene(seed=3))
    server.client.patch(job["links"]["self"], json={"state": "paused"})
    server.client.patch(job["links"]["self"], json={"priority": 3})
    server.client.patch(job["links"]["self"], json={"state": "queued"})
    server.client.delete(job["links"]["self"])
    states = [json.loads(event.data) for event in listen(server, job) if event.event == "state"]
    told = [state["state"] for state in states if state["state"] != "running"]
    assert told == ["queued", "paused", "paused", "queued", "cancelled"]
    assert states[-1] == {"state": "cancelled", "priority": 3, "error": None}


def test_nothing_is_told_after_the_final_state(server):
    """What came in until then is stored and told before it."""
    for seed in range(3):
        job = server.submit(long_scene(seed=seed))
        server.progressed(job, 0.01)
        server.client.delete(job["links"]["self"])
        events = list(listen(server, job))
        assert json.loads(events[-1].data)["state"] == "cancelled"
        assert int(events[-1].id) == max(int(event.id) for event in events)


def test_the_stream_of_a_deleted_job_ends(server):
    job = server.submit(long_scene(seed=4))
    server.client.patch(job["links"]["self"], json={"state": "paused"})
    ended = threading.Event()

    def follow() -> None:
        for _ in listen(server, job):
            pass
        ended.set()

    thread = threading.Thread(target=follow)
    thread.start()
    assert not ended.wait(0.5)
    server.client.delete(job["links"]["self"])
    server.client.delete(job["links"]["self"])
    assert ended.wait(20)
    thread.join()


def test_many_listeners_hear_the_same_and_are_forgotten(server):
    job = server.submit(long_scene(seed=5))
    heard: list[list] = []
    threads = [threading.Thread(target=lambda: heard.append(list(listen(server, job)))) for _ in range(20)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(heard) == 20
    assert {events[-1].id for events in heard} == {heard[0][-1].id}
    until(lambda: "tilecast_listeners 0.0" in server.client.get("/metrics").text)


def test_who_goes_away_leaves_no_trace_in_the_log(server):
    job = server.submit(long_scene(seed=6))
    for _ in range(10):
        for _ in listen(server, job):
            break
    server.client.delete(job["links"]["self"])
    until(lambda: "tilecast_listeners 0.0" in server.client.get("/metrics").text)
    assert "request_failed" not in server.log.read_text()
