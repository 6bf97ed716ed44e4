"""Lights and cameras as the core takes them."""

from __future__ import annotations

from .. import _core
from . import schema


def add_light(builder: _core.SceneBuilder, light: schema.Light) -> None:
    """Hands a light over; an area light is an object and comes with those."""
    match light:
        case schema.PointLight():
            builder.point_light(light.position, light.intensity)
        case schema.SpotLight():
            direction = light.direction or [t - p for t, p in zip(light.target, light.position)]
            builder.spot_light(light.position, direction, light.intensity, light.inner_angle, light.outer_angle)
        case schema.DirectionalLight():
            builder.directional_light(light.direction, light.irradiance)


def core_camera(camera: schema.Camera, image: schema.Image) -> _core.Camera:
    view = _core.View(camera.position, camera.target, camera.up, image.width, image.height)
    match camera:
        case schema.Orthographic():
            return _core.Camera.orthographic(view, camera.height)
        case schema.ThinLens():
            return _core.Camera.thin_lens(view, camera.fov, camera.aperture, camera.focus_distance)
        case schema.Panorama():
            return _core.Camera.panorama(view)
    return _core.Camera.perspective(view, camera.fov)
