"""A preload for workers: makes certain scenes kill the process that renders them, or hold its threads for good, as native
code would, or makes them slow."""

import ctypes
import threading
import time

from tilecast.jobs import worker

PRELOAD = {"DASK_DISTRIBUTED__WORKER__PRELOAD": repr([__file__])}
"""The environment of a server whose workers load this."""

# The seeds of those scenes.
CRASHES_WHILE_COMPILING = 666
CRASHES_IN_ONE_TILE = 667
NEVER_ENDS = 668
NEVER_ENDS_IN_ONE_CHUNK = 669
SLOW_FIRST_HITS = 670


def crash() -> None:
    ctypes.string_at(0)  # SIGSEGV


def dask_setup(_worker: object) -> None:
    render_chunks, compiled_scene, first_hits = worker.render_chunks, worker._compiled, worker.tile_first_hits

    def render(compiled, chunks):
        if compiled.document.render.seed == CRASHES_IN_ONE_TILE and any(chunk.tile.index == 3 for chunk in chunks):
            crash()
        if compiled.document.render.seed == NEVER_ENDS:
            threading.Event().wait()
        if compiled.document.render.seed == NEVER_ENDS_IN_ONE_CHUNK \
                and any((chunk.tile.index, chunk.first) == (0, 0) for chunk in chunks):
            threading.Event().wait()
        return render_chunks(compiled, chunks)

    def compile(*arguments):
        compiled = compiled_scene(*arguments)
        if compiled.document.render.seed == CRASHES_WHILE_COMPILING:
            crash()
        return compiled

    def first(compiled, tile):
        if compiled.document.render.seed == SLOW_FIRST_HITS:
            time.sleep(3)
        return first_hits(compiled, tile)

    worker.render_chunks, worker._compiled, worker.tile_first_hits = render, compile, first
