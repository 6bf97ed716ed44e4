"""How the server starts, and how it says that it cannot."""

import os
import signal
import socket
import subprocess
import sys

import psutil
from servers import PATIENCE, gone, long_scene, until


def refusals(calls: dict[str, tuple[list[str], dict[str, str]]]) -> dict[str, tuple[int, str]]:
    """The status and the standard error of several calls of `tilecast serve`, made at the same time."""
    started = {
        name: subprocess.Popen(
            [sys.executable, "-m", "tilecast", "serve", *options],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=os.environ | environment,
        )
        for name, (options, environment) in calls.items()
    }
    ended = {}
    for name, process in started.items():
        out, told = process.communicate(timeout=PATIENCE)
        assert out == ""
        ended[name] = (process.returncode, told)
    return ended


def test_why_a_server_cannot_start_is_told_in_one_line(server, tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])

        def call(*options: str, **environment: str) -> tuple[list[str], dict[str, str]]:
            folder = tmp_path / str(len(calls))
            return ["--data", str(folder), "--port", "0", *options], environment

        calls: dict = {}
        calls["--port"] = call("--port", port)
        calls[f"process {server.pid}"] = call("--data", str(server.folder))
        calls["postgresql"] = call("--database", "postgresql+psycopg://me:secret@127.0.0.1:1/x")
        calls["blobs"] = call("--blobs", "ftp://example.com")
        calls["blobs at http://127.0.0.1:1/x"] = call("--blobs", "http://127.0.0.1:1/x")
        calls["belong to another database"] = call("--blobs", (server.folder / "blobs").as_uri())
        calls["scheduler tcp://127.0.0.1:1"] = call("--scheduler", "tcp://127.0.0.1:1")
        calls["TILECAST_MAX_PIXELS"] = call(TILECAST_MAX_PIXELS="many")
        calls["--scheduler"] = call("--scheduler", "here")
        ended = refusals(calls)
    for name, (status, told) in ended.items():
        assert told.startswith("tilecast: ") and told.count("\n") == 1, told
        assert name in told and "secret" not in told
        assert status == (2 if name.startswith("TILECAST") or name == "--scheduler" else 1)


# Makes a worker tell the scheduler that it lives without a pause, so that one such call is always under way.
EAGER_HEARTBEAT = """
import asyncio

def dask_setup(worker):
    async def beat():
        while worker.status.name == "init":
            await asyncio.sleep(0.01)
        while worker.status.name == "running":
            await worker.heartbeat()
    worker.beating = [asyncio.ensure_future(beat()) for _ in range(4)]
"""


def test_only_the_page_is_open_to_all_and_ctrl_c_ends_everybody(make_server, tmp_path):
    eager = tmp_path / "eager.py"
    eager.write_text(EAGER_HEARTBEAT)
    server = make_server("--host", "0.0.0.0", DASK_DISTRIBUTED__WORKER__PRELOAD=repr([str(eager)])).start()
    children = server.children()
    open_to_all = [
        connection.laddr.port
        for process in [psutil.Process(server.pid), *children]
        for connection in process.net_connections("tcp")
        if connection.status == psutil.CONN_LISTEN and connection.laddr.ip not in ("127.0.0.1", "::1")
    ]
    assert open_to_all == [int(server.url.rsplit(":", 1)[1].strip("/"))]
    # A terminal sends Ctrl-C to all of the group, workers included, and here in the middle of a job.
    server.progressed(server.submit(long_scene()), 0.01)
    os.killpg(server.pid, signal.SIGINT)
    assert server.signal(0) == 0
    until(lambda: gone(children), patience=20)
    assert "Traceback" not in server.log.read_text()
