"""Transforms of the scene format as 4 x 4 matrices for column vectors: p' = M p.

All transforms of a scene are worked out together, step by step. The arithmetic is spelled out element by
element (no BLAS, no vectorised sine), so that it rounds the same on every machine.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence

import numpy as np

from . import schema

# A transform is singular where its 3 x 3 part, each row and column brought to length 1, squeezes some
# direction by more than this. Rounding leaves up to some 1e-15 of a direction that was meant to vanish;
# honest transforms of condition number 1e8 stay far above, and plain scales by axis are exactly 1 after the
# lengths are taken out.
_SINGULAR = 1e-14


def matrices(transforms: Sequence[list | None]) -> np.ndarray:
    """The matrix of each validated transform (None: none); float64 [n, 4, 4]."""
    result = _identities(len(transforms))
    whole = [index for index, transform in enumerate(transforms) if transform and isinstance(transform[0], list)]
    if whole:
        result[whole] = np.array([transforms[index] for index in whole], np.float64)
    left = [index for index, transform in enumerate(transforms) if transform and not isinstance(transform[0], list)]
    at = 0
    while left:  # the next step of every transform that has one
        by_kind: dict[type, list[int]] = {}
        for index in left:
            by_kind.setdefault(type(transforms[index][at]), []).append(index)
        for kind, indices in by_kind.items():
            steps = _STEPS[kind]([transforms[index][at] for index in indices])
            result[indices] = product(steps, result[indices])
        at += 1
        left = [index for index in left if at < len(transforms[index])]
    return result


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a b for each pair of float64 [n, k, k]."""
    with np.errstate(all="ignore"):  # an overflow is told by `problems`, with its place
        return sum(a[:, :, k, None] * b[:, None, k, :] for k in range(a.shape[1]))


def _identities(count: int) -> np.ndarray:
    return np.tile(np.eye(4), (count, 1, 1))


def _translate(steps: list[schema.Translate]) -> np.ndarray:
    result = _identities(len(steps))
    result[:, :3, 3] = [step.translate for step in steps]
    return result


def _scale(steps: list[schema.Scale]) -> np.ndarray:
    result = _identities(len(steps))
    result[:, range(3), range(3)] = [
        step.scale if isinstance(step.scale, list) else [step.scale] * 3 for step in steps]
    return result


def _matrix(steps: list[schema.MatrixStep]) -> np.ndarray:
    return np.array([step.matrix for step in steps], np.float64)


def _rotate(steps: list[schema.Rotate]) -> np.ndarray:
    result = _identities(len(steps))
    about_axis = [index for index, step in enumerate(steps) if isinstance(step.rotate, schema.AxisAngle)]
    about_xyz = [index for index, step in enumerate(steps) if not isinstance(step.rotate, schema.AxisAngle)]
    if about_axis:
        result[about_axis, :3, :3] = [_about(steps[index].rotate) for index in about_axis]
    if about_xyz:
        x, y, z = zip(*(steps[index].rotate for index in about_xyz))
        turned = product(_turn(2, z), product(_turn(1, y), _turn(0, x)))
        result[about_xyz, :3, :3] = turned
    return result


def _turn(axis: int, degrees: Sequence[float]) -> np.ndarray:
    """Turns about x, y or z; float64 [n, 3, 3]."""
    sin, cos = np.array([_sin_cos(angle) for angle in degrees]).T
    result = np.zeros((len(sin), 3, 3))
    u, v = (axis + 1) % 3, (axis + 2) % 3
    result[:, axis, axis] = 1
    result[:, u, u] = result[:, v, v] = cos
    result[:, u, v], result[:, v, u] = -sin, sin
    return result


def _about(turn: schema.AxisAngle) -> list[list[float]]:
    """A turn about an axis (Rodrigues)."""
    largest = max(map(abs, turn.axis))  # taken out first: its square may overflow or vanish
    x, y, z = (value / largest for value in turn.axis)
    length = math.sqrt(x * x + y * y + z * z)
    x, y, z = x / length, y / length, z / length
    sin, cos = _sin_cos(turn.angle)
    t = 1 - cos
    return [[cos + x * x * t, x * y * t - z * sin, x * z * t + y * sin],
            [y * x * t + z * sin, cos + y * y * t, y * z * t - x * sin],
            [z * x * t - y * sin, z * y * t + x * sin, cos + z * z * t]]


@functools.lru_cache(4096)  # most angles of a scene are 0 or come again
def _sin_cos(degrees: float) -> tuple[float, float]:
    """Sine and cosine of degrees, exact at multiples of 90."""
    turned = math.fmod(degrees, 360.0)
    rest = math.remainder(turned, 90.0)  # within +-45; like fmod, exact
    sin, cos = math.sin(math.radians(rest)), math.cos(math.radians(rest))
    quarter = round((turned - rest) / 90.0) % 4
    return ((sin, cos), (cos, -sin), (-sin, -cos), (-cos, sin))[quarter]


_STEPS = {schema.Translate: _translate, schema.Scale: _scale, schema.Rotate: _rotate, schema.MatrixStep: _matrix}


def problems(matrices: np.ndarray) -> list[tuple[int, str]]:
    """What is wrong with each of float64 [n, 4, 4] matrices: (index, message), in order of the index."""
    found: dict[int, str] = {}
    linear = matrices[:, :3, :3]
    finite = np.isfinite(matrices).all(axis=(1, 2))
    for index in np.flatnonzero(~finite):
        found[int(index)] = "overflows: scale by smaller numbers"
    affine = (matrices[:, 3] == [0, 0, 0, 1]).all(axis=1)
    for index in np.flatnonzero(~affine & finite):
        found[int(index)] = "must have the last row 0 0 0 1: only affine transforms can place an object"

    balanced = np.where(finite[:, None, None], linear, np.eye(3))
    for axis in (1, 2, 1, 2):  # columns, rows, and both again: the second round settles what the first has moved
        largest = np.abs(balanced).max(axis=axis, keepdims=True)
        balanced = balanced / np.where(largest > 0, largest, 1)
    smallest = np.linalg.svd(balanced, compute_uv=False)[:, 2]
    with np.errstate(all="ignore"):  # too small or too large a volume to invert in double precision
        invertible = np.isfinite(1 / np.abs(np.linalg.det(linear)))
    for index in np.flatnonzero((smallest < _SINGULAR) & finite):
        found.setdefault(int(index), "is singular: it flattens the object")
    for index in np.flatnonzero(~invertible & finite):
        found.setdefault(int(index), "is singular in double precision: scale by numbers nearer to 1")
    return sorted(found.items())
