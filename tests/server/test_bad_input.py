"""Whatever is sent, the answer is one clear refusal, never a failure of the server's."""

import gzip
import json
import os
import subprocess
import sys
import threading
import time

import pytest
from servers import refused, scene


BODIES = {
    "nothing": b"",
    "white space": b" \n\t ",
    "no JSON": b"a picture, please",
    "half a document": json.dumps(scene()).encode()[:-1],
    "more than a document": json.dumps(scene()).encode() + b"{}",
    "null": b"null",
    "a number": b"17",
    "a text": b'"scene"',
    "a list": b"[]",
    "an empty object": b"{}",
    "no UTF-8": b'{"camera": "\xff\xfe"}',
    "UTF-16": json.dumps(scene()).encode("utf-16"),
    "NUL bytes": b"\0" * 1000,
    "1,000 levels": b"[" * 1000 + b"]" * 1000,
    "1,000 levels of objects": b'{"a":' * 1000 + b"1" + b"}" * 1000,
    "50,000 levels": b"[" * 50_000 + b"]" * 50_000,
    "50,000 levels, not closed": b'{"scene":' + b"[" * 50_000,
    "1,000 levels in the scene": b'{"scene":{"scene":' + b"[" * 1000 + b"]" * 1000 + b"}}",
    "a number of thousands of digits": b'{"version": ' + b"9" * 5000 + b"}",
    "half a surrogate pair": b'{"\\ud800": 1}',
    "half a surrogate pair as a type": b'{"camera": {"type": "\\udfff"}}',
    "a key twice": b'{"version": 1, "version": 1}',
}


@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
def test_what_is_no_scene_is_refused(server, body):
    refused(server.client.post("/v1/jobs", content=body), 422)


def changed(path: str, value) -> dict:
    """The test scene with one value replaced; `path` like objects.ball.radius."""
    document = scene()
    *parents, last = path.split(".")
    place = document
    for part in parents:
        place = place[int(part)] if isinstance(place, list) else place[part]
    place[last] = value
    return document


@pytest.mark.parametrize(
    ("path", "value", "told"),
    [
        ("objects.ball.radius", -0.5, "objects.ball.radius"),
        ("objects.ball.radius", 0, "objects.ball.radius"),
        ("objects.ball.radius", "1", "objects.ball.radius"),
        ("objects.ball.radius", True, "objects.ball.radius"),
        ("objects.ball.radius", None, "objects.ball.radius"),
        ("objects.ball.radius", [1], "objects.ball.radius"),
        ("objects.ball.colour", "red", "objects.ball.colour"),
        ("objects.ball.type", "ball", "objects.ball.type"),
        ("scene.0.object", "bal", "scene[0].object"),
        ("scene.0.material", "brass", "scene[0].material"),
        ("scene.0.transform", [{"scale": 0}], "scene[0].transform[0].scale"),
        ("scene.0.transform", [{"scale": [1, 0, 1]}], "scene[0].transform[0].scale[1]"),
        ("scene.0.transform", [[1, 2, 3, 4]] * 4, "scene[0].transform"),
        ("scene.0.transform", [{"scale": 1e-200}, {"scale": 1e-200}], "scene[0].transform"),
        ("camera.fov", 180, "camera.fov"),
        ("camera.target", [0, 1, 5], "camera.target"),
        ("render.integrator", "magic", "render.integrator"),
        ("render.samples", 2.5, "render.samples"),
        ("render.accelerator", "kdtree", "render.accelerator"),
        ("image.width", 0, "image.width"),
        ("image.width", 1e30, "image.width"),
        ("version", 2, "version"),
        ("nonsense", 1, "nonsense"),
        ("objects.ball", {"type": "union", "of": [{"object": "ball"}, {"type": "sphere", "radius": 1}]}, "objects.ball"),
        ("objects.ball", {"type": "mesh", "vertices": [[0, 0, 0]], "faces": [[0, 1, 2]]}, "objects.ball.faces[0][1]"),
        ("objects.ball", {"type": "mesh", "file": "/etc/passwd"}, "objects.ball.file"),
        ("objects.ball", {"type": "mesh", "file": "../../etc/passwd.ply"}, "objects.ball.file"),
        ("objects.ball", {"type": "mesh", "file": "http://example.com/a.ply"}, "objects.ball.file"),
        ("objects.ball", {"type": "mesh", "file": "bunny.ply"}, "objects.ball.file"),
        ("objects.ball", {"type": "mesh", "file": f"sha256:{'0' * 64}.ply"}, "objects.ball.file"),
    ],
)
@pytest.mark.parametrize("wrapped", [False, True], ids=["bare", "wrapped"])
def test_a_bad_scene_is_told_with_its_place(server, path, value, told, wrapped):
    document = changed(path, value)
    problem = refused(server.client.post("/v1/jobs", json={"scene": document} if wrapped else document), 422)
    assert problem["errors"][0]["path"].startswith(told)
    assert problem["errors"][0]["message"]
    assert problem["detail"] == f"{problem['errors'][0]['path']}: {problem['errors'][0]['message']}"


@pytest.mark.parametrize("number", ["NaN", "Infinity", "-Infinity", "1e999", "-1e999"])
@pytest.mark.parametrize("place", ["camera", "vertex", "material"])
def test_what_is_no_number_is_refused(server, number, place):
    text = {
        "camera": changed("camera.fov", "#"),
        "vertex": changed("objects.ball", {"type": "mesh", "vertices": [[0, 0, "#"]] * 3, "faces": [[0, 1, 2]]}),
        "material": changed("scene.0.material", {"type": "dielectric", "ior": "#"}),
    }[place]
    refused(server.client.post("/v1/jobs", content=json.dumps(text).replace('"#"', number).encode()), 422)


@pytest.mark.parametrize("wrapped", [False, True], ids=["bare", "wrapped"])
@pytest.mark.parametrize(
    ("text", "twice", "path"),
    [
        ('"samples": 4', '"samples": 4, "samples": 4', "render.samples"),
        ('"ball": {', '"a b": {"a": 1, "a": 1}, "ball": {', 'objects["a b"].a'),
        ('"object": "ball"', '"object": "ball", "object": "ball"', "scene[0].object"),
        ('"camera": {', '"": {"a": 1, "a": 1}, "camera": {', '[""].a'),
    ],
)
def test_a_key_given_twice_is_told_with_its_place(server, text, twice, path, wrapped):
    body = json.dumps(scene()).replace(text, twice)
    problem = refused(server.client.post("/v1/jobs", content='{"name": "x", "scene": %s}' % body if wrapped else body), 422)
    assert [error["path"] for error in problem["errors"]] == [path]


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("name", 5),
        ("name", "x" * 201),
        ("name", "\ud800"),
        ("name", "a\0b"),
        ("priority", "high"),
        ("priority", 1e9),
        ("priority", 1.5),
        ("priority", True),
        ("callback", "ftp://example.com/"),
        ("callback", "not a URL"),
        ("callback", "http://"),
        ("callback", "http://[::1/"),
        ("callback", "http://user:secret@example.com/"),
        ("callback", "http://example.com:99999/"),
        ("owner", "me"),
    ],
)
def test_a_bad_wrapper_is_told_with_its_place(server, field, value):
    problem = refused(server.client.post("/v1/jobs", content=json.dumps({"scene": scene(), field: value})), 422)
    assert problem["errors"][0]["path"] == field


@pytest.mark.parametrize(
    "body",
    [b"", b"[]", b"null", b"{", b'{"state": "done"}', b'{"state": 1}', b'{"priority": "1"}', b'{"priority": NaN}',
     b'{"name": "x"}', b'{"priority": 1, "priority": 2}', b"\xff", b"[" * 1000],
)
def test_a_bad_change_is_refused(server, body):
    job = server.submit(scene())
    refused(server.client.patch(job["links"]["self"], content=body), 422)


@pytest.mark.parametrize(
    "media_type", ["image/png", "text/html", "application/xml", "multipart/form-data; boundary=x", "nonsense", "é"]
)
def test_other_content_types_are_refused(server, media_type):
    headers = {"Content-Type": media_type.encode("latin-1")}
    refused(server.client.post("/v1/jobs", content=json.dumps(scene()).encode(), headers=headers), 415)


def test_compressed_bodies_are_refused(server):
    body = gzip.compress(b" " * 10_000_000)
    headers = {"Content-Type": "application/json", "Content-Encoding": "gzip"}
    refused(server.client.post("/v1/jobs", content=body, headers=headers), 415)


@pytest.mark.parametrize("method", ["POST", "PATCH"])
@pytest.mark.parametrize("declared", [True, False], ids=["declared", "streamed"])
def test_a_body_over_the_limit_is_refused(server, method, declared):
    path = "/v1/jobs" if method == "POST" else server.submit(scene())["links"]["self"]
    body = b" " * 200_001
    problem = refused(server.client.request(method, path, content=body if declared else iter([body])), 413)
    assert "200,000" in problem["detail"]


@pytest.mark.parametrize(
    ("document", "path"),
    [
        (scene(width=200, height=101), "image"),
        (scene(samples=100_001), "render.samples"),
        (scene(max_depth=65), "render.max_depth"),
        (changed("objects.ball", {"type": "mesh", "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
                                  "faces": [[0, 1, 2]] * 1001}), "objects.ball"),
    ],
)
def test_scenes_over_the_limits_are_refused(server, document, path):
    problem = refused(server.client.post("/v1/jobs", json=document), 422)
    assert problem["errors"][0]["path"] == path


def test_several_faults_are_told_at_once(server):
    document = changed("camera.fov", -1) | {"unknown": 1}
    problem = refused(server.client.post("/v1/jobs", json=document), 422)
    assert {error["path"] for error in problem["errors"]} == {"camera.fov", "unknown"}


@pytest.mark.parametrize("path", ["/v1/jobs/nothing", "/v1/jobs/nothing/tiles", "/v1/jobs/nothing/image.png",
                                  "/v1/jobs/nothing/events", "/v1/jobs/nothing/curve", "/v1/jobs/nothing/stats",
                                  "/v1/jobs/nothing/tiles/0/0.png", "/v1/scenes/nothing", "/v2", "/web/nothing.js",
                                  "/v1/jobs/%00", "/v1/jobs/%ff", "/v1/jobs/" + "x" * 60])
def test_what_is_not_there_is_404(server, path):
    refused(server.client.get(path), 404)


def test_tiles_outside_the_image_are_404(server):
    job = server.submit(scene())
    for place in ("99/0", "0/99"):
        refused(server.client.get(f"{job['links']['tiles']}/{place}.png"), 404)
    for place in ("-1/0", "a/b", "0/99999999999999999999"):
        assert server.client.get(f"{job['links']['tiles']}/{place}.png").status_code in (404, 422)
    assert server.client.get(f"{job['links']['tiles']}/0/0.gif").status_code in (404, 422)


@pytest.mark.parametrize("query", ["limit=0", "limit=201", "limit=x", "state=sleeping", "after=x", "after=-1",
                                   "after=99999999999999999999", "after=%00"])
def test_bad_queries_are_refused(server, query):
    refused(server.client.get(f"/v1/jobs?{query}"), 422)


def test_other_methods_are_refused(server):
    for path, allowed in (("/v1/jobs", {"GET", "POST"}), ("/v1/jobs/x", {"GET", "PATCH", "DELETE"}),
                          (f"/v1/assets/{'0' * 64}", {"HEAD", "PUT"}), ("/healthz", {"GET"})):
        answer = server.client.request("OPTIONS", path)
        problem = refused(answer, 405)
        assert set(answer.headers["allow"].split(", ")) == allowed
        assert "OPTIONS" in problem["detail"] and answer.headers["allow"] in problem["detail"]


@pytest.mark.parametrize("event", ["x", "-1", "1e9", "99999999999999999999", "½", "１"])
def test_a_nonsensical_last_event_is_taken_for_none(server, event):
    job = server.reach(server.submit(scene()), "done")
    answer = server.client.get(job["links"]["events"], headers={"Last-Event-ID": event.encode("utf-8")})
    assert "event: state" in answer.text


def test_a_hostile_body_does_not_hold_up_the_others(make_server):
    """A body of the largest size that is allowed by default, while somebody else asks for the server's health."""
    server = make_server().start()
    mesh = {"type": "mesh", "vertices": [[0.123456, 1.234567, 2.345678]] * 350_000, "faces": [[0, 1, 2]] * 350_000}
    body = json.dumps(changed("objects.ball", mesh)).encode()
    assert 14e6 < len(body) < 16 * 2**20
    answers = []
    thread = threading.Thread(target=lambda: answers.append(server.client.post("/v1/jobs", content=body)))
    # In another process: this one is busy sending.
    probe = subprocess.Popen(
        [sys.executable, "-c", PROBE, f"{server.url}healthz"], stdout=subprocess.PIPE, stdin=subprocess.PIPE, text=True
    )
    began = time.monotonic()
    thread.start()
    thread.join()
    took = time.monotonic() - began
    longest = float(probe.communicate("\n")[0])
    assert answers[0].status_code == 202, answers[0].text
    assert longest < took / 2, f"nobody was answered for {longest:.1f} of {took:.1f} s"


PROBE = """
import select, sys, time, urllib.request
longest = 0.0
while not select.select([sys.stdin], [], [], 0.01)[0]:
    began = time.monotonic()
    urllib.request.urlopen(sys.argv[1]).read()
    longest = max(longest, time.monotonic() - began)
print(longest)
"""


def test_a_server_that_was_tormented_still_works(server):
    server.reach(server.submit(scene()), "done")
    assert "request_failed" not in server.log.read_text()
    assert os.path.exists(server.folder / "tilecast.db")
