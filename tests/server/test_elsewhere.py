"""What runs elsewhere: a cluster, a database, and those who wait to be called back."""

import json
import os
import socket
import subprocess
import sys
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import dask
import numpy as np
import pytest
import yaml
from distributed.comm import CommClosedError
from servers import exr, locally, long_scene, scene, until

from tilecast.jobs import engine


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


def test_a_result_that_is_lost_on_its_way_is_asked_for_again(tmp_path):
    """As where the worker that holds it, or the scheduler, dies while it is fetched: Dask says so with this error."""
    def lost_once(seen):
        if not seen.exists():
            seen.touch()
            raise CommClosedError("in <TCP (closed) ConnectionPool.gather>: Stream is closed")
        return 7

    executor = engine.Engine(None, 1, tmp_path / "dask", stuck_seconds=60.0)
    try:
        assert executor.submit(lost_once, tmp_path / "seen").result(timeout=60) == 7
    finally:
        executor.shutdown()


def test_workers_in_the_compose_file_treat_memory_as_our_own_cluster_does():
    """Dask's defaults pause a worker at 80 % of its memory, for good, and all jobs with it."""
    compose = yaml.safe_load((Path(__file__).resolve().parents[2] / "docker" / "compose.yaml").read_text())
    given = dask.config.collect_env({name: str(value) for name, value in compose["services"]["worker"]["environment"].items()})
    memory = {name: value for name, value in engine._LOCAL_SETTINGS.items() if "worker.memory" in name}
    assert len(memory) == 4
    assert {name: dask.config.get(name, config=given) for name in memory} == memory


class Listener:
    """An address that is called back; it fails the first `failures` calls, and answers while
    it is `open`."""

    def __init__(self, failures: int = 0):
        self.heard: list[dict] = []
        self.calls = 0
        self.failures = failures
        self.open = threading.Event()
        self.open.set()
        listener = self

        class Handler(BaseHTTPRequestHandler):
            def do_POST(self):
                body = self.rfile.read(int(self.headers["Content-Length"]))
                listener.calls += 1
                listener.open.wait()
                failed = listener.calls <= listener.failures
                if not failed:
                    listener.heard.append(json.loads(body))
                self.send_response(500 if failed else 204)
                self.end_headers()

            def log_message(self, *_):
                pass

        self.server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
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


def test_an_address_that_never_answers_holds_up_no_other(server):
    with socket.create_server(("127.0.0.1", 0)) as silent:  # it takes connections, and no more
        for _ in range(3):
            server.submit(scene(), callback=f"http://127.0.0.1:{silent.getsockname()[1]}/")
        listener = Listener()
        server.reach(server.submit(scene(), callback=listener.url), "done")
        until(lambda: listener.heard, patience=8)


def test_the_end_after_a_retry_is_told_although_the_end_before_it_is_being_told(server):
    listener = Listener()
    listener.open.clear()
    job = server.submit(scene(samples=500), callback=listener.url)
    server.client.delete(job["links"]["self"])
    until(lambda: listener.calls == 1)
    assert server.client.post(f"{job['links']['self']}/retry").status_code == 202
    server.reach(job, "done")
    listener.open.set()
    until(lambda: "done" in [told["state"] for told in listener.heard])


def test_a_killed_server_goes_on_with_postgresql_and_calls_back(make_server, postgres_url, tmp_path):
    server = make_server("--database", postgres_url).start()
    listener = Listener(failures=10_000)
    told = server.reach(server.submit(scene(), callback=listener.url), "done")
    document = long_scene(seed=12)
    job = server.submit(document)
    server.progressed(job, 0.2)
    server.kill()
    listener.failures = 0
    server.start()
    until(lambda: listener.heard)
    assert listener.heard == [told]
    server.reach(job, "done")
    assert np.array_equal(exr(server, job, tmp_path), locally(document))
    assert not list(server.folder.glob("*.db"))
