"""Calls about pictures and what is known of their quality. All are served as the job stands, whatever its state."""

from typing import Annotated, Literal

from anyio import CapacityLimiter, to_thread
from fastapi import APIRouter, Path, Request, Response

from tilecast.api.access import Manager
from tilecast.api.conditions import caching, not_modified, unchanged
from tilecast.api.jobs import JobId
from tilecast.api.problems import not_found
from tilecast.api.views import etag
from tilecast.jobs.records import Job

router = APIRouter(prefix="/v1/jobs/{job_id}", tags=["pictures"])

# An EXR may wait for workers to make its layers: few at a time, so that other calls find threads.
_layering = CapacityLimiter(8)

_TYPES = {"png": "image/png", "exr": "image/x-exr", "f16": "application/octet-stream"}


def _content(*formats: str) -> dict:
    binary = {"schema": {"type": "string", "format": "binary"}}
    return {200: {"content": {_TYPES[name]: binary for name in formats}}}


@router.get("/tiles")
def tiles(job_id: JobId, manager: Manager) -> dict:
    """Sizes and versions of all tiles. A version counts the sample ranges that are in; 0 is still black."""
    return manager.tiles(job_id)


@router.get("/tiles/{column}/{row}.{format}", response_class=Response, responses=_content("png", "f16"))
def tile(
    job_id: JobId,
    column: Annotated[int, Path(ge=0, le=16384)],
    row: Annotated[int, Path(ge=0, le=16384)],
    format: Literal["png", "f16"],
    request: Request,
    manager: Manager,
) -> Response:
    """One tile: PNG, or f16: row-major RGB, linear, little-endian half floats."""
    job = manager.job(job_id)
    version = manager.images.tile_version(job, column, row)
    if version is None:
        raise not_found(f"tile in column {column}, row {row} of this job")
    tag = _tag(job, f'"{job.id}-{column}-{row}-{version}"')
    if unchanged(request, tag):
        return not_modified(tag)
    data, version = manager.images.tile(job, column, row, format)
    tag = _tag(job, f'"{job.id}-{column}-{row}-{version}"')
    return Response(data, media_type=_TYPES[format], headers=caching(tag))


@router.get("/image.{format}", response_class=Response, responses=_content("png", "exr"))
async def image(job_id: JobId, format: Literal["png", "exr"], request: Request, manager: Manager) -> Response:
    """The whole image: PNG (sRGB, 8 bits) or EXR (linear, 32 bits), which holds its error, samples, albedo, normals and
    depth as layers."""
    limiter = _layering if format == "exr" else None
    return await to_thread.run_sync(_picture, job_id, format, request, manager, limiter=limiter)


@router.get("/error.png", response_class=Response, responses=_content("png"))
def error_map(job_id: JobId, request: Request, manager: Manager) -> Response:
    """Where the error is: the relative squared error about each pixel as a colour, from black (1e-6 or less) to bright
    (1 or more), logarithmic."""
    return _picture(job_id, "error", request, manager)


@router.get("/thumbnail.png", response_class=Response, responses=_content("png"))
def thumbnail(job_id: JobId, request: Request, manager: Manager) -> Response:
    """A small PNG."""
    return _picture(job_id, "thumbnail", request, manager)


def _picture(job_id: str, kind: str, request: Request, manager: Manager) -> Response:
    job = manager.job(job_id)
    tag = _tag(job, etag(job, f"-{kind}"))
    if unchanged(request, tag):
        return not_modified(tag)
    data = manager.images.image(job, kind)
    headers = caching(tag)
    if kind != "thumbnail":
        name = f"{job.id}-error.png" if kind == "error" else f"{job.id}.{kind}"
        headers["Content-Disposition"] = f'inline; filename="{name}"'
    return Response(data, media_type=_TYPES.get(kind, "image/png"), headers=headers)


def _tag(job: Job, tag: str) -> str:
    """Weak while the job is under way: its pixels may be newer than what is known of them."""
    return tag if job.state.final else f"W/{tag}"


@router.get("/curve")
def curve(job_id: JobId, manager: Manager) -> dict:
    """The estimated error at every checkpoint: seconds, samples, mse, relative_mse, low, high; heavy_tailed: whether
    rare events carry it, so that it may be understated, and tail_share, their share."""
    job = manager.job(job_id)
    return {"curve": manager.store.curve(job.id)}


@router.get("/stats")
def statistics(job_id: JobId, manager: Manager) -> dict:
    """What the job cost and came to: times, rays, error, accelerator, features. Counts what is stored so far."""
    return manager.statistics(job_id)
