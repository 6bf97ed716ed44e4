"""The database: the truth about every job. SQLite by default, PostgreSQL by URL; SQLAlchemy Core speaks to both.

One server owns a database. Writers take turns through a lock of this process, so that a transaction never fails for
being too late; readers do not wait for them.
"""

import secrets
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, fields

from sqlalchemy import (
    Connection,
    RowMapping,
    delete,
    func,
    insert,
    select,
    union_all,
    update,
)
from sqlalchemy.exc import IntegrityError, SQLAlchemyError

from tilecast.jobs import database
from tilecast.jobs.faults import KeyReused, TooMany
from tilecast.jobs.records import Job, NewJob, Occurrence, TileRow
from tilecast.jobs.state import ACTIVE, State, Status
from tilecast.jobs.tables import databases, events, jobs, metadata, tiles

_STATE_EVENTS_KEPT = 32
_RETRY_SECONDS = 15


_JOB_FIELDS = [field.name for field in fields(Job)]


class Store:
    """Jobs, their tiles and their events. Every method is one transaction; all are safe to call from any thread."""

    def __init__(self, url: str):
        """Open the database, create its tables where they are missing, and own it. Raises `CannotStart`."""
        self._writing = threading.Lock()
        self._engine = database.open_engine(url)
        self._owning: Connection | None = None
        try:
            self._owning = database.own(self._engine)
            metadata.create_all(self._engine)
            database.add_missing_columns(self._engine, metadata)
        except BaseException as error:
            self.close()
            if isinstance(error, SQLAlchemyError):
                raise database.cannot_open(url, error) from None
            raise

    def close(self) -> None:
        if self._owning is not None:
            self._owning.close()
            self._owning = None
        self._engine.dispose()

    def name(self) -> str:
        """A name that this database keeps, unlike that of any other."""
        with self._write() as connection:
            if (known := connection.scalar(select(databases.c.name))) is None:
                known = secrets.token_hex(16)
                connection.execute(insert(databases).values(name=known))
            return known

    def ping(self) -> None:
        """Raise where the database does not answer."""
        with self._engine.connect() as connection:
            connection.execute(select(1))

    # -- jobs ---------------------------------------------------------------------------------------------------

    def create(self, new: NewJob, unfinished_limit: int, data: dict) -> tuple[Job, bool]:
        """Commit a job, queued, with `data` as its first state event. Returns it and whether it is new.

        The same idempotency key with the same request returns the job of the first time; with another one it raises
        `KeyReused`. Raises `TooMany` where the owner has `unfinished_limit` jobs that have not ended.
        """
        try:
            with self._write() as connection:
                if known := _by_key(connection, new.owner, new.idempotency_key, new.request):
                    return known, False
                _check_room(connection, new.owner, unfinished_limit)
                values = {field.name: getattr(new, field.name) for field in fields(NewJob)}
                values |= {"state": State.QUEUED, "created": time.time(), "event": 1}
                connection.execute(insert(jobs), values)
                connection.execute(insert(events), {"job": new.id, "event": 1, "type": "state", "data": data})
                return _job(connection, new.id), True
        except IntegrityError:
            # Another process of the same database was quicker with this key.
            if known := self.by_idempotency_key(new.owner, new.idempotency_key, new.request):
                return known, False
            raise

    def check_room(self, owner: str, unfinished_limit: int) -> None:
        """Raise `TooMany` where the owner has so many jobs that have not ended."""
        with self._engine.connect() as connection:
            _check_room(connection, owner, unfinished_limit)

    def by_idempotency_key(self, owner: str, key: str | None, request: str) -> Job | None:
        """The job that this request made before, if any. Raises `KeyReused`."""
        with self._engine.connect() as connection:
            return _by_key(connection, owner, key, request)

    def get(self, job: str) -> Job | None:
        with self._engine.connect() as connection:
            return _job(connection, job)

    def page(self, state: State | None, limit: int, before: int | None) -> tuple[list[Job], int | None]:
        """Up to `limit` jobs, newest first, whose `number` is below `before`; and the `before` of the next page."""
        query = select(jobs).order_by(jobs.c.number.desc()).limit(limit + 1)
        if state is not None:
            query = query.where(jobs.c.state == state)
        if before is not None:
            query = query.where(jobs.c.number < before)
        with self._engine.connect() as connection:
            found = [_to_job(row) for row in connection.execute(query).mappings()]
        return found[:limit], found[limit - 1].number if len(found) > limit else None

    def with_states(self, states: Sequence[State]) -> list[Job]:
        """All jobs in one of `states`, oldest first."""
        with self._engine.connect() as connection:
            query = select(jobs).where(jobs.c.state.in_(states)).order_by(jobs.c.number)
            return [_to_job(row) for row in connection.execute(query).mappings()]

    def callbacks_due(self) -> list[Job]:
        """Ended jobs whose callback address has not been told."""
        with self._engine.connect() as connection:
            query = select(jobs).where(jobs.c.callback_due).order_by(jobs.c.number)
            return [_to_job(row) for row in connection.execute(query).mappings()]

    def states(self) -> dict[str, State]:
        """The state of every job, by its id."""
        with self._engine.connect() as connection:
            return {row.id: State(row.state) for row in connection.execute(select(jobs.c.id, jobs.c.state))}

    def scenes(self) -> set[str]:
        """The digests of the scenes that some job needs."""
        with self._engine.connect() as connection:
            return set(connection.scalars(select(jobs.c.scene).distinct()))

    def needs_scene(self, digest: str) -> bool:
        with self._engine.connect() as connection:
            return connection.scalar(select(jobs.c.number).where(jobs.c.scene == digest).limit(1)) is not None

    def counts(self) -> dict[State, int]:
        """How many jobs there are in each state."""
        with self._engine.connect() as connection:
            rows = connection.execute(select(jobs.c.state, func.count()).group_by(jobs.c.state))
            return dict.fromkeys(State, 0) | {State(state): count for state, count in rows}

    def change(self, job: Job, status: Status, data: dict, **values) -> Job | None:
        """Give the job another status (and other `values`), if it still has the one of `job`; else return None.

        `data` becomes a state event.
        """
        with self._write() as connection:
            same = (jobs.c.id == job.id, jobs.c.state == job.state)
            values |= {
                "state": status.state,
                "crashes": status.crashes,
                "error_path": status.error_path,
                "error_message": status.error_message,
                "event": jobs.c.event + 1,
            }
            if connection.execute(update(jobs).where(*same).values(values)).rowcount != 1:
                return None
            changed = _job(connection, job.id)
            _add_state_event(connection, changed, data)
            return changed

    def set(self, job: str, **values) -> None:
        """Change columns that nobody listens for."""
        with self._write() as connection:
            connection.execute(update(jobs).where(jobs.c.id == job).values(values))

    def callback_told(self, job: Job) -> None:
        """Its address knows of the end that `job` tells of; not of one that came since, after a retry."""
        with self._write() as connection:
            this = (jobs.c.id == job.id, jobs.c.finished == job.finished)
            connection.execute(update(jobs).where(*this).values(callback_due=False))

    def delete(self, job: str) -> bool:
        """Forget the job. Returns whether it was there."""
        with self._write() as connection:
            return connection.execute(delete(jobs).where(jobs.c.id == job)).rowcount == 1

    # -- progress -----------------------------------------------------------------------------------------------

    def save_progress(self, job: str, changed: Sequence[TileRow], points: Sequence[dict], **values) -> list[int] | None:
        """Commit how far tiles are, new points of the error curve, and columns of the job (`progress`, `seconds`, ...).

        Points come first: the events of `points`, then those of `changed`, are numbered in the order given. Returns the
        versions that the changed tiles had before (0: none), or None where the job is gone.
        """
        with self._write() as connection:
            number = connection.scalar(select(jobs.c.event).where(jobs.c.id == job).with_for_update())
            if number is None:
                return None
            for point in points:
                number += 1
                connection.execute(
                    insert(events), {"job": job, "event": number, "type": "error", "data": point}
                )
            mine = (tiles.c.job == job, tiles.c.index.in_([tile.index for tile in changed]))
            rows = connection.execute(select(tiles.c.index, tiles.c.version).where(*mine))
            before = {row.index: row.version for row in rows}
            rows = [asdict(tile) | {"job": job, "event": number + 1 + k} for k, tile in enumerate(changed)]
            number += len(rows)
            # What is known is deleted, so that one statement can write all.
            if before:
                connection.execute(delete(tiles).where(*mine))
            if rows:
                connection.execute(insert(tiles), rows)
            connection.execute(update(jobs).where(jobs.c.id == job).values(values | {"event": number}))
            return [before.get(tile.index, 0) for tile in changed]

    def forget_tiles(self, job: str, indices: Sequence[int], points_kept: int) -> None:
        """Start these tiles again: what was stored of them cannot be read. Of the error curve, only the first
        `points_kept` points still hold."""
        with self._write() as connection:
            connection.execute(delete(tiles).where(tiles.c.job == job, tiles.c.index.in_(indices)))
            points = (events.c.job == job, events.c.type == "error")
            numbers = list(connection.scalars(select(events.c.event).where(*points).order_by(events.c.event)))
            void = numbers[points_kept:]
            connection.execute(delete(events).where(events.c.job == job, events.c.event.in_(void)))

    def tiles(self, job: str) -> list[TileRow]:
        with self._engine.connect() as connection:
            query = select(tiles).where(tiles.c.job == job).order_by(tiles.c.index)
            return [
                TileRow(row["index"], row["version"], row["samples"], row["event"], row["relative_mse"])
                for row in connection.execute(query).mappings()
            ]

    def tile_version(self, job: str, index: int) -> int:
        """Sample ranges that are stored of one tile."""
        with self._engine.connect() as connection:
            query = select(tiles.c.version).where(tiles.c.job == job, tiles.c.index == index)
            return connection.scalar(query) or 0

    def curve(self, job: str) -> list[dict]:
        """The data of the job's error events, in order."""
        with self._engine.connect() as connection:
            query = select(events.c.data).where(events.c.job == job, events.c.type == "error")
            return list(connection.scalars(query.order_by(events.c.event)))

    def since(self, job: str, event: int, limit: int = 1000) -> list[Occurrence] | None:
        """What happened to the job after `event`, in order, `limit` entries at most; None where the job is gone."""
        numbers = union_all(
            select(events.c.event).where(events.c.job == job, events.c.event > event),
            select(tiles.c.event).where(tiles.c.job == job, tiles.c.event > event),
        ).subquery()
        with self._engine.connect() as connection:
            # One statement sees one state of the database; the three below may see three. Entries only ever move to
            # higher numbers, so what moved away in between is met again later.
            if _job(connection, job) is None:
                return None
            first = select(numbers.c.event).order_by(numbers.c.event).limit(limit)
            wanted = list(connection.scalars(first))
            if not wanted:
                return []
            last = wanted[-1]
            told = connection.execute(
                select(events).where(events.c.job == job, events.c.event > event, events.c.event <= last)
            ).mappings()
            found = [Occurrence(row["event"], row["type"], row["data"]) for row in told]
            drawn = connection.execute(
                select(tiles).where(tiles.c.job == job, tiles.c.event > event, tiles.c.event <= last)
            ).mappings()
            for row in drawn:
                data = {name: row[name] for name in ("index", "version", "samples", "relative_mse")}
                found.append(Occurrence(row["event"], "tile", data))
        return sorted(found, key=lambda occurrence: occurrence.event)

    # -- the connection -----------------------------------------------------------------------------------------

    @contextmanager
    def _write(self) -> Iterator[Connection]:
        with self._writing, self._engine.begin() as connection:
            yield connection


def _to_job(row: RowMapping) -> Job:
    values = {name: row[name] for name in _JOB_FIELDS}
    return Job(**values | {"state": State(values["state"])})


def _job(connection: Connection, job: str) -> Job | None:
    row = connection.execute(select(jobs).where(jobs.c.id == job)).mappings().one_or_none()
    return _to_job(row) if row is not None else None


def _check_room(connection: Connection, owner: str, unfinished_limit: int) -> None:
    mine = (jobs.c.owner == owner, jobs.c.state.in_(ACTIVE))
    if connection.scalar(select(func.count()).select_from(jobs).where(*mine)) >= unfinished_limit:
        message = f"you have {unfinished_limit} jobs that have not ended; wait for one, or cancel one"
        raise TooMany(message, _RETRY_SECONDS)


def _by_key(connection: Connection, owner: str, key: str | None, request: str) -> Job | None:
    if key is None:
        return None
    query = select(jobs).where(jobs.c.owner == owner, jobs.c.idempotency_key == key)
    row = connection.execute(query).mappings().one_or_none()
    if row is None:
        return None
    if row["request"] != request:
        raise KeyReused("this Idempotency-Key came before with another request")
    return _to_job(row)


def _add_state_event(connection: Connection, job: Job, data: dict) -> None:
    connection.execute(insert(events), {"job": job.id, "event": job.event, "type": "state", "data": data})
    states = (events.c.job == job.id, events.c.type == "state")
    newest = select(events.c.event).where(*states).order_by(events.c.event.desc())
    oldest_kept = connection.scalar(newest.offset(_STATE_EVENTS_KEPT - 1).limit(1))
    if oldest_kept is not None:
        connection.execute(delete(events).where(*states, events.c.event < oldest_kept))
