"""Transforms mean what the format says, and are judged singular only where they are."""

import math

import numpy as np
import pytest
from documents import minimal
from hypothesis import given
from hypothesis import strategies as st

from tilecast.scene import SceneError, parse, transforms

angles = st.floats(-1000, 1000)


def matrix(transform) -> np.ndarray:
    scene = parse(minimal(scene=[{"object": {"type": "sphere", "radius": 1}, "transform": transform}]))
    return transforms.matrices([scene.scene[0].transform])[0]


def about(axis: int, degrees: float) -> np.ndarray:
    """The textbook's turn about x, y or z."""
    s, c = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    return np.array([[[1, 0, 0], [0, c, -s], [0, s, c]], [[c, 0, s], [0, 1, 0], [-s, 0, c]],
                     [[c, -s, 0], [s, c, 0], [0, 0, 1]]][axis])


def test_steps_are_applied_in_order():
    m = matrix([{"scale": 2}, {"rotate": [0, 0, 90]}, {"translate": [10, 0, 0]}])
    assert np.array_equal(m @ [1, 0, 0, 1], [10, 2, 0, 1])


def test_right_angles_are_exact():
    for turns in range(-8, 9):
        for axis in range(3):
            angle = [0.0, 0.0, 0.0]
            angle[axis] = 90.0 * turns
            assert np.array_equal(matrix([{"rotate": angle}])[:3, :3], np.round(about(axis, 90 * turns)))
    assert np.array_equal(matrix([{"rotate": [0, 360e6 + 90, 0]}])[:3, :3], np.round(about(1, 90)))


@given(angles, angles, angles)
def test_three_angles_turn_about_x_then_y_then_z(x, y, z):
    expected = about(2, z) @ about(1, y) @ about(0, x)
    assert np.allclose(matrix([{"rotate": [x, y, z]}])[:3, :3], expected, rtol=0, atol=1e-12)


@given(angles, st.sampled_from([1e-90, 1.0, 1e90]))
def test_an_axis_of_any_length_turns_alike(angle, length):
    for axis in range(3):
        along = [0.0, 0.0, 0.0]
        along[axis] = length
        turned = matrix([{"rotate": {"axis": along, "angle": angle}}])[:3, :3]
        assert np.allclose(turned, about(axis, angle), rtol=0, atol=1e-12)


@given(st.lists(st.floats(-1, 1), min_size=3, max_size=3).filter(lambda a: max(map(abs, a)) > 1e-3), angles)
def test_a_turn_is_a_rotation_that_keeps_its_axis(axis, angle):
    m = matrix([{"rotate": {"axis": axis, "angle": angle}}])[:3, :3]
    assert np.allclose(m @ m.T, np.eye(3), atol=1e-14)
    assert np.isclose(np.linalg.det(m), 1)
    assert np.allclose(m @ axis, axis, atol=1e-14)


def test_the_small_box_of_the_cornell_box():
    m = matrix([{"scale": 0.3}, {"rotate": [0, -17, 0]}])
    assert np.allclose(m[:3, :3], [[0.286891, 0, -0.0877115], [0, 0.3, 0], [0.0877115, 0, 0.286891]], atol=5e-7)


def test_a_matrix_stands_for_itself():
    rows = [[1, 2, 0, 4], [0, 1, 5, 0], [0, 0, 1, 7], [0, 0, 0, 1]]
    assert np.array_equal(matrix(rows), rows)
    assert np.array_equal(matrix([{"matrix": rows}]), rows)
    assert np.array_equal(matrix([]), np.eye(4))


def test_many_transforms_at_once_are_as_one_by_one():
    rng = np.random.default_rng(0)
    steps = [lambda: {"translate": rng.normal(size=3)}, lambda: {"scale": rng.uniform(1, 2, 3)},
             lambda: {"scale": float(rng.uniform(1, 2))}, lambda: {"rotate": rng.uniform(-180, 180, 3)},
             lambda: {"rotate": {"axis": rng.normal(size=3), "angle": float(rng.uniform(-180, 180))}},
             lambda: {"matrix": np.vstack([rng.normal(size=(3, 4)), [0, 0, 0, 1]])}]
    lists = [[steps[k]() for k in rng.integers(0, len(steps), rng.integers(0, 6))] for _ in range(200)]
    scene = parse(minimal(scene=[{"object": {"type": "sphere", "radius": 1}, "transform": one} for one in lists]))
    parsed = [node.transform for node in scene.scene]
    together = transforms.matrices(parsed)
    for index, transform in enumerate(parsed):
        assert np.array_equal(together[index], transforms.matrices([transform])[0])


@pytest.mark.parametrize("scale", [[1, 1, 1e-8], [1e-50, 1e-50, 1e-50], [1e-30, 1, 1e30], [-1, 1, 1], [1e90, 1e90, 1e90]])
@pytest.mark.parametrize("turn", [[0, 0, 0], [10, 20, 30]])
def test_scales_of_any_size_are_not_singular(scale, turn):
    matrix([{"scale": scale}, {"rotate": turn}])


@given(st.integers(0, 2), angles, angles, angles, st.floats(1e-3, 1e3))
def test_a_flattened_direction_is_found_behind_any_turns(axis, x, y, z, size):
    scale = np.eye(4) * size
    scale[3, 3] = 1
    scale[axis, axis] = 0
    with pytest.raises(SceneError) as caught:
        matrix([{"rotate": [x, y, z]}, {"matrix": scale}, {"rotate": [z, x, y]}, {"translate": [1, 2, 3]}])
    assert caught.value.path == "scene[0].transform"
    assert "singular" in caught.value.message
