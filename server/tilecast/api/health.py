"""Calls about the server itself."""

from collections.abc import Iterator

from fastapi import APIRouter, FastAPI, Response
from fastapi.responses import JSONResponse
from prometheus_client import CollectorRegistry
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric
from prometheus_client.registry import Collector
from prometheus_fastapi_instrumentator import Instrumentator

from tilecast import scene
from tilecast.api.access import Manager
from tilecast.api.problems import Problem
from tilecast.jobs import manager as jobs

router = APIRouter(tags=["server"])


@router.get("/healthz")
async def healthz() -> dict[str, str]:
    """The process answers."""
    return {"status": "ok"}


@router.get("/readyz", responses={503: {"description": "Not ready: jobs are accepted late, or not at all"}})
def readyz(manager: Manager) -> dict[str, str | int]:
    """The database answers, and there is a worker to render on."""
    try:
        manager.store.ping()
    except Exception:
        raise Problem("Not ready", "not-ready", "The database does not answer.", 503) from None
    threads = sum(manager.engine.workers.values())
    if threads == 0:
        raise Problem("Not ready", "not-ready", "There is no worker; accepted jobs wait for one.", 503)
    return {"status": "ready", "threads": threads}


@router.get("/v1/schema", response_class=Response, responses={200: {"content": {"application/schema+json": {}}}})
def schema() -> JSONResponse:
    """The JSON Schema of a scene."""
    return JSONResponse(scene.schema_json(), media_type="application/schema+json")


class _Jobs(Collector):
    """What Prometheus may know about jobs and workers, read when it asks."""

    def __init__(self, manager: jobs.Manager):
        self._manager = manager

    def collect(self) -> Iterator[Metric]:
        states = GaugeMetricFamily("tilecast_jobs", "Jobs by state", labels=["state"])
        for state, count in self._manager.store.counts().items():
            states.add_metric([state], count)
        yield states
        workers = self._manager.engine.workers
        yield GaugeMetricFamily("tilecast_workers", "Worker processes that are up", len(workers))
        yield GaugeMetricFamily("tilecast_worker_threads", "Threads that render", sum(workers.values()))
        yield GaugeMetricFamily("tilecast_listeners", "Open event streams", len(self._manager.hub))
        counted = self._manager.counters
        yield CounterMetricFamily("tilecast_chunks", "Chunks rendered", counted["chunks"])
        yield CounterMetricFamily("tilecast_chunk_seconds", "Time that workers spent on chunks", counted["seconds"])
        yield CounterMetricFamily("tilecast_rays", "Rays traced", counted["rays"])
        yield CounterMetricFamily("tilecast_crashes", "Chunks lost to the death of a worker", counted["crashes"])


def add_metrics(app: FastAPI, manager: jobs.Manager) -> None:
    """Count requests, and answer /metrics."""
    registry = CollectorRegistry()
    registry.register(_Jobs(manager))
    # Event streams stay open for hours: that is no latency.
    instrumentator = Instrumentator(registry=registry, excluded_handlers=["/v1/jobs/{job_id}/events", "/metrics"])
    text = {200: {"content": {"text/plain": {}}}}
    instrumentator.instrument(app).expose(app, tags=["server"], response_class=Response, responses=text)
