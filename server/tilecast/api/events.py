"""Server-sent events: what happens to one job, as it happens."""

import asyncio
import json
from collections.abc import AsyncIterator
from typing import Annotated

from anyio import to_thread
from fastapi import APIRouter, Header
from fastapi.responses import Response, StreamingResponse
from fastapi.sse import KEEPALIVE_COMMENT, format_sse_event

from tilecast.api.access import Manager
from tilecast.api.jobs import JobId

router = APIRouter(tags=["progress"])

_GATHER_SECONDS = 0.05  # what happens faster is told together: of a tile, only its latest version
_KEEPALIVE_SECONDS = 15.0
_RECONNECT_MILLISECONDS = 1000


# A plain response: where an endpoint is itself the generator, FastAPI 0.165 logs an error whenever a client goes away.
@router.get(
    "/v1/jobs/{job_id}/events",
    response_class=Response,
    responses={
        200: {"content": {"text/event-stream": {"schema": {"type": "string"}}}},
        204: {"description": "The job has ended, and `Last-Event-ID` is its last event"},
    },
)
async def events(
    job_id: JobId, manager: Manager, last_event_id: Annotated[str, Header(max_length=100)] = ""
) -> Response:
    """`state`, `tile` and `error` events. Begins with what happened since `Last-Event-ID`; without it, with everything.

    Of the changes of a tile, the latest one stands for all. The stream ends with the job.
    """
    seen = int(last_event_id) if last_event_id.isascii() and last_event_id.isdigit() and len(last_event_id) < 10 else 0
    job = await to_thread.run_sync(manager.job, job_id)
    if job.state.final and seen >= job.event:
        return Response(status_code=204)  # tells a browser's EventSource not to come back
    headers = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
    return StreamingResponse(_follow(manager, job_id, seen), media_type="text/event-stream", headers=headers)


async def _follow(manager: Manager, job_id: str, seen: int) -> AsyncIterator[bytes]:
    loop = asyncio.get_running_loop()
    news = asyncio.Event()
    stop = manager.hub.listen(job_id, lambda: loop.call_soon_threadsafe(news.set))
    try:
        yield format_sse_event(retry=_RECONNECT_MILLISECONDS)
        while not manager.hub.closed:
            news.clear()
            occurrences = await to_thread.run_sync(manager.since, job_id, seen)
            if occurrences is None:
                return
            for occurrence in occurrences:
                seen = occurrence.event
                data = json.dumps(occurrence.data, separators=(",", ":"))
                yield format_sse_event(data_str=data, event=occurrence.type, id=str(seen))
            if occurrences:
                await asyncio.sleep(_GATHER_SECONDS)
            elif await to_thread.run_sync(manager.has_ended, job_id, seen):
                return
            elif not manager.hub.closed:
                try:
                    await asyncio.wait_for(news.wait(), _KEEPALIVE_SECONDS)
                except TimeoutError:
                    yield KEEPALIVE_COMMENT
    finally:
        stop()
