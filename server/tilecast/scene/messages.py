"""Pydantic's findings in the project's words, each with the JSON path as the user wrote it."""

from __future__ import annotations

import difflib
import json
import math
from collections.abc import Mapping
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from . import paths, schema
from .fields import SMALLEST

_NO_TAG = str.maketrans("", "", "'~")
_UNTAGGED = {(), ("objects",), ("materials",)}  # these hold names
_MOST = 100  # errors that are worded; a broken generator makes the same one a million times


def errors(found: ValidationError, document: Any) -> list[tuple[str, str]]:
    """(path, message) of each finding in `document`, at most 100."""
    return [_one(error, document) for error in found.errors(include_url=False)[:_MOST]]


def _one(error: Mapping[str, Any], document: Any) -> tuple[str, str]:
    parts, parent = _path(error["loc"], document)
    context = error.get("ctx", {})
    if error["type"] in ("union_tag_invalid", "union_tag_not_found") and context["discriminator"] == "'type'":
        parts.append("type")
    elif error["type"] == "fault":
        parts.extend(context["at"])
    return paths.text(parts), _message(error["type"], context, error["input"], error["msg"], parts, parent)


def _path(location: tuple[str | int, ...], document: Any) -> tuple[list[paths.Part], Any]:
    """The path of a pydantic location, without the tags of the unions on the way; and the innermost value
    above it."""
    parts: list[paths.Part] = []
    value, parent, tagged = document, None, False
    for part in location:
        # In front of the keys of an object with a `type` pydantic puts that type, once.
        kind = value.get("type", "perspective" if parts == ["camera"] else None) if isinstance(value, dict) else None
        tag = part == kind is not None and not tagged and tuple(parts) not in _UNTAGGED
        if isinstance(value, dict) and part in value and not tag:
            value, parent, tagged = value[part], value, False
        elif isinstance(value, list) and isinstance(part, int) and part < len(value):
            value, parent, tagged = value[part], value, False
        elif str(part).startswith("~") or part == "[key]":
            continue
        elif tag:
            tagged = True
            continue
        else:
            value, parent = None, value  # a key that is missing
        parts.append(part)
    return parts, parent


def _message(kind: str, context: Mapping[str, Any], value: Any, text: str, parts: list[paths.Part],
             parent: Any) -> str:
    got = f", got {shown(value)}"
    match kind:
        case "fault":
            return context["message"]
        case "missing":
            return "is required"
        case "extra_forbidden":
            return f"is not a key that is known here{_suggestion(str(parts[-1]), parent, parts[:-1])}"
        case "union_tag_invalid" if parts[-1] != "type":
            return f"must be an object with one of the keys {context['expected_tags'].translate(_NO_TAG)}{got}"
        case "union_tag_invalid":
            tag = value.get("type") if isinstance(value, dict) else value
            return f"must be one of {context['expected_tags'].translate(_NO_TAG)}, got {shown(tag)}"
        case "union_tag_not_found":
            return "is required: it says what kind this is"
        case "literal_error":
            return f"must be {context['expected'].translate(_NO_TAG)}{got}"
        case "greater_than":
            return f"must be greater than {context['gt']:g}{got}"
        case "greater_than_equal" if context["ge"] == SMALLEST and value <= 0:
            return f"must be positive{got}"
        case "greater_than_equal":
            return f"must be at least {context['ge']:g}{got}"
        case "less_than":
            return f"must be less than {context['lt']:g}{got}"
        case "less_than_equal":
            return f"must be at most {context['le']:.10g}{got}"
        case "too_short":
            return f"needs at least {context['min_length']} elements, got {context['actual_length']}"
        case "too_long":
            return f"takes at most {context['max_length']} elements, got more"
        case "string_too_short":
            return "must not be empty"
        case "string_too_long":
            return f"must be at most {context['max_length']} characters long"
        case "finite_number":
            return f"must be a finite number{got}"
        case "float_type":
            return f"must be a {'finite ' if isinstance(value, int) else ''}number{got}"
        case "int_type":
            return f"must be an integer{got}"
        case "string_type" | "string_unicode":
            return f"must be a text{got}"
        case "bool_type":
            return f"must be true or false{got}"
        case "list_type":
            return f"must be a list{got}"
        case "dict_type" | "model_type" | "model_attributes_type":
            return f"must be an object {{...}}{got}"
        case "recursion_loop":
            return "contains itself"
    return text[:1].lower() + text[1:] + got


def shown(value: Any) -> str:
    """A value as an error repeats it: short, on one line."""
    if isinstance(value, (list, tuple)):
        return f"a list of {len(value)}" if value else "an empty list"
    if isinstance(value, (dict, BaseModel)):
        return "an object"
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if value != value else ("infinity" if value > 0 else "-infinity")
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) >= 10**40:
        return "a number of more than 40 digits"
    text = value if isinstance(value, str) else None
    text = json.dumps(value if text is None else text[:60], default=str,
                      ensure_ascii=text is not None and not text.isprintable())
    return text if len(text) <= 80 else text[:77] + "..."


def _suggestion(key: str, parent: Any, path: list[paths.Part]) -> str:
    known = _known_keys(parent, path)
    close = difflib.get_close_matches(key, known, n=1)
    if close:
        return f"; did you mean {close[0]}?"
    return f"; known are {', '.join(known)}" if known else ""


def _members(union: Any) -> tuple[type[BaseModel], ...]:
    return get_args(get_args(union.__value__)[0])


_BY_TYPE = {get_args(model.model_fields["type"].annotation)[0]: model
            for model in (*_members(schema.Object), *_members(schema.Material), *_members(schema.Light),
                          *_members(schema.Camera), schema.Checker, schema.Gradient, schema.SkyBackground)}
_IMAGES = {"background": schema.ImageBackground, "emission": schema.EmissionImage, "normal_map": schema.NormalMap,
           "roughness": schema.ScalarImage, "opacity": schema.ScalarImage}
_BY_PATH = {(): schema.Scene, ("image",): schema.Image, ("render",): schema.Render, ("render", "stop"): schema.Stop}
_BY_KEY = {"object": schema.Reference, "translate": schema.Translate, "scale": schema.Scale,
           "rotate": schema.Rotate, "matrix": schema.MatrixStep, "axis": schema.AxisAngle}


def _known_keys(parent: Any, path: list[paths.Part]) -> list[str]:
    """The keys that the object `parent` at `path` may have; empty where that is not clear."""
    if not isinstance(parent, dict):
        return []
    kind = parent.get("type", "perspective" if list(path) == ["camera"] else None)
    if kind == "image" and path:
        return list(_IMAGES.get(path[-1], schema.ImageTexture).model_fields)
    model = _BY_PATH.get(tuple(path)) or (_BY_TYPE.get(kind) if isinstance(kind, str) else None)
    model = model or next((model for key, model in _BY_KEY.items() if key in parent), None)
    return list(model.model_fields) if model else []
