"""What the scene format takes, and the JSON Schema that says so."""

import json

import jsonschema_rs
import numpy as np
import pytest
from documents import EXAMPLE, example, minimal

from tilecast.scene import SceneError, override, parse, schema_json, to_json


@pytest.fixture(scope="module")
def validator():
    return jsonschema_rs.validator_for(schema_json())


def test_the_example_is_taken():
    scene = parse(json.dumps(EXAMPLE))
    assert scene.camera.position == [0, 2, 8]
    assert scene.objects["part"].of[0].of[1].radius == 1.35
    assert scene.render.stop.seconds == 60
    assert to_json(scene) == EXAMPLE


def test_what_is_left_out_has_a_default():
    scene = parse(minimal())
    assert (scene.image.width, scene.image.height, scene.render.samples) == (640, 480, 64)
    assert scene.scene == [] and scene.lights == [] and scene.background == [0, 0, 0]


@pytest.mark.parametrize("setting", [
    'scene[0].transform=[[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]',
    'scene[0].transform=[{"matrix": [[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]}]',
    'scene[0].transform=[{"scale": [-1, 2, 3]}, {"rotate": {"axis": [1, 1, 0], "angle": 45}}]',
    "scene[0].transform=[]",
    'scene[0].object={"object": "part"}',
    'objects.part.of[0]={"object": {"type": "sphere", "radius": 2}, "material": "glass", "transform": []}',
    'scene[0].material={"type": "mirror"}',
    'materials.brass.reflectance={"type": "checker", "even": [1, 1, 1], "odd": [0, 0, 0], "size": 0.5}',
    "materials.brass.emission=[1, 2, 1e6]",
    "materials.brass.opacity=0.5",
    'materials.brass={"type": "conductor", "metal": "gold", "roughness": 0.3}',
    'materials.brass={"type": "conductor", "eta": [0.2, 0.9, 1.1], "k": [3.9, 2.4, 2.2]}',
    'materials.brass={"type": "plastic", "reflectance": [0.2, 0.3, 0.1], "ior": 1.4, "roughness": 0.1}',
    'materials.brass={"type": "phong", "specular": [0.1, 0.1, 0.1], "exponent": 1000}',
    'materials.brass={"type": "principled", "metallic": 0.5, "transmission": 1, "opacity": 0.5}',
    'materials.brass={"type": "blend", "of": ["glass", {"type": "diffuse", "roughness": 1}], "weight": 0.25}',
    "materials.glass.priority=-3",
    "materials.glass.abbe=30",
    'objects.m={"type": "mesh", "file": "meshes/bunny.ply", "accelerator": "none"}',
    'objects.m={"type": "mesh", "file": "sha256:%s.glb"}' % ("0f" * 32),
    'objects.g={"type": "group", "of": []}',
    "render.samples=64.0",
    "render.integrator=whitted",
    "render.next_event=false",
    "render.sampler=independent",
    "render.roulette=false",
    'render={"integrator": "whitted", "contrast": 0.1}',
    "scene=[]",
])
def test_is_taken_by_parser_and_schema_alike(setting, validator):
    document = override(example(), [setting])
    if setting.startswith("scene[0].object="):
        with pytest.raises(SceneError):
            parse(document)  # a reference is not an object: a placement is written once
        assert not validator.is_valid(document)
    else:
        parse(document)
        validator.validate(document)


def test_the_schema_is_one_of_discriminated_unions(validator):
    schema = schema_json()
    jsonschema_rs.meta.validate(schema)
    kinds = schema["$defs"]["Object"]
    assert kinds["discriminator"]["propertyName"] == "type"
    assert set(kinds["discriminator"]["mapping"]) == {
        "sphere", "box", "cylinder", "cone", "capsule", "torus", "quadric", "halfspace", "rectangle", "disk", "mesh",
        "union", "intersection", "difference", "group"}
    assert "title" not in json.dumps(schema["$defs"]["Sphere"]["properties"])
    text = json.dumps(schema)
    assert "~" not in text and "Union_" not in text and "_Csg" not in text
    validator.validate(EXAMPLE)


@pytest.mark.parametrize("setting", ["camera=1", "objects.part.of[1].radius=-1", "render.samples=0", "image.width=20000",
                                     "foo=1", "objects.part.type=prism", "scene[0].transform=[{}]", "version=3"])
def test_the_schema_refuses_what_the_parser_refuses(setting, validator):
    document = override(example(), [setting])
    assert not validator.is_valid(document)
    with pytest.raises(SceneError):
        parse(document)


def test_arrays_are_taken_from_python():
    document = minimal(objects={"m": {"type": "mesh", "vertices": np.eye(3), "faces": np.array([[0, 1, 2]])}},
                       background=np.zeros(3, np.float32))
    assert parse(document).objects["m"].faces == [[0, 1, 2]]


def test_a_scene_cannot_be_changed():
    scene = parse(minimal())
    with pytest.raises(ValueError):
        scene.version = 2
