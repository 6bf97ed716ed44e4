"""What the models of the scene format are made of: numbers, vectors, colours, and unions without a `type`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Annotated, Any
from typing import Union as OneOf

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Discriminator, Field, StringConstraints, Tag
from pydantic_core import PydanticCustomError
from typing_extensions import TypeAliasType

from .geometry import IMAGES, MESHES, check_file


class Model(BaseModel):
    model_config = ConfigDict(defer_build=True, extra="forbid", strict=True, frozen=True, allow_inf_nan=False,
                              use_attribute_docstrings=True)


def fault(message: str, *at: str | int) -> PydanticCustomError:
    """An error for a validator to raise; `at` is the path below the model, where it is not the model
    itself."""
    return PydanticCustomError("fault", "{message}", {"message": message, "at": list(at)})


def _whole(value: Any) -> Any:
    """JSON knows one kind of number: 64.0 is an integer."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


# --- Numbers, vectors, colours. The bounds are the core's: within them no product of a few numbers overflows.

SMALLEST, LARGEST, BRIGHTEST = 1e-100, 1e100, 1e30

Positive = Annotated[float, Field(ge=SMALLEST, le=LARGEST)]
NotNegative = Annotated[float, Field(ge=0, le=LARGEST)]
Coordinate = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
Fraction = Annotated[float, Field(ge=0, le=1)]
Integer = Annotated[int, BeforeValidator(_whole)]
Name = Annotated[str, StringConstraints(min_length=1, max_length=200)]


def _file_name(formats: Sequence[str]) -> Any:
    def checked(file: str) -> str:
        if problem := check_file(file, formats):
            raise fault(problem)
        return file

    return Annotated[str, AfterValidator(checked)]


MeshFile, ImageFile = _file_name(MESHES), _file_name(IMAGES)


def whole(low: int, high: int) -> Any:
    """An integer from `low` to `high`."""
    return Annotated[int, Field(ge=low, le=high), BeforeValidator(_whole)]  # in this order, for the JSON Schema's sake


def list_of(item: Any, length: int, description: str) -> Any:
    return Annotated[list[item], Field(min_length=length, max_length=length, description=description)]


Vector = TypeAliasType("Vector", list_of(Coordinate, 3, "x, y, z"))
Colour = TypeAliasType("Colour", list_of(Fraction, 3, "Red, green, blue: linear, 0 to 1."))
Radiance = TypeAliasType("Radiance", list_of(
    Annotated[float, Field(ge=0, le=BRIGHTEST)], 3, "Red, green, blue: linear, not negative."))
Matrix = TypeAliasType("Matrix", list_of(
    list_of(Coordinate, 4, "A row."), 4, "4 x 4, row-major, for column vectors; last row 0 0 0 1."))


def _not_zero(direction: list[float]) -> list[float]:
    if max(map(abs, direction)) < SMALLEST:
        raise fault(f"must have a component of at least {SMALLEST:g}" if any(direction) else "must not be [0, 0, 0]")
    return direction


Direction = Annotated[Vector, AfterValidator(_not_zero)]


# --- Unions. Where no `type` tells the members apart, a function of the value does. Its tags start with "~",
# --- so that no path in an error shows them (see parsing).

def choice(choose: Callable[[Any], str], **members: Any) -> Any:
    """The union of `members`, of which `choose(value)` tells by its tag which one `value` is meant to be."""
    return Annotated[OneOf[tuple(Annotated[member, Tag("~" + tag)] for tag, member in members.items())],
                     Discriminator(choose)]


def name_or_inline(value: Any) -> str:
    return "~name" if isinstance(value, str) else "~inline"


def list_or_inline(value: Any) -> str:
    return "~inline" if isinstance(value, (dict, Model)) else "~list"
