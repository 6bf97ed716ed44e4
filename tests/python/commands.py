"""The command line by subprocess."""

from __future__ import annotations

import subprocess
import sys

TILECAST = [sys.executable, "-m", "tilecast"]


def run(*arguments, cwd=None, **keys) -> subprocess.CompletedProcess:
    return subprocess.run([*TILECAST, *map(str, arguments)], capture_output=True, text=True, cwd=cwd, timeout=120, **keys)


def one_line(result: subprocess.CompletedProcess, status: int, *parts) -> None:
    """A failure is one line on stderr, and its status."""
    assert result.returncode == status, result.stderr
    assert result.stderr.endswith("\n") and result.stderr.count("\n") == 1, result.stderr
    for part in ("tilecast: ", *map(str, parts)):
        assert part in result.stderr
