"""Whatever is sent as a scene: the parser gives a Scene or a SceneError, never anything else."""

import json

import jsonschema_rs
from documents import example
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tilecast.scene import SceneError, files, override, parse, renamed, schema, schema_json, to_json

SCHEMA = jsonschema_rs.validator_for(schema_json())

numbers = st.one_of(st.integers(), st.floats(), st.sampled_from([0, -0.0, 1e-320, 1e308, 2**63, 2**1100, True]))
scalars = st.one_of(st.none(), st.booleans(), numbers, st.text(max_size=20))
values = st.recursive(scalars, lambda inner: st.one_of(
    st.lists(inner, max_size=5), st.dictionaries(st.text(max_size=8), inner, max_size=5)), max_leaves=20)

# Values that come near to what the format has: its own keys, kinds and names, put together at random.
KEYS = sorted({key for model in vars(schema).values() if isinstance(model, type) and issubclass(model, schema.Model)
               for key in model.model_fields} | {"part", "pyramid", "brass"})
KINDS = ["sphere", "box", "cylinder", "cone", "capsule", "torus", "quadric", "halfspace", "rectangle", "disk", "mesh",
         "union", "difference", "group", "diffuse", "mirror", "conductor", "dielectric", "plastic", "phong", "principled",
         "blend", "checker", "point", "area", "perspective", "part", "pyramid", "brass", "a.ply"]
near = st.recursive(
    st.one_of(scalars, st.sampled_from(KINDS), st.lists(st.floats(-2, 2), min_size=3, max_size=4)),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(
        st.sampled_from(KEYS), st.one_of(inner, st.sampled_from(KINDS)), max_size=6)), max_leaves=25)


def places(value, path=()):
    """The paths of all values in a document."""
    yield path
    children = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, child in children:
        yield from places(child, (*path, key))


PLACES = [path for path in places(example()) if path]


def judge(text):
    """Parses; where it is a scene, it is one for the JSON Schema as well, and comes back from its JSON."""
    try:
        scene = parse(text)
    except SceneError as error:
        assert error.message and "\n" not in str(error)
        str(error).encode("utf-8", "strict")
        return
    assert parse(to_json(scene)) == scene
    assert renamed(scene, {}) == to_json(scene)
    assert len(files(scene)) <= len(text)
    SCHEMA.validate(json.loads(text) if isinstance(text, (str, bytes)) else text)


@given(st.one_of(values, near))
def test_any_json(value):
    judge(json.dumps(value))


@given(st.binary(max_size=200))
def test_any_bytes(data):
    judge(data)


@given(st.text(alphabet='{}[]",:0123456789.eE+-\\ nulltruefalseNaN\n\ud800', max_size=80))
def test_anything_like_json(text):
    judge(text)


@settings(max_examples=300, suppress_health_check=[HealthCheck.too_slow])
@given(st.lists(st.tuples(st.sampled_from(PLACES), st.one_of(near, values)), min_size=1, max_size=3))
def test_a_scene_with_something_else_in_it(changes):
    document = example()
    for path, value in changes:
        here = document
        for part in path[:-1]:
            here = here[part] if isinstance(here, dict) and part in here or \
                isinstance(here, list) and isinstance(part, int) and part < len(here) else None
        if isinstance(here, dict) or isinstance(here, list) and isinstance(path[-1], int) and path[-1] < len(here):
            here[path[-1]] = value
    judge(json.dumps(document))


@given(st.lists(st.text(max_size=30), max_size=3), st.sampled_from(["", "render.", "objects.part", "scene[0]."]))
def test_any_setting(settings_, prefix):
    try:
        parse(override(example(), [prefix + setting for setting in settings_]))
    except SceneError as error:
        str(error)
