"""Request bodies: bytes to documents. FastAPI does not parse them, so that every fault is told in one voice."""

import re
from typing import Annotated, Literal, TypeVar
from urllib.parse import urlsplit

from fastapi import Request
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from tilecast import scene
from tilecast.api.problems import Problem, bad_request, legible

_JSON_TYPES = {
    "application/json",
    "text/json",
    "text/plain",
    # What curl --data claims, whatever it sends.
    "application/x-www-form-urlencoded",
    "",
}

_WRAPPER = re.compile(r"^scene(\.|(?=\[\"))")
"""What stands before the place of a fault within the scene of a submission, and before none within a bare scene."""


def _plain_text(text: str) -> str:
    if text != legible(text) or "\0" in text:
        raise ValueError("must be text without NUL and unpaired surrogates")
    return text


def _address(url: str) -> str:
    parts = urlsplit(_plain_text(url))
    if parts.scheme not in ("http", "https") or not parts.hostname:
        raise ValueError("must be an http or https URL")
    if parts.username is not None or parts.password is not None:
        raise ValueError("must not carry a user name or password")
    _ = parts.port  # raises ValueError where it is no number
    return url


Model = TypeVar("Model", bound=BaseModel)


class Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)


Priority = Annotated[int, Field(ge=-1000, le=1000)]


class Submission(Strict):
    """A scene with what is known about the job apart from it."""

    scene: dict
    name: Annotated[str, Field(max_length=200), AfterValidator(_plain_text)] = ""
    priority: Priority = 0
    """Jobs of a higher priority go first, whoever sent them."""
    callback: Annotated[str, Field(max_length=2000), AfterValidator(_address)] | None = None
    """http or https URL to which the finished job is posted."""


class Change(Strict):
    """What a PATCH may ask for."""

    priority: Priority | None = None
    state: Literal["paused", "queued", "cancelled"] | None = None


async def read(request: Request) -> bytes:
    """The body, if it may be JSON. Raises a problem with 413, 415 or 422 (empty)."""
    media_type = request.headers.get("content-type", "").split(";")[0].strip().lower()
    if media_type not in _JSON_TYPES and not media_type.endswith("+json"):
        detail = f"The body must be JSON (Content-Type: application/json), not {legible(media_type)}."
        raise Problem("Not JSON", "wrong-content-type", detail, 415)
    if (encoding := request.headers.get("content-encoding", "identity").strip().lower()) != "identity":
        detail = f"The body must come as it is, not in Content-Encoding {legible(encoding)}."
        raise Problem("Not plain", "wrong-content-encoding", detail, 415)
    limit = request.app.state.settings.max_body
    body = bytearray()
    # Starlette can limit bodies too, but what it answers is no problem+json.
    async for chunk in request.stream():
        body += chunk
        if len(body) > limit or declared_length(request) > limit:
            detail = f"The body is larger than the {limit:,} bytes that this server takes. Send large meshes as assets."
            raise Problem("The body is too large", "too-large", detail, 413)
    if not body.strip():
        raise bad_request("", "the body is empty")
    return bytes(body)


def declared_length(request: Request) -> int:
    """What Content-Length says; 0 where it is not there."""
    declared = request.headers.get("content-length", "")
    return int(declared) if declared.isascii() and declared.isdigit() else 0


def submission(body: bytes) -> tuple[Submission, bytes | dict]:
    """What a submission asks for, and its scene, not yet checked: the body itself where it is a bare scene."""
    try:
        document = scene.read(body)
    except scene.SceneError as error:
        raise scene.SceneError(_WRAPPER.sub("", error.path), error.message) from None
    # A scene has a list under "scene": what is seen.
    if not isinstance(document.get("scene"), dict):
        return Submission(scene={}), body
    asked = _checked(Submission, document)
    return asked, asked.scene


def change(body: bytes) -> Change:
    return _checked(Change, scene.read(body))


def _checked(model: type[Model], document: dict) -> Model:
    try:
        return model.model_validate(document)
    except ValidationError as error:
        fault = error.errors()[0]
        path = ".".join(map(str, fault["loc"]))
        if fault["type"] == "extra_forbidden":
            known = ", ".join(model.model_fields)
            raise bad_request(path, f"is unknown here; possible are {known}") from None
        raise bad_request(path, fault["msg"].removeprefix("Value error, ")) from None
