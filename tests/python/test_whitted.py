"""Whitted's integrator against closed forms, and against paths, which find the same light where nothing is diffuse."""

import numpy as np
import pytest
from documents import minimal

import tilecast
from tilecast import _core, _images

ABOVE = {"position": [0, 0.5, 0], "target": [0, 0, 0], "up": [1, 0, 0], "fov": 1e-6}
WHITE = [1, 1, 1]
SUN = {"type": "directional", "direction": [0, -1, 0], "irradiance": [np.pi] * 3}
LAMP = {"type": "area", "object": {"type": "rectangle", "size": [2, 1]}, "radiance": WHITE,
        "transform": [{"rotate": [180, 0, 0]}, {"translate": [0.3, 2, 0]}]}
BALL = {"type": "area", "object": {"type": "sphere", "radius": 0.7}, "radiance": WHITE,
        "transform": [{"translate": [0.3, 2, 0]}]}
PLATE = {"type": "rectangle", "size": [20, 20]}
METAL = {"type": "conductor", "reflectance": WHITE, "roughness": 0.5}


def box(low, high, **material):
    return {"object": {"type": "box", "min": [-5, low, -5], "max": [5, high, 5]}, "material": {"type": "dielectric", **material}}


def pixels(scene, integrator="whitted", samples=1, size=1, folder=None, camera=ABOVE, max_depth=8, **keys) -> np.ndarray:
    """The radiance of one point, as each of size x size pixels finds it."""
    document = minimal(scene=scene, image={"width": size, "height": size}, **keys) | {
        "camera": camera, "render": {"integrator": integrator, "max_depth": max_depth, "roulette": False}}
    return tilecast.render(tilecast.load(document, folder=folder), samples=samples).pixels[..., 0].astype(float)


def seen(*arguments, **keys) -> float:
    """The same where nothing is left to chance."""
    return float(pixels(*arguments, **keys)[0, 0])


def estimate(*arguments, samples=64, **keys) -> tuple[float, float]:
    """The same where much is, and its standard error."""
    found = pixels(*arguments, samples=samples, size=8, **keys)
    return found.mean(), found.std() / np.sqrt(found.size - 1)


def same(a, b):
    return abs(a[0] - b[0]) <= 4.5 * np.hypot(a[1], b[1]) + 1e-6


@pytest.fixture
def surroundings(tmp_path):
    _images.write(str(tmp_path / "white.exr"), np.ones((1, 1, 3), np.float32), ["R", "G", "B"])
    return tmp_path


GLOSSY = [METAL, {"type": "conductor", "roughness": 0.2}, {"type": "dielectric", "roughness": 0.5},
          {"type": "principled", "metallic": 0.5, "roughness": 0.5},
          {"type": "blend", "of": [{"type": "dielectric", "roughness": 0.4}, METAL], "weight": 0.4},
          {"type": "blend", "of": [{"type": "diffuse"}, METAL], "weight": 0.7}]


@pytest.mark.parametrize("material", GLOSSY)
def test_surroundings_count_once_for_what_is_glossy(surroundings, material):
    arguments = {"background": {"type": "image", "file": "white.exr"}, "folder": surroundings}
    ball = [{"object": {"type": "sphere", "radius": 0.2}, "material": material}]
    found = estimate(ball, **arguments)
    assert same(found, estimate(ball, "path", **arguments))
    if material is METAL:
        assert found[0] == pytest.approx(1, abs=4.5 * found[1] + 1e-3)


@pytest.mark.parametrize("material, expected", [({"type": "diffuse"}, 0), ({"type": "mirror"}, 1)])
def test_a_background_of_one_colour_is_mirrored_and_lights_nothing_diffuse(material, expected):
    assert seen([{"object": PLATE, "material": material}], background=WHITE) == expected


@pytest.mark.parametrize("lamp", [LAMP, BALL])
@pytest.mark.parametrize("material", [material for material in GLOSSY])
def test_a_lamp_counts_once_for_what_is_glossy(material, lamp):
    plate = [{"object": PLATE, "material": material}]
    found, expected = (estimate(plate, integrator, samples=256, lights=[lamp]) for integrator in ("whitted", "path"))
    assert found[0] > 0.01 and same(found, expected)


def test_a_lamp_behind_glass_counts_once_for_what_is_glossy():
    plate = [{"object": PLATE, "material": METAL}, box(1, 1.2, ior=1.5)]
    found, expected = (estimate(plate, integrator, samples=1024, lights=[LAMP]) for integrator in ("whitted", "path"))
    assert found[0] > 0.3 and same(found, expected)


# Seen from below, and at two segments, so that there is one way for the light: straight down through the glass.
def test_light_through_a_rough_surface_is_lost_behind_it():
    def through(**glass):
        below = {"position": [0, -2, 0], "target": [0.3, 0, 0], "up": [1, 0, 0], "fov": 1e-6}
        return seen([box(-1, 0, ior=1.5, roughness=0.6, **glass)], camera=below, max_depth=2, lights=[SUN])

    clear = through()
    assert clear > 0.01
    assert through(absorption=[3, 3, 3]) / clear == pytest.approx(np.exp(-3), rel=1e-5)


@pytest.mark.parametrize("opacity", [0, 0.25, 0.5, 1])
def test_a_net_of_glass_takes_its_share_of_the_light(opacity):
    floor = {"object": PLATE, "material": {"type": "diffuse", "reflectance": WHITE}}
    found = seen([floor, box(1, 1.5, ior=10, opacity=opacity)], lights=[SUN])
    assert found == pytest.approx((1 - opacity * (9 / 11) ** 2) ** 2, rel=1e-6)


@pytest.mark.parametrize("glass", [{"ior": 100}, {"ior": 1e-2}, {"ior": 330, "opacity": 0}, {"ior": 5, "opacity": 0.5}])
def test_what_is_behind_a_high_index_shows(glass):
    found = seen([box(-1, 0, **glass)], max_depth=9999, background=WHITE)
    assert found == pytest.approx(1, abs=0.01)  # branches end at 1e-5 each


def test_a_ball_of_one_medium_may_have_any_number_of_layers():
    layers = [{"object": {"type": "sphere", "radius": 1 + i / 100}, "material": "water"} for i in range(40)]
    medium = {"water": {"type": "dielectric", "ior": 1.5, "absorption": WHITE}}
    camera = {"position": [0, 0, 3], "target": [0, 0, 0], "fov": 1e-6}
    left, reflected = np.exp(-2 * 1.39), 0.04
    expected = reflected + (1 - reflected) ** 2 * left / (1 - reflected * left)
    found = seen(layers, camera=camera, max_depth=50, materials=medium, background=WHITE)
    assert found == pytest.approx(expected, abs=1e-4)
    assert same(estimate(layers, "path", camera=camera, max_depth=50, materials=medium, background=WHITE), (expected, 0))


def test_more_media_in_one_place_than_are_kept_are_refused():
    def layers(count):
        return [{"object": {"type": "sphere", "radius": 2 - i / 100},
                 "material": {"type": "dielectric", "ior": 1, "absorption": [0.1 + 0.01 * i] * 3}} for i in range(count)]

    camera = {"position": [0, 0, 3], "target": [0, 0, 0], "fov": 1e-6}
    depth = sum((0.1 + 0.01 * i) * 2 * (0.01 if i < 15 else 1.85) for i in range(16))
    for integrator in ("path", "whitted"):
        arguments = {"integrator": integrator, "camera": camera, "max_depth": 50, "background": WHITE}
        assert seen(layers(16), **arguments) == pytest.approx(np.exp(-depth), rel=1e-5)
        with pytest.raises(_core.SampleError, match="more than 16 dielectrics"):
            seen(layers(17), **arguments)
