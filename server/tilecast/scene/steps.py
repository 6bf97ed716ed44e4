"""Transforms as the scene format has them: steps in order, or one matrix. What they mean is in
`transforms`."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field, field_validator
from typing_extensions import TypeAliasType

from .fields import Coordinate, Matrix, Model, Vector, choice, fault, list_or_inline


def _number_or_list(value: Any) -> str:
    return "~list" if isinstance(value, list) else "~number"


def _step_kind(value: Any) -> str:
    if isinstance(value, Model):
        return "~" + next(iter(type(value).model_fields))
    keys = [key for key in ("translate", "scale", "rotate", "matrix") if key in value] if isinstance(value, dict) else []
    return "~" + keys[0] if keys else "~unknown"


def _transform_kind(value: Any) -> str:
    return "~matrix" if isinstance(value, list) and value and isinstance(value[0], list) else "~steps"


class Translate(Model):
    """Moves by a vector, in metres."""
    translate: Vector


class Scale(Model):
    """Scales about the origin: by one factor, or by one for each axis. Negative factors mirror."""
    scale: choice(_number_or_list, number=Coordinate, list=Vector)

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
    rotate: choice(list_or_inline, list=Vector, inline=AxisAngle)


class MatrixStep(Model):
    """Multiplies by a matrix."""
    matrix: Matrix


Step = TypeAliasType("Step", choice(_step_kind, translate=Translate, scale=Scale, rotate=Rotate, matrix=MatrixStep))
Transform = TypeAliasType("Transform", Annotated[
    choice(_transform_kind, steps=list[Step], matrix=Matrix),
    Field(description="Steps applied in order, or one 4 x 4 matrix.")])
