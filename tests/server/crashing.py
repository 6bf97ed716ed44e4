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
    render_chunk, compiled_scene, first_hits = worker.render_chunk, worker._compiled, worker.tile_first_hits

    def render(compiled, chunk):
        if compiled.document.render.seed == CRASHES_IN_ONE_TILE and chunk.tile.index == 3:
            crash()
        if compiled.document.render.seed == NEVER_ENDS:
            threading.Event().wait()
        if compiled.document.render.seed == NEVER_ENDS_IN_ONE_CHUNK and (chunk.tile.index, chunk.first) == (0, 0):
            threading.Event().wait()
        return render_chunk(compiled, chunk)

    def compile(*arguments):
        compiled = compiled_scene(*arguments)
        if compiled.document.render.seed == CRASHES_WHILE_COMPILING:
            crash()
        return compiled

    def first(compiled, tile):
        if compiled.document.render.seed == SLOW_FIRST_HITS:
            time.sleep(3)
        return first_hits(compiled, tile)

    worker.render_chunk, worker._compiled, worker.tile_first_hits = render, compile, first
