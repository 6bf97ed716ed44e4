"""Jobs as JSON."""

from datetime import UTC, datetime

from pydantic import BaseModel, ConfigDict, Field

from tilecast.jobs.records import Job
from tilecast.jobs.state import State


class View(BaseModel):
    model_config = ConfigDict(use_attribute_docstrings=True)


class ErrorView(View):
    path: str
    """The place in the scene's JSON; empty where it has none."""
    message: str


class TilesView(View):
    columns: int
    rows: int
    size: int
    """Pixels along a side; tiles at the right and at the bottom may be smaller."""


class LinksView(View):
    self: str
    events: str
    tiles: str
    image: str
    exr: str
    error_map: str
    thumbnail: str
    curve: str
    stats: str


class JobView(View):
    """A job as it stands."""

    id: str
    name: str
    state: State
    priority: int
    created: datetime
    started: datetime | None
    finished: datetime | None
    width: int
    height: int
    samples: int
    progress: float = Field(ge=0, le=1)
    seconds_left: float | None
    """An estimate, while it runs."""
    error: ErrorView | None
    relative_mse: float | None
    """Estimated at the last checkpoint."""
    tiles: TilesView
    links: LinksView


class PageView(View):
    jobs: list[JobView]
    next: str | None
    """What to pass as `after` for the next page."""


def job_view(job: Job) -> JobView:
    columns, rows = -(-job.width // job.tile_size), -(-job.height // job.tile_size)
    here = f"/v1/jobs/{job.id}"
    return JobView(
        id=job.id,
        name=job.name,
        state=job.state,
        priority=job.priority,
        created=_time(job.created),
        started=_time(job.started),
        finished=_time(job.finished),
        width=job.width,
        height=job.height,
        samples=job.samples,
        progress=job.progress,
        seconds_left=job.seconds_left if job.state is State.RUNNING else None,
        error=ErrorView(path=job.error_path or "", message=job.error_message) if job.error_message else None,
        relative_mse=job.relative_mse,
        tiles=TilesView(columns=columns, rows=rows, size=job.tile_size),
        links=LinksView(
            self=here,
            events=f"{here}/events",
            tiles=f"{here}/tiles",
            image=f"{here}/image.png",
            exr=f"{here}/image.exr",
            error_map=f"{here}/error.png",
            thumbnail=f"{here}/thumbnail.png",
            curve=f"{here}/curve",
            stats=f"{here}/stats",
        ),
    )


def etag(job: Job, part: str = "") -> str:
    """Changes whenever anything about the job that can be seen does."""
    return f'"{job.id}-{job.event}{part}"'


def _time(seconds: float | None) -> datetime | None:
    return None if seconds is None else datetime.fromtimestamp(seconds, UTC)
