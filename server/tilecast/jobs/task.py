"""What travels between a job, the dispatcher and the journal."""

import math
from dataclasses import dataclass
from typing import Any, Protocol

from tilecast.jobs import state
from tilecast.render.plan import Chunk
from tilecast.render.rendering import ChunkResult


class Listener(Protocol):
    """Whom a work tells what happens. The calls return at once; what they cause happens later, in the same order."""

    def happened(self, work: object, event: state.Event) -> None:
        """The job's state has to change."""

    def news(self, work: object) -> None:
        """There is something to `save`, and where `save` says so, to `finalize`."""

    def counted(self, result: ChunkResult | None) -> None:
        """A chunk came back; None: it was lost with its worker."""


@dataclass(frozen=True, eq=False)
class Task:
    """What goes to a worker: chunks, or (none) the compilation of the scene. `exclusive`: with nothing beside it."""

    chunks: tuple[Chunk, ...] = ()
    exclusive: bool = False


def finite(value: Any) -> Any:
    """`value` as JSON can say it: None for what is infinite or not a number."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: finite(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(inner) for inner in value]
    return value
