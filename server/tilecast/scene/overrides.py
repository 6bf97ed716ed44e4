"""Settings given apart from the scene: `render.samples=16`."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterable
from typing import Any

from . import messages, paths
from .errors import SceneError
from .parsing import Pairs


def override(document: dict[str, Any], settings: Iterable[str]) -> dict[str, Any]:
    """A copy of the JSON document with each KEY=VALUE put in place, in order. KEY is a JSON path; objects on
    the way that are not there are made. VALUE is JSON, or else stands for itself as a text."""
    if settings := list(settings):
        document = copy.deepcopy(document)
    for setting in settings:
        key, equals, value = setting.partition("=")
        if not equals:
            raise SceneError("", f"the setting {setting!r} must be KEY=VALUE, as in render.samples=16")
        try:
            parts = paths.parse(key.strip())
        except ValueError as error:
            raise SceneError("", f"the setting {setting!r}: {error}") from None
        _put(document, parts, value_of(value))
    return document


def value_of(text: str) -> Any:
    """The JSON value, or else the text itself."""
    pairs = Pairs()
    try:
        value = json.loads(text, object_pairs_hook=pairs)
    except (ValueError, RecursionError):
        return text
    if pairs.duplicates:
        raise SceneError("", f"the setting has the key {pairs.duplicates[0][1]!r} twice")
    return value


def _put(document: Any, parts: list[paths.Part], value: Any) -> None:
    here = document
    for at, part in enumerate(parts):
        path, last = parts[:at + 1], at == len(parts) - 1
        if isinstance(part, int):
            if not isinstance(here, list) or part >= len(here):
                size = f"a list of {len(here)}" if isinstance(here, list) else messages.shown(here)
                raise SceneError(path, f"cannot be set: {paths.text(parts[:at]) or 'the scene'} is {size}")
        elif not isinstance(here, dict):
            raise SceneError(path, f"cannot be set: {paths.text(parts[:at])} is {messages.shown(here)}")
        if last:
            here[part] = value
        elif isinstance(part, int):
            here = here[part]
        else:
            if here.get(part) is None:
                here[part] = {}
            here = here[part]
