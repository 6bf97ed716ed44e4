"""Mesh files: which a scene names, what may be opened, what a scene's digest depends on."""

import pickle

import pytest
from documents import example, minimal

from tilecast.scene import SceneError, digest, files, folder_opener, override, parse, renamed


def with_meshes():
    mesh = {"type": "mesh", "file": "meshes/a.ply"}
    return minimal(objects={"a": mesh, "both": {"type": "union", "of": [{"object": "a"}, {"type": "mesh", "file": "b.stl"}]}},
                   scene=[{"object": {"type": "group", "of": [{"object": {"type": "mesh", "file": "c.obj"}}]}}],
                   lights=[{"type": "area", "object": {"type": "mesh", "file": "d.glb"}, "radiance": [1, 1, 1]}])


def test_all_files_of_a_scene_with_their_paths():
    assert files(parse(with_meshes())) == {
        "objects.a.file": "meshes/a.ply", "objects.both.of[1].file": "b.stl",
        "scene[0].object.of[0].object.file": "c.obj", "lights[0].object.file": "d.glb"}


def test_files_get_other_names_and_nothing_else_changes():
    asset = f"sha256:{'0' * 64}.ply"
    document = renamed(parse(with_meshes()), {"meshes/a.ply": asset})
    expected = with_meshes()
    expected["objects"]["a"]["file"] = asset
    assert document == expected
    assert renamed(parse(example()), {"part": "x"}) == example()


def test_a_folder_opens_what_is_in_it(tmp_path):
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "a.ply").write_bytes(b"ply")
    assert folder_opener(tmp_path)("meshes/a.ply") == b"ply"


@pytest.mark.parametrize("file", ["../secret.ply", "/etc/passwd.ply", "link.ply", "folder/secret.ply", "nothing.ply",
                                  "dir.ply", "a\0.ply", "meshes/../../secret.ply"])
def test_a_folder_opens_nothing_else(tmp_path, file):
    (tmp_path / "secret.ply").write_bytes(b"secret")
    folder = tmp_path / "scene"
    folder.mkdir()
    (folder / "link.ply").symlink_to(tmp_path / "secret.ply")
    (folder / "folder").symlink_to(tmp_path)
    (folder / "dir.ply").mkdir()
    with pytest.raises(SceneError):
        folder_opener(folder)(file)


def test_a_link_inside_the_folder_is_followed(tmp_path):
    (tmp_path / "a.ply").write_bytes(b"ply")
    (tmp_path / "b.ply").symlink_to("a.ply")
    assert folder_opener(tmp_path)("b.ply") == b"ply"


def test_an_unreadable_file_is_told(tmp_path, monkeypatch):
    (tmp_path / "a.ply").write_bytes(b"ply")

    def refuse(path):  # by a patch, since no permission stops the superuser, as whom tests may run
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("pathlib.Path.read_bytes", refuse)
    with pytest.raises(SceneError, match="cannot be read: Permission denied"):
        folder_opener(tmp_path)("a.ply")


def test_the_digest_is_of_the_content(tmp_path):
    scene = parse(example())
    assert digest(scene) == digest(parse({**dict(reversed(example().items())), "version": 1}))
    assert digest(parse(minimal())) == digest(parse(minimal(image={"width": 640}, render={"seed": 0})))
    for setting in ("render.samples=65", "render.seed=1", "image.width=65", "scene[0].transform[1].rotate[1]=31"):
        assert digest(parse(override(example(), [setting]))) != digest(scene)

    mesh = parse(minimal(objects={"a": {"type": "mesh", "file": "a.ply"}}))
    opened = {"a.ply": b"1"}
    first = digest(mesh, opened.__getitem__)
    opened["a.ply"] = b"2"
    assert digest(mesh, opened.__getitem__) != first
    assert digest(mesh) != first


def test_an_error_travels_between_processes():
    error = pickle.loads(pickle.dumps(SceneError("a.b", "is wrong", [("a.b", "is wrong"), ("c", "too")])))
    assert (error.path, error.message, str(error), len(error.errors)) == ("a.b", "is wrong", "a.b: is wrong", 2)
