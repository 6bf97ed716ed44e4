"""What a user may have at once, and how fast."""

from conftest import long_scene, scene
from test_bad_input import refused


def test_a_user_may_have_only_so_many_jobs(make_server):
    server = make_server(TILECAST_MAX_JOBS="2", TILECAST_USER_HEADER="X-User").start()
    jobs = [server.submit(long_scene(seed=seed)) for seed in range(2)]
    answer = server.client.post("/v1/jobs", json=scene())
    refused(answer, 429)
    assert int(answer.headers["retry-after"]) > 0
    # Another user is not affected, and one job less makes room.
    assert server.client.post("/v1/jobs", json=scene(), headers={"X-User": "somebody else"}).status_code == 202
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


def test_users_take_turns(make_server):
    """A user with one small job does not wait for another one's long ones."""
    server = make_server(TILECAST_USER_HEADER="X-User").start()
    for seed in range(3):
        long = server.client.post("/v1/jobs", json=long_scene(seed=seed), headers={"X-User": "busy"}).json()
    small = server.client.post("/v1/jobs", json=scene(), headers={"X-User": "modest"}).json()
    server.reach(small, "done")
    assert server.job(long)["state"] in ("queued", "running")
