"""Textures say what their definitions say, at every kind of surface; what cannot be one is refused at its place."""

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from documents import minimal

import tilecast
from tilecast import _images, scene

WHITE = [1.0, 1.0, 1.0]
GLIMPSE = 1e-4  # degrees that a camera sees: a point
QUADRANTS = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [255, 255, 255]]], np.uint8)  # R G above, B W below
PLATE = {"type": "rectangle", "size": [2, 2]}


@pytest.fixture
def folder(tmp_path):
    """With images: quadrants.png, white.png, ramp.exr (0 to 1 in steps), odd.exr (out of range)."""
    def write(name, pixels):
        pixels = np.asarray(pixels)
        _images.write(str(tmp_path / name), pixels, list("RGBA")[:pixels.shape[2]])

    write("quadrants.png", QUADRANTS)
    write("white.png", np.full((3, 5, 3), 255, np.uint8))
    write("ramp.exr", np.tile(np.linspace(0, 1, 4, dtype=np.float32)[None, :, None], (2, 1, 3)))
    write("odd.exr", np.full((2, 2, 3), 1.5, np.float32))
    write("cut.png", np.dstack([np.full((1, 2, 3), 255, np.uint8), np.array([[0, 255]], np.uint8)]))
    write("metal.exr", np.tile(np.array([0.52, 0.55, 0.61], np.float32)[None, :, None], (2, 1, 3)))
    angle = math.radians(30)
    tilted = np.array([0.5 + 0.5 * math.sin(angle), 0.5, 0.5 + 0.5 * math.cos(angle)], np.float32)
    write("tilted.exr", np.tile(tilted, (2, 2, 1)))
    return tmp_path


def document(material, shape=PLATE, eye=(0, 5, 0), target=(0, 0, 0), up=(0, 0, -1), size=1, **keys):
    return minimal(camera={"type": "perspective", "position": list(eye), "target": list(target), "up": list(up),
                           "fov": GLIMPSE if size == 1 else 25}, image={"width": size, "height": size}, background=WHITE,
                   scene=[{"object": shape, "material": material}], **keys)


def load(folder, *arguments, **keys):
    return tilecast.load(document(*arguments, **keys), folder=folder)


def albedo(folder, texture, *arguments, **keys):
    """Of the point in the middle of the picture."""
    found = load(folder, {"type": "diffuse", "reflectance": texture}, *arguments, **keys)
    return np.array(found.scene.first_hits(0, 0, 1, 1, 1))[0, 0, :3]


def image(file, **keys):
    return {"type": "image", "file": file, **keys}


def refused(folder, material, shape=PLATE):
    with pytest.raises(scene.SceneError) as error:
        load(folder, material, shape)
    return str(error.value)


@pytest.mark.parametrize("kind", ["diffuse", "mirror", "conductor", "plastic", "phong", "principled"])
def test_a_white_texture_is_no_texture_bit_for_bit(folder, kind):
    name = "base_color" if kind == "principled" else "reflectance"
    extra = {"specular": [0.0, 0.0, 0.0]} if kind == "phong" else {}
    ball = {"type": "sphere", "radius": 1}
    plain, textured = (tilecast.render(load(folder, {"type": kind, name: value, **extra}, ball, size=8), samples=4).pixels
                       for value in (WHITE, image("white.png")))
    assert np.array_equal(plain, textured)


def test_an_image_is_interpolated_between_the_centres_of_its_pixels(folder):
    for wrap, beyond in [("clamp", lambda x: min(max(x, 0), 3)), ("repeat", None), ("mirror", None)]:
        for u in (0.03, 0.2, 0.5, 0.61, 0.99):
            x = 4 * u - 0.5
            low = math.floor(x)
            place = {"clamp": lambda i: min(max(i, 0), 3), "repeat": lambda i: i % 4,
                     "mirror": lambda i: min(max(i, 0), 3)}[wrap]  # inside the square a mirror is a clamp
            expected = (1 - (x - low)) * place(low) / 3 + (x - low) * place(low + 1) / 3
            at = 2 * u - 1
            got = albedo(folder, image("ramp.exr", wrap=wrap), eye=(at, 5, 0), target=(at, 0, 0))
            assert got == pytest.approx([expected] * 3, abs=1e-5)
    assert albedo(folder, image("ramp.exr", filter="closest"), eye=(0.1, 5, 0), target=(0.1, 0, 0)) == pytest.approx(2 / 3)
    tiled = image("ramp.exr", filter="closest", tiling=[2, 1], offset=[0.5, 0])  # 2 * 0.3 + 0.5 is 0.1 beyond
    assert albedo(folder, tiled, eye=(-0.4, 5, 0), target=(-0.4, 0, 0)) == pytest.approx([0.0] * 3)
    mirrored = image("ramp.exr", filter="closest", tiling=[2, 1], wrap="mirror")  # 1.8 stands for 0.2
    assert albedo(folder, mirrored, eye=(0.8, 5, 0), target=(0.8, 0, 0)) == pytest.approx([0.0] * 3)


@pytest.mark.parametrize("wrap, column", [("repeat", lambda i: i % 4), ("clamp", lambda i: min(max(i, 0), 3)),
                                          ("mirror", lambda i: min(i % 8, 7 - i % 8))])
def test_the_closest_pixel_is_the_one_that_the_place_lies_in(folder, wrap, column):
    corners = {"vertices": [[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]], "faces": [[0, 1, 2], [0, 2, 3]]}
    for u in (0, 0.25, 0.5, 0.6, 1, 1.25, 2, -0.25, -1, -1.1, 1 - 2**-24, -1e-30, 1e6):
        mesh = {"type": "mesh", **corners, "uvs": [[u, 0.5]] * 4}
        expected = column(math.floor(4 * float(np.float32(u)))) / 3
        assert albedo(folder, image("ramp.exr", wrap=wrap, filter="closest"), mesh) == pytest.approx([expected] * 3), u
    for u, v, expected in [(0, 0, [0, 0, 1]), (0, 0.5, [1, 0, 0]), (0.5, 0.49, WHITE), (0.9, 0.9, [0, 1, 0])]:
        mesh = {"type": "mesh", **corners, "uvs": [[u, v]] * 4}
        assert albedo(folder, image("quadrants.png", wrap=wrap, filter="closest"), mesh).tolist() == expected, (u, v)


def test_png_is_srgb_and_exr_linear_unless_told(folder):
    grey = np.full((1, 1, 3), 128, np.uint8)
    _images.write(str(folder / "grey.png"), grey, ["R", "G", "B"])
    linear = ((128 / 255 + 0.055) / 1.055) ** 2.4
    assert albedo(folder, image("grey.png")) == pytest.approx([linear] * 3, rel=1e-6)
    assert albedo(folder, image("grey.png", colour_space="linear")) == pytest.approx([128 / 255] * 3, rel=1e-6)


def test_colours_are_not_multiplied_by_the_alpha_channel(folder):
    pixel = np.array([[[200, 100, 50, 20]]], np.uint8)
    _images.write(str(folder / "faint.png"), pixel, list("RGBA"), {"oiio:UnassociatedAlpha": "1"})
    faint = image("faint.png", colour_space="linear")
    assert albedo(folder, faint) == pytest.approx([200 / 255, 100 / 255, 50 / 255], rel=1e-6)


@pytest.mark.parametrize("shape, eye, up", [
    (PLATE, (0, 5, 0), (0, 0, -1)),
    ({"type": "disk", "radius": 1}, (0, 5, 0), (0, 0, -1)),
    *[({"type": kind, **size}, eye, up) for kind, size in [
        ("box", {"min": [-1, -1, -1], "max": [1, 1, 1]}), ("box", {"min": [-1, -1, -1], "max": [1, 1, 1], "radius": 0.2})]
      for eye, up in [((5, 0, 0), (0, 1, 0)), ((-5, 0, 0), (0, 1, 0)), ((0, 0, 5), (0, 1, 0)), ((0, 0, -5), (0, 1, 0)),
                      ((0, 5, 0), (0, 0, -1)), ((0, -5, 0), (0, 0, 1))]],
    ({"type": "cylinder", "radius": 1, "height": 2}, (0, 5, 0), (0, 0, -1)),
    ({"type": "cone", "radius": 1, "top_radius": 0.5, "height": 2}, (0, -5, 0), (0, 0, 1)),
    ({"type": "sphere", "radius": 1}, (0, 0, 5), (0, 1, 0)),
    ({"type": "capsule", "radius": 0.5, "height": 1}, (0, 0, 5), (0, 1, 0)),
    ({"type": "torus", "radius": 1, "minor_radius": 0.4}, (0, 0, 5), (0, 1, 0)),
])
def test_an_image_stands_upright_and_is_not_mirrored_seen_from_outside(folder, shape, eye, up):
    eye, up = np.array(eye, float), np.array(up, float)
    right = np.cross(-eye, up) / 5
    for sideways, upwards, colour in [(-1, 1, [1, 0, 0]), (1, 1, [0, 1, 0]), (-1, -1, [0, 0, 1]), (1, -1, WHITE)]:
        target = 0.1 * (sideways * right + upwards * up)
        got = albedo(folder, image("quadrants.png", filter="closest"), shape, eye=tuple(eye + target), target=tuple(target),
                     up=tuple(up))
        assert got == pytest.approx(colour), (sideways, upwards)


def test_coordinates_of_a_sphere_are_its_longitude_and_latitude(folder):
    rng = np.random.default_rng(3)
    for direction in rng.normal(size=(8, 3)):
        x, y, z = direction / np.linalg.norm(direction)
        u, v = 0.5 + math.atan2(x, z) / (2 * math.pi), 0.5 + math.asin(y) / math.pi
        for along, expected in [("u", u), ("v", v)]:
            ramp = {"type": "gradient", "start": [0, 0, 0], "end": WHITE, "along": along}
            assert albedo(folder, ramp, {"type": "sphere", "radius": 2}, eye=(9 * x, 9 * y, 9 * z), up=(0.1, 1, 0.2)) == \
                pytest.approx([expected] * 3, abs=1e-6)


def test_gradients_and_checkers_follow_objects_or_coordinates(folder):
    for along, eye, expected in [("x", (0.5, 5, 0), 0.75), ("z", (0.3, 5, 0.5), 0.75), ("x", (-3, 5, 0), 0.0)]:
        ramp = {"type": "gradient", "start": [0, 0, 0], "end": WHITE, "along": along, "range": [-1, 1]}
        got = albedo(folder, ramp, {"type": "rectangle", "size": [8, 8]}, eye=eye, target=(eye[0], 0, eye[2]))
        assert got == pytest.approx([expected] * 3, abs=1e-5)
    checker = {"type": "checker", "even": WHITE, "odd": [0, 0, 0], "size": 0.5, "space": "uv"}
    for x, z, expected in [(-0.5, -0.5, 0), (0.5, -0.5, 1), (0.5, 0.5, 0)]:
        assert albedo(folder, checker, eye=(x, 5, z), target=(x, 0, z)) == pytest.approx([expected] * 3)


TETRAHEDRON = {"type": "mesh", "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
               "faces": [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]}


def test_a_mesh_with_seams_stays_closed_and_interpolates_its_corners(folder):
    mesh = TETRAHEDRON | {"uvs": [[0, 0], [1, 0], [0, 1], [0.5, 0.5]], "uv_faces": [[0, 1, 2], [3, 3, 3], [3, 3, 3], [0, 1, 2]]}
    cut = {"type": "difference", "of": [mesh, {"type": "sphere", "radius": 0.1}]}
    ramp = {"type": "gradient", "start": [0, 0, 0], "end": WHITE, "along": "u"}
    x, y = 0.25, 0.375  # of the slanted face, whose corners have u = 0, 1, 0: u is the second one's weight, y
    for shape in (mesh, cut):
        got = albedo(folder, ramp, shape, eye=(x + 4, y + 4, 4.375), target=(x, y, 1 - x - y), up=(0, 1, 0))
        assert got == pytest.approx([y] * 3, abs=1e-4)
    assert albedo(folder, ramp, mesh, eye=(0.2, -5, 0.2), target=(0.2, 0, 0.2), up=(0, 0, 1)) == pytest.approx([0.5] * 3)


def test_coordinates_come_from_mesh_files(folder):
    import trimesh
    (folder / "a.obj").write_text("v -1 0 1\nv 1 0 1\nv 1 0 -1\nv -1 0 -1\n"
                                  "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n")
    square = trimesh.Trimesh([[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]], [[0, 1, 2], [0, 2, 3]], process=False,
                             visual=trimesh.visual.TextureVisuals(uv=[[0, 0], [1, 0], [1, 1], [0, 1]]))
    for kind in ("ply", "glb"):
        (folder / f"a.{kind}").write_bytes(square.export(file_type=kind))
    for file in ("a.obj", "a.ply", "a.glb"):
        for x, z, colour in [(-0.5, -0.5, [1, 0, 0]), (0.5, -0.5, [0, 1, 0]), (-0.5, 0.5, [0, 0, 1])]:
            got = albedo(folder, image("quadrants.png", filter="closest"), {"type": "mesh", "file": file}, eye=(x, 5, z),
                         target=(x, 0, z))
            assert got == pytest.approx(colour), file


def test_holes_are_cut_out_by_an_alpha_channel(folder):
    net = {"type": "diffuse", "reflectance": [0, 0, 0], "opacity": image("cut.png", filter="closest")}
    for x, seen in [(-0.5, 1.0), (0.5, 0.0)]:
        plate = load(folder, net, eye=(x, 5, 0), target=(x, 0, 0))
        assert tilecast.render(plate, samples=4).pixels[0, 0] == pytest.approx([seen] * 3)
    below = load(folder, net)  # light through the holes alone: a shadow with a sharp edge
    assert "opacity" in below.facts()["features"]["used"]
    shut = load(folder, {"type": "diffuse", "opacity": image("white.png")})
    assert "opacity" not in shut.facts()["features"]["used"]


@pytest.mark.parametrize("material", [
    {"type": "conductor", "reflectance": WHITE, "roughness": image("metal.exr")},
    {"type": "plastic", "reflectance": WHITE, "roughness": image("metal.exr")},
    {"type": "diffuse", "reflectance": WHITE, "roughness": {"type": "gradient", "start": 0, "end": 1}},
])
def test_textured_roughness_keeps_all_light(folder, material):
    plate = load(folder, material, eye=(3, 3, 2), up=(0, 1, 0), size=12)
    assert tilecast.render(plate, samples=256).pixels[4:8, 4:8].mean() == pytest.approx(1.0, abs=4e-3)


def test_a_textured_roughness_is_that_roughness(folder):
    """On a level of the tables, and between two of them."""
    for value in (0.5, 0.53):
        scenes = [load(folder, {"type": "conductor", "reflectance": [0.9, 0.5, 0.1], "roughness": roughness},
                       eye=(3, 3, 2), up=(0, 1, 0), size=4, render={"seed": 5})
                  for roughness in (value, {"type": "gradient", "start": value, "end": value})]
        plain, textured = (tilecast.render(found, samples=64).pixels for found in scenes)
        assert textured == pytest.approx(plain, abs=3e-3)


def test_a_level_normal_map_changes_nothing_and_a_tilted_one_loses_what_it_hides(folder):
    level = np.tile(np.array([0.5, 0.5, 1.0], np.float32), (2, 2, 1))
    _images.write(str(folder / "level.exr"), level, ["R", "G", "B"])
    for kind in ("diffuse", "mirror", "plastic"):
        plain, mapped = (tilecast.render(load(folder, {"type": kind, "reflectance": WHITE, **keys}), samples=16).pixels
                         for keys in ({}, {"normal_map": image("level.exr")}))
        assert mapped == pytest.approx(plain, abs=1e-5)
    # White and diffuse, in uniform light: a hemisphere about a normal that is tilted by a has (1 + cos a) / 2 in sight.
    bent = load(folder, {"type": "diffuse", "reflectance": WHITE, "normal_map": image("tilted.exr")})
    expected = (1 + math.cos(math.radians(30))) / 2
    assert tilecast.render(bent, samples=16384).pixels[0, 0] == pytest.approx([expected] * 3, abs=0.008)
    mirror = load(folder, {"type": "mirror", "normal_map": image("tilted.exr")}, eye=(5, 0.05, 0))
    assert tilecast.render(mirror, samples=4).pixels[0, 0] == pytest.approx(WHITE)  # even there no light is lost


@pytest.mark.parametrize("mirrored", [1, -1])
def test_a_normal_map_leans_towards_u(folder, mirrored):
    """Red above one half: the normal leans to where u grows, under mirroring transforms too. Lit from +x alone."""
    lit = document({"type": "diffuse", "reflectance": WHITE, "normal_map": image("tilted.exr")})
    lit |= {"background": [0, 0, 0], "lights": [{"type": "directional", "direction": [-1, -1, 0], "irradiance": WHITE}]}
    lit["scene"][0]["transform"] = [{"scale": [mirrored, 1, 1]}]
    cosine = math.cos(math.radians(45 - 30 if mirrored == 1 else 45 + 30))
    got = tilecast.render(tilecast.load(lit, folder=folder), samples=4).pixels[0, 0]
    assert got == pytest.approx([cosine / math.pi] * 3, rel=1e-5)


def test_an_image_shines_and_lights_what_is_around(folder):
    shining = {"type": "diffuse", "reflectance": [0, 0, 0],
               "emission": image("quadrants.png", factor=3.0, filter="closest")}
    found = load(folder, shining, eye=(0.5, 5, -0.5), target=(0.5, 0, -0.5))
    assert tilecast.render(found, samples=1).pixels[0, 0] == pytest.approx([0, 3, 0])
    def room(emission):
        lit = document({"type": "diffuse"}, {"type": "rectangle", "size": [0.5, 0.5]}, render={"max_depth": 2})
        lit["background"] = [0, 0, 0]
        lit["scene"].append({"object": PLATE, "transform": [{"rotate": [180, 0, 0]}, {"translate": [0, 1, 0]}],
                             "material": {"type": "diffuse", "emission": emission}})
        lit["camera"] |= {"position": [0, 0.5, 0]}
        return tilecast.render(tilecast.load(lit, folder=folder), samples=4096).pixels[0, 0]
    assert room(image("white.png", factor=2.0)) == pytest.approx(room([2.0, 2.0, 2.0]), rel=0.05)


def test_pixels_do_not_depend_on_threads_or_tiles(folder):
    made = load(folder, {"type": "plastic", "reflectance": image("quadrants.png", tiling=[7, 5]),
                         "normal_map": image("tilted.exr")}, {"type": "sphere", "radius": 1}, size=32).scene
    whole = made.render_chunk(0, 0, 32, 32, 0, 4).sums
    with ThreadPoolExecutor(3) as pool:
        for size in (8, 16):
            tiles = [(x, y) for y in range(0, 32, size) for x in range(0, 32, size)]
            parts = pool.map(lambda at: made.render_chunk(*at, size, size, 0, 4).sums, tiles)
            for (x, y), part in zip(tiles, parts):
                assert np.array_equal(whole[:, y:y + size, x:x + size], part)


def test_images_are_files_of_the_scene(folder):
    parsed = scene.parse(document({"type": "blend", "of": [{"type": "diffuse", "reflectance": image("a.png")},
                                                           {"type": "plastic", "roughness": image("b.png")}]},
                                  materials={"m": {"type": "mirror", "normal_map": image("c.exr")}}))
    assert scene.files(parsed) == {"materials.m.normal_map.file": "c.exr",
                                   "scene[0].material.of[0].reflectance.file": "a.png",
                                   "scene[0].material.of[1].roughness.file": "b.png"}
    assert set(scene.files(scene.parse(scene.renamed(parsed, {"a.png": "x.png", "c.exr": "y.exr"}))).values()) == \
        {"x.png", "b.png", "y.exr"}


@pytest.mark.parametrize("material, message", [
    ({"type": "diffuse", "reflectance": image("none.png")}, "material.reflectance.file: names the file 'none.png'"),
    ({"type": "diffuse", "reflectance": image("odd.exr")}, "material.reflectance: must lie between 0 and 1"),
    ({"type": "diffuse", "reflectance": image("a.gif")}, "material.reflectance.file: must end in"),
    ({"type": "diffuse", "reflectance": image("a.png", filtr="x")}, "material.reflectance.filtr: is not a key"),
    ({"type": "plastic", "roughness": image("ramp.exr", channel="a")}, "material.roughness.file: names the file 'ramp.exr', which has no channel a"),
    ({"type": "dielectric", "roughness": image("ramp.exr")}, "material.roughness: "),
    ({"type": "principled", "transmission": 1, "roughness": image("ramp.exr")}, "material.roughness: must be a number"),
    ({"type": "phong", "reflectance": image("white.png")}, "material.specular[0]: must be at most 1 together"),
    ({"type": "diffuse", "reflectance": {"type": "gradient", "start": WHITE, "end": WHITE, "range": [1, 1]}},
     "material.reflectance.range[1]: must be another number"),
    ({"type": "blend", "of": [{"type": "mirror", "normal_map": image("white.png")}, {"type": "mirror"}]},
     "material.of[0].normal_map: belongs to the blend"),
])
def test_what_cannot_be_a_texture_is_refused_at_its_place(folder, material, message):
    assert message in refused(folder, material)


@pytest.mark.parametrize("mesh, message", [
    (TETRAHEDRON, "has no texture coordinates"),
    (TETRAHEDRON | {"uvs": [[0, 0]]}, "uvs: must be as many as the 4 vertices"),
    (TETRAHEDRON | {"uvs": [[0, 0]], "uv_faces": [[0, 0, 1]] * 4}, "uv_faces[0][2]: must be the index of one of the 1 uvs"),
    (TETRAHEDRON | {"uv_faces": [[0, 0, 0]] * 4}, "uv_faces: needs uvs"),
])
def test_a_mesh_without_sound_coordinates_is_refused_at_its_place(folder, mesh, message):
    told = refused(folder, {"type": "diffuse", "reflectance": image("white.png")}, mesh)
    assert told.startswith("scene[0].object") and message in told


def test_a_mesh_needs_no_coordinates_where_no_texture_asks_for_them(folder):
    mixed = document({"type": "diffuse", "reflectance": image("white.png")})
    mixed["scene"].append({"object": TETRAHEDRON, "material": {"type": "mirror"}})
    assert tilecast.load(mixed, folder=folder).facts()["primitives"] == 5
