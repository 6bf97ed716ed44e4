"""What a user may have at once, and how fast."""

from servers import long_scene, refused, scene


def test_what_users_may_have(make_server):
    server = make_server(
        TILECAST_MAX_JOBS="2", TILECAST_MAX_SUBMISSIONS="7/minute", TILECAST_USER_HEADER="X-User",
        TILECAST_CALLBACKS="false",
    ).start()
    # So many jobs at once.
    jobs = [server.submit(long_scene(seed=seed)) for seed in range(2)]
    answer = server.client.post("/v1/jobs", json=scene())
    refused(answer, 429)
    assert int(answer.headers["retry-after"]) > 0
    # Before anything is done for the scene.
    refused(server.client.post("/v1/jobs", json={"no": "scene"}), 429)
    # Another user is not affected, and does not wait for the long jobs of the first.
    other = server.client.post("/v1/jobs", json=scene(), headers={"X-User": "somebody else"})
    assert other.status_code == 202
    server.reach(other.json(), "done")
    assert server.job(jobs[1])["state"] in ("queued", "running")
    # One job less makes room.
    server.client.delete(jobs[0]["links"]["self"])
    for _ in range(3):
        # The same request sent again is no other job.
        assert server.client.post("/v1/jobs", json=scene(), headers={"Idempotency-Key": "a"}).status_code == 202
    # So many submissions in a minute: these are the sixth, the seventh, and one too many.
    server.client.delete(jobs[1]["links"]["self"])
    for seed in range(2):
        server.reach(server.submit(scene(seed=seed)), "done")
    answer = server.client.post("/v1/jobs", json=scene())
    assert "7 per 1 minute" in refused(answer, 429)["detail"]
    assert 0 < int(answer.headers["retry-after"]) <= 60
    # And no callbacks, where they are switched off.
    answer = server.client.post("/v1/jobs", json={"scene": scene(), "callback": "http://127.0.0.1:9/"})
    assert refused(answer, 422)["errors"][0]["path"] == "callback"
