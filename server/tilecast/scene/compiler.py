"""From a checked scene to the core's: loads the meshes, hands every object over once, and places it."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import _core
from . import checks, images, meshes, schema, transforms
from .appearance import Appearance, uses_uvs
from .core_errors import at
from .errors import SceneError
from .lighting import add_light, core_camera
from .loader import Loader
from .mesh_files import OpenFile
from .parsing import collector_paused
from .views import shown_as

Path = checks.Path

_PLACEMENTS = (schema.Reference, schema.AreaLight)
_IDENTITY = np.eye(4)
_INHERIT = -1  # the material of a placement that names none
_GREY = schema.Diffuse(type="diffuse")  # the material of what has none at all


@dataclass(frozen=True)
class Compiled:
    """A scene that is ready to be rendered, or to be asked about rays. Immutable; threads may share it."""

    scene: _core.Scene
    document: schema.Scene
    seconds: dict[str, float]
    """Wall time: "load" (reading files) and "compile" (all else)."""

    @property
    def closest(self) -> Callable[..., Any]:
        """closest(origins, directions, t_min=0, t_max=inf): the first hit of each ray; float64 [n, 3] each. Its
        own help says all."""
        return self.scene.closest

    @property
    def occluded(self) -> Callable[..., Any]:
        """occluded(origins, directions, t_min=0, t_max=inf): whether each ray hits anything; bool [n]."""
        return self.scene.occluded

    @property
    def crossings(self) -> Callable[..., Any]:
        """crossings(origins, directions): all entries and exits along each whole line, sorted."""
        return self.scene.crossings

    def facts(self) -> dict[str, Any]:
        """What the statistics of a job say about its scene, as plain JSON values."""
        used = list(self.scene.features)
        shown = shown_as(self.scene, self.document)
        return {"seconds": dict(self.seconds),
                "accelerator": dict(self.scene.accelerator),
                "features": {"used": used, "left_out": [name for name in _core.FEATURES if name not in used]},
                "kernel": self.scene.kernel,
                "primitives": self.scene.primitives,
                **({"error_leaves_out": ["contrast"]} if self.document.render.contrast else {}),
                **({"shown": shown} if shown else {})}


def compile(scene: schema.Scene, open_file: OpenFile, max_triangles: int | None = None) -> Compiled:
    """Builds the immutable core scene. `open_file` gives the bytes of a mesh file (see `folder_opener`); the
    errors of files, meshes and geometry are SceneErrors at the object that they belong to. `max_triangles`:
    how many all meshes may have together, before instances multiply them."""
    start = time.perf_counter()
    work = _Compiler(scene, open_file, max_triangles)
    with collector_paused():
        core = work.run()
    load = work.loader.seconds
    seconds = {"load": load, "compile": time.perf_counter() - start - load}
    return Compiled(core, scene, seconds)


@dataclass(frozen=True)
class _Placed:
    """An object that the core has, with the transform and material that belong to it."""
    handle: int
    matrix: np.ndarray
    material: int


class _Compiler:
    def __init__(self, scene: schema.Scene, open_file: OpenFile, max_triangles: int | None):
        self.scene = scene
        self.loader = Loader(open_file)
        self.max_triangles = max_triangles
        self.triangles = 0
        self.builder = _core.SceneBuilder()
        self.appearance = Appearance(scene, self.builder, self.loader)
        self.with_uvs = uses_uvs([material for _, material in checks.materials(scene, checks.walk(scene))])
        self.named: dict[str, _Placed] = {}
        self.files: dict[str, meshes.Triangles] = {}
        self.mesh_paths: dict[int, Path] = {}

    def run(self) -> _core.Scene:
        scene, builder = self.scene, self.builder
        lights = [(("lights", index), light) for index, light in enumerate(scene.lights)]
        area = [(path, light) for path, light in lights if isinstance(light, schema.AreaLight)]
        seen = [(("scene", index), node) for index, node in enumerate(scene.scene)]
        for name in self._needed([*seen, *area]):
            path = ("objects", name)
            self.named[name] = self._place([(path, scene.objects[name])])[0]

        placed = self._place([*seen, *area])
        materials = [node.material for node in placed[:len(seen)]] + [self._shine(light) for _, light in area]
        if _INHERIT in materials:
            grey = self.appearance.material(("scene",), _GREY)
            materials = [grey if material == _INHERIT else material for material in materials]
        with at((), of=[path for path, _ in (*seen, *area)]):
            root = builder.group(*_arrays(placed, materials), accelerator=self._accelerator(None))
        for handle in builder.without_uvs(root) if self.with_uvs else ():
            raise SceneError(self.mesh_paths[handle], "has no texture coordinates, but its material has a texture that "
                                                      "asks for them: give the mesh uvs, or the material other textures")
        for path, light in lights:
            with at(path):
                add_light(builder, light)
        self._background()
        with at(("camera",)):
            builder.camera(core_camera(scene.camera, scene.image))
        builder.filter(scene.image.filter)
        settings = scene.render
        reach = {} if settings.ao_distance is None else {"ao_distance": settings.ao_distance}
        with at(()):
            return builder.build(root, integrator=settings.integrator, max_depth=settings.max_depth,
                                 seed=settings.seed, next_event=settings.next_event, sampler=settings.sampler,
                                 roulette=settings.roulette, contrast=settings.contrast or 0.0, **reach)

    def _needed(self, roots: Sequence[tuple[Path, Any]]) -> list[str]:
        """The names that `roots` use, each after all that it uses itself. Without recursion: chains may be
        long."""
        order: list[str] = []
        started: set[str] = set()
        stack = [(name, False) for path, node in reversed(roots) for _, name in checks.uses(path, node)]
        while stack:
            name, ready = stack.pop()
            if ready:
                order.append(name)
            elif name not in started:
                started.add(name)
                stack.append((name, True))
                stack.extend((inner, False) for _, inner in checks.uses(("objects", name), self.scene.objects[name]))
        return order

    def _place(self, nodes: Sequence[tuple[Path, Any]]) -> list[_Placed]:
        """Compiles placements (references, objects in place, area lights), all their transforms at once. A
        reference's transform comes after its object's own; of the two materials the object's own, the inner
        one, counts."""
        inner = self._inner(nodes)
        matrices = transforms.matrices([node.transform for _, node in nodes])
        combined = transforms.product(matrices, np.array([found.matrix for found in inner]).reshape(-1, 4, 4))
        for index, message in transforms.problems(combined):
            raise SceneError((*nodes[index][0], "transform"), f"with those of the object that it places: {message}")
        return [_Placed(found.handle, matrix, found.material if found.material != _INHERIT else self._own(path, node))
                for (path, node), found, matrix in zip(nodes, inner, combined)]

    def _own(self, path: Path, node: Any) -> int:
        material = getattr(node, "material", None)  # an area light has none here
        return _INHERIT if material is None else self.appearance.material((*path, "material"), material)

    def _inner(self, nodes: Sequence[tuple[Path, Any]]) -> list[_Placed]:
        """What each node places, before its own transform."""
        in_place = [((*path, "object"), node.object) for path, node in nodes
                    if isinstance(node, _PLACEMENTS) and not isinstance(node.object, str)]
        placed = iter(self._place(in_place) if in_place else ())
        found = []
        for path, node in nodes:
            if not isinstance(node, _PLACEMENTS):
                found.append(_Placed(self._object(path, node), _IDENTITY, _INHERIT))
            else:
                found.append(self.named[node.object] if isinstance(node.object, str) else next(placed))
        return found

    def _accelerator(self, kind: str | None) -> _core.Accelerator:
        render = self.scene.render
        return _core.Accelerator(kind or render.accelerator, render.grouping, render.reinsertion)

    def _object(self, path: Path, node: Any) -> int:
        """Hands one object to the core; its handle."""
        builder, accelerator = self.builder, self._accelerator(getattr(node, "accelerator", None))
        match node:
            case schema.Mesh():
                mesh = self._mesh(path, node)
                self.triangles += len(mesh.faces)
                if self.max_triangles is not None and self.triangles > self.max_triangles:
                    raise SceneError(path, f"brings the scene to {self.triangles:,} triangles, more than the "
                                           f"{self.max_triangles:,} that are allowed here")
                with at(path):
                    handle = builder.mesh(mesh.vertices, mesh.faces, accelerator=accelerator, uvs=mesh.uvs)
                self.mesh_paths[handle] = path
                return handle
            case schema.Group() | schema.Union() | schema.Intersection() | schema.Difference():
                arrays = _arrays(placed := self._operands(path, node), [child.material for child in placed])
                with at(path):
                    if node.type == "group":
                        return builder.group(*arrays, accelerator=accelerator)
                    return builder.csg(node.type, *arrays)
        with at(path):
            match node:
                case schema.Sphere():
                    return builder.sphere(node.radius)
                case schema.Box(radius=None):
                    return builder.box(node.min, node.max)
                case schema.Box():
                    return builder.rounded_box(node.min, node.max, node.radius)
                case schema.Cylinder():
                    return builder.cylinder(node.radius, node.height)
                case schema.Cone():
                    return builder.cone(node.radius, node.top_radius, node.height)
                case schema.Capsule():
                    return builder.capsule(node.radius, node.height)
                case schema.Torus():
                    return builder.torus(node.radius, node.minor_radius)
                case schema.Quadric():
                    return builder.quadric(node.coefficients, node.min, node.max)
                case schema.Halfspace():
                    return builder.halfspace(node.normal, node.offset)
                case schema.Rectangle():
                    return builder.rectangle(*node.size)
                case schema.Disk():
                    return builder.disk(node.radius)
        raise TypeError(f"no way to compile a {type(node).__name__}")

    def _operands(self, path: Path, node: Any) -> list[_Placed]:
        return self._place([((*path, "of", index), child) for index, child in enumerate(node.of)])

    def _background(self) -> None:
        background = self.scene.background
        with at(("background",)):
            match background:
                case schema.ImageBackground():
                    with self.loader.file(background.file, ("background", "file")) as data:
                        pixels = images.load(data, background.file)
                        with np.errstate(over="ignore"):  # the core refuses infinity
                            pixels *= np.float32(background.scale)
                        self.builder.environment(pixels, background.rotation)
                case schema.SkyBackground():
                    sky = background
                    self.builder.sky(sky.sun_direction, sky.turbidity, sky.ground, sky.scale)
                case _:
                    self.builder.background(background)

    def _mesh(self, path: Path, node: schema.Mesh) -> meshes.Triangles:
        if node.file is None:
            vertices, faces = np.array(node.vertices, np.float64), np.array(node.faces, np.uint32)
            uvs = None
            if self.with_uvs and node.uvs is not None:
                uvs = np.array(node.uvs, np.float32)[faces if node.uv_faces is None else np.array(node.uv_faces, np.uint32)]
            return meshes.Triangles(vertices.reshape(-1, 3), faces.reshape(-1, 3), uvs)
        if node.file not in self.files:
            with self.loader.file(node.file, (*path, "file")) as data:
                self.files[node.file] = meshes.load(data, node.file, self.with_uvs, self.max_triangles)
        return self.files[node.file]

    def _shine(self, light: schema.AreaLight) -> int:
        """The material of an area light: black, and it emits."""
        black = schema.Diffuse(type="diffuse", reflectance=[0.0, 0.0, 0.0], emission=light.radiance)
        return self.appearance.material(("lights",), black)


def _arrays(placed: Sequence[_Placed], materials: Sequence[int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Placements as the core takes them: int32 [n], float64 [n, 4, 4], int32 [n]."""
    return (np.array([node.handle for node in placed], np.int32),
            np.array([node.matrix for node in placed], np.float64).reshape(-1, 4, 4),
            np.array(materials, np.int32))
