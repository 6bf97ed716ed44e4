"""One sample of one pixel, alone: it depends on nothing else, so a failure can be seen again without the image."""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence

import numpy as np

from .. import _core
from ..scene.compiler import Compiled
from ..scene.errors import SceneError


def one_sample(compiled: Compiled, x: int, y: int, sample: int) -> np.ndarray:
    """Its radiance, float64 [3], linear RGB. (x, y): the pixel, from the top left; `sample`: from 0. SceneError where
    the image has no such pixel, the core's SampleError where the sample is not finite."""
    scene = compiled.scene
    if not (0 <= x < scene.width and 0 <= y < scene.height):
        raise SceneError("image", f"has {scene.width} x {scene.height} pixels, and none at ({x}, {y})")
    return scene.render_chunk(x, y, 1, 1, sample, 1).sums[sample & 1, 0, 0]


_PLACE = re.compile(r"pixel \((?P<x>\d+), (?P<y>\d+)\), sample (?P<sample>\d+), seed (?P<seed>\d+)")


def with_command(error: _core.SampleError, scene: str = "SCENE", settings: Sequence[str] = ()) -> str:
    """What the core says of a sample that is not finite, and the command that renders it again. The text is all that
    the core's error has; it comes from other processes too."""
    place = _PLACE.search(str(error))
    if place is None:
        return str(error)
    words = ["tilecast", "sample", scene, "--pixel", f"{place['x']},{place['y']}", "--sample", place["sample"],
             *(word for setting in settings for word in ("--set", setting)), "--set", f"render.seed={place['seed']}"]
    return f"{error}; to see it again: {shlex.join(words)}"
