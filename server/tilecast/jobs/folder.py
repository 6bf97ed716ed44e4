"""The data folder belongs to one server at a time."""

import fcntl
import os
from pathlib import Path
from typing import BinaryIO

from tilecast.jobs.faults import InUse


def lock_folder(folder: Path) -> BinaryIO:
    """Take the data folder for this server; closing the file, as the end of the process does, gives it back.

    Raises `InUse`, or `OSError` where the folder cannot be made.
    """
    folder.mkdir(parents=True, exist_ok=True)
    lock = open(folder / "lock", "a+b")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        lock.seek(0)
        owner = lock.read(20).decode("ascii", "replace").strip() or "unknown"
        lock.close()
        raise InUse(
            f"another server (process {owner}) works in the data folder {folder}; "
            "stop it, or choose another folder with --data"
        ) from None
    lock.truncate(0)
    lock.write(str(os.getpid()).encode())
    lock.flush()
    return lock
