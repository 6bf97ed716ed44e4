"""A PostgreSQL server of its own, for as long as the tests need it."""

import os
import pwd
import shutil
import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_VERSIONS = Path("/usr/lib/postgresql")  # where Debian puts them


def binaries() -> Path | None:
    """The folder of initdb and pg_ctl; None where PostgreSQL is not installed."""
    found = sorted(_VERSIONS.glob("*/bin/initdb"))
    if found:
        return found[-1].parent
    on_path = shutil.which("initdb")
    return Path(on_path).parent if on_path else None


@contextmanager
def running(folder: Path) -> Iterator[str]:
    """Its SQLAlchemy URL. `folder` must be empty, and may be reached by everybody."""
    programs = binaries()
    assert programs, "install Debian's package postgresql (./dev test does)"
    data = folder / "cluster"
    user: list[str] = []
    if os.geteuid() == 0:  # which PostgreSQL refuses to be
        user = ["runuser", "-u", "postgres", "--"]
        owner = pwd.getpwnam("postgres")
        os.chown(folder, owner.pw_uid, owner.pw_gid)
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    options = f"-p {port} -c listen_addresses=127.0.0.1 -c unix_socket_directories='{folder}' -c fsync=off"
    control = [*user, programs / "pg_ctl", "-D", data, "-w", "-l", folder / "log"]
    run([*user, programs / "initdb", "-D", data, "-U", "tilecast", "-A", "trust", "--no-sync"], folder)
    run([*control, "-o", options, "start"], folder)
    try:
        yield f"postgresql+psycopg://tilecast@127.0.0.1:{port}/postgres"
    finally:
        run([*control, "-m", "immediate", "stop"], folder)


def run(command: list, folder: Path) -> None:
    # Not captured through a pipe: the server would inherit and hold it.
    with (folder / "output").open("w+") as output:
        done = subprocess.run(command, stdout=output, stderr=output, stdin=subprocess.DEVNULL, cwd=folder, timeout=60)
        output.seek(0)
        assert done.returncode == 0, output.read()
