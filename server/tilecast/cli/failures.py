"""How a command fails: one line on stderr, and a status. 2: the scene or the call is wrong; 1: something else
is."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NoReturn

import typer

from ..scene.errors import SceneError

BAD_SCENE = 2
FAILED = 1


def say(message: str) -> None:
    """One line on stderr, whatever is in the message."""
    typer.echo("tilecast: " + " ".join(message.split()), err=True)


def fail(message: str, status: int = FAILED) -> NoReturn:
    """Ends the command with one line."""
    say(message)
    raise typer.Exit(status)


def describe(source: str | Path, error: SceneError) -> str:
    """A bad scene in one line: its file, the path in it, what is wrong, and how much else is."""
    more = len(error.errors) - 1
    return f"{source}: {error}" + (f" (and {more} more: tilecast validate --all lists them)" if more else "")


@contextlib.contextmanager
def failing(source: str | Path, settings: Sequence[str] = ()) -> Iterator[None]:
    """What can go wrong with a scene, some values of which `settings` (KEY=VALUE) replace, on its way to an image
    ends the command with one line."""
    try:
        yield
    except BaseException as error:
        found = explain(source, error, settings)
        if found is None:
            raise
        fail(*found)


def explain(source: str | Path, error: BaseException, settings: Sequence[str] = ()) -> tuple[str, int] | None:
    """The line and the status for an error that belongs to a scene or to the machine; None for a mistake of
    ours."""
    if isinstance(error, SceneError):
        return describe(source, error), BAD_SCENE
    if isinstance(error, MemoryError):
        return f"{source}: there is not enough memory for this scene or image", FAILED
    if isinstance(error, OSError):
        return f"{source}: {error.filename or 'a file'}: {error.strerror or error}", FAILED
    if type(error).__name__ == "SampleError":  # the core's; naming the type would import it for every command
        from ..render.one_sample import with_command
        return f"{source}: {with_command(error, str(source), settings)}", FAILED
    return None


def writable(path: Path) -> None:
    """Ends the command where a file could not be written, before an hour is spent on what it should hold."""
    folder = path.parent
    if not folder.is_dir():
        fail(f"{path}: there is no folder {folder}; make it first")
    if path.is_dir():
        fail(f"{path}: is a folder, not a file")
    if not os.access(folder, os.W_OK):
        fail(f"{path}: the folder {folder} cannot be written to")
