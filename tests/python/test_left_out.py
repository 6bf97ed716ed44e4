"""What a build may leave out are features of the core, by their names."""

import re
import subprocess
from pathlib import Path

import pytest

from tilecast import _core

BUILT = Path(__file__).resolve().parents[2] / "core" / "base" / "built.h"


def compiled(left_out: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["c++", "-std=c++20", "-fsyntax-only", "-x", "c++", f"-DTILECAST_WITHOUT={left_out}", BUILT],
                          capture_output=True, text=True)


def test_what_can_be_left_out_are_features():
    listed = re.search(r"kCanBeLeftOut\[\]\{(.*?)\}", BUILT.read_text(), re.DOTALL)[1]
    names = re.findall(r'"(\w+)"', listed)
    assert names and not set(names) - set(_core.FEATURES)
    result = compiled(",".join(f'"{name}"' for name in names))
    assert result.returncode == 0, result.stderr


@pytest.mark.parametrize("left_out", ['"textures"', '"texture","instances"'])
def test_what_cannot_be_left_out_is_refused(left_out):
    result = compiled(left_out)
    assert result.returncode != 0 and "cannot be left out" in result.stderr
