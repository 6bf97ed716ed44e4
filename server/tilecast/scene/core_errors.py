"""Errors of the core at their places in the scene."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator, Sequence

from .. import _core
from .checks import Path
from .errors import SceneError
from .paths import parse

# The core says what is wrong and, where it lies deeper than the object itself, first where: "of[1].transform:
# ...".
_DEEPER = re.compile(r"(?P<at>[a-z_]+(?:\[\d+\])*(?:\.[a-z_]+(?:\[\d+\])*)*): (?P<message>.+)", re.DOTALL)


@contextlib.contextmanager
def at(path: Path, of: Sequence[Path] = ()) -> Iterator[None]:
    """Errors of the core become errors at `path`, or below it. `of`: the paths of what the core knows as
    of[i], where that is not the key under which the scene has it."""
    try:
        yield
    except _core.Error as error:
        message = str(error)
        match = _DEEPER.fullmatch(message)
        if match is None:
            raise SceneError(path, message) from None
        deeper = parse(match["at"])
        if of and deeper[0] == "of":
            path, deeper = of[deeper[1]], deeper[2:]
        raise SceneError((*path, *deeper), match["message"]) from None
