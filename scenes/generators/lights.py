"""Writes the scenes that are about light: environment.json with its image studio.exr, and many-lights.json.

    PYTHONPATH=server python scenes/generators/lights.py
"""

import colorsys
import math
import random

import numpy as np
from writing import FOLDER, write

from tilecast import _images

STUDIO = 192, 96  # pixels


def studio() -> np.ndarray:
    """A photographer's studio, float32 [h, w, 3]: grey walls, a floor, two softboxes, a window, a small hard lamp."""
    width, height = STUDIO
    azimuth = ((np.arange(width) + 0.5) / width - 0.5) * 360  # degrees to the right of -z
    elevation = 90 - (np.arange(height) + 0.5) / height * 180
    image = np.zeros((height, width, 3), np.float32)
    up = np.sin(np.radians(elevation))[:, None, None]
    image[:] = np.where(up < 0, np.array([0.1, 0.085, 0.07]), 0.14 + 0.08 * up * np.array([0.9, 1, 1.15]))

    def lamp(at: float, high: float, across: float, tall: float, colour: list[float]) -> None:
        aside = np.abs((azimuth - at + 180) % 360 - 180) < across / 2
        image[np.ix_(np.abs(elevation - high) < tall / 2, aside)] = colour

    lamp(-100, 38, 46, 40, [6.5, 6.2, 5.8])
    lamp(75, 30, 26, 54, [1.6, 2.0, 2.7])
    for pane in (-9, 9):
        lamp(165 + pane, 26, 15, 26, [3.2, 3.4, 3.6])
    lamp(20, 58, 3.8, 3.8, [420, 330, 210])
    return image


def environment() -> dict:
    balls = {"chrome": (-1.65, 0.75), "gold": (0.0, 0.75), "clay": (1.65, 0.75)}
    return {
        "version": 1,
        "camera": {"type": "thin-lens", "position": [0.6, 1.7, 6.2], "target": [0, 0.62, 0], "up": [0, 1, 0], "fov": 33,
                   "aperture": 0.05, "focus_distance": 5.6},
        "image": {"width": 640, "height": 360, "filter": "gaussian"},
        "render": {"integrator": "path", "samples": 64, "max_depth": 6},
        "materials": {
            "chrome": {"type": "conductor", "reflectance": [0.9, 0.91, 0.92]},
            "gold": {"type": "conductor", "reflectance": [1.0, 0.78, 0.34], "roughness": 0.35},
            "clay": {"type": "diffuse", "reflectance": [0.62, 0.28, 0.2]},
            "glass": {"type": "dielectric", "ior": 1.5},
            "table": {"type": "diffuse", "reflectance": {"type": "checker", "even": [0.42, 0.42, 0.42],
                                                         "odd": [0.3, 0.3, 0.3], "size": 0.5}}},
        "scene": [
            *({"object": {"type": "sphere", "radius": radius}, "material": name,
               "transform": [{"translate": [x, radius, 0]}]} for name, (x, radius) in balls.items()),
            {"object": {"type": "sphere", "radius": 0.3}, "material": "glass", "transform": [{"translate": [0.75, 0.3, 1.2]}]},
            {"object": {"type": "cylinder", "radius": 3.4, "height": 0.2}, "material": "table",
             "transform": [{"translate": [0, -0.1, 0]}]}],
        "background": {"type": "image", "file": "studio.exr", "rotation": 20},
    }


def many_lights(count: int = 1000) -> dict:
    """Lamps strewn along a spiral on the ground, among standing stones."""
    rng = random.Random(7)
    lights, stones = [], []
    for index in range(count):
        turn = index * math.pi * (3 - math.sqrt(5))
        radius = 0.32 * math.sqrt(index + 0.5) + 0.5
        x, z = radius * math.cos(turn), radius * math.sin(turn)
        colour = colorsys.hsv_to_rgb((0.08 + 0.55 * rng.random() ** 2) % 1, 0.75, 1)
        bright = 2 ** rng.uniform(3, 6)
        lights.append({"type": "area", "object": "lamp", "radiance": [round(bright * c, 2) for c in colour],
                       "transform": [{"translate": [round(x, 3), round(rng.uniform(0.08, 0.3), 3), round(z, 3)]}]})
    for index in range(40):
        turn, radius = index * 0.9 + rng.uniform(-0.2, 0.2), 1.2 + 0.21 * index
        stones.append({"object": "stone", "material": "stone", "transform": [
            {"scale": [1, round(rng.uniform(0.5, 1.6), 2), 1]}, {"rotate": [0, round(rng.uniform(0, 90)), 0]},
            {"translate": [round(radius * math.cos(turn), 2), 0, round(radius * math.sin(turn), 2)]}]})
    return {
        "version": 1,
        "camera": {"type": "perspective", "position": [0, 5.2, 11.5], "target": [0, 0, 0.6], "up": [0, 1, 0], "fov": 50},
        "image": {"width": 640, "height": 360, "filter": "gaussian"},
        "render": {"integrator": "path", "samples": 64, "max_depth": 4},
        "materials": {"stone": {"type": "diffuse", "reflectance": [0.6, 0.58, 0.55]},
                      "ground": {"type": "diffuse", "reflectance": [0.35, 0.36, 0.33]}},
        "objects": {"lamp": {"type": "sphere", "radius": 0.03},
                    "stone": {"type": "box", "min": [-0.18, 0, -0.12], "max": [0.18, 1, 0.12], "radius": 0.05}},
        "scene": [{"object": {"type": "rectangle", "size": [60, 60]}, "material": "ground"}, *stones],
        "lights": lights,
        "background": [0.004, 0.006, 0.012],
    }


if __name__ == "__main__":
    _images.write(str(FOLDER / "studio.exr"), studio(), ["R", "G", "B"])
    write("environment", environment())
    write("many-lights", many_lights())
