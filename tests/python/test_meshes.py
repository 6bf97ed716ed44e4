"""Mesh files of every format are read; what is wrong with one is told in one line."""

import json
import os
import re
import time

import numpy as np
import pytest
import trimesh
from documents import minimal
from hypothesis import given
from hypothesis import strategies as st

import tilecast
from tilecast.scene import SceneError, meshes

PLY = """ply
format ascii 1.0
element vertex {vertices}
property float x
property float y
property float z
element face {faces}
property list uchar int vertex_indices
end_header
"""


def ply(vertices, faces) -> bytes:
    rows = [" ".join(map(str, vertex)) for vertex in vertices]
    rows += [" ".join(map(str, (len(face), *face))) for face in faces]
    return (PLY.format(vertices=len(vertices), faces=len(faces)) + "\n".join(rows) + "\n").encode()


def exported(kind: str) -> bytes:
    data = trimesh.creation.icosphere(subdivisions=1).export(file_type=kind)
    return data.encode() if isinstance(data, str) else data


SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


@pytest.mark.parametrize("kind", ["ply", "obj", "stl", "glb"])
def test_a_sphere_comes_back_from_every_format(kind):
    vertices, faces, _ = meshes.load(exported(kind), f"sphere.{kind}")
    assert vertices.dtype == np.float64 and faces.dtype == np.uint32
    assert faces.shape == (80, 3)
    assert np.allclose(np.linalg.norm(vertices, axis=1), 1, atol=1e-6)
    corners = vertices[faces]
    volume = np.einsum("ni,ni->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert volume == pytest.approx(trimesh.creation.icosphere(subdivisions=1).volume, rel=1e-6)


@pytest.mark.parametrize("kind", ["ply", "obj", "stl", "glb"])
def test_every_format_is_closed_enough_for_csg(kind, tmp_path):
    (tmp_path / f"sphere.{kind}").write_bytes(exported(kind))
    scene = minimal(scene=[{"object": {"type": "difference", "of": [
        {"type": "box", "min": [-2, -2, -2], "max": [2, 2, 2]}, {"type": "mesh", "file": f"sphere.{kind}"}]}}])
    loaded = tilecast.load(scene, folder=tmp_path)
    hits = loaded.crossings(np.array([[0.01, 0.02, 9.0]]), np.array([[0.0, 0.0, -1.0]]))
    assert len(hits.t) == 4


def test_faces_of_many_corners_are_cut_into_triangles():
    _, faces, _ = meshes.load(ply(SQUARE, [(0, 1, 2, 3)]), "square.ply")
    assert len(faces) == 2
    obj = b"v 0 0 0\nv 2 0 0\nv 3 1 0\nv 1 3 0\nv 0 1 0\nf 1 2 3 4 5\nf 1 2 3\nf -5 -4 -3 -2\n"
    vertices, faces, _ = meshes.load(obj, "mixed.obj")
    assert len(faces) == 3 + 1 + 2
    assert faces.max() < len(vertices)


def test_negative_numbers_of_an_obj_count_from_their_line():
    blocks = "".join(f"v 0 0 {z}\nv 1 0 {z}\nv 1 1 {z}\nvt 0.{z} 0\nvt 0.{z} 1\nvt 1 1\nf -3/-3 -2/-2 -1/-1\n"
                     for z in range(1, 4))
    vertices, faces, uvs = meshes.load(blocks.encode(), "blocks.obj", with_uvs=True)
    assert vertices[faces][:, :, 2].tolist() == [[z] * 3 for z in range(1, 4)]
    assert np.allclose(uvs[:, 0, 0], [0.1, 0.2, 0.3])


def test_an_obj_may_be_untidy():
    tidy = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 5 5 5\nf 1 2 3\nf 1 3 4\n"
    untidy = b"# a\nv 0 0 0 # b\nv\t1 0 0\n  v 1 1 0\nv 5 5 5\r\n\tf 1 2 \\\n3\n  f 1 3\t4# c\n"
    for a, b in zip(meshes.load(tidy, "a.obj")[:2], meshes.load(untidy, "b.obj")[:2]):
        assert np.array_equal(a, b)


@pytest.mark.parametrize("order", ["<", ">"])
def test_a_binary_ply_of_different_faces_is_refused_rather_than_misread(order):
    head = PLY.format(vertices=6, faces=3).replace("ascii", f"binary_{'little' if order == '<' else 'big'}_endian").encode()
    vertices = np.random.default_rng(1).random((6, 3)).astype(order + "f4").tobytes()

    def faces(*of: tuple[int, ...]) -> bytes:
        return b"".join(bytes([len(face)]) + np.array(face, order + "i4").tobytes() for face in of)

    assert len(meshes.load(head + vertices + faces((0, 1, 2, 3), (1, 2, 3, 4), (2, 3, 4, 5)), "a.ply").faces) == 6
    for mixed in (((0, 1, 2, 3), (0, 1, 4), (1, 2, 3, 4, 5)),  # as long as three of four corners
                  ((0, 1, 2), (0, 1, 2, 3), (3, 4, 5))):
        with pytest.raises(SceneError, match="rows of its element face differ in length"):
            meshes.load(head + vertices + faces(*mixed), "a.ply")


def test_a_glb_keeps_the_places_of_its_nodes(tmp_path):
    scene = trimesh.Scene()
    box = trimesh.creation.box()
    scene.add_geometry(box, transform=trimesh.transformations.translation_matrix([5, 0, 0]))
    scene.add_geometry(box, transform=np.diag([-2.0, 1, 1, 1]))  # mirrored: its faces turn around
    vertices, faces, _ = meshes.load(scene.export(file_type="glb"), "two.glb")
    corners = vertices[faces]
    volume = np.einsum("ni,ni->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert volume == pytest.approx(1 + 2)
    assert vertices[:, 0].min() == pytest.approx(-1) and vertices[:, 0].max() == pytest.approx(5.5)


def changed_glb(change) -> bytes:
    data = exported("glb")
    length = int.from_bytes(data[12:16], "little")
    document = json.loads(data[20:20 + length])
    change(document)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + length:]
    return (data[:8] + (20 + len(text) + len(rest)).to_bytes(4, "little") + len(text).to_bytes(4, "little") + b"JSON"
            + text + rest)


def positions(document) -> dict:
    return document["accessors"][document["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]


@pytest.mark.parametrize("change, message", [
    (lambda d: d.update(extensionsRequired=["KHR_draco_mesh_compression"]), "it is compressed (KHR_draco_mesh_compression)"),
    (lambda d: positions(d).update(normalized=True), "the positions of meshes[0].primitives[0] are normalised integers"),
    (lambda d: positions(d).update(sparse={}), "the positions of meshes[0].primitives[0] are sparse"),
    (lambda d: (positions(d).pop("bufferView"), positions(d).update(count=10**9)), "are sparse"),
    (lambda d: d["meshes"][0]["primitives"][0].update(mode=6), "meshes[0].primitives[0] is a fan of triangles"),
])
def test_a_glb_that_would_be_misread_is_refused(change, message):
    assert len(meshes.load(changed_glb(lambda document: None), "a.glb").faces) == 80
    with pytest.raises(SceneError, match=re.escape(message)):
        meshes.load(changed_glb(change), "a.glb")


def test_a_mesh_that_is_multiplied_out_is_counted_before():
    def repeat(document):
        node = {"mesh": 0}
        document["nodes"] = [{"children": list(range(1, 1001))}] + [node] * 1000
        document["scenes"] = [{"nodes": [0]}]

    with pytest.raises(SceneError, match="80,000 triangles, more than the 1,000 that are allowed here"):
        meshes.load(changed_glb(repeat), "a.glb", most=1000)


def test_blanks_without_number_take_no_time():
    obj = b"# a\nv 0 0 0" + b" " * 400_000 + b"\nv 1 0 0\nv 1 1 0\nf 1 2 3\nf" + b" 1" * 3 + b" " * 400_000
    began = time.monotonic()
    assert len(meshes.load(obj, "a.obj").faces) == 2
    assert time.monotonic() - began < 5  # minutes when each blank began a search of its own


def test_an_obj_may_begin_with_a_byte_order_mark():
    vertices, faces, _ = meshes.load(b"\xef\xbb\xbfv 9 9 9\nv 1 0 0\nv 1 1 0\nf 1 2 3\n", "a.obj")
    assert vertices.shape == (3, 3) and (vertices[0] == 9).all()


def test_what_is_no_regular_file_is_refused(tmp_path):
    os.mkfifo(tmp_path / "pipe.ply")
    (tmp_path / "loop.ply").symlink_to("loop.ply")
    for file, message in (("pipe.ply", "which is no regular file"), ("loop.ply", "leads to itself|symbolic links")):
        path = tmp_path / "scene.json"
        path.write_text(json.dumps(minimal(scene=[{"object": {"type": "mesh", "file": file}}])))
        with pytest.raises(SceneError, match=message) as caught:
            tilecast.load(path)
        assert caught.value.path == "scene[0].object.file"


def test_an_obj_needs_none_of_its_other_files():
    obj = b"mtllib nothing.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvn 0 0 1\nusemtl a\nf 1/1/1 2/1/1 3/1/1\n"
    assert meshes.load(obj, "a.obj")[1].shape == (1, 3)


@pytest.mark.parametrize("file, data, message", [
    ("a.ply", b"", "which is empty"),
    ("a.ply", b"hello", "is not a readable PLY mesh"),
    ("a.glb", b"hello", "is not a readable GLB mesh"),
    ("a.stl", b"hello", "holds no faces"),
    ("a.obj", b"hello", "holds no faces"),
    ("a.obj", b"v a b c\n", "is not a readable OBJ mesh"),
    ("a.obj", b"v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 9\n", "is not a readable OBJ mesh"),
    ("a.obj", b"v 0 0 0\nv 1 0 0\nv 1 1 0\nf 0 1 2\n", "line 4 names vertex 0, but they count from 1"),
    ("a.obj", b"v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1/1 2/1 0/1\n", "line 4 names vertex 0"),
    ("a.ply", ply(SQUARE, []), "holds no faces"),
    ("a.ply", ply([], []), "holds no faces"),
    ("a.ply", ply(SQUARE, [(0, 1, 7)]), "face 0 has a corner beyond its 4 vertices"),
    ("a.ply", ply([*SQUARE, (0, "nan", 0)], [(0, 1, 2)]), "vertex 4 is NaN or infinite"),
    ("a.ply", ply([*SQUARE, ("1e999", 0, 0)], [(0, 1, 2)]), "vertex 4 is NaN or infinite"),
    ("a.ply", exported("ply").replace(b"vertex 42", b"vertex 4200000000000"), "is not a readable PLY mesh"),
    ("a.ply", ply(SQUARE, [(0, 1, 2)]).replace(b"vertex 4", b"vertex 4000000000000"),
     "5 of 4000000000000 rows of its element vertex"),
    ("a.ply", ply(SQUARE, [(0, 1, 2)]).replace(b"face 1", b"face 3"), "1 of 3 rows of its element face are there"),
    ("a.ply", ply(SQUARE, [(0, 1, 2), (0, 2, 3)])[:-3], "row 1 of its element face has 3 numbers instead of 4"),
    ("a.ply", ply(SQUARE, [(0, 1, 2)]).replace(b"3 0 1 2", b"3 0 1 2 3 0 2 3"), "has 8 numbers instead of 4"),
    ("a.obj", b"v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 00\n", "line 4 names vertex 0"),
    ("a.obj", b"v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\nf 2 3", "line 5 is a face of fewer than three corners"),
    ("a.obj", b"v 0 0 0\nv 1 0 0\nv 1 1 0\nf\t1 2 \r\nf 1 2 3\n", "line 4 is a face of fewer than three corners"),
    ("a.ply", ply(SQUARE, [(0, 1, "1.7")]), "row 0 of its element face has a fraction"),
    ("a.obj", b"v 0 0 0\nv 1 0 0\nf -3 -2 -1\nv 1 1 0\n", "line 3 counts back beyond the first vertex"),
    ("a.ply", exported("ply")[:-1], "is not a readable PLY mesh"),
    ("a.glb", exported("glb")[:-1], "is not a readable GLB mesh"),
    ("a.stl", exported("stl")[:-1], "cut off"),
])
def test_a_file_that_is_no_mesh_is_refused(file, data, message):
    with pytest.raises(SceneError) as caught:
        meshes.load(data, file)
    assert message in caught.value.message and repr(file) in caught.value.message
    assert "\n" not in str(caught.value)


@given(st.sampled_from(["ply", "obj", "stl", "glb"]), st.integers(0, 10**6),
       st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 255)), max_size=8))
def test_a_damaged_file_is_a_mesh_or_refused(kind, length, changes):
    data = bytearray(EXPORTED[kind])
    if length % 2:
        del data[length % len(data):]
    for at, value in changes if data else ():
        data[at % len(data)] = value
    try:
        vertices, faces, _ = meshes.load(bytes(data), f"a.{kind}", with_uvs=True)
    except SceneError:
        return
    assert np.isfinite(vertices).all() and faces.max() < len(vertices)


EXPORTED = {kind: exported(kind) for kind in ("ply", "obj", "stl", "glb")}


def test_errors_of_files_lead_to_the_key_that_names_them(tmp_path):
    (tmp_path / "empty.ply").write_bytes(b"")
    (tmp_path / "bad.ply").write_bytes(b"ply or not")
    for file, message in (("none.ply", "is not in"), ("empty.ply", "is empty"), ("bad.ply", "not a readable PLY")):
        scene = minimal(objects={"m": {"type": "union", "of": [{"type": "sphere", "radius": 1},
                                                               {"type": "mesh", "file": file}]}}, scene=[{"object": "m"}])
        with pytest.raises(SceneError) as caught:
            tilecast.load(scene, folder=tmp_path)
        assert caught.value.path == "objects.m.of[1].file"
        assert message in caught.value.message
