"""Writes textured.json with its images: tiles.png, tiles-relief.png, globe.png, leaves.png and wood.png.

    PYTHONPATH=server python scenes/generators/textures.py
"""

import numpy as np
from writing import FOLDER, write

from tilecast import _images

RANDOM = np.random.default_rng(7)


def save(name: str, pixels: np.ndarray) -> None:
    """Values from 0 to 1, [h, w, channels], rounded to 8 bits."""
    bits = (np.clip(pixels, 0, 1) * 255 + 0.5).astype(np.uint8)
    plain = {"oiio:UnassociatedAlpha": "1"}  # colours are not multiplied by the alpha channel
    _images.write(str(FOLDER / name), bits, list("RGBA")[:bits.shape[2]], plain)


def noise(height: int, width: int, cells: tuple[int, int], octaves: int) -> np.ndarray:
    """Smooth noise from 0 to 1, [h, w], which repeats in both directions."""
    total, weight = np.zeros((height, width)), 0.0
    for octave in range(octaves):
        rows, columns = (n << octave for n in cells)
        values = RANDOM.random((rows, columns))
        y, x = np.arange(height) * rows / height, np.arange(width) * columns / width
        (y0, a), (x0, b) = ((np.floor(t).astype(int), t % 1) for t in (y, x))
        a, b = (t * t * (3 - 2 * t) for t in (a[:, None], b[None, :]))
        y0, x0 = y0 % rows, x0 % columns
        y1, x1 = (y0 + 1) % rows, (x0 + 1) % columns
        total += 0.5**octave * ((1 - a) * ((1 - b) * values[np.ix_(y0, x0)] + b * values[np.ix_(y0, x1)])
                                + a * ((1 - b) * values[np.ix_(y1, x0)] + b * values[np.ix_(y1, x1)]))
        weight += 0.5**octave
    return total / weight


def mixed(share: np.ndarray, first: list[float], second: list[float]) -> np.ndarray:
    return np.array(first) + share[..., None] * (np.array(second) - np.array(first))


def tiles(size: int = 192, across: int = 3) -> None:
    """Glazed tiles in grout: their colour; and their relief, with how rough they are as its alpha channel."""
    at = (np.arange(size) + 0.5) * across / size
    edge = np.minimum(at % 1, 1 - at % 1)  # distance from the nearest joint, in tiles
    near = np.minimum(edge[:, None], edge[None, :])
    tile = np.clip((near - 0.02) / 0.015, 0, 1)  # 0: grout
    tone = RANDOM.random((across, across))[np.ix_(at.astype(int), at.astype(int))]
    glaze = mixed(0.6 * tone + 0.4 * noise(size, size, (6, 6), 3), [0.10, 0.30, 0.42], [0.42, 0.66, 0.70])
    save("tiles.png", glaze * tile[..., None] + (1 - tile[..., None]) * 0.78)
    height = 0.055 * np.clip((near - 0.01) / 0.06, 0, 1) ** 0.5
    slope_x, slope_y = ((np.roll(height, -1, axis) - np.roll(height, 1, axis)) * size / across / 2 for axis in (1, 0))
    normal = np.dstack([-slope_x, slope_y, np.ones_like(height)])  # rows go down, v goes up
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    save("tiles-relief.png", np.dstack([0.5 + 0.5 * normal, 0.9 - 0.72 * tile]))


def globe(height: int = 128) -> None:
    """Land and sea, ice at the poles."""
    relief = noise(height, 2 * height, (4, 8), 5)
    latitude = np.abs(np.linspace(1, -1, height))[:, None]
    land, ice = np.clip((relief - 0.52) * 30, 0, 1), np.clip((latitude + 0.3 * relief - 1.0) * 25, 0, 1)
    ground = mixed(np.clip((relief - 0.52) * 6, 0, 1), [0.25, 0.48, 0.18], [0.66, 0.55, 0.34])
    colour = mixed(np.clip(relief * 1.6, 0, 1), [0.05, 0.14, 0.36], [0.16, 0.42, 0.66])
    colour = colour * (1 - land[..., None]) + ground * land[..., None]
    save("globe.png", colour * (1 - ice[..., None]) + 0.95 * ice[..., None])


def leaves(size: int = 160) -> None:
    """Leaves, between which nothing is: the alpha channel cuts them out."""
    at = (np.arange(size) + 0.5) / size
    x, y = np.meshgrid(at, 1 - at)
    colour, alpha = np.zeros((size, size, 3)) + np.array([0.2, 0.4, 0.1]), np.zeros((size, size))
    for row in range(5):
        for column in range(4):
            turn = RANDOM.uniform(0, np.pi)
            dx, dy = x - (column + 0.5 + 0.25 * (row % 2)) / 4.3, y - (row + 0.5) / 5
            along, across = dx * np.cos(turn) + dy * np.sin(turn), dy * np.cos(turn) - dx * np.sin(turn)
            t = along / 0.13
            inside = (np.abs(t) < 1) & (np.abs(across) < 0.05 * (1 - t * t))
            vein = np.abs(across) < 0.004
            green = np.array([0.22, 0.45, 0.12]) * RANDOM.uniform(0.7, 1.5) + (0.15 * vein)[..., None]
            colour, alpha = np.where(inside[..., None], green, colour), np.where(inside, 1.0, alpha)
    save("leaves.png", np.dstack([colour, alpha]))


def wood(size: int = 128) -> None:
    """Boards with their grain."""
    rings = noise(size, size, (2, 16), 4)
    grain = 0.5 + 0.5 * np.sin(40 * rings + 6 * noise(size, size, (4, 4), 2))
    boards = (np.arange(size) % (size // 4) > 1).astype(float)[None, :, None]
    save("wood.png", mixed(grain, [0.45, 0.29, 0.16], [0.68, 0.48, 0.29]) * (0.35 + 0.65 * boards))


def textured() -> dict:
    def image(file: str, **keys) -> dict:
        return {"type": "image", "file": file, **keys}

    floor = {"tiling": [4, 4]}
    return {
        "version": 1,
        "camera": {"type": "perspective", "position": [0.5, 2.0, 6.4], "target": [0, 0.72, 0], "up": [0, 1, 0], "fov": 33},
        "image": {"width": 640, "height": 360, "filter": "gaussian"},
        "render": {"integrator": "path", "samples": 64, "max_depth": 6},
        "materials": {
            "tiles": {"type": "plastic", "reflectance": image("tiles.png", **floor),
                      "roughness": image("tiles-relief.png", channel="a", **floor),
                      "normal_map": image("tiles-relief.png", **floor)},
            "globe": {"type": "plastic", "reflectance": image("globe.png"), "roughness": 0.25},
            "wood": {"type": "diffuse", "reflectance": image("wood.png")},
            "leaves": {"type": "diffuse", "reflectance": image("leaves.png", wrap="clamp"),
                       "opacity": image("leaves.png", wrap="clamp")},
            "worn": {"type": "conductor", "reflectance": [1.0, 0.78, 0.34],
                     "roughness": {"type": "gradient", "start": 0.05, "end": 0.7, "along": "v", "range": [0.25, 0.75]}},
            "stripes": {"type": "plastic", "roughness": 0.1, "reflectance": {
                "type": "checker", "even": [0.75, 0.1, 0.08], "odd": [0.85, 0.82, 0.76], "size": 0.0625, "space": "uv"}},
        },
        "scene": [
            {"object": {"type": "rectangle", "size": [12, 12]}, "material": "tiles"},
            {"object": {"type": "sphere", "radius": 0.8}, "material": "globe",
             "transform": [{"rotate": [0, 0, -23]}, {"translate": [-0.15, 0.8, 0.1]}]},
            {"object": {"type": "sphere", "radius": 0.45}, "material": "worn",
             "transform": [{"rotate": [0, 0, 30]}, {"translate": [1.15, 0.45, 1.1]}]},
            {"object": {"type": "box", "min": [-0.6, -0.6, -0.6], "max": [0.6, 0.6, 0.6], "radius": 0.03},
             "material": "wood", "transform": [{"rotate": [0, 28, 0]}, {"translate": [1.75, 0.6, -0.7]}]},
            {"object": {"type": "torus", "radius": 0.36, "minor_radius": 0.14}, "material": "stripes",
             "transform": [{"translate": [0.1, 0.14, 1.75]}]},
            {"object": {"type": "rectangle", "size": [1.9, 1.9]}, "material": "leaves",
             "transform": [{"rotate": [90, 0, 0]}, {"rotate": [0, 24, 0]}, {"translate": [-1.75, 0.97, 0.2]}]},
        ],
        "background": image("studio.exr", rotation=20),
    }


if __name__ == "__main__":
    tiles(), globe(), leaves(), wood()
    write("textured", textured())
