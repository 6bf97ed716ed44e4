"""Nothing that dies takes anything with it: the server, its worker, a job that kills whatever renders it."""

import random
import time

import numpy as np
import pytest
from crashing import CRASHES_IN_ONE_TILE, CRASHES_WHILE_COMPILING, NEVER_ENDS, NEVER_ENDS_IN_ONE_CHUNK, PRELOAD
from servers import exr, gone, locally, long_scene, scene, until


@pytest.fixture(scope="module")
def undisturbed() -> np.ndarray:
    return locally(long_scene())


def test_a_killed_server_goes_on_where_it_was(make_server, undisturbed, tmp_path):
    server = make_server().start()
    job = server.submit(long_scene())
    rendered = 0.0
    for progress in (0.02, 0.4):
        # So far, and then at a moment that nobody chose.
        now = server.progressed(job, progress)
        assert now["progress"] >= rendered, "what was stored is not rendered again"
        time.sleep(random.uniform(0, 0.2))
        rendered = server.job(job)["progress"]
        workers = server.children()
        server.kill()
        until(lambda: gone(workers), patience=20)
        server.start()
    server.reach(job, "done")
    assert np.array_equal(exr(server, job, tmp_path), undisturbed)
    stats = server.client.get(job["links"]["stats"]).json()
    assert [point["samples"] for point in stats["curve"]] == [2**k for k in range(1, 11)]
    assert stats["rays"]["camera"] == 96 * 64 * 1024
    folder = server.folder / "blobs" / "jobs" / job["id"]
    until(lambda: not (folder / "tiles").exists())  # tiles go once the commit that ended the job is safe
    leftovers = [path for path in folder.rglob("*") if path.is_file()]
    # The first hits were made for the EXR above.
    assert {path.name for path in leftovers} == {"pixels.npy", "variance.npy", "first-hits.npy", "thumbnail.png"}


def test_a_killed_worker_costs_nothing_but_time(make_server, undisturbed, tmp_path):
    server = make_server().start()
    job = server.submit(long_scene())
    for progress in (0.05, 0.4):
        server.progressed(job, progress)
        [worker] = until(server.workers)
        worker.kill()
    server.reach(job, "done")
    assert np.array_equal(exr(server, job, tmp_path), undisturbed)


def test_what_was_accepted_waits_through_a_restart(make_server):
    """Queued jobs, a paused one, and one that was accepted the moment before, without its scene being compiled."""
    server = make_server(TILECAST_CHECK_SECONDS="0").start()
    paused = server.submit(long_scene())
    server.progressed(paused, 0.01)
    server.client.patch(paused["links"]["self"], json={"state": "paused"})
    jobs = [server.submit(scene(samples=64, seed=seed)) for seed in range(12)]
    server.reach(jobs[0], "done")
    held = server.job(paused)
    jobs.append(server.submit(scene(seed=99)))
    server.kill()
    server.start()
    for job in jobs:
        server.reach(job, "done")
    assert server.job(paused) == held and held["progress"] > 0
    # What was done before stays done, without another start.
    assert server.client.get(jobs[0]["links"]["events"]).text.count('"state":"done"') == 1


def test_sigterm_ends_in_order_and_loses_nothing(make_server, undisturbed, tmp_path):
    server = make_server().start()
    job = server.submit(long_scene())
    server.progressed(job, 0.2)
    rendered = server.job(job)["progress"]
    children = server.children()
    with server.client.stream("GET", job["links"]["events"]) as listening:
        next(listening.iter_lines())
        began = time.monotonic()
        assert server.stop() == 0
        assert time.monotonic() - began < 15
    until(lambda: gone(children), patience=20)
    server.start()
    assert server.job(job)["progress"] >= rendered
    server.reach(job, "done")
    assert np.array_equal(exr(server, job, tmp_path), undisturbed)
    log = server.log.read_text()
    assert "Traceback" not in log and "stopped" in log


def test_jobs_that_kill_workers_fail_and_take_nobody_with_them(make_server, tmp_path):
    server = make_server(**PRELOAD).start()
    innocent = [server.submit(scene(width=64, height=48, samples=64, seed=seed)) for seed in (1, 2)]
    poison = [server.submit(scene(samples=64, seed=seed)) for seed in (CRASHES_IN_ONE_TILE, CRASHES_WHILE_COMPILING)]
    innocent.append(server.submit(scene(width=64, height=48, samples=64, seed=3)))
    for job in poison:
        failed = server.reach(job, "failed")
        assert "died 3 times" in failed["error"]["message"]
    for seed, job in enumerate(innocent, 1):
        server.reach(job, "done")
        assert np.array_equal(exr(server, job, tmp_path), locally(scene(width=64, height=48, samples=64, seed=seed)))
    assert server.client.get("/healthz").status_code == 200
    # What was rendered of it before is there to be seen.
    assert server.client.get(poison[0]["links"]["image"]).status_code == 200


@pytest.mark.parametrize("end", ["paused", "cancelled"])
def test_chunks_that_never_end_give_their_threads_back(make_server, end):
    server = make_server(**PRELOAD, TILECAST_STUCK_SECONDS="1", TILECAST_CHECK_SECONDS="1").start()
    endless = server.reach(server.submit(scene(samples=64, seed=NEVER_ENDS)), "running")
    waiting = server.submit(scene())
    time.sleep(2)  # for as long as somebody wants it, it may take its time
    assert (server.job(endless)["state"], server.job(waiting)["state"]) == ("running", "queued")
    server.client.patch(endless["links"]["self"], json={"state": end})
    until(lambda: server.job(waiting)["state"] == "done", patience=60)
    assert server.job(endless)["state"] == end


def test_a_worker_that_is_restarted_for_a_chunk_costs_other_jobs_nothing_but_time(make_server, undisturbed, tmp_path):
    server = make_server(**PRELOAD, TILECAST_STUCK_SECONDS="1").start()
    endless = server.reach(server.submit(scene(samples=64, seed=NEVER_ENDS_IN_ONE_CHUNK)), "running")
    [worker] = server.workers()
    innocent = server.submit(long_scene())
    server.progressed(innocent, 0.01)
    server.client.patch(endless["links"]["self"], json={"state": "cancelled"})
    until(lambda: gone([worker]), patience=60)
    server.reach(innocent, "done")
    assert np.array_equal(exr(server, innocent, tmp_path), undisturbed)


def test_damaged_tiles_are_rendered_again_and_litter_is_swept(make_server, undisturbed, tmp_path):
    server = make_server().start()
    finished = server.reach(server.submit(scene()), "done")
    job = server.submit(long_scene())
    server.progressed(job, 0.3)
    server.kill()
    blobs = server.folder / "blobs"
    tiles = sorted((blobs / "jobs" / job["id"] / "tiles").iterdir())
    tiles[0].write_bytes(b"")
    tiles[1].write_bytes(tiles[1].read_bytes()[:-100])
    tiles[2].unlink()
    # What kills leave between a put and a commit, and between a commit and what follows it.
    litter = [tiles[0].parent / "999999-1", blobs / "jobs/0123456789abcdef/tiles/0-1",
              blobs / f"jobs/{finished['id']}/tiles/0-1", blobs / "scenes/0000.json", blobs / "uploads/half"]
    for path in litter:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(b"x")
    server.start()
    assert not any(path.exists() for path in litter)
    assert server.client.get(finished["links"]["image"]).status_code == 200
    server.reach(job, "done")
    assert np.array_equal(exr(server, job, tmp_path), undisturbed)
    samples = [point["samples"] for point in server.client.get(job["links"]["curve"]).json()["curve"]]
    assert samples == [2**k for k in range(1, 11)]


def test_a_worker_that_dies_at_birth_again_and_again_is_replaced(make_server):
    """Dask's nanny gives up when its worker dies while it starts; then the server raises another nanny."""
    server = make_server().start()
    [worker] = until(server.workers)
    worker.kill()
    end = time.monotonic() + 2
    while time.monotonic() < end:
        for young in server.workers():
            young.kill()
        time.sleep(0.05)
    job = server.submit(scene())
    server.reach(job, "done")
