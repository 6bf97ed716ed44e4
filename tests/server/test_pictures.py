"""Pictures of jobs: whole, in the making, and while somebody reads them."""

import threading
import time
from concurrent.futures import Executor, Future

import numpy as np
import pytest
from crashing import PRELOAD, SLOW_FIRST_HITS
from servers import Server, exr, long_scene, refused, scene, until

from tilecast import _images
from tilecast import scene as scenes
from tilecast.jobs.blobs import Blobs
from tilecast.jobs.faults import NoSuchJob, NotYet
from tilecast.jobs.first_hits import FirstHits
from tilecast.jobs.images import Images
from tilecast.jobs.store import Store
from tilecast.render import error, layers, local, output
from tilecast.render.dispatch import Dispatcher

KINDS = {"png": "image", "exr": "exr", "thumbnail": "thumbnail", "error": "error_map"}


def test_tiles_make_up_the_picture(server, tmp_path):
    job = server.reach(server.submit(scene(width=50, height=40)), "done")
    tiles = server.client.get(f"/v1/jobs/{job['id']}/tiles").json()
    assert {name: tiles[name] for name in ("columns", "rows", "size")} == job["tiles"]
    assert len(tiles["tiles"]) == tiles["columns"] * tiles["rows"]
    whole = np.full((40, 50, 3), -1, np.float16)
    for tile in tiles["tiles"]:
        assert tile["samples"] == 4
        answer = server.client.get(f"/v1/jobs/{job['id']}/tiles/{tile['column']}/{tile['row']}.f16")
        pixels = np.frombuffer(answer.content, "<f2").reshape(tile["height"], tile["width"], 3)
        whole[tile["y"] : tile["y"] + tile["height"], tile["x"] : tile["x"] + tile["width"]] = pixels
    assert np.array_equal(whole, exr(server, job, tmp_path).astype(np.float16))


def test_pictures_are_there_before_the_end(server, tmp_path):
    job = server.submit(long_scene())
    server.progressed(job, 0.01)
    assert exr(server, job, tmp_path).max() > 0
    drawn = [tile for tile in server.client.get(job["links"]["tiles"]).json()["tiles"] if tile["version"]]
    here = f"{job['links']['tiles']}/{drawn[0]['column']}/{drawn[0]['row']}"
    assert any(np.frombuffer(server.client.get(f"{here}.f16").content, "<f2"))
    for picture in (f"{here}.png", job["links"]["image"], job["links"]["thumbnail"]):
        assert server.client.get(picture).content.startswith(b"\x89PNG")
    assert server.client.get(job["links"]["stats"]).json()["rays"]["camera"] > 0
    server.client.delete(job["links"]["self"])
    # And of a job that was given up, what there was.
    assert exr(server, job, tmp_path).max() > 0


def test_an_exr_holds_layers_and_the_error_has_a_map(server, tmp_path):
    document = scene(width=50, height=40, samples=16)
    job = server.reach(server.submit(document), "done")
    compiled = scenes.compile(scenes.parse(document), lambda name: b"")
    image = local.render(compiled, threads=2)
    expected = layers.error_layers(image.pixels, image.variance, image.sample_counts) \
        | layers.first_hit_layers(local.first_hits(compiled))
    for _ in range(2):  # made, then kept
        exr(server, job, tmp_path)
        pixels, channels, _ = _images.read(str(tmp_path / "image.exr"))
        assert set(channels) == {"R", "G", "B", *expected}
        for name, values in expected.items():
            assert np.array_equal(pixels[..., channels.index(name)], values), name
    answer = server.client.get(job["links"]["error_map"])
    assert answer.headers["content-type"] == "image/png"
    assert answer.content == output.error_png(image.pixels, image.variance)
    for tile in server.client.get(job["links"]["tiles"]).json()["tiles"]:
        window = slice(tile["y"], tile["y"] + tile["height"]), slice(tile["x"], tile["x"] + tile["width"])
        mean, variance = (np.moveaxis(of[window], 2, 0) for of in (image.pixels, image.variance))
        assert tile["relative_mse"] == pytest.approx((variance * error.weight(mean, variance)).mean())


def test_a_job_under_way_has_a_map_of_its_error(server):
    job = server.submit(long_scene(seed=77))
    server.progressed(job, 0.01)
    assert server.client.get(job["links"]["error_map"]).content.startswith(b"\x89PNG")
    server.client.delete(job["links"]["self"])
    assert server.client.get(job["links"]["error_map"]).content.startswith(b"\x89PNG")


def test_a_job_that_waits_has_a_black_picture(server):
    first = server.submit(long_scene(seed=78))
    server.progressed(first, 0.01)  # it has all threads
    job = server.submit(long_scene(), priority=-1000)
    server.client.patch(job["links"]["self"], json={"state": "paused"})
    assert server.client.get(job["links"]["thumbnail"]).content.startswith(b"\x89PNG")
    assert server.client.get(job["links"]["curve"]).json() == {"curve": []}
    assert server.client.get(job["links"]["stats"]).json()["kernel"]
    for each in (job, first):
        server.client.delete(each["links"]["self"])


def test_what_is_read_while_a_job_ends_is_its_finished_picture(server):
    """A request reads the job's row, then its pixels. In between the job may end, which drops its tiles."""
    store, blobs = Store(f"sqlite:///{server.folder / 'tilecast.db'}"), Blobs((server.folder / "blobs").as_uri())
    images, others = (Images(store, blobs, lambda job: None, FirstHits(store, blobs, None, 0)) for _ in range(2))
    job = server.submit(long_scene(seed=31))
    server.progressed(job, 0.01)
    running = store.get(job["id"])
    server.reach(job, "done")
    until(lambda: not (server.folder / "blobs" / "jobs" / job["id"] / "tiles").exists())
    for kind, link in KINDS.items():
        finished = server.client.get(job["links"][link]).content
        assert images.image(running, kind) == finished, kind
    for tile in server.client.get(job["links"]["tiles"]).json()["tiles"]:
        place = tile["column"], tile["row"]
        finished = server.client.get(f"{job['links']['tiles']}/{place[0]}/{place[1]}.f16")
        assert np.frombuffer(finished.content, "<f2").any()
        assert images.tile(running, *place, "f16") == (finished.content, tile["version"])

    done = store.get(job["id"])
    server.client.delete(job["links"]["self"])
    with pytest.raises(NoSuchJob):
        others.image(done, "png")
    with pytest.raises(NoSuchJob):
        others.tile(done, 0, 0, "f16")
    store.close()


def test_a_tile_that_cannot_be_read_is_black_and_says_so(server):
    job = server.submit(long_scene(seed=32))
    server.progressed(job, 0.01)
    server.client.patch(job["links"]["self"], json={"state": "paused"})
    drawn = next(tile for tile in server.client.get(job["links"]["tiles"]).json()["tiles"] if tile["version"])
    here = f"{job['links']['tiles']}/{drawn['column']}/{drawn['row']}.f16"
    before = server.client.get(here)
    assert any(np.frombuffer(before.content, "<f2")) and before.headers["etag"].endswith(f'-{drawn["version"]}"')
    for blob in (server.folder / "blobs" / "jobs" / job["id"] / "tiles").iterdir():
        blob.write_bytes(b"")
    damaged = server.client.get(here)
    assert not any(np.frombuffer(damaged.content, "<f2"))
    assert damaged.headers["etag"].endswith('-0"')
    server.client.delete(job["links"]["self"])


def test_a_tag_is_strong_where_no_byte_will_change(server):
    job = server.submit(long_scene(seed=33))
    server.progressed(job, 0.01)
    links = [*(job["links"][link] for link in KINDS.values()), f"{job['links']['tiles']}/0/0.png"]
    for link in links:
        answer = server.client.get(link)
        assert answer.headers["etag"].startswith('W/"')
    server.client.patch(job["links"]["self"], json={"state": "paused"})
    for link in links:  # and a weak one serves as well for asking again
        tag = server.client.get(link).headers["etag"]
        assert server.client.get(link, headers={"If-None-Match": tag}).status_code == 304
    server.client.patch(job["links"]["self"], json={"state": "queued"})
    server.reach(job, "done")
    for link in links:
        assert server.client.get(link).headers["etag"].startswith('"')


@pytest.fixture(scope="module")
def slow_server(tmp_path_factory):
    """One that takes 3 seconds for the layers of each tile of an EXR."""
    server = Server(tmp_path_factory.mktemp("slow") / "data", **PRELOAD)
    yield server.start()
    server.close()


def ask_for_exrs(server, jobs) -> tuple[list[threading.Thread], list]:
    """Asks for the EXRs of some jobs at the same time; the threads, and where the answers come."""
    answers: list = []
    threads = [threading.Thread(target=lambda link: answers.append(server.client.get(link)), args=(job["links"]["exr"],))
               for job in jobs]
    for thread in threads:
        thread.start()
    return threads, answers


def test_who_waits_for_an_exr_holds_up_nobody(slow_server):
    job = slow_server.reach(slow_server.submit(scene(seed=SLOW_FIRST_HITS)), "done")
    threads, answers = ask_for_exrs(slow_server, [job] * 60)
    time.sleep(0.5)
    for link in (job["links"]["self"], job["links"]["image"]):
        began = time.monotonic()
        assert slow_server.client.get(link).status_code == 200
        assert time.monotonic() - began < 1.5
    assert not answers
    for thread in threads:
        thread.join()
    assert [answer.status_code for answer in answers] == [200] * 60


def test_a_job_that_is_deleted_while_its_exr_is_made_leaves_nothing(slow_server):
    job = slow_server.reach(slow_server.submit(scene(seed=SLOW_FIRST_HITS)), "done")
    threads, answers = ask_for_exrs(slow_server, [job])
    time.sleep(0.5)
    assert slow_server.client.delete(job["links"]["self"]).status_code == 204
    for thread in threads:
        thread.join()
    refused(answers[0], 404)
    time.sleep(7)  # what is under way on the workers comes to its end
    assert not (slow_server.folder / "blobs" / "jobs" / job["id"]).exists()


def test_layers_that_make_no_progress_are_given_up(server, monkeypatch):
    monkeypatch.setattr("tilecast.jobs.first_hits._PATIENCE", 0.2)
    store, blobs = Store(f"sqlite:///{server.folder / 'tilecast.db'}"), Blobs((server.folder / "blobs").as_uri())
    job = store.get(server.reach(server.submit(scene()), "done")["id"])
    needed, endless = [], Future()

    class Workers(Executor):
        def submit(self, *_, **options):
            needed.append(options["needed"])
            return endless

    dispatcher = Dispatcher(Workers(), 1)
    hits = FirstHits(store, blobs, dispatcher, 1000)
    for tries in (1, 2):
        with pytest.raises(NotYet):
            hits.get(job)
        assert len(needed) == 2 and not any(is_needed() for is_needed in needed)
    dispatcher.close()
    store.close()
