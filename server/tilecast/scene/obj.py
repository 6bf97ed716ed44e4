"""OBJ files as trimesh reads them rightly."""

from __future__ import annotations

import re

_UNTIDY = re.compile(rb"[\t#]|^ |\\\r?$", re.MULTILINE)
_BACKWARDS = re.compile(rb"^f [^\n]*-", re.MULTILINE)
_FEW = re.compile(rb"^f(?: +[^\s]+){0,2} *\r?$", re.MULTILINE)
_ZERO = re.compile(rb"^f [^\n]*?(?<= )[+-]?0+(?=[/\s]|$)", re.MULTILINE)


def tidy_obj(data: bytes) -> bytes:
    """The same mesh in the form that trimesh knows: lines that begin with their keyword, blanks between words, and vertices
    counted from the first. Raises `ValueError`, with the line, where a face names vertex 0, which trimesh takes for the
    last, or has fewer than three corners, which it leaves out.
    """
    data = data.removeprefix(b"\xef\xbb\xbf")  # a byte order mark
    if _UNTIDY.search(data):
        data = re.sub(rb"\\\r?\n", b" ", data).replace(b"\t", b" ")
        data = re.sub(rb"#[^\n]*|^ +", b"", data, flags=re.MULTILINE)
    if line := _ZERO.search(data):
        raise ValueError(f"line {data.count(10, 0, line.start()) + 1} names vertex 0, but they count from 1")
    if line := _FEW.search(data):
        raise ValueError(f"line {data.count(10, 0, line.start()) + 1} is a face of fewer than three corners")
    return _forwards(data) if _BACKWARDS.search(data) else data


def _forwards(data: bytes) -> bytes:
    """Negative numbers count back from the face's line; trimesh counts them from the end of the file."""
    count = {b"v": 0, b"vt": 0, b"vn": 0}
    lines = data.split(b"\n")
    for i, line in enumerate(lines):
        words = line.split()
        if not words:
            continue
        if words[0] in count:
            count[words[0]] += 1
        elif words[0] == b"f" and b"-" in line:
            corners = [zip(corner.split(b"/"), count.values()) for corner in words[1:]]
            lines[i] = b" ".join([b"f", *(b"/".join(_absolute(*number, i) for number in corner) for corner in corners)])
    return b"\n".join(lines)


def _absolute(number: bytes, count: int, line: int) -> bytes:
    if not number.startswith(b"-"):
        return number
    found = count + 1 + int(number)
    if found < 1:
        raise ValueError(f"line {line + 1} counts back beyond the first vertex")
    return b"%d" % found
