"""Files that scenes name by their hash."""

import hashlib
import struct
import threading

import numpy as np
from servers import refused, scene

from tilecast import _images


def tetrahedron(scale: float = 1.0) -> bytes:
    """A closed mesh as a binary STL."""
    corners = [(scale, scale, scale), (scale, -scale, -scale), (-scale, scale, -scale), (-scale, -scale, scale)]
    faces = [(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)]
    out = b"\0" * 80 + struct.pack("<I", len(faces))
    for face in faces:
        out += struct.pack("<12fH", 0, 0, 0, *(value for corner in face for value in corners[corner]), 0)
    return out


def digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def with_mesh(data: bytes) -> dict:
    document = scene()
    document["objects"]["ball"] = {"type": "mesh", "file": f"sha256:{digest(data)}.stl"}
    return document


def test_a_mesh_is_sent_once_and_rendered(server):
    data = tetrahedron()
    address = f"/v1/assets/{digest(data)}"
    assert server.client.head(address).status_code == 404
    refused(server.client.post("/v1/jobs", json=with_mesh(data)), 422)
    assert server.client.put(address, content=data).status_code == 201
    answer = server.client.head(address)
    assert (answer.status_code, answer.headers["x-asset-size"]) == (200, str(len(data)))
    assert server.client.put(address, content=data).status_code == 204
    job = server.reach(server.submit(with_mesh(data)), "done")
    assert "mesh" in server.client.get(job["links"]["stats"]).json()["features"]["used"]


def test_a_streamed_asset_is_stored(server):
    data = tetrahedron(2)
    parts = (data[start : start + 100] for start in range(0, len(data), 100))
    assert server.client.put(f"/v1/assets/{digest(data)}", content=parts).status_code == 201


def test_other_bytes_than_promised_are_not_stored(server):
    wanted, sent = digest(b"this"), digest(b"that")
    problem = refused(server.client.put(f"/v1/assets/{wanted}", content=b"that"), 422)
    assert sent in problem["detail"]
    assert server.client.head(f"/v1/assets/{wanted}").status_code == 404
    assert not any((server.folder / "blobs" / "uploads").glob("*"))


def test_an_empty_asset_is_an_asset(server):
    assert server.client.put(f"/v1/assets/{digest(b'')}", content=b"").status_code == 201
    problem = refused(server.client.post("/v1/jobs", json=with_mesh(b"")), 422)
    assert problem["errors"][0]["path"] == "objects.ball.file"


def test_an_asset_over_the_limit_is_refused(server):
    data = b"x" * 100_001
    for content in (data, iter([data])):
        problem = refused(server.client.put(f"/v1/assets/{digest(data)}", content=content), 413)
        assert "100,000" in problem["detail"]
    assert server.client.head(f"/v1/assets/{digest(data)}").status_code == 404


def test_a_name_that_is_no_hash_is_refused(server):
    for name in ("x", "A" * 64, "0" * 63, "0" * 65, "..%2F..%2Flock"):
        assert server.client.put(f"/v1/assets/{name}", content=b"x").status_code in (404, 405, 422)
        assert server.client.head(f"/v1/assets/{name}").status_code in (404, 405, 422)


def test_a_file_that_is_no_mesh_is_told_at_its_place(server):
    for data in (b"solid nonsense", b"\xff" * 500, b"\0" * 84):
        server.client.put(f"/v1/assets/{digest(data)}", content=data)
        problem = refused(server.client.post("/v1/jobs", json=with_mesh(data)), 422)
        assert problem["errors"][0]["path"].startswith("objects.ball")


def test_an_image_of_a_texture_is_an_asset_and_told_at_its_place(server):
    def with_image(data: bytes) -> dict:
        document = scene()
        document["scene"][0]["material"] = {
            "type": "diffuse", "reflectance": {"type": "image", "file": f"sha256:{digest(data)}.png"}}
        return document

    white = _images.encode("png", np.full((2, 2, 3), 255, np.uint8), ["R", "G", "B"])
    for data, expected in ((b"no image", 422), (white, 202)):
        problem = refused(server.client.post("/v1/jobs", json=with_image(data)), 422)
        assert problem["errors"][0]["path"] == "scene[0].material.reflectance.file"
        server.client.put(f"/v1/assets/{digest(data)}", content=data)
        answer = server.client.post("/v1/jobs", json=with_image(data))
        assert answer.status_code == expected
        if expected == 422:
            assert refused(answer, 422)["errors"][0]["path"] == "scene[0].material.reflectance.file"
    job = server.reach(answer.json(), "done")
    assert "image_texture" in server.client.get(job["links"]["stats"]).json()["features"]["used"]


def test_the_same_asset_sent_by_many_at_once_is_stored_once(server):
    data = tetrahedron(3) + b"!" * 50_000
    answers = []

    def put() -> None:
        answers.append(server.client.put(f"/v1/assets/{digest(data)}", content=data).status_code)

    threads = [threading.Thread(target=put) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert set(answers) <= {201, 204} and 201 in answers
    assert server.client.head(f"/v1/assets/{digest(data)}").headers["x-asset-size"] == str(len(data))
    assert not any((server.folder / "blobs" / "uploads").glob("*"))
