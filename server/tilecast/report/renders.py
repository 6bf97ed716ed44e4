"""The renders that a report is made of: each from scratch, with its own time.

Every checkpoint is a render of its own that stops there. That costs twice what reading the image off a single long
render would, and is what it says: its time has no work in it that was already under way for later checkpoints, and
whatever decides samples while rendering decides as it would for a user who asks for so many.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from itertools import count, islice
from pathlib import Path
from typing import Any

import numpy as np

from ..render.local import render
from ..render.plan import make_plan
from ..scene.compiler import Compiled
from ..scene.loading import load, load_document
from ..scene.schema import Scene, Stop


@dataclass(frozen=True)
class Taken:
    """One render: float32 [h, w, 3], the error that it estimates for itself, samples a pixel, and seconds of
    rendering: on the wall, and of all processors."""
    pixels: np.ndarray
    error: dict[str, Any]
    samples: float
    seconds: float
    cpu_seconds: float


Render = Callable[[int, int], Taken]
"""(seed, samples) -> an image. Images of two seeds are independent."""


class SceneRenders:
    """Renders of one scene: call it with a seed and a number of samples. The scene's own stop rules do not count:
    checkpoints are fixed beforehand."""

    def __init__(self, source: str | Path | dict[str, Any], settings: Sequence[str], threads: int | None):
        self.source, self.settings, self.threads = source, list(settings), threads
        self.document: Scene = load_document(source, self.settings)[0]
        self.load_seconds: list[float] = []
        self.compile_seconds: list[float] = []
        self._loaded: tuple[int, Compiled] | None = None

    def __call__(self, seed: int, samples: int) -> Taken:
        compiled = self.compiled(seed)
        cpu = time.process_time()
        image = render(compiled, samples=samples, threads=self.threads, stop=Stop())
        cpu = time.process_time() - cpu
        return Taken(image.pixels, image.error, image.stats["samples"], image.stats["seconds"]["render"], cpu)

    def compiled(self, seed: int) -> Compiled:
        """The scene with a seed; the last is kept."""
        if self._loaded is None or self._loaded[0] != seed:
            self._loaded = None  # before the next is built
            compiled = load(self.source, settings=[*self.settings, f"render.seed={seed}"])
            self.load_seconds.append(compiled.seconds["load"])
            self.compile_seconds.append(compiled.seconds["compile"])
            self._loaded = seed, compiled
        return self._loaded[1]

    @property
    def checkpoints(self) -> list[int]:
        """Samples a pixel at which the plan of this image estimates its error."""
        plan = make_plan(self.document.image.width, self.document.image.height, self.document.render.samples)
        return [plan.samples_after(index + 1) for index in plan.checkpoints]

    def seeds(self, count: int) -> list[int]:
        """To be measured: the scene's own and those after it."""
        return [(self.document.render.seed + k) % 2**32 for k in range(count)]

    def reference_seeds(self, measured: Collection[int]) -> list[int]:
        """For two references: none of those measured."""
        free = ((self.document.render.seed + 2**31 + k) % 2**32 for k in count())
        return list(islice((seed for seed in free if seed not in measured), 2))
