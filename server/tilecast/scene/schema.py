"""The scene format, as pydantic models: the only place that says what a scene may hold.

y up, right-handed, metres, degrees, linear RGB. Unknown keys are errors. Lists stand for vectors and colours, so that
the JSON Schema made from these models stays plain. What needs more than one model to be judged (names, cycles,
transforms that are singular only as a product) is in `checks`.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, Union

from pydantic import (BaseModel, BeforeValidator, ConfigDict, Discriminator, Field, StringConstraints, Tag,
                      field_validator, model_validator)
from pydantic.json_schema import GenerateJsonSchema
from pydantic_core import PydanticCustomError
from typing_extensions import TypeAliasType

from .geometry import check_faces, check_file


class Model(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False,
                              use_attribute_docstrings=True)


def fault(message: str, *at: str | int) -> PydanticCustomError:
    """An error for a validator to raise; `at` is the path below the model, where it is not the model itself."""
    return PydanticCustomError("fault", "{message}", {"message": message, "at": list(at)})


def _whole(value: Any) -> Any:
    """JSON knows one kind of number: 64.0 is an integer."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


# --- Numbers, vectors, colours. The bounds are the core's: within them no product of a few numbers overflows.

SMALLEST, LARGEST, BRIGHTEST = 1e-100, 1e100, 1e30

Positive = Annotated[float, Field(ge=SMALLEST, le=LARGEST)]
Coordinate = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
Fraction = Annotated[float, Field(ge=0, le=1)]
Integer = Annotated[int, BeforeValidator(_whole, json_schema_input_type=int)]
Name = Annotated[str, StringConstraints(min_length=1, max_length=200)]


def _list_of(item: Any, length: int, description: str) -> Any:
    return Annotated[list[item], Field(min_length=length, max_length=length, description=description)]


Vector = TypeAliasType("Vector", _list_of(Coordinate, 3, "x, y, z"))
Colour = TypeAliasType("Colour", _list_of(Fraction, 3, "Red, green, blue: linear, 0 to 1."))
Radiance = TypeAliasType("Radiance", _list_of(
    Annotated[float, Field(ge=0, le=BRIGHTEST)], 3, "Red, green, blue: linear, not negative."))
Matrix = TypeAliasType("Matrix", _list_of(
    _list_of(Coordinate, 4, "A row."), 4, "4 x 4, row-major, for column vectors; last row 0 0 0 1."))


# --- Unions. Where no `type` tells the members apart, a function of the value does. Its tags start with "~", so that
# --- no path in an error shows them (see parsing).

def _choice(choose, **members) -> Any:
    """The union of `members`, of which `choose(value)` tells by its tag which one `value` is meant to be."""
    return Annotated[Union[tuple(Annotated[member, Tag("~" + tag)] for tag, member in members.items())],
                     Discriminator(choose)]


def _name_or_inline(value: Any) -> str:
    return "~name" if isinstance(value, str) else "~inline"


def _number_or_list(value: Any) -> str:
    return "~list" if isinstance(value, list) else "~number"


def _list_or_inline(value: Any) -> str:
    return "~inline" if isinstance(value, (dict, Model)) else "~list"


def _step_kind(value: Any) -> str:
    if isinstance(value, Model):
        return "~" + next(iter(type(value).model_fields))
    keys = [key for key in ("translate", "scale", "rotate", "matrix") if key in value] if isinstance(value, dict) else []
    return "~" + keys[0] if keys else "~unknown"


def _transform_kind(value: Any) -> str:
    return "~matrix" if isinstance(value, list) and value and isinstance(value[0], list) else "~steps"


def _placement_kind(value: Any) -> str:
    reference = isinstance(value, Reference) or (isinstance(value, dict) and "object" in value)
    return "~reference" if reference else "~inline"


# --- Transforms

class Translate(Model):
    """Moves by a vector, in metres."""
    translate: Vector


class Scale(Model):
    """Scales about the origin: by one factor, or by one for each axis. Negative factors mirror."""
    scale: _choice(_number_or_list, number=Coordinate, list=Vector)

    @field_validator("scale")
    @classmethod
    def _not_flat(cls, scale):
        for axis, factor in enumerate(scale if isinstance(scale, list) else [scale]):
            if factor == 0:
                raise fault("must not be 0: the transform is singular and would flatten the object",
                            *([axis] if isinstance(scale, list) else []))
        return scale


class AxisAngle(Model):
    """A turn about an axis through the origin; counter-clockwise as seen from the axis' tip."""
    axis: Vector
    angle: float
    """Degrees."""

    @field_validator("axis")
    @classmethod
    def _has_direction(cls, axis):
        if not any(axis):
            raise fault("must not be [0, 0, 0]: it has no direction")
        return axis


class Rotate(Model):
    """Turns: about x, then y, then z, by these degrees; or about an axis."""
    rotate: _choice(_list_or_inline, list=Vector, inline=AxisAngle)


class MatrixStep(Model):
    """Multiplies by a matrix."""
    matrix: Matrix


Step = TypeAliasType("Step", _choice(_step_kind, translate=Translate, scale=Scale, rotate=Rotate, matrix=MatrixStep))
Transform = TypeAliasType("Transform", Annotated[
    _choice(_transform_kind, steps=list[Step], matrix=Matrix),
    Field(description="Steps applied in order, or one 4 x 4 matrix.")])


# --- Materials

class Checker(Model):
    """Cubes of two colours in turn, in the object's own space."""
    type: Literal["checker"]
    even: Colour
    odd: Colour
    size: Positive = 1.0
    """The side of a cube, metres."""


Reflectance = TypeAliasType("Reflectance", _choice(_list_or_inline, list=Colour, inline=Checker))


class _Material(Model):
    emission: Radiance = [0.0, 0.0, 0.0]
    """Radiance that leaves the side to which the surface's normal points."""


class Diffuse(_Material):
    """Reflects light equally in all directions."""
    type: Literal["diffuse"]
    reflectance: Reflectance = [0.8, 0.8, 0.8]


class Mirror(_Material):
    """Reflects light in one direction."""
    type: Literal["mirror"]
    reflectance: Reflectance = [1.0, 1.0, 1.0]


class Conductor(_Material):
    """A metal, polished or rough."""
    type: Literal["conductor"]
    reflectance: Reflectance = [0.9, 0.9, 0.9]
    roughness: Fraction = 0.0


class Dielectric(_Material):
    """Glass, water: reflects and refracts."""
    type: Literal["dielectric"]
    ior: Annotated[float, Field(ge=1e-3, le=1e3)] = 1.5
    """Index of refraction of the inside over the outside."""
    absorption: Radiance = [0.0, 0.0, 0.0]
    """Part of the light that is lost inside: exp(-absorption x metres) goes on."""


Material = TypeAliasType("Material", Annotated[
    Union[Diffuse, Mirror, Conductor, Dielectric], Field(discriminator="type")])
MaterialChoice = TypeAliasType("MaterialChoice", _choice(_name_or_inline, name=Name, inline=Material))


# --- Objects

Accelerator = Literal["auto", "none", "bvh"]


class _Object(Model):
    transform: Transform | None = None
    material: MaterialChoice | None = None
    """A name under `materials`, or a material. Of several around each other, the innermost counts."""


class Sphere(_Object):
    """A ball about the origin."""
    type: Literal["sphere"]
    radius: Positive


class Box(_Object):
    """A box along the axes."""
    type: Literal["box"]
    min: Vector
    max: Vector

    @model_validator(mode="after")
    def _not_empty(self):
        for axis, (low, high) in enumerate(zip(self.min, self.max)):
            if not low < high:
                raise fault(f"must be greater than min[{axis}] = {low:g}, got {high:g}", "max", axis)
        return self


class Cylinder(_Object):
    """A closed cylinder about the y axis, centred at the origin."""
    type: Literal["cylinder"]
    radius: Positive
    height: Positive


class Rectangle(_Object):
    """A flat rectangle in the plane y = 0, centred at the origin; its normal is +y."""
    type: Literal["rectangle"]
    size: Annotated[list[Positive], Field(min_length=2, max_length=2)]
    """Along x and along z, metres."""


class Mesh(_Object):
    """Triangles: from a file, or `vertices` and `faces` in place."""
    type: Literal["mesh"]
    file: str | None = None
    """A file beside the scene (PLY, OBJ, STL, GLB); on a server an uploaded asset, sha256:<64 hex digits>.<extension>."""
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


class Union_(_Csg):
    """All that is inside any of the operands, which are closed."""
    model_config = ConfigDict(title="Union")
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
    Union[Sphere, Box, Cylinder, Rectangle, Mesh, Union_, Intersection, Difference, Group],
    Field(discriminator="type")])
ObjectChoice = TypeAliasType("ObjectChoice", _choice(_name_or_inline, name=Name, inline=Object))


class Reference(Model):
    """An object, by its name under `objects` or in place, put somewhere with a material."""
    object: ObjectChoice
    transform: Transform | None = None
    material: MaterialChoice | None = None


Placement = TypeAliasType("Placement", _choice(_placement_kind, reference=Reference, inline=Object))


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


Light = TypeAliasType("Light", Annotated[Union[PointLight, AreaLight], Field(discriminator="type")])


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
    width: Annotated[Integer, Field(ge=1, le=16384)] = 640
    height: Annotated[Integer, Field(ge=1, le=16384)] = 480
    filter: Literal["box"] = "box"


class Stop(Model):
    """Ends the render early, at whichever comes first."""
    relative_mse: Positive | None = None
    """Stop at the first checkpoint at which the relative mean squared error is surely (97.5%) below this."""
    seconds: Positive | None = None
    """Start nothing new after this time; every pixel gets its first samples all the same."""


class Render(Model):
    integrator: Literal["path", "whitted"] = "path"
    samples: Annotated[Integer, Field(ge=1, le=2**24)] = 64
    """For each pixel."""
    max_depth: Annotated[Integer, Field(ge=1, le=10000)] = 8
    """Path segments from the camera: 1 shows only what shines by itself."""
    accelerator: Accelerator = "auto"
    seed: Annotated[Integer, Field(ge=0, le=2**32 - 1)] = 0
    stop: Stop = Stop()
    next_event: bool = True
    """Sample lights directly. Without it the path integrator finds them by chance: the same image, with more noise."""


class Scene(Model):
    """A scene and how to render it."""
    version: Literal[1] = 1
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


for _model in (Union_, Intersection, Difference, Group, Reference, AreaLight, Scene):
    _model.model_rebuild()


class _Schema(GenerateJsonSchema):
    """Without a title for every field, which would only repeat its key."""

    def field_title_should_be_set(self, schema) -> bool:
        return False


def json_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a scene."""
    schema = Scene.model_json_schema(schema_generator=_Schema)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": "Tilecast scene"}
