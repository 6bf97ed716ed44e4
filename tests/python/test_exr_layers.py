"""What an EXR holds beside the picture: the error of each pixel, and what the camera sees first."""

import json

import numpy as np
import pytest
from commands import one_line, run
from documents import diffuse, minimal

import tilecast
from tilecast import _core, _images
from tilecast.render import layers, output
from tilecast.render.display import heat
from tilecast.render.error import error_map
from tilecast.render.local import first_hits

NAMES = {"variance.R", "variance.G", "variance.B", "error", "samples", "albedo.R", "albedo.G", "albedo.B", "normal.X",
         "normal.Y", "normal.Z", "depth.Z"}


def wall(**render):
    """A red square, 3 wide and 4 away, a glass ball in front of its left half; nothing beyond its edges."""
    square = {"type": "rectangle", "size": [3, 3], "transform": [{"rotate": [90, 0, 0]}]}
    red = {"type": "diffuse", "reflectance": [0.7, 0.2, 0.1]}
    return minimal(camera={"position": [0, 0, 4], "target": [0, 0, 0], "fov": 60}, image={"width": 36, "height": 36},
                   render=render, background=[1, 1, 1],
                   scene=[{"object": square, "material": red},
                          {"object": {"type": "sphere", "radius": 0.25}, "material": {"type": "dielectric"},
                           "transform": [{"translate": [-0.8, 0, 2]}]}])


def test_first_hits_are_the_albedo_the_outward_normal_and_the_distance():
    scene = tilecast.load(wall())
    hits = first_hits(scene)
    assert hits.shape == (36, 36, 7) and hits.dtype == np.float32
    albedo, normal, depth = hits[..., :3], hits[..., 3:6], hits[..., 6]
    half = np.tan(np.radians(30)) * 4  # of the image in the square's plane
    assert not hits[0].any() and not hits[:, 0].any()  # beyond the square's edges there is nothing
    inside = hits[16:20, 20:28]
    assert np.allclose(inside[..., :3], [0.7, 0.2, 0.1], rtol=1e-6)
    assert np.allclose(inside[..., 3:6], [0, 0, 1], atol=1e-6)
    x, y = ((np.arange(36) + 0.5) / 18 - 1) * half, ((np.arange(36) + 0.5) / 18 - 1) * half
    distance = np.sqrt(16 + x**2 + y[:, None] ** 2)
    pixel = half / 18
    assert np.abs(depth - distance)[16:20, 20:28].max() < pixel  # a mean over the pixel
    ball = np.unravel_index(np.argmin(np.where(depth > 0, depth, 9)), depth.shape)
    assert np.allclose(albedo[ball], 1) and normal[ball][2] > 0.5 and depth[ball] < 2.2
    edge = albedo[18, :, 0]
    assert np.any((edge > 0.01) & (edge < 0.69))  # a pixel on the square's edge holds a part of it
    partly = (edge > 0.01) & (edge < 0.69)
    assert depth[18, partly].min() > 4  # and the distance of what is hit


def test_first_hits_do_not_depend_on_tiles_and_light():
    scene, dark = (tilecast.load(wall(samples=samples)) for samples in (1, 64))
    whole = first_hits(scene, threads=1)
    assert np.array_equal(whole, first_hits(dark, threads=3))
    assert np.array_equal(scene.scene.first_hits(5, 7, 9, 11, layers.FIRST_HIT_SAMPLES), whole[7:18, 5:14])
    with pytest.raises(_core.Error, match="outside of the image"):
        scene.scene.first_hits(30, 0, 9, 9, 16)
    with pytest.raises(_core.Error, match="at least one sample"):
        scene.scene.first_hits(0, 0, 9, 9, 0)


def test_the_variance_of_the_pixels_is_the_error_of_the_image():
    image = tilecast.render(tilecast.load(diffuse(16)))
    assert image.variance.mean() == pytest.approx(image.error["mse"], rel=1e-5)
    assert (image.sample_counts == 16).all() and image.sample_counts.shape == image.pixels.shape[:2]
    once = tilecast.render(tilecast.load(diffuse(1)))
    assert not once.variance.any() and (once.sample_counts == 1).all()


def test_the_map_finds_the_noise_and_its_mean_is_the_relative_error():
    generator = np.random.default_rng(0)
    truth, spread = np.full((64, 96, 3), 0.5), np.where(np.arange(96) < 48, 0.01, 0.1)[:, None]
    a, b = (truth + spread * generator.standard_normal(truth.shape) for _ in range(2))
    found = error_map((a + b) / 2, (a - b) ** 2 / 4)
    expected = spread[:, 0] ** 2 / 2 / (0.25 + 0.01)
    assert found.shape == (64, 96) and found.dtype == np.float32
    # 9 x 9 x 3 squares of normal numbers: a relative standard deviation of sqrt(2 / 243) = 0.09, less in their mean
    assert np.allclose(found[:, :44] / expected[:44], 1, atol=0.5)
    assert np.allclose(found[:, 52:] / expected[52:], 1, atol=0.5)
    assert found[:, :44].mean() == pytest.approx(expected[0], rel=0.05)
    assert found[:, 52:].mean() == pytest.approx(expected[-1], rel=0.05)


def test_the_heat_of_an_error_is_its_logarithm():
    ramp = heat(np.array([[0, 1e-9, 1e-6, 1e-3, 1, 50]]))
    assert not (ramp[0, 0] > 0.01).any() and np.array_equal(ramp[0, :2], ramp[0, [2, 2]])
    assert np.array_equal(ramp[0, 4], ramp[0, 5]) and ramp[0, 4].min() > 0.3
    steps = heat(10.0 ** np.linspace(-6, 0, 50)[None])[0] @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(steps) > 0).all()


def test_the_command_writes_layers_into_an_exr_and_a_map(tmp_path):
    scene = tmp_path / "wall.json"
    scene.write_text(json.dumps(wall(samples=8)))
    assert run("render", scene, "-o", tmp_path / "out.exr", "--error-map", tmp_path / "error.png", "-q").returncode == 0
    pixels, channels, _ = _images.read(str(tmp_path / "out.exr"))
    assert channels[:3] == ["R", "G", "B"] and set(channels[3:]) == NAMES
    found = dict(zip(channels, np.moveaxis(pixels, 2, 0)))
    compiled = tilecast.load(wall(samples=8))
    image = tilecast.render(compiled)
    expected = layers.error_layers(image.pixels, image.variance, image.sample_counts) \
        | layers.first_hit_layers(first_hits(compiled))
    for name, values in expected.items():
        assert np.array_equal(found[name], values), name
    assert np.array_equal(pixels[..., :3], image.pixels)
    assert run("batch", scene, "-o", tmp_path / "all", "--format", "exr", "-q").returncode == 0
    assert _images.read(str(tmp_path / "all" / "wall.exr"))[1] == channels
    assert (tmp_path / "error.png").read_bytes() == output.error_png(image.pixels, image.variance)
    assert run("render", scene, "-o", tmp_path / "o.png", "--error-map", tmp_path / "e.exr").returncode == 2


def test_one_sample_has_no_layers_of_its_error_and_no_map(tmp_path):
    scene = tmp_path / "wall.json"
    scene.write_text(json.dumps(wall(samples=1)))
    assert run("render", scene, "-o", tmp_path / "out.exr", "-q").returncode == 0
    channels = _images.read(str(tmp_path / "out.exr"))[1]
    assert set(channels[3:]) == {name for name in NAMES if not name.startswith(("variance", "error"))}
    one_line(run("render", scene, "-o", tmp_path / "o.exr", "--error-map", tmp_path / "e.png"), 2,
             "render.samples: must be at least 2 for an error map, got 1")
    assert not (tmp_path / "o.exr").exists()
    partly = layers.error_layers(np.ones((2, 2, 3)), np.ones((2, 2, 3)), np.array([[2, 2], [0, 1]]))
    for name in ("variance.R", "error"):
        assert np.isfinite(partly[name][0]).all() and np.isnan(partly[name][1]).all()


def test_light_whose_variance_no_float_holds_has_its_error_all_the_same(caplog):
    """Radiance of 1e22 behind the square, so that pixels on its edges have a variance of 1e42 or more."""
    document = wall(samples=16) | {"background": [1e22] * 3}
    image, dim = (tilecast.render(tilecast.load(found)) for found in (document, wall(samples=16)))
    assert image.variance.dtype == np.float64 and dim.variance.dtype == np.float32
    assert image.variance.mean() == pytest.approx(image.error["mse"], rel=1e-6)
    found = layers.error_layers(image.pixels, image.variance, image.sample_counts)
    assert all(layer.dtype == np.float32 and np.isfinite(layer).all() for layer in found.values())
    assert found["variance.R"].max() == np.finfo(np.float32).max and "becomes that" in caplog.text
    assert found["error"].mean() == pytest.approx(image.error["relative_mse"], rel=0.3)
