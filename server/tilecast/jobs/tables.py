"""The tables of the database. `store.Store` is the only one that reads and writes them.

A job's `event` counts everything that can be seen to happen to it: tiles carry the number of their latest change, and
`events` holds the rest. What a listener has missed is whatever has a higher number than the last one it saw; nothing
grows with the time that a job takes.
"""

from sqlalchemy import (
    JSON,
    BigInteger,
    Boolean,
    Column,
    Float,
    ForeignKey,
    Index,
    Integer,
    MetaData,
    String,
    Table,
    Text,
    UniqueConstraint,
)

metadata = MetaData()

# SQLite counts up by itself only in a column of type INTEGER.
_Serial = BigInteger().with_variant(Integer, "sqlite")

jobs = Table(
    "jobs",
    metadata,
    Column("number", _Serial, primary_key=True, autoincrement=True),  # the order of submission
    Column("id", String(32), nullable=False, unique=True),
    Column("owner", String(255), nullable=False),
    Column("name", Text, nullable=False),
    Column("priority", Integer, nullable=False),
    Column("state", String(16), nullable=False),
    Column("crashes", Integer, nullable=False, default=0),
    Column("error_path", Text),
    Column("error_message", Text),
    Column("created", Float, nullable=False),  # seconds since 1970, as are the next two
    Column("started", Float),
    Column("finished", Float),
    Column("scene", String(64), nullable=False),  # SHA-256 of the scene's JSON
    Column("width", Integer, nullable=False),
    Column("height", Integer, nullable=False),
    Column("samples", Integer, nullable=False),
    Column("tile_size", Integer, nullable=False),
    Column("stop", JSON, nullable=False),  # {"relative_mse", "seconds"}, either may be missing
    Column("adaptive", Boolean),
    Column("event", Integer, nullable=False, default=0),
    Column("progress", Float, nullable=False, default=0.0),
    Column("seconds", Float, nullable=False, default=0.0),  # spent rendering
    Column("seconds_left", Float),
    Column("relative_mse", Float),
    Column("facts", JSON),  # of the compiled scene, once it was compiled
    Column("statistics", JSON),
    Column("callback", Text),
    Column("callback_due", Boolean, nullable=False, default=False),
    Column("idempotency_key", String(255)),
    Column("request", String(64), nullable=False),  # SHA-256 of the request's body
    UniqueConstraint("owner", "idempotency_key"),
    Index("jobs_by_state", "state", "number"),
    Index("jobs_by_owner", "owner", "state"),
    Index("jobs_by_scene", "scene"),
    sqlite_autoincrement=True,
)

databases = Table("databases", metadata, Column("name", String(32), primary_key=True))  # this one's name: one row

tiles = Table(
    "tiles",
    metadata,
    Column("job", String(32), ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True),
    Column("index", Integer, primary_key=True),
    Column("version", Integer, nullable=False),  # sample ranges added
    Column("samples", Integer, nullable=False),
    Column("event", Integer, nullable=False),
    Column("relative_mse", Float),
    Index("tiles_by_event", "job", "event"),
)

events = Table(
    "events",
    metadata,
    Column("job", String(32), ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True),
    Column("event", Integer, primary_key=True),
    Column("type", String(16), nullable=False),  # state | error
    Column("data", JSON, nullable=False),
)
