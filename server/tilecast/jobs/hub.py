"""Tells listeners that something happened to a job. What it was, they read from the store: nothing can be missed."""

import threading
from collections import defaultdict
from collections.abc import Callable

Wake = Callable[[], None]


class Hub:
    """Listeners by job. `wake` functions must be quick and must not raise; they are called on any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._listeners: dict[str, set[Wake]] = defaultdict(set)
        self.closed = False
        """Whether the server is going down: listeners should let go."""

    def listen(self, job: str, wake: Wake) -> Callable[[], None]:
        """Call `wake` whenever something happens to `job`. Returns what ends it."""
        with self._lock:
            self._listeners[job].add(wake)

        def stop() -> None:
            with self._lock:
                listeners = self._listeners.get(job, set())
                listeners.discard(wake)
                if not listeners:
                    self._listeners.pop(job, None)

        return stop

    def notify(self, job: str) -> None:
        with self._lock:
            listeners = list(self._listeners.get(job, ()))
        for wake in listeners:
            wake()

    def close(self) -> None:
        """Wake everybody for the last time."""
        with self._lock:
            self.closed = True
            listeners = [wake for group in self._listeners.values() for wake in group]
        for wake in listeners:
            wake()

    def __len__(self) -> int:
        with self._lock:
            return sum(map(len, self._listeners.values()))
