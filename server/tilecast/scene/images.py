"""Image files as arrays of linear RGB, through OpenImageIO."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import PurePosixPath

import numpy as np

from .. import _core
from .errors import SceneError


_SRGB = ("png", "jpg", "jpeg")  # what these hold, unless they are said to be otherwise


def load(data: bytes, file: str, colour_space: str = "auto") -> np.ndarray:
    """The pixels in the bytes of an image file: float32 [h, w, 3], linear RGB; a grey image has three equal channels,
    others than R, G and B are left out. colour_space: of the file's values, "srgb", "linear" or, by its kind, "auto". What
    is not an image is refused with a SceneError without a path."""
    pixels, names = _decoded(data, file)
    picked = [names.index(name) for name in "RGB"] if {"R", "G", "B"} <= set(names) else [0, 0, 0]
    pixels = np.ascontiguousarray(pixels[..., picked])
    srgb = colour_space == "srgb" or (colour_space == "auto" and PurePosixPath(file).suffix[1:].lower() in _SRGB)
    return _core.linear(pixels) if srgb else pixels


def load_channel(data: bytes, file: str, wanted: Sequence[str], colour_space: str) -> np.ndarray:
    """The first channel of the wanted names (r, g, b, a) that there is, or where none are named the first: float32 [h, w, 1].
    The only channel of a grey image is r, g and b."""
    pixels, names = _decoded(data, file)
    if "R" not in names:
        names = ["R", *names[1:]]
    for name in wanted:
        if name.upper() not in names and name in "gb" and "G" not in names:
            name = "r"
        if name.upper() in names:
            pixels = np.ascontiguousarray(pixels[..., [names.index(name.upper())]])
            return _core.linear(pixels) if colour_space == "srgb" else pixels
    raise SceneError("", f"names the file {file!r}, which has no channel {wanted[0]}")


def texels(pixels: np.ndarray) -> _core.Texels:
    """What textures may share: pixels float32 [h, w, 1 or 3], linear light, or plain numbers."""
    from .. import _images

    return _images.texels(pixels)


def _decoded(data: bytes, file: str) -> tuple[np.ndarray, list[str]]:
    """float32 [h, w, channels], and the channels' names in capitals."""
    if not data:
        raise SceneError("", f"names the file {file!r}, which is empty")
    from .. import _images  # OpenImageIO is loaded where there is an image

    kind = PurePosixPath(file).suffix[1:].lower()
    try:
        pixels, channels, _ = _images.decode(f"image.{kind}", data)
    except (_core.Error, UnicodeDecodeError) as error:  # of names of channels
        text = " ".join(str(error).split())[:200]
        raise SceneError("", f"names the file {file!r}, which is not a readable {kind.upper()} image: {text}") from None
    return pixels, [name.upper() for name in channels]
