"""Writes the sections of scenes/RESULTS.md: what the scenes' error costs, whether they know it, and what adaptive
sampling saves.

    python scenes/generators/results.py time|calibration|adaptive [SCENE...]

Each writes its own section and leaves the others as they are; some minutes each. Small images, so that anyone can do it
again: absolute times belong to the machine that is named, slopes, quotients and labels to the scenes.
"""

import re
import sys
from datetime import date
from pathlib import Path

import numpy as np

from tilecast.render.local import render
from tilecast.render.output import write_file
from tilecast.report import calibration
from tilecast.report.curve_table import short_time
from tilecast.report.curves import error_against_time
from tilecast.report.plot import plot
from tilecast.report.references import References
from tilecast.report.renders import SceneRenders, Taken
from tilecast.report.text import figure
from tilecast.scene.loading import load
from tilecast.scene.schema import Stop

FOLDER = Path(__file__).resolve().parent.parent
RESULTS = FOLDER / "RESULTS.md"
SCENES = {
    "time": ("cornell", "drilled-part-brass", "drilled-part-glass", "lens", "solids", "terrain", "whitted"),
    "calibration": ("cornell", "drilled-part-brass", "drilled-part-glass", "lens", "nested-glass", "whitted",
                    "many-lights", "menger", "csg-of-meshes", "materials", "solids", "environment"),
    "adaptive": ("cornell", "csg-of-meshes", "drilled-part-brass", "drilled-part-glass", "ellipsoids", "lens", "many-lights",
                 "menger", "nested-glass", "textured", "whitted")}
HEIGHT, CALIBRATED, ADAPTIVE = 96, 36, 240  # pixels; the width keeps the scene's shape
SAMPLES, SEEDS, RENDERS = 64, 4, 1000
TARGET, STOPS, MOST = 1e-3, 16, 1024  # a relative MSE, images that stop there, and the samples that they may take


def at_height(scene: Path, height: int, samples: int) -> list[str]:
    image = SceneRenders(scene, [], None).document.image
    return [f"image.height={height}", f"image.width={round(image.width * height / image.height)}",
            f"render.samples={samples}"]


# --- Error against time

TIME_HEADS = ("scene", "seconds to 1e-2", "to 1e-3", "slope", "efficiency", "heavy-tailed")


def time_section(names: tuple[str, ...]) -> str:
    rows, curves, machine = [], [], {}
    for name in names:
        scene = FOLDER / f"{name}.json"
        report = error_against_time(scene, settings=at_height(scene, HEIGHT, SAMPLES), seeds=SEEDS,
                                    on_step=lambda what, seconds: print(f"{name}: {what}: {seconds:.1f} s", flush=True))
        [curve], machine = report["curves"], report["machine"]
        slope = curve["slope"]["samples"]
        rows.append((link(name), *map(short_time, curve["time_to"].values()),
                     f"{slope['value']:.2f} ± {slope['standard_error']:.2f}",
                     figure(curve["points"][-1]["efficiency"]),
                     "yes: " + "; ".join(curve["heavy_tailed"]) if curve["heavy_tailed"] else "no"))
        curves.append({**curve, "label": f"scene={name}"})
    pictures = plot({"machine": machine, "curves": curves}, "Error against run time")
    write_file(FOLDER / "gallery" / "error-against-time.png", pictures["png"])
    return "\n".join([
        "![Relative MSE and MSE over seconds of rendering, one curve a scene](gallery/error-against-time.png)", "",
        f"Images of {HEIGHT} rows, 2 to {SAMPLES} samples a pixel, {SEEDS} seeds, against two independent references "
        f"of {8 * SAMPLES} samples; {machine['threads']} threads of {machine['processor']}. Times in seconds, to that "
        "relative MSE: `<` where the first checkpoint is below, `~` where it is extrapolated along the slope. The "
        "slope is that of the relative MSE over samples on logarithmic axes: -1 for independent ones. Efficiency is "
        f"1 / (MSE × seconds) at {SAMPLES} samples. The last column: whether the report calls the scene "
        "heavy-tailed, and why.", "", *table(TIME_HEADS, rows)])


# --- Calibration

CALIBRATION_HEADS = ("scene", "MSE: predicted/true", "coverage", "relative MSE: predicted/true", "coverage",
                     "say that they are heavy-tailed", "stop at 1e-3: samples", "true error/1e-3")


class Remembered:
    """Renders of a scene, whose images add up to two independent references."""

    def __init__(self, scene: Path):
        self.take = SceneRenders(scene, at_height(scene, CALIBRATED, SAMPLES), None)
        self._sums, self._counts = [0.0, 0.0], [0, 0]

    def __call__(self, seed: int, samples: int) -> Taken:
        taken = self.take(seed, samples)
        half = sum(self._counts) % 2
        self._sums[half] = self._sums[half] + taken.pixels.astype(np.float64)
        self._counts[half] += 1
        return taken

    def references(self) -> References:
        return References([total / count for total, count in zip(self._sums, self._counts)])


def calibration_section(names: tuple[str, ...]) -> str:
    rows = []
    for name in names:
        scene = FOLDER / f"{name}.json"
        renders = Remembered(scene)
        seeds = renders.take.seeds(RENDERS + STOPS)
        found = calibration.calibrate(renders, seeds[:RENDERS], SAMPLES)
        ends = [stopped(scene, CALIBRATED, seed, "uniform") for seed in seeds[RENDERS:]]
        true = [renders.references().error(image.pixels).relative_mse / TARGET for image in ends]
        samples = np.mean([image.stats["samples"] for image in ends])
        labelled = sum(image.error["heavy_tailed"] for image in ends)
        rows.append((link(name), *ratio_and_coverage(found["mse"]), *ratio_and_coverage(found["relative_mse"]),
                     f"{found['heavy_tailed']} of {RENDERS}",
                     f"{samples:.0f}" + (f" ({labelled} of {STOPS} heavy-tailed)" if labelled else ""),
                     f"{np.mean(true):.2f} ({min(true):.2f} to {max(true):.2f})"))
        print(*rows[-1], sep="  ", flush=True)
    return "\n".join([
        f"{RENDERS} renders of {CALIBRATED} rows with {SAMPLES} samples a pixel: what they predict over what is true, "
        "and how often their 95% interval holds the truth; in brackets: 95% confidence. All renders but one are the "
        f"reference of that one (`tilecast report SCENE --calibrate {RENDERS}` does the same with images of at most 96 "
        f"pixels a side). Then {STOPS} more with "
        f"`render.stop.relative_mse` = {TARGET:g} and at most {MOST} samples, which end by their own "
        f"estimate, at 16 samples or later: their samples, and their true error over {TARGET:g}, mean and "
        f"range. Measured on {date.today()}.", "", *table(CALIBRATION_HEADS, rows)])


def ratio_and_coverage(found: dict) -> tuple[str, str]:
    ratio, coverage = found["predicted_over_true"], found["coverage"]
    return (f"{ratio['mean']:.2f} ({ratio['low']:.2f} to {ratio['high']:.2f})",
            f"{coverage['mean']:.1%} ({coverage['low']:.0%} to {coverage['high']:.0%})")


def stopped(scene: Path, height: int, seed: int, how: str):
    """An image that ends by its error, `how`: "uniform" or "adaptive"."""
    settings = [*at_height(scene, height, MOST), f"render.seed={seed}",
                f"render.adaptive={'true' if how == 'adaptive' else 'false'}"]
    return render(load(scene, settings=settings), stop=Stop(relative_mse=TARGET))


# --- Adaptive sampling

ADAPTIVE_HEADS = ("scene", "samples: uniform", "adaptive", "quotient", "rays: quotient",
                  "seconds: uniform", "adaptive", "quotient", "estimated error/1e-3: uniform", "adaptive")


def adaptive_section(names: tuple[str, ...]) -> str:
    rows = []
    for name in names:
        images = [stopped(FOLDER / f"{name}.json", ADAPTIVE, 0, how) for how in ("uniform", "adaptive")]
        samples = [image.stats["samples"] for image in images]
        rays = [sum(image.stats["rays"].values()) for image in images]
        seconds = [image.stats["seconds"]["render"] for image in images]
        rows.append((link(name), *(f"{count:.0f}" for count in samples),
                     *(f"{values[1] / values[0]:.2f}" for values in (samples, rays)),
                     *(f"{value:.1f}" for value in seconds), f"{seconds[1] / seconds[0]:.2f}",
                     *(f"{image.error['relative_mse'] / TARGET:.2f}" for image in images)))
        print(*rows[-1], sep="  ", flush=True)
    return "\n".join([
        f"Images of {ADAPTIVE} rows that end at a relative MSE of {TARGET:g}, without and with "
        "`render.adaptive`: samples a pixel, seconds of rendering, and the quotients of both and of rays, which no other "
        f"program on the machine disturbs. One image each, by its own estimate. Measured on {date.today()}.", "",
        *table(ADAPTIVE_HEADS, rows)])


# --- The page

SECTIONS = {"time": ("Error against time", time_section),
            "calibration": ("Whether images know their error", calibration_section),
            "adaptive": ("Adaptive sampling", adaptive_section)}


def link(name: str) -> str:
    return f"[{name}]({name}.json)"


def table(heads: tuple[str, ...], rows: list[tuple[str, ...]]) -> list[str]:
    return [f"| {' | '.join(cells)} |" for cells in (heads, ["---"] * len(heads), *rows)]


def with_section(page: str, title: str, text: str) -> str:
    """The page with one section replaced: from its heading to the next, or to the end."""
    found = re.search(rf"^## {re.escape(title)}\n.*?(?=^## |\Z)", page, re.MULTILINE | re.DOTALL)
    if found is None:
        raise SystemExit(f"{RESULTS} has no section {title!r}")
    return page[:found.start()] + f"## {title}\n\n{text.rstrip()}\n\n" + page[found.end():]


def main(part: str, names: tuple[str, ...]) -> None:
    title, section = SECTIONS[part]
    text = section(names or SCENES[part])
    write_file(RESULTS, (with_section(RESULTS.read_text(), title, text).rstrip() + "\n").encode())


if __name__ == "__main__":
    if len(sys.argv) < 2 or sys.argv[1] not in SECTIONS:
        raise SystemExit(__doc__)
    main(sys.argv[1], tuple(sys.argv[2:]))
