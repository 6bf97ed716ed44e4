"""Conditional requests (RFC 9110): entity tags in both directions."""

from fastapi import Request, Response

from tilecast.api.problems import Problem


def unchanged(request: Request, tag: str) -> bool:
    """Whether the client has what `tag` names already (If-None-Match)."""
    return _matches(request.headers.get("if-none-match"), tag)


def not_modified(tag: str) -> Response:
    return Response(status_code=304, headers=caching(tag))


def caching(tag: str) -> dict[str, str]:
    """Headers of what may be kept, if it is asked about each time."""
    return {"ETag": tag, "Cache-Control": "no-cache"}


def require(request: Request, tag: str) -> None:
    """Refuse with 412 where the client means an older state (If-Match)."""
    wanted = request.headers.get("if-match")
    if wanted is not None and not _matches(wanted, tag):
        detail = "The job is not as it was when you read it. Read it again, then decide."
        raise Problem("The job has changed", "changed", detail, 412, headers={"ETag": tag})


def _matches(header: str | None, tag: str) -> bool:
    if header is None:
        return False
    tags = [part.strip().removeprefix("W/") for part in header.split(",")]
    return "*" in tags or tag.removeprefix("W/") in tags
