"""Textures as the scene format has them: colours and numbers that change over a surface."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal
from typing import Union as OneOf

from pydantic import Field, field_validator
from typing_extensions import TypeAliasType

from .fields import Colour, Coordinate, Fraction, ImageFile, Model, Positive, choice, fault, list_of, list_or_inline

_Factor = Annotated[float, Field(ge=-1e6, le=1e6)]
_Pair = TypeAliasType("UV", list_of(_Factor, 2, "For u and for v."))


class _Checker(Model):
    type: Literal["checker"]
    size: Positive = 1.0
    """The side of a cell: metres, or of the texture coordinates."""
    space: Literal["object", "uv"] = "object"
    """Cubes in the object's own space, or squares of its texture coordinates."""


class Checker(_Checker):
    """Cells of two colours in turn."""
    even: Colour
    odd: Colour


class ScalarChecker(_Checker):
    """Cells of two numbers in turn."""
    even: Fraction
    odd: Fraction


class _Gradient(Model):
    type: Literal["gradient"]
    along: Literal["x", "y", "z", "u", "v"] = "v"
    """x, y, z: in the object's own space, metres; u, v: texture coordinates."""
    range: Annotated[list[Coordinate], Field(min_length=2, max_length=2)] = [0.0, 1.0]
    """Where it starts and where it ends; before and after, it does not change."""

    @field_validator("range")
    @classmethod
    def _goes_somewhere(cls, range):
        if range[0] == range[1]:
            raise fault(f"must be another number than the first, got {range[1]:g}", 1)
        return range


class Gradient(_Gradient):
    """From one colour to another."""
    start: Colour
    end: Colour


class ScalarGradient(_Gradient):
    """From one number to another."""
    start: Fraction
    end: Fraction


class _Image(Model):
    type: Literal["image"]
    file: ImageFile
    """A file beside the scene (PNG, JPEG, EXR, HDR); on a server an uploaded asset, sha256:<64 hex
    digits>.<extension>."""
    wrap: Literal["repeat", "mirror", "clamp"] = "repeat"
    """What lies beyond the image: the image again, in a mirror, or the pixels of its edge."""
    filter: Literal["bilinear", "closest"] = "bilinear"
    """Between the centres of pixels: interpolated, or the pixel's own value."""
    tiling: _Pair = [1.0, 1.0]
    """How many times the image stands side by side where u and v go from 0 to 1."""
    offset: _Pair = [0.0, 0.0]
    """Added to u and v after that: the image moves left and down."""


class ImageTexture(_Image):
    """Colours from an image. Texture coordinates (0, 0) are its lower left corner, (1, 1) its upper right one."""
    colour_space: Literal["auto", "srgb", "linear"] = "auto"
    """Of the file's values; auto: srgb for PNG and JPEG, linear for EXR and HDR."""


class EmissionImage(ImageTexture):
    """Radiance from an image. What shines by it is met by chance alone, so that small ones make noise."""
    factor: Annotated[float, Field(ge=0, le=1e20)] = 1.0
    """From the image's values to radiance."""


class ScalarImage(_Image):
    """Numbers from one channel of an image."""
    channel: Literal["r", "g", "b", "a"] | None = None
    """If not given: for opacity the alpha channel, if there is one; else the first."""
    colour_space: Literal["srgb", "linear"] = "linear"
    """Of the file's values: numbers are mostly stored as they are."""


class NormalMap(_Image):
    """Normals from an image, x along u and y along v: red, green and blue from 0 to 1 stand for x, y and z from -1 to 1,
    so that (0.5, 0.5, 1) is the surface's own."""


Texture = Annotated[OneOf[Checker, Gradient, ImageTexture], Field(discriminator="type")]
ScalarTexture = Annotated[OneOf[ScalarChecker, ScalarGradient, ScalarImage], Field(discriminator="type")]
Reflectance = TypeAliasType("Reflectance", choice(list_or_inline, list=Colour, inline=Texture))


def _number_or_inline(value: Any) -> str:
    return "~inline" if isinstance(value, (dict, Model)) else "~number"


Scalar = TypeAliasType("Scalar", choice(_number_or_inline, number=Fraction, inline=ScalarTexture))


def textures(material: Model) -> Iterator[tuple[tuple[str | int, ...], Model]]:
    """The textures of a material with their paths in it, those of a blend's materials in place among them."""
    for name in type(material).model_fields:
        value = getattr(material, name)
        if isinstance(value, (_Checker, _Gradient, _Image)):
            yield (name,), value
    for index, part in enumerate(getattr(material, "of", ())):
        if isinstance(part, Model):
            yield from (((("of", index, *path)), texture) for path, texture in textures(part))


def asks_for_uv(texture: Model) -> bool:
    """Whether it needs texture coordinates."""
    if isinstance(texture, _Checker):
        return texture.space == "uv"
    return isinstance(texture, _Image) or texture.along in "uv"
