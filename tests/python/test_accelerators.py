"""Every accelerator gives the same hits and the same pixels, bit for bit.

    ./dev test tests/python/test_accelerators.py --rays 10000000

shoots so many rays at each mesh and each example scene with each accelerator (and a hundredth of them at brute force).
"""

import hashlib
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import trimesh

import tilecast
from tilecast import _core
from tilecast.scene.compiler import Compiled

ROOT = Path(__file__).resolve().parents[2]
MODELS = ROOT.parent / "shared" / "models"
BATCH = 100_000

Triangles = tuple[np.ndarray, np.ndarray]


def soup(count: int) -> Triangles:
    """Random triangles all through each other."""
    random = np.random.default_rng(1)
    corners = random.uniform(-1, 1, (count, 1, 3)) + random.normal(0, 0.05, (count, 3, 3))
    return corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)


def needles(count: int) -> Triangles:
    """Long thin triangles in all directions."""
    random = np.random.default_rng(2)
    start = random.uniform(-1, 1, (count, 3))
    along, across = random.normal(size=(2, count, 3))
    corners = np.stack([start, start + 0.5 * along, start + 0.5 * along + 1e-3 * across], axis=1)
    return corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)


def lattice(count: int) -> Triangles:
    """Squares between the points of a lattice: all planes, edges and corners coincide with those of even cells."""
    side = round((count / 6) ** (1 / 3))
    random = np.random.default_rng(3)
    corners = []
    for axis in range(3):
        at = random.integers(0, side, (2 * side**2, 3)).astype(float)
        u, v = np.roll(np.eye(3), axis, axis=0)[:2]
        corners += [np.stack([at, at + u, at + u + v], axis=1), np.stack([at, at + u + v, at + v], axis=1)]
    found = np.concatenate(corners)
    return found.reshape(-1, 3), np.arange(3 * len(found)).reshape(-1, 3)


def model(path: Path) -> Triangles:
    mesh = trimesh.load(path, process=False)
    return np.asarray(mesh.vertices), np.asarray(mesh.faces)


def rays(vertices: np.ndarray, count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Half from afar, half from within; some along an axis, some through two vertices."""
    random = np.random.default_rng(seed)
    low, high = vertices.min(0), vertices.max(0)
    inside = random.uniform(low, high, (2, count, 3))
    outwards = random.normal(size=(count, 3))
    origins = np.where(np.arange(count)[:, None] % 2, inside[0], inside[0] + 3 * (high - low).max() * outwards)
    targets = inside[1]
    through = np.arange(count) % 5 == 0
    targets[through] = vertices[random.integers(0, len(vertices), through.sum())]
    directions = targets - origins
    axis = np.arange(count) % 11 == 0
    directions[axis] = np.eye(3)[random.integers(0, 3, axis.sum())] * random.choice([-1.0, 1.0], (axis.sum(), 1))
    corner = np.arange(count) % 22 == 0
    origins[corner] = vertices[random.integers(0, len(vertices), corner.sum())] - 2 * directions[corner]
    return origins, directions


SOURCES = {"soup": soup, "needles": needles, "lattice": lattice,
           **{path.stem: path for path in sorted(MODELS.glob("*.ply"))}}


def assert_same_hits(traced: Mapping[str, Compiled], points: np.ndarray, count: int) -> None:
    """What each kind of accelerator finds along `count` rays about these points."""

    def differences(kind: str) -> list[tuple[str, str]]:
        some = slice(None, None, 100) if kind == "none" else slice(None)
        hits = traced[kind].closest(origins[some], directions[some])
        return [(kind, field) for field in ("t", "object", "primitive", "u", "v")
                if not np.array_equal(getattr(hits, field), getattr(expected, field)[some])]

    with ThreadPoolExecutor() as pool:
        for batch, first in enumerate(range(0, count, BATCH)):
            origins, directions = rays(points, min(BATCH, count - first), batch)
            expected = traced["bvh"].closest(origins, directions)
            assert np.isfinite(expected.t).any()
            assert not sum(pool.map(differences, traced), [])


@pytest.mark.parametrize("name", SOURCES)
def test_every_accelerator_gives_the_same_hits_of_a_mesh(name, pytestconfig):
    count = pytestconfig.getoption("--rays")
    triangles = 100_000 if name == "soup" and count > 1_000_000 else 5_000
    source = SOURCES[name]
    vertices, faces = model(source) if isinstance(source, Path) else source(triangles)
    meshes = {kind: tilecast.mesh(vertices, faces, accelerator=kind) for kind in _core.ACCELERATORS}
    assert_same_hits(meshes, vertices, count)


def points_of(scene: Compiled) -> np.ndarray:
    """Where rays from within its bounds meet it, float64 [n, 3]."""
    random = np.random.default_rng(4)
    low, high = np.clip(scene.scene.bounds, -1e3, 1e3)
    origins, directions = random.uniform(low, high, (4000, 3)), random.normal(size=(4000, 3))
    t = scene.closest(origins, directions).t
    return (origins + t[:, None] * directions)[np.isfinite(t)]


@pytest.mark.parametrize("path", sorted((ROOT / "scenes").glob("*.json")), ids=lambda path: path.stem)
def test_every_accelerator_gives_the_same_hits_and_pixels_of_a_scene(path, pytestconfig):
    scenes = {kind: tilecast.load(path, settings=[f"render.accelerator={kind}", "image.width=32", "image.height=24"])
              for kind in ("auto", *_core.ACCELERATORS)}
    assert_same_hits(scenes, points_of(scenes["bvh"]), pytestconfig.getoption("--rays"))
    seen = {}
    for kind, scene in scenes.items():
        image = tilecast.render(scene, samples=1)
        seen.setdefault(hashlib.sha256(image.pixels.tobytes()).hexdigest(), []).append(kind)
    assert len(seen) == 1, seen
