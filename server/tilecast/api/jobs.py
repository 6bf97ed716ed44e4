"""Calls about jobs."""

from hashlib import sha256
from typing import Annotated

from anyio import CapacityLimiter, to_thread
from fastapi import APIRouter, Depends, Header, Path, Query, Request, Response

from tilecast import scene
from tilecast.api import bodies
from tilecast.api.access import Manager, User, same_site
from tilecast.api.conditions import caching, not_modified, require, unchanged
from tilecast.api.problems import bad_request, bad_scene
from tilecast.api.views import JobView, PageView, etag, job_view
from tilecast.jobs.manager import Order
from tilecast.jobs.records import Job
from tilecast.jobs.state import State

router = APIRouter(prefix="/v1/jobs", tags=["jobs"])

JobId = Annotated[str, Path(max_length=64, description="As the submission's answer named it.")]

# Submissions are parsed and compiled beside the event loop, few at a time, so that other calls find threads.
_checking = CapacityLimiter(4)

def _body(description: str, *models: str) -> dict:
    """What the OpenAPI document says of a body that FastAPI does not parse. `app` puts the models in."""
    choices = [{"$ref": f"#/components/schemas/{model}"} for model in models]
    schema = choices[0] if len(choices) == 1 else {"anyOf": choices}
    content = {"application/json": {"schema": schema}}
    return {"requestBody": {"required": True, "description": description, "content": content}}


_SCENE_BODY = _body("A scene, or an object that holds one under `scene`.", "Scene", "Submission")
_CHANGE_BODY = _body("What to change.", "Change")


@router.post("", status_code=202, dependencies=[Depends(same_site)], openapi_extra=_SCENE_BODY)
async def submit(
    request: Request,
    response: Response,
    manager: Manager,
    user: User,
    idempotency_key: Annotated[str | None, Header(min_length=1, max_length=255)] = None,
) -> JobView:
    """Queue a scene. It is accepted (202) once it is checked and committed.

    The same `Idempotency-Key` with the same body, sent again, names the job of the first time.
    """
    body = await bodies.read(request)

    def work() -> tuple[Job, bool]:
        try:
            asked, document = bodies.submission(body)
        except scene.SceneError as error:
            raise bad_scene(error.errors) from None
        if asked.callback and not manager.settings.callbacks:
            raise bad_request("callback", "callbacks are switched off on this server")
        order = Order(user, asked.name, asked.priority, asked.callback, idempotency_key)
        return manager.submit(document, order, body)

    job, new = await to_thread.run_sync(work, limiter=_checking)
    response.headers["Location"] = f"/v1/jobs/{job.id}"
    if not new:
        response.headers["Idempotency-Replayed"] = "true"
    return job_view(job)


@router.get("")
def list_jobs(
    request: Request,
    response: Response,
    manager: Manager,
    state: Annotated[State | None, Query(description="Only jobs in this state.")] = None,
    limit: Annotated[int, Query(ge=1, le=200)] = 50,
    after: Annotated[str | None, Query(max_length=32, description="`next` of the page before.")] = None,
) -> PageView:
    """Jobs, newest first."""
    if after is not None and not (after.isascii() and after.isdigit() and len(after) < 19):
        raise bad_request("after", "must be the `next` of another page")
    jobs, following = manager.store.page(state, limit, int(after) if after is not None else None)
    tag = f'"{sha256(" ".join([*map(etag, jobs), str(following)]).encode()).hexdigest()[:32]}"'
    if unchanged(request, tag):
        return not_modified(tag)
    response.headers.update(caching(tag))
    return PageView(jobs=[job_view(job) for job in jobs], next=None if following is None else str(following))


@router.get("/{job_id}")
def show(job_id: JobId, request: Request, response: Response, manager: Manager) -> JobView:
    """One job."""
    job = manager.job(job_id)
    if unchanged(request, etag(job)):
        return not_modified(etag(job))
    response.headers.update(caching(etag(job)))
    return job_view(job)


@router.patch("/{job_id}", dependencies=[Depends(same_site)], openapi_extra=_CHANGE_BODY)
async def change(job_id: JobId, request: Request, manager: Manager) -> JobView:
    """Change the priority, hold the job (`"state": "paused"`), let it go on (`"state": "queued"`), or give it up
    (`"state": "cancelled"`), which unlike DELETE leaves a job that has ended as it is (409)."""
    body = await bodies.read(request)
    changes = {"paused": manager.pause, "queued": manager.resume, "cancelled": manager.cancel}

    def work() -> Job:
        try:
            asked = bodies.change(body)
        except scene.SceneError as error:
            raise bad_request(error.path, error.message) from None
        with manager.held(job_id) as job:
            require(request, etag(job))
            # Both are refused of a job that has ended, so that a refusal leaves it as it was.
            if asked.priority is not None:
                job = manager.set_priority(job_id, asked.priority)
            if asked.state is not None:
                job = changes[asked.state](job_id)
            return job

    return job_view(await to_thread.run_sync(work))


@router.post("/{job_id}/retry", status_code=202, dependencies=[Depends(same_site)])
def retry(job_id: JobId, request: Request, manager: Manager) -> JobView:
    """Let a failed or cancelled job go on from what is stored of it."""
    with manager.held(job_id) as job:
        require(request, etag(job))
        return job_view(manager.retry(job_id))


@router.delete(
    "/{job_id}",
    dependencies=[Depends(same_site)],
    responses={200: {"model": JobView, "description": "Cancelled"}, 204: {"description": "Deleted"}},
)
def cancel_or_delete(job_id: JobId, request: Request, manager: Manager) -> Response:
    """Cancel a job that has not ended (200); delete one that has (204)."""
    with manager.held(job_id) as job:
        require(request, etag(job))
        job = manager.cancel_or_delete(job_id)
    if job is None:
        return Response(status_code=204)
    return Response(job_view(job).model_dump_json(), media_type="application/json")
