"""Lights and backgrounds as the scene format has them."""

from __future__ import annotations

from typing import Annotated, Literal
from typing import Union as OneOf

from pydantic import Field, field_validator, model_validator
from typing_extensions import TypeAliasType

from .fields import Colour, Direction, ImageFile, Model, Radiance, Vector, choice, fault, list_or_inline
from .objects import ObjectChoice
from .steps import Transform

Angle = Annotated[float, Field(ge=0, le=180)]


class PointLight(Model):
    """Shines equally in all directions from one point."""
    type: Literal["point"]
    position: Vector
    intensity: Radiance
    """Radiant intensity, watts a steradian."""


class SpotLight(Model):
    """Shines into a cone from one point: fully up to the inner angle, then less and less up to the outer one."""
    type: Literal["spot"]
    position: Vector
    target: Vector | None = None
    """A point on the cone's axis; instead of a direction."""
    direction: Direction | None = None
    """Of the cone's axis, of any length; instead of a target."""
    intensity: Radiance
    """Radiant intensity along the axis, watts a steradian."""
    outer_angle: Angle = 45.0
    """Degrees from the axis to where it is dark."""
    inner_angle: Angle = 0.0
    """Degrees from the axis up to which it shines fully."""

    @model_validator(mode="after")
    def _points_somewhere(self):
        if (self.target is None) == (self.direction is None):
            raise fault("needs either a target or a direction")
        if self.target == self.position:
            raise fault("must differ from position: the light points nowhere", "target")
        if self.inner_angle > self.outer_angle:
            raise fault(f"must be at most outer_angle = {self.outer_angle:g}, got {self.inner_angle:g}", "inner_angle")
        return self


class DirectionalLight(Model):
    """Parallel light from infinitely far away, such as the sun's."""
    type: Literal["directional"]
    direction: Direction
    """In which the light goes; of any length."""
    irradiance: Radiance
    """On a surface that the light meets head on, watts a square metre."""


class AreaLight(Model):
    """An object that shines from its surface and reflects nothing."""
    type: Literal["area"]
    object: ObjectChoice
    radiance: Radiance
    transform: Transform | None = None


Light = TypeAliasType("Light", Annotated[
    OneOf[PointLight, SpotLight, DirectionalLight, AreaLight], Field(discriminator="type")])


class ImageBackground(Model):
    """Light from all around, from an equirectangular image: +y along its upper edge, -z in the middle, +x to the right
    of that. Values below 0 count as 0."""
    type: Literal["image"]
    file: ImageFile
    """A file beside the scene (EXR, HDR, PNG, JPEG); on a server an uploaded asset, sha256:<64 hex digits>.<extension>.
    Those of a PNG or JPEG are taken for sRGB."""
    rotation: Annotated[float, Field(ge=-1e6, le=1e6)] = 0.0
    """Degrees about +y, counter-clockwise as seen from above."""
    scale: Annotated[float, Field(ge=0, le=1e20)] = 1.0
    """Factor from the image's values to radiance."""


class SkyBackground(Model):
    """The clear sky by day (Preetham, Shirley and Smits 1999), without the sun itself, which is a directional light."""
    type: Literal["sky"]
    sun_direction: Direction = [0.0, 1.0, 0.0]
    """Towards the sun, not below the horizon; of any length."""
    turbidity: Annotated[float, Field(ge=2, le=10)] = 3.0
    """Haze: 2 is very clear, 10 is misty."""
    ground: Colour = [0.2, 0.2, 0.2]
    """Reflectance of the ground, which is what lies below the horizon; the sky lights it."""
    scale: Annotated[float, Field(ge=0, le=1e20)] = 0.1
    """Radiance for each 1,000 candela a square metre. A clear sky has about 5,000."""

    @field_validator("sun_direction")
    @classmethod
    def _by_day(cls, direction):
        if direction[1] < 0:
            raise fault(f"must not be below the horizon: at least 0, got {direction[1]:g}", 1)
        return direction


Background = TypeAliasType("Background", choice(list_or_inline, list=Radiance, inline=Annotated[
    OneOf[ImageBackground, SkyBackground], Field(discriminator="type")]))
