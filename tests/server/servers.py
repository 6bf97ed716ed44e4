"""Servers as real processes, and what tests ask of them again and again."""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import httpx2
import numpy as np
import psutil

from tilecast import _images
from tilecast import scene as scenes
from tilecast.render import local

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

    def start(self, *options: str) -> "Server":
        began = self.log.stat().st_size if self.log.exists() else 0
        command = [sys.executable, "-m", "tilecast", "serve", "--data", str(self.folder), "--port", "0"]
        with self.log.open("ab") as log:
            # A process group of its own, as a terminal gives it: for tests that signal the group.
            self._process = subprocess.Popen(
                [*command, "--threads", "2", *self._options, *options],
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


def locally(document: dict) -> np.ndarray:
    """The pixels of a scene as this process renders them."""
    compiled = scenes.compile(scenes.parse(document), lambda name: b"")
    return local.render(compiled, threads=2).pixels


def exr(server: Server, job: dict, tmp_path: Path) -> np.ndarray:
    """The pixels of a job, float32 [height, width, 3]."""
    answer = server.client.get(f"/v1/jobs/{job['id']}/image.exr")
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"] == "image/x-exr"
    path = tmp_path / "image.exr"
    path.write_bytes(answer.content)
    pixels, channels, *_ = _images.read(str(path))
    assert channels[:3] == ["R", "G", "B"]
    return pixels[..., :3]


def refused(answer: httpx2.Response, status: int) -> dict:
    """The problem that an answer is."""
    assert answer.status_code == status, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    problem = answer.json()
    assert problem["status"] == status and problem["title"] and problem["detail"]
    assert problem["type"].startswith("urn:tilecast:problem:")
    return problem
