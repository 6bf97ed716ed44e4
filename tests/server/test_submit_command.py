"""`tilecast submit`, as a user calls it."""

import json
import subprocess
import sys
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import numpy as np
from servers import scene
from test_assets import tetrahedron

from tilecast import _images


def submit(server, *arguments: str) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", "tilecast", "submit", *arguments, "--server", server.url]
    return subprocess.run(command, capture_output=True, text=True, timeout=120)


def written(folder, document: dict) -> str:
    path = folder / "picture.json"
    path.write_text(json.dumps(document))
    return str(path)


def test_the_address_of_the_job_is_printed(server, tmp_path):
    done = submit(server, written(tmp_path, scene()), "--priority", "2")
    assert done.returncode == 0, done.stderr
    job = server.client.get(done.stdout.strip()).json()
    assert (job["name"], job["priority"]) == ("picture", 2)


def test_waiting_ends_with_the_image(server, tmp_path):
    for suffix, magic in ((".png", b"\x89PNG"), (".exr", b"v/1\x01")):
        image = tmp_path / f"out{suffix}"
        done = submit(server, written(tmp_path, scene(samples=8)), "-o", str(image))
        assert done.returncode == 0, done.stderr
        assert image.read_bytes().startswith(magic)
        assert "8 samples" in done.stderr


def test_files_beside_the_scene_are_sent(server, tmp_path):
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "shape.stl").write_bytes(tetrahedron(0.7))
    document = scene()
    document["objects"]["ball"] = {"type": "mesh", "file": "meshes/shape.stl"}
    _images.write(str(tmp_path / "around.exr"), np.ones((2, 4, 3), np.float32), ["R", "G", "B"])
    document["background"] = {"type": "image", "file": "around.exr"}
    done = submit(server, written(tmp_path, document), "--wait", "--quiet")
    assert (done.returncode, done.stderr) == (0, "")


def one_line(done: subprocess.CompletedProcess, status: int) -> str:
    assert done.returncode == status, done.stderr
    assert done.stderr.startswith("tilecast: ") and done.stderr.count("\n") == 1
    return done.stderr


def test_a_bad_scene_is_status_2(server, tmp_path):
    bad = scene()
    bad["objects"]["ball"]["radius"] = -1
    assert "objects.ball.radius" in one_line(submit(server, written(tmp_path, bad)), 2)
    missing = scene()
    missing["objects"]["ball"] = {"type": "mesh", "file": "nothing.ply"}
    assert "nothing.ply" in one_line(submit(server, written(tmp_path, missing)), 2)
    assert "there.json" in one_line(submit(server, str(tmp_path / "not-there.json")), 1)


def test_what_the_server_refuses_is_told(server, tmp_path):
    assert "render.samples" in one_line(submit(server, written(tmp_path, scene(samples=100_001))), 2)


def test_a_server_that_is_not_there_is_told(tmp_path):
    class Nowhere:
        url = "http://127.0.0.1:1/"

    assert "is the server running" in one_line(submit(Nowhere, written(tmp_path, scene())), 1)


def test_an_address_that_is_none_or_no_tilecast_is_told(tmp_path):
    class Page(BaseHTTPRequestHandler):
        def do_POST(self):
            self.rfile.read(int(self.headers["Content-Length"]))
            self.send_response(301 if self.path.startswith("/moved") else 200)
            self.end_headers()
            self.wfile.write(b"<html>")

        def log_message(self, *_):
            pass

    class Elsewhere:
        url = "http://[::1"

    path = written(tmp_path, scene())
    bad = submit(Elsewhere, path)
    assert bad.returncode == 2 and "is not an address" in bad.stderr and "Traceback" not in bad.stderr
    with ThreadingHTTPServer(("127.0.0.1", 0), Page) as page:
        threading.Thread(target=page.serve_forever, daemon=True).start()
        Elsewhere.url = f"http://127.0.0.1:{page.server_port}"
        assert "not a Tilecast server" in one_line(submit(Elsewhere, path), 1)
        Elsewhere.url += "/moved"
        assert "301" in one_line(submit(Elsewhere, path), 1)
        page.shutdown()


def test_waiting_outlives_a_restart(make_server, tmp_path):
    server = make_server().start()
    port = server.url.rsplit(":", 1)[1].strip("/")
    image = tmp_path / "out.png"
    command = [sys.executable, "-m", "tilecast", "submit", written(tmp_path, scene(width=128, height=96, samples=600)),
               "--server", server.url, "-o", str(image)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as waiting:
        waiting.stdout.readline()
        server.kill()
        time.sleep(6)
        server.start("--port", port)
        _, told = waiting.communicate(timeout=60)
    assert waiting.returncode == 0, told
    assert image.read_bytes().startswith(b"\x89PNG")


def test_a_job_that_is_given_up_is_status_1(server, tmp_path):
    command = [sys.executable, "-m", "tilecast", "submit", written(tmp_path, scene(width=128, height=96, samples=20_000)),
               "--server", server.url, "--wait"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as waiting:
        address = waiting.stdout.readline().strip()
        server.client.delete(address)
        _, told = waiting.communicate(timeout=60)
    assert waiting.returncode == 1 and "cancelled" in told
