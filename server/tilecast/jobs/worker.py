"""What runs on a worker: compile a scene once, keep it, render its chunks.

Dask imports this module when it starts a worker of its own (`dask_setup`), and by name whenever a task arrives.
"""

import logging
import signal
import threading
from collections import OrderedDict
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from typing import Any, Generic, TypeVar

import numpy as np

from tilecast import _core, scene
from tilecast.jobs.blobs import Blobs, asset_key, scene_key
from tilecast.render.local import render_chunks, tile_first_hits
from tilecast.render.one_sample import with_command
from tilecast.render.plan import Chunk, Tile
from tilecast.render.rendering import ChunkResult

SCENES_KEPT = 4

Value = TypeVar("Value")


class Rejected(Exception):
    """The scene cannot be rendered, and trying again would not help. `errors`: (JSON path, message)."""

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
_places: Cache[Blobs] = Cache(4)


def prepare(blobs_url: str, digest: str, max_triangles: int) -> dict[str, Any]:
    """Compile the scene `digest`, so that its chunks find it ready. Returns its facts, for statistics.

    Raises `Rejected` where it cannot be compiled.
    """
    return _compiled(blobs_url, digest, max_triangles).facts()


def render(blobs_url: str, digest: str, max_triangles: int, chunks: Sequence[Chunk]) -> list[ChunkResult]:
    """The sums of chunks of the scene `digest`, one after the other.

    Raises `Rejected` where the scene cannot be compiled, or a sample of it is not a number.
    """
    compiled = _compiled(blobs_url, digest, max_triangles)
    try:
        return render_chunks(compiled, chunks)
    except _core.SampleError as error:
        raise Rejected([("", with_command(error))]) from None


def first_hits(blobs_url: str, digest: str, max_triangles: int, tile: Tile) -> np.ndarray:
    """What the camera sees first in a tile of the scene `digest`: float32 [h, w, 7]. Raises `Rejected` as `render`."""
    return tile_first_hits(_compiled(blobs_url, digest, max_triangles), tile)


def _compiled(blobs_url: str, digest: str, max_triangles: int) -> scene.Compiled:
    def make() -> scene.Compiled:
        blobs = _places.get(blobs_url, lambda: Blobs(blobs_url))

        def open_file(name: str) -> bytes:
            try:
                return blobs.get(asset_key(name.removeprefix("sha256:").split(".")[0]))
            except FileNotFoundError:
                raise scene.SceneError("", missing(name)) from None

        try:
            return scene.compile(scene.parse(blobs.get(scene_key(digest))), open_file, max_triangles=max_triangles)
        except scene.SceneError as error:
            raise Rejected(error.errors) from None
        except MemoryError:
            raise Rejected([("", "is too large: the worker has not enough memory for it")]) from None

    return _scenes.get(digest, make)


def missing(name: str) -> str:
    """What to say of an asset that is not there."""
    digest = name.removeprefix("sha256:").split(".")[0]
    return f"names the asset {name}, which is not on the server: send it first, with PUT /v1/assets/{digest}"


def dask_setup(_worker: object) -> None:
    """Set up the process of a local worker."""
    # Ctrl-C, which the terminal sends to every process of the service, is for the server: it stops the worker.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # That a worker is stopped in the middle of a chunk is no news.
    logging.getLogger("distributed.worker.state_machine").setLevel(logging.ERROR)
    # Nor is it that the scheduler, which ends together with it, did not answer its last heartbeat.
    logging.getLogger("distributed.worker").addFilter(lambda record: "scheduler during heartbeat" not in record.getMessage())
