"""Jobs over HTTP, from the scene to the end."""

import html
import json
import re
import threading
from pathlib import Path

import numpy as np
import pytest
from servers import exr, locally, long_scene, scene, until


def test_a_scene_becomes_a_picture(server, tmp_path):
    answer = server.client.post("/v1/jobs", json=scene(samples=16))
    assert answer.status_code == 202
    job = answer.json()
    assert answer.headers["location"] == f"/v1/jobs/{job['id']}" == job["links"]["self"]
    assert (job["state"], job["progress"], job["started"], job["error"]) == ("queued", 0, None, None)
    assert (job["width"], job["height"], job["samples"]) == (32, 24, 16)

    done = server.reach(job, "done")
    assert done["progress"] == 1 and done["relative_mse"] > 0
    assert done["created"] <= done["started"] <= done["finished"]
    assert np.array_equal(exr(server, job, tmp_path), locally(scene(samples=16)))


def test_workers_load_nothing_for_images_that_a_scene_lacks(make_server):
    server = make_server().start()  # one that has rendered nothing else
    server.reach(server.submit(scene()), "done")
    loaded = [{Path(area.path).name for area in process.memory_maps()} for process in server.children()]
    workers = [names for names in loaded if any(name.startswith("_core") for name in names)]
    assert workers and not any(name.startswith("libOpenImageIO") for names in workers for name in names)


def test_every_link_leads_somewhere(server):
    job = server.reach(server.submit(scene()), "done")
    for name, link in job["links"].items():
        assert server.client.get(link).status_code == 200, name


def test_an_adaptive_job_takes_the_samples_that_the_command_line_takes(server, tmp_path):
    document = scene(width=80, height=64, samples=48, adaptive=True)
    job = server.reach(server.submit(document), "done")
    assert np.array_equal(exr(server, job, tmp_path), locally(document))
    samples = {tile["samples"] for tile in server.client.get(job["links"]["tiles"]).json()["tiles"]}
    assert min(samples) < 48 < max(samples) and job["tiles"]["size"] == 8


def test_statistics_hold_all_that_is_promised(server):
    job = server.reach(server.submit(scene(samples=16)), "done")
    stats = server.client.get(job["links"]["stats"]).json()
    assert stats["seconds"].keys() >= {"load", "compile", "render", "write"}
    assert stats["seconds"]["render"] > 0 and stats["seconds"]["write"] > 0
    assert stats["rays"].keys() == {"camera", "bounce", "shadow"}
    assert stats["rays"]["camera"] == 32 * 24 * 16
    assert stats["samples"] == 16 and stats["rays_per_second"] > 0
    assert stats["error"].keys() >= {"mse", "relative_mse", "low", "high"}
    assert stats["accelerator"].keys() >= {"kind", "nodes", "bytes", "seconds"}
    assert "dielectric" in stats["features"]["used"] and "csg" in stats["features"]["left_out"]
    assert stats["kernel"]
    curve = server.client.get(job["links"]["curve"]).json()["curve"]
    assert [point["samples"] for point in curve] == [2, 4, 8, 16]
    assert curve == stats["curve"]
    assert job["relative_mse"] == curve[-1]["relative_mse"]


def test_an_empty_scene_is_its_background(server, tmp_path):
    document = scene() | {"scene": [], "lights": []}
    job = server.reach(server.submit(document), "done")
    expected = np.float32([0.1, 0.1, 0.2])
    assert np.array_equal(exr(server, job, tmp_path), np.broadcast_to(expected, (24, 32, 3)))


def test_a_job_has_a_name_and_a_priority(server):
    job = server.submit(scene(), name="Kugel – Σφαίρα 🎱", priority=7)
    assert (job["name"], job["priority"]) == ("Kugel – Σφαίρα 🎱", 7)
    assert server.reach(job, "done")["name"] == job["name"]


@pytest.mark.parametrize(
    "media_type", ["application/x-www-form-urlencoded", "application/json; charset=utf-8", "text/plain"]
)
def test_what_curl_and_browsers_send_by_default_is_taken(server, media_type):
    body = json.dumps(scene()).encode()
    answer = server.client.post("/v1/jobs", content=body, headers={"Content-Type": media_type})
    assert answer.status_code == 202


def test_stop_rules_end_a_job_early(server):
    loose = server.submit(scene(samples=100_000, stop={"relative_mse": 1.0}))
    done = server.reach(loose, "done")
    assert server.client.get(done["links"]["stats"]).json()["samples"] < 1000
    short = server.submit(scene(width=128, height=96, samples=100_000, stop={"seconds": 0.5}))
    done = server.reach(short, "done")
    assert 0 < server.client.get(done["links"]["stats"]).json()["samples"] < 100_000


def test_cancelling_ends_a_job_and_deleting_forgets_it(server):
    job = server.submit(long_scene())
    server.progressed(job, 0.001)
    answer = server.client.delete(job["links"]["self"])
    assert (answer.status_code, answer.json()["state"]) == (200, "cancelled")
    assert answer.json()["finished"]
    assert server.client.delete(job["links"]["self"]).status_code == 204
    for call in (server.client.get, server.client.delete):
        gone = call(job["links"]["self"])
        assert gone.status_code == 404 and gone.headers["content-type"] == "application/problem+json"


def test_a_change_to_cancelled_never_deletes(server):
    job = server.submit(long_scene())
    answer = server.client.patch(job["links"]["self"], json={"priority": 3, "state": "cancelled"})
    assert (answer.status_code, answer.json()["state"], answer.json()["priority"]) == (200, "cancelled", 3)
    done = server.reach(server.submit(scene()), "done")
    for ended in (answer.json(), done):
        late = server.client.patch(ended["links"]["self"], json={"state": "cancelled"})
        assert late.status_code == 409 and ended["state"] in late.json()["detail"]
        assert server.job(ended) == ended


def test_deleting_leaves_no_blobs(server):
    job = server.submit(scene(seed=4711))
    server.reach(job, "done")
    folder = server.folder / "blobs" / "jobs" / job["id"]
    until(lambda: not (folder / "tiles").exists())  # tiles go once the commit that ended the job is safe
    assert {path.name for path in folder.iterdir()} == {"pixels.npy", "variance.npy", "thumbnail.png"}
    before = set(server.folder.glob("blobs/scenes/*"))
    server.client.delete(job["links"]["self"])
    assert not folder.exists()
    assert len(before - set(server.folder.glob("blobs/scenes/*"))) == 1


def test_a_scene_that_two_jobs_share_stays_for_the_second(server, tmp_path):
    first, second = server.submit(scene(seed=4712)), server.submit(long_scene(seed=4712) | {"image": scene()["image"]})
    third = server.submit(scene(seed=4712))
    server.reach(first, "done")
    server.client.delete(first["links"]["self"])
    assert server.reach(third, "done")
    server.client.delete(second["links"]["self"])


def test_a_cancelled_job_goes_on_from_where_it_was(server, tmp_path):
    document = scene(width=128, height=96, samples=256, seed=3)
    job = server.submit(document)
    server.progressed(job, 0.05)
    cancelled = server.client.delete(job["links"]["self"]).json()
    rendered = cancelled["progress"]
    answer = server.client.post(f"{job['links']['self']}/retry")
    assert answer.status_code == 202 and answer.json()["state"] in ("queued", "running")
    assert answer.json()["finished"] is None
    assert answer.json()["progress"] >= rendered > 0
    server.reach(job, "done")
    assert np.array_equal(exr(server, job, tmp_path), locally(document))


def test_pausing_holds_a_job_and_resuming_lets_it_go_on(server, tmp_path):
    document = scene(width=128, height=96, samples=256, seed=5)
    job = server.submit(document)
    server.progressed(job, 0.02)
    paused = server.client.patch(job["links"]["self"], json={"state": "paused"})
    assert (paused.status_code, paused.json()["state"]) == (200, "paused")
    assert server.client.patch(job["links"]["self"], json={"state": "paused"}).status_code == 200
    held = server.job(job)["progress"]
    other = server.submit(scene())
    server.reach(other, "done")
    assert server.job(job)["state"] == "paused" and server.job(job)["progress"] == held
    assert server.client.patch(job["links"]["self"], json={"state": "queued"}).status_code == 200
    server.reach(job, "done")
    assert np.array_equal(exr(server, job, tmp_path), locally(document))


def test_a_higher_priority_overtakes_what_is_running(server):
    slow = server.submit(scene(width=96, height=64, samples=4096, seed=6))
    server.progressed(slow, 0.001)
    quick = server.submit(scene(seed=7), priority=10)
    server.reach(quick, "done")
    assert server.job(slow)["state"] == "running"
    # And a priority that changes while it runs counts at once. What had been sent out still ends, some tasks of several
    # chunks, so `slow` is looked at after that; equals would go on at the same pace.
    slower = server.submit(scene(width=96, height=64, samples=4096, seed=8))
    changed = server.client.patch(slower["links"]["self"], json={"priority": 5})
    assert changed.json()["priority"] == 5
    began, before = server.progressed(slower, 0.1)["progress"], server.job(slow)["progress"]
    ended, after = server.progressed(slower, 0.2)["progress"], server.job(slow)["progress"]
    assert after - before < (ended - began) / 2 and after < 1
    for job in (slow, slower):
        server.client.delete(job["links"]["self"])


def test_what_does_not_fit_the_state_is_refused(server):
    job = server.reach(server.submit(scene()), "done")
    for answer in (
        server.client.patch(job["links"]["self"], json={"state": "paused"}),
        server.client.patch(job["links"]["self"], json={"state": "queued"}),
        server.client.patch(job["links"]["self"], json={"priority": 3}),
        server.client.post(f"{job['links']['self']}/retry"),
    ):
        assert answer.status_code == 409
        assert "done" in answer.json()["detail"]


def test_the_same_request_sent_again_makes_one_job(server):
    headers = {"Idempotency-Key": "once"}
    first = server.client.post("/v1/jobs", json=scene(), headers=headers)
    again = server.client.post("/v1/jobs", json=scene(), headers=headers)
    assert first.json()["id"] == again.json()["id"]
    assert (first.status_code, again.status_code) == (202, 202)
    assert "idempotency-replayed" not in first.headers and again.headers["idempotency-replayed"] == "true"
    other = server.client.post("/v1/jobs", json=scene(samples=8), headers=headers)
    assert other.status_code == 422
    assert other.json()["type"].endswith("idempotency-key-reused")


def test_requests_at_the_same_time_make_one_job_for_each_key(server):
    answers = []

    def post(key: int) -> None:
        answers.append(server.client.post("/v1/jobs", json=scene(seed=key), headers={"Idempotency-Key": f"key {key}"}))

    threads = [threading.Thread(target=post, args=(key,)) for key in range(6) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [answer.status_code for answer in answers] == [202] * 24
    jobs = {answer.json()["id"] for answer in answers}
    assert len(jobs) == 6
    for job in jobs:
        server.reach({"id": job}, "done")


def test_the_list_is_newest_first_and_paged(server):
    jobs = [server.submit(scene(seed=seed)) for seed in range(5)]
    ids = [job["id"] for job in jobs][::-1]
    page = server.client.get("/v1/jobs?limit=2").json()
    assert [job["id"] for job in page["jobs"]] == ids[:2]
    page = server.client.get(f"/v1/jobs?limit=3&after={page['next']}").json()
    assert [job["id"] for job in page["jobs"]] == ids[2:5]
    for job in jobs:
        server.reach(job, "done")
    assert all(job["state"] == "done" for job in server.client.get("/v1/jobs?state=done&limit=200").json()["jobs"])
    assert server.client.get("/v1/jobs?state=paused").json()["next"] is None


def test_what_did_not_change_is_not_sent_again(server):
    job = server.reach(server.submit(scene()), "done")
    tile = f"{job['links']['tiles']}/0/0.f16"
    pictures = [job["links"][name] for name in ("image", "exr", "thumbnail")]
    for link in ("/v1/jobs?state=done", job["links"]["self"], *pictures, tile):
        tag = server.client.get(link).headers["etag"]
        again = server.client.get(link, headers={"If-None-Match": tag})
        assert (again.status_code, again.content) == (304, b"")
        assert server.client.get(link, headers={"If-None-Match": '"other"'}).status_code == 200


def test_a_tag_changes_with_the_job(server):
    job = server.submit(long_scene(seed=9))
    before = server.client.get(job["links"]["self"]).headers["etag"]
    server.progressed(job, 0.01)
    after = server.client.get(job["links"]["self"]).headers["etag"]
    assert before != after
    stale = server.client.delete(job["links"]["self"], headers={"If-Match": before})
    assert stale.status_code == 412
    server.client.patch(job["links"]["self"], json={"state": "paused"})
    now = server.client.get(job["links"]["self"]).headers["etag"]
    assert server.client.delete(job["links"]["self"], headers={"If-Match": now}).status_code == 200


def test_of_changes_at_the_same_time_one_meets_the_state_it_means(server):
    job = server.submit(long_scene())
    here = job["links"]["self"]
    server.client.patch(here, json={"state": "paused"})
    for _ in range(10):
        tag = server.client.get(here).headers["etag"]
        start, answers = threading.Barrier(4), []

        def change(priority: int) -> None:
            start.wait()
            answers.append(server.client.patch(here, json={"priority": priority}, headers={"If-Match": tag}).status_code)

        threads = [threading.Thread(target=change, args=(priority,)) for priority in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert sorted(answers) == [200, 412, 412, 412]
    server.client.delete(here)


def test_another_site_may_not_change_anything(server):
    answer = server.client.post("/v1/jobs", json=scene(), headers={"Sec-Fetch-Site": "cross-site"})
    assert answer.status_code == 403
    assert server.client.post("/v1/jobs", json=scene(), headers={"Sec-Fetch-Site": "same-origin"}).status_code == 202


def test_metrics_count_what_was_done(server):
    server.reach(server.submit(scene()), "done")
    text = server.client.get("/metrics").text
    values = dict(line.rsplit(" ", 1) for line in text.splitlines() if not line.startswith("#"))
    assert float(values['tilecast_jobs{state="done"}']) >= 1
    assert float(values["tilecast_chunks_total"]) > 0
    assert float(values["tilecast_workers"]) == 1
    assert any(name.startswith("http_request") for name in values)


def test_the_server_says_how_it_is(server):
    assert server.client.get("/healthz").json() == {"status": "ok"}
    assert until(lambda: server.client.get("/readyz").status_code == 200)
    schema = server.client.get("/v1/schema")
    assert schema.headers["content-type"] == "application/schema+json"
    assert schema.json()["properties"].keys() >= {"camera", "scene", "objects"}


def test_the_description_needs_nothing_from_elsewhere(server):
    page = server.client.get("/docs")
    assert page.headers["content-type"].startswith("text/html")
    assert not re.search(r"<script|(?:src|href)=[\"']?(?:\w+:|//)", page.text)
    for path, calls in server.client.get("/openapi.json").json()["paths"].items():
        for method, call in calls.items():
            assert f"{method.upper()} {path}<" in page.text
            assert html.escape(call.get("description", "").split("\n")[0]) in page.text


def test_the_page_and_the_example_scenes_are_served(server):
    page = server.client.get("/")
    assert page.headers["content-type"].startswith("text/html") and "/web/main.js" in page.text
    script = server.client.get("/web/main.js")
    assert "javascript" in script.headers["content-type"]
    assert script.headers["x-content-type-options"] == "nosniff"
    names = [entry["name"] for entry in server.client.get("/v1/scenes").json()["scenes"]]
    assert "cornell" in names
    assert server.client.get("/v1/scenes/cornell").json()["camera"]
    for name in ("nothing", "..%2Fpyproject", "%2Fetc%2Fpasswd"):
        assert server.client.get(f"/v1/scenes/{name}").status_code == 404
    assert server.client.get("/web/../pyproject.toml").status_code == 404
    assert server.client.get("/web/%2e%2e/pyproject.toml").status_code == 404
