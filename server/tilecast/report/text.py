"""Figures and columns of plain text."""

from __future__ import annotations

from collections.abc import Sequence


def aligned(rows: Sequence[Sequence[str]]) -> str:
    """Rows of cells as lines: the first column to the left, the others to the right, two spaces between."""
    widths = [max(map(len, column)) for column in zip(*rows)]
    return "".join("  ".join([cells[0].ljust(widths[0]), *map(str.rjust, cells[1:], widths[1:])]).rstrip() + "\n"
                   for cells in rows)


def figure(value: float | None) -> str:
    """Three significant digits; a dash for what is not known."""
    return "-" if value is None else f"{value:.3g}"
