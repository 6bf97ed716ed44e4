"""Views hold numbers, not light: how a screen is to show them."""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import _core
from . import schema

COST_RANGE = (0.0, 256.0)  # one for all accelerators, so that their pictures can be compared
_FARTHEST = 1e30  # metres, that the core writes


def shown_as(core: _core.Scene, document: schema.Scene) -> dict[str, Any] | None:
    """{"view": "normals"}; {"view": "depth" or "cost", "range": [first, last]}, the values at the ends of a ramp of
    colours; None where the integrator gives colours of its own. Known before the first sample, so that all tiles
    agree. See `render.display`."""
    view = document.render.integrator
    if view == "normals":
        return {"view": view}
    if view in ("depth", "cost"):
        return {"view": view, "range": list(document.render.view_range or (
            COST_RANGE if view == "cost" else _distances(core.bounds, document.camera)))}
    return None


def _distances(bounds: np.ndarray | None, camera: schema.Camera) -> tuple[float, float]:
    """From a camera to the nearest and to the farthest point of a box, along its rays, metres."""
    if bounds is None:
        return 0.0, 1.0
    position = np.array(camera.position)
    if isinstance(camera, schema.Orthographic):
        ahead = (camera.target - position) / np.linalg.norm(camera.target - position)
        along = [float(np.where(ahead > 0, a, b) @ ahead) for a, b in ((bounds[0], bounds[1]), (bounds[1], bounds[0]))]
        return tuple(min(max(distance - float(position @ ahead), 0.0), _FARTHEST) for distance in along)
    near = np.clip(position, *bounds) - position
    far = np.abs(bounds - position).max(axis=0)
    return tuple(min(float(np.linalg.norm(offset)), _FARTHEST) for offset in (near, far))
