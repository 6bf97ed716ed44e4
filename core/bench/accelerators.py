"""What `auto` chooses against the best accelerator of each example scene, and a box minus 10,000 balls against one minus 100.

    .venv/bin/python core/bench/accelerators.py [--runs 7] [--height 120] [--json FILE] [SCENE...]

One sample a pixel of the whole image, by one thread and in its own time (`time.thread_time`), the accelerators taking turns;
medians. One that takes 8 times as long as `auto` at first takes no further turns. The boxes are drawn at 640 x 480 by Whitted's
integrator with shadows, and by path tracing; their balls take away as much however many they are, or, of the same size as the
hundred, whatever they do not share.
"""

from __future__ import annotations

import argparse
import json
import random
import statistics
import tempfile
import time
from pathlib import Path

import tilecast
from tilecast import _core
from tilecast.scene.compiler import Compiled

SCENES = Path(__file__).resolve().parents[2] / "scenes"
SLOW = 8  # times `auto`: not worth further turns


def seconds(compiled: Compiled, sample: int) -> float:
    scene = compiled.scene
    start = time.thread_time()
    scene.render_chunk(0, 0, scene.width, scene.height, sample, 1)
    return time.thread_time() - start


def medians(scenes: dict[str, Compiled], runs: int, base: str) -> dict[str, float]:
    """Seconds of each, by name; `base` decides which are too slow to go on."""
    first = {name: seconds(scene, 0) for name, scene in scenes.items()}  # and warms up
    taken = {name: [] for name in scenes if first[name] < SLOW * first[base]}
    for run in range(runs):
        for name, times in taken.items():
            times.append(seconds(scenes[name], run))
    return first | {name: statistics.median(times) for name, times in taken.items()}


def choice(path: Path, height: int, runs: int) -> dict:
    image = json.loads(path.read_text())["image"]
    size = [f"image.height={height}", f"image.width={round(image['width'] * height / image['height'])}"]
    scenes = {kind: tilecast.load(path, settings=[*size, f"render.accelerator={kind}"])
              for kind in ("auto", *_core.ACCELERATORS)}
    found = medians(scenes, runs, "auto")
    best = min(_core.ACCELERATORS, key=found.__getitem__)
    return {"scene": path.stem, "best": best, "auto_over_best": found["auto"] / found[best], "seconds": found}


def drilled(balls: int, smaller: bool, integrator: str, folder: Path) -> Compiled:
    """A box minus so many balls; `smaller`: the more the smaller."""
    numbers = random.Random(7)
    shrunk = (100 / balls) ** (1 / 3) if smaller else 1.0
    operands = [{"type": "sphere", "radius": shrunk * numbers.uniform(0.08, 0.23),
                 "transform": [{"translate": [numbers.uniform(-1, 1) for _ in range(3)]}]} for _ in range(balls)]
    scene = {
        "version": 1, "image": {"width": 640, "height": 480}, "render": {"integrator": integrator, "samples": 1},
        "camera": {"type": "perspective", "position": [2.4, 1.8, 3.2], "target": [0, 0, 0], "up": [0, 1, 0], "fov": 36},
        "materials": {"paint": {"type": "diffuse", "reflectance": [0.8, 0.7, 0.5]}},
        "objects": {"part": {"type": "difference", "of": [{"type": "box", "min": [-1, -1, -1], "max": [1, 1, 1]},
                                                          *operands]}},
        "scene": [{"object": "part", "material": "paint"}],
        "lights": [{"type": "point", "position": [4, 7, 6], "intensity": [300, 300, 300]}],
        "background": [0.1, 0.12, 0.16]}
    path = folder / "drilled.json"
    path.write_text(json.dumps(scene))
    return tilecast.load(path)


def many_operands(runs: int) -> list[dict]:
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for integrator in ("whitted", "path"):
            scenes = {name: drilled(balls, smaller, integrator, Path(folder)) for name, balls, smaller in
                      (("few", 100, False), ("many small", 10_000, True), ("many", 10_000, False))}
            found = medians(scenes, runs, "few")
            rows.append({"integrator": integrator, "seconds": found,
                         "many_small_over_few": found["many small"] / found["few"],
                         "many_over_few": found["many"] / found["few"]})
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="of the example scenes; all of them by default")
    parser.add_argument("--runs", type=int, default=7)
    parser.add_argument("--height", type=int, default=120, help="of the images, pixels")
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    arguments = parser.parse_args()
    print("a box minus 10,000 balls over one minus 100, in seconds")
    operands = many_operands(arguments.runs)
    for row in operands:
        print(f"  {row['integrator']:10}{row['many_small_over_few']:7.2f} (as much taken away)"
              f"{row['many_over_few']:7.2f} (balls of the same size)", flush=True)
    print(f"{'scene':22}{'auto / best':>12}  best")
    rows = []
    for name in arguments.scenes or sorted(path.stem for path in SCENES.glob("*.json")):
        rows.append(row := choice(SCENES / f"{name}.json", arguments.height, arguments.runs))
        print(f"{row['scene']:22}{row['auto_over_best']:12.2f}  {row['best']}", flush=True)
    print(f"{'the farthest off':22}{max(row['auto_over_best'] for row in rows):12.2f}")
    if arguments.json:
        arguments.json.write_text(json.dumps({"choices": rows, "operands": operands}, indent=2) + "\n")


if __name__ == "__main__":
    main()
