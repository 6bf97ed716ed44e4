"""Views: what they hold, what a PNG shows of it, and what a scene does not pay for with them."""

import json

import numpy as np
import pytest
import trimesh
from commands import run
from documents import minimal, quick

import tilecast
from tilecast import _images
from tilecast.render import display, output

VIEWS = ("normals", "depth", "primitives", "instances", "facing", "cost")


def wall(distance: float, **render) -> dict:
    """A square of 4 x 4 metres, looked at from so far that it fills the image."""
    return minimal(camera={"position": [0, 0, distance], "target": [0, 0, 0], "fov": 1},
                   image={"width": 8, "height": 8}, render={"samples": 1, **render},
                   scene=[{"object": {"type": "rectangle", "size": [4, 4]}, "transform": [{"rotate": [90, 0, 0]}]}])


def image(document, **keys) -> np.ndarray:
    return tilecast.render(tilecast.load(document), **keys).pixels


def test_depth_is_in_metres():
    pixels = image(wall(5, integrator="depth"))
    assert pixels == pytest.approx(5, abs=5 * (1 - np.cos(np.radians(1))))
    facts = tilecast.load(wall(5, integrator="depth", view_range=[4, 6])).facts()
    assert facts["shown"] == {"view": "depth", "range": [4, 6]}


@pytest.mark.parametrize("view, bright, dark", [("depth", 2, 8), ("cost", 8, 2)])
def test_the_ramp_goes_from_bright_to_black(view, bright, dark):
    facts = {"shown": {"view": view, "range": [2, 8]}}

    def shown(value):
        return display.shown(np.full((1, 1, 3), value, np.float32), facts)[0, 0]

    assert shown(bright).min() > 0.3 and shown(dark).max() < 0.01
    assert np.array_equal(shown(0), shown(dark)) and np.array_equal(shown(1e30), shown(8))
    between = [output.srgb(shown(value)) @ [0.2126, 0.7152, 0.0722] for value in np.linspace(bright, dark, 50)]
    assert (np.diff(between) < 0).all()  # in grey, too


def test_light_and_colours_are_shown_as_they_are():
    for integrator in ("whitted", "facing"):
        pixels = image(quick(2, integrator=integrator))
        assert display.shown(pixels, tilecast.load(quick(2, integrator=integrator)).facts()) is pixels
    assert display.shown(pixels, None) is pixels


def test_a_png_of_normals_holds_them_as_normal_maps_do():
    document = quick(1, integrator="normals")
    pixels = image(document)
    bytes_ = output.srgb(display.shown(pixels, tilecast.load(document).facts()))
    assert np.abs(bytes_ - pixels.astype(float) * 255).max() < 0.501


@pytest.mark.parametrize("position, near, far", [([0, 0, 5], 4, np.sqrt(38)), ([0, 0, 0.5], 0, np.sqrt(4.25))])
def test_depths_are_shown_between_the_nearest_and_the_farthest_point_of_the_scene(position, near, far):
    document = minimal(camera={"position": position, "target": [0, 0, -9]}, render={"integrator": "depth"},
                       scene=[{"object": {"type": "box", "min": [-1, -1, -1], "max": [1, 1, 1]}}])
    assert tilecast.load(document).facts()["shown"]["range"] == pytest.approx([near, far], rel=1e-12)
    assert tilecast.load(document | {"scene": []}).facts()["shown"]["range"] == [0, 1]


def test_depths_of_any_size_have_finite_errors():
    document = minimal(camera={"position": [0, 0, 1e60], "target": [0, 0, 0]}, image={"width": 4, "height": 4},
                       render={"integrator": "depth", "samples": 4},
                       scene=[{"object": {"type": "sphere", "radius": 8e59}}])
    result = tilecast.render(tilecast.load(document))
    assert result.pixels.max() == np.float32(1e30)
    json.dumps(result.stats, allow_nan=False)
    assert display.shown(result.pixels, result.stats).max() <= 1


@pytest.mark.parametrize("view", VIEWS)
def test_a_view_uses_geometry_alone(view):
    result = tilecast.render(tilecast.load(quick(4, integrator=view)))
    assert set(result.stats["features"]["used"]) == {"csg", "hierarchy", "mesh", "rectangle", "solid"} \
        - ({"hierarchy"} if result.stats["accelerator"]["nodes"] == 0 else set())
    assert {"shadow_rays", "point_lights", "area_lights", "dielectric"} <= set(result.stats["features"]["left_out"])
    assert result.stats["rays"] == {"camera": 48 * 32 * 4, "bounce": 0, "shadow": 0}
    assert result.stats["kernel"].startswith(view)
    assert ("shown" in result.stats) == (view in ("normals", "depth", "cost"))
    assert result.error["relative_mse"] > 0 and result.pixels.std() > 0


@pytest.mark.parametrize("accelerator, least, most", [("none", 81, 81), ("bvh", 3, 80)])
def test_cost_counts_what_a_ray_is_tested_against(accelerator, least, most):
    ball = trimesh.creation.icosphere(subdivisions=1)  # 80 faces, and the instance
    document = minimal(camera={"position": [0, 0, 5], "target": [0, 0, 0], "fov": 10}, image={"width": 8, "height": 8},
                       render={"integrator": "cost", "samples": 1, "accelerator": accelerator},
                       scene=[{"object": {"type": "mesh", "vertices": ball.vertices.tolist(),
                                          "faces": ball.faces.tolist()}}])
    scene = tilecast.load(document)
    steps, tests = scene.scene.camera_cost(0, 0, 8, 8)
    assert least * 64 <= tests <= most * 64
    assert (steps == 64) == (accelerator == "none")  # the instance's box alone
    pixels = tilecast.render(scene).pixels
    assert pixels.min() > least and (accelerator == "bvh" or (pixels == 82).all())
    assert pixels.mean() == pytest.approx((steps + tests) / 64, rel=0.2)  # through other points of the pixels
    assert scene.facts()["shown"] == {"view": "cost", "range": [0, 256]}


@pytest.mark.parametrize("view", VIEWS)
def test_a_view_is_the_same_with_any_tiles_and_threads(view):
    scene = tilecast.load(quick(2, integrator=view))
    assert np.array_equal(tilecast.render(scene, threads=1, tile_size=16).pixels,
                          tilecast.render(scene, threads=3, tile_size=64).pixels)


def test_numbers_are_not_blended_with_one_sample():
    one, four = (np.unique(image(quick(samples, integrator="primitives")).reshape(-1, 3), axis=0) for samples in (1, 4))
    assert len(one) <= tilecast.load(quick()).scene.primitives + 1  # and the background
    assert len(one) < len(four)


def test_the_bounds_of_a_scene_hold_it():
    bounds = tilecast.load(minimal(scene=[{"object": {"type": "sphere", "radius": 2}, "transform": [
        {"translate": [1, 2, 3]}]}])).scene.bounds
    assert bounds == pytest.approx(np.array([[-1, 0, 1], [3, 4, 5]]), rel=1e-12)
    assert tilecast.load(minimal()).scene.bounds is None


def test_an_exr_holds_the_values_and_a_png_the_ramp(tmp_path):
    scene = tmp_path / "wall.json"
    scene.write_text(json.dumps(wall(5)))
    for name in ("depth.exr", "depth.png"):
        result = run("render", scene, "-o", tmp_path / name, "--integrator", "depth", "-q",
                     "--set", "render.view_range=[4, 6]")
        assert result.returncode == 0, result.stderr
    exr, png = (_images.read(str(tmp_path / name))[0] for name in ("depth.exr", "depth.png"))
    assert exr[..., :3] == pytest.approx(5, abs=1e-3)
    # Inferno at a half is #bc3754.
    assert np.abs(png[..., :3] * 255 - [0xbc, 0x37, 0x54]).max() <= 1
