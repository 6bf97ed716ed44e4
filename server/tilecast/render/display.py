"""Views as a screen shows them. Only what is looked at goes this way (PNG, thumbnails, the page); an EXR keeps the
numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .. import _core

# Inferno (S. van der Walt and N. Smith, CC0), every eighth of it, sRGB: even steps look even, in grey too.
_INFERNO = ("000004", "210c4a", "57106e", "8a226a", "bc3754", "e45a31", "f98e09", "f9cb35", "fcffa4")


def shown(pixels: np.ndarray, facts: Mapping[str, Any] | None) -> np.ndarray:
    """Pixels, float32 [h, w, 3], as linear RGB for a screen. `facts` are those of the scene (`Compiled.facts`) or the
    statistics of its image, which hold them too.

    Normals: so that a PNG holds 0.5 + 0.5 n itself, as normal maps do. Cost goes from black to bright, depth from
    bright (near) to black (far); where nothing is hit, at 0 metres, it is black.
    """
    how = facts and facts.get("shown")
    if not how:
        return pixels
    if how["view"] == "normals":
        return _core.linear(pixels)
    first, last = how["range"]
    value = pixels[..., 0].astype(np.float64)
    place = np.clip((value - first) / (last - first), 0, 1) if last > first else np.zeros(value.shape)
    if how["view"] == "depth":
        place = np.where(value > 0, 1 - place, 0)
    return _coloured(place)


def heat(error: np.ndarray) -> np.ndarray:
    """A map of relative squared errors, float [h, w], as linear RGB for a screen, float32 [h, w, 3]: on a logarithmic
    scale, from black at 1e-6 or less to bright at 1 or more, so that the same colour is the same error everywhere."""
    place = np.clip(1 + np.log10(np.maximum(error, 1e-6)) / 6, 0, 1)
    return _coloured(place)


def _ramp(steps: int = 1025) -> np.ndarray:
    """float32 [steps, 3], linear RGB."""
    anchors = np.array([[int(text[at:at + 2], 16) for at in (0, 2, 4)] for text in _INFERNO]) / 255
    at = np.linspace(0, len(anchors) - 1, steps)
    return _core.linear(np.stack([np.interp(at, range(len(anchors)), channel) for channel in anchors.T], axis=1))


_RAMP = _ramp()


def _coloured(place: np.ndarray) -> np.ndarray:
    """The colours of places in 0 to 1 on the ramp, float32 [..., 3], linear RGB."""
    return _RAMP[np.rint(place * (len(_RAMP) - 1)).astype(np.intp)]
