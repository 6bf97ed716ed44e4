"""The README is held to the truth: every command in it is run, every path in it is there."""

import os
import re
import select
import signal
import socket
import subprocess
import sys
import time
import urllib.request
from contextlib import contextmanager
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text()
BLOCKS = [text for _, text in re.findall(r"^```(\w+)\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)]
PATIENCE = 600  # seconds for a command, should it have to compile first

# Every block, by what it begins with. A block that is not here has no test yet.
DEMO, TEST, STRESS, SERVE, POST = "./dev demo\n", "./dev test\n", "./dev stress", "./dev serve\n", "job=$(curl"
RENDER, PYTHON, RAYS = ".venv/bin/tilecast render", "import tilecast\n", "import numpy as np\n"
ONE_TEST = "./dev test tests/python/"


def block(start: str) -> str:
    [text] = [text for text in BLOCKS if text.startswith(start)]
    return text


def run(command: str, patience: float = PATIENCE) -> str:
    """What bash printed; anything but success fails the test."""
    result = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", command],
        cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=patience,
    )  # fmt: skip
    assert result.returncode == 0, f"{command}\n{result.stdout}"
    return result.stdout


@contextmanager
def running(command: str, until: str):
    """A command that does not end by itself, once it has printed `until`; what it printed. Ctrl-C ends it, as a user would."""
    process = subprocess.Popen(
        ["bash", "-c", command], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True
    )
    try:
        yield read_until(process, until)
        os.killpg(process.pid, signal.SIGINT)
        process.wait(30)
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        process.stdout.close()


def read_until(process: subprocess.Popen, text: str) -> str:
    printed = b""
    end = time.monotonic() + PATIENCE
    while text.encode() not in printed:
        assert select.select([process.stdout], [], [], max(0, end - time.monotonic()))[0], printed.decode()
        more = os.read(process.stdout.fileno(), 65536)
        assert more, f"ended without printing {text!r}:\n{printed.decode()}"
        printed += more
    return printed.decode()


def get(address: str) -> bytes:
    with urllib.request.urlopen(address, timeout=10) as answer:
        return answer.read()


@pytest.fixture(scope="module")
def built():
    """What `./dev demo` or any other of its commands leaves behind, and the blocks after it rely on."""
    run("./dev build")


def test_every_block_has_a_test():
    known = (DEMO, TEST, STRESS, SERVE, POST, RENDER, PYTHON, RAYS, ONE_TEST)
    assert all(block(start) for start in known) and len(BLOCKS) == len(known)


def test_demo():
    picture = ROOT / "out" / "whitted.png"
    picture.unlink(missing_ok=True)
    with running(block(DEMO), until="Ctrl-C stops the server") as printed:
        [address] = set(re.findall(r"http://127\.0\.0\.1:\d+/", printed))
        assert b"<title>Tilecast</title>" in get(address)
        assert picture.read_bytes().startswith(b"\x89PNG")
        assert "   tile (" in printed
        assert len(re.findall(r": \d+\.\d s$", printed, re.MULTILINE)) >= 4, "each step says how long it took"
    with pytest.raises(OSError):
        get(address)


def test_test():
    # This is what is running now; once more, cut down to one file so that it ends.
    assert "passed" in run(f"{block(TEST).strip()} tests/python/test_layers.py")


def test_one_test():
    assert "passed" in run(block(ONE_TEST))


def test_stress(built):
    printed = run(block(STRESS))
    [(good, all_of_them)] = re.findall(r"^(\d+) of (\d+) hold, ", printed, re.MULTILINE)
    assert good == all_of_them and int(good) > 20


def test_serve_and_post(built, tmp_path):
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        port = listener.getsockname()[1]
    picture = ROOT / "out" / "cornell.png"
    picture.unlink(missing_ok=True)
    with running(f"{block(SERVE).strip()} --port {port} --data {tmp_path}", until=f"http://127.0.0.1:{port}/"):
        printed = run(block(POST).replace(":8000", f":{port}"))
    assert "event: tile" in printed and '"state":"done"' in printed
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_render_and_validate(built):
    run(block(RENDER))
    assert (ROOT / "out" / "cornell.exr").read_bytes().startswith(b"v/1\x01")
    assert (ROOT / "out" / "cornell-stats.json").stat().st_size > 0
    assert (ROOT / "out" / "depth.png").read_bytes().startswith(b"\x89PNG")
    assert (ROOT / "out" / "accelerators" / "table.txt").read_text().count("same") == 2
    assert (ROOT / "out" / "report" / "report.png").read_bytes().startswith(b"\x89PNG")


def python(code: str) -> str:
    result = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=PATIENCE)
    assert result.returncode == 0, result.stderr
    return result.stdout


def test_python(built):
    assert re.fullmatch(r"\(256, 256, 3\) [\d.e-]+\n", python(block(PYTHON)))


def test_rays(built):
    inside = float(python(block(RAYS)).removeprefix("inside: "))
    assert abs(inside - 1 / 6) < 5 * (5 / 36 / 100_000) ** 0.5  # five standard deviations


def test_paths_are_there():
    named = re.findall(r"`([\w.-]+/[\w./-]*)`", README) + re.findall(r"\]\(([\w./-]+)\)", README)
    assert len(named) > 15
    assert [path for path in named if not (ROOT / path).exists()] == []
