"""The scene format, as pydantic models: the only place that says what a scene may hold, with `steps`
(transforms), `materials` and `fields` (numbers and unions), whose models are names of this module too.

y up, right-handed, metres, degrees, linear RGB. Unknown keys are errors. Lists stand for vectors and colours,
so that the JSON Schema made from these models stays plain. What needs more than one model to be judged
(names, cycles, transforms that are singular only as a product) is in `checks`.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal
from typing import Union as OneOf  # Union is a kind of object here

from pydantic import BeforeValidator, Field, field_validator, model_validator
from pydantic.json_schema import GenerateJsonSchema
from typing_extensions import TypeAliasType

from .fields import (
    SMALLEST, Coordinate, Integer, Model, Name, NotNegative, Positive, Radiance, Vector, choice, fault, name_or_inline,
    whole)
from .geometry import check_faces, check_file
from .materials import Checker, Conductor, Dielectric, Diffuse, Material, MaterialChoice, Mirror
from .steps import AxisAngle, MatrixStep, Rotate, Scale, Step, Transform, Translate


def _placement_kind(value: Any) -> str:
    reference = isinstance(value, Reference) or (isinstance(value, dict) and "object" in value)
    return "~reference" if reference else "~inline"


# --- Objects

Accelerator = Literal["auto", "none", "bvh", "sbvh", "grid", "grid-two-level", "octree", "octree-balanced", "bsp",
                      "bsp-median"]
Grouping = Literal["sah", "sah-sweep", "median", "middle", "morton"]


class _Object(Model):
    transform: Transform | None = None
    material: MaterialChoice | None = None
    """A name under `materials`, or a material. Of several around each other, the innermost counts."""


class Sphere(_Object):
    """A ball about the origin."""
    type: Literal["sphere"]
    radius: Positive


class _Boxed(_Object):
    min: Vector
    max: Vector

    @model_validator(mode="after")
    def _not_empty(self):
        for axis, (low, high) in enumerate(zip(self.min, self.max)):
            if not low < high:
                raise fault(f"must be greater than min[{axis}] = {low:g}, got {high:g}", "max", axis)
        return self


class Box(_Boxed):
    """A box along the axes."""
    type: Literal["box"]
    radius: Positive | None = None
    """Rounds edges and corners off: at most half the shortest side."""

    @model_validator(mode="after")
    def _room_to_round(self):
        most = min(high - low for low, high in zip(self.min, self.max)) / 2
        if self.radius is not None and self.radius > most:
            raise fault(f"must be at most half the shortest side, {most:g}, got {self.radius:g}", "radius")
        return self


class Cylinder(_Object):
    """A closed cylinder about the y axis, centred at the origin."""
    type: Literal["cylinder"]
    radius: Positive
    height: Positive


class Cone(_Object):
    """A closed cone about the y axis, centred at the origin; with a `top_radius` its frustum."""
    type: Literal["cone"]
    radius: NotNegative
    """Of the bottom."""
    top_radius: NotNegative = 0.0
    height: Positive

    @model_validator(mode="after")
    def _not_a_line(self):
        if self.radius == self.top_radius == 0:
            raise fault("must be positive where top_radius is 0, got 0", "radius")
        return self


class Capsule(_Object):
    """All that lies within `radius` of a segment of the y axis, centred at the origin."""
    type: Literal["capsule"]
    radius: Positive
    height: Positive
    """Of the cylindrical part; over all it is two radii more."""


class Torus(_Object):
    """A ring about the y axis, centred at the origin."""
    type: Literal["torus"]
    radius: Positive
    """From the axis to the middle of the tube."""
    minor_radius: Positive
    """Of the tube."""

    @model_validator(mode="after")
    def _a_ring(self):
        if self.minor_radius > self.radius:
            raise fault(f"must be at most radius = {self.radius:g}, got {self.minor_radius:g}", "minor_radius")
        return self


class Quadric(_Boxed):
    """Where a polynomial of second degree is negative, within a box along the axes."""
    type: Literal["quadric"]
    coefficients: Annotated[list[Coordinate], Field(min_length=10, max_length=10)]
    """Of x^2, y^2, z^2, xy, xz, yz, x, y, z and 1."""

    @field_validator("coefficients")
    @classmethod
    def _a_surface(cls, coefficients):
        largest = max(map(abs, coefficients[:9]))
        if largest == 0:
            raise fault("must not all be 0 but for the last: that is no surface")
        if largest < SMALLEST:
            raise fault(f"must have one of at least {SMALLEST:g} before the last, got {largest:g}")
        return coefficients


class Halfspace(_Object):
    """All that lies below a plane. It has no end, so it is for CSG: intersect it with something that has, or
    subtract it."""
    type: Literal["halfspace"]
    normal: Vector
    """Away from the inside; of any length."""
    offset: Coordinate = 0.0
    """Of the plane from the origin, along the normal, metres."""

    @field_validator("normal")
    @classmethod
    def _a_direction(cls, normal):
        if max(map(abs, normal)) < SMALLEST:
            raise fault(f"must have a component of at least {SMALLEST:g}" if any(normal) else "must not be [0, 0, 0]")
        return normal


class Rectangle(_Object):
    """A flat rectangle in the plane y = 0, centred at the origin; its normal is +y."""
    type: Literal["rectangle"]
    size: Annotated[list[Positive], Field(min_length=2, max_length=2)]
    """Along x and along z, metres."""


class Disk(_Object):
    """A flat disk in the plane y = 0, centred at the origin; its normal is +y."""
    type: Literal["disk"]
    radius: Positive


class Mesh(_Object):
    """Triangles: from a file, or `vertices` and `faces` in place."""
    type: Literal["mesh"]
    file: str | None = None
    """A file beside the scene (PLY, OBJ, STL, GLB); on a server an uploaded asset, sha256:<64 hex
    digits>.<extension>."""
    vertices: list[Vector] | None = None
    faces: list[Annotated[list[Integer], Field(min_length=3, max_length=3)]] | None = None
    """Three indices into `vertices`, counter-clockwise as seen from outside."""
    accelerator: Accelerator | None = None

    @field_validator("file")
    @classmethod
    def _file(cls, file):
        problem = check_file(file) if file is not None else None
        if problem:
            raise fault(problem)
        return file

    @model_validator(mode="after")
    def _one_source(self):
        if (self.file is None) == (self.vertices is None):
            raise fault("needs either a file or vertices and faces")
        if (self.vertices is None) != (self.faces is None):
            raise fault("vertices and faces belong together")
        if self.vertices is not None:
            problem = check_faces(self.vertices, self.faces)
            if problem:
                raise fault(problem[1], *problem[0])
        return self


class _Csg(_Object):
    of: Annotated[list[Placement], Field(min_length=2)]


class Union(_Csg):
    """All that is inside any of the operands, which are closed."""
    type: Literal["union"]


class Intersection(_Csg):
    """What is inside all of the operands, which are closed."""
    type: Literal["intersection"]


class Difference(_Csg):
    """What is inside the first operand and outside all others. All are closed."""
    type: Literal["difference"]


class Group(_Object):
    """Objects placed together; placed again as one."""
    type: Literal["group"]
    of: list[Placement]
    accelerator: Accelerator | None = None


Object = TypeAliasType("Object", Annotated[
    OneOf[Sphere, Box, Cylinder, Cone, Capsule, Torus, Quadric, Halfspace, Rectangle, Disk, Mesh, Union, Intersection,
          Difference, Group],
    Field(discriminator="type")])
ObjectChoice = TypeAliasType("ObjectChoice", choice(name_or_inline, name=Name, inline=Object))


class Reference(Model):
    """An object, by its name under `objects` or in place, put somewhere with a material."""
    object: ObjectChoice
    transform: Transform | None = None
    material: MaterialChoice | None = None


Placement = TypeAliasType("Placement", choice(_placement_kind, reference=Reference, inline=Object))


# --- Lights, camera, settings

class PointLight(Model):
    """Shines equally in all directions from one point."""
    type: Literal["point"]
    position: Vector
    intensity: Radiance
    """Radiant intensity, watts a steradian."""


class AreaLight(Model):
    """An object that shines from its surface and reflects nothing."""
    type: Literal["area"]
    object: ObjectChoice
    radiance: Radiance
    transform: Transform | None = None


Light = TypeAliasType("Light", Annotated[OneOf[PointLight, AreaLight], Field(discriminator="type")])


class Perspective(Model):
    """A pinhole camera."""
    type: Literal["perspective"] = "perspective"
    position: Vector
    target: Vector
    up: Vector = [0.0, 1.0, 0.0]
    fov: Annotated[float, Field(gt=0, lt=180)] = 40.0
    """Degrees across the image's height."""

    @model_validator(mode="after")
    def _looks_somewhere(self):
        if self.position == self.target:
            raise fault("must differ from position: the camera looks nowhere", "target")
        if not any(self.up):
            raise fault("must not be [0, 0, 0]", "up")
        view = [t - p for t, p in zip(self.target, self.position)]
        if _parallel(view, self.up):
            raise fault("must not be parallel to the viewing direction", "up")
        return self


def _parallel(a: list[float], b: list[float]) -> bool:
    """Whether the angle between two vectors is too small (below 1e-9) to span a plane."""
    a, b = ([x / max(map(abs, v)) for x in v] for v in (a, b))
    cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    return max(map(abs, cross)) < 1e-9


class Image(Model):
    width: whole(1, 16384) = 640
    height: whole(1, 16384) = 480
    filter: Literal["box"] = "box"


class Stop(Model):
    """Ends the render early, at whichever comes first."""
    relative_mse: Positive | None = None
    """Stop at the first checkpoint at which the relative mean squared error is surely (97.5%) below this."""
    seconds: Positive | None = None
    """Start nothing new after this time; every pixel gets its first samples all the same."""


class Render(Model):
    integrator: Literal["path", "whitted", "normals", "depth", "primitives", "instances", "facing",
                        "cost"] = "path"
    """Light: path (all of it) or whitted (direct light, mirrors and glass). Or a view of what a camera ray meets,
    black where that is nothing: normals (0.5 + 0.5 n; outward, world space), depth (metres along the ray),
    primitives and instances (a colour for each), facing (front sides blue, back sides red), cost (steps through the
    accelerator and primitives tested). Samples of a view are averaged like any others; with one sample nothing is
    blended. An EXR holds the numbers; a PNG holds those of normals too, and shows depth and cost by a ramp of
    colours, see view_range."""
    view_range: Annotated[list[Coordinate], Field(min_length=2, max_length=2)] | None = None
    """Which depths a PNG shows from bright to black, or which costs from black to bright; if not given, the depths
    of the box around the scene, and costs from 0 to 256."""
    samples: whole(1, 2**24) = 64
    """For each pixel."""
    max_depth: whole(1, 10000) = 8
    """Path segments from the camera: 1 shows only what shines by itself."""
    accelerator: Accelerator = "auto"
    """For triangles in meshes and for objects in groups. All give the same image; auto picks by expected cost."""
    grouping: Grouping = "sah"
    """What a bvh groups: by surface area heuristic over bins or over every place (sah-sweep), as many on each side
    (median), at the middle, or along a Morton curve."""
    reinsertion: bool = False
    """Improve a bvh after it is built, by taking nodes out and putting them where they cost least."""
    seed: whole(0, 2**32 - 1) = 0
    stop: Stop = Stop()
    next_event: bool = True
    """Sample lights directly. Without it the path integrator finds them by chance: the same image, with more
    noise."""

    @field_validator("view_range")
    @classmethod
    def _rises(cls, view_range):
        if view_range is not None and not view_range[0] < view_range[1]:
            raise fault(f"must be greater than the first, {view_range[0]:g}, got {view_range[1]:g}", 1)
        return view_range


def _no_boolean(value: Any) -> Any:
    if isinstance(value, bool):  # Python takes true for 1
        raise fault(f"must be 1, got {str(value).lower()}")
    return value


class Scene(Model):
    """A scene and how to render it."""
    version: Annotated[Literal[1], BeforeValidator(_no_boolean)] = 1
    camera: Perspective
    image: Image = Image()
    render: Render = Render()
    materials: dict[Name, Material] = {}
    objects: dict[Name, Object] = {}
    scene: list[Reference] = []
    """What is seen. Empty renders the background."""
    lights: list[Light] = []
    background: Radiance = [0.0, 0.0, 0.0]
    """Radiance where a ray hits nothing."""


for _model in (Union, Intersection, Difference, Group, Reference, AreaLight, Scene):
    _model.model_rebuild()


class _Schema(GenerateJsonSchema):
    """Without a title for every field, which would only repeat its key."""

    def field_title_should_be_set(self, schema) -> bool:
        return False


def json_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a scene."""
    schema = Scene.model_json_schema(schema_generator=_Schema)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": "Tilecast scene"}
