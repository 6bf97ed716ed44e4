"""`tilecast report --vary`: what it measures, what it refuses, and what it calls a fault."""

import dataclasses
import json
import re

import numpy as np
import pytest
from commands import one_line, run
from documents import diffuse

import tilecast
from tilecast import SceneError
from tilecast.report import measure
from tilecast.report.table import table
from tilecast.report.variation import Variation, parse_variation


def crowd(**render) -> dict:
    """Balls in a square, enough for a hierarchy."""
    document = diffuse(4, 24, 16, **render)
    document["scene"] += [{"object": {"type": "sphere", "radius": 0.2}, "transform": [{"translate": [x, 1, z]}]}
                          for x in range(-3, 4) for z in range(-3, 4)]
    return document


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "crowd.json"
    path.write_text(json.dumps(crowd()))
    return path


@pytest.mark.parametrize("text, key, values", [
    ("render.accelerator=bvh,grid", "render.accelerator", ("bvh", "grid")),
    ("render.samples=1,2,16", "render.samples", (1, 2, 16)),
    (" render.samples = 4 ", "render.samples", (4,)),
    ("camera.position=[0,0,5],[0,1,5]", "camera.position", ([0, 0, 5], [0, 1, 5])),
    ('render.integrator="path", whitted', "render.integrator", ("path", "whitted")),
    ("render.stop.seconds=null,2", "render.stop.seconds", (None, 2)),
    ("objects.m.file=a=b.ply,c.ply", "objects.m.file", ("a=b.ply", "c.ply"))])
def test_variations_are_read(text, key, values):
    assert parse_variation(text) == Variation(key, values)


@pytest.mark.parametrize("text", ["", "render.samples", "render.samples=", "=1,2", " = "])
def test_a_variation_without_key_or_values_is_refused(text):
    with pytest.raises(SceneError, match="must be KEY=A,B,C"):
        parse_variation(text)


def test_every_value_has_a_row():
    order = []
    report = measure.compare(crowd(), parse_variation("render.accelerator=none,bvh,auto"), repeats=3, threads=2,
                             on_run=lambda label, repeat, seconds: order.append((repeat, label.partition("=")[2])))
    assert order == [(0, "none"), (0, "bvh"), (0, "auto"), (1, "auto"), (1, "bvh"), (1, "none"),
                     (2, "none"), (2, "bvh"), (2, "auto")]
    none, bvh, _ = report["rows"]
    assert [row["value"] for row in report["rows"]] == ["none", "bvh", "auto"]
    assert none["accelerator"]["nodes"] == 0 < bvh["accelerator"]["nodes"]
    assert bvh["camera_ray"]["tests"] < none["camera_ray"]["tests"] + 52 and bvh["camera_ray"]["steps"] > 0
    for row in report["rows"]:
        assert row["identical"] and row["repeatable"] and row["samples"] == 4
        assert sorted(row["render_seconds"])[1] == row["seconds"]["render"] > 0
        assert row["seconds"]["compile"] >= row["seconds"]["build"] >= 0
        assert row["ratio"] >= 1
    assert min(row["ratio"] for row in report["rows"]) == 1
    assert report["faults"] == [] and (report["repeats"], report["threads"]) == (3, 2)
    json.dumps(report, allow_nan=False)


def test_rays_are_counted_through_the_centres_of_all_pixels():
    compiled = tilecast.load(crowd(accelerator="none"))
    [row] = measure.compare(crowd(), parse_variation("render.accelerator=none"), repeats=1)["rows"]
    steps, tests = compiled.scene.camera_cost(0, 0, 24, 16)
    assert row["camera_ray"] == {"steps": steps / (24 * 16), "tests": tests / (24 * 16)}
    assert steps == 52 * 24 * 16  # every box: 49 balls, one more, the floor and the lamp


def test_any_key_can_be_varied():
    for text, identical in (("render.samples=1,4", [True, False]),
                            ("render.integrator=path,whitted,depth", [True, False, False]),
                            ("image.width=24,24", [True, True]), ("image.width=24,12", [True, False]),
                            ("background=[0,0,0],[1,1,1]", [True, False])):
        report = measure.compare(crowd(), parse_variation(text), repeats=1)
        assert [row["identical"] for row in report["rows"]] == identical
        assert report["faults"] == []
        assert len(table(report).splitlines()) == 1 + len(identical)


def test_settings_hold_for_all_values_and_the_varied_one_wins():
    report = measure.compare(crowd(), parse_variation("render.samples=1,2"), repeats=1,
                             settings=["render.samples=9", "image.width=5"])
    assert [(row["samples"], row["width"]) for row in report["rows"]] == [(1, 5), (2, 5)]


def faulty(monkeypatch, spoil):
    """Renders whose pixels are spoilt: spoil(pixels, accelerator, count of renders so far)."""
    real, count = measure.render, iter(range(1000))

    def render(compiled, **keys):
        image = real(compiled, **keys)
        pixels = spoil(image.pixels.copy(), compiled.document.render.accelerator, next(count))
        return dataclasses.replace(image, pixels=pixels)

    monkeypatch.setattr(measure, "render", render)


def in_one_bit(pixels):
    pixels[3, 4, 1] = np.nextafter(pixels[3, 4, 1], np.float32(2))
    return pixels


def test_a_single_bit_by_an_accelerator_is_a_fault(monkeypatch):
    faulty(monkeypatch, lambda pixels, accelerator, count: in_one_bit(pixels) if accelerator == "bvh" else pixels)
    report = measure.compare(crowd(), parse_variation("render.accelerator=none,bvh"), repeats=1)
    assert report["faults"] == ["render.accelerator=bvh: the pixels are not those of render.accelerator=none"]
    cells = [line.split()[-1] for line in table(report).splitlines()]
    assert cells[0] == "pixels" and len(set(cells)) == 3 and "same" not in cells


def test_a_picture_that_a_repetition_changes_is_a_fault(monkeypatch):
    faulty(monkeypatch, lambda pixels, accelerator, count: in_one_bit(pixels) if count == 2 else pixels)
    report = measure.compare(crowd(), parse_variation("render.samples=1,2"), repeats=2)
    assert report["faults"] == ["render.samples=2: the pixels change from run to run"]
    assert table(report).splitlines()[2].endswith("change")


@pytest.mark.parametrize("render", [{"integrator": "cost"}, {"stop": {"seconds": 60}}])
def test_where_pixels_may_differ_it_is_no_fault(monkeypatch, render):
    faulty(monkeypatch, lambda pixels, accelerator, count: in_one_bit(pixels) if accelerator == "bvh" else pixels)
    assert measure.compare(crowd(**render), parse_variation("render.accelerator=none,bvh"), repeats=1)["faults"] == []


def test_the_command_prints_and_writes_a_table(scene, tmp_path):
    folder = tmp_path / "new" / "report"
    result = run("report", scene, "--vary", "render.accelerator=none,bvh", "-o", folder, "--samples", 2,
                 "--size", "20x10", "--threads", 1, "--repeats", 2, "--set", "camera.fov=50")
    assert result.returncode == 0, result.stderr
    assert result.stdout == (folder / "table.txt").read_text()
    head, *rows = result.stdout.splitlines()
    assert re.split(r"  +", head) == ["render.accelerator", "build s", "nodes", "bytes", "cost", "steps/ray",
                                      "tests/ray", "render s", "ratio", "relative MSE", "pixels"]
    assert [row.split()[0] for row in rows] == ["none", "bvh"] and rows[1].endswith("same")
    assert len(result.stderr.splitlines()) == 4 and "render.accelerator=bvh, 2 of 2: " in result.stderr
    report = json.loads((folder / "report.json").read_text())
    assert (report["scene"], report["vary"], report["threads"]) == ("crowd.json", "render.accelerator", 1)
    assert [(row["width"], row["height"], row["samples"]) for row in report["rows"]] == [(20, 10, 2)] * 2


def test_quiet_leaves_the_table_alone(scene):
    result = run("report", scene, "--vary", "render.samples=1,2", "--repeats", 1, "--quiet")
    assert (result.returncode, result.stderr, len(result.stdout.splitlines())) == (0, "", 3)


@pytest.mark.parametrize("vary, message", [
    ("render.acelerator=bvh", "render.acelerator: is not a key that is known here; did you mean accelerator?"),
    ("render.accelerator=bvh,kdtree", "render.accelerator: must be auto, none, bvh"),
    ("render.samples=1,0", "render.samples: must be at least 1, got 0"),
    ("scene[99].object=a", "scene[99]: cannot be set"),
    ("render.samples", "must be KEY=A,B,C"),
    ("render..samples=1", "the setting")])
def test_a_bad_variation_is_one_line_and_status_2(scene, vary, message):
    result = run("report", scene, "--vary", vary)
    one_line(result, 2, "crowd.json", message)
    assert result.stdout == ""


def test_what_else_is_wrong_with_the_call_is_told(scene, tmp_path):
    one_line(run("report", tmp_path / "gone.json", "--vary", "render.samples=1"), 2, "gone.json", "No such file")
    one_line(run("report", scene, "--vary", "render.samples=1", "-o", scene), 1, "cannot be made a folder")
