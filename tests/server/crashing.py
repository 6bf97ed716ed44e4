"""A preload for workers: makes certain scenes kill the process that renders them, as a fault in native code would."""

import ctypes

from tilecast.jobs import worker

# The seeds of those scenes.
CRASHES_WHILE_COMPILING = 666
CRASHES_IN_ONE_TILE = 667


def crash() -> None:
    ctypes.string_at(0)  # SIGSEGV


def dask_setup(_worker: object) -> None:
    render_chunk, compiled_scene = worker.render_chunk, worker._compiled

    def render(compiled, chunk):
        if compiled.document.render.seed == CRASHES_IN_ONE_TILE and chunk.tile.index == 3:
            crash()
        return render_chunk(compiled, chunk)

    def compile(*arguments):
        compiled = compiled_scene(*arguments)
        if compiled.document.render.seed == CRASHES_WHILE_COMPILING:
            crash()
        return compiled

    worker.render_chunk, worker._compiled = render, compile
