"""Error against run time as a picture, PNG and SVG, by matplotlib. Only this module needs it."""

from __future__ import annotations

import importlib.util
import io
import math
from collections.abc import Sequence
from typing import Any

FORMATS = ("png", "svg")

# Okabe and Ito's colours, told apart by the colour-blind; without the yellow, which is lost on white.
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000")
_QUIET = "#8a8a8a"
_PANELS = (("relative_mse", "relative MSE"), ("mse", "MSE"))


def missing() -> str | None:
    """What to install where there is no matplotlib; None where there is."""
    if importlib.util.find_spec("matplotlib") is not None:
        return None
    return ("the plot needs matplotlib: install it with pip install 'tilecast[report]', or leave --output away for the "
            "table alone")


def plot(report: dict[str, Any], title: str) -> dict[str, bytes]:
    """The curves of a report (see `curves.error_against_time`), as files by their format. Each point is the mean over
    the seeds with its 95% band; dashed is what the images say of themselves."""
    from matplotlib.figure import Figure

    curves = report["curves"]
    figure = Figure(figsize=(11, 4.9), layout="constrained")
    figure.suptitle(title, fontsize=12)
    for axes, (key, name) in zip(figure.subplots(1, 2), _PANELS):
        drawn = [(curve, colour, points) for curve, colour in zip(curves, _cycle(len(curves)))
                 if (points := [point for point in curve["points"] if point[key]["mean"] > 0 < point["seconds"]])]
        for curve, colour, points in drawn:
            _draw(axes, points, key, colour, curve["label"].partition("=")[2])
            if len(curves) == 1 and key == _PANELS[0][0]:  # samples are said once
                _number(axes, points, colour)
        threads = report["machine"]["threads"]
        axes.set_xlabel(f"seconds of rendering, {threads} thread{'s' if threads > 1 else ''}")
        axes.set_title(name, fontsize=11)
        if not drawn:
            axes.text(0.5, 0.5, "no error at any checkpoint", transform=axes.transAxes, ha="center", color=_QUIET)
            axes.set_xticks([]), axes.set_yticks([])
            continue
        _scale(axes, [points for _, _, points in drawn], key)
        if len(curves) > 1 and key == _PANELS[0][0]:
            axes.legend(loc="upper right", fontsize=9, frameon=False, labelcolor="linecolor")
    _legend(figure, curves)
    return {kind: _saved(figure, kind) for kind in FORMATS}


def plot_tessellation(report: dict[str, Any]) -> dict[str, bytes]:
    """The errors of a sphere of triangles (see `tessellation.tessellation`) over their number."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.2, 4.6), layout="constrained")
    axes = figure.subplots()
    rows = report["rows"]
    for (key, name), colour in zip((("deepest", "deepest point"), ("rms", "depth, rms"),
                                    ("silhouette", "part of the silhouette missed")), _COLOURS):
        points = [(row["triangles"], row[key]) for row in rows if row[key] > 0]
        axes.plot(*zip(*points), color=colour, marker="o", markersize=3.5, linewidth=1.6, label=name)
    axes.plot([row["triangles"] for row in rows], [row["sagitta"] for row in rows], color="black", linewidth=0.8,
              linestyle=(0, (4, 3)), label="sagitta: the deepest on paper")
    axes.set(xscale="log", yscale="log", xlabel="triangles", ylabel="radii; silhouette: part of its area",
             title="A sphere of triangles against the exact one")
    axes.grid(alpha=0.3, linewidth=0.5)
    axes.legend(fontsize=9, frameon=False)
    return {kind: _saved(figure, kind) for kind in FORMATS}


def _cycle(count: int) -> Sequence[str]:
    return [_COLOURS[at % len(_COLOURS)] for at in range(count)]


def _draw(axes: Any, points: Sequence[dict[str, Any]], key: str, colour: str, label: str) -> None:
    seconds = [point["seconds"] for point in points]
    means = [point[key]["mean"] for point in points]
    axes.fill_between(seconds, [point[key]["low"] for point in points], [point[key]["high"] for point in points],
                      color=colour, alpha=0.22, linewidth=0)
    axes.plot(seconds, means, color=colour, linewidth=1.6, marker="o", markersize=3.5, label=label)
    estimated = [(point["seconds"], point["estimated"][key]) for point in points if point["estimated"][key] > 0]
    if estimated:
        axes.plot(*zip(*estimated), color=colour, linewidth=1.1, linestyle=(0, (4, 3)))


def _number(axes: Any, points: Sequence[dict[str, Any]], colour: str) -> None:
    """Writes the samples beside the points of the first panel."""
    for point in points:
        axes.annotate(f"{point['samples']:g}", (point["seconds"], point[_PANELS[0][0]]["mean"]), xytext=(4, 4),
                      textcoords="offset points", fontsize=8, color=colour)


def _scale(axes: Any, curves: Sequence[Sequence[dict[str, Any]]], key: str) -> None:
    """Logarithmic axes around the curves, with lines of slope -1 behind them, half a decade apart."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    seconds = [point["seconds"] for points in curves for point in points]
    errors = [value for points in curves for point in points
              for value in (point[key]["mean"], point[key]["low"], point[key]["high"], point["estimated"][key])
              if value > 0]
    left, right = min(seconds) / 1.5, max(seconds) * 2.2
    # An interval that says nothing must not flatten all others.
    low = max(min(errors) / 1.6, min(point[key]["mean"] for points in curves for point in points) / 30)
    high = min(max(errors) * 1.6, max(point[key]["mean"] for points in curves for point in points) * 30)
    axes.set(xscale="log", yscale="log", xlim=(left, right), ylim=(low, high))
    for half in range(math.floor(2 * math.log10(left * low)), math.ceil(2 * math.log10(right * high)) + 1):
        product = 10.0 ** (half / 2)  # of error and seconds
        axes.plot([left, right], [product / left, product / right], color=_QUIET, linewidth=0.5, alpha=0.5, zorder=0,
                  scalex=False, scaley=False)
    for axis, first, last in ((axes.xaxis, left, right), (axes.yaxis, low, high)):
        decades = math.log10(last / first)
        axis.set_major_locator(LogLocator(subs=(1, 2, 5) if decades < 2.5 else (1,), numticks=20))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())
    axes.tick_params(which="both", labelsize=9)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def _legend(figure: Any, curves: Sequence[dict[str, Any]]) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    colour = _COLOURS[0] if len(curves) == 1 else "#404040"
    seeds = len(curves[0]["seeds"])
    true = f"true error, mean of {seeds} seeds" + ("; numbers: samples a pixel" if len(curves) == 1 else "")
    dashed = (0, (4, 3))
    handles = [Line2D([], [], color=colour, marker="o", markersize=3.5, label=true),
               Patch(color=colour, alpha=0.22, linewidth=0, label="95% band"),
               Line2D([], [], color=colour, linewidth=1.1, linestyle=dashed, label="estimated by the image itself"),
               Line2D([], [], color=_QUIET, linewidth=0.5, label="slope -1")]
    figure.legend(handles=handles, loc="outside lower center", ncols=4, fontsize=9, frameon=False)


def _saved(figure: Any, kind: str) -> bytes:
    import matplotlib

    out = io.BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "tilecast", "svg.fonttype": "path"}):
        figure.savefig(out, format=kind, dpi=150, facecolor="white",
                       metadata={"Date": None} if kind == "svg" else {"Software": "tilecast"})
    return out.getvalue()
