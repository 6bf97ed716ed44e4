"""A sample that is not finite fails with its place, and the command that shows it again."""

import json
import shlex

import numpy as np
import pytest
import typer
from commands import one_line, run
from documents import diffuse
from typer.testing import CliRunner

import tilecast
from tilecast import _core
from tilecast.cli import app
from tilecast.cli.failures import failing
from tilecast.cli.render import render as render_command
from tilecast.cli.sample import sample as sample_command
from tilecast.jobs import worker
from tilecast.render.one_sample import one_sample, with_command
from tilecast.render.plan import Chunk, Tile
from tilecast.scene import loading
from tilecast.scene.compiler import Compiled

PLACE = "a sample is not finite: pixel (5, 2), sample 3, seed 4"


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "a ball.json"
    path.write_text(json.dumps(diffuse(8, 24, 16)))
    return path


class Failing:
    """A core's scene in which sample 3 of pixel (5, 2) fails, as the core says it. No scene is known that does."""
    width, height = 8, 8

    def render_chunk(self, x, y, width, height, first, count):
        if x <= 5 < x + width and y <= 2 < y + height and first <= 3 < first + count:
            raise _core.SampleError(PLACE)
        return type("Sums", (), {"sums": np.zeros((2, height, width, 3)), "rays": (0, 0, 0)})

    def render_chunks(self, chunks):
        return [self.render_chunk(*chunk) for chunk in chunks]


def failing_load(source, settings=()):
    return Compiled(Failing(), tilecast.scene.parse(diffuse(8, 8, 8)), {"load": 0, "compile": 0})


def test_a_sample_alone_is_the_sample_in_the_image(scene):
    compiled = tilecast.load(scene, settings=["render.seed=7"])
    chunk = compiled.scene.render_chunk(0, 0, 24, 16, 5, 1).sums[1]
    for x, y in ((0, 0), (23, 15), (12, 7)):
        assert np.array_equal(one_sample(compiled, x, y, 5), chunk[y, x])
    found = run("sample", scene, "--pixel", "12,7", "--sample", 5, "--seed", 7)
    assert found.returncode == 0, found.stderr
    assert list(map(float, found.stdout.split())) == chunk[7, 12].tolist()


def test_the_failure_of_a_render_names_the_command_that_shows_it(scene, monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(loading, "load", failing_load)
    options = dict.fromkeys(("samples", "seconds", "error", "size", "accelerator", "integrator", "threads", "stats",
                             "error_map"))
    with pytest.raises(typer.Exit) as end:
        render_command(scene, tmp_path / "out.png", **options | {"seed": 4}, set_=["camera.fov=50"], quiet=True)
    assert end.value.exit_code == 1
    line = capsys.readouterr().err
    assert line.startswith("tilecast: ") and PLACE in line and line.count("\n") == 1
    words = shlex.split(line.partition("; to see it again: ")[2])
    assert words == ["tilecast", "sample", str(scene), "--pixel", "5,2", "--sample", "3", "--set", "camera.fov=50",
                     "--set", "render.seed=4", "--set", "render.seed=4"]
    monkeypatch.undo()
    assert run(*words[1:]).returncode == 0  # the command is one; the true scene has no such sample
    monkeypatch.setattr(loading, "load", failing_load)
    with pytest.raises(typer.Exit):
        sample_command(scene, "5,2", 3, None, None, None, None)
    assert PLACE in capsys.readouterr().err


def test_the_failure_of_a_job_names_the_command_too(monkeypatch):
    monkeypatch.setattr(worker, "_compiled", lambda *_: failing_load(None))
    with pytest.raises(worker.Rejected) as found:
        worker.render("", "", 0, [Chunk(Tile(0, 0, 0, 0, 0, 8, 8), 0, 0, 4)])
    [(path, message)] = found.value.errors
    assert path == "" and message == \
        f"{PLACE}; to see it again: tilecast sample SCENE --pixel 5,2 --sample 3 --set render.seed=4"


def test_an_error_without_a_place_is_told_as_it_is(scene, capsys):
    assert with_command(_core.SampleError("no place")) == "no place"
    with pytest.raises(typer.Exit), failing(scene):
        raise _core.SampleError("no place")
    assert "no place" in capsys.readouterr().err


def test_what_is_wrong_with_the_call_is_told(scene):
    one_line(run("sample", scene, "--pixel", "24,0", "--sample", 0), 2, "has 24 x 16 pixels, and none at (24, 0)")
    for arguments in (("--pixel", "1,-1", "--sample", "0"), ("--pixel", "1,1"),
                      ("--pixel", "1,1", "--sample", str(2**32))):
        found = CliRunner().invoke(app, ["sample", str(scene), *arguments])
        assert found.exit_code == 2 and isinstance(found.exception, SystemExit)
