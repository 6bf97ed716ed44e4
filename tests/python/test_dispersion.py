"""Light of different wavelengths is refracted by different indices."""

import numpy as np
import pytest

import tilecast
from tilecast import SceneError

IOR, ABBE = 1.6, 20.0
TILT = np.pi / 6  # of the prism's lower face
SCREEN = -10.0  # its height


def index(micrometres: np.ndarray) -> np.ndarray:
    """Cauchy's, through the definition of Abbe's number."""
    of_d, of_f, of_c = (1 / w**2 for w in (0.58756, 0.48613, 0.65627))
    return IOR + (IOR - 1) / (ABBE * (of_f - of_c)) * (1 / micrometres**2 - of_d)


def weights(micrometres: np.ndarray) -> np.ndarray:
    """float64 [3, n]: what wavelengths add to red, green and blue; the mean of each is 1."""
    def lobe(height, middle, below, above):
        off = 1000 * micrometres - middle
        return height * np.exp(-0.5 * (off / np.where(off < 0, below, above)) ** 2)

    xyz = np.stack([lobe(1.056, 599.8, 37.9, 31.0) + lobe(0.362, 442.0, 16.0, 26.7) - lobe(0.065, 501.1, 20.4, 26.2),
                    lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
                    lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8)])
    rgb = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]) @ xyz
    rgb = np.maximum(rgb, 0)
    return rgb / rgb.mean(axis=1, keepdims=True)


def through_the_prism(micrometres: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where a ray that comes down at x = 0 meets the screen, and which part of it comes through both faces."""
    n = index(micrometres)
    inside, outside = np.cos(TILT), np.sqrt(1 - (n * np.sin(TILT)) ** 2)  # cosines with the normal
    reflected = (n * inside - outside) / (n * inside + outside), (inside - n * outside) / (inside + n * outside)
    passed = 4 * n / (n + 1) ** 2 * (1 - (reflected[0] ** 2 + reflected[1] ** 2) / 2)
    normal, tangent = np.array([np.sin(TILT), -np.cos(TILT)]), np.array([-np.cos(TILT), -np.sin(TILT)])
    x, z = normal[:, None] * outside + tangent[:, None] * (n * np.sin(TILT))
    leaves = -0.2 - np.tan(TILT)  # height of the lower face at x = 0
    return x / z * (SCREEN - leaves), passed


def prism(edge: float) -> dict:
    """Seen from straight above; the screen shines where x is below `edge`."""
    drop = 0.2 + 2 * np.tan(TILT)
    outline = [(-1, 0), (-1, -drop), (1, -0.2), (1, 0)]  # x, z; clockwise as seen from -y
    vertices = [[x, y, z] for y in (-2, 2) for x, z in outline]
    faces = [[0, 1, 2], [0, 2, 3], [4, 6, 5], [4, 7, 6]]
    for i in range(4):
        j = (i + 1) % 4
        faces += [[i, 4 + i, j], [j, 4 + i, 4 + j]]
    lamp = {"object": {"type": "rectangle", "size": [20, 20]},
            "material": {"type": "diffuse", "reflectance": [0, 0, 0], "emission": [1, 1, 1]},
            "transform": [{"rotate": [90, 0, 0]}, {"translate": [edge - 10, 0, SCREEN]}]}
    return {"camera": {"type": "orthographic", "position": [0, 0, 5], "target": [0, 0, 0], "height": 1e-6},
            "image": {"width": 1, "height": 1},
            "render": {"samples": 65536, "max_depth": 3, "roulette": False},
            "scene": [{"object": {"type": "mesh", "vertices": vertices, "faces": faces},
                       "material": {"type": "dielectric", "ior": IOR, "abbe": ABBE}}, lamp]}


@pytest.mark.parametrize("edge_at", [0.45, 0.5, 0.55, 0.6])
def test_a_prism_splits_light_by_wavelength(edge_at):
    wavelengths = np.linspace(0.4, 0.7, 30001)
    x, passed = through_the_prism(wavelengths)
    [edge], _ = through_the_prism(np.array([edge_at]))
    expected = (weights(wavelengths) * passed * (x < edge)).mean(axis=1)
    image = tilecast.render(tilecast.load(prism(edge)))
    assert np.abs(image.pixels[0, 0] - expected).max() < 0.01
    assert expected.max() > 0.3 and expected.min() < 0.6


def test_in_light_from_everywhere_a_ball_does_not_show():
    document = {"camera": {"position": [0, 0, 4], "target": [0, 0, 0], "fov": 30}, "image": {"width": 16, "height": 16},
                "render": {"samples": 1024, "max_depth": 100}, "background": [1, 1, 1],
                "scene": [{"object": {"type": "sphere", "radius": 1},
                           "material": {"type": "dielectric", "ior": 1.7, "abbe": 10}}]}
    image = tilecast.render(tilecast.load(document))
    deviation = np.sqrt(image.variance.mean(axis=(0, 1)) / image.variance[..., 0].size)
    assert (image.variance.max(axis=(0, 1)) > 0).all()
    assert (np.abs(image.pixels.mean(axis=(0, 1)) - 1) < 5 * deviation + 1e-3).all()


def test_scenes_without_it_do_without():
    document = prism(0.0)
    assert "dispersion" in tilecast.load(document).facts()["features"]["used"]
    del document["scene"][0]["material"]["abbe"]
    scene = tilecast.load(document)
    assert "dispersion" in scene.facts()["features"]["left_out"]
    plain = tilecast.render(scene, samples=16).pixels
    assert np.ptp(plain) == 0  # all wavelengths go one way


def test_a_rough_surface_does_not_split():
    document = prism(0.0)
    document["scene"][0]["material"]["roughness"] = 0.2
    with pytest.raises(SceneError, match="is for polished surfaces alone, got a roughness of 0.2"):
        tilecast.load(document)


@pytest.mark.parametrize("ior, abbe, least", [(0.5, 1, -0.378), (0.9, 1, None), (0.5, 2, None), (1e-3, 1e3, -0.0007)])
def test_no_wavelength_has_an_index_below_zero(ior, abbe, least):
    document = prism(0.0)
    document["scene"][0]["material"] |= {"ior": ior, "abbe": abbe}
    shift = 1 / 0.4**2 - 1 / 0.58756**2
    index_of_violet = ior + (ior - 1) / (abbe * (1 / 0.48613**2 - 1 / 0.65627**2)) * shift
    if least is None:
        assert index_of_violet > 1e-3
        tilecast.load(document)
    else:
        assert index_of_violet == pytest.approx(least, abs=1e-3)
        with pytest.raises(SceneError, match="abbe: must be greater for an ior of .* at least 0.001") as error:
            tilecast.load(document)
        assert error.value.path == "scene[0].material.abbe"
