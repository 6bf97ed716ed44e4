"""The page's modules on their own, run in the browser and compared with Python."""

import json

import numpy as np
import pytest
from watching import Watched

from tilecast.scene import paths


@pytest.fixture(scope="module")
def run(server, browser):
    """run(module, expression, argument): the expression sees the module as `m` and the argument as `a`."""
    watched = Watched(browser)
    page = watched.page
    page.goto(f"{server.url}/#/new")

    def run(module, expression, argument=None):
        return page.evaluate(f"async (a) => {{ const m = await import('/web/{module}'); return {expression}; }}", argument)

    yield run
    watched.close()
    assert watched.complaints == []


def test_every_half_float(run):
    page = run("half.js", "Array.from({length: 65536}, (_, bits) => String(m.fromHalf(bits)))")
    halves = np.arange(65536, dtype=np.uint16).view(np.float16).astype(np.float64)
    shown = np.array([float(text.replace("Infinity", "inf")) for text in page])
    np.testing.assert_array_equal(shown, halves)


@pytest.mark.parametrize(("exposure", "operator"), [(0, "clip"), (1.5, "clip"), (-2, "compress")])
def test_tone_table(run, exposure, operator):
    page = np.array(run("half.js", "Array.from(m.toneTable(a[0], a[1]))", [exposure, operator]))
    light = np.arange(0x7C00, dtype=np.uint16).view(np.float16).astype(np.float64) * 2.0**exposure
    level = np.minimum(light, 1) if operator == "clip" else light / (1 + light)
    encoded = np.where(level <= 0.0031308, 12.92 * level, 1.055 * level ** (1 / 2.4) - 0.055)
    np.testing.assert_array_equal(page[:0x7C00], np.floor(255 * encoded + 0.5))
    assert page[0x7C00] == 255 and not page[0x7C01:].any(), "infinity is white; NaN and negative light are black"


@pytest.mark.parametrize(
    ("text", "offset"),
    [
        ("", 0),
        ("{", 1),
        ('{"a": 1,}', 7),
        ("[1 2]", 3),
        ("{a: 1}", 1),
        ('{"a" 1}', 5),
        ("[nan]", 1),
        ("[1e]", 2),
        ("[01]", 2),
        ('["\n"]', 1),
        ('["\\x"]', 1),
        ("[1] 2", 4),
        ("[" * 70 + "]" * 70, 65),
    ],
)
def test_place_of_a_syntax_error(run, text, offset):
    assert run("json-places.js", "m.findSyntaxError(a)", text)["offset"] == offset


@pytest.mark.parametrize("value", [None, True, [], {}, -1.5e-7, "é\n\"\\\u2028😀", {"a b": [1, {"": [[], {}]}]}, [0, -0.0, 1e300]])
@pytest.mark.parametrize("indent", [None, 3])
def test_what_python_writes_is_json(run, value, indent):
    assert run("json-places.js", "m.findSyntaxError(a)", json.dumps(value, indent=indent)) is None
    assert run("json-places.js", "m.findSyntaxError(a)", json.dumps(value, indent=indent, ensure_ascii=False)) is None


def test_place_of_a_value(run):
    document = {"objects": {"lens": {"of": [{"radius": 1}, {"radius": -0.5}]}}, "scene": []}
    text = json.dumps(document, indent=1)

    def at(path):
        place = run("json-places.js", "m.locate(a[0], a[1])", [text, path])
        return json.loads(text[place["start"] : place["end"]])

    assert at("objects.lens.of[1].radius") == -0.5
    assert at("objects.lens.of[1]") == {"radius": -0.5}
    assert at("scene") == []
    assert at("") == document
    assert at("objects.lens.of[0].colour") == {"radius": 1}, "a missing key is a fault of what lacks it"


@pytest.mark.parametrize("key", ["a b", "a.b", "a[0]", 'say "a"', "a\\b", "é\n", ""])
def test_place_of_a_value_under_a_key_in_quotes(run, key):
    """As `tilecast.scene.paths` writes keys that are no names."""
    text = json.dumps({"objects": {key: {"radius": -1}, "a": 1, "b": 2}})
    place = run("json-places.js", "m.locate(a[0], a[1])", [text, paths.text(["objects", key, "radius"])])
    assert text[place["start"] : place["end"]] == "-1"


@pytest.mark.parametrize(
    ("call", "text"),
    [
        ("duration(0)", "0 s"),
        ("duration(0.0000016)", "1.6 µs"),
        ("duration(0.042)", "42 ms"),
        ("duration(0.9999)", "1.0 s"),
        ("duration(3.21)", "3.2 s"),
        ("duration(59.4)", "59 s"),
        ("duration(60)", "1 min 00 s"),
        ("duration(3599.6)", "1 h 00 min"),
        ("duration(86400 * 3 + 7200)", "3 d 2 h"),
        ("duration(NaN)", "–"),
        ("count(16777216)", "16\u202f777\u202f216"),
        ("short(2345678)", "2.35\u202fM"),
        ("bytes(512)", "512\u202fB"),
        ("scientific(0.00032)", "3.2·10⁻⁴"),
        ("scientific(0)", "0"),
        ("interval(0.0168, 0.0172)", "1.68·10⁻² to 1.72·10⁻²"),
        ("percent(0.9999)", "99%"),
        ("percent(1)", "100%"),
    ],
)
def test_numbers_as_a_person_reads_them(run, call, text):
    assert run("format.js", f"m.{call}") == text


@pytest.mark.parametrize("heavy", [True, False, None])
def test_statistics_say_where_rare_events_carry_the_error(run, heavy):
    text = run("statistics.js", "(() => { const table = m.statisticsTable(); table.set(a); return table.element.textContent; })()",
               {"error": {"relative_mse": 0.1, "heavy_tailed": heavy, "tail_share": 0.934}})
    assert ("93% of the error: it may be understated" in text) == bool(heavy)
