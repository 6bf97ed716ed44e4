"""Writes the scenes whose objects are instances of instances: sphereflake.json, menger.json, ellipsoids.json.

    python scenes/generators/instances.py
"""

import math
import random

from writing import write


def sphereflake(levels: int = 9) -> dict:
    """Haines' sphereflake: every sphere carries nine of a third its radius. 9 levels: 435,848,050 spheres."""
    children = [(60 * i, 90) for i in range(6)] + [(30 + 120 * i, 30) for i in range(3)]  # azimuth, angle from the pole
    objects = {"flake0": {"type": "sphere", "radius": 1}}
    for level in range(1, levels + 1):
        below = f"flake{level - 1}"
        objects[f"flake{level}"] = {"type": "group", "of": [{"type": "sphere", "radius": 1}] + [
            {"object": below, "transform": [{"scale": 1 / 3}, {"translate": [0, 4 / 3, 0]},
                                            {"rotate": {"axis": [0, 0, -1], "angle": polar}},
                                            {"rotate": {"axis": [0, 1, 0], "angle": azimuth}}]}
            for azimuth, polar in children]}
    return {
        "version": 1,
        "camera": {"type": "perspective", "position": [2.6, 2.3, 3.6], "target": [0, 0.15, 0], "up": [0, 1, 0], "fov": 42},
        "image": {"width": 640, "height": 480},
        "render": {"integrator": "path", "samples": 64, "max_depth": 6},
        "materials": {"silver": {"type": "conductor", "reflectance": [0.9, 0.85, 0.75], "roughness": 0.2},
                      "floor": {"type": "diffuse", "reflectance": [0.3, 0.32, 0.36]}},
        "objects": objects,
        "scene": [{"object": f"flake{levels}", "material": "silver"},
                  {"object": {"type": "rectangle", "size": [40, 40]}, "material": "floor",
                   "transform": [{"translate": [0, -1.6, 0]}]}],
        "lights": [{"type": "area", "object": {"type": "rectangle", "size": [3, 3]}, "radiance": [14, 13, 11],
                    "transform": [{"rotate": [180, 0, 0]}, {"rotate": [0, 0, -40]}, {"translate": [5, 6, 1]}]}],
        "background": [0.3, 0.38, 0.5],
    }


def menger(levels: int = 6) -> dict:
    """The Menger sponge: 20 copies of a third the size. 6 levels: 64,000,000 boxes, 384,000,000 faces."""
    places = [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if (x == 0) + (y == 0) + (z == 0) < 2]
    objects = {"sponge0": {"type": "box", "min": [-1, -1, -1], "max": [1, 1, 1]}}
    for level in range(1, levels + 1):
        objects[f"sponge{level}"] = {"type": "group", "of": [
            {"object": f"sponge{level - 1}", "transform": [{"scale": 1 / 3}, {"translate": [2 * c / 3 for c in place]}]}
            for place in places]}
    return {
        "version": 1,
        "camera": {"type": "perspective", "position": [2.2, 1.9, 2.9], "target": [0, -0.1, 0], "up": [0, 1, 0], "fov": 40},
        "image": {"width": 640, "height": 480},
        "render": {"integrator": "path", "samples": 64, "max_depth": 5},
        "materials": {"stone": {"type": "diffuse", "reflectance": [0.75, 0.66, 0.52]},
                      "floor": {"type": "diffuse", "reflectance": [0.35, 0.36, 0.38]}},
        "objects": objects,
        "scene": [{"object": f"sponge{levels}", "material": "stone"},
                  {"object": {"type": "rectangle", "size": [30, 30]}, "material": "floor",
                   "transform": [{"translate": [0, -1, 0]}]}],
        "lights": [{"type": "area", "object": {"type": "rectangle", "size": [1.5, 1.5]}, "radiance": [60, 55, 46],
                    "transform": [{"rotate": [180, 0, 0]}, {"rotate": [0, 0, -40]}, {"translate": [5, 6, 3]}]}],
        "background": [0.25, 0.35, 0.55],
    }


def ellipsoids() -> dict:
    """One sphere, placed 600 times by scales and turns: a phyllotaxis of petals."""
    random.seed(7)
    golden = 180 * (3 - math.sqrt(5))
    petals = []
    for i in range(600):
        radius = 0.16 * math.sqrt(i + 2)
        tilt = 75 - 60 * math.sqrt(i / 600) + random.uniform(-4, 4)
        petals.append({"object": "ball", "material": ["rose", "coral", "amber"][i % 3],
                       "transform": [{"scale": [0.34, 0.07, 0.16]}, {"rotate": [0, 0, round(tilt, 2)]},
                                     {"translate": [round(radius, 4), round(0.9 - 0.055 * radius ** 2, 4), 0]},
                                     {"rotate": [0, round(i * golden % 360, 3), 0]}]})
    return {
        "version": 1,
        "camera": {"type": "perspective", "position": [0, 6.2, 7.2], "target": [0, 0, 0.2], "up": [0, 1, 0], "fov": 46},
        "image": {"width": 640, "height": 480},
        "render": {"integrator": "path", "samples": 64, "max_depth": 6},
        "materials": {"rose": {"type": "diffuse", "reflectance": [0.75, 0.2, 0.3]},
                      "coral": {"type": "diffuse", "reflectance": [0.85, 0.42, 0.3]},
                      "amber": {"type": "conductor", "reflectance": [0.9, 0.65, 0.3], "roughness": 0.35},
                      "ground": {"type": "diffuse", "reflectance": [0.28, 0.34, 0.3]}},
        "objects": {"ball": {"type": "sphere", "radius": 1}, "flower": {"type": "group", "of": petals}},
        "scene": [{"object": "flower"},
                  {"object": {"type": "rectangle", "size": [60, 60]}, "material": "ground",
                   "transform": [{"translate": [0, -0.6, 0]}]}],
        "lights": [{"type": "area", "object": {"type": "rectangle", "size": [3, 3]}, "radiance": [16, 15, 13],
                    "transform": [{"rotate": [180, 0, 0]}, {"translate": [-2, 8, 3]}]}],
        "background": [0.4, 0.5, 0.65],
    }


if __name__ == "__main__":
    write("sphereflake", sphereflake())
    write("menger", menger())
    write("ellipsoids", ellipsoids())
