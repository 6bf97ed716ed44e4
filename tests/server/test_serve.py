"""How the server starts, and how it says that it cannot."""

import socket
import subprocess
import sys
import time

import psutil
import pytest
from conftest import scene


def serve(*options: str, **environment) -> subprocess.CompletedProcess:
    import os

    command = [sys.executable, "-m", "tilecast", "serve", *options]
    return subprocess.run(command, capture_output=True, text=True, timeout=90, env=os.environ | environment)


def one_line(done: subprocess.CompletedProcess, status: int = 1) -> str:
    assert done.returncode == status, done.stderr
    assert done.stderr.count("\n") == 1 and done.stderr.startswith("tilecast: ")
    assert done.stdout == ""
    return done.stderr


def test_a_port_in_use_is_told_in_one_line(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        told = one_line(serve("--data", str(tmp_path), "--port", str(port)))
    assert str(port) in told and "--port" in told


def test_a_second_server_on_the_same_data_is_refused(server):
    told = one_line(serve("--data", str(server.folder), "--port", "0"))
    assert str(server.pid) in told and "--data" in told


def test_the_lock_goes_with_its_process(make_server):
    server = make_server().start()
    server.kill()
    server.start()


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--database", "nonsense"], "database"),
        (["--database", "postgresql+psycopg://me:secret@127.0.0.1:1/x"], "database"),
        (["--blobs", "ftp://example.com"], "blobs"),
        (["--scheduler", "tcp://127.0.0.1:1"], "scheduler"),
        (["--host", "no.such.host.invalid"], "no.such.host.invalid"),
    ],
)
def test_what_cannot_be_had_is_told_in_one_line(tmp_path, options, told):
    line = one_line(serve("--data", str(tmp_path), "--port", "0", *options))
    assert told in line and "secret" not in line


@pytest.mark.parametrize(("name", "value"), [("TILECAST_MAX_PIXELS", "many"), ("TILECAST_MAX_SUBMISSIONS", "some"),
                                             ("TILECAST_PORT", "99999"), ("TILECAST_SCHEDULER", "here")])
def test_a_bad_setting_is_told_by_its_name(tmp_path, name, value):
    assert name in one_line(serve("--data", str(tmp_path), **{name: value}), status=2)


def test_nothing_but_the_page_listens_beyond_the_loopback(make_server):
    server = make_server("--host", "0.0.0.0").start()
    open_to_all = [
        connection.laddr.port
        for process in [psutil.Process(server.pid), *server.children()]
        for connection in process.net_connections("tcp")
        if connection.status == psutil.CONN_LISTEN and connection.laddr.ip not in ("127.0.0.1", "::1")
    ]
    assert open_to_all == [int(server.url.rsplit(":", 1)[1].strip("/"))]


def test_a_worker_ends_when_its_server_is_killed(make_server):
    server = make_server().start()
    server.submit(scene())
    children = server.children()
    assert server.workers()
    server.kill()
    end = time.monotonic() + 20
    while any(child.is_running() and child.status() != psutil.STATUS_ZOMBIE for child in children):
        assert time.monotonic() < end
        time.sleep(0.05)
