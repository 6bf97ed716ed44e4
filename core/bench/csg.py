"""CSG against POV-Ray: the same scenes, one thread, taking turns; prints rays and seconds of both.

    .venv/bin/python core/bench/csg.py [--runs 7] [--json out/csg.json] [--keep out/csg]

Seconds are those of tracing alone: POV-Ray's "Trace Time", and `seconds.render` of tilecast.render, which is what
`tilecast render` calls. Neither holds parsing or building. Both take one ray a pixel (POV-Ray through its middle,
tilecast anywhere in it), follow 10 levels, drop branches below 1e-5 and shoot a shadow ray from every diffuse point that
faces the light.

Rays: POV-Ray's "Rays" (camera, reflected, refracted) + "Shadow Ray Tests"; tilecast's camera + bounce + shadow. Shadow
rays through glass and branches that are cut off as too faint are not counted alike, so beside the ratio of rays a second
stands that of plain seconds for the same picture.
"""

from __future__ import annotations

import argparse
import json
import math
import random
import re
import shutil
import statistics
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import tilecast
from tilecast import _images
from tilecast.render.output import srgb, to_png, write_file

WIDTH, HEIGHT = 640, 480
BACKGROUND = (0.1, 0.12, 0.16)
LIGHT = (400.0, 700.0, 600.0)  # metres; so far that its falloff over the scene is below a percent: POV-Ray has none
DEPTH, FAINTEST = 10, 1e-5


@dataclass
class Case:
    name: str
    position: tuple[float, float, float]  # of the camera, which looks at the origin
    fov: float                            # degrees, across the height
    objects: dict                         # tilecast's, by name
    scene: list
    materials: dict
    povray: str


def drilled_part() -> tuple[dict, str]:
    """(box intersected with a sphere) minus a cylinder along each axis."""
    turned = {"y": [], "x": [{"rotate": [0, 0, 90]}], "z": [{"rotate": [90, 0, 0]}]}
    part = {"type": "difference", "of": [
        {"type": "intersection", "of": [{"type": "box", "min": [-1, -1, -1], "max": [1, 1, 1]},
                                        {"type": "sphere", "radius": 1.35}]},
        *({"type": "cylinder", "radius": 0.6, "height": 4, "transform": steps} for steps in turned.values())]}
    povray = "difference { intersection { box { -1, 1 } sphere { 0, 1.35 } }" + "".join(
        f" cylinder {{ -2*{axis}, 2*{axis}, 0.6 }}" for axis in turned) + " }"
    return part, povray


def copies() -> Case:
    part, povray = drilled_part()
    places = [[2.5 * (i - 4) for i in (x, y, z)] for x in range(9) for y in range(9) for z in range(9)]
    return Case("729 copies of a drilled part", (21.0, 17.0, 27.0), 40.0, {"part": part},
                [{"object": "part", "material": "paint", "transform": [{"translate": place}]} for place in places],
                {"paint": {"type": "diffuse", "reflectance": [0.8, 0.7, 0.5]}},
                f"#declare Part = {povray}\n" + "\n".join(
                    f"object {{ Part translate {vector(place)} {PAINT} }}" for place in places))


def bitten_box() -> Case:
    numbers = random.Random(1)
    balls = [([numbers.uniform(-1, 1) for _ in range(3)], numbers.uniform(0.08, 0.23)) for _ in range(200)]
    return Case("box minus 200 spheres", (2.4, 1.8, 3.2), 36.0,
                {"part": {"type": "difference", "of": [
                    {"type": "box", "min": [-1, -1, -1], "max": [1, 1, 1]},
                    *({"type": "sphere", "radius": radius, "transform": [{"translate": centre}]}
                      for centre, radius in balls)]}},
                [{"object": "part", "material": "paint"}],
                {"paint": {"type": "diffuse", "reflectance": [0.8, 0.7, 0.5]}},
                "difference { box { -1, 1 }\n" + "\n".join(
                    f"sphere {{ {vector(centre)}, {radius!r} }}" for centre, radius in balls) + f"\n{PAINT} }}")


def glass() -> Case:
    part, povray = drilled_part()
    # POV-Ray's checker is a pattern of unit cubes: scaled and moved off the plane, so that no face lies on their walls.
    return Case("glass part over a plane", (2.6, 2.1, 3.7), 36.0, {"part": part},
                [{"object": "part", "material": "glass", "transform": [{"rotate": [0, 20, 0]}]},
                 {"object": {"type": "rectangle", "size": [60, 60]}, "material": "tiles",
                  "transform": [{"translate": [0, -1.001, 0]}]}],
                {"glass": {"type": "dielectric", "ior": 1.5},
                 "tiles": {"type": "diffuse", "reflectance": {"type": "checker", "even": [0.8, 0.8, 0.76],
                                                              "odd": [0.16, 0.2, 0.26], "size": 0.8}}},
                f"object {{ {povray} rotate 20*y pigment {{ rgbf 1 }} interior {{ ior 1.5 }}\n"
                "  finish { ambient 0 diffuse 0 conserve_energy reflection { 0, 1 fresnel on } } }\n"
                "polygon { 5, <-30, -1.001, -30>, <30, -1.001, -30>, <30, -1.001, 30>, <-30, -1.001, 30>,\n"
                "  <-30, -1.001, -30> pigment { checker rgb <0.8, 0.8, 0.76> rgb <0.16, 0.2, 0.26>\n"
                "  scale 0.8 translate (0.1 - 1.001)*y } finish { ambient 0 diffuse 1 } }")


PAINT = "pigment { rgb <0.8, 0.7, 0.5> } finish { ambient 0 diffuse 1 }"


def vector(v) -> str:
    return "<" + ", ".join(repr(float(x)) for x in v) + ">"


def tilecast_scene(case: Case) -> dict:
    distance2 = sum(x * x for x in LIGHT)
    return {"version": 1,
            "camera": {"type": "perspective", "position": case.position, "target": [0, 0, 0], "up": [0, 1, 0],
                       "fov": case.fov},
            "image": {"width": WIDTH, "height": HEIGHT},
            "render": {"integrator": "whitted", "samples": 1, "max_depth": DEPTH},
            "materials": case.materials, "objects": case.objects, "scene": case.scene,
            # A white surface that faces it gives back 1, as in POV-Ray.
            "lights": [{"type": "point", "position": LIGHT, "intensity": [math.pi * distance2] * 3}],
            "background": BACKGROUND}


def povray_scene(case: Case) -> str:
    half_height = math.tan(math.radians(case.fov / 2))
    across = 2 * math.degrees(math.atan(half_height * WIDTH / HEIGHT))
    return (f"#version 3.7;\nglobal_settings {{ assumed_gamma 1 max_trace_level {DEPTH} adc_bailout {FAINTEST!r} }}\n"
            f"camera {{ location {vector(case.position)} up y right -x*{WIDTH}/{HEIGHT} angle {across!r} look_at 0 }}\n"
            f"light_source {{ {vector(LIGHT)} rgb 1 }}\nbackground {{ rgb {vector(BACKGROUND)} }}\n{case.povray}\n")


def run_povray(source: Path, image: Path) -> tuple[int, float]:
    """(rays, seconds)"""
    command = ["povray", f"+I{source}", f"+O{image}", f"+W{WIDTH}", f"+H{HEIGHT}", "-A", "+WT1", "-D", "+FN"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"povray failed on {source}:\n{done.stderr[-2000:]}")

    def number(pattern: str) -> float:
        found = re.search(pattern, done.stderr)
        return float(found[1]) if found else 0.0

    rays = number(r"Rays:\s+(\d+)") + number(r"Shadow Ray Tests:\s+(\d+)")
    return int(rays), number(r"Trace Time:.*\(([\d.]+) seconds\)")


def run_tilecast(scene) -> tuple[int, float, np.ndarray]:
    """(rays, seconds, linear pixels)"""
    image = tilecast.render(scene, samples=1, threads=1)
    return sum(image.stats["rays"].values()), image.stats["seconds"]["render"], image.pixels


def measure(case: Case, runs: int, folder: Path) -> dict:
    stem = folder / case.name.replace(" ", "-")
    source, picture = stem.with_suffix(".pov"), stem.with_name(stem.name + "-povray.png")
    source.write_text(povray_scene(case))
    document = stem.with_suffix(".json")
    document.write_text(json.dumps(tilecast_scene(case)))
    scene = tilecast.load(document)
    have_povray = shutil.which("povray") is not None
    ours, theirs = [], []
    for _ in range(runs):
        if have_povray:
            theirs.append(run_povray(source, picture))
        ours.append(run_tilecast(scene))
    encoded = srgb(ours[0][2])
    write_file(stem.with_name(stem.name + "-tilecast.png"), to_png(ours[0][2]))

    row = {"scene": case.name, "runs": runs, "tilecast": summary(ours)}
    if have_povray:
        row["povray"] = summary(theirs)
        row["rays_ratio"] = row["tilecast"]["rays_per_second"] / row["povray"]["rays_per_second"]
        row["seconds_ratio"] = row["povray"]["seconds"] / row["tilecast"]["seconds"]
        row["mean_difference"] = float(np.abs(encoded / 255.0 - _images.read(str(picture))[0]).mean())
    return row


def summary(results: list[tuple]) -> dict:
    seconds = statistics.median(result[1] for result in results)
    return {"rays": results[0][0], "seconds": seconds, "rays_per_second": results[0][0] / seconds}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=7, help="of each renderer and scene; the median counts")
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    parser.add_argument("--keep", type=Path, help="leave scenes and pictures in this folder")
    arguments = parser.parse_args()
    if not shutil.which("povray"):
        print("povray is not installed (Debian: apt install povray): no ratios")
    rows = []
    print(f"{'scene':30}{'renderer':10}{'rays':>11}{'seconds':>9}{'M rays/s':>10}"
          f"{'rays/s':>9}{'seconds':>9}{'differ':>8}")
    with tempfile.TemporaryDirectory() as scratch:
        folder = arguments.keep or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        for case in (copies(), bitten_box(), glass()):
            row = measure(case, arguments.runs, folder)
            rows.append(row)
            for renderer in ("povray", "tilecast"):
                if renderer not in row:
                    continue
                one = row[renderer]
                line = (f"{case.name:30}{renderer:10}{one['rays']:11}{one['seconds']:9.3f}"
                        f"{one['rays_per_second'] / 1e6:10.2f}")
                if renderer == "tilecast" and "povray" in row:
                    line += f"{row['rays_ratio']:8.2f}x{row['seconds_ratio']:8.2f}x{row['mean_difference']:8.4f}"
                print(line, flush=True)
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=2) + "\n")


if __name__ == "__main__":
    main()
