"""The command line, by subprocess: what it writes, what it says, and with which status it ends."""

import json
import os
import pty
import re
import signal
import subprocess
import sys
import time

import pytest
from commands import TILECAST, one_line, run
from documents import diffuse, minimal, quick

from tilecast import _images
from tilecast.scene import schema_json

def test_renders_a_png_and_an_exr(scene, tmp_path):
    for name in ("out.png", "out.exr"):
        result = run("render", scene, "-o", tmp_path / name)
        assert result.returncode == 0 and result.stdout == ""
        assert _images.read(str(tmp_path / name))[0].shape[:2] == (16, 24)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["ball.json", "out.exr", "out.png"]


def test_options_replace_what_the_scene_says(scene, tmp_path):
    stats = tmp_path / "stats.json"
    result = run("render", scene, "-o", tmp_path / "out.exr", "--samples", 5, "--size", "20x10", "--seed", 7,
                 "--integrator", "whitted", "--accelerator", "none", "--threads", 1, "--stats", stats,
                 "--set", "render.samples=64", "--set", "camera.fov=50", "--quiet")
    assert (result.returncode, result.stdout, result.stderr) == (0, "", "")
    found = json.loads(stats.read_text())
    assert (found["width"], found["height"], found["samples"]) == (20, 10, 5)
    assert "whitted" in found["kernel"]
    assert {"seconds", "samples", "rays", "rays_per_second", "error", "curve", "accelerator", "features",
            "kernel"} <= set(found)
    assert found["seconds"]["write"] > 0 and found["seconds"]["load"] > 0
    assert set(found["features"]) == {"used", "left_out"} and "csg" in found["features"]["left_out"]


def test_statistics_go_to_standard_output_on_request(scene, tmp_path):
    result = run("render", scene, "-o", tmp_path / "out.png", "--stats", "-")
    assert json.loads(result.stdout)["samples"] == 8
    assert [path.name for path in tmp_path.iterdir() if path.name not in ("ball.json", "out.png")] == []


def test_stops_by_error_and_by_time(scene, tmp_path):
    stats = tmp_path / "stats.json"
    base = ("render", scene, "-o", tmp_path / "out.png", "--stats", stats, "-q")
    assert run(*base, "--samples", 4096, "--error", 1000).returncode == 0
    assert json.loads(stats.read_text())["samples"] == 16
    assert run(*base, "--samples", 2**24, "--seconds", 0.5).returncode == 0
    found = json.loads(stats.read_text())
    assert 2 <= found["samples"] < 2**24 and found["seconds"]["render"] < 30


def test_progress_is_plain_lines_where_there_is_no_terminal(scene, tmp_path):
    # One thread: with more, all may be done before the first point can be told.
    lines = run("render", scene, "-o", tmp_path / "out.png", "--threads", 1).stderr.splitlines()
    assert re.fullmatch(r"ball.json: 2 samples in \d+\.\d s, relative MSE \S+, about .+ left", lines[0])
    assert re.fullmatch(r"ball.json: 8 samples in \d+\.\d s, relative MSE \S+", lines[-2])
    assert re.fullmatch(r".*out.png: 8 samples in \d+\.\d s", lines[-1])
    assert "\x1b" not in "".join(lines)


def test_an_error_that_rare_events_carry_is_said_to_be_understated(scene, tmp_path):
    """The lamp is small and found by chance alone."""
    result = run("render", scene, "-o", tmp_path / "out.png", "--samples", 16, "--set", "render.next_event=false",
                 "--set", "lights[0].object.radius=0.2", "--set", "lights[0].radiance=[900,900,900]")
    assert re.fullmatch(r".*out.png: the error may be understated: rare bright samples, met in 1% of the pixels, make up "
                        r"\d+% of it", result.stderr.splitlines()[-1])


def test_progress_is_a_bar_on_a_terminal(scene, tmp_path):
    ours, theirs = pty.openpty()
    process = subprocess.Popen([*TILECAST, "render", scene, "-o", tmp_path / "out.png", "--samples", "20000"],
                               stderr=theirs, env={**os.environ, "TERM": "xterm"})
    os.close(theirs)
    shown = b""
    while True:
        try:
            part = os.read(ours, 4096)
        except OSError:  # the terminal is closed
            break
        if not part:
            break
        shown += part
    os.close(ours)
    assert process.wait(60) == 0
    assert b"%" in shown and b"left" in shown and b"relative MSE" in shown
    assert b"\r" in shown and b"\x1b" in shown


@pytest.mark.parametrize("change, path", [
    ({"objects": {"lens": {"type": "union", "of": [{"type": "sphere", "radius": 1}, {"type": "sphere", "radius": -0.5}]}}},
     "objects.lens.of[1].radius: must be positive, got -0.5"),
    ({"scene": [{"object": "nothing"}]}, "scene[0].object: names the unknown object nothing"),
    ({"objects": {"m": {"type": "mesh", "file": "gone.ply"}}, "scene": [{"object": "m"}]}, "objects.m.file: names the file"),
    ({"sceen": []}, "sceen: is not a key that is known here; did you mean scene?"),
])
@pytest.mark.parametrize("command", ["render", "validate", "batch"])
def test_a_bad_scene_is_one_line_with_its_path_and_status_2(command, change, path, tmp_path):
    scene = tmp_path / "bad.json"
    scene.write_text(json.dumps(minimal(**change)))
    arguments = {"render": ["-o", tmp_path / "o.png"], "validate": [], "batch": ["-o", tmp_path / "out", "--quiet"]}
    one_line(run(command, scene, *arguments[command]), 2, f"bad.json: {path}")
    assert not (tmp_path / "o.png").exists()


@pytest.mark.parametrize("text, message", [
    ("[" * 1000, "is nested 1000 levels deep"), ("{", "is not JSON"), ('{"camera": NaN}', "camera"),
    ('{"camera": {"fov": 1e999}}', "camera.position: is required")])
def test_text_that_is_no_scene_is_one_line(text, message, tmp_path):
    scene = tmp_path / "bad.json"
    scene.write_text(text)
    one_line(run("validate", scene), 2, "bad.json", message)


def test_what_is_wrong_with_the_call_is_told(scene, tmp_path):
    one_line(run("render", tmp_path / "gone.json", "-o", tmp_path / "o.png"), 2, "gone.json", "No such file")
    one_line(run("render", tmp_path, "-o", tmp_path / "o.png"), 2, "Is a directory")
    one_line(run("render", scene, "-o", tmp_path / "gone" / "o.png"), 1, "there is no folder")
    one_line(run("render", scene, "-o", tmp_path / "o.png", "--set", "render.samples"), 2, "must be KEY=VALUE")
    one_line(run("render", scene, "-o", tmp_path / "o.png", "--samples", "0"), 2, "render.samples: must be at least 1")
    one_line(run("render", scene, "-o", tmp_path / "o.png", "--size", "0x5"), 2, "image.width: must be at least 1")
    for arguments in (("-o", "o.jpg"), ("-o", "o.png", "--size", "big"), (), ("-o", "o.png", "--frobnicate")):
        result = run("render", scene, *arguments, cwd=tmp_path)
        assert result.returncode == 2 and "Traceback" not in result.stderr


def test_no_file_is_written_over_another(scene, tmp_path):
    image = tmp_path / "out.png"
    for options in (("--stats", str(image)), ("--error-map", str(image)), ("--stats", str(scene))):
        done = run("render", scene, "-o", image, *options)
        assert done.returncode == 2 and "are the same file" in done.stderr
    assert not image.exists() and json.loads(scene.read_text())


def test_validate_says_what_is_valid_and_lists_all_errors_on_request(scene, tmp_path):
    bad = tmp_path / "bad.json"
    bad.write_text(json.dumps(minimal(image={"width": 0, "height": 0})))
    result = run("validate", scene, bad)
    assert result.returncode == 2
    assert re.search(r"ball.json: valid \(24 x 16 pixels, \d+ primitives\)", result.stdout)
    assert result.stderr.count("\n") == 1 and "(and 1 more" in result.stderr
    listed = run("validate", "--all", "--quiet", scene, bad)
    assert (listed.returncode, listed.stdout) == (2, "")
    assert "image.width" in listed.stderr and "image.height" in listed.stderr and listed.stderr.count("\n") == 2


def test_the_schema_is_printed():
    result = run("schema")
    assert result.returncode == 0 and json.loads(result.stdout) == schema_json()


def test_ctrl_c_ends_without_a_traceback(scene, tmp_path):
    process = subprocess.Popen([*TILECAST, "render", scene, "-o", tmp_path / "out.png", "--samples", str(2**24)],
                               stderr=subprocess.PIPE, text=True)
    process.stderr.readline()  # it renders
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130 and "Traceback" not in errors
    assert not (tmp_path / "out.png").exists()


def test_help_names_every_command():
    result = run("--help")
    assert result.returncode == 0
    for command in ("render", "batch", "serve", "submit", "report", "validate", "schema"):
        assert command in result.stdout
    assert run("frobnicate").returncode == 2
    assert run("--version").stdout.startswith("tilecast")


@pytest.mark.parametrize("command", [["validate"], ["render", "-q", "-o", "out.png"]])
def test_a_command_imports_only_what_it_needs(scene, command, tmp_path):
    code = ("import sys\nfrom tilecast.cli import app\ntry:\n    app(sys.argv[1:])\nexcept SystemExit as e:\n"
            "    assert not e.code\nprint(sorted(sys.modules))")
    result = subprocess.run([sys.executable, "-c", code, *command, scene], capture_output=True, text=True, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    loaded = result.stdout.splitlines()[-1]
    for heavy in ("fastapi", "distributed", "dask", "sqlalchemy", "uvicorn", "trimesh", "tilecast.jobs", "tilecast.api"):
        assert f"'{heavy}'" not in loaded


def batch(folder, *arguments):
    result = run("batch", *sorted(folder.glob("*.json")), "-o", folder / "out", *arguments)
    return result.returncode, result.stderr.splitlines()[-1], result.stderr


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "scenes"
    folder.mkdir()
    for name in ("a", "b", "c"):
        (folder / f"{name}.json").write_text(json.dumps(diffuse(4, 16, 12, seed=ord(name))))
    return folder


def test_a_batch_skips_what_is_done(folder):
    assert batch(folder)[:2] == (0, "3 rendered, 0 skipped, 0 failed")
    assert sorted(path.name for path in (folder / "out").iterdir()) == [
        "a.png", "a.stats.json", "b.png", "b.stats.json", "c.png", "c.stats.json"]
    before = {path: path.stat().st_mtime_ns for path in (folder / "out").iterdir()}
    os.utime(folder / "a.json")  # newer, but the same
    (folder / "b.json").write_text(json.dumps(diffuse(4, 16, 12, seed=ord("b")), indent=1))  # written otherwise
    assert batch(folder)[:2] == (0, "0 rendered, 3 skipped, 0 failed")
    assert before == {path: path.stat().st_mtime_ns for path in (folder / "out").iterdir()}
    assert batch(folder, "--force")[:2] == (0, "3 rendered, 0 skipped, 0 failed")


def test_a_batch_renders_what_is_not_what_was_made(folder):
    batch(folder)
    (folder / "a.json").write_text(json.dumps(diffuse(4, 16, 12, seed=1)))  # another scene
    (folder / "out" / "b.png").write_bytes(b"broken")
    (folder / "out" / "c.stats.json").unlink()
    assert batch(folder)[:2] == (0, "3 rendered, 0 skipped, 0 failed")
    assert batch(folder, "--samples", "8")[:2] == (0, "3 rendered, 0 skipped, 0 failed")  # other settings
    assert batch(folder, "--samples", "8")[:2] == (0, "0 rendered, 3 skipped, 0 failed")


def test_a_batch_sees_a_mesh_that_has_changed(folder):
    for path in folder.glob("*.json"):
        path.unlink()
    (folder / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (folder / "mesh.json").write_text(json.dumps(minimal(
        image={"width": 8, "height": 8}, render={"samples": 2}, scene=[{"object": {"type": "mesh", "file": "m.obj"}}])))
    assert batch(folder)[1] == "1 rendered, 0 skipped, 0 failed"
    (folder / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n")
    assert batch(folder)[1] == "1 rendered, 0 skipped, 0 failed"
    assert batch(folder)[1] == "0 rendered, 1 skipped, 0 failed"


def test_a_batch_goes_on_after_a_failure(folder):
    (folder / "b.json").write_text(json.dumps(minimal(scene=[{"object": "nothing"}])))
    status, last, errors = batch(folder)
    assert (status, last) == (2, "2 rendered, 0 skipped, 1 failed")
    assert len(re.findall(r"^tilecast: .*b\.json: scene\[0\]\.object: .*$", errors, re.MULTILINE)) == 1
    assert (folder / "out" / "a.png").exists() and (folder / "out" / "c.png").exists()
    (folder / "b.json").write_text(json.dumps(diffuse(4, 16, 12)))
    assert batch(folder)[:2] == (0, "1 rendered, 2 skipped, 0 failed")


def test_a_batch_refuses_two_scenes_of_one_name_and_to_write_over_a_scene(folder, tmp_path):
    other = tmp_path / "a.json"
    other.write_text(json.dumps(diffuse(4)))
    one_line(run("batch", folder / "a.json", other, "-o", tmp_path / "out"), 2, "would both be written to")
    trap = folder / "a.stats.json"
    trap.write_text(json.dumps(diffuse(4)))
    one_line(run("batch", folder / "a.json", trap, "-o", folder), 1, "is a scene and would be overwritten")
    assert json.loads(trap.read_text()) == diffuse(4)


def test_a_batch_killed_half_way_goes_on(folder):
    (folder / "b.json").write_text(json.dumps(quick(500, 48, 32)))
    process = subprocess.Popen([*TILECAST, "batch", *sorted(folder.glob("*.json")), "-o", folder / "out"],
                               stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + 60
    while not (folder / "out" / "a.stats.json").exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    process.kill()
    process.wait()
    done = len(list((folder / "out").glob("*.stats.json")))
    assert done >= 1
    assert batch(folder)[:2] == (0, f"{3 - done} rendered, {done} skipped, 0 failed")
    assert run("render", folder / "b.json", "-o", folder / "b.png", "-q").returncode == 0
    assert (folder / "b.png").read_bytes() == (folder / "out" / "b.png").read_bytes()
