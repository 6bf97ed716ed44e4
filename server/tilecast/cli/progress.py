"""How far a render is: a bar with the time left on a terminal, plain lines elsewhere, nothing where quiet is
asked."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import typer

from ..render.rendering import Event, Rendering

_LINE_EVERY = 10.0  # seconds, where no point of the error curve gives a line sooner

Report = Callable[[Event, Rendering], None]


@contextlib.contextmanager
def progress(name: str, quiet: bool) -> Iterator[Report]:
    """Gives what `render` calls at each event. It may be called on another thread."""
    if quiet:
        yield lambda event, rendering: None
    elif sys.stderr.isatty():
        with _bar(name) as report:
            yield report
    else:
        yield _Lines(name)


class _Lines:
    """A line for each point of the error curve, and one now and then between them."""

    def __init__(self, name: str):
        self.name = name
        self.last = time.monotonic()

    def __call__(self, event: Event, rendering: Rendering) -> None:
        now = time.monotonic()
        if event["type"] == "error":
            typer.echo(f"{self.name}: {_samples(event['samples'])} samples in {event['seconds']:.1f} s, {_error(event)}"
                       f"{_left(rendering, ', ')}", err=True)
            self.last = now
        elif now - self.last >= _LINE_EVERY:
            typer.echo(f"{self.name}: {rendering.progress:.0%}{_left(rendering, ', ')}", err=True)
            self.last = now


@contextlib.contextmanager
def _bar(name: str) -> Iterator[Report]:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

    columns = [TextColumn("{task.description}", markup=False), BarColumn(), TaskProgressColumn(),
               TextColumn("{task.fields[error]}"), TextColumn("{task.fields[left]}")]
    with Progress(*columns, console=Console(stderr=True), transient=True) as bars:
        task = bars.add_task(name, total=1.0, error="", left="")

        def report(event: Event, rendering: Rendering) -> None:
            fields: dict[str, Any] = {"left": _left(rendering, "")}
            if event["type"] == "error":
                fields["error"] = _error(event)
            bars.update(task, completed=rendering.progress, **fields)

        yield report


def _error(point: Event) -> str:
    return f"relative MSE {point['relative_mse']:.2g}"


def _samples(mean: float) -> str:
    """Adaptive images have a mean that is no whole number."""
    return f"{mean:d}" if isinstance(mean, int) else f"{mean:.1f}"


def _left(rendering: Rendering, before: str) -> str:
    left = rendering.seconds_left
    return "" if left is None or rendering.finished else f"{before}about {duration(left)} left"


def report_end(image: Path, stats: dict[str, Any]) -> None:
    """How a render ended, and what is not to be trusted about it."""
    typer.echo(f"{image}: {stats['samples']:.4g} samples in {duration(stats['seconds']['render'])}", err=True)
    error = stats["error"]
    if skipped := stats.get("error_leaves_out"):
        typer.echo(f"{image}: the error may be understated: it leaves out what render.{skipped[0]} skips", err=True)
    if error["heavy_tailed"]:
        typer.echo(f"{image}: the error may be understated: rare bright samples, met in 1% of the pixels, make up "
                   f"{error['tail_share']:.0%} of it", err=True)


def duration(seconds: float) -> str:
    """Time as people read it: 0.4 s, 12 s, 3 min 20 s, 2 h 5 min."""
    if seconds < 10:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest} s" if minutes else f"{rest} s"
    return f"{minutes // 60} h {minutes % 60} min"
