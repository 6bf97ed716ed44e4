"""From the text of a scene to a checked `schema.Scene`. Every refusal is a SceneError that names its
place."""

from __future__ import annotations

import contextlib
import gc
import json
import re
from collections.abc import Iterator
from typing import Any

import numpy as np
from pydantic import ValidationError

from . import checks, messages, schema
from .errors import SceneError
from .paths import Part

DEEPEST = 64  # levels of lists and objects in each other; nothing that people write comes near


def parse(text: bytes | str | dict) -> schema.Scene:
    """The scene in `text` (JSON, UTF-8) or in a dictionary of the same shape; SceneError if there is anything
    wrong.

    What only the meshes' files can tell is not known yet: see `compile`.
    """
    with collector_paused():
        return judge(read(text))


def judge(document: dict[str, Any]) -> schema.Scene:
    """The scene in a document that `read` gave."""
    with collector_paused():
        try:
            scene = schema.Scene.model_validate(document)
        except ValidationError as error:
            found = messages.errors(error, document)
            raise SceneError(*found[0], errors=found) from None
        checks.check(scene)
        return scene


@contextlib.contextmanager
def collector_paused() -> Iterator[None]:
    """For work that makes nothing but objects that stay: looking through them for garbage would take half of
    its time."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def read(text: bytes | str | dict) -> dict[str, Any]:
    """The JSON document as it stands, not yet held against the schema. NaN and infinity pass here, to be
    refused by the schema with their path."""
    if not isinstance(text, (bytes, str)):
        text = _written(text)
    if isinstance(text, bytes):
        try:
            text = text.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            raise SceneError("", f"is not JSON: byte {error.start} is not UTF-8 text") from None
    _refuse_depth(text)
    pairs = Pairs()
    try:
        document = json.loads(text, object_pairs_hook=pairs)
    except json.JSONDecodeError as error:
        raise SceneError("", f"is not JSON: {error.msg} at line {error.lineno}, column {error.colno}") from None
    except ValueError:  # Python refuses integers of more than 4300 digits
        raise SceneError("", "is not a scene: it holds an integer of thousands of digits") from None
    except RecursionError:  # called from deep within another program
        raise SceneError("", "is nested too deeply for the stack that is left") from None
    if pairs.duplicates:
        raise SceneError(_find(document, pairs.duplicates), "stands here twice; keep one of the two")
    if not isinstance(document, dict):
        raise SceneError("", f"must be an object {{...}}, got {messages.shown(document)}")
    return document


def _written(document: Any) -> str:
    """A dictionary from Python as JSON: so it is held to the same rules. Arrays become lists."""
    try:
        return json.dumps(document, default=_list)
    except TypeError as error:
        raise SceneError("", f"is not JSON: {error}") from None
    except ValueError:
        raise SceneError("", "is not JSON: it contains itself") from None
    except RecursionError:
        raise SceneError("", f"is nested more than {DEEPEST} levels deep") from None


def _list(value: Any) -> Any:
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    raise TypeError(f"an object of type {type(value).__name__} has no place in JSON")


# Without an end, too: a search that fails at one quote and begins again at the next takes hours of a megabyte of them.
_STRING = re.compile(r'"[^"\\]*(?:\\.[^"\\]*)*(?:"|\\?\Z)', re.DOTALL)


def _refuse_depth(text: str) -> None:
    """Refuses deep nesting before the JSON parser, which recurses, sees it."""
    characters = np.frombuffer(_STRING.sub("", text).encode("utf-8", "replace"), np.uint8)
    opening = (characters == ord("[")) | (characters == ord("{"))
    closing = (characters == ord("]")) | (characters == ord("}"))
    depth = np.cumsum(opening.astype(np.int32) - closing, dtype=np.int32)
    if len(depth) and depth.max() > DEEPEST:
        raise SceneError("", f"is nested {depth.max()} levels deep, more than {DEEPEST} {_where(text)}")


def _where(text: str) -> str:
    """Line and column of the first bracket beyond the limit."""
    depth = 0
    for token in re.finditer(_STRING.pattern + r"|[\[\]{}]", text, re.DOTALL):
        depth += (token[0] in "[{") - (token[0] in "]}")
        if depth > DEEPEST:
            break
    line = text.count("\n", 0, token.start())
    return f"at line {line + 1}, column {token.start() - text.rfind(chr(10), 0, token.start())}"


class Pairs:
    """Builds the JSON parser's dictionaries and notes those in which a key stood twice."""

    def __init__(self):
        self.duplicates: list[tuple[dict, str]] = []

    def __call__(self, pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        result = dict(pairs)
        if len(result) < len(pairs):
            seen: set[str] = set()
            key = next(key for key, _ in pairs if key in seen or seen.add(key))
            self.duplicates.append((result, key))
        return result


def _find(document: Any, duplicates: list[tuple[dict, str]]) -> list[Part]:
    """The path of the first dictionary with a key that stood twice. Its second value won, and so a dictionary
    inside the first value may have gone."""
    keys = {id(dictionary): key for dictionary, key in duplicates}
    stack: list[tuple[list[Part], Any]] = [([], document)]
    while stack:
        path, value = stack.pop()
        if id(value) in keys:
            return [*path, keys[id(value)]]
        children = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
        stack.extend(([*path, part], child) for part, child in reversed(list(children)))
    return [duplicates[0][1]]
