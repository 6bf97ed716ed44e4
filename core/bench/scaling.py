"""Cost against size: rays a second from 1e3 to 1e7 triangles and to 1e9 instanced ones, and two threads against one.

    .venv/bin/python core/bench/scaling.py [--runs 5] [--most 10000000] [--json FILE] [--plot core/bench/scaling.png]

Terrains of ever finer squares, seen alike; and copies of one of 100,000 triangles in rows and columns. Rays are those of
`Scene.closest` on numpy arrays: primary ones of a pinhole camera in rows, diffuse ones by the cosine from random ones of
their hits. Sizes take turns within a run, and medians over the runs are printed. Then the example scenes named in RENDERED
are rendered by one thread, by two, and by two processes of one thread at once, in turns: what these gain is what the
machine has to give.
"""

from __future__ import annotations

import argparse
import json
import statistics
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from functools import cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

import tilecast
from tilecast import _core

SCENES = Path(__file__).resolve().parents[2] / "scenes"
RENDERED = {"cornell": 64, "terrain": 4, "drilled-part-brass": 4, "materials": 4}  # samples a pixel
WIDTH, HEIGHT = 1024, 512  # of the camera's rays
COPIED = 100_000           # triangles


def terrain(triangles: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices [n, 3] and faces [m, 3] of a height field over [-1, 1]^2: seven octaves of value noise."""
    side = round((triangles / 2) ** 0.5)
    x, z = np.meshgrid(*[np.linspace(0.0, 1.0, side + 1)] * 2)
    height = np.zeros_like(x)
    for octave in range(7):
        lattice = np.random.default_rng(octave).random((5 << octave, 5 << octave))
        u, v = x * ((4 << octave) - 1e-9), z * ((4 << octave) - 1e-9)
        i, j = u.astype(int), v.astype(int)
        a, b = ((f := w - k) * f * (3 - 2 * f) for w, k in ((u, i), (v, j)))
        low, high = (lattice[j, i + k] * (1 - b) + lattice[j + 1, i + k] * b for k in (0, 1))
        height += 0.25 * (low * (1 - a) + high * a) / (1 << octave)
    vertices = np.stack([2 * x - 1, height, 2 * z - 1], axis=-1).reshape(-1, 3)
    p = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    q = p + side + 1
    return vertices, np.concatenate([np.stack(f, axis=-1) for f in ((p, q, p + 1), (p + 1, q, q + 1))])


def plain(triangles: int) -> tuple[_core.Scene, int]:
    vertices, faces = terrain(triangles)
    return tilecast.mesh(vertices, faces), len(faces)


def instanced(copies: int) -> tuple[_core.Scene, int]:
    """side x side copies of one terrain over [-1, 1]^2, in rows; and how many triangles that makes."""
    builder = _core.SceneBuilder()
    vertices, faces = terrain(COPIED)
    side = round(copies ** 0.5)
    grey = builder.material("diffuse")

    def repeat(handle: int, axis: int, scale: float) -> int:
        places = np.tile(np.diag([scale, scale, scale, 1.0]), (side, 1, 1))
        places[:, axis, 3] = (2 * np.arange(side) + 1) / side - 1
        return builder.group(np.full(side, handle, np.int32), places, np.full(side, grey, np.int32))

    row = repeat(builder.mesh(vertices, faces.astype(np.uint32)), 0, 1 / side)
    return builder.build(repeat(row, 2, 1.0)), side * side * len(faces)


def camera_rays() -> tuple[np.ndarray, np.ndarray]:
    eye = np.array([0.5, 1.2, 1.9])
    forward = -eye / np.linalg.norm(eye)
    right = np.cross(forward, [0, 1, 0])
    right /= np.linalg.norm(right)
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    across, up = 0.9 * (2 * (x + 0.5) / WIDTH - 1), 0.45 * (1 - 2 * (y + 0.5) / HEIGHT)
    ways = forward + across[..., None] * right + up[..., None] * np.cross(right, forward)
    return np.tile(eye, (WIDTH * HEIGHT, 1)), ways.reshape(-1, 3)


def diffuse_rays(scene: _core.Scene, origins: np.ndarray, ways: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    hits = scene.closest(origins, ways)
    random = np.random.default_rng(1)
    chosen = random.choice(np.flatnonzero(np.isfinite(hits.t)), len(ways))
    normals = np.asarray(hits.normal)[chosen]
    normals *= -np.sign(np.einsum("ij,ij->i", normals, ways[chosen]))[:, None]
    points = origins[chosen] + np.asarray(hits.t)[chosen, None] * ways[chosen] + 1e-6 * normals
    ball = random.normal(size=points.shape)
    return points, normals + ball / np.linalg.norm(ball, axis=1, keepdims=True)


def rate(scene: _core.Scene, rays: tuple[np.ndarray, np.ndarray], threads: int, pool: ThreadPoolExecutor) -> float:
    """Million rays a second; each thread has blocks of its own."""
    blocks = np.array_split(np.arange(len(rays[0])), 16)
    parts = [(rays[0][block[0]:block[-1] + 1], rays[1][block[0]:block[-1] + 1]) for block in blocks]
    start = time.perf_counter()
    if threads == 1:
        for part in parts:
            scene.closest(*part)
    else:
        list(pool.map(lambda part: scene.closest(*part), parts))
    return len(rays[0]) / (time.perf_counter() - start) * 1e-6


def rays_against_size(makers: list[tuple[str, Any]], runs: int) -> list[dict[str, Any]]:
    rows, origins = [], camera_rays()
    for kind, make in makers:
        scene, triangles = make()
        rows.append({"kind": kind, "triangles": triangles, "scene": scene,
                     "rays": {"primary": origins, "diffuse": diffuse_rays(scene, *origins)}})
        print(f"{kind} of {triangles:,} triangles is built", flush=True)
    seen: dict[tuple[int, str, int], list[float]] = {}
    with ThreadPoolExecutor(2) as pool:
        for _ in range(runs):
            for i, row in enumerate(rows):
                for name, rays in row["rays"].items():
                    for threads in (1, 2):
                        seen.setdefault((i, name, threads), []).append(rate(row["scene"], rays, threads, pool))
    return [{"kind": row["kind"], "triangles": row["triangles"], "rays": name,
             "one": statistics.median(seen[i, name, 1]),
             "speedup": statistics.median(b / a for a, b in zip(seen[i, name, 1], seen[i, name, 2]))}
            for i, row in enumerate(rows) for name in row["rays"]]


@cache
def example(name: str) -> Any:
    return tilecast.load(SCENES / f"{name}.json")


def seconds(name: str, samples: int, threads: int = 1) -> float:
    return tilecast.render(example(name), samples=samples, threads=threads).stats["seconds"]["render"]


def renders(runs: int) -> list[dict[str, Any]]:
    """Seconds of rendering of whole scenes; and how many times as many two threads, and two processes, render."""
    out = []
    with ProcessPoolExecutor(1, get_context("spawn")) as first, ProcessPoolExecutor(1, get_context("spawn")) as second:
        for name, samples in RENDERED.items():
            processes = first, second
            for process in processes:
                process.submit(seconds, name, 1).result()
            seen = []
            for _ in range(runs):
                one, two = (seconds(name, samples, threads) for threads in (1, 2))
                at_once = [process.submit(seconds, name, samples) for process in processes]
                seen.append((one, one / two, sum(one / each.result() for each in at_once)))
            one, threads, both = (statistics.median(column) for column in zip(*seen))
            out.append({"scene": name, "seconds": one, "threads": threads, "processes": both})
    return out


def draw(rows: list[dict[str, Any]], path: Path) -> None:
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(7, 4), layout="constrained")
    for kind, style in (("terrain", "-o"), ("copies", "--s")):
        for rays, colour in (("primary", "tab:blue"), ("diffuse", "tab:orange")):
            chosen = [row for row in rows if row["kind"] == kind and row["rays"] == rays]
            axes.plot([row["triangles"] for row in chosen], [row["one"] for row in chosen], style, color=colour,
                      label=f"{rays}, {'one mesh' if kind == 'terrain' else 'copies of 100,000'}")
    axes.set(xscale="log", yscale="log", xlabel="triangles", ylabel="million rays a second, one thread")
    axes.grid(True, which="both", alpha=0.3)
    axes.legend()
    figure.savefig(path, dpi=110)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--most", type=float, default=1e7, help="triangles of the largest terrain")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--plot", type=Path)
    options = parser.parse_args()
    sizes = [n for n in (1_000, 10_000, 100_000, 1_000_000, 10_000_000) if n <= options.most]
    makers = [("terrain", lambda n=n: plain(n)) for n in sizes]
    makers += [("copies", lambda k=k: instanced(k)) for k in (1, 9, 100, 1024, 10_000)]
    rows = rays_against_size(makers, options.runs)
    print(f"\n{'triangles':>15}  {'as':<8}{'rays':<9}{'M/s, one thread':>16}{'two threads':>13}")
    for row in rows:
        print(f"{row['triangles']:>15,}  {row['kind']:<8}{row['rays']:<9}{row['one']:>16.2f}{row['speedup']:>12.2f}x")
    rendered = renders(options.runs)
    print(f"\n{'scene':<20}{'seconds, one thread':>20}{'two threads':>13}{'two processes':>15}")
    for row in rendered:
        print(f"{row['scene']:<20}{row['seconds']:>20.2f}{row['threads']:>12.2f}x{row['processes']:>14.2f}x")
    if options.json:
        options.json.write_text(json.dumps({"rays": rows, "renders": rendered}, indent=2) + "\n")
    if options.plot:
        draw(rows, options.plot)


if __name__ == "__main__":
    main()
