"""Servers for tests: real processes, each with a data folder of its own, stopped when the test is over."""

import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import httpx2
import psutil
import pytest
from postgres import running
from sqlalchemy import create_engine, text

PATIENCE = 120.0  # seconds; a machine with other things to do may be slow


def scene(width: int = 32, height: int = 24, samples: int = 4, **render) -> dict:
    """A sphere on a floor. Small enough to be done at once, unless more samples are asked for."""
    return {
        "camera": {"position": [0, 1, 5], "target": [0, 0.2, 0]},
        "image": {"width": width, "height": height},
        "render": {"samples": samples, **render},
        "objects": {"ball": {"type": "sphere", "radius": 1}},
        "scene": [
            {"object": "ball", "material": {"type": "dielectric"}},
            {"object": {"type": "rectangle", "size": [10, 10]}, "transform": [{"translate": [0, -1, 0]}]},
        ],
        "lights": [{"type": "point", "position": [4, 6, 4], "intensity": [60, 60, 60]}],
        "background": [0.1, 0.1, 0.2],
    }


def long_scene(**render) -> dict:
    """Some seconds of work on two cores."""
    return scene(width=96, height=64, samples=1024, **render)


def until(condition: Callable[[], object], patience: float = PATIENCE):
    """Wait for `condition` to be true; what it gave."""
    end = time.monotonic() + patience
    while not (found := condition()):
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.03)
    return found


def gone(processes: list[psutil.Process]) -> bool:
    """Whether all of these processes have ended."""
    return not any(process.is_running() and process.status() != psutil.STATUS_ZOMBIE for process in processes)


class Server:
    """`tilecast serve` on a data folder, which may be started and killed again and again."""

    def __init__(self, folder: Path, *options: str, **environment: str):
        self.folder = folder
        self.log = folder.parent / f"{folder.name}.log"
        self._options = options
        self._environment = environment
        self._process: subprocess.Popen | None = None
        self.client = httpx2.Client()

    def start(self) -> "Server":
        began = self.log.stat().st_size if self.log.exists() else 0
        command = [sys.executable, "-m", "tilecast", "serve", "--data", str(self.folder), "--port", "0"]
        with self.log.open("ab") as log:
            # A process group of its own, as a terminal gives it: for tests that signal the group.
            self._process = subprocess.Popen(
                [*command, "--threads", "2", *self._options],
                stdout=log,
                stderr=log,
                env=os.environ | self._environment,
                start_new_session=True,
            )

        def ready() -> re.Match | None:
            text = self.log.read_text()[began:]
            assert self._process.poll() is None, text
            return re.search(r"Tilecast is at (http://[^/]+/)", text)

        self.url = until(ready)[1]
        self.client.close()
        self.client = httpx2.Client(base_url=self.url, timeout=PATIENCE)
        return self

    @property
    def pid(self) -> int:
        return self._process.pid

    def signal(self, number: int) -> int:
        """Send a signal and wait for the end of the process; its status."""
        self._process.send_signal(number)
        return self._process.wait(PATIENCE)

    def kill(self) -> None:
        self.signal(signal.SIGKILL)

    def stop(self) -> int:
        return self.signal(signal.SIGTERM)

    def children(self) -> list[psutil.Process]:
        return psutil.Process(self.pid).children(recursive=True)

    def workers(self) -> list[psutil.Process]:
        """The processes that render."""
        found = []
        for process in self.children():
            try:
                if "spawn_main" in " ".join(process.cmdline()):
                    found.append(process)
            except psutil.Error:
                continue  # ended in the meantime
        return found

    def close(self) -> None:
        self.client.close()
        if self._process is not None and self._process.poll() is None:
            self.kill()

    # --- What tests ask again and again

    def submit(self, document: dict, **fields) -> dict:
        answer = self.client.post("/v1/jobs", json={"scene": document, **fields} if fields else document)
        assert answer.status_code == 202, answer.text
        return answer.json()

    def job(self, job: dict) -> dict:
        answer = self.client.get(f"/v1/jobs/{job['id']}")
        assert answer.status_code == 200, answer.text
        return answer.json()

    def reach(self, job: dict, *states: str) -> dict:
        """The job, once it is in one of `states`."""

        def there() -> dict | None:
            now = self.job(job)
            if now["state"] in states:
                return now
            assert now["state"] not in ("done", "failed", "cancelled"), now
            return None

        return until(there)

    def progressed(self, job: dict, progress: float) -> dict:
        """The job, once it is so far, and not yet at its end."""

        def there() -> dict | None:
            now = self.job(job)
            assert now["state"] in ("queued", "running"), now
            return now if now["progress"] >= progress else None

        return until(there)


@pytest.fixture
def make_server(tmp_path: Path) -> Iterator[Callable[..., Server]]:
    """Makes servers that end with the test."""
    servers = []

    def make(*options: str, name: str = "data", **environment: str) -> Server:
        server = Server(tmp_path / name, *options, **environment)
        servers.append(server)
        return server

    yield make
    for server in servers:
        server.close()


@pytest.fixture(scope="session")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """One server for all tests that leave it as they found it, but for some jobs more."""
    limits = {
        "TILECAST_MAX_BODY": "200000",
        "TILECAST_MAX_ASSET": "100000",
        "TILECAST_MAX_PIXELS": "20000",
        "TILECAST_MAX_SAMPLES": "100000",
        "TILECAST_MAX_DEPTH": "64",
        "TILECAST_MAX_TRIANGLES": "1000",
        "TILECAST_MAX_JOBS": "1000",
        "TILECAST_MAX_SUBMISSIONS": "100000/minute",
    }
    server = Server(tmp_path_factory.mktemp("shared") / "data", **limits)
    try:
        yield server.start()
    finally:
        server.close()


@pytest.fixture(scope="session")
def postgres_server() -> Iterator[str]:
    """The URL of a PostgreSQL server of our own."""
    with tempfile.TemporaryDirectory(prefix="tilecast-postgres-") as folder:
        os.chmod(folder, 0o755)
        with running(Path(folder)) as url:
            yield url


@pytest.fixture
def postgres_url(postgres_server: str) -> str:
    """The URL of an empty PostgreSQL database."""
    engine = create_engine(postgres_server, isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        connection.execute(text("DROP DATABASE IF EXISTS test WITH (FORCE)"))
        connection.execute(text("CREATE DATABASE test STRATEGY file_copy"))
    engine.dispose()
    return postgres_server.replace("/postgres", "/test")
