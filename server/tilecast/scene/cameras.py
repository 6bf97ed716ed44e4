"""Cameras as the scene format has them."""

from __future__ import annotations

from typing import Annotated, Any, Literal
from typing import Union as OneOf

from pydantic import BeforeValidator, Field, model_validator
from typing_extensions import TypeAliasType

from .fields import Model, NotNegative, Positive, Vector, fault

FieldOfView = Annotated[float, Field(gt=0, lt=180, description="Degrees across the image's height.")]


class _Camera(Model):
    position: Vector
    target: Vector
    up: Vector = [0.0, 1.0, 0.0]

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


class Perspective(_Camera):
    """A pinhole camera."""
    type: Literal["perspective"] = "perspective"
    fov: FieldOfView = 40.0


class Orthographic(_Camera):
    """Parallel rays: everything in its size, however far away. What lies behind `position` is not seen."""
    type: Literal["orthographic"]
    height: Positive
    """Metres across the image's height."""


class ThinLens(_Camera):
    """A camera with a lens: what is not at the distance of focus is blurred."""
    type: Literal["thin-lens"]
    fov: FieldOfView = 40.0
    aperture: NotNegative
    """The lens's radius, metres; 0 is a pinhole."""
    focus_distance: Positive
    """Metres from `position` along the line of sight to the plane that is sharp."""


class Panorama(_Camera):
    """All directions, equirectangular: `target` in the middle, `up` along the upper edge. Twice as wide as high shows
    them undistorted."""
    type: Literal["panorama"]


def _with_type(value: Any) -> Any:
    return {"type": "perspective", **value} if isinstance(value, dict) and "type" not in value else value


Camera = TypeAliasType("Camera", Annotated[
    OneOf[Perspective, Orthographic, ThinLens, Panorama], Field(discriminator="type"), BeforeValidator(_with_type)])
