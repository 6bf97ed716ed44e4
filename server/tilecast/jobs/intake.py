"""How a scene becomes a job: everything that may be wrong with it is found before it is accepted."""

import hashlib
import json
import secrets
import threading
import time
from concurrent.futures import TimeoutError
from dataclasses import dataclass
from typing import Any

import limits
import structlog

from tilecast import scene
from tilecast.jobs.blobs import Blobs, asset_key, scene_key
from tilecast.jobs.check import Check
from tilecast.jobs.faults import BadScene, TooMany
from tilecast.jobs.records import Job, NewJob
from tilecast.jobs.settings import Settings
from tilecast.jobs.state import State
from tilecast.jobs.store import Store
from tilecast.jobs.worker import Rejected, missing
from tilecast.render.dispatch import Dispatcher
from tilecast.render.plan import make_plan

log = structlog.get_logger()


@dataclass(frozen=True)
class Order:
    """Who wants a scene rendered, and how."""

    owner: str
    name: str = ""
    priority: int = 0
    callback: str | None = None
    idempotency_key: str | None = None


class Intake:
    """Checks scenes and makes jobs of them; keeps the scenes' blobs for as long as a job needs them."""

    def __init__(self, settings: Settings, store: Store, blobs: Blobs, dispatcher: Dispatcher):
        self._settings = settings
        self._store = store
        self._blobs = blobs
        self._dispatcher = dispatcher
        self._scenes = threading.Lock()  # from looking whether a scene is needed to acting on it
        self._rate = limits.parse(settings.max_submissions)
        self._window = limits.strategies.MovingWindowRateLimiter(limits.storage.MemoryStorage())

    def take(self, document: bytes | dict[str, Any], order: Order, body: bytes) -> tuple[Job, bool]:
        """Commit a job for the scene in `document`. Returns it and whether it is new.

        `body` is the whole request: the same one with the same idempotency key returns the job of the first time.
        """
        request = hashlib.sha256(body).hexdigest()
        if known := self._store.by_idempotency_key(order.owner, order.idempotency_key, request):
            return known, False
        self._slow_down(order.owner)
        # Before the work of checking the scene; `create` looks again, for those that came at the same time.
        self._store.check_room(order.owner, self._settings.max_jobs)
        try:
            parsed = scene.parse(document)
        except scene.SceneError as error:
            raise BadScene(error.errors) from None
        self._check_limits(parsed)
        self._check_files(parsed)
        digest = scene.digest(parsed)
        content = document if isinstance(document, bytes) else json.dumps(document).encode()
        try:
            self._keep(digest, content)
            facts = self._compile(digest, order.owner)
            return self._commit(parsed, digest, content, facts, order, request)
        except BaseException:
            self.release(digest)
            raise

    def release(self, digest: str) -> None:
        """Delete the scene's blob if no job needs it any more."""
        with self._scenes:
            if not self._store.needs_scene(digest):
                self._blobs.delete(scene_key(digest))

    def _slow_down(self, owner: str) -> None:
        if not self._window.hit(self._rate, owner):
            wait = self._window.get_window_stats(self._rate, owner).reset_time - time.time()
            raise TooMany(f"more than {self._rate} from you", max(1, round(wait)))

    def _check_limits(self, parsed: scene.schema.Scene) -> None:
        settings, image, render = self._settings, parsed.image, parsed.render
        errors = []
        if image.width * image.height > settings.max_pixels:
            asked = f"{image.width} x {image.height} = {image.width * image.height:,}"
            errors.append(("image", f"must have at most {settings.max_pixels:,} pixels on this server, got {asked}"))
        for path, value, most in (
            ("render.samples", render.samples, settings.max_samples),
            ("render.max_depth", render.max_depth, settings.max_depth),
        ):
            if value > most:
                errors.append((path, f"must be at most {most:,} on this server, got {value:,}"))
        if errors:
            raise BadScene(errors)

    def _check_files(self, parsed: scene.schema.Scene) -> None:
        errors = []
        checked: dict[str, bool] = {}
        for path, file in scene.files(parsed).items():
            if not file.startswith("sha256:"):
                advice = "a server has no files beside a scene; 'tilecast submit' sends them"
                errors.append((path, f"names the file {file!r}, but {advice}"))
                continue
            if file not in checked:
                digest = file.removeprefix("sha256:").split(".")[0]
                checked[file] = self._blobs.has(asset_key(digest))
            if not checked[file]:
                errors.append((path, missing(file)))
        if errors:
            raise BadScene(errors[:100])

    def _keep(self, digest: str, content: bytes) -> None:
        with self._scenes:
            if not self._blobs.has(scene_key(digest)):
                self._blobs.put(scene_key(digest), content)

    def _compile(self, digest: str, owner: str) -> dict[str, Any] | None:
        """The facts of the scene; None where they could not be had in time. Raises `BadScene`."""
        if self._settings.check_seconds == 0:
            return None
        check = Check(f"check-{secrets.token_hex(8)}", owner, self._blobs.url, digest, self._settings.max_triangles)
        self._dispatcher.add(check)
        try:
            return check.facts.result(self._settings.check_seconds)
        except Rejected as error:
            raise BadScene(error.errors) from None
        except TimeoutError:
            self._dispatcher.remove(check.key)
            log.info("accepted_unchecked", reason="workers are busy")
        except Exception as error:
            # The worker died, by this scene or by another one: the job will show.
            log.warning("accepted_unchecked", reason=repr(error))
        return None

    def _commit(
        self,
        parsed: scene.schema.Scene,
        digest: str,
        content: bytes,
        facts: dict[str, Any] | None,
        order: Order,
        request: str,
    ) -> tuple[Job, bool]:
        image, samples = parsed.image, parsed.render.samples
        new = NewJob(
            id=secrets.token_hex(8),
            owner=order.owner,
            name=order.name,
            priority=order.priority,
            scene=digest,
            width=image.width,
            height=image.height,
            samples=samples,
            tile_size=make_plan(image.width, image.height, samples, adaptive=parsed.render.adaptive).tile_size,
            stop=parsed.render.stop.model_dump(),
            adaptive=parsed.render.adaptive,
            facts=facts,
            callback=order.callback,
            idempotency_key=order.idempotency_key,
            request=request,
        )
        with self._scenes:
            # Another job's end may have taken the scene away in the meantime.
            if not self._blobs.has(scene_key(digest)):
                self._blobs.put(scene_key(digest), content)
            data = {"state": State.QUEUED, "priority": order.priority, "error": None}
            return self._store.create(new, self._settings.max_jobs, data)
