"""What runs elsewhere: a cluster, a database, and those who wait to be called back."""

import json
import os
import subprocess
import sys
import threading
from http.server import BaseHTTPRequestHandler, HTTPServer

import numpy as np
import pytest
from conftest import long_scene, scene, until
from test_jobs import exr, locally


@pytest.fixture
def cluster(tmp_path):
    """Starts schedulers and workers of Dask, as an operator would: (start, address)."""
    processes = []
    environment = os.environ | {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0"}
    address_file = tmp_path / "scheduler.json"

    def start(program: str, *options: str) -> subprocess.Popen:
        command = [sys.executable, "-m", "distributed.cli.dask_" + program, *options, "--no-dashboard"]
        with (tmp_path / f"{program}.log").open("ab") as log:
            processes.append(subprocess.Popen(command, stdout=log, stderr=log, env=environment, cwd=tmp_path))
        return processes[-1]

    def begin(port: int = 0) -> str:
        address_file.unlink(missing_ok=True)
        start("scheduler", "--host", "127.0.0.1", "--port", str(port), "--scheduler-file", str(address_file))

        def written() -> str | None:
            try:
                return json.loads(address_file.read_text())["address"]
            except (OSError, ValueError):
                return None

        return until(written)

    begin.worker = lambda address: start("worker", address, "--nworkers", "1", "--nthreads", "1",
                                         "--local-directory", str(tmp_path))
    begin.processes = processes
    yield begin
    for process in processes:
        process.kill()
        process.wait()


def test_a_running_cluster_renders_and_may_lose_everything(cluster, make_server, tmp_path):
    address = cluster()
    server = make_server("--scheduler", address).start()
    # Without a worker, jobs wait.
    assert server.client.get("/readyz").status_code == 503
    cluster.worker(address)
    until(lambda: server.client.get("/readyz").status_code == 200)
    document = long_scene(seed=11)
    job = server.submit(document)
    server.progressed(job, 0.1)
    # The scheduler dies, and with it all that it knew; another one starts at the same address.
    scheduler, worker = cluster.processes
    for process in (scheduler, worker):
        process.kill()
        process.wait()
    until(lambda: server.client.get("/readyz").status_code == 503)
    assert cluster(int(address.rsplit(":", 1)[1])) == address
    cluster.worker(address)
    server.reach(job, "done")
    assert np.array_equal(exr(server, job, tmp_path), locally(document))


def test_a_killed_server_goes_on_with_postgresql(make_server, postgres_url, tmp_path):
    server = make_server("--database", postgres_url).start()
    document = long_scene(seed=12)
    job = server.submit(document)
    server.progressed(job, 0.2)
    server.kill()
    server.start()
    server.reach(job, "done")
    assert np.array_equal(exr(server, job, tmp_path), locally(document))
    assert not list(server.folder.glob("*.db"))


class Listener:
    """An address that is called back; it fails the first `failures` calls."""

    def __init__(self, failures: int = 0):
        self.heard: list[dict] = []
        self.calls = 0
        listener = self

        class Handler(BaseHTTPRequestHandler):
            def do_POST(self):
                body = self.rfile.read(int(self.headers["Content-Length"]))
                listener.calls += 1
                failed = listener.calls <= failures
                if not failed:
                    listener.heard.append(json.loads(body))
                self.send_response(500 if failed else 204)
                self.end_headers()

            def log_message(self, *_):
                pass

        self.server = HTTPServer(("127.0.0.1", 0), Handler)
        self.url = f"http://127.0.0.1:{self.server.server_port}/done"
        threading.Thread(target=self.server.serve_forever, daemon=True).start()


def test_a_callback_is_told_of_the_end(server):
    listener = Listener(failures=1)
    job = server.submit(scene(), callback=listener.url)
    server.reach(job, "done")
    until(lambda: listener.heard)
    assert listener.heard == [server.job(job)] and listener.calls == 2
    cancelled = server.submit(long_scene(), callback=listener.url)
    server.client.delete(cancelled["links"]["self"])
    until(lambda: len(listener.heard) == 2)
    assert listener.heard[1]["state"] == "cancelled"


def test_a_callback_that_was_due_at_a_kill_is_made_up_for(make_server):
    with_nobody = "http://127.0.0.1:9/"
    server = make_server().start()
    job = server.submit(scene(), callback=with_nobody)
    server.reach(job, "done")
    server.kill()
    # The address gets somebody who listens.
    import sqlite3

    listener = Listener()
    with sqlite3.connect(server.folder / "tilecast.db") as database:
        database.execute("UPDATE jobs SET callback = ?", (listener.url,))
    server.start()
    until(lambda: listener.heard)
    assert listener.heard[0]["id"] == job["id"]


def test_callbacks_can_be_switched_off(make_server):
    server = make_server(TILECAST_CALLBACKS="false").start()
    answer = server.client.post("/v1/jobs", json={"scene": scene(), "callback": "http://127.0.0.1:9/"})
    assert answer.status_code == 422 and answer.json()["errors"][0]["path"] == "callback"
