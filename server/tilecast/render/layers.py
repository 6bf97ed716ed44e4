"""What an EXR holds beside the picture, by channel name: layers as OpenEXR names them, so that viewers group them.

    variance.R .G .B    the estimated variance of the pixel: its mean is the image's `mse`
    error               the relative squared error about the pixel, see `error.error_map`
    samples             of the pixel
    albedo.R .G .B, normal.X .Y .Z, depth.Z
                        of what the camera sees first: see the core's `first_hits`
"""

from __future__ import annotations

import numpy as np

from .error import error_map

Layers = dict[str, np.ndarray]
"""Channel name -> float32 [h, w]."""

_FIRST_HITS = ("albedo.R", "albedo.G", "albedo.B", "normal.X", "normal.Y", "normal.Z", "depth.Z")
FIRST_HIT_SAMPLES = 16  # of each pixel: enough for the edges between surfaces


def error_layers(pixels: np.ndarray, variance: np.ndarray, samples: np.ndarray) -> Layers:
    """Of an image [h, w, 3], the variance of its pixels [h, w, 3], and their samples [h, w]."""
    layers = {f"variance.{name}": variance[..., channel] for channel, name in enumerate("RGB")}
    return layers | {"error": error_map(pixels, variance), "samples": samples.astype(np.float32)}


def first_hit_layers(hits: np.ndarray) -> Layers:
    """Of what the core's `first_hits` gives, [h, w, 7]."""
    return {name: hits[..., channel] for channel, name in enumerate(_FIRST_HITS)}
