"""`tilecast serve`: the server, its page and its worker."""

from __future__ import annotations

from pathlib import Path
from pkgutil import resolve_name
from typing import Annotated, Any

import typer
from pydantic import ValidationError

from .failures import BAD_SCENE, fail


def serve(
    host: Annotated[str | None, typer.Option(help="Address to listen on: 127.0.0.1. There are no passwords: open it to "
                                                  "trusted networks only.", show_default=False)] = None,
    port: Annotated[int | None, typer.Option(min=0, max=65535, help="8000; 0 takes any.", show_default=False)] = None,
    data: Annotated[Path | None, typer.Option(metavar="FOLDER", help="Where everything that has to outlive the server "
                                              "goes: ~/.local/share/tilecast.", show_default=False)] = None,
    database: Annotated[str | None, typer.Option(metavar="URL", help="SQLite in the data folder, or "
                                                 "postgresql+psycopg://...", show_default=False)] = None,
    blobs: Annotated[str | None, typer.Option(metavar="URL", help="Place of the large files: in the data folder, or "
                                              "s3://bucket/prefix.", show_default=False)] = None,
    scheduler: Annotated[str | None, typer.Option(metavar="URL", help="A running Dask scheduler, tcp://host:8786, to "
                                                  "render on; a process on this machine otherwise.",
                                                  show_default=False)] = None,
    threads: Annotated[int | None, typer.Option(min=1, help="Of the process on this machine: one a core.",
                                                show_default=False)] = None,
    scenes: Annotated[Path | None, typer.Option(metavar="FOLDER", help="Example scenes for the page.",
                                                show_default=False)] = None,
) -> None:
    """Serve the HTTP interface and the page.

    Every option, and the limits, can also be set in the environment: TILECAST_PORT, TILECAST_MAX_PIXELS, ...
    """
    from ..jobs.faults import CannotStart
    from ..jobs.settings import Settings

    options = {"host": host, "port": port, "data": data, "database": database, "blobs": blobs,
               "scheduler": scheduler, "threads": threads, "scenes": scenes}
    try:
        settings = Settings(**{name: value for name, value in options.items() if value is not None})
    except ValidationError as error:
        fault = error.errors()[0]
        name = str(fault["loc"][0])
        shown = f"--{name}" if options.get(name) is not None else f"TILECAST_{name.upper()}"
        fail(f"{shown}: {fault['msg']}", BAD_SCENE)
    # By name, as servers name applications: commands do not know the HTTP floor.
    run: Any = resolve_name("tilecast.api.server:serve")
    try:
        run(settings)
    except CannotStart as error:
        fail(str(error))
    except OSError as error:
        fail(f"cannot use the data folder {settings.data}: {error.strerror or error}")
