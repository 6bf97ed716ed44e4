"""What is answered when something is wrong: `application/problem+json` (RFC 9457).

Every problem has a type of its own, urn:tilecast:problem:NAME; those about a document list its faults under `errors`, as
{"path", "message"} with JSON paths.
"""

from collections.abc import Sequence

import structlog
from fastapi import FastAPI
from fastapi.exceptions import RequestValidationError
from fastapi_problem.error import Problem, StatusProblem
from fastapi_problem.handler import ExceptionHandler, add_exception_handler, new_exception_handler
from pydantic import BaseModel
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request
from starlette.routing import compile_path

from tilecast.jobs import faults

log = structlog.get_logger()


class Internal(StatusProblem):
    """A mistake of ours. What it was, only the log says."""

    title = "Internal error"
    type_ = "internal"
    status = 500

    def __init__(self, _what: str):
        super().__init__("The server met an error of its own; its log says more. Jobs that were accepted go on.")


class FaultView(BaseModel):
    path: str
    message: str


class Document(BaseModel):
    """RFC 9457."""

    type: str
    title: str
    status: int
    detail: str | None = None
    errors: list[FaultView] | None = None


def not_found(what: str) -> Problem:
    return Problem("Not found", "not-found", f"There is no {what}.", 404)


def bad_document(title: str, type_: str, errors: Sequence[tuple[str, str]], status: int = 422) -> Problem:
    """A document with faults: (JSON path, message), the most important one first."""
    listed = [{"path": legible(path), "message": legible(message)} for path, message in errors]
    path, message = listed[0]["path"], listed[0]["message"]
    return Problem(title, type_, f"{path}: {message}" if path else message, status, errors=listed)


def bad_scene(errors: Sequence[tuple[str, str]]) -> Problem:
    return bad_document("The scene cannot be rendered", "bad-scene", errors)


def bad_request(path: str, message: str) -> Problem:
    return bad_document("The request is not as it should be", "bad-request", [(path, message)])


def legible(text: str) -> str:
    """`text` without what UTF-8 cannot carry: half a surrogate pair, which JSON can."""
    return text.encode("utf-8", "replace").decode()


def install(app: FastAPI) -> None:
    """Let `app` answer every error with a problem."""
    handler = new_exception_handler(
        documentation_uri_template="urn:tilecast:problem:{type}",
        http_exception_handler=_from_http,
        request_validation_handler=_from_validation,
        unhandled_wrappers={"default": Internal},
        pre_hooks=[_log_bugs],
        handlers={
            faults.Fault: _from_fault,
            ClientDisconnect: lambda *_: Problem("The client went away", "client-gone", status=400),
        },
    )
    add_exception_handler(app, handler, generic_swagger_defaults=False)
    app.add_exception_handler(faults.Fault, handler)
    app.add_exception_handler(ClientDisconnect, handler)


def _from_fault(_handler: ExceptionHandler, _request: Request, fault: "faults.Fault") -> Problem:
    match fault:
        case faults.BadScene(errors=errors):
            return bad_scene(errors)
        case faults.NoSuchJob():
            return Problem("Not found", "not-found", str(fault), 404)
        case faults.NotYet():
            return Problem("Not there yet", "not-yet", str(fault), 404)
        case faults.Refused():
            return Problem("Not possible in this state", "wrong-state", str(fault), 409)
        case faults.KeyReused():
            return Problem("Idempotency-Key used twice", "idempotency-key-reused", str(fault), 422)
        case faults.TooMany(retry_after=seconds):
            return Problem("Too many jobs", "too-many-jobs", str(fault), 429, headers={"Retry-After": str(seconds)})
    raise TypeError(f"no answer for {fault!r}")


def _from_http(_handler: ExceptionHandler, request: Request, error: HTTPException) -> Problem:
    headers = dict(error.headers or {})
    match error.status_code:
        case 404:
            return Problem("Not found", "not-found", f"There is nothing at {legible(request.url.path)}.", 404)
        case 405:
            headers["Allow"] = ", ".join(sorted(_allowed(request))) or headers.get("Allow", "")
            detail = f"{request.method} is not possible here; {headers.get('Allow', 'nothing')} is."
            return Problem("Method not allowed", "method-not-allowed", detail, 405, headers=headers)
    return Problem(str(error.detail), "http-error", None, error.status_code, headers=headers)


def _allowed(request: Request) -> set[str]:
    """The methods of all calls at this address: the one that refused knows of its own alone."""
    calls = request.app.openapi()["paths"].items()
    here = [methods for path, methods in calls if compile_path(path)[0].match(request.url.path)]
    return {method.upper() for methods in here for method in methods}


def _from_validation(_handler: ExceptionHandler, _request: Request, error: RequestValidationError) -> Problem:
    # FastAPI checks what stands in the address and in headers alone; bodies are read by `bodies`.
    errors = [(".".join(map(str, fault["loc"][1:])), fault["msg"]) for fault in error.errors()]
    return bad_document("The request is not as it should be", "bad-request", errors)


def _log_bugs(request: Request, error: Exception) -> None:
    if not isinstance(error, (Problem, HTTPException, RequestValidationError, ClientDisconnect, faults.Fault)):
        log.error("request_failed", method=request.method, path=request.url.path, exc_info=error)
