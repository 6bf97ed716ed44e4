"""Run the service: one process that listens, and a worker process that renders."""

import signal
import socket
import sys

import structlog
import uvicorn

from tilecast.api import logs
from tilecast.api.app import create_app
from tilecast.api.views import job_view
from tilecast.jobs.faults import CannotStart
from tilecast.jobs.hub import Hub
from tilecast.jobs.manager import Manager
from tilecast.jobs.settings import Settings

log = structlog.get_logger()


def serve(settings: Settings) -> None:
    """Answer until SIGTERM or SIGINT, then end in order.

    Raises `CannotStart`, or `OSError` where the data folder cannot be used.
    """
    logs.set_up()
    listener = _listen(settings.host, settings.port)
    # Until uvicorn takes the signals over, and when it raises them again after its own end.
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: sys.exit(0))
    with listener:
        manager = Manager(settings, describe=lambda job: job_view(job).model_dump(mode="json"))
        try:
            config = uvicorn.Config(
                create_app(manager),
                log_config=None,
                access_log=False,
                lifespan="off",
                timeout_graceful_shutdown=5,
                timeout_keep_alive=30,
            )
            _Server(config, manager.hub, _address(listener)).run(sockets=[listener])
        finally:
            manager.close()
            log.info("stopped")


class _Server(uvicorn.Server):
    """Says when it is ready, and lets event streams go when it stops: they would not end by themselves."""

    def __init__(self, config: uvicorn.Config, hub: Hub, address: str):
        super().__init__(config)
        self._hub = hub
        self._address = address

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        log.info(f"Tilecast is at {self._address}")

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        log.info("stopping")
        self._hub.close()
        await super().shutdown(sockets)


def _listen(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        return socket.create_server((host, port), family=family, backlog=2048)
    except (OSError, OverflowError) as error:
        reason = str(getattr(error, "strerror", None) or error).split(" (")[0]
        advice = "stop what listens there, or choose another port (--port 0 takes any)"
        raise CannotStart(f"cannot listen on {host}, port {port}: {reason}; {advice}") from None


def _address(listener: socket.socket) -> str:
    host, port = listener.getsockname()[:2]
    return f"http://[{host}]:{port}/" if ":" in host else f"http://{host}:{port}/"
