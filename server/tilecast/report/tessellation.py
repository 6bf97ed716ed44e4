"""What it costs to put triangles for a sphere: the error of inscribed meshes against the exact solid.

A unit icosahedron is subdivided at the middles of its edges, its new vertices moved out onto the sphere. Measured by
rays: along radii, how far the mesh lies below the sphere; along parallels near the rim, what part of the sphere's
silhouette the mesh misses. On paper: the mesh lies deepest at the centre of the circle around its largest triangle, by
the sagitta 1 - d with d the distance of that triangle's plane from the centre. Both fall as 1 / triangles.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..scene.loading import load, mesh
from .text import aligned, figure

LEVELS = 8  # 20 to 327,680 triangles
_RAYS = 500  # squared: of each kind
_VIEW = np.array([0.36, 0.48, 0.8])  # along no symmetry of the icosahedron; of length 1


def icosphere(level: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices float64 [10 * 4^level + 2, 3] on the unit sphere and faces [20 * 4^level, 3], counter-clockwise from
    outside."""
    golden = (1 + 5**0.5) / 2
    vertices = np.array([(-1, golden, 0), (1, golden, 0), (-1, -golden, 0), (1, -golden, 0),
                         (0, -1, golden), (0, 1, golden), (0, -1, -golden), (0, 1, -golden),
                         (golden, 0, -1), (golden, 0, 1), (-golden, 0, -1), (-golden, 0, 1)])
    vertices /= np.linalg.norm(vertices[0])
    faces = np.array([(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2),
                      (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5),
                      (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)])
    for _ in range(level):
        edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        edges, numbers = np.unique(edges, axis=0, return_inverse=True)
        middles = vertices[edges].sum(axis=1)
        middles /= np.linalg.norm(middles, axis=1, keepdims=True)
        a, b, c = faces.T
        ab, bc, ca = (len(vertices) + numbers.reshape(-1, 3)).T
        vertices = np.vstack([vertices, middles])
        faces = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=1).reshape(-1, 3)
    return vertices, faces


def sagitta(vertices: np.ndarray, faces: np.ndarray) -> float:
    """How far the deepest point of an inscribed mesh lies below the unit sphere, on paper."""
    a, b, c = vertices[faces].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    return float(1 - (np.abs((normal * a).sum(axis=1)) / np.linalg.norm(normal, axis=1)).min())


def tessellation(levels: int = LEVELS) -> dict[str, Any]:
    """As plain JSON values: rows {triangles, deepest, sagitta, rms: of the depth below the sphere, in radii;
    silhouette: the part of it that is missed; seconds: for all rays; bytes}, sphere {seconds} for the exact solid, and
    slopes of deepest and silhouette over triangles on logarithmic axes."""
    grid = (np.arange(_RAYS) + 0.5) / _RAYS
    u, v = (part.ravel() for part in np.meshgrid(grid, grid))
    outward = _directions(u, v)
    sphere = load({"camera": {"position": [0, 0, 5], "target": [0, 0, 0]}, "scene": [
        {"object": {"type": "sphere", "radius": 1}}]})
    depths, _, seconds = _traced(sphere, outward, _parallels(u, v, 0.0))
    rows = []
    for level in range(levels):
        vertices, faces = icosphere(level)
        scene = mesh(vertices, faces)
        depth = sagitta(vertices, faces)
        found, met, took = _traced(scene, outward, _parallels(u, v, 1 - depth))
        gap = depths - found
        ring = 1 - (1 - depth) ** 2  # of the disk's area: within it the mesh misses nothing
        rows.append({"triangles": len(faces), "deepest": float(gap.max()), "sagitta": depth,
                     "rms": float(np.sqrt((gap * gap).mean())), "silhouette": float(ring * (1 - met.mean())),
                     "seconds": took, "bytes": scene.accelerator["bytes"]})
    return {"rays": 2 * _RAYS**2, "sphere": {"seconds": seconds}, "rows": rows,
            "slope": {key: _slope(rows, key) for key in ("deepest", "silhouette")}}


def _slope(rows: Sequence[dict[str, Any]], key: str) -> float | None:
    """Over triangles."""
    points = [(row["triangles"], row[key]) for row in rows if row[key] > 0]
    return float(np.polyfit(*np.log(np.array(points)).T, 1)[0]) if len(points) > 1 else None


def _directions(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Unit vectors, even over the sphere; float64 [n, 3]."""
    z = 2 * u - 1
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(2 * np.pi * v), r * np.sin(2 * np.pi * v), z], axis=1)


def _parallels(u: np.ndarray, v: np.ndarray, inner: float) -> np.ndarray:
    """Where parallel rays start, outside of the sphere, even over the ring from `inner` to its rim; float64 [n, 3]."""
    across = np.cross(_VIEW, [0.0, 1.0, 0.0])
    across /= np.linalg.norm(across)
    r = np.sqrt(inner**2 + (1 - inner**2) * u)
    x, y = r * np.cos(2 * np.pi * v), r * np.sin(2 * np.pi * v)
    return np.outer(x, across) + np.outer(y, np.cross(across, _VIEW)) - 2 * _VIEW


def _traced(scene: Any, outward: np.ndarray, parallels: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Distances along the radii, which parallels meet anything, and seconds."""
    start = time.perf_counter()
    depths = scene.closest(np.zeros_like(outward), outward).t
    met = scene.occluded(parallels, np.broadcast_to(_VIEW, parallels.shape))
    return np.asarray(depths), np.asarray(met), time.perf_counter() - start


def tessellation_table(report: dict[str, Any]) -> str:
    """A line for each mesh, the exact sphere last."""
    rows = [("triangles", "deepest", "sagitta", "rms", "silhouette missed", "bytes", "seconds")]
    rows += [(f"{row['triangles']:,}", figure(row["deepest"]), figure(row["sagitta"]), figure(row["rms"]),
              f"{row['silhouette']:.2e}", f"{row['bytes']:,}", figure(row["seconds"])) for row in report["rows"]]
    rows.append(("sphere", "0", "0", "0", "0", "-", figure(report["sphere"]["seconds"])))
    slope = report["slope"]
    return (f"A unit sphere of triangles against the exact one, {report['rays']:,} rays each; depths in radii\n\n"
            + aligned(rows) + f"slope over triangles: deepest {figure(slope['deepest'])}, silhouette "
                              f"{figure(slope['silhouette'])} (-1 on paper)\n")
