"""Every material of the scene format reaches the core as what it is."""

import numpy as np
import pytest
from documents import minimal

import tilecast
from tilecast.scene.metals import METALS

WHITE = [1.0, 1.0, 1.0]


def seen(material, samples=4, **keys):
    """The colour of a plate, seen straight on in uniform light."""
    document = minimal(image={"width": 1, "height": 1}, camera={"position": [0, 0, 5], "target": [0, 0, 0], "fov": 0.01},
                       background=WHITE, scene=[{"object": {"type": "rectangle", "size": [1, 1], "transform": [
                           {"rotate": [90, 0, 0]}]}, "material": material}], **keys)
    return tilecast.render(tilecast.load(document), samples=samples).pixels[0, 0].astype(float)


def used(material, **keys):
    document = minimal(scene=[{"object": {"type": "sphere", "radius": 1}, "material": material}], **keys)
    return set(tilecast.load(document).facts()["features"]["used"]) - {"solid"}


@pytest.mark.parametrize("material, features", [
    ({"type": "diffuse"}, {"diffuse"}),
    ({"type": "diffuse", "roughness": 0.5}, {"diffuse", "oren_nayar"}),
    ({"type": "mirror", "opacity": 0.5}, {"mirror", "opacity"}),
    ({"type": "conductor", "metal": "gold"}, {"conductor"}),
    ({"type": "conductor", "roughness": 0.5}, {"conductor", "microfacets"}),
    ({"type": "dielectric", "roughness": 0.5, "absorption": [1, 0, 0]}, {"dielectric", "microfacets", "absorption"}),
    ({"type": "plastic"}, {"plastic"}),
    ({"type": "phong"}, {"phong"}),
    ({"type": "principled", "metallic": 1}, {"conductor", "microfacets"}),
    ({"type": "principled", "metallic": 0.5, "transmission": 0.5, "roughness": 0},
     {"blend", "conductor", "plastic", "dielectric"}),
    ({"type": "blend", "of": [{"type": "mirror"}, {"type": "diffuse"}]}, {"blend", "mirror", "diffuse"}),
])
def test_a_scene_uses_what_its_materials_need(material, features):
    assert used(material) == features


@pytest.mark.parametrize("metal", METALS)
def test_a_named_metal_reflects_straight_back_as_its_index_says(metal):
    eta, k = map(np.array, METALS[metal])
    expected = ((eta - 1) ** 2 + k ** 2) / ((eta + 1) ** 2 + k ** 2)
    assert seen({"type": "conductor", "metal": metal}) == pytest.approx(expected, rel=1e-6)
    assert seen({"type": "conductor", "eta": eta.tolist(), "k": k.tolist()}) == pytest.approx(expected, rel=1e-6)


def test_a_principled_material_is_what_it_is_made_of():
    colour, rough = [0.9, 0.5, 0.2], {"roughness": 0.3}
    for principled, plain in [
            ({"metallic": 1}, {"type": "conductor", "reflectance": colour}),
            ({"ior": 1.4}, {"type": "plastic", "reflectance": colour, "ior": 1.4}),
            ({"metallic": 0.25, "base_color": {"type": "checker", "even": colour, "odd": colour}}, None)]:
        mixed = {"type": "principled", "base_color": colour, **rough, **principled}
        if plain is None:
            plain = {"type": "blend", "weight": 0.25, "of": [{"type": "plastic", "reflectance": colour, **rough},
                                                           {"type": "conductor", "reflectance": colour, **rough}]}
            assert seen(mixed, samples=4096) == pytest.approx(seen(plain, samples=4096), abs=0.02)
        else:
            assert np.array_equal(seen(mixed, samples=16), seen(plain | rough, samples=16))


def test_clear_principled_takes_its_colour_at_each_passage():
    document = minimal(image={"width": 1, "height": 1}, camera={"position": [0, 0, 5], "target": [0, 0, 0], "fov": 0.01},
                       background=WHITE, scene=[{"object": {"type": "box", "min": [-1, -1, -1], "max": [1, 1, 1]},
                                                 "material": {"type": "principled", "transmission": 1, "roughness": 0,
                                                              "ior": 1.0, "base_color": [0.5, 0.25, 1.0]}}])
    assert tilecast.render(tilecast.load(document), samples=2).pixels[0, 0] == pytest.approx([0.25, 0.0625, 1.0])


def test_a_blend_gives_each_its_share():
    blend = {"type": "blend", "of": ["mirror", {"type": "mirror", "reflectance": [0, 0, 0]}], "weight": 0.25}
    whitted = seen(blend, materials={"mirror": {"type": "mirror"}}, render={"integrator": "whitted"})
    assert whitted == pytest.approx([0.75] * 3, rel=1e-6)
    assert seen(blend, 4096, materials={"mirror": {"type": "mirror"}}) == pytest.approx([0.75] * 3, abs=0.03)


def test_too_many_pairs_of_rough_glass_are_refused():
    objects = [{"object": {"type": "sphere", "radius": 1},
                "material": {"type": "dielectric", "ior": 1.1 + 0.01 * i, "roughness": 0.9}} for i in range(12)]
    with pytest.raises(tilecast.scene.SceneError, match="more than 64 pairs of a rough dielectric"):
        tilecast.load(minimal(scene=objects))
