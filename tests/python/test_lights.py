"""Lights, backgrounds, cameras and filters as scenes give them; what they do is tested in the core."""

import numpy as np
import pytest
from documents import minimal

import tilecast
from tilecast import _images
from tilecast.scene import SceneError, digest, files, folder_opener, images, parse, renamed

FLOOR = {"object": {"type": "rectangle", "size": [20, 20]},
         "material": {"type": "diffuse", "reflectance": [1, 1, 1]}}
ABOVE = {"position": [0, 0.5, 0], "target": [0, 0, 0], "up": [1, 0, 0], "fov": 1e-6}


def irradiance(samples=4, integrator="path", **keys) -> float:
    document = minimal(scene=[FLOOR], image={"width": 4, "height": 4}, render={"integrator": integrator}, camera=ABOVE, **keys)
    return float(tilecast.render(tilecast.load(document), samples=samples).pixels[..., 0].mean()) * np.pi


def one(light, **keys) -> float:
    return irradiance(lights=[light], **keys)


@pytest.mark.parametrize("integrator", ["path", "direct", "whitted"])
def test_lights_shine_as_they_are_described(integrator):
    spot = {"type": "spot", "position": [0, 2, 0], "intensity": [8, 8, 8], "outer_angle": 40, "inner_angle": 20}
    for aim in ({"target": [0, 0, 0]}, {"direction": [0, -3, 0]}, {"target": [2 * np.tan(np.radians(19)), 0, 0]}):
        assert one({**spot, **aim}, integrator=integrator) == pytest.approx(2)
    x = (np.cos(np.radians(30)) - np.cos(np.radians(40))) / (np.cos(np.radians(20)) - np.cos(np.radians(40)))
    aside = {**spot, "direction": [np.sin(np.radians(30)), -np.cos(np.radians(30)), 0]}
    assert one(aside, integrator=integrator) == pytest.approx(2 * x * x * (3 - 2 * x))
    sun = {"type": "directional", "direction": [3, -4, 0], "irradiance": [5, 5, 5]}
    assert one(sun, integrator=integrator) == pytest.approx(4)
    ball = {"type": "area", "object": {"type": "sphere", "radius": 1e-4}, "radiance": [1e8] * 3,
            "transform": [{"translate": [0, 2, 0]}]}
    assert one(ball, integrator=integrator) == pytest.approx(np.pi / 4, rel=1e-5)


def test_features_name_what_is_used():
    def used(**keys):
        return set(tilecast.load(minimal(scene=[FLOOR], **keys)).facts()["features"]["used"])

    assert used() == {"diffuse", "rectangle"}
    point = {"type": "point", "position": [0, 1, 0], "intensity": [1, 1, 1]}
    assert used(lights=[point] * 4) == {"diffuse", "rectangle", "point_lights", "shadow_rays"}
    assert "light_tree" in used(lights=[point] * 5)
    spot = {"type": "spot", "position": [0, 1, 0], "target": [0, 0, 0], "intensity": [1, 1, 1]}
    assert "spot_lights" in used(lights=[spot])
    assert "directional_lights" in used(lights=[{"type": "directional", "direction": [0, -1, 0], "irradiance": [1, 1, 1]}])
    assert "environment" in used(background={"type": "sky"})
    assert {"lens", "pixel_filter"} <= used(
        camera={"type": "thin-lens", **ABOVE, "aperture": 0.1, "focus_distance": 1}, image={"filter": "tent"})


# --- Images from all around

def environment(folder, name="a.exr", **keys):
    """A background image of a gradient; its pixels."""
    pixels = np.linspace(0.1, 2, 8 * 4 * 3, dtype=np.float32).reshape(4, 8, 3)
    _images.write(str(folder / name), pixels, ["R", "G", "B"])
    return minimal(background={"type": "image", "file": name, **keys}, image={"width": 8, "height": 4},
                   camera={"type": "panorama", "position": [0, 0, 1], "target": [0, 0, 0]}), pixels


def test_a_panorama_shows_the_image(tmp_path):
    for keys, factor, roll in (({}, 1, 0), ({"scale": 2.0}, 2, 0), ({"rotation": 90}, 1, -2), ({"rotation": -45.0}, 1, 1)):
        document, pixels = environment(tmp_path, **keys)
        image = tilecast.render(tilecast.load(document, folder=tmp_path), samples=256).pixels
        expected = np.roll(pixels, roll, axis=1) * factor
        # The mean of what is interpolated over a pixel: 1/8, 3/4, 1/8, at the poles of the pixel itself.
        rows = np.pad(expected, ((1, 1), (0, 0), (0, 0)), mode="edge")
        expected = (rows[:-2] + 6 * rows[1:-1] + rows[2:]) / 8
        expected = (np.roll(expected, 1, axis=1) + 6 * expected + np.roll(expected, -1, axis=1)) / 8
        assert image == pytest.approx(expected, abs=0.02)


def test_files_of_images_are_files_of_the_scene(tmp_path):
    document, _ = environment(tmp_path)
    scene = parse(document)
    assert files(scene) == {"background.file": "a.exr"}
    asset = f"sha256:{'0' * 64}.exr"
    assert renamed(scene, {"a.exr": asset})["background"] == {"type": "image", "file": asset}
    first = digest(scene, folder_opener(tmp_path))
    environment(tmp_path, scale=1.0)
    assert digest(scene, folder_opener(tmp_path)) == first
    _images.write(str(tmp_path / "a.exr"), np.zeros((2, 4, 3), np.float32), ["R", "G", "B"])
    assert digest(scene, folder_opener(tmp_path)) != first


def refused(document, folder) -> SceneError:
    with pytest.raises(SceneError) as caught:
        tilecast.load(document, folder=folder)
    assert caught.value.path == "background.file"
    assert "\n" not in str(caught.value)
    return caught.value


def test_what_is_no_image_is_refused(tmp_path):
    document, _ = environment(tmp_path)
    whole = (tmp_path / "a.exr").read_bytes()
    for data, message in ((b"", "which is empty"), (b"garbage", "not a readable EXR image"),
                          (whole[:len(whole) // 2], "not a readable EXR image"),
                          (whole[:40] + bytes(200) + whole[240:], "not a readable EXR image")):
        (tmp_path / "a.exr").write_bytes(data)
        assert message in refused(document, tmp_path).message
    (tmp_path / "a.exr").unlink()
    assert "which is not in" in refused(document, tmp_path).message
    for name in ("b.hdr", "b.png"):
        (tmp_path / name).write_bytes(b"garbage")
        document["background"]["file"] = name
        assert "not a readable" in refused(document, tmp_path).message


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e31])
def test_pixels_that_are_no_radiance_are_refused(tmp_path, value):
    document, pixels = environment(tmp_path)
    pixels[2, 5, 1] = value
    _images.write(str(tmp_path / "a.exr"), pixels, ["R", "G", "B"])
    assert "pixel (5, 2) is " in refused(document, tmp_path).message


def test_an_image_of_zeros_is_no_light(tmp_path):
    document, _ = environment(tmp_path, scale=0.0)
    document["scene"] = [FLOOR]
    scene = tilecast.load(document, folder=tmp_path)
    assert "environment" not in scene.facts()["features"]["used"]
    assert not tilecast.render(scene, samples=4).pixels.any()


def test_images_come_as_linear_rgb(tmp_path):
    encoded = np.array([[[0, 10, 128], [255, 200, 3]]], np.uint8)
    _images.write(str(tmp_path / "a.png"), encoded, ["R", "G", "B"])
    share = encoded / 255
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    assert images.load((tmp_path / "a.png").read_bytes(), "a.png") == pytest.approx(linear, rel=1e-6)
    grey = np.array([[[0.25], [3]]], np.float32)
    _images.write(str(tmp_path / "grey.exr"), grey, ["Y"])
    assert np.array_equal(images.load((tmp_path / "grey.exr").read_bytes(), "grey.exr"), grey.repeat(3, axis=2))
    layers = np.arange(10, dtype=np.float32).reshape(1, 2, 5)
    _images.write(str(tmp_path / "layers.exr"), layers, ["B", "G", "R", "A", "Z"])
    loaded = images.load((tmp_path / "layers.exr").read_bytes(), "layers.exr")
    stored = dict(zip(_images.read(str(tmp_path / "layers.exr"))[1], range(5)))
    read = _images.read(str(tmp_path / "layers.exr"))[0]
    assert np.array_equal(loaded, read[..., [stored["R"], stored["G"], stored["B"]]])


def test_an_hdr_comes_with_its_common_exponents():
    header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n"
    pixels = images.load(header + bytes([128, 64, 32, 129, 255, 0, 16, 140]), "a.hdr")  # mantissa / 256 x 2^(e - 128)
    assert np.array_equal(pixels, np.float32([[[1, 0.5, 0.25], [255 * 16, 0, 256]]]))
    with pytest.raises(SceneError, match="not a readable HDR image"):
        images.load(header + bytes([128, 64]), "a.hdr")


def test_a_sky_lights_the_scene():
    noon, evening = (irradiance(64, background={"type": "sky", "sun_direction": sun}) for sun in ([0, 1, 0.2], [1, 0.1, 0]))
    assert noon > 2 * evening > 0
    assert irradiance(background={"type": "sky", "scale": 0}) == 0


# --- Cameras

SQUARE = {"object": {"type": "rectangle", "size": [2, 2]}, "transform": [{"rotate": [90, 0, 0]}]}


@pytest.mark.parametrize("camera", [{"type": "orthographic", "height": 3}, {"type": "panorama"},
                                    {"type": "thin-lens", "aperture": 0.2, "focus_distance": 5}, {"type": "perspective"}])
def test_all_cameras_serve_views_and_costs(camera):
    camera = {**camera, "position": [0, 0, 5], "target": [0, 0, 0]}
    for view in ("normals", "depth", "cost", "ambient-occlusion"):
        scene = tilecast.load(minimal(camera=camera, image={"width": 8, "height": 8, "filter": "gaussian"}, scene=[SQUARE],
                                      render={"integrator": view}))
        pixels = tilecast.render(scene, samples=4).pixels
        assert np.isfinite(pixels).all() and pixels.any()
    assert sum(scene.scene.camera_cost(0, 0, 8, 8)) > 0


def test_depth_of_parallel_rays_is_shown_from_the_nearest_to_the_farthest():
    document = minimal(camera={"type": "orthographic", "position": [30, 0, 5], "target": [30, 0, 0], "height": 2},
                       render={"integrator": "depth"},
                       scene=[{"object": {"type": "box", "min": [-1, -1, -1], "max": [1, 1, 1]}}])
    assert tilecast.load(document).facts()["shown"]["range"] == pytest.approx([4, 6])


def test_ambient_occlusion_has_a_reach():
    roof = {**SQUARE, "transform": [{"scale": 100}, {"translate": [0, 3, 0]}]}
    for reach, value in ((None, 0), (2.9, 1)):
        document = minimal(scene=[FLOOR, roof], camera=ABOVE, image={"width": 2, "height": 2},
                           render={"integrator": "ambient-occlusion", **({"ao_distance": reach} if reach else {})})
        assert tilecast.render(tilecast.load(document), samples=16).pixels.mean() == pytest.approx(value, abs=0.02)


def test_a_camera_without_a_type_is_a_pinhole():
    plain = {"position": [0, 0, 5], "target": [0, 0, 0]}
    a, b = (tilecast.render(tilecast.load(minimal(camera=camera, scene=[SQUARE], background=[1, 2, 3],
                                                  image={"width": 8, "height": 8})), samples=2).pixels
            for camera in (plain, {"type": "perspective", **plain}))
    assert np.array_equal(a, b)
    with pytest.raises(SceneError, match="camera.fow: is not a key that is known here; did you mean fov"):
        tilecast.load(minimal(camera={**plain, "fow": 3}))


# --- Emitters that light goes through

@pytest.mark.parametrize("integrator", ["path", "direct"])
@pytest.mark.parametrize("material, share", [
    ({"type": "diffuse", "reflectance": [0, 0, 0], "opacity": 0.5}, 0.5), ({"type": "dielectric"}, 1),
    ({"type": "blend", "of": [{"type": "diffuse", "reflectance": [0, 0, 0]}, {"type": "dielectric"}]}, 1)])
def test_a_small_lamp_that_light_goes_through_shows(integrator, material, share):
    lamp = {"object": {"type": "rectangle", "size": [0.2, 0.2]}, "material": {**material, "emission": [1, 1, 1]},
            "transform": [{"rotate": [90, 0, 0]}]}
    document = minimal(scene=[lamp], camera={"position": [0, 0, 5], "target": [0, 0, 0], "fov": 40},
                       image={"width": 32, "height": 32}, render={"integrator": integrator})
    found = tilecast.render(tilecast.load(document), samples=1024)
    expected = share * (0.2 * 32 / (10 * np.tan(np.radians(20)))) ** 2
    assert abs(found.pixels[..., 0].sum() - expected) < 4.5 * np.sqrt(found.variance[..., 0].sum()) + 1e-3 * expected


@pytest.mark.parametrize("integrator", ["path", "direct", "whitted"])
@pytest.mark.parametrize("around, hidden", [(None, False), ({"priority": -1}, False), ({"priority": 1}, True)])
def test_a_surface_shines_where_its_medium_counts(integrator, around, hidden):
    glass = {"type": "dielectric", "ior": 1}
    scene = [{"object": {"type": "disk", "radius": 2}, "material": FLOOR["material"]},
             {"object": {"type": "sphere", "radius": 0.5}, "material": {**glass, "emission": [1, 1, 1]},
              "transform": [{"translate": [0, 1.5, 0]}]}]
    if around:
        scene.append({"object": {"type": "sphere", "radius": 5}, "material": {**glass, **around}})
    document = minimal(scene=scene, image={"width": 4, "height": 4}, render={"integrator": integrator}, camera=ABOVE)
    found = float(tilecast.render(tilecast.load(document), samples=64).pixels[..., 0].mean())
    assert found == pytest.approx(0 if hidden else (0.5 / 1.5) ** 2, rel=0.01)
