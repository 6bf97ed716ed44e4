"""What a user may have at once, and how fast."""

from conftest import long_scene, scene
from test_bad_input import refused


def test_a_user_may_have_only_so_many_jobs_and_users_take_turns(make_server):
    server = make_server(TILECAST_MAX_JOBS="2", TILECAST_USER_HEADER="X-User").start()
    jobs = [server.submit(long_scene(seed=seed)) for seed in range(2)]
    answer = server.client.post("/v1/jobs", json=scene())
    refused(answer, 429)
    assert int(answer.headers["retry-after"]) > 0
    # Another user is not affected, and does not wait for the long jobs of the first.
    other = server.client.post("/v1/jobs", json=scene(), headers={"X-User": "somebody else"})
    assert other.status_code == 202
    server.reach(other.json(), "done")
    assert server.job(jobs[1])["state"] in ("queued", "running")
    # One job less makes room.
    server.client.delete(jobs[0]["links"]["self"])
    server.submit(scene())


def test_a_user_may_submit_only_so_fast(make_server):
    server = make_server(TILECAST_MAX_SUBMISSIONS="3/minute").start()
    body = scene()
    for _ in range(3):
        assert server.client.post("/v1/jobs", json=body, headers={"Idempotency-Key": "a"}).status_code == 202
    for seed in range(2):
        server.submit(scene(seed=seed))
    answer = server.client.post("/v1/jobs", json=body)
    refused(answer, 429)
    assert 0 < int(answer.headers["retry-after"]) <= 60
