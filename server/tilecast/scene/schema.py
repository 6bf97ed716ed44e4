"""The scene format, as pydantic models: the only place that says what a scene may hold, with `objects`, `materials`,
`lights`, `cameras`, `steps` (transforms) and `fields` (numbers and unions), whose models are names of this module too.

y up, right-handed, metres, degrees, linear RGB. Unknown keys are errors. Lists stand for vectors and colours,
so that the JSON Schema made from these models stays plain. What needs more than one model to be judged
(names, cycles, transforms that are singular only as a product) is in `checks`.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, field_validator, model_validator
from pydantic.json_schema import GenerateJsonSchema

from .cameras import Camera, Orthographic, Panorama, Perspective, ThinLens
from .fields import Coordinate, Model, Name, Positive, fault, whole
from .lights import (
    AreaLight, Background, DirectionalLight, ImageBackground, Light, PointLight, SkyBackground, SpotLight)
from .materials import (
    Blend, Conductor, Dielectric, Diffuse, Material, MaterialChoice, Mirror, Phong, Plastic, Principled)
from .objects import (
    Accelerator, Box, Capsule, Cone, Cylinder, Difference, Disk, Group, Grouping, Halfspace, Intersection, Mesh, Object,
    ObjectChoice, Placement, Quadric, Rectangle, Reference, Sphere, Torus, Union)
from .steps import AxisAngle, MatrixStep, Rotate, Scale, Step, Transform, Translate
from .textures import (
    Checker, EmissionImage, Gradient, ImageTexture, NormalMap, ScalarChecker, ScalarGradient, ScalarImage)

# --- Settings

class Image(Model):
    width: whole(1, 16384) = 640
    height: whole(1, 16384) = 480
    filter: Literal["box", "tent", "gaussian", "blackman-harris", "mitchell"] = "box"
    """How a pixel weighs what lies around its middle, along x and along y: box (half a pixel far), tent (one), gaussian
    (deviation half a pixel, ends at 2), blackman-harris (1.5), mitchell (2; sharpens, with weights below 0)."""


class Stop(Model):
    """Ends the render early, at whichever comes first."""
    relative_mse: Positive | None = None
    """Stop when the relative mean squared error is estimated to be below this, and surely (97.5%) below 1.5 times this.
    Looked at from 16 samples on: at powers of two, and up to eight times between two of them where the error is near
    this. An image whose error rests on rare bright samples (`heavy_tailed` in its statistics) cannot be sure of it, and
    goes on to `samples` or `seconds`. One without any noise may have met no light yet: where paths go on from what the
    camera sees, it takes 1024 samples first."""
    seconds: Positive | None = None
    """Start nothing new after this time; every pixel gets its first samples all the same."""


class Render(Model):
    integrator: Literal["path", "direct", "whitted", "ambient-occlusion", "normals", "depth", "primitives", "instances",
                        "facing", "cost"] = "path"
    """Light: path (all of it), direct (what shines, and what is lit by it) or whitted (direct light, mirrors and glass; a
    background of one colour is seen and mirrored, and lights nothing diffuse). Geometry: ambient-occlusion (which share of
    the hemisphere above a point is free, weighted by the cosine). Or a view of what a camera ray meets, black where that
    is nothing: normals (0.5 + 0.5 n; outward, world space), depth (metres along the ray), primitives and instances (a
    colour for each), facing (front sides blue, back sides red), cost (steps through the accelerator and primitives
    tested). Samples of a view are averaged like any others; with one sample nothing is blended. An EXR holds the numbers;
    a PNG holds those of normals too, and shows depth and cost by a ramp of colours, see view_range."""
    ao_distance: Positive | None = None
    """How far away ambient occlusion looks for what is in the way, metres; if not given, to infinity."""
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
    adaptive: bool = False
    """Take samples where the relative error is; `samples` is then their mean over the image. Decided by tiles and what
    is around them, at fixed counts of samples. Light that fewer than one sample in a thousand meets comes out too dark:
    tiles that have met none of it yet get fewer samples (0.87 of it at one in 4096)."""
    next_event: bool = True
    """Sample lights directly. Without it the path integrator finds them by chance: the same image, with more
    noise."""
    sampler: Literal["sobol", "independent"] = "sobol"
    """Where in each pixel, lens and light the samples lie: scrambled Sobol points, which are spread evenly, or
    independent ones, with more noise."""
    roulette: bool = True
    """End paths that carry little at random, and weigh the others up: the same image in less time, with more noise for
    each sample."""
    contrast: Positive | None = None
    """Adaptive antialiasing of the whitted integrator: where the first two samples of a pixel and of the eight around it
    differ by at most this, as a part of their mean and 0.1 more, those two stand for all from the eighth on. 0.1 leaves
    edges their samples; what is so small that none of these hits it is lost. The estimated error leaves out what is
    skipped: it may be less than half of the true one (`error_leaves_out` in the statistics), so it can end no render."""

    @field_validator("view_range")
    @classmethod
    def _rises(cls, view_range):
        if view_range is not None and not view_range[0] < view_range[1]:
            raise fault(f"must be greater than the first, {view_range[0]:g}, got {view_range[1]:g}", 1)
        return view_range

    @model_validator(mode="after")
    def _is_deterministic(self):
        if self.contrast is not None and self.integrator != "whitted":
            raise fault(f"is for the whitted integrator alone, got {self.integrator}: what is noisy is nowhere alike",
                        "contrast")
        if self.contrast is not None and self.stop.relative_mse is not None:
            raise fault("cannot be had together with render.contrast: the estimated error leaves out what that skips",
                        "stop", "relative_mse")
        return self


def _no_boolean(value: Any) -> Any:
    if isinstance(value, bool):  # Python takes true for 1
        raise fault(f"must be 1, got {str(value).lower()}")
    return value


class Scene(Model):
    """A scene and how to render it."""
    version: Annotated[Literal[1], BeforeValidator(_no_boolean)] = 1
    camera: Camera
    image: Image = Image()
    render: Render = Render()
    materials: dict[Name, Material] = {}
    objects: dict[Name, Object] = {}
    scene: list[Reference] = []
    """What is seen. Empty renders the background."""
    lights: list[Light] = []
    background: Background = [0.0, 0.0, 0.0]
    """Radiance where a ray hits nothing: the same all around, an image, or a sky."""


Scene.model_rebuild()  # once, here: not by threads at the same time


class _Schema(GenerateJsonSchema):
    """Without a title for every field, which would only repeat its key."""

    def field_title_should_be_set(self, schema) -> bool:
        return False


def json_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a scene."""
    schema = Scene.model_json_schema(schema_generator=_Schema)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": "Tilecast scene"}
