"""Images as bytes and files: PNG in sRGB, EXR in linear float, thumbnails, half floats for the viewer."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .display import heat, shown
from .error import error_map

FORMATS = ("png", "exr")

_CHANNELS = ["R", "G", "B"]
_HALF_MAX = 65504.0


def srgb(pixels: np.ndarray) -> np.ndarray:
    """Linear RGB in float as sRGB in 8 bits (IEC 61966-2-1), clipped to what a screen shows; the same
    shape."""
    linear = np.clip(pixels, 0, 1).astype(np.float32, copy=False)
    encoded = np.where(linear <= 0.0031308, linear * np.float32(12.92),
                       np.float32(1.055) * linear ** np.float32(1 / 2.4) - np.float32(0.055))
    return (encoded * 255 + 0.5).astype(np.uint8)


def to_png(pixels: np.ndarray, metadata: Mapping[str, str] | None = None) -> bytes:
    """A PNG of float32 [h, w, 3], linear RGB: sRGB, 8 bits."""
    return _encoded("png", np.ascontiguousarray(srgb(pixels)), _CHANNELS, dict(metadata or {}))


def to_exr(pixels: np.ndarray, metadata: Mapping[str, str] | None = None,
           layers: Mapping[str, np.ndarray] | None = None) -> bytes:
    """An OpenEXR file of float32 [h, w, 3], linear RGB, without loss; and of more channels, [h, w] each, by name."""
    layers = layers or {}
    channels = np.dstack([pixels, *layers.values()]).astype(np.float32, copy=False)
    return _encoded("exr", np.ascontiguousarray(channels), [*_CHANNELS, *layers], dict(metadata or {}))


def _encoded(*image: Any) -> bytes:
    from .. import _images  # OpenImageIO is loaded where there is an image

    return _images.encode(*image)


def error_png(pixels: np.ndarray, variance: np.ndarray) -> bytes:
    """A PNG that shows where the error of an image is (`display.heat`); both float32 [h, w, 3]."""
    return to_png(heat(error_map(pixels, variance)))


def to_f16(pixels: np.ndarray) -> bytes:
    """Half floats, little-endian, row by row, RGB; what is above the largest half (65504) becomes it."""
    return np.clip(pixels, -_HALF_MAX, _HALF_MAX).astype("<f2").tobytes()


def thumbnail(pixels: np.ndarray, size: int = 160) -> bytes:
    """A PNG whose longer side is at most `size`; averaged in linear light. Smaller images keep their size."""
    height, width = pixels.shape[:2]
    scale = min(size / max(height, width), 1)
    for axis, length in ((0, height), (1, width)):
        edges = np.linspace(0, length, max(round(length * scale), 1) + 1).round().astype(np.int64)
        shape = (-1, 1, 1) if axis == 0 else (1, -1, 1)
        pixels = np.add.reduceat(pixels, edges[:-1], axis) / np.diff(edges).reshape(shape)
    return to_png(pixels)


def encode(suffix: str, pixels: np.ndarray, metadata: Mapping[str, str] | None = None,
           facts: Mapping[str, Any] | None = None, layers: Mapping[str, np.ndarray] | None = None) -> bytes:
    """The image in the format of a file name's suffix (".png", ".exr"). ValueError for any other. `facts`: see
    `display.shown`, by which a PNG shows what an EXR holds; `layers`: what else an EXR holds."""
    match suffix.lower():
        case ".png":
            return to_png(shown(pixels, facts), metadata)
        case ".exr":
            return to_exr(pixels, metadata, layers)
    raise ValueError(f"an image file ends in .png or .exr, got {suffix or 'no suffix'!r}")


def write_file(path: Path, data: bytes) -> None:
    """Writes a file in one step: under another name first, then renamed. Whoever reads it finds the old or
    the new."""
    path = Path(path)
    handle, temporary = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent or Path("."))
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        os.chmod(temporary, 0o666 & ~_umask())  # mkstemp lets nobody else read
        os.replace(temporary, path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def _umask() -> int:
    mask = os.umask(0o022)
    os.umask(mask)
    return mask
