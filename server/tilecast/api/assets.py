"""Calls about assets: files that scenes name by their SHA-256. Only what is missing needs to be sent."""

from typing import Annotated

from anyio import to_thread
from fastapi import APIRouter, Depends, Path, Request, Response

from tilecast.api.access import Manager, same_site
from tilecast.api.bodies import declared_length
from tilecast.api.problems import Problem, not_found
from tilecast.jobs.blobs import Mismatch, TooLarge, asset_key

router = APIRouter(prefix="/v1/assets/{digest}", tags=["assets"])

Digest = Annotated[str, Path(pattern="^[0-9a-f]{64}$", description="SHA-256 of the bytes, in lower-case hex.")]

_BYTES = {
    "requestBody": {
        "required": True,
        "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
    }
}


@router.head("", response_class=Response, responses={404: {"description": "Missing: PUT it"}})
def ask(digest: Digest, manager: Manager) -> Response:
    """Whether the asset is here."""
    try:
        size = manager.blobs.size(asset_key(digest))
    except FileNotFoundError:
        raise not_found(f"asset {digest}") from None
    return Response(headers={"X-Asset-Size": str(size)})


@router.put(
    "",
    status_code=201,
    response_class=Response,
    dependencies=[Depends(same_site)],
    responses={201: {"description": "Stored"}, 204: {"description": "It was here already"}},
    openapi_extra=_BYTES,
)
async def put(digest: Digest, request: Request, manager: Manager) -> Response:
    """Send the asset's bytes. They are stored only if they have this SHA-256."""
    limit = manager.settings.max_asset
    if declared_length(request) > limit:
        raise _too_large(limit)
    if await to_thread.run_sync(manager.blobs.has, asset_key(digest)):
        return Response(status_code=204)
    try:
        await manager.blobs.upload(digest, request.stream(), limit)
    except TooLarge:
        raise _too_large(limit) from None
    except Mismatch as error:
        detail = f"The bytes that came have the SHA-256 {error.actual}, not the one in the address. Send them again."
        raise Problem("Another file", "digest-mismatch", detail, 422) from None
    return Response(status_code=201)


def _too_large(limit: int) -> Problem:
    detail = f"The asset is larger than the {limit:,} bytes that this server takes."
    return Problem("The asset is too large", "too-large", detail, 413)
