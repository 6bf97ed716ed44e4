"""Small scenes that the tests share, as JSON documents."""

from __future__ import annotations

import copy
from typing import Any

CAMERA = {"type": "perspective", "position": [0, 1, 5], "target": [0, 0, 0], "fov": 40}

# The example of the scene format, with its mesh in place.
EXAMPLE: dict[str, Any] = {
    "version": 1,
    "camera": {"type": "perspective", "position": [0, 2, 8], "target": [0, 0, 0], "up": [0, 1, 0], "fov": 40},
    "image": {"width": 64, "height": 48, "filter": "box"},
    "render": {"integrator": "path", "samples": 64, "max_depth": 8, "accelerator": "auto", "seed": 0,
               "stop": {"relative_mse": 0.001, "seconds": 60}},
    "materials": {"brass": {"type": "conductor", "reflectance": [0.9, 0.7, 0.3], "roughness": 0.2},
                  "glass": {"type": "dielectric", "ior": 1.5}},
    "objects": {
        "part": {"type": "difference", "of": [
            {"type": "intersection", "of": [{"type": "box", "min": [-1, -1, -1], "max": [1, 1, 1]},
                                            {"type": "sphere", "radius": 1.35}]},
            {"type": "cylinder", "radius": 0.6, "height": 4, "transform": [{"rotate": [0, 0, 90]}]}]},
        "pyramid": {"type": "mesh", "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
                    "faces": [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]}},
    "scene": [
        {"object": "part", "material": "brass",
         "transform": [{"scale": 0.5}, {"rotate": [0, 30, 0]}, {"translate": [0, 1, 0]}]},
        {"object": "pyramid", "material": "glass"}],
    "lights": [{"type": "point", "position": [4, 6, 4], "intensity": [60, 60, 60]},
               {"type": "area", "object": {"type": "rectangle", "size": [1, 1]}, "radiance": [3, 3, 3],
                "transform": [{"rotate": [180, 0, 0]}, {"translate": [0, 3, 0]}]}],
    "background": [0.1, 0.1, 0.1],
}


def example() -> dict[str, Any]:
    """A copy of the example, to be changed."""
    return copy.deepcopy(EXAMPLE)


def minimal(**keys: Any) -> dict[str, Any]:
    """The shortest scene, and some keys more."""
    return {"camera": copy.deepcopy(CAMERA), **keys}


def quick(samples: int = 16, width: int = 48, height: int = 32, **render: Any) -> dict[str, Any]:
    """The example, small enough to be rendered in a moment."""
    document = example()
    document["image"] |= {"width": width, "height": height}
    document["render"] = {"samples": samples, **render}
    return document


def diffuse(samples: int = 64, width: int = 40, height: int = 30, **render: Any) -> dict[str, Any]:
    """A ball on the floor under a lamp, all diffuse: noise without rare bright samples."""
    return minimal(image={"width": width, "height": height}, render={"samples": samples, **render},
                   scene=[{"object": {"type": "sphere", "radius": 1}},
                          {"object": {"type": "box", "min": [-9, -2, -9], "max": [9, -1, 9]}}],
                   lights=[{"type": "area", "object": {"type": "sphere", "radius": 1}, "radiance": [4, 5, 6],
                            "transform": [{"translate": [2, 4, 2]}]}], background=[0.2, 0.2, 0.2])
