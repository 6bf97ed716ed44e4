"""KEY=VALUE puts a value into a document."""

import pytest
from documents import example

from tilecast.scene import SceneError, override


@pytest.mark.parametrize("setting, path, value", [
    ("render.samples=16", ("render", "samples"), 16),
    ("render.integrator=whitted", ("render", "integrator"), "whitted"),
    ('render.integrator="whitted"', ("render", "integrator"), "whitted"),
    ("camera.position[1]=2.5", ("camera", "position", 1), 2.5),
    ("objects.part.of[0].of[1].radius=2", ("objects", "part", "of", 0, "of", 1, "radius"), 2),
    ('objects["a b"]={"type": "sphere", "radius": 1}', ("objects", "a b"), {"type": "sphere", "radius": 1}),
    ("background=[1, 2, 3]", ("background",), [1, 2, 3]),
    ("new.key.deep=1", ("new", "key", "deep"), 1),
    ("scene[0].material=a=b", ("scene", 0, "material"), "a=b"),
    ("render.stop=null", ("render", "stop"), None),
])
def test_puts_a_value_in_place(setting, path, value):
    document = example()
    changed = override(document, [setting])
    for part in path:
        changed = changed[part]
    assert changed == value
    assert document == example()


def test_the_last_of_two_counts_and_null_gives_way():
    document = override(example(), ["render.stop=null", "render.stop.seconds=1", "render.stop.seconds=2"])
    assert document["render"]["stop"] == {"seconds": 2}


@pytest.mark.parametrize("setting, path, message", [
    ("render.samples", "", "must be KEY=VALUE"),
    ('render={"seed": 1, "seed": 2}', "", "the setting has the key 'seed' twice"),
    ("=1", "", "the path is empty"),
    ("a b=1", "", "is not a path"),
    ("scene[7].material=x", "scene[7]", "cannot be set: scene is a list of 2"),
    ("render[0]=1", "render[0]", "cannot be set: render is an object"),
    ("camera.fov.deep=1", "camera.fov.deep", "cannot be set: camera.fov is 40"),
    ("scene.first=1", "scene.first", "cannot be set: scene is a list of 2"),
])
def test_what_cannot_be_set_is_told(setting, path, message):
    with pytest.raises(SceneError) as caught:
        override(example(), [setting])
    assert caught.value.path == path
    assert message in caught.value.message
