"""Clears away, before anything else starts, what a kill left between a commit and what should have followed it."""

from collections import defaultdict

import structlog

from tilecast.jobs.blobs import Blobs, database_key, job_prefix, scene_key, tile_key
from tilecast.jobs.faults import InUse
from tilecast.jobs.state import State
from tilecast.jobs.store import Store

log = structlog.get_logger()


def claim(store: Store, blobs: Blobs) -> None:
    """See that the blobs are this database's, and mark them so. Raises `InUse`: another's would be swept away."""
    name = store.name().encode()
    if blobs.has(database_key()):
        ours = blobs.get(database_key()) == name
    else:  # a new place, or an earlier version's
        ours = bool(store.states()) or not blobs.folders("jobs")
        if ours:
            blobs.put(database_key(), name)
    if not ours:
        raise InUse(f"the blobs at {blobs.url} belong to another database than this server's: give it that database, "
                    "or a place of its own with --blobs")


def sweep(store: Store, blobs: Blobs) -> None:
    """Delete every blob that nothing in the store needs. Nobody else may be at work."""
    blobs.delete_all("uploads")
    needed = {scene_key(digest) for digest in store.scenes()}
    blobs.delete(*(key for key in list(blobs.keys("scenes")) if key not in needed))

    found = defaultdict(list)
    for key in blobs.keys("jobs"):
        _, job, rest = key.split("/", 2)
        found[job].append((key, rest))
    states = store.states()
    for job, keys in found.items():
        state = states.get(job)
        if state is None:
            log.info("swept", job=job, blobs=len(keys))
            blobs.delete_all(job_prefix(job))
        elif state is State.DONE:
            blobs.delete(*(key for key, rest in keys if rest.startswith("tiles/")))
        else:
            known = {tile_key(job, tile.index, tile.version) for tile in store.tiles(job)}
            blobs.delete(*(key for key, rest in keys if rest.startswith("tiles/") and key not in known))
