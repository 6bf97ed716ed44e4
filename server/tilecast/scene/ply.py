"""PLY files that trimesh would misread without a word: it takes what there is of a text that was cut off, and in binary
files the number of corners of the first face for that of all."""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np

_HEADER = re.compile(rb"ply\s.*?^end_header[ \t]*\r?\n", re.DOTALL | re.MULTILINE)
_TYPES = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4", "double": "f8",
          "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4", "float32": "f4",
          "float64": "f8"}


class _Element(NamedTuple):
    name: str
    count: int
    properties: list[list[str]]  # [type, name], or ["list", type of the number, type, name]


def check_ply(data: bytes) -> None:
    """Raises `ValueError` where trimesh would take the file for another mesh; what else is wrong it tells itself."""
    if not (header := _HEADER.match(data)):
        return
    text, elements = header.group().decode("ascii", "replace"), []
    for words in (line.split() for line in text.splitlines()):
        if words[:1] == ["element"] and len(words) == 3 and words[2].isdigit():
            elements.append(_Element(words[1], int(words[2]), []))
        elif words[:1] == ["property"] and len(words) > 2 and elements:
            elements[-1].properties.append(words[1:])
    if re.search(r"^format ascii", text, re.MULTILINE):
        _check_text(data[header.end():], elements)
    else:
        _check_binary(data, header.end(), elements, ">" if "binary_big_endian" in text else "<")


def _check_text(body: bytes, elements: list[_Element]) -> None:
    rows = [row for row in body.splitlines() if row.strip()]
    begin = 0
    for element in elements:
        if len(rows) < begin + element.count:
            raise ValueError(f"it is cut off: {max(0, len(rows) - begin)} of {element.count} rows of its element "
                             f"{element.name} are there")
        whole = all(_TYPES.get(of[-2], "f")[0] in "iu" for of in element.properties)
        if any(of[0] == "list" for of in element.properties):
            for i, row in enumerate(rows[begin:begin + element.count]):
                words, at = row.split(), 0
                for of in element.properties:
                    at += 1 + (int(words[at]) if of[0] == "list" and at < len(words) else 0)
                if at != len(words):
                    raise ValueError(f"row {i} of its element {element.name} has {len(words)} numbers instead of {at}")
                if whole and b"." in row:
                    raise ValueError(f"row {i} of its element {element.name} has a fraction, where whole numbers are said to be")
        begin += element.count


def _check_binary(data: bytes, begin: int, elements: list[_Element], order: str) -> None:
    for element in elements:
        fields: list[tuple] = []  # of a row as long as the first
        lengths: list[tuple[str, int]] = []
        for i, of in enumerate(element.properties):
            if any(kind not in _TYPES for kind in (of[1:3] if of[0] == "list" else of[:1])):
                return
            if of[0] == "list":
                number = order + _TYPES[of[1]]
                at = begin + np.dtype(fields).itemsize
                if at + np.dtype(number).itemsize > len(data) or not element.count:
                    break
                first = int(np.frombuffer(data, number, 1, at)[0])
                lengths.append((f"length {i}", first))
                fields += [(f"length {i}", number), (f"{i}", order + _TYPES[of[2]], (max(0, first),))]
            else:
                fields.append((f"{i}", order + _TYPES[of[0]]))
        row = np.dtype(fields)
        end = begin + element.count * row.itemsize
        rows = np.frombuffer(data, row, element.count, begin) if end <= len(data) and row.itemsize else None
        if lengths and (rows is None or any((rows[name] != first).any() for name, first in lengths)):
            raise ValueError(f"it is cut off, or the rows of its element {element.name} differ in length, which is understood "
                             "in text alone: cut its faces into triangles, or save it as text (ASCII)")
        begin = end
