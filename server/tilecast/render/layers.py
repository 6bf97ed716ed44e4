"""What an EXR holds beside the picture, by channel name: layers as OpenEXR names them, so that viewers group them.

    variance.R .G .B    the estimated variance of the pixel: its mean is the image's `mse`
    error               the relative squared error about the pixel, see `error.error_map`
    samples             of the pixel
    albedo.R .G .B, normal.X .Y .Z, depth.Z
                        of what the camera sees first: see the core's `first_hits`
"""

from __future__ import annotations

import logging

import numpy as np

from .error import error_map
from .film import MOST_FLOAT, as_float32

_log = logging.getLogger(__name__)

Layers = dict[str, np.ndarray]
"""Channel name -> float32 [h, w]."""

_FIRST_HITS = ("albedo.R", "albedo.G", "albedo.B", "normal.X", "normal.Y", "normal.Z", "depth.Z")
FIRST_HIT_SAMPLES = 16  # of each pixel: enough for the edges between surfaces


def error_layers(pixels: np.ndarray, variance: np.ndarray, samples: np.ndarray) -> Layers:
    """Of an image [h, w, 3], the variance of its pixels [h, w, 3], and their samples [h, w]. Pixels with fewer than two
    samples tell nothing of their error: NaN, and no layers of it where that is all of them. What float32 cannot hold
    becomes its largest number."""
    counts = {"samples": samples.astype(np.float32)}
    told = samples >= 2
    if not told.any():
        return counts
    layers = {f"variance.{name}": variance[..., channel] for channel, name in enumerate("RGB")}
    layers["error"] = error_map(pixels, variance)
    if (variance > MOST_FLOAT).any():
        _log.warning("the variance of some pixels is above %.2g, the most that an EXR's layer holds; it becomes that",
                     MOST_FLOAT)
    layers = {name: as_float32(layer) for name, layer in layers.items()}
    if not told.all():
        layers = {name: np.where(told, layer, np.float32(np.nan)) for name, layer in layers.items()}
    return layers | counts


def first_hit_layers(hits: np.ndarray) -> Layers:
    """Of what the core's `first_hits` gives, [h, w, 7]."""
    return {name: hits[..., channel] for channel, name in enumerate(_FIRST_HITS)}
