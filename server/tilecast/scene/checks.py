"""What no single model can judge: names that are not there, objects that contain themselves, singular
transforms."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator, Mapping
from itertools import chain, islice
from typing import Any

from . import schema, transforms
from .errors import SceneError
from .paths import Part, text

Path = tuple[Part, ...]

_CSG = (schema.Union, schema.Intersection, schema.Difference)
_MOST_ERRORS = 100
_MOST_COMPARED = 200  # names, with one that is not known
_THIN = {schema.Rectangle: "box", schema.Disk: "cylinder"}  # what is open, and the solid to take for it


def walk(scene: schema.Scene) -> Iterator[tuple[Path, Any]]:
    """Every placement, object and area light of a scene with its path: under `objects`, in `scene`, in
    `lights`."""
    for name, node in scene.objects.items():
        yield from below(("objects", name), node)
    for index, node in enumerate(scene.scene):
        yield from below(("scene", index), node)
    for index, node in enumerate(scene.lights):
        if isinstance(node, schema.AreaLight):
            yield from below(("lights", index), node)


def materials(scene: schema.Scene, nodes: Iterable[tuple[Path, Any]]) -> Iterator[tuple[Path, Any]]:
    """Every material with its path: under `materials`, and in place at nodes of `walk`."""
    for name, material in scene.materials.items():
        yield ("materials", name), material
    for path, node in nodes:
        material = getattr(node, "material", None)
        if material is not None and not isinstance(material, str):
            yield (*path, "material"), material


def below(path: Path, node: Any) -> Iterator[tuple[Path, Any]]:
    """`node` and all placements and objects written inside it; names are not followed."""
    yield path, node
    if isinstance(node, (*_CSG, schema.Group)):
        for index, child in enumerate(node.of):
            yield from below((*path, "of", index), child)
    elif isinstance(node, (schema.Reference, schema.AreaLight)) and not isinstance(node.object, str):
        yield from below((*path, "object"), node.object)


def check(scene: schema.Scene) -> None:
    """Raises SceneError, with all that is wrong with names, transforms and operands, in the order of the
    document."""
    nodes = list(walk(scene))
    for stage in ((_names(scene, nodes), _blends(scene, nodes), _transforms(nodes)), (_cycles(scene),),
                  (_operands(scene, nodes), _area_lights(scene, nodes))):
        if errors := [(text(path), message) for path, message in islice(chain(*stage), _MOST_ERRORS)]:
            raise SceneError(*errors[0], errors=errors)


def _names(scene: schema.Scene, nodes: list[tuple[Path, Any]]) -> Iterator[tuple[Path, str]]:
    for path, node in nodes:
        if isinstance(getattr(node, "object", None), str) and node.object not in scene.objects:
            yield (*path, "object"), _unknown(node.object, scene.objects, "object", "objects")
        if isinstance(getattr(node, "material", None), str) and node.material not in scene.materials:
            yield (*path, "material"), _unknown(node.material, scene.materials, "material", "materials")


def _blends(scene: schema.Scene, nodes: list[tuple[Path, Any]]) -> Iterator[tuple[Path, str]]:
    """What a blend takes: names that are there, of materials that are no mixtures, shine and let through nothing by
    themselves, and one dielectric at most."""
    for path, material in materials(scene, nodes):
        if not isinstance(material, schema.Blend):
            continue
        parts = [scene.materials.get(part) if isinstance(part, str) else part for part in material.of]
        for index, (given, part) in enumerate(zip(material.of, parts)):
            at = (*path, "of", index)
            if part is None:
                yield at, _unknown(given, scene.materials, "material", "materials")
            elif isinstance(part, (schema.Blend, schema.Principled)):
                yield at, f"is a {part.type}: a blend takes materials that are no mixtures themselves"
            elif isinstance(part.emission, schema.Model) or any(part.emission) or part.opacity != 1:
                yield at, "shines or lets light through: emission and opacity belong to the blend"
            elif part.normal_map is not None:
                yield (*at, "normal_map"), "belongs to the blend, not to the materials that it takes"
        if all(isinstance(part, schema.Dielectric) for part in parts):
            yield (*path, "of", 1), "is a second dielectric: what is inside of a blend can be of one kind alone"


def _unknown(name: str, known: Mapping[str, Any], what: str, where: str) -> str:
    close = difflib.get_close_matches(name[:100], known, n=1) if len(known) <= _MOST_COMPARED else []
    listed = [text([key]) for key in known]
    if close:
        hint = f"did you mean {text(close)}?"
    elif len(listed) > 8:
        hint = f"{where} holds {len(listed)} others"
    else:
        hint = f"{where} holds {', '.join(listed)}" if listed else f"{where} is empty"
    return f"names the unknown {what} {text([name])}; {hint}"


def _transforms(nodes: list[tuple[Path, Any]]) -> Iterator[tuple[Path, str]]:
    placed = [(path, node.transform) for path, node in nodes if getattr(node, "transform", None)]
    if placed:
        for index, message in transforms.problems(transforms.matrices([transform for _, transform in placed])):
            yield (*placed[index][0], "transform"), message


def uses(path: Path, node: Any) -> Iterator[tuple[Path, str]]:
    """The names of objects that `node` uses, each with the path of the key that names it."""
    for at, inner in below(path, node):
        if isinstance(getattr(inner, "object", None), str):
            yield (*at, "object"), inner.object


def _cycles(scene: schema.Scene) -> Iterator[tuple[Path, str]]:
    """The first object that contains itself. Depth-first without recursion: chains of names may be long."""
    done: set[str] = set()
    for root in scene.objects:
        chain = [root]
        pending = [uses(("objects", root), scene.objects[root])] if root not in done else []
        open_names = {root}
        while pending:
            path, name = next(pending[-1], (None, None))
            if path is None:
                pending.pop()
                finished = chain.pop()
                open_names.discard(finished)
                done.add(finished)
            elif name in open_names:
                loop = [*chain[chain.index(name):], name]
                shown = loop if len(loop) <= 8 else [*loop[:6], "...", loop[-1]]
                yield path, f"the object contains itself: {' -> '.join(text([part]) for part in shown)}"
                return
            elif name not in done:
                chain.append(name)
                open_names.add(name)
                pending.append(uses(("objects", name), scene.objects[name]))


def resolve(scene: schema.Scene, node: Any) -> Any:
    """The object that a placement stands for, through all names."""
    while True:
        if isinstance(node, str):
            node = scene.objects[node]
        elif isinstance(node, (schema.Reference, schema.AreaLight)):
            node = node.object
        else:
            return node


def _operands(scene: schema.Scene, nodes: list[tuple[Path, Any]]) -> Iterator[tuple[Path, str]]:
    for path, node in nodes:
        if isinstance(node, _CSG):
            for index, operand in enumerate(node.of):
                placed = resolve(scene, operand)
                if type(placed) in _THIN:
                    solid = _THIN[type(placed)]
                    yield ((*path, "of", index), f"a {placed.type} is open and has no inside: a {node.type} takes "
                                                 f"closed objects (use a thin {solid})")


def _area_lights(scene: schema.Scene, nodes: list[tuple[Path, Any]]) -> Iterator[tuple[Path, str]]:
    # The innermost material counts everywhere else; a light whose object keeps its own material would not
    # shine.
    for path, node in nodes:
        if isinstance(node, schema.AreaLight) and getattr(resolve(scene, node), "material", None) is not None:
            yield (*path, "object"), "has a material of its own, but an area light brings its own: leave it out there"
