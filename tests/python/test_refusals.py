"""Every kind of bad input is refused, with the JSON path of what is wrong and a message that says how to mend
it."""

import json
import time

import pytest
from documents import example, minimal

from tilecast.scene import SceneError, override, parse

SINGULAR = "[[1, 2, 3, 0], [4, 5, 6, 0], [7, 8, 9, 0], [0, 0, 0, 1]]"
FLAT = "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0], [0, 0, 0, 1]]"
PROJECTIVE = "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0.5, 1]]"


def refused(document) -> SceneError:
    with pytest.raises(SceneError) as caught:
        parse(document)
    error = caught.value
    assert error.errors[0] == (error.path, error.message)
    assert "\n" not in str(error)
    return error


@pytest.mark.parametrize("setting, path, message", [
    # Unknown keys
    ("colour=1", "colour", "is not a key that is known here; known are version, camera"),
    ("render.sampels=1", "render.sampels", "did you mean samples?"),
    ("render.stop.secs=1", "render.stop.secs", "did you mean seconds?"),
    ("camera.fow=1", "camera.fow", "did you mean fov?"),
    ("objects.part.of[1].radios=1", "objects.part.of[1].radios", "did you mean radius?"),
    ("objects.part.of[1].cylinder=1", "objects.part.of[1].cylinder", "is not a key that is known here"),
    ("camera.perspective=1", "camera.perspective", "is not a key that is known here"),
    ('objects={"type": "sphere", "sphere": {}}', "objects.type", 'must be an object {...}, got "sphere"'),
    ('objects={"sphere": {"type": "sphere"}}', "objects.sphere.radius", "is required"),
    ("materials.brass.ior=1", "materials.brass.ior", "is not a key that is known here"),
    ("scene[0].translate=[1, 2, 3]", "scene[0].translate", "is not a key that is known here"),
    ("scene[0].transform[0].rotate=[1, 2, 3]", "scene[0].transform[0].rotate", "is not a key that is known here"),
    ("lights[0].radius=1", "lights[0].radius", "is not a key that is known here"),
    # Wrong types
    ("render.samples=many", "render.samples", 'must be an integer, got "many"'),
    ("render.samples=1.5", "render.samples", "must be an integer, got 1.5"),
    ("render.samples=true", "render.samples", "must be an integer, got true"),
    ('camera.fov="40"', "camera.fov", 'must be a number, got "40"'),
    ("camera.position=[0, 0]", "camera.position", "needs at least 3 elements, got 2"),
    ("camera.position=[0, 0, 0, 0]", "camera.position", "takes at most 3 elements"),
    ('camera.position=[0, "x", 0]', "camera.position[1]", 'must be a number, got "x"'),
    ("camera=3", "camera", "must be an object {...}, got 3"),
    ("objects=[]", "objects", "must be an object {...}, got an empty list"),
    ("scene={}", "scene", "must be a list, got an object"),
    ("scene[0]=part", "scene[0]", 'must be an object {...}, got "part"'),
    ("scene[0].object=1", "scene[0].object", "must be an object {...}, got 1"),
    ("render.next_event=1", "render.next_event", "must be true or false, got 1"),
    ("materials.glass.abbe=0", "materials.glass.abbe", "must be at least 1, got 0"),
    ("render.contrast=0.1", "render.contrast", "is for the whitted integrator alone, got path"),
    ('render={"integrator": "whitted", "contrast": 0.1, "stop": {"relative_mse": 0.01}}', "render.stop.relative_mse",
     "cannot be had together with render.contrast: the estimated error leaves out"),
    ("render.contrast=0", "render.contrast", "must be positive, got 0"),
    ("scene[0].transform={}", "scene[0].transform", "must be a list, got an object"),
    ("scene[0].transform=[1]", "scene[0].transform[0]", "with one of the keys translate, scale, rotate, matrix"),
    ("objects.part.of[0]=box", "objects.part.of[0]", 'must be an object {...}, got "box"'),
    ("materials.brass.reflectance=0.5", "materials.brass.reflectance", "must be a list, got 0.5"),
    ("version=null", "version", "must be 1, got null"),
    # Missing keys and kinds
    ("objects.part.of[0].of[1]={\"type\": \"sphere\"}", "objects.part.of[0].of[1].radius", "is required"),
    ("objects.part.type=prism", "objects.part.type", 'must be one of sphere, box, cylinder, cone, capsule, torus'),
    ("objects.part={}", "objects.part.type", "is required"),
    ("camera.type=fisheye", "camera.type", "must be one of perspective, orthographic, thin-lens, panorama"),
    ("camera.type=orthographic", "camera.height", "is required"),
    ("lights[0].type=laser", "lights[0].type", "must be one of point, spot, directional, area"),
    ('background={"type": "cube"}', "background.type", "must be one of image, sky, got \"cube\""),
    ("lights[0]={\"type\": \"area\", \"radiance\": [1, 1, 1]}", "lights[0].object", "is required"),
    ("render.integrator=normal", "render.integrator", "must be path, direct, whitted, ambient-occlusion, normals"),
    ("render.view_range=[2, 2]", "render.view_range[1]", "must be greater than the first, 2, got 2"),
    ("render.accelerator=kdtree", "render.accelerator", 'must be auto, none, bvh'),
    ("image.filter=gauss", "image.filter", "must be box, tent, gaussian, blackman-harris or mitchell"),
    ("version=2", "version", "must be 1, got 2"),
    # Numbers that are none, or out of range
    ("camera.fov=NaN", "camera.fov", "must be a finite number, got NaN"),
    ("camera.fov=1e999", "camera.fov", "must be a finite number, got infinity"),
    ("camera.position[2]=-1e999", "camera.position[2]", "must be a finite number, got -infinity"),
    ("camera.fov=" + "9" * 400, "camera.fov", "must be a finite number, got a number of more than 40 digits"),
    ("camera.fov=180", "camera.fov", "must be less than 180, got 180"),
    ("camera.fov=0", "camera.fov", "must be greater than 0, got 0"),
    ("objects.part.of[0].of[1].radius=-0.5", "objects.part.of[0].of[1].radius", "must be positive, got -0.5"),
    ("objects.part.of[0].of[1].radius=0", "objects.part.of[0].of[1].radius", "must be positive, got 0"),
    ("objects.part.of[0].of[1].radius=1e-320", "objects.part.of[0].of[1].radius", "must be at least 1e-100"),
    ("objects.part.of[0].of[1].radius=1e200", "objects.part.of[0].of[1].radius", "must be at most 1e+100"),
    ('objects.a={"type": "cone", "radius": 0, "height": 1}', "objects.a.radius", "must be positive where top_radius is 0"),
    ('objects.a={"type": "cone", "radius": 1, "top_radius": -1, "height": 1}', "objects.a.top_radius", "at least 0, got -1"),
    ('objects.a={"type": "capsule", "radius": 1, "height": 0}', "objects.a.height", "must be positive, got 0"),
    ('objects.a={"type": "torus", "radius": 1}', "objects.a.minor_radius", "is required"),
    ('objects.a={"type": "torus", "radius": 1, "minor_radius": 2}', "objects.a.minor_radius",
     "must be at most radius = 1, got 2"),
    ('objects.a={"type": "box", "min": [0, 0, 0], "max": [1, 2, 3], "radius": 0.6}', "objects.a.radius",
     "must be at most half the shortest side, 0.5, got 0.6"),
    ('objects.a={"type": "box", "min": [0, 0, 0], "max": [1, 2, 3], "radius": 0}', "objects.a.radius", "must be positive"),
    ('objects.a={"type": "quadric", "coefficients": [0, 0, 0, 0, 0, 0, 0, 0, 0, 1], "min": [0, 0, 0], "max": [1, 1, 1]}',
     "objects.a.coefficients", "must not all be 0 but for the last"),
    ('objects.a={"type": "quadric", "coefficients": [1, 1, 1], "min": [0, 0, 0], "max": [1, 1, 1]}',
     "objects.a.coefficients", "needs at least 10 elements, got 3"),
    ('objects.a={"type": "quadric", "coefficients": [1, 1, 1, 0, 0, 0, 0, 0, 0, -1], "min": [0, 2, 0], "max": [1, 1, 1]}',
     "objects.a.max[1]", "must be greater than min[1] = 2, got 1"),
    ('objects.a={"type": "halfspace", "normal": [0, 0, 0]}', "objects.a.normal", "must not be [0, 0, 0]"),
    ('objects.a={"type": "disk", "radius": -2}', "objects.a.radius", "must be positive, got -2"),
    ("objects.part.of[0].of[0].max=[1, -1, 1]", "objects.part.of[0].of[0].max[1]", "must be greater than min[1] = -1"),
    ("render.samples=0", "render.samples", "must be at least 1, got 0"),
    ("render.samples=16777217", "render.samples", "must be at most 16777216, got 16777217"),
    ("render.max_depth=10001", "render.max_depth", "must be at most 10000"),
    ("render.seed=4294967296", "render.seed", "must be at most 4294967295"),
    ("render.seed=-1", "render.seed", "must be at least 0, got -1"),
    ("render.stop.seconds=0", "render.stop.seconds", "must be positive, got 0"),
    ("image.width=16385", "image.width", "must be at most 16384"),
    ("image.height=0", "image.height", "must be at least 1"),
    ("materials.brass.reflectance=[2, 0, 0]", "materials.brass.reflectance[0]", "must be at most 1, got 2"),
    ("materials.brass.roughness=-1", "materials.brass.roughness", "must be at least 0, got -1"),
    ("materials.glass.ior=0", "materials.glass.ior", "must be at least 0.001, got 0"),
    ("materials.glass.absorption=[0, 0, -1]", "materials.glass.absorption[2]", "must be at least 0, got -1"),
    ("materials.glass.priority=1.5", "materials.glass.priority", "must be an integer, got 1.5"),
    ("materials.glass.priority=1001", "materials.glass.priority", "must be at most 1000, got 1001"),
    ("materials.brass.priority=1", "materials.brass.priority", "is not a key that is known here"),
    ("materials.brass.metal=adamantium", "materials.brass.metal",
     'must be aluminium, brass, chromium, copper, gold, iron, platinum or silver, got "adamantium"'),
    ("materials.brass.metal=brass", "materials.brass.metal", "says the same as reflectance: give one of them"),
    ('materials.brass={"type": "conductor", "eta": [1, 1, 1]}', "materials.brass.eta", "needs k as well"),
    ('materials.brass={"type": "conductor", "eta": [0, 1, 1], "k": [1, 1, 1]}', "materials.brass.eta[0]", "at least 0.001"),
    ('materials.a={"type": "plastic", "ior": 0.9}', "materials.a.ior", "must be at least 1, got 0.9"),
    ('materials.a={"type": "phong", "reflectance": [0.5, 0.5, 0.5], "specular": [0, 0.6, 0]}', "materials.a.specular[1]",
     "must be at most 1 together with the reflectance 0.5, got 0.6"),
    ('materials.a={"type": "phong", "exponent": -1}', "materials.a.exponent", "must be at least 0, got -1"),
    ('materials.a={"type": "principled", "metallic": 2}', "materials.a.metallic", "must be at most 1, got 2"),
    ('materials.a={"type": "principled", "basecolor": [1, 1, 1]}', "materials.a.basecolor", "did you mean base_color?"),
    ('materials.a={"type": "blend", "of": ["brass"]}', "materials.a.of", "needs at least 2 elements, got 1"),
    ('materials.a={"type": "blend", "of": ["brass", "wood"]}', "materials.a.of[1]", "names the unknown material wood"),
    ('materials.a={"type": "blend", "of": ["glass", {"type": "dielectric"}]}', "materials.a.of[1]", "a second dielectric"),
    ('materials.a={"type": "blend", "of": ["brass", "a"]}', "materials.a.of[1]", "is a blend: a blend takes"),
    ('materials.a={"type": "blend", "of": ["brass", {"type": "blend", "of": []}]}', "materials.a.of[1].type",
     "must be one of diffuse, mirror"),
    ('materials.a={"type": "blend", "of": [{"type": "mirror", "emission": [1, 1, 1]}, "brass"]}', "materials.a.of[0]",
     "emission and opacity belong to the blend"),
    ('scene[0].material={"type": "blend", "of": ["brass", "wood"]}', "scene[0].material.of[1]",
     "names the unknown material wood"),
    ("materials.glass.opacity=1.1", "materials.glass.opacity", "must be at most 1, got 1.1"),
    ("background=[0, 1e31, 0]", "background[1]", "must be at most 1e+30"),
    # Cameras that see nothing
    ("camera.target=[0, 2, 8]", "camera.target", "must differ from position"),
    ("camera.up=[0, -2, -8]", "camera.up", "must not be parallel to the viewing direction"),
    ("camera.up=[0, 0, 0]", "camera.up", "must not be [0, 0, 0]"),
    ('camera={"type": "orthographic", "position": [0, 0, 1], "target": [0, 0, 0], "height": 0}', "camera.height",
     "must be positive, got 0"),
    ('camera={"type": "orthographic", "position": [0, 0, 1], "target": [0, 0, 0], "height": 1, "fov": 4}', "camera.fov",
     "is not a key that is known here; known are position, target, up, type, height"),
    ('camera={"type": "panorama", "position": [0, 0, 1], "target": [0, 0, 1]}', "camera.target", "must differ from position"),
    ('camera={"type": "thin-lens", "position": [0, 0, 1], "target": [0, 0, 0], "aperture": -1, "focus_distance": 1}',
     "camera.aperture", "must be at least 0, got -1"),
    ('camera={"type": "thin-lens", "position": [0, 0, 1], "target": [0, 0, 0], "aperture": 1}', "camera.focus_distance",
     "is required"),
    ("render.ao_distance=0", "render.ao_distance", "must be positive, got 0"),
    # Lights that point nowhere, and skies
    ('lights[0]={"type": "spot", "position": [0, 1, 0], "intensity": [1, 1, 1]}', "lights[0]",
     "needs either a target or a direction"),
    ('lights[0]={"type": "spot", "position": [0, 1, 0], "target": [0, 1, 0], "intensity": [1, 1, 1]}', "lights[0].target",
     "must differ from position"),
    ('lights[0]={"type": "spot", "position": [0, 1, 0], "direction": [0, 0, 0], "intensity": [1, 1, 1]}',
     "lights[0].direction", "must not be [0, 0, 0]"),
    ('lights[0]={"type": "spot", "position": [0, 1, 0], "target": [0, 0, 0], "intensity": [1, 1, 1], "inner_angle": 50}',
     "lights[0].inner_angle", "must be at most outer_angle = 45, got 50"),
    ('lights[0]={"type": "directional", "direction": [0, 0, 0], "irradiance": [1, 1, 1]}', "lights[0].direction",
     "must not be [0, 0, 0]"),
    ('background={"type": "sky", "sun_direction": [1, -1, 0]}', "background.sun_direction[1]", "below the horizon"),
    ('background={"type": "sky", "turbidity": 1}', "background.turbidity", "must be at least 2, got 1"),
    ('background={"type": "image"}', "background.file", "is required"),
    ('background={"type": "image", "file": "a.bmp"}', "background.file", "must end in .exr, .hdr, .png"),
    ('background={"type": "image", "file": "../a.exr"}', "background.file", "must be relative to the scene's folder"),
    ('background={"type": "image", "file": "a.exr", "scale": -1}', "background.scale", "must be at least 0, got -1"),
    # Names
    ("scene[0].object=prat", "scene[0].object", "names the unknown object prat; did you mean part?"),
    ("scene[0].object=", "scene[0].object", "must not be empty"),
    ("scene[1].material=wood", "scene[1].material", "names the unknown material wood; materials holds brass, glass"),
    ("objects.part.of[1].material=wood", "objects.part.of[1].material", "names the unknown material wood"),
    ("lights[1].object=lamp", "lights[1].object", "names the unknown object lamp"),
    # Objects in themselves
    ('objects.part.of[1]={"object": "part"}', "objects.part.of[1].object", "contains itself: part -> part"),
    ('objects.a={"type": "group", "of": [{"object": {"type": "group", "of": [{"object": "a"}]}}]}',
     "objects.a.of[0].object.of[0].object", "contains itself: a -> a"),
    # Open operands
    ('objects.part.of[1]={"type": "rectangle", "size": [1, 1]}', "objects.part.of[1]", "a rectangle is open"),
    ('objects.part.of[1]={"type": "disk", "radius": 1}', "objects.part.of[1]", "a disk is open and has no inside"),
    ("objects.part.of=[]", "objects.part.of", "needs at least 2 elements, got 0"),
    # Transforms
    ("scene[0].transform[0].scale=0", "scene[0].transform[0].scale", "must not be 0: the transform is singular"),
    ("scene[0].transform[0].scale=[1, 0, 1]", "scene[0].transform[0].scale[1]", "must not be 0"),
    (f"scene[0].transform={FLAT}", "scene[0].transform", "is singular: it flattens the object"),
    (f"scene[0].transform={SINGULAR}", "scene[0].transform", "is singular"),
    ('objects.part.of[1].transform=[{"rotate": [10, 20, 30]}, {"matrix": %s}, {"rotate": [3, 4, 5]}]' % FLAT,
     "objects.part.of[1].transform", "is singular"),
    (f"lights[1].transform={SINGULAR}", "lights[1].transform", "is singular"),
    (f"scene[0].transform={PROJECTIVE}", "scene[0].transform", "must have the last row 0 0 0 1"),
    ('scene[0].transform=[{"scale": 1e90}, {"scale": 1e90}, {"scale": 1e90}, {"scale": 1e90}]', "scene[0].transform",
     "overflows"),
    ("scene[0].transform=[[1, 0, 0, 0]]", "scene[0].transform", "needs at least 4 elements, got 1"),
    ('scene[0].transform=[{"rotate": {"axis": [0, 0, 0], "angle": 1}}]', "scene[0].transform[0].rotate.axis",
     "must not be [0, 0, 0]"),
    # Meshes
    ("objects.pyramid.faces[2][1]=4", "objects.pyramid.faces[2][1]", "one of the 4 vertices (from 0), got 4"),
    ("objects.pyramid.faces[2][1]=-1", "objects.pyramid.faces[2][1]", "one of the 4 vertices (from 0), got -1"),
    ("objects.pyramid.faces[2][1]=99999999999999999999", "objects.pyramid.faces[2][1]", "got 99999999999999999999"),
    ("objects.pyramid.faces=[]", "objects.pyramid.faces", "must not be empty"),
    ("objects.pyramid.faces[0]=[0, 1]", "objects.pyramid.faces[0]", "needs at least 3 elements"),
    ("objects.pyramid.faces[0]=[0, 1, 2, 3]", "objects.pyramid.faces[0]", "takes at most 3 elements"),
    ("objects.pyramid.vertices[3]=[0, NaN, 0]", "objects.pyramid.vertices[3][1]", "must be a finite number, got NaN"),
    ("objects.pyramid.file=a.ply", "objects.pyramid", "either a file or vertices and faces"),
    ('objects.m={"type": "mesh"}', "objects.m", "either a file or vertices and faces"),
    ('objects.m={"type": "mesh", "vertices": []}', "objects.m", "vertices and faces belong together"),
    ('objects.m={"type": "mesh", "file": "/etc/a.ply"}', "objects.m.file", "must be relative to the scene's folder"),
    ('objects.m={"type": "mesh", "file": "../a.ply"}', "objects.m.file", "must be relative to the scene's folder"),
    ('objects.m={"type": "mesh", "file": "C:\\\\a.ply"}', "objects.m.file", "must be relative to the scene's folder"),
    ('objects.m={"type": "mesh", "file": "http://x/a.ply"}', "objects.m.file", "must be a file and not an address"),
    ('objects.m={"type": "mesh", "file": "a.fbx"}', "objects.m.file", "must end in .ply, .obj, .stl, .glb"),
    ('objects.m={"type": "mesh", "file": "sha256:12.ply"}', "objects.m.file", "must be sha256:<64 hex digits>"),
    # Area lights
    ("lights[1].object.material=brass", "lights[1].object", "has a material of its own"),
])
def test_is_refused_with_its_place(setting, path, message):
    error = refused(override(example(), [setting]))
    assert error.path == path
    assert message in error.message


@pytest.mark.parametrize("text, message", [
    (b"", "is not JSON: Expecting value at line 1, column 1"),
    (b"{", "is not JSON"),
    (b'{\n "camera": {},}', "at line 2, column"),
    (b"\xff\xfe", "byte 0 is not UTF-8 text"),
    (b"[]", "must be an object {...}, got an empty list"),
    (b"null", "must be an object {...}, got null"),
    (b"[" * 1000, "is nested 1000 levels deep, more than 64 at line 1, column 65"),
    (b"[" * 1_000_000, "is nested 1000000 levels deep"),
    (b'{"a":' * 1000 + b"1" + b"}" * 1000, "is nested 1000 levels deep, more than 64 at line 1, column 321"),
    (b'{"seed": ' + b"1" * 5000 + b"}", "an integer of thousands of digits"),
])
def test_text_that_is_no_scene_is_refused(text, message):
    error = refused(text)
    assert error.path == ""
    assert message in error.message


def test_brackets_in_texts_are_no_nesting():
    error = refused(json.dumps(minimal(title="[" * 100 + '"' + "{" * 100)))
    assert error.path == "title"


def test_quotes_without_an_end_take_no_time():
    began = time.monotonic()
    assert refused('{"a": "' + '\\"' * 500_000).path == ""
    assert time.monotonic() - began < 5  # hours when each quote began a search of its own


def test_thousands_of_names_that_are_wrong_take_no_time():
    objects = {f"object_{i}": {"type": "sphere", "radius": 1} for i in range(5000)}
    began = time.monotonic()
    error = refused(minimal(objects=objects, scene=[{"object": f"objekt_{i}"} for i in range(5000)]))
    assert len(error.errors) == 100 and "objects holds 5000 others" in error.message
    assert time.monotonic() - began < 10


def test_a_key_that_stands_twice_is_refused_where_it_stands():
    assert refused('{"camera": {"fov": 1, "fov": 2}}').path == "camera.fov"
    assert refused('{"a": [1, {"b": 1, "c": 2, "b": 3}]}').path == "a[1].b"
    assert refused('{"a": {"b": 1, "b": 2}, "a": 3}').path == "a"


def test_a_dictionary_from_python_is_held_to_the_same_rules():
    loop = {}
    loop["camera"] = loop
    assert "contains itself" in refused(loop).message
    deep = value = {}
    for _ in range(100_000):
        value["a"] = value = {}
    assert "nested" in refused(deep).message
    assert "of type set has no place in JSON" in refused({"camera": {1, 2}}).message
    assert refused(minimal(background=[0, float("nan"), 0])).path == "background[1]"


def test_all_errors_are_told_and_the_first_is_the_error():
    document = override(example(), ["image.width=0", "image.height=-1", "scene[0].colour=1", "nothing=1"])
    error = refused(document)
    assert [path for path, _ in error.errors] == ["image.width", "image.height", "scene[0].colour", "nothing"]
    assert str(error) == "image.width: must be at least 1, got 0"


def test_a_million_errors_make_a_short_answer():
    error = refused(minimal(scene=[{"object": 1}] * 100_000))
    assert len(error.errors) == 100


def test_a_long_cycle_of_names_is_found_without_recursion():
    count = 20_000
    objects = {f"o{i}": {"type": "group", "of": [{"object": f"o{(i + 1) % count}"}]} for i in range(count)}
    error = refused(minimal(objects=objects))
    assert error.path == f"objects.o{count - 1}.of[0].object"
    assert "o0 -> o1" in error.message and len(error.message) < 200


def test_every_object_is_judged_even_if_nothing_uses_it():
    document = minimal(objects={"unused": {"type": "group", "of": [{"object": "nothing"}]}})
    assert refused(document).path == "objects.unused.of[0].object"


def test_strange_names_make_readable_paths():
    objects = {"my lens": {"type": "sphere", "radius": -1}, "Würfel": {"type": "sphere", "radius": -1}}
    assert [path for path, _ in refused(minimal(objects=objects)).errors] == \
        ['objects["my lens"].radius', 'objects["Würfel"].radius']
    refused('{"objects": {"\\ud800": {"type": "sphere"}}}').message.encode("utf-8")
