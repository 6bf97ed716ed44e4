"""A report as a table of plain text."""

from __future__ import annotations

from typing import Any

from .text import aligned, figure
from .variation import label

_HEADS = ("build s", "nodes", "bytes", "cost", "steps/ray", "tests/ray", "render s", "ratio", "relative MSE", "pixels")


def table(report: dict[str, Any]) -> str:
    """A line for each value. Times are medians; cost is what a line through the scene is expected to cost, steps and
    tests are what a camera ray had on average; ratio is to the fastest; pixels are told by their hash."""
    return aligned([(report["vary"], *_HEADS), *(_cells(row, report["rows"][0]) for row in report["rows"])])


def _cells(row: dict[str, Any], first: dict[str, Any]) -> tuple[str, ...]:
    accelerator, seconds, ray = row["accelerator"], row["seconds"], row["camera_ray"]
    return (label(row["value"]), f"{seconds['build']:.4f}", f"{accelerator['nodes']:,}", f"{accelerator['bytes']:,}",
            _cost(accelerator.get("cost")), f"{ray['steps']:.1f}", f"{ray['tests']:.1f}",
            f"{seconds['render']:.4f}", f"{row['ratio']:.2f}", figure(row["error"]["relative_mse"]),
            _pixels(row, first))


def _cost(value: float | None) -> str:
    return "-" if value is None else f"{value:.1f}"


def _pixels(row: dict[str, Any], first: dict[str, Any]) -> str:
    if not row["repeatable"]:
        return "change"
    if row is first:
        return row["pixels_sha256"][:8]
    return "same" if row["identical"] else row["pixels_sha256"][:8]
