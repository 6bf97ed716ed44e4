"""What features cost scenes that do not use them: instructions a sample of the core, and of the core built without one.

    .venv/bin/python core/bench/feature_cost.py [--only lens csg+mesh] [--json FILE]

For each feature that can be left out (core/base/built.h) the core is built without it in build/without/FEATURE, and for
each of SCENES once without all that it does not use; ccache, where there is one, makes that cheap the second time.
Callgrind counts the instructions of `render_chunk`, on up to three of SCENES that do not use the feature. Other work on
the machine does not matter. Features joined by + are left out together. Needs valgrind.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCENES = {  # name: file, settings
    "cornell": ("cornell", []),
    "whitted": ("whitted", []),
    "terrain": ("terrain", []),
    "environment": ("environment", []),
    "drilled-part-glass": ("drilled-part-glass", []),
    "cornell-whitted": ("cornell", ['render.integrator="whitted"']),
    "unlit": ("whitted", ["lights=[]"]),  # but for its background
}
WIDTH, HEIGHT, SAMPLES = 64, 48, 4
MODULE = "tilecast._core"


def optional_features() -> list[str]:
    """All that can be left out, as the core's header lists it."""
    text = (ROOT / "core/base/built.h").read_text()
    return re.findall(r'"(\w+)"', text[text.index("kCanBeLeftOut"):text.index("};", text.index("kCanBeLeftOut"))])


def build(name: str, left_out: list[str]) -> Path:
    """The module of a core without these features."""
    import pybind11
    folder = ROOT / "build/without" / name
    cached = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
    # Callgrind finds functions by symbols, and the compiler's cache the files that do not ask what is left out.
    subprocess.run(["cmake", "-S", ROOT, "-B", folder, "-G", "Ninja", f"-DTILECAST_WITHOUT={';'.join(left_out)}",
                    "-DCMAKE_STRIP=", "-DCMAKE_UNITY_BUILD=OFF", f"-DPython_EXECUTABLE={sys.executable}",
                    f"-Dpybind11_DIR={pybind11.get_cmake_dir()}", *cached], check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", folder, "--target", "_core"], check=True, stdout=subprocess.DEVNULL)
    return next(folder.glob("_core*.so"))


def load(module: Path, scenes: list[str]) -> list:
    """Compiled by this module instead of the installed one."""
    spec = importlib.util.spec_from_file_location(MODULE, module)
    sys.modules[MODULE] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sys.modules[MODULE])
    import tilecast
    files = [SCENES[name] for name in scenes]
    size = [f"image.width={WIDTH}", f"image.height={HEIGHT}"]
    return [tilecast.load(ROOT / f"scenes/{file}.json", settings=size + settings).scene for file, settings in files]


def control(*command: str) -> None:
    """Of the callgrind that this process runs under."""
    subprocess.run(["callgrind_control", *command, str(os.getpid())], check=True, stdout=subprocess.DEVNULL)


def render(module: Path, scenes: list[str]) -> None:
    """What is counted, in a process of its own; of each scene a sample before, for what is read and made once."""
    loaded = load(module, scenes)
    for scene in loaded:
        scene.render_chunk(0, 0, WIDTH, HEIGHT, 0, 1)
    control("--instr=on")
    for scene in loaded:
        scene.render_chunk(0, 0, WIDTH, HEIGHT, 1, SAMPLES)
        control("--dump")


def count(module: Path, scenes: list[str]) -> dict[str, float]:
    """Instructions a sample of each scene."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(["valgrind", "--tool=callgrind", "--instr-atstart=no", "--toggle-collect=tilecast::render_chunk*",
                        f"--callgrind-out-file={folder}/out", sys.executable, __file__, "--render", module, *scenes],
                       check=True, stderr=subprocess.DEVNULL)
        totals = [int(re.search(r"^totals: (\d+)", Path(folder, f"out.{i + 1}").read_text(), re.M)[1])
                  for i in range(len(scenes))]
    return {name: total / (WIDTH * HEIGHT * SAMPLES) for name, total in zip(scenes, totals)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", metavar="FEATURE", help="these alone")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--render", nargs="+", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.render:
        return render(options.render[0], options.render[1:])

    features = optional_features()
    whole = build("nothing", [])
    used = {name: set(scene.features) for name, scene in zip(SCENES, load(whole, list(SCENES)))}
    all_unused = {f"all-that-{name}-does-not-use": name for name in SCENES}

    def plan(name: str) -> tuple[list[str], list[str]]:
        """What is left out, and the scenes to count."""
        if name in all_unused:
            return [feature for feature in features if feature not in used[all_unused[name]]], [all_unused[name]]
        left_out = name.split("+")
        return left_out, [scene for scene in SCENES if used[scene].isdisjoint(left_out)][:3]

    plans = {name: plan(name) for name in options.only or [*features, *all_unused]}
    modules = {name: build(name, left_out) for name, (left_out, _) in plans.items()}
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        full = pool.submit(count, whole, list(SCENES))
        counts = {name: pool.submit(count, modules[name], scenes) for name, (_, scenes) in plans.items() if scenes}
    rows = [{"without": name, "scene": scene, "full": full.result()[scene], "left": left}
            for name, counted in counts.items() for scene, left in counted.result().items()]
    print(f"{'without':<38}{'scene':<20}{'instructions a sample':>22}{'without':>10}{'cost':>9}")
    for row in rows:
        print(f"{row['without']:<38}{row['scene']:<20}{row['full']:>22,.0f}{row['left']:>10,.0f}"
              f"{100 * (row['full'] / row['left'] - 1):>8.2f}%")
    if options.json:
        options.json.write_text(json.dumps(rows, indent=2) + "\n")


if __name__ == "__main__":
    main()
