"""JSON paths are written as they are read."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tilecast.scene import paths

parts = st.lists(st.one_of(st.integers(0, 10**6), st.text(min_size=1, max_size=80)), min_size=1, max_size=6)


@pytest.mark.parametrize("written, read", [
    ("render.samples", ["render", "samples"]),
    ("objects.lens.of[1].radius", ["objects", "lens", "of", 1, "radius"]),
    ('objects["my lens"].radius', ["objects", "my lens", "radius"]),
    ("scene[0].transform[2][3]", ["scene", 0, "transform", 2, 3]),
    ("objects.kebab-case", ["objects", "kebab-case"]),
])
def test_a_path_is_text_and_parts(written, read):
    assert paths.parse(written) == read
    assert paths.text(read) == written


@given(parts)
def test_every_path_comes_back_from_its_text(path):
    assert paths.parse(paths.text(path)) == path


@pytest.mark.parametrize("text", ["", ".", "a.", ".a", "a..b", "a[", "a[x]", "a[-1]", "a b", "[0]a", 'a["b]', "a[1"])
def test_what_is_no_path_is_refused(text):
    with pytest.raises(ValueError):
        paths.parse(text)


def test_a_long_key_is_cut_and_a_line_break_stays_inside_its_line():
    assert len(paths.text(["x" * 10_000])) < 100
    assert "\n" not in paths.text(["a\nb"])
