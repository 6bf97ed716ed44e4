"""Writes scenes/RESULTS.md and its plot: what the example scenes' error costs, and whether they know it.

    python scenes/generators/results.py [SCENE...]

Some minutes. Small images, so that anyone can do it again: absolute times belong to the machine that is named, slopes,
quotients and labels to the scenes.
"""

import sys
from pathlib import Path

from tilecast.render.output import write_file
from tilecast.report import calibration
from tilecast.report.curve_table import short_time
from tilecast.report.curves import error_against_time
from tilecast.report.plot import plot
from tilecast.report.renders import SceneRenders
from tilecast.report.text import figure

FOLDER = Path(__file__).resolve().parent.parent
SCENES = ("cornell", "drilled-part-brass", "drilled-part-glass", "lens", "solids", "terrain", "whitted")
HEIGHT, CALIBRATED = 96, 48  # pixels; the width keeps the scene's shape
SAMPLES, SEEDS, RENDERS = 64, 4, 100

HEADS = ("scene", "seconds to 1e-2", "to 1e-3", "slope", "efficiency", "predicted/true", "coverage", "heavy-tailed")


def at_height(scene: Path, height: int) -> list[str]:
    image = SceneRenders(scene, [], None).document.image
    return [f"image.height={height}", f"image.width={round(image.width * height / image.height)}",
            f"render.samples={SAMPLES}"]


def measure(name: str) -> tuple[dict, dict]:
    """The report of one scene, and its calibration."""
    scene = FOLDER / f"{name}.json"
    report = error_against_time(scene, settings=at_height(scene, HEIGHT), seeds=SEEDS,
                                on_step=lambda what, seconds: print(f"{name}: {what}: {seconds:.1f} s", flush=True))
    take = SceneRenders(scene, at_height(scene, CALIBRATED), None)
    return report, calibration.calibrate(take, take.seeds(RENDERS), SAMPLES)


def row(name: str, report: dict, calibrated: dict) -> tuple[str, ...]:
    [curve] = report["curves"]
    slope, found = curve["slope"]["samples"], calibrated["relative_mse"]
    ratio, coverage = found["predicted_over_true"], found["coverage"]
    return (f"[{name}]({name}.json)", *map(short_time, curve["time_to"].values()),
            f"{slope['value']:.2f} ± {slope['standard_error']:.2f}", figure(curve["points"][-1]["efficiency"]),
            f"{ratio['mean']:.2f} ({ratio['low']:.2f} to {ratio['high']:.2f})",
            f"{coverage['mean']:.0%} ({coverage['low']:.0%} to {coverage['high']:.0%})",
            "yes: " + "; ".join(curve["heavy_tailed"]) if curve["heavy_tailed"] else "no")


def page(rows: list[tuple[str, ...]], machine: dict) -> str:
    lines = [f"| {' | '.join(cells)} |" for cells in (HEADS, ["---"] * len(HEADS), *rows)]
    return "\n".join([
        "# Error against run time: the example scenes", "",
        "![Relative MSE and MSE over seconds of rendering, one curve a scene](gallery/error-against-time.png)", "",
        f"Images of {HEIGHT} rows, 2 to {SAMPLES} samples a pixel, {SEEDS} seeds, against two independent references "
        f"of {8 * SAMPLES} samples; {machine['threads']} threads of {machine['processor']}. Times in seconds, to that "
        "relative MSE: `<` where the first checkpoint is below, `~` where it is extrapolated along the slope. The "
        "slope is that of the relative MSE over samples on logarithmic axes: -1 for independent ones. Efficiency is "
        f"1 / (MSE × seconds) at {SAMPLES} samples. The last three columns ask whether images know their own error: "
        f"{RENDERS} renders of {CALIBRATED} rows with {SAMPLES} samples, what they predict over what is true, and how "
        "often their 95% interval holds the truth (in brackets: 95% confidence); and whether the report calls the "
        "scene heavy-tailed, and why.", "",
        *lines, "",
        "Written by `scenes/generators/results.py`. For any scene: `tilecast report SCENE -o FOLDER`, and "
        "`tilecast report SCENE --calibrate 200`.", ""])


def main(names: tuple[str, ...]) -> None:
    rows, curves, machine = [], [], {}
    for name in names:
        report, calibrated = measure(name)
        machine = report["machine"]
        rows.append(row(name, report, calibrated))
        curves.append({**report["curves"][0], "label": f"scene={name}"})
        print(*rows[-1], sep="  ", flush=True)
    write_file(FOLDER / "RESULTS.md", page(rows, machine).encode())
    pictures = plot({"machine": machine, "curves": curves}, "Error against run time")
    write_file(FOLDER / "gallery" / "error-against-time.png", pictures["png"])


if __name__ == "__main__":
    main(tuple(sys.argv[1:]) or SCENES)
