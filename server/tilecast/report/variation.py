"""KEY=A,B,C: one setting of a scene, and the values that it is to have in turn."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from ..scene.errors import SceneError
from ..scene.overrides import value_of

# Keys that change how fast a picture is made, and never the picture.
_FOR_SPEED = ("accelerator", "grouping", "reinsertion")
# Keys that change its noise, and not what it becomes with more and more samples.
_FOR_NOISE = ("adaptive", "contrast", "next_event", "roulette", "sampler", "samples", "seed")
# Keys whose point is error against time: what noise there is, and what it costs.
_CURVES = ("adaptive", "contrast", "integrator", "next_event", "roulette", "sampler")


@dataclass(frozen=True)
class Variation:
    key: str
    """A JSON path in the scene."""
    values: tuple[Any, ...]
    """JSON values."""

    @property
    def settings(self) -> list[str]:
        """The values as KEY=VALUE."""
        return [f"{self.key}={json.dumps(value)}" for value in self.values]

    @property
    def labels(self) -> list[str]:
        """The same for people: texts without quotes."""
        return [f"{self.key}={label(value)}" for value in self.values]

    @property
    def keeps_pixels(self) -> bool:
        """Whether every value must give the same picture."""
        return self.key.rpartition(".")[2] in _FOR_SPEED

    @property
    def keeps_expectation(self) -> bool:
        """Whether every value must give the same picture in the end, and so has the same references."""
        return self.key.rpartition(".")[2] in (*_FOR_SPEED, *_FOR_NOISE)

    @property
    def wants_curves(self) -> bool:
        """Whether error against run time is what the values are compared by."""
        return self.key.rpartition(".")[2] in _CURVES


def label(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value)


def parse_variation(text: str) -> Variation:
    """Each value is JSON, or else stands for itself as a text: bvh,grid is two texts, [0,0,5],[0,1,5] two lists."""
    key, equals, values = text.partition("=")
    if not (equals and key.strip() and values.strip()):
        raise SceneError("", f"the variation {text!r} must be KEY=A,B,C, as in render.accelerator=bvh,grid")
    try:
        found = json.loads(f"[{values}]")
    except (ValueError, RecursionError):
        found = [value_of(value.strip()) for value in values.split(",")]
    return Variation(key.strip(), tuple(found))
