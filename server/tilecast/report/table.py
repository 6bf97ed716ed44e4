"""A report as a table of plain text."""

from __future__ import annotations

from typing import Any

from .variation import label

_HEADS = ("build s", "nodes", "bytes", "cost", "steps/ray", "tests/ray", "render s", "ratio", "relative MSE", "pixels")


def table(report: dict[str, Any]) -> str:
    """A line for each value. Times are medians; cost is what a line through the scene is expected to cost, steps and
    tests are what a camera ray had on average; ratio is to the fastest; pixels are told by their hash."""
    rows = [(report["vary"], *_HEADS), *(_cells(row, report["rows"][0]) for row in report["rows"])]
    widths = [max(map(len, column)) for column in zip(*rows)]
    return "".join("  ".join([cells[0].ljust(widths[0]), *map(str.rjust, cells[1:], widths[1:])]).rstrip() + "\n"
                   for cells in rows)


def _cells(row: dict[str, Any], first: dict[str, Any]) -> tuple[str, ...]:
    accelerator, seconds, ray = row["accelerator"], row["seconds"], row["camera_ray"]
    return (label(row["value"]), f"{seconds['build']:.4f}", f"{accelerator['nodes']:,}", f"{accelerator['bytes']:,}",
            _known(accelerator.get("cost"), "{:.1f}"), f"{ray['steps']:.1f}", f"{ray['tests']:.1f}",
            f"{seconds['render']:.4f}", f"{row['ratio']:.2f}", _known(row["error"]["relative_mse"], "{:.3g}"),
            _pixels(row, first))


def _known(value: float | None, form: str) -> str:
    return "-" if value is None else form.format(value)


def _pixels(row: dict[str, Any], first: dict[str, Any]) -> str:
    if not row["repeatable"]:
        return "change"
    if row is first:
        return row["pixels_sha256"][:8]
    return "same" if row["identical"] else row["pixels_sha256"][:8]
