"""Reading the files of a scene while it is compiled."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator

from .. import _core
from .checks import Path
from .errors import SceneError
from .mesh_files import OpenFile, read_file
from .paths import text


class Loader:
    """Opens files, and times what is done with them. `seconds`: wall time so far."""

    def __init__(self, open_file: OpenFile):
        self.seconds = 0.0
        self._open_file = open_file

    @contextlib.contextmanager
    def file(self, name: str, path: Path) -> Iterator[bytes]:
        """The bytes of a file; what is found wrong with them is told at `path`, which names it."""
        start, where = time.perf_counter(), text(path)
        try:
            yield read_file(self._open_file, name, where)
        except SceneError as error:
            raise SceneError(where, error.message) from None
        except _core.Error as error:
            raise SceneError(where, f"names the file {name!r}: {error}") from None
        finally:
            self.seconds += time.perf_counter() - start
