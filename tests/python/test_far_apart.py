"""Scenes whose parts differ in size by more than floats can square, or that multiply out to more than can be walked."""

import time

import numpy as np
import pytest
from documents import minimal

import tilecast
from tilecast.render.error import error_map

SPHERE = {"type": "sphere", "radius": 1.8}


def rays(count: int) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(5)
    origins = random.normal(size=(count, 3))
    origins *= 4.0 / np.linalg.norm(origins, axis=1, keepdims=True)
    return origins, random.uniform(-1.2, 1.2, (count, 3)) - origins


@pytest.mark.parametrize("end", [1e6, 1e18, 2e19, 1e21, 1e25, 1e30])
@pytest.mark.parametrize("operation", ["difference", "intersection", "union"])
def test_a_box_without_end_takes_nothing_else_away(operation, end):
    endless = {"type": "box", "min": [-1, -1, -end], "max": [1, 1, end]}
    origins, directions = rays(1000)

    def hits(box: dict):
        csg = {"type": operation, "of": [SPHERE, box]}
        return tilecast.load(minimal(scene=[{"object": csg}])).closest(origins, directions)

    found, expected = hits(endless), hits({"type": "box", "min": [-1, -1, -100], "max": [1, 1, 100]})
    assert np.isfinite(expected.t).sum() > 500
    assert np.allclose(found.t, expected.t, rtol=1e-6, atol=1e-6, equal_nan=True)


def test_csg_of_nothing_is_nothing():
    nothing = {"type": "group", "of": []}
    for operation in ("union", "intersection", "difference"):
        scene = tilecast.load(minimal(scene=[{"object": {"type": operation, "of": [nothing, nothing]}}]))
        origins, directions = rays(10)
        assert np.isinf(scene.closest(origins, directions).t).all()
        assert not scene.occluded(origins, directions).any()
        assert len(scene.crossings(origins, directions).t) == 0


def test_light_beyond_the_range_of_floats_stays_finite():
    image = tilecast.render(tilecast.load(minimal(
        image={"width": 4, "height": 4}, render={"samples": 16}, scene=[{"object": {"type": "rectangle", "size": [1, 1]}}],
        camera={"type": "orthographic", "position": [0, 1, 0], "target": [0, 0, 0], "up": [0, 0, 1], "height": 1e-5},
        lights=[{"type": "point", "position": [0, 1e-5, 0], "intensity": [1e30, 1e30, 1e30]}])))
    assert (image.pixels > 1e38).all() and np.isfinite(image.pixels).all() and np.isfinite(image.variance).all()
    assert np.isfinite(error_map(image.pixels, image.variance)).all()


@pytest.mark.parametrize("emitter", [{"type": "box", "min": [-1, -1, -1], "max": [1, 1, 1]},
                                     {"type": "rectangle", "size": [1, 1]}])
def test_emitters_without_number_are_met_by_chance(emitter):
    objects = {"0": {"type": "group", "of": [{"object": emitter, "material": "lamp"}]}}
    for level in range(1, 37):
        objects[str(level)] = {"type": "group", "of": [
            {"object": str(level - 1), "transform": [{"translate": [side * 3.0 * 2**level, 0, 0]}]} for side in (-1, 1)]}
    began = time.monotonic()
    tilecast.load(minimal(materials={"lamp": {"type": "diffuse", "emission": [1, 1, 1]}}, objects=objects,
                          scene=[{"object": "36"}], render={"integrator": "path"}))
    assert time.monotonic() - began < 60
