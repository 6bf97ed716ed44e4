"""`tilecast submit`: send a scene and the files that it names to a server; wait for the image, if asked."""

from __future__ import annotations

import hashlib
import json
import secrets
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import httpx2
import typer

from . import options
from .failures import BAD_SCENE, fail, failing, writable
from .progress import duration

_TRIES = 6  # of one request, where the server is too busy
_CALLS = 4  # of one request, where no answer comes
_LONGEST_PAUSE = 30.0  # seconds between tries
_UPLOAD_CHUNK = 2**20


def submit(
    scene: Annotated[Path, typer.Argument(metavar="SCENE", help="A scene, JSON.", show_default=False)],
    server: Annotated[str, typer.Option(metavar="URL", help="As in http://127.0.0.1:8000", show_default=False)],
    wait: Annotated[bool, typer.Option("--wait", help="Follow the job to its end.")] = False,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Wait, and write the image: .png or .exr.",
                                                show_default=False)] = None,
    name: Annotated[str | None, typer.Option(help="Of the job: the scene's by default.", show_default=False)] = None,
    priority: Annotated[int, typer.Option(min=-1000, max=1000, help="High first.")] = 0,
    quiet: options.Quiet = False,
) -> None:
    """Send a scene, with the files that it names, to a server. Prints the job's address."""
    if output is not None:
        if output.suffix.lower() not in (".png", ".exr"):
            raise typer.BadParameter(f"must end in .png or .exr, got {str(output)!r}", param_hint="--output")
        writable(output)
    try:
        (name or "").encode()
    except UnicodeEncodeError:
        raise typer.BadParameter("is not text", param_hint="--name") from None
    if not server.startswith(("http://", "https://")):
        raise typer.BadParameter(f"must begin with http:// or https://, got {server!r}", param_hint="--server")

    with failing(scene):
        document, files = _prepared(scene)
        try:
            with httpx2.Client(base_url=server.rstrip("/"), timeout=60) as client:
                for digest, path in files.items():
                    _send(client, digest, path)
                name = name if name is not None else scene.stem[:200]
                order = {"scene": document, "name": name, "priority": priority}
                # A key of its own: an answer that is lost on its way makes no second job.
                key = {"Idempotency-Key": secrets.token_hex(16)}
                job = _job(_call(client, scene, "POST", "/v1/jobs", json=order, headers=key))
                typer.echo(f"{server.rstrip('/')}{job['links']['self']}")
                if wait or output is not None:
                    _follow(client, scene, job, quiet)
                if output is not None:
                    from ..render.output import write_file
                    suffix = output.suffix.lower()[1:]
                    image = _call(client, scene, "GET", f"{job['links']['self']}/image.{suffix}", timeout=600)
                    write_file(output, image.content)
        except httpx2.InvalidURL as error:
            raise typer.BadParameter(f"is not an address: {error}", param_hint="--server") from None
        except httpx2.HTTPError as error:
            fail(f"{server}: {str(error) or type(error).__name__}; is the server running?")


def _prepared(path: Path) -> tuple[dict[str, Any], dict[str, Path]]:
    """The scene with its files named by their SHA-256, and those files."""
    from ..scene import files, folder_opener, parse, renamed

    parsed = parse(path.read_bytes())
    open_file = folder_opener(path.parent)
    names: dict[str, str] = {}
    found: dict[str, Path] = {}
    for place, file in files(parsed).items():
        if file in names or file.startswith("sha256:"):
            continue
        try:
            digest = hashlib.sha256(open_file(file)).hexdigest()
        except ValueError as error:
            fail(f"{path}: {place}: {error}", BAD_SCENE)
        names[file] = f"sha256:{digest}.{file.rsplit('.', 1)[-1].lower()}"
        found[digest] = path.parent / file
    return renamed(parsed, names), found


def _send(client: httpx2.Client, digest: str, path: Path) -> None:
    """Upload a file, if the server does not have it."""
    asset = f"/v1/assets/{digest}"
    if _retried(lambda: client.head(asset)).status_code == 404:

        def content() -> Iterator[bytes]:
            with path.open("rb") as file:
                while chunk := file.read(_UPLOAD_CHUNK):
                    yield chunk

        size = {"Content-Length": str(path.stat().st_size), "Content-Type": "application/octet-stream"}
        answer = _retried(lambda: client.put(asset, content=content(), headers=size, timeout=600))
        if not answer.is_success:
            fail(f"{path}: {_detail(answer)}")


def _call(client: httpx2.Client, scene: Path, method: str, path: str, **arguments: Any) -> httpx2.Response:
    """Call the server; what it refuses ends the command with one line."""
    answer = _retried(lambda: client.request(method, path, **arguments))
    if not answer.is_success:
        fail(f"{scene}: {_detail(answer)}", BAD_SCENE if answer.status_code in (413, 422) else 1)
    return answer


def _job(answer: httpx2.Response) -> dict[str, Any]:
    """What the server says of a job."""
    try:
        job = answer.json()
        if "self" in job["links"]:
            return job
    except (ValueError, KeyError, TypeError):
        pass
    fail(f"{answer.url}: what answers there is not a Tilecast server")


def _retried(call: Any) -> httpx2.Response:
    """Call again, later and later, where no answer comes or the server asks for patience."""
    for attempt in range(_TRIES):
        try:
            answer = call()
        except httpx2.TransportError:
            if attempt >= _CALLS - 1:
                raise
            pause = 0.5 * 2**attempt
        else:
            if answer.status_code not in (429, 503) or attempt == _TRIES - 1:
                return answer
            wait = answer.headers.get("retry-after", "")
            pause = float(wait) if wait.isdigit() else 0.5 * 2**attempt
        time.sleep(min(pause, _LONGEST_PAUSE))
    raise AssertionError("the last try returns or raises")


def _detail(answer: httpx2.Response) -> str:
    """What a refusal says, in one line."""
    try:
        problem = answer.json()
        return problem.get("detail") or problem["title"]
    except (ValueError, KeyError, AttributeError):
        return f"the server answered {answer.status_code} {answer.reason_phrase}"


def _follow(client: httpx2.Client, scene: Path, job: dict[str, Any], quiet: bool) -> None:
    """Tell how the job goes until it ends. Lost connections are made again."""
    links, headers, silent_since = job["links"], {}, time.monotonic()
    while job["state"] not in ("done", "failed", "cancelled"):
        try:
            with client.stream("GET", links["events"], headers=headers, timeout=60) as stream:
                if stream.status_code == 404:
                    fail(f"{scene}: the job was deleted")
                for event in httpx2.EventSource(stream) if stream.status_code == 200 else ():
                    silent_since = time.monotonic()
                    headers["Last-Event-ID"] = event.id
                    if event.event == "error" and not quiet:
                        _tell(scene, json.loads(event.data))
            job = _job(_call(client, scene, "GET", links["self"]))
        except httpx2.TransportError:
            if time.monotonic() - silent_since > 120:
                raise
            time.sleep(1)
    if job["state"] != "done":
        error = job["error"] or {"path": "", "message": f"the job was {job['state']}"}
        fail(f"{scene}: {error['path']}: {error['message']}" if error["path"] else f"{scene}: {error['message']}")


def _tell(scene: Path, point: dict[str, Any]) -> None:
    error = f"relative MSE {point['relative_mse']:.2g}" if point["relative_mse"] is not None else "error unknown"
    typer.echo(f"{scene.name}: {point['samples']} samples in {duration(point['seconds'])}, {error}", err=True)
