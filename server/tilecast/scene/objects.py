"""Objects as the scene format has them, and how they are placed."""

from __future__ import annotations

from typing import Annotated, Any, Literal
from typing import Union as OneOf  # Union is a kind of object here

from pydantic import Field, field_validator, model_validator
from typing_extensions import TypeAliasType

from .fields import (
    SMALLEST, Coordinate, Direction, Integer, MeshFile, Model, Name, NotNegative, Positive, Vector, choice, fault,
    list_of, name_or_inline)
from .geometry import check_faces, check_uvs
from .materials import MaterialChoice
from .steps import Transform


def _placement_kind(value: Any) -> str:
    reference = isinstance(value, Reference) or (isinstance(value, dict) and "object" in value)
    return "~reference" if reference else "~inline"


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
    normal: Direction
    """Away from the inside; of any length."""
    offset: Coordinate = 0.0
    """Of the plane from the origin, along the normal, metres."""


class Rectangle(_Object):
    """A flat rectangle in the plane y = 0, centred at the origin; its normal is +y."""
    type: Literal["rectangle"]
    size: Annotated[list[Positive], Field(min_length=2, max_length=2)]
    """Along x and along z, metres."""


class Disk(_Object):
    """A flat disk in the plane y = 0, centred at the origin; its normal is +y."""
    type: Literal["disk"]
    radius: Positive


TextureCoordinates = TypeAliasType("TextureCoordinates", list_of(
    Annotated[float, Field(ge=-1e6, le=1e6)], 2, "u to the right, v upwards: from 0 to 1 over an image."))


class Mesh(_Object):
    """Triangles: from a file, or `vertices` and `faces` in place."""
    type: Literal["mesh"]
    file: MeshFile | None = None
    """A file beside the scene (PLY, OBJ, STL, GLB); on a server an uploaded asset, sha256:<64 hex
    digits>.<extension>."""
    vertices: list[Vector] | None = None
    faces: list[Annotated[list[Integer], Field(min_length=3, max_length=3)]] | None = None
    """Three indices into `vertices`, counter-clockwise as seen from outside."""
    uvs: list[TextureCoordinates] | None = None
    """Texture coordinates, for `vertices` and `faces` in place; a file brings its own. They only matter to textures: the
    mesh is the same along seams."""
    uv_faces: list[Annotated[list[Integer], Field(min_length=3, max_length=3)]] | None = None
    """For each face three indices into `uvs`. If not given, those of `faces`."""
    accelerator: Accelerator | None = None

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
        problem = check_uvs(self.vertices, self.faces, self.uvs, self.uv_faces)
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
