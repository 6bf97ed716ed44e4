"""How the database is opened: SQLite or PostgreSQL, by one server at a time."""

import time

from sqlalchemy import Connection, Engine, MetaData, create_engine, event, inspect, make_url, text
from sqlalchemy.exc import ArgumentError, SQLAlchemyError

from tilecast.jobs.faults import CannotStart, InUse

_OWNING_TRIES, _OWNING_PAUSE = 20, 0.1  # seconds
_POSTGRES_LOCK = 0x7469_6C65_6361_7374  # "tilecast"


def open_engine(url: str) -> Engine:
    """SQLAlchemy's engine for `url`. Raises `CannotStart` where it means nothing, or its driver is not installed."""
    try:
        engine = create_engine(url, pool_pre_ping=True)
    except (SQLAlchemyError, ImportError) as error:
        raise cannot_open(url, error) from None
    if engine.dialect.name == "sqlite":
        event.listen(engine, "connect", _set_up_sqlite)
    return engine


def own(engine: Engine) -> Connection | None:
    """Take the database for this server, until the connection that is returned is closed. Raises `InUse`.

    None for SQLite, which the lock of the data folder guards.
    """
    if engine.dialect.name != "postgresql":
        return None
    connection = engine.connect().execution_options(isolation_level="AUTOCOMMIT")
    # A server that was killed this moment may not be gone yet as PostgreSQL sees it.
    for _ in range(_OWNING_TRIES):
        if connection.scalar(text("SELECT pg_try_advisory_lock(:key)"), {"key": _POSTGRES_LOCK}):
            return connection
        time.sleep(_OWNING_PAUSE)
    connection.close()
    raise InUse("another Tilecast server uses this database; stop it, or give this one a database of its own")


def add_missing_columns(engine: Engine, metadata: MetaData) -> None:
    """Give the tables of an earlier version the columns that came since; those may be null."""
    known = inspect(engine)
    with engine.begin() as connection:
        for table in metadata.sorted_tables:
            there = {column["name"] for column in known.get_columns(table.name)}
            for column in table.columns:
                if column.name not in there:
                    kind = column.type.compile(engine.dialect)
                    connection.execute(text(f"ALTER TABLE {table.name} ADD COLUMN {column.name} {kind}"))


def cannot_open(url: str, error: Exception) -> CannotStart:
    """What to say where the database cannot be opened: one line, without the password."""
    try:
        shown = make_url(url).render_as_string(hide_password=True)
    except ArgumentError:
        shown = "at this URL"
    reason = str(getattr(error, "orig", None) or error).splitlines()[0]
    return CannotStart(f"cannot open the database {shown}: {reason}")


def _set_up_sqlite(connection, _record) -> None:
    cursor = connection.cursor()
    for pragma in ("journal_mode = WAL", "synchronous = FULL", "foreign_keys = ON", "busy_timeout = 10000"):
        cursor.execute(f"PRAGMA {pragma}")
    cursor.close()
