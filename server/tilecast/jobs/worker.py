"""What runs on a worker: compile a scene once, keep it, render its chunks.

Dask imports this module when it starts a local worker (`dask_setup`), and by name whenever a task arrives.
"""

import signal
import threading
from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import Future
from time import perf_counter
from typing import Generic, TypeVar

import numpy as np

from tilecast import _core, scene
from tilecast.jobs import blobs
from tilecast.render import ChunkResult

SCENES_KEPT = 4

Value = TypeVar("Value")


class Rejected(Exception):
    """The scene cannot be rendered, and trying again would not help. `errors`: (JSON path, message), the first one first."""

    def __init__(self, errors: list[tuple[str, str]]):
        super().__init__(errors)  # the arguments are what pickling carries
        self.errors = errors

    def __str__(self) -> str:
        return "; ".join(f"{path}: {message}" if path else message for path, message in self.errors)


class Cache(Generic[Value]):
    """The last few values by key. Each is made once, however many threads ask for it at the same time."""

    def __init__(self, capacity: int):
        self._capacity = capacity
        self._lock = threading.Lock()
        self._values: OrderedDict[str, Future[Value]] = OrderedDict()

    def get(self, key: str, make: Callable[[], Value]) -> Value:
        """The value under `key`, made by `make` where it is not there. An error of `make` is raised, and not kept."""
        with self._lock:
            value = self._values.get(key)
            first = value is None
            if first:
                value = self._values[key] = Future()
            self._values.move_to_end(key)
            while len(self._values) > self._capacity:
                self._values.popitem(last=False)
        if first:
            try:
                value.set_result(make())
            except BaseException as error:
                with self._lock:
                    if self._values.get(key) is value:
                        del self._values[key]
                value.set_exception(error)
        return value.result()


_scenes: Cache[scene.Compiled] = Cache(SCENES_KEPT)
_stores: Cache[blobs.Blobs] = Cache(4)
