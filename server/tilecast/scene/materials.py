"""Materials as the scene format has them."""

from __future__ import annotations

from typing import Annotated, Literal
from typing import Union as OneOf

from pydantic import Field, model_validator
from typing_extensions import TypeAliasType

from .fields import (
    Colour, Fraction, Model, Name, Radiance, choice, fault, list_of, list_or_inline, name_or_inline, whole)
from .metals import METALS
from .textures import Checker, EmissionImage, Gradient, NormalMap, Reflectance, Scalar


Index = TypeAliasType("Index", list_of(
    Annotated[float, Field(ge=1e-3, le=1e3)], 3, "Of refraction: for red, green, blue."))
Extinction = TypeAliasType("Extinction", list_of(
    Annotated[float, Field(ge=0, le=1e3)], 3, "Coefficients: for red, green, blue."))
CoatIndex = Annotated[float, Field(ge=1, le=1e3)]


Emission = TypeAliasType("Emission", choice(list_or_inline, list=Radiance, inline=EmissionImage))


class _Material(Model):
    emission: Emission = [0.0, 0.0, 0.0]
    """Radiance that leaves the side to which the surface's normal points."""
    opacity: Scalar = 1.0
    """Part of the light that meets the surface; the rest goes straight on, as through a fine net, and its path has no
    segment more. By a texture, shapes are cut out."""
    normal_map: NormalMap | None = None
    """Bends the normal that light is scattered about. What would be scattered into the surface is lost."""


class Diffuse(_Material):
    """Reflects light equally in all directions; where it is rough, as plaster or clay, more of it back to where it
    came from (Oren and Nayar's model, in its energy-preserving form)."""
    type: Literal["diffuse"]
    reflectance: Reflectance = [0.8, 0.8, 0.8]
    roughness: Scalar = 0.0


class Mirror(_Material):
    """Reflects light in one direction."""
    type: Literal["mirror"]
    reflectance: Reflectance = [1.0, 1.0, 1.0]


class Conductor(_Material):
    """A metal, polished or rough: `reflectance` says how much it reflects straight back, or `metal` which one it is,
    or `eta` and `k` its complex index of refraction."""
    type: Literal["conductor"]
    reflectance: Reflectance = [0.9, 0.9, 0.9]
    metal: Literal[tuple(METALS)] | None = None
    eta: Index | None = None
    """Real part of the index of refraction over that of what is around, for red, green and blue."""
    k: Extinction | None = None
    """Its imaginary part."""
    roughness: Scalar = 0.0
    """0: polished; the alpha of GGX's distribution is its square."""

    @model_validator(mode="after")
    def _one_colour(self):
        if (self.eta is None) != (self.k is None):
            given, other = ("k", "eta") if self.eta is None else ("eta", "k")
            raise fault(f"needs {other} as well", given)
        given = [name for name in ("reflectance", "metal", "eta") if name in self.model_fields_set
                 and getattr(self, name) is not None]
        if len(given) > 1:
            raise fault(f"says the same as {given[0]}: give one of them", given[1])
        return self

    def index(self) -> tuple[list[float], list[float]] | None:
        """Of refraction: real and imaginary part; None where the reflectance is given."""
        return METALS[self.metal] if self.metal else (self.eta, self.k) if self.eta else None


class Dielectric(_Material):
    """Glass, water: reflects and refracts."""
    type: Literal["dielectric"]
    ior: Annotated[float, Field(ge=1e-3, le=1e3)] = 1.5
    """Index of refraction of the inside over vacuum."""
    abbe: Annotated[float, Field(ge=1, le=1e6)] | None = None
    """Abbe's number, by which white light is split into colours: crown glass 60, flint 30, diamond 55; the less, the more.
    For polished surfaces and the path integrator; others take the index as it is."""
    roughness: Fraction = 0.0
    """0: polished; the alpha of GGX's distribution is its square."""
    absorption: Radiance = [0.0, 0.0, 0.0]
    """Part of the light that is lost inside: exp(-absorption x metres) goes on."""
    priority: whole(-1000, 1000) = 0
    """Where dielectrics overlap, the one of highest priority fills the place, as if the others were cut out there;
    of equal ones the one that the light entered last. Let a drink reach into its glass, and give the glass the
    higher priority."""

    @model_validator(mode="after")
    def _splits_at_polished_surfaces(self):
        if self.abbe is not None and self.roughness > 0:
            raise fault(f"is for polished surfaces alone, got a roughness of {self.roughness:g}", "abbe")
        return self


class Plastic(_Material):
    """Pigment under a clear coat: plastic, varnished wood, glazed clay."""
    type: Literal["plastic"]
    reflectance: Reflectance = [0.8, 0.8, 0.8]
    """Of the pigment."""
    ior: CoatIndex = 1.5
    """Index of refraction of the coat over that of what is around."""
    roughness: Scalar = 0.0
    """Of the coat's surface. 0: polished; the alpha of GGX's distribution is its square."""


class Phong(_Material):
    """Phong's model of 1975, normalised so that no light is made: diffuse, and a highlight about the mirrored
    direction."""
    type: Literal["phong"]
    reflectance: Reflectance = [0.6, 0.6, 0.6]
    """Of the diffuse part."""
    specular: Colour = [0.3, 0.3, 0.3]
    """Of the highlight; with the diffuse part at most 1."""
    exponent: Annotated[float, Field(ge=0, le=1e6)] = 40.0
    """The higher, the smaller and brighter the highlight."""

    @model_validator(mode="after")
    def _not_more_than_all(self):
        match self.reflectance:
            case list():
                colours = [self.reflectance]
            case Checker():
                colours = [self.reflectance.even, self.reflectance.odd]
            case Gradient():
                colours = [self.reflectance.start, self.reflectance.end]
            case _:
                return self  # the core sees the image's pixels
        for channel, specular in enumerate(self.specular):
            most = max(colour[channel] for colour in colours)
            if most + specular > 1 + 1e-12:
                raise fault(f"must be at most 1 together with the reflectance {most:g}, got {specular:g}",
                            "specular", channel)
        return self


class Principled(_Material):
    """The metallic-roughness model of glTF 2.0: a metal, plastic and glass, mixed."""
    type: Literal["principled"]
    base_color: Reflectance = [0.8, 0.8, 0.8]
    """Of the metal's reflection, of the plastic's pigment, and of what goes through the glass's surface."""
    metallic: Fraction = 0.0
    """How much of it is metal."""
    roughness: Scalar = 0.5
    transmission: Fraction = 0.0
    """How much of what is no metal is glass instead of plastic."""
    ior: CoatIndex = 1.5

    @model_validator(mode="after")
    def _glass_of_one_roughness(self):
        if self.transmission > 0 and self.metallic < 1 and isinstance(self.roughness, Model):
            raise fault("must be a number where transmission is above 0: glass takes no texture here", "roughness")
        return self


class Blend(_Material):
    """Two materials at one place, in shares: dirt on glass, rust on iron."""
    type: Literal["blend"]
    of: Annotated[list[BlendPart], Field(min_length=2, max_length=2)]
    """Names under `materials`, or materials, which are no blends or principled themselves. At most one is a
    dielectric. Emission and opacity belong to the blend."""
    weight: Fraction = 0.5
    """The share of the second."""


_Plain = Annotated[OneOf[Diffuse, Mirror, Conductor, Dielectric, Plastic, Phong], Field(discriminator="type")]
BlendPart = TypeAliasType("BlendPart", choice(name_or_inline, name=Name, inline=_Plain))
Material = TypeAliasType("Material", Annotated[
    OneOf[Diffuse, Mirror, Conductor, Dielectric, Plastic, Phong, Principled, Blend], Field(discriminator="type")])
MaterialChoice = TypeAliasType("MaterialChoice", choice(name_or_inline, name=Name, inline=Material))
