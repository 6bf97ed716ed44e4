"""What the service refuses, and why. The texts are for the user."""

from collections.abc import Sequence


class Fault(Exception):
    """The base of them all."""


class BadScene(Fault):
    """The scene cannot be rendered, or not within the limits. `errors`: (JSON path, message), the first one first."""

    def __init__(self, errors: Sequence[tuple[str, str]]):
        super().__init__("; ".join(f"{path}: {message}" if path else message for path, message in errors))
        self.errors = list(errors)


class NoSuchJob(Fault):
    """There is no job of this name."""


class NotYet(Fault):
    """The job is there, but what was asked for is not."""


class Refused(Fault):
    """The job is in a state that does not allow this."""


class KeyReused(Fault):
    """The idempotency key came before with another request."""


class TooMany(Fault):
    """The user has too many jobs, or sends them too fast. `retry_after`: seconds to wait."""

    def __init__(self, message: str, retry_after: int):
        super().__init__(message)
        self.retry_after = retry_after


class CannotStart(Fault):
    """Something that the server needs is not to be had: the text says what, where, and how to mend it."""


class InUse(CannotStart):
    """Another server works on the same data."""
