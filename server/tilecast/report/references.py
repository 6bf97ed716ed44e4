"""What images are measured against: two independent references, or a single one.

Let R be the true image and R1 = R + e1, R2 = R + e2 references whose errors are independent of each other and of an
image I, and zero on average. Then mean((I - R1)(I - R2)) has the expectation of mean((I - R)^2), however noisy the
references are: in (d - e1)(d - e2) = d^2 - d e1 - d e2 + e1 e2 all but the first vanish on average. Their noise only
widens the scatter.

The relative error is mean((I - R1)(I - R2) f(M)) with f(r) = 1 / (r^2 + 0.01) and M = (R1 + R2) / 2 in place of R,
and that has a bias. Where an image has the error s^2 and each reference v, the expectation to second order in the
references' noise is s^2 f(R) + f''(R) (s^2 v / 4 + v^2 / 4): the first from the curvature of f, the second from
the noise that numerator and denominator share. Where R is not black f is convex, and the first is taken away: v / 4 is
(R1 - R2)^2 / 8 on average, and f(M) is divided by 1 + f''(M) v / 4 f(M), as in core/render/denominators, which is right to
the same order and cannot go below 0. Of what noisy references leave, the part that this takes from their own error tells the
size: their error lies where the bias does. By 512 samples each it is 14% in many-lights, where the bias was 11% and is 5%,
and 1% to 2% in most scenes.

Of a single reference, (I - R1)^2 is the error of the image and that of the reference together.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .. import _core
from ..scene.errors import SceneError



@dataclass(frozen=True)
class Error:
    """The error of an image against references. `top`: the part of the squared error that lies in a thousandth of the
    pixels, those where it is largest (at least one)."""
    mse: float
    relative_mse: float
    top: float


class References:
    """One or two images, [h, w, 3], linear RGB; `seeds`: what they were rendered with, where that is known."""

    def __init__(self, images: Sequence[np.ndarray], seeds: Sequence[int | None] = ()):
        self.first, self.second = (np.asarray(image, np.float64) for image in (images[0], images[-1]))
        self.independent = len(images) == 2
        self.seeds = tuple(seeds)
        self.weight = _core.error_weight(self._mean(), self._variance())

    def _mean(self) -> np.ndarray:
        return (self.first + self.second) / 2

    def _variance(self) -> np.ndarray:
        """Of the mean, estimated for each pixel; 0 for a single reference."""
        return (self.first - self.second) ** 2 / 4

    @property
    def shape(self) -> tuple[int, ...]:
        return self.first.shape

    def error(self, pixels: np.ndarray) -> Error:
        """Of an image [h, w, 3] that is independent of the references."""
        pixels = np.asarray(pixels, np.float64)
        square = (pixels - self.first) * (pixels - self.second)
        each = np.sort(square.sum(axis=2), axis=None)
        total = each.sum()
        top = each[-max(len(each) // 1000, 1):].sum() / total if total > 0 else 0.0
        return Error(float(square.mean()), float((square * self.weight).mean()), float(min(top, 1.0)))

    def holds(self, pixels: np.ndarray) -> bool:
        """Whether an image is one of the references, bit for bit."""
        return any(np.array_equal(pixels, reference) for reference in (self.first, self.second))

    def own_error(self) -> dict[str, float] | None:
        """Of the mean of the two: MSE and relative MSE, and relative_bias, what part of a relative MSE may be of the
        references' noise. None for a single one, which cannot tell."""
        if not self.independent:
            return None
        square = self._variance()
        relative = float((square * self.weight).mean())
        plain = float((square * _core.error_weight(self._mean(), 0.0)).mean())
        return {"mse": float(square.mean()), "relative_mse": relative,
                "relative_bias": 1 - relative / plain if plain > 0 else 0.0}


def read_references(paths: Sequence[Path], width: int, height: int, measured: Collection[int] = ()) -> References:
    """From one or two OpenEXR files of the image's size with channels R, G and B. SceneError for anything else, and for
    files that say that they have each other's seed, or one of those that are `measured`."""
    if len(paths) > 2:
        raise SceneError("", f"there may be one reference or two, got {len(paths)}")
    if len({path.resolve() for path in paths}) < len(paths):
        raise SceneError("", f"the two references must be independent renders, got {paths[0]} twice")
    images, seeds = zip(*(_read(path, width, height) for path in paths))
    for path, seed in zip(paths, seeds):
        if seed in measured:
            raise SceneError("", f"the reference {path} was rendered with seed {seed}, which is measured: the errors "
                                 "would be the same. Render it with --seed of another")
    if len(seeds) == 2 and seeds[0] == seeds[1] is not None:
        raise SceneError("", f"the two references must be independent renders: {paths[0]} and {paths[1]} both have seed "
                             f"{seeds[0]}")
    if len(images) == 2 and np.array_equal(*images):
        raise SceneError("", f"the two references must be independent renders: {paths[0]} and {paths[1]} are the same")
    return References(images, seeds)


def _read(path: Path, width: int, height: int) -> tuple[np.ndarray, int | None]:
    """The pixels, and the seed where the file says it."""
    if path.suffix.lower() != ".exr":
        raise SceneError("", f"the reference {path} must be an OpenEXR file, which holds linear light")
    if not path.is_file():
        raise SceneError("", f"the reference {path} is not there")
    from .. import _images  # OpenImageIO is loaded where there is an image

    try:
        pixels, channels, metadata = _images.read(str(path))
    except _core.Error as problem:
        raise SceneError("", f"the reference {path} cannot be read: {problem}") from None
    if not {"R", "G", "B"} <= set(channels):
        raise SceneError("", f"the reference {path} must have the channels R, G and B, got {', '.join(channels)}")
    if pixels.shape[:2] != (height, width):
        raise SceneError("", f"the reference {path} must have the image's {width} x {height} pixels, got "
                             f"{pixels.shape[1]} x {pixels.shape[0]}")
    rgb = pixels[..., [channels.index(name) for name in "RGB"]]
    if not np.isfinite(rgb).all():
        raise SceneError("", f"the reference {path} has pixels that are NaN or infinite")
    seed = metadata.get("tilecast:seed", "")
    return rgb, int(seed) if seed.isdecimal() else None
