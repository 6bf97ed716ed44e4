"""The house has floors: includes and imports run downward only."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CORE = ROOT / "core"
PACKAGE = ROOT / "server" / "tilecast"

# Lowest first. The benchmarks look at everything and nothing looks at them.
CORE_FLOORS = ["base", "optics", "geometry", "accel", "scene", "shading", "integrators", "render", "stress", "images", "bind", "bench"]
# Parts on one floor do not know each other. The package's own __init__.py is the facade over `render`.
PACKAGE_FLOORS = [{"_core", "_images"}, {"scene"}, {"render"}, {"jobs", "report", "__init__"}, {"api", "cli"}, {"__main__"}]

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^">]+)[">]', re.MULTILINE)


def core_files() -> list[Path]:
    return sorted(path for path in CORE.rglob("*") if path.suffix in {".h", ".cpp"})


def core_edges(path: Path, text: str) -> list[tuple[str, str]]:
    """(floor of the file, floor of each core header that it includes)."""
    own = path.relative_to(CORE).parts[0]
    edges = []
    for mark, name in INCLUDE.findall(text):
        beside, below = (path.parent / name).resolve(), CORE / name
        header = beside if mark == '"' and beside.is_file() else below
        if header.is_file():
            edges.append((own, header.relative_to(CORE).parts[0]))
    return edges


def package_edges(path: Path, text: str) -> list[tuple[str, str]]:
    """(part of the file, part of the package that each of its imports names), at any depth of the file."""
    inside = path.relative_to(PACKAGE)
    own = inside.parts[0].removesuffix(".py")
    package = ["tilecast", *inside.parts[:-1]]
    edges = []
    for node in ast.walk(ast.parse(text, str(path))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            module = ".".join([*base, *filter(None, [node.module])])
            # `from tilecast import scene` names a part; `from tilecast import load` the facade.
            names = [f"{module}.{alias.name}" if module == "tilecast" else module for alias in node.names]
        else:
            continue
        edges += [(own, part_of(name)) for name in names if name.split(".")[0] == "tilecast"]
    return edges


def part_of(name: str) -> str:
    parts = name.split(".")
    known = set().union(*PACKAGE_FLOORS)
    return parts[1] if len(parts) > 1 and parts[1] in known else "__init__"


def floor(part: str) -> int:
    return next(index for index, parts in enumerate(PACKAGE_FLOORS) if part in parts)


def test_core_includes_run_downward():
    upward = []
    for path in core_files():
        for own, other in core_edges(path, path.read_text()):
            if CORE_FLOORS.index(other) > CORE_FLOORS.index(own):
                upward.append(f"{path.relative_to(ROOT)}: {own} includes {other}")
    assert core_files() and not upward, "\n".join(upward)


def test_core_below_the_bindings_knows_no_python():
    guilty = [
        str(path.relative_to(ROOT))
        for path in core_files()
        if path.relative_to(CORE).parts[0] not in {"bind", "bench"}
        and any(name.startswith(("pybind11", "Python.h")) for _, name in INCLUDE.findall(path.read_text()))
    ]
    assert not guilty


def test_package_imports_run_downward():
    upward = []
    for path in sorted(PACKAGE.rglob("*.py")):
        for own, other in package_edges(path, path.read_text()):
            if own != other and floor(other) >= floor(own):
                upward.append(f"{path.relative_to(ROOT)}: {own} imports {other}")
    assert not upward, "\n".join(upward)


@pytest.mark.parametrize(
    ("line", "part"),
    [
        ("import tilecast.api.app", "api"),
        ("from tilecast.api import app", "api"),
        ("from tilecast import api", "api"),
        ("from .. import api", "api"),
        ("from ..api.app import make", "api"),
        ("def f():\n    from tilecast import load", "__init__"),
    ],
)
def test_an_upward_import_is_seen_in_every_form(line, part):
    assert package_edges(PACKAGE / "scene" / "compile.py", line) == [("scene", part)]


def test_an_upward_include_is_seen():
    header = next((CORE / "accel").glob("*.h"))
    assert core_edges(CORE / "base" / "ray.h", f'#include "accel/{header.name}"') == [("base", "accel")]
    assert core_edges(CORE / "base" / "ray.h", f'#include "../accel/{header.name}"') == [("base", "accel")]
