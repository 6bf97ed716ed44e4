"""A preload for workers: makes certain scenes kill the process that renders them, or hold its threads for good, as native
code would."""

import ctypes
import threading

from tilecast.jobs import worker

# The seeds of those scenes.
CRASHES_WHILE_COMPILING = 666
CRASHES_IN_ONE_TILE = 667
NEVER_ENDS = 668
NEVER_ENDS_IN_ONE_CHUNK = 669


def crash() -> None:
    ctypes.string_at(0)  # SIGSEGV


def dask_setup(_worker: object) -> None:
    render_chunk, compiled_scene = worker.render_chunk, worker._compiled

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

    worker.render_chunk, worker._compiled = render, compile
