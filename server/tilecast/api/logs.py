"""One way of logging for the service and all that it stands on: structlog, to standard error."""

import logging
import sys

import structlog

_QUIET = {
    "distributed": logging.WARNING,
    # Whoever gets through to the scheduler and leaves again is no news.
    "distributed.core": logging.ERROR,
    "uvicorn": logging.WARNING,
    # Says again what `problems` has said.
    "uvicorn.error": logging.CRITICAL,
}


def set_up() -> None:
    """Lines for people on a terminal, JSON elsewhere."""
    stamp = structlog.processors.TimeStamper(fmt="iso", utc=True)
    shared = [structlog.contextvars.merge_contextvars, structlog.stdlib.add_log_level, stamp]
    people = sys.stderr.isatty()
    renderer = structlog.dev.ConsoleRenderer() if people else structlog.processors.JSONRenderer(ensure_ascii=False)
    tracebacks = [] if people else [structlog.processors.format_exc_info]
    structlog.configure(
        processors=[
            structlog.stdlib.filter_by_level,
            *shared,
            structlog.stdlib.PositionalArgumentsFormatter(),
            structlog.stdlib.ProcessorFormatter.wrap_for_formatter,
        ],
        logger_factory=structlog.stdlib.LoggerFactory(),
        cache_logger_on_first_use=True,
    )
    formatter = structlog.stdlib.ProcessorFormatter(
        foreign_pre_chain=[*shared, structlog.stdlib.add_logger_name],
        processors=[structlog.stdlib.ProcessorFormatter.remove_processors_meta, *tracebacks, renderer],
    )
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(formatter)
    logging.basicConfig(level=logging.INFO, handlers=[handler], force=True)
    # Dask hangs handlers of its own on its loggers, when it is imported.
    for name in [*logging.root.manager.loggerDict]:
        if name.split(".")[0] in ("distributed", "tornado", "bokeh"):
            logging.getLogger(name).handlers.clear()
            logging.getLogger(name).propagate = True
    for name, level in _QUIET.items():
        logging.getLogger(name).setLevel(level)
