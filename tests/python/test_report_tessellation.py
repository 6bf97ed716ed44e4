"""A sphere of triangles against the exact one, by rays and on paper."""

import numpy as np
import pytest

from tilecast.report import tessellation


@pytest.fixture(scope="module")
def report():
    return tessellation.tessellation(5)


@pytest.mark.parametrize("level", range(4))
def test_an_icosphere_is_closed_round_and_turned_outwards(level):
    vertices, faces = tessellation.icosphere(level)
    assert (len(vertices), len(faces)) == (10 * 4**level + 2, 20 * 4**level)
    assert np.allclose(np.linalg.norm(vertices, axis=1), 1, atol=1e-14)
    edges = {tuple(edge) for face in faces for edge in zip(face, np.roll(face, -1))}
    assert len(edges) == 3 * len(faces) and all((b, a) in edges for a, b in edges)
    corners = vertices[faces]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    assert 0.6 * 4 / 3 * np.pi < volume < 4 / 3 * np.pi


def test_the_sagitta_of_an_icosahedron_is_known():
    radius = np.sqrt(3) * (3 + np.sqrt(5)) / 12 / np.sin(2 * np.pi / 5)  # inscribed over circumscribed
    assert tessellation.sagitta(*tessellation.icosphere(0)) == pytest.approx(1 - radius)


def test_rays_find_the_depth_that_paper_says(report):
    """None goes deeper than the sagitta (but for the vertices' rounding to float32, 1e-7 each), and among a quarter
    of a million, some come close to the centre of the largest triangle."""
    for row in report["rows"]:
        assert 0.95 * row["sagitta"] < row["deepest"] < row["sagitta"] + 1e-6
        assert row["rms"] < row["deepest"]


def test_a_silhouette_misses_what_its_outline_leaves_out(report):
    """Seen from afar a convex mesh fills the hull of its projected corners. The rays are a grid of 500 angles by 500
    radii, each angle's count exact to one ray: 1/500 of the ring, of which an eighth is missed at least."""
    for level, row in enumerate(report["rows"]):
        vertices, _ = tessellation.icosphere(level)
        across = np.cross(tessellation._VIEW, [0, 1, 0])
        across /= np.linalg.norm(across)
        flat = np.stack([vertices @ across, vertices @ np.cross(across, tessellation._VIEW)], axis=1)
        assert row["silhouette"] == pytest.approx(1 - hull_area(flat) / np.pi, rel=0.02)


def hull_area(points):
    """Andrew's monotone chain, and the shoelace formula."""
    points = sorted(map(tuple, points))
    hull = []
    for way in (points, points[::-1]):
        part = []
        for p in way:
            while len(part) > 1 and cross(part[-2], part[-1], p) <= 0:
                part.pop()
            part.append(p)
        hull += part[:-1]
    x, y = np.array(hull).T
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) / 2)


def cross(o, a, b):
    return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])


def test_errors_fall_with_the_triangles(report):
    assert report["slope"]["deepest"] == pytest.approx(-1, abs=0.1)
    assert report["slope"]["silhouette"] == pytest.approx(-1, abs=0.15)
    assert [row["triangles"] for row in report["rows"]] == [20, 80, 320, 1280, 5120]
    lines = tessellation.tessellation_table(report).splitlines()
    assert lines[2].split()[0] == "triangles" and lines[8].split()[0] == "sphere" and "-1 on paper" in lines[-1]
