"""What is wrong with a scene, and where."""

from __future__ import annotations

from collections.abc import Sequence

from . import paths


class SceneError(ValueError):
    """A scene that cannot be rendered, named by its place in the JSON.

    `path` is the JSON path ("objects.lens.of[1].radius"; empty where the document as a whole is meant),
    `message` says what is wrong and how to mend it. `errors` lists every (path, message) that was found, at
    most 100; the first is `path` and `message`.
    """

    def __init__(self, path: str | Sequence[paths.Part], message: str,
                 errors: Sequence[tuple[str, str]] | None = None):
        self.path = path if isinstance(path, str) else paths.text(path)
        self.message = message
        self.errors = list(errors) if errors else [(self.path, message)]
        super().__init__(f"{self.path}: {message}" if self.path else message)

    def __reduce__(self):  # exceptions travel between processes: keep the parts, not the joined text
        return SceneError, (self.path, self.message, self.errors)

    def below(self, path: Sequence[paths.Part]) -> SceneError:
        """The same error as seen from a document in which it lies under `path`."""
        return SceneError(paths.text(path) + ("." + self.path if self.path else ""), self.message)
