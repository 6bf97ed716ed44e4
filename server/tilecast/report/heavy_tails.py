"""Where an image cannot know its own error: the report's label, from errors that references tell and from what the
images say themselves (`render.tails`).

A few samples that are rare and very bright carry most of the error of such an image. An image that has met none of
them looks better than it is; one that has met one looks worse. Its estimate is without bias over all images, and
says little of this one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..render.rounds import PILOT
from . import estimates

_TRUSTED = (0.9, 1.1)  # predicted over true error
_COVERAGE = 0.9  # of what claims 0.95
_TOP = 0.5  # of the squared error in a thousandth of the pixels


def reasons(points: Sequence[dict[str, Any]]) -> list[str]:
    """Why a scene is heavy-tailed, from the points of its curve; empty where it is not. What only the first samples
    show does not count: nothing is decided on so few (`rounds.PILOT`), unless there are no more."""
    counted = [point for point in points if point["samples"] >= PILOT] or list(points)
    found = []
    for point in counted:
        ratio, renders = point["predicted_over_true"], len(point["runs"])
        if ratio and (ratio["high"] < _TRUSTED[0] or ratio["low"] > _TRUSTED[1]):
            found.append(f"at {point['samples']:g} samples the estimate is {ratio['mean']:.2f} "
                         f"({ratio['low']:.2f} to {ratio['high']:.2f}) of the error")
        if estimates.share(point["covered"], renders).high < _COVERAGE:
            found.append(f"at {point['samples']:g} samples the 95% interval holds the error in {point['covered']} of "
                         f"{renders} images")
    said = [run["estimated"].get("heavy_tailed") for run in counted[-1]["runs"]]
    if 2 * said.count(True) > len(said):
        found.append(f"{said.count(True)} of {len(said)} images say so themselves")
    top = counted[-1]["top"]
    if top > _TOP:
        found.append(f"a thousandth of the pixels carries {top:.0%} of the squared error")
    return found
