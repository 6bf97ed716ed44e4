"""Server-sent events: what happens to one job, as it happens."""

import asyncio
import json
from collections.abc import AsyncIterator
from typing import Annotated

from anyio import to_thread
from fastapi import APIRouter, Depends, Header, Request, Response
from fastapi.sse import EventSourceResponse, ServerSentEvent

from tilecast.api.access import Manager
from tilecast.api.jobs import JobId

router = APIRouter(tags=["progress"])

_GATHER_SECONDS = 0.05  # what happens faster is told together: of a tile, only its latest version
_RECONNECT_MILLISECONDS = 1000


class Ended(Exception):
    """Whoever asks has heard everything that there will be."""


def _seen(
    job_id: JobId, manager: Manager, last_event_id: Annotated[str, Header(max_length=100)] = ""
) -> int:
    """The number of the last event that the client has. What can be refused is refused here, while there is still a
    status line to say it in."""
    job = manager.job(job_id)
    seen = int(last_event_id) if last_event_id.isascii() and last_event_id.isdigit() and len(last_event_id) < 10 else 0
    if job.state.final and seen >= job.event:
        raise Ended
    return seen


def answer_ended(_request: Request, _ended: Ended) -> Response:
    """204 tells a browser's EventSource not to come back."""
    return Response(status_code=204)


@router.get(
    "/v1/jobs/{job_id}/events",
    response_class=EventSourceResponse,
    responses={204: {"description": "The job has ended, and `Last-Event-ID` is its last event"}},
)
async def events(
    job_id: JobId, seen: Annotated[int, Depends(_seen)], manager: Manager
) -> AsyncIterator[ServerSentEvent]:
    """`state`, `tile` and `error` events. Begins with what happened since `Last-Event-ID`; without it, with everything.

    Of the changes of a tile, the latest one stands for all. The stream ends with the job.
    """
    loop = asyncio.get_running_loop()
    news = asyncio.Event()
    stop = manager.hub.listen(job_id, lambda: loop.call_soon_threadsafe(news.set))
    try:
        yield ServerSentEvent(retry=_RECONNECT_MILLISECONDS)
        while not manager.hub.closed:
            news.clear()
            occurrences = await to_thread.run_sync(manager.since, job_id, seen)
            if occurrences is None:
                return
            for occurrence in occurrences:
                seen = occurrence.event
                data = json.dumps(occurrence.data, separators=(",", ":"))
                yield ServerSentEvent(raw_data=data, event=occurrence.type, id=str(seen))
            if occurrences:
                await asyncio.sleep(_GATHER_SECONDS)
            elif await to_thread.run_sync(manager.has_ended, job_id, seen):
                return
            elif not manager.hub.closed:
                await news.wait()
    finally:
        stop()
