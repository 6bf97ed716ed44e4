"""Error against run time as a table of plain text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .text import aligned, figure

_HEADS = ("samples", "seconds", "CPU s", "MSE", "", "relative MSE", "", "predicted/true", "", "covered", "efficiency")


def curve_table(report: dict[str, Any]) -> str:
    """Each curve: a line for each checkpoint and what follows from them. Of several, a line for each at the end."""
    threads, curves = report["machine"]["threads"], report["curves"]
    blocks = [_curve(curve, threads) for curve in curves]
    if len(curves) > 1:
        blocks.append(_side_by_side(curves))
    return "\n".join(blocks)


def _curve(curve: dict[str, Any], threads: int) -> str:
    seconds, seeds = curve["seconds"], len(curve["seeds"])
    title = [curve["label"]] if curve["label"] else []
    title += [f"{curve['width']} x {curve['height']} pixels", f"{seeds} seeds",
              f"{threads} thread{'s' if threads > 1 else ''}",
              f"load {figure(seconds['load'])} s", f"compile {figure(seconds['compile'])} s"]
    lines = [", ".join(title), _references(curve["references"], curve["points"]), "",
             aligned([_HEADS, *(_cells(point) for point in curve["points"])]), *_findings(curve)]
    return "\n".join(lines) + "\n"


def _references(references: dict[str, Any], points: Sequence[dict[str, Any]]) -> str:
    if "files" in references:
        text = "references: " + " and ".join(references["files"])
    else:
        text = f"references: two independent renders of {references['samples']} samples a pixel"
    if "relative_mse" in references:
        text += f"; relative MSE of their mean {figure(references['relative_mse'])}, which biases no MSE below"
        best = min(point["relative_mse"]["mean"] for point in points)
        if references["relative_mse"] > best:
            return text + ", but the relative ones: it is no better than the images; give references more samples"
        return text + f", and the relative ones by some {references['relative_bias']:.1%} at most"
    return f"{text}; a single one, so that its own error is part of every figure below"


def _cells(point: dict[str, Any]) -> Sequence[str]:
    ratio = point["predicted_over_true"]
    return (f"{point['samples']:g}", figure(point["seconds"]), figure(point["cpu_seconds"]),
            *_with_band(point["mse"]), *_with_band(point["relative_mse"]), *(_with_band(ratio) if ratio else ("-", "")),
            f"{point['covered']} of {len(point['runs'])}", figure(point["efficiency"]))


def _with_band(band: dict[str, float]) -> tuple[str, str]:
    """A figure, and how far its interval goes up and down on a logarithmic axis."""
    if band["mean"] <= 0 or band["high"] == band["low"]:
        return figure(band["mean"]), ""
    return figure(band["mean"]), f"+-{band['high'] / band['mean'] - 1:.1%}"


def _findings(curve: dict[str, Any]) -> list[str]:
    slope, times = curve["slope"], curve["time_to"]
    lines = []
    if slope["seconds"]:
        lines.append("slope of the relative MSE: " + ", ".join(
            f"{found['value']:.3f} +- {found['standard_error']:.3f} against {key}"
            for key, found in slope.items() if found) + " (-1 for independent samples)")
    lines += [f"relative MSE {level}: {_time(found)}" for level, found in times.items()]
    lines.append("heavy-tailed: " + "; ".join(curve["heavy_tailed"]) if curve["heavy_tailed"]
                 else "not heavy-tailed: the images' own estimates can be trusted")
    return lines


def _time(found: dict[str, Any] | None) -> str:
    """Of `estimates.time_to`, in words."""
    if found is None:
        return "out of reach"
    return {"measured": "after {} s", "within": "within {} s, the first checkpoint",
            "extrapolated": "after {} s, extrapolated along the slope"}[found["how"]].format(figure(found["seconds"]))


def _side_by_side(curves: Sequence[dict[str, Any]]) -> str:
    levels = list(curves[0]["time_to"])
    heads = ("", "samples", "seconds", "relative MSE", "", "slope", *(f"s to {level}" for level in levels),
             "efficiency", "tails")
    rows = []
    for curve in curves:
        last, slope = curve["points"][-1], curve["slope"]["seconds"]
        rows.append((curve["label"], f"{last['samples']:g}", figure(last["seconds"]),
                     *_with_band(last["relative_mse"]), f"{slope['value']:.3f}" if slope else "-",
                     *(short_time(curve["time_to"][level]) for level in levels), figure(last["efficiency"]),
                     "heavy" if curve["heavy_tailed"] else "-"))
    return aligned([heads, *rows])


def short_time(found: dict[str, Any] | None) -> str:
    """Of `estimates.time_to`, for a column: < where the first checkpoint is below, ~ where it is extrapolated."""
    if found is None:
        return "-"
    return {"measured": "", "within": "<", "extrapolated": "~"}[found["how"]] + figure(found["seconds"])
