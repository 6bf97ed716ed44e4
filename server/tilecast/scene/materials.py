"""Materials as the scene format has them."""

from __future__ import annotations

from typing import Annotated, Literal
from typing import Union as OneOf

from pydantic import Field
from typing_extensions import TypeAliasType

from .fields import Colour, Fraction, Model, Name, Positive, Radiance, choice, list_or_inline, name_or_inline


class Checker(Model):
    """Cubes of two colours in turn, in the object's own space."""
    type: Literal["checker"]
    even: Colour
    odd: Colour
    size: Positive = 1.0
    """The side of a cube, metres."""


Reflectance = TypeAliasType("Reflectance", choice(list_or_inline, list=Colour, inline=Checker))


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
    OneOf[Diffuse, Mirror, Conductor, Dielectric], Field(discriminator="type")])
MaterialChoice = TypeAliasType("MaterialChoice", choice(name_or_inline, name=Name, inline=Material))
