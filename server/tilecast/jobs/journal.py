"""One thread that stores what happens, in the order in which it happened.

Results arrive faster than they can be committed one by one. The dispatcher's thread leaves a note here and goes on; by
the time that this thread comes to a job, many of its tiles may have changed, and one transaction takes them all.
"""

import threading
from collections.abc import Callable

import structlog

log = structlog.get_logger()

_RETRY_SECONDS = 1.0


class Journal:
    """Runs what is left here, first come, first served. What raises is run again a little later: a database that is
    away or a full disk must not lose anything that was rendered."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._entries: dict[object, Callable[[], None]] = {}  # in order of arrival
        self._closing = False
        self._thread = threading.Thread(target=self._run, name="journal", daemon=True)
        self._thread.start()

    def enter(self, action: Callable[[], None], key: object | None = None) -> None:
        """Run `action` on the journal's thread. One with the same `key` that still waits stands for both."""
        with self._changed:
            self._entries.setdefault(key if key is not None else object(), action)
            self._changed.notify()

    def close(self) -> None:
        """Run what is left, once, and end."""
        with self._changed:
            self._closing = True
            self._changed.notify()
        self._thread.join()

    def _run(self) -> None:
        while True:
            with self._changed:
                while not self._entries:
                    if self._closing:
                        return
                    self._changed.wait()
                key = next(iter(self._entries))
                action = self._entries.pop(key)
            while not self._succeeds(action):
                with self._changed:
                    # Waiting for the same condition: closing cuts it short.
                    if self._closing or self._changed.wait_for(lambda: self._closing, _RETRY_SECONDS):
                        break

    @staticmethod
    def _succeeds(action: Callable[[], None]) -> bool:
        try:
            action()
        except Exception:
            log.exception("journal_entry_failed")
            return False
        return True
