"""`tilecast report` from end to end: the files, the table, and what is refused in one line."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from commands import run
from typer.testing import CliRunner

import tilecast
from tilecast import _images, cli
from tilecast.render import output

CORNELL = Path(__file__).resolve().parents[2] / "scenes" / "cornell.json"


def test_a_scene_alone_gives_its_error_against_time(scene, tmp_path):
    folder = tmp_path / "new" / "report"
    result = run("report", scene, "-o", folder, "--seeds", 3, "--threads", 1)
    assert result.returncode == 0, result.stderr
    assert sorted(path.name for path in folder.iterdir()) == ["report.json", "report.png", "report.svg", "table.txt"]
    assert result.stdout == (folder / "table.txt").read_text()
    assert [line.split()[0] for line in result.stdout.splitlines()[4:7]] == ["2", "4", "8"]
    assert [line.partition(": ")[2].rpartition(": ")[0] for line in result.stderr.splitlines()] == [
        "reference 1 of 2, 64 samples", "reference 2 of 2, 64 samples",
        *(f"seed {seed} of 3, 2 to 8 samples" for seed in (1, 2, 3))]
    found = json.loads((folder / "report.json").read_text())
    [curve] = found["curves"]
    assert (found["scene"], found["machine"]["threads"], curve["width"]) == ("ball.json", 1, 24)
    assert not set(curve["seeds"]) & set(curve["references"]["seeds"])
    assert [point["samples"] for point in curve["points"]] == [2, 4, 8]
    seconds = [point["seconds"] for point in curve["points"]]
    assert 0 < seconds[0] and curve["seconds"]["load"] > 0 and curve["seconds"]["compile"] > 0
    # Noise without rare bright samples: each checkpoint halves the error at least, and the estimate may be true.
    for before, after in zip(curve["points"], curve["points"][1:]):
        assert after["relative_mse"]["mean"] < 0.6 * before["relative_mse"]["mean"]
        assert after["predicted_over_true"]["low"] < 1.1 and after["predicted_over_true"]["high"] > 0.8
    assert _images.read(str(folder / "report.png"))[0].shape[1] > 1000


def report(*arguments):
    """The command in this process: starting another costs more than the report of a small scene."""
    return CliRunner().invoke(cli.app, ["report", *map(str, arguments)])


def test_a_given_reference_is_measured_against(scene, tmp_path):
    for seed in (100, 101):
        image = tilecast.render(tilecast.load(scene, settings=[f"render.seed={seed}"]), samples=256)
        (tmp_path / f"{seed}.exr").write_bytes(output.to_exr(image.pixels))
    two = report(scene, "--seeds", 2, "-q", "--reference", tmp_path / "100.exr", "--reference", tmp_path / "101.exr")
    assert (two.exit_code, two.stderr) == (0, "")
    assert "references: 100.exr and 101.exr; relative MSE of their mean" in two.stdout
    one = report(scene, "--seeds", 2, "-q", "--reference", tmp_path / "100.exr").stdout
    assert "references: 100.exr; a single one, so that its own error is part of every figure" in one


def test_what_changes_the_noise_has_curves(tmp_path):
    """In the Cornell box, whose lamp a path meets by chance alone one time in a hundred."""
    result = report(CORNELL, "--seeds", 2, "--repeats", 1, "--size", "20x20", "--samples", 8, "--reference-samples",
                    512, "-q", "-o", tmp_path, "--vary", "render.next_event=true,false")
    assert result.exit_code == 0, result.output
    found = json.loads((tmp_path / "report.json").read_text())
    assert [row["value"] for row in found["rows"]] == [curve["value"] for curve in found["curves"]] == [True, False]
    first, second = found["curves"]
    assert first["references"] == second["references"]  # of one and the same picture
    assert second["points"][-1]["relative_mse"]["mean"] > 4 * first["points"][-1]["relative_mse"]["mean"]
    assert re.search(r"^render.next_event=false +8 ", result.stdout, re.MULTILINE)
    assert (tmp_path / "report.png").exists()


def test_other_pictures_have_references_of_their_own(scene):
    result = report(scene, "--seeds", 2, "--repeats", 1, "--vary", "background=[0,0,0],[1,1,1]", "--curves")
    assert result.exit_code == 0 and result.stderr.count("reference 1 of 2") == 2
    assert report(scene, "--repeats", 1, "-q", "--vary", "render.next_event=true,false",
                  "--no-curves").stdout.count("\n") == 3


def test_renders_are_asked_how_often_they_are_right(scene, tmp_path):
    result = report(scene, "--calibrate", 20, "--samples", 4, "-o", tmp_path / "out")
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith("ball.json: 20 renders of 24 x 16 pixels, 4 samples a pixel")
    assert len(result.stdout.splitlines()) == 5 and result.stderr.count("of 20 renders") == 10
    found = json.loads((tmp_path / "out" / "report.json").read_text())
    assert found["relative_mse"]["coverage"]["mean"] > 0.6 and found["renders"] == 20
    assert report(scene, "--calibrate", 8, "--set", "image.width=960", "-q").stdout.startswith(
        "ball.json: 8 renders of 96 x 2 pixels, 64 samples a pixel")


def test_a_sphere_of_triangles_needs_no_scene(monkeypatch, tmp_path):
    monkeypatch.setattr("tilecast.report.tessellation.tessellation.__defaults__", (3,))
    result = report("--tessellation", "-o", tmp_path)
    assert result.exit_code == 0 and "1,280" not in result.output and "320" in result.output
    assert len(json.loads((tmp_path / "report.json").read_text())["rows"]) == 3 and (tmp_path / "report.svg").exists()


def test_without_matplotlib_one_line_says_what_to_install(monkeypatch, scene, tmp_path):
    monkeypatch.setattr("tilecast.report.plot.importlib.util.find_spec", lambda name: None)
    for asked in (scene, "--tessellation"):
        result = report(asked, "-o", tmp_path / "out")
        assert result.exit_code == 1 and result.stderr.count("\n") == 1 and result.stdout == ""
        assert "pip install 'tilecast[report]'" in result.stderr
    assert list((tmp_path / "out").iterdir()) == []
    assert report(scene, "--seeds", 2, "-q").exit_code == 0  # a table needs none


@pytest.mark.parametrize("arguments, message", [
    (["--samples", 2], "render.samples: must be at least 3 for an error against run time"),
    (["--reference", "gone.exr"], "the reference gone.exr is not there"),
    (["--size", "24x17", "--reference", "right.exr"], "must have the image's 24 x 17 pixels, got 24 x 16"),
    (["--reference", "right.exr", "--reference", "right.exr"], "got right.exr twice")])
def test_what_does_not_fit_is_one_line(scene, arguments, message, monkeypatch):
    right = scene.parent / "right.exr"
    right.write_bytes(output.to_exr(np.zeros((16, 24, 3), np.float32)))
    monkeypatch.chdir(scene.parent)
    result = report(scene, *arguments)
    assert result.exit_code == 2 and result.stderr.count("\n") == 1 and result.stdout == ""
    assert "ball.json" in result.stderr and message in result.stderr


@pytest.mark.parametrize("arguments, message", [
    (["--seeds", 1], "--seeds"), (["--calibrate", 7], "--calibrate"),
    (["--calibrate", 9, "--vary", "render.samples=1,2"], "--calibrate"), (["--tessellation"], "--tessellation")])
def test_a_call_that_contradicts_itself_is_refused(scene, arguments, message):
    result = report(scene, *arguments)
    assert result.exit_code == 2 and message in result.output and "Traceback" not in result.output
    assert report().exit_code == 2


@pytest.mark.parametrize("arguments, message", [
    (["--reference", "gone.exr"], "the reference gone.exr is not there"),
    (["--samples", 2], "render.samples: must be at least 3")])
def test_what_does_not_fit_is_said_before_values_are_compared(scene, arguments, message, monkeypatch):
    monkeypatch.setattr("tilecast.report.measure.render", None)
    result = report(scene, "--vary", "render.next_event=true,false", *arguments)
    assert result.exit_code == 2 and message in result.stderr and result.stderr.count("\n") == 1
