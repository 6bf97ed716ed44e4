"""What the store takes and gives: plain rows."""

from dataclasses import dataclass

from tilecast.jobs.state import State, Status


@dataclass(frozen=True)
class NewJob:
    """What a job is at its submission. See `tables.jobs`."""

    id: str
    owner: str
    name: str
    priority: int
    scene: str
    width: int
    height: int
    samples: int
    tile_size: int
    stop: dict
    adaptive: bool | None
    facts: dict | None
    callback: str | None
    idempotency_key: str | None
    request: str


@dataclass(frozen=True)
class Job:
    """A row of `tables.jobs`. Times are seconds since 1970."""

    number: int
    id: str
    owner: str
    name: str
    priority: int
    state: State
    crashes: int
    error_path: str | None
    error_message: str | None
    created: float
    started: float | None
    finished: float | None
    scene: str
    width: int
    height: int
    samples: int
    tile_size: int
    stop: dict
    adaptive: bool | None
    event: int
    progress: float
    seconds: float
    seconds_left: float | None
    relative_mse: float | None
    facts: dict | None
    statistics: dict | None
    callback: str | None
    callback_due: bool
    idempotency_key: str | None
    request: str

    @property
    def status(self) -> Status:
        return Status(self.state, self.crashes, self.error_path, self.error_message)


@dataclass(frozen=True)
class TileRow:
    """How far a tile is stored: `version` sample ranges, `samples` samples a pixel; `event`: its latest change;
    `relative_mse`: estimated, of it alone."""

    index: int
    version: int
    samples: int
    event: int = 0
    relative_mse: float | None = None


@dataclass(frozen=True)
class Occurrence:
    """One entry of a job's history: "state", "error", or "tile" with the data `index`, `version`, `samples`."""

    event: int
    type: str
    data: dict
