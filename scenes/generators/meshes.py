"""Writes the scenes that carry their own meshes: terrain.json and csg-of-meshes.json.

    python scenes/generators/meshes.py [terrain cells along a side]
"""

import sys

import numpy as np

from writing import write


def terrain_mesh(cells: int, seed: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """A square of ridges from -1 to 1 in x and z: vertices [(n + 1)^2, 3] and faces [2 n^2, 3], facing up.

    Ridged noise (Musgrave, "Texturing and Modeling", chapter 16) over random gradients.
    """
    x, z = np.meshgrid(np.linspace(-1, 1, cells + 1), np.linspace(-1, 1, cells + 1))
    generator = np.random.default_rng(seed)
    height, weight = np.zeros_like(x), np.ones_like(x)
    for octave in range(6):
        frequency = 2.0 ** octave
        ridge = (1 - np.abs(_gradient_noise(x * frequency + 7, z * frequency + 3, generator))) ** 2
        height += ridge * weight * 0.55 / frequency ** 0.95
        weight = np.clip(ridge * 1.6, 0, 1)
    height *= 0.42
    vertices = np.stack([x, height - height.min(), z], axis=-1).reshape(-1, 3)
    index = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    faces = np.concatenate([np.stack([a, d, c], -1).reshape(-1, 3), np.stack([a, c, b], -1).reshape(-1, 3)])
    return vertices, faces


def _gradient_noise(x: np.ndarray, y: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Perlin's gradient noise, about -1 to 1."""
    angles = generator.uniform(0, 2 * np.pi, (256, 256))
    i, j = np.floor(x).astype(int), np.floor(y).astype(int)
    u, v = x - i, y - j

    def corner(di: int, dj: int) -> np.ndarray:
        angle = angles[(i + di) % 256, (j + dj) % 256]
        return np.cos(angle) * (u - di) + np.sin(angle) * (v - dj)

    s, t = (w ** 3 * (w * (w * 6 - 15) + 10) for w in (u, v))
    low = corner(0, 0) * (1 - s) + corner(1, 0) * s
    high = corner(0, 1) * (1 - s) + corner(1, 1) * s
    return 1.4 * (low * (1 - t) + high * t)


def torus_mesh(major: float, minor: float, n: int, k: int) -> tuple[np.ndarray, np.ndarray]:
    """A closed torus about y: vertices [n k, 3], faces [2 n k, 3]."""
    a, b = np.meshgrid(2 * np.pi * np.arange(n) / n, 2 * np.pi * np.arange(k) / k, indexing="ij")
    r = major + minor * np.cos(b)
    vertices = np.stack([r * np.cos(a), minor * np.sin(b), r * np.sin(a)], -1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(n), np.arange(k), indexing="ij")
    at = lambda di, dj: (((i + di) % n) * k + (j + dj) % k).reshape(-1)
    faces = np.concatenate([np.stack([at(0, 0), at(0, 1), at(1, 1)], -1), np.stack([at(0, 0), at(1, 1), at(1, 0)], -1)])
    return vertices, faces


def star_mesh(points: int, outer: float, inner: float, height: float) -> tuple[np.ndarray, np.ndarray]:
    """A closed prism over a star about y."""
    n = 2 * points
    angle = 2 * np.pi * np.arange(n) / n
    radius = np.where(np.arange(n) % 2 == 0, outer, inner)
    ring = np.stack([radius * np.cos(angle), np.zeros(n), radius * np.sin(angle)], -1)
    up = np.array([0, height / 2, 0])
    vertices = np.concatenate([ring - up, ring + up, [-up, up]])
    faces = []
    for i in range(n):
        j = (i + 1) % n
        faces += [[i, j, 2 * n], [n + j, n + i, 2 * n + 1], [i, n + i, j], [j, n + i, n + j]]
    return vertices, np.array(faces)


def inline(vertices: np.ndarray, faces: np.ndarray) -> dict:
    return {"type": "mesh", "vertices": np.round(vertices, 4).tolist(), "faces": faces.tolist()}


def terrain(cells: int) -> dict:
    return {
        "version": 1,
        "camera": {"type": "perspective", "position": [0.15, 0.62, 0.98], "target": [0.05, 0.1, -0.3], "up": [0, 1, 0], "fov": 46},
        "image": {"width": 640, "height": 480},
        "render": {"integrator": "path", "samples": 64, "max_depth": 5},
        "materials": {"rock": {"type": "diffuse", "reflectance": [0.55, 0.47, 0.38]},
                      "lake": {"type": "mirror", "reflectance": [0.35, 0.5, 0.55]}},
        "objects": {"ground": inline(*terrain_mesh(cells))},
        "scene": [{"object": "ground", "material": "rock"},
                  {"object": {"type": "rectangle", "size": [2, 2]}, "material": "lake",
                   "transform": [{"translate": [0, 0.13, 0]}]}],
        "lights": [{"type": "area", "object": {"type": "rectangle", "size": [2, 2]}, "radiance": [150, 128, 96],
                    "transform": [{"rotate": [180, 0, 0]}, {"rotate": [0, 0, 60]}, {"translate": [-9, 6, -3]}]}],
        "background": [0.35, 0.5, 0.75],
    }


def csg_of_meshes() -> dict:
    return {
        "version": 1,
        "camera": {"type": "perspective", "position": [2.2, 3.0, 3.6], "target": [0, -0.05, 0], "up": [0, 1, 0], "fov": 38},
        "image": {"width": 640, "height": 480},
        "render": {"integrator": "path", "samples": 128, "max_depth": 8},
        "materials": {"copper": {"type": "conductor", "reflectance": [0.93, 0.58, 0.44], "roughness": 0.3},
                      "enamel": {"type": "diffuse", "reflectance": [0.12, 0.32, 0.45]},
                      "floor": {"type": "diffuse", "reflectance": [0.5, 0.5, 0.48]}},
        "objects": {
            "ring": inline(*torus_mesh(1.1, 0.42, 48, 24)),
            "star": inline(*star_mesh(9, 1.95, 1.3, 0.34)),
            "wheel": {"type": "difference", "of": [
                {"type": "union", "of": [{"object": "ring", "material": "copper"}, {"object": "star", "material": "enamel"}]},
                {"object": "ring", "transform": [{"scale": 0.55}, {"translate": [0, 0.3, 0]}], "material": "copper"},
                {"type": "cylinder", "radius": 0.3, "height": 3, "material": "copper"},
                {"type": "box", "min": [-2, -0.7, -0.12], "max": [2, -0.2, 0.12]}]}},
        "scene": [{"object": "wheel", "transform": [{"rotate": [0, 12, 0]}]},
                  {"object": {"type": "rectangle", "size": [40, 40]}, "material": "floor",
                   "transform": [{"translate": [0, -0.45, 0]}]}],
        "lights": [{"type": "area", "object": {"type": "rectangle", "size": [3, 3]}, "radiance": [14, 13.5, 13],
                    "transform": [{"rotate": [180, 0, 0]}, {"rotate": [0, 0, -30]}, {"translate": [4, 6, 2]}]}],
        "background": [0.35, 0.38, 0.42],
    }


if __name__ == "__main__":
    write("terrain", terrain(int(sys.argv[1]) if len(sys.argv) > 1 else 80))
    write("csg-of-meshes", csg_of_meshes())
