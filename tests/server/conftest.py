"""Servers for tests: each with a data folder of its own, stopped when the test is over."""

import os
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from postgres import running
from servers import Server
from sqlalchemy import create_engine, text


@pytest.fixture
def make_server(tmp_path: Path) -> Iterator[Callable[..., Server]]:
    """Makes servers that end with the test."""
    servers = []

    def make(*options: str, name: str = "data", **environment: str) -> Server:
        server = Server(tmp_path / name, *options, **environment)
        servers.append(server)
        return server

    yield make
    for server in servers:
        server.close()


@pytest.fixture(scope="session")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """One server for all tests that leave it as they found it, but for some jobs more."""
    limits = {
        "TILECAST_MAX_BODY": "200000",
        "TILECAST_MAX_ASSET": "100000",
        "TILECAST_MAX_PIXELS": "20000",
        "TILECAST_MAX_SAMPLES": "100000",
        "TILECAST_MAX_DEPTH": "64",
        "TILECAST_MAX_TRIANGLES": "1000",
        "TILECAST_MAX_JOBS": "1000",
        "TILECAST_MAX_SUBMISSIONS": "100000/minute",
    }
    server = Server(tmp_path_factory.mktemp("shared") / "data", **limits)
    try:
        yield server.start()
    finally:
        server.close()


@pytest.fixture(scope="session")
def postgres_server() -> Iterator[str]:
    """The URL of a PostgreSQL server of our own."""
    with tempfile.TemporaryDirectory(prefix="tilecast-postgres-") as folder:
        os.chmod(folder, 0o755)
        with running(Path(folder)) as url:
            yield url


@pytest.fixture
def postgres_url(postgres_server: str) -> str:
    """The URL of an empty PostgreSQL database."""
    engine = create_engine(postgres_server, isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        connection.execute(text("DROP DATABASE IF EXISTS test WITH (FORCE)"))
        connection.execute(text("CREATE DATABASE test STRATEGY file_copy"))
    engine.dispose()
    return postgres_server.replace("/postgres", "/test")
