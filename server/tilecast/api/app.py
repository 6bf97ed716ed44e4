"""The application: every call of the service in one place."""

from importlib.metadata import PackageNotFoundError, version

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from starlette.datastructures import MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from tilecast import scene
from tilecast.api import assets, bodies, description, events, health, images, jobs, page, problems
from tilecast.jobs.manager import Manager

_DESCRIPTION = """A ray-tracing render server. POST a scene, follow its events, keep the image.

Errors are `application/problem+json` (RFC 9457); those about a document name the place of every fault."""


def create_app(manager: Manager) -> FastAPI:
    """The calls of `manager`, which the caller starts and closes."""
    settings = manager.settings
    app = FastAPI(
        title="Tilecast",
        version=_version(),
        description=_DESCRIPTION,
        docs_url=None,
        redoc_url=None,
    )
    app.state.manager = manager
    app.state.settings = settings
    problems.install(app)
    for router in (jobs.router, events.router, images.router, assets.router, health.router):
        app.include_router(router)
    description.add_description(app)
    page.add_page(app, settings.scenes)
    health.add_metrics(app, manager)

    app.add_middleware(_NeverGuessTypes)
    app.openapi = lambda: app.openapi_schema or _describe(app)
    return app


class _NeverGuessTypes:
    """Tells browsers to take every answer for what it says it is."""

    def __init__(self, app: ASGIApp):
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def send_with_header(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message)["X-Content-Type-Options"] = "nosniff"
            await send(message)

        await self._app(scope, receive, send_with_header)


def _describe(app: FastAPI) -> dict:
    """The OpenAPI document, with the models of what comes in bodies, which FastAPI does not parse."""
    document = get_openapi(
        title=app.title, version=app.version, description=app.description, routes=app.routes, tags=app.openapi_tags
    )
    models = document.setdefault("components", {}).setdefault("schemas", {})
    for name, schema in (
        ("Scene", scene.schema_json()),
        ("Submission", bodies.Submission.model_json_schema()),
        ("Change", bodies.Change.model_json_schema()),
        ("Problem", problems.Document.model_json_schema()),
    ):
        schema.pop("$schema", None)
        parts = schema.pop("$defs", {})
        for part, definition in {**parts, name: schema}.items():
            models[part] = _relocated(definition)
    models["Submission"]["properties"]["scene"] = {"$ref": "#/components/schemas/Scene"}
    for path in document["paths"].values():
        for call in path.values():
            # FastAPI would have its own faults described here.
            call["responses"].pop("422", None)
            call["responses"]["4XX"] = {
                "description": "Refused",
                "content": {"application/problem+json": {"schema": {"$ref": "#/components/schemas/Problem"}}},
            }
    for unused in ("HTTPValidationError", "ValidationError"):
        models.pop(unused, None)
    app.openapi_schema = document
    return document


def _relocated(value):
    """`value` with its references pointing to where OpenAPI keeps models."""
    if isinstance(value, dict):
        return {key: _relocated(_moved(key, inner)) for key, inner in value.items()}
    if isinstance(value, list):
        return [_relocated(inner) for inner in value]
    return value


def _moved(key: str, value):
    if key == "$ref" and isinstance(value, str):
        return value.replace("#/$defs/", "#/components/schemas/")
    if key == "mapping" and isinstance(value, dict):  # of a discriminator
        return {
            name: target.replace("#/$defs/", "#/components/schemas/") if isinstance(target, str) else target
            for name, target in value.items()
        }
    return value


def _version() -> str:
    try:
        return version("tilecast")
    except PackageNotFoundError:  # run from the source tree
        return "0"
