"""The web page, and the example scenes that it offers."""

import json
from pathlib import Path
from typing import Annotated

from fastapi import APIRouter, FastAPI
from fastapi import Path as PathParameter
from fastapi.responses import FileResponse, HTMLResponse, Response
from fastapi.staticfiles import StaticFiles

from tilecast.api.problems import not_found

_PACKAGE = Path(__file__).resolve().parents[1]
_REPOSITORY = _PACKAGE.parents[1]

_NO_PAGE = """<!doctype html><html lang="en"><title>Tilecast</title>
<p>Tilecast is running, but its page was not installed. <a href="/docs">The calls that it answers.</a></p></html>"""


def add_page(app: FastAPI, scenes: Path | None) -> None:
    """Answer `/`, `/web/...` and `/v1/scenes`."""
    app.include_router(_scenes(scenes or _first(_PACKAGE / "_scenes", _REPOSITORY / "scenes")))
    folder = _first(_PACKAGE / "_web", _REPOSITORY / "web")

    @app.get("/", include_in_schema=False)
    def page() -> Response:
        if folder is None:
            return HTMLResponse(_NO_PAGE)
        return FileResponse(folder / "index.html", headers={"Cache-Control": "no-cache"})

    if folder is not None:
        app.mount("/web", _Modules(directory=folder), name="web")


class _Modules(StaticFiles):
    """The page's files, asked about each time: they have no version in their names."""

    def file_response(self, *arguments, **options) -> Response:
        response = super().file_response(*arguments, **options)
        response.headers["Cache-Control"] = "no-cache"
        return response


def _scenes(folder: Path | None) -> APIRouter:
    router = APIRouter(prefix="/v1/scenes", tags=["scenes"])

    @router.get("")
    def list_scenes() -> dict:
        """The example scenes."""
        return {"scenes": [{"name": name, "title": _title(name)} for name in sorted(_files(folder))]}

    @router.get("/{name}", response_class=Response, responses={200: {"content": {"application/json": {}}}})
    def show_scene(name: Annotated[str, PathParameter(max_length=200)]) -> Response:
        """One example scene, as it was written."""
        path = _files(folder).get(name)
        if path is None:
            raise not_found(f"example scene of this name; there are {', '.join(sorted(_files(folder))) or 'none'}")
        return Response(path.read_bytes(), media_type="application/json")

    return router


def _files(folder: Path | None) -> dict[str, Path]:
    """Those that can be posted as they are: what needs files beside it goes through `tilecast submit`."""
    if folder is None or not folder.is_dir():
        return {}
    return {path.stem: path for path in folder.glob("*.json") if _stands_alone(path)}


def _stands_alone(path: Path) -> bool:
    try:
        document = json.loads(path.read_bytes())
    except (OSError, ValueError):
        return False
    pending = [document]
    while pending:
        value = pending.pop()
        if isinstance(value, dict):
            if value.get("type") in ("mesh", "image") and "file" in value:
                return False
            pending.extend(value.values())
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            pending.extend(value)
    return isinstance(document, dict)


def _title(name: str) -> str:
    return name.replace("-", " ").replace("_", " ").capitalize()


def _first(*folders: Path) -> Path | None:
    return next((folder for folder in folders if folder.is_dir()), None)
