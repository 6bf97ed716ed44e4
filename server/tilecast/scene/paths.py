"""JSON paths as users read and write them: `objects.lens.of[1].radius`, `objects["my lens"].radius`."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable

Part = str | int

_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_-]*")
_PART = re.compile(r"""
    (?P<dot>\.?)(?P<plain>[A-Za-z_][A-Za-z0-9_-]*)     # a key
    | \[(?P<index>[0-9]{1,9})\]                        # an element of a list
    | \[(?P<quoted>"(?:[^"\\]|\\.)*")\]                # any other key, as a JSON string
""", re.VERBOSE)
_LONGEST_KEY = 80  # characters of a key that an error repeats


def text(parts: Iterable[Part]) -> str:
    """The path as text; keys that are not plain words are quoted."""
    out = ""
    for part in parts:
        if isinstance(part, int):
            out += f"[{part}]"
        elif _PLAIN.fullmatch(part) and len(part) <= _LONGEST_KEY:
            out += f".{part}" if out else part
        else:
            key = part if len(part) <= _LONGEST_KEY else part[:_LONGEST_KEY] + "..."
            out += f"[{json.dumps(key, ensure_ascii=not key.isprintable())}]"
    return out


def parse(path: str) -> list[Part]:
    """The parts of a path; the inverse of `text`. ValueError where it is not a path."""
    parts: list[Part] = []
    at = 0
    while at < len(path):
        match = _PART.match(path, at)
        # A plain key stands first or after a dot, and nowhere else.
        if match is None or (match["plain"] and bool(match["dot"]) != bool(parts)):
            raise ValueError(f"{path!r} is not a path like render.samples or scene[0].material")
        if match["plain"]:
            parts.append(match["plain"])
        elif match["index"]:
            parts.append(int(match["index"]))
        else:
            parts.append(json.loads(match["quoted"]))
        at = match.end()
    if not parts:
        raise ValueError("the path is empty")
    return parts
