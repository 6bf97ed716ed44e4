"""The life of a job as a pure state machine: an event goes in, a new status and commands come out.

    queued --> running --> done
       \\        | ^  \\--> failed       paused <--> queued
        \\       v |                    failed, cancelled --retry--> queued
         \\--> paused, cancelled        running --server restart--> queued

Nothing here does I/O. `manager.Manager` commits the new status and then carries the commands out, in order; a command
lost to a kill between the two is made up for when the server starts again (`Recovered`, and `sweep`).
"""

from dataclasses import dataclass, replace
from enum import StrEnum, auto

TRIES = 3
"""A job whose worker dies this many times in a row is given up."""


class State(StrEnum):
    """Where a job stands. A job leaves a final state only by a user's retry."""

    QUEUED = auto()
    RUNNING = auto()
    PAUSED = auto()
    DONE = auto()
    FAILED = auto()
    CANCELLED = auto()

    @property
    def final(self) -> bool:
        return self in FINAL


FINAL = frozenset({State.DONE, State.FAILED, State.CANCELLED})
ACTIVE = frozenset(State) - FINAL


@dataclass(frozen=True)
class Status:
    """What the machine remembers of a job. `crashes` counts worker deaths since the job was last proved innocent."""

    state: State = State.QUEUED
    crashes: int = 0
    error_path: str | None = None
    error_message: str | None = None


@dataclass(frozen=True)
class Started:
    """The first chunk since the job was queued went to a worker."""


@dataclass(frozen=True)
class Paused:
    """A user asked to hold the job."""


@dataclass(frozen=True)
class Resumed:
    """A user asked to let a held job go on."""


@dataclass(frozen=True)
class Cancelled:
    """A user gave the job up."""


@dataclass(frozen=True)
class Finished:
    """Every sample is in, or a stop rule was met, and all of it is stored."""


@dataclass(frozen=True)
class Failed:
    """The job cannot go on. `path` is the place in the scene's JSON, or empty."""

    path: str
    message: str


@dataclass(frozen=True)
class Crashed:
    """A worker died with a chunk of this job in flight. `alone`: nothing else was in flight, so the guilt is certain."""

    alone: bool


@dataclass(frozen=True)
class Cleared:
    """Every chunk under suspicion ran alone and came back."""


@dataclass(frozen=True)
class Retried:
    """A user wants a failed or cancelled job to go on from what is stored."""


@dataclass(frozen=True)
class Recovered:
    """The server started and found the job in its store."""


Event = (
    Started | Paused | Resumed | Cancelled | Finished | Failed | Crashed | Cleared | Retried | Recovered
)


class Command(StrEnum):
    """What the shell has to do once the new status is committed."""

    ENQUEUE = auto()
    """Give the job to the dispatcher, to go on from what is stored."""
    WITHDRAW = auto()
    """Take the job from the dispatcher. Chunks in flight are thrown away."""
    CLEAN = auto()
    """The image is final: drop what was kept to go on rendering."""
    CALL_BACK = auto()
    """Tell the job's callback address, if it has one."""


class Refused(Exception):
    """The event does not fit the state the job is in. The text says why, for the user."""


def transition(status: Status, event: Event) -> tuple[Status, list[Command]]:
    """The status after `event`, and the commands that follow from it. Raises `Refused`."""
    state = status.state
    match event:
        case Started() if state is State.QUEUED:
            return replace(status, state=State.RUNNING), []
        case Paused() if state in (State.QUEUED, State.RUNNING):
            return replace(status, state=State.PAUSED), [Command.WITHDRAW]
        case Resumed() if state is State.PAUSED:
            return replace(status, state=State.QUEUED, crashes=0), [Command.ENQUEUE]
        case Paused() if state is State.PAUSED:
            return status, []
        case Resumed() if state in (State.QUEUED, State.RUNNING):
            return status, []
        case Cancelled() if not state.final:
            return replace(status, state=State.CANCELLED), [Command.WITHDRAW, Command.CALL_BACK]
        case Finished() if state is State.RUNNING:
            return replace(status, state=State.DONE, crashes=0), [Command.CLEAN, Command.CALL_BACK]
        case Failed(path, message) if state in (State.QUEUED, State.RUNNING):
            return _fail(status, path, message)
        case Crashed(alone) if state is State.RUNNING:
            return _crash(status, alone)
        case Cleared() if state is State.RUNNING:
            return replace(status, crashes=0), []
        case Retried() if state in (State.FAILED, State.CANCELLED):
            return Status(State.QUEUED), [Command.ENQUEUE]
        case Recovered():
            return _recover(status)
    raise Refused(_reason(state, event))


def _fail(status: Status, path: str, message: str) -> tuple[Status, list[Command]]:
    failed = replace(status, state=State.FAILED, error_path=path, error_message=message)
    return failed, [Command.WITHDRAW, Command.CALL_BACK]


def _crash(status: Status, alone: bool) -> tuple[Status, list[Command]]:
    # Several jobs may have been in flight: the first death in company makes a suspect, but proves nothing more.
    crashes = status.crashes + 1 if alone else max(status.crashes, 1)
    if crashes < TRIES:
        return replace(status, crashes=crashes), []
    message = f"the worker process died {TRIES} times while it rendered this job; the scene seems to crash the renderer"
    return _fail(replace(status, crashes=crashes), "", message)


def _recover(status: Status) -> tuple[Status, list[Command]]:
    if status.state in (State.QUEUED, State.RUNNING):
        # Which chunks were under suspicion went with the old process: the job starts with a clean slate.
        return replace(status, state=State.QUEUED, crashes=0), [Command.ENQUEUE]
    if status.state is State.DONE:
        return status, [Command.CLEAN]
    return status, []


def _reason(state: State, event: Event) -> str:
    if isinstance(event, Retried):
        return f"only a failed or cancelled job can be retried; this one is {state}"
    if state.final:
        return f"the job has ended ({state}) and cannot be changed; retry it, or submit it again"
    return f"the job is {state}, which does not allow '{type(event).__name__.lower()}'"
