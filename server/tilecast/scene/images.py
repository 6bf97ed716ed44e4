"""Image files as arrays of linear RGB, through OpenImageIO."""

from __future__ import annotations

from pathlib import PurePosixPath

import numpy as np

from .. import _core
from .errors import SceneError


def load(data: bytes, file: str) -> np.ndarray:
    """The pixels in the bytes of an EXR, HDR or PNG file: float32 [h, w, 3], linear RGB; a grey image has three equal
    channels, others than R, G and B are left out. Those of a PNG are taken for sRGB. What is not an image is refused
    with a SceneError without a path."""
    if not data:
        raise SceneError("", f"names the file {file!r}, which is empty")
    kind = PurePosixPath(file).suffix[1:].lower()
    try:
        pixels, channels, _ = _core.decode_image(f"image.{kind}", data)
    except _core.Error as error:
        text = " ".join(str(error).split())[:200]
        raise SceneError("", f"names the file {file!r}, which is not a readable {kind.upper()} image: {text}") from None
    names = [name.upper() for name in channels]
    picked = [names.index(name) for name in "RGB"] if {"R", "G", "B"} <= set(names) else [0, 0, 0]
    pixels = np.ascontiguousarray(pixels[..., picked])
    return _core.linear(pixels) if kind == "png" else pixels
