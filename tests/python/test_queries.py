"""Rays as numpy arrays: right answers, shapes and types that are told apart, no copies, no hold on other threads."""

import signal
import threading
import time
import tracemalloc

import numpy as np
import pytest
import trimesh
from documents import minimal
from trimesh.ray.ray_triangle import ray_triangle_id

import tilecast
from tilecast import SceneError

TETRAHEDRON = ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
UP = np.array([[0.0, 0.0, 1.0]])


@pytest.fixture(scope="module")
def tetrahedron():
    return tilecast.mesh(*TETRAHEDRON)


def soup(faces: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Random triangles; the vertices are float32, as a mesh stores them."""
    generator = np.random.default_rng(seed)
    centres = generator.uniform(-1, 1, (faces, 1, 3))
    vertices = (centres + generator.normal(0, 0.2, (faces, 3, 3))).reshape(-1, 3).astype(np.float32).astype(float)
    return vertices, np.arange(3 * faces).reshape(-1, 3)


def random_rays(count: int, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    generator = np.random.default_rng(seed)
    directions = generator.normal(size=(count, 3)) * generator.uniform(0.1, 10, (count, 1))
    return generator.uniform(-1, 1, (count, 3)), directions


# --- Answers

class Everything:
    """Where trimesh asks an R-tree for candidates: all triangles."""

    def __init__(self, triangles):
        self.count = len(triangles)
        self.bounds = np.concatenate([triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))])

    def intersection(self, bounds):
        return range(self.count)


@pytest.mark.parametrize("accelerator", ["none", "bvh"])
def test_hits_are_those_of_trimesh(accelerator):
    vertices, faces = soup(200)
    origins, directions = random_rays(1500)
    scene = tilecast.mesh(vertices, faces, accelerator=accelerator)
    triangles = vertices[faces]
    unit = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    face, ray, points = ray_triangle_id(triangles, origins, unit, tree=Everything(triangles))
    t = np.einsum("ij,ij->i", points - origins[ray], unit[ray]) / np.linalg.norm(directions[ray], axis=1)
    order = np.lexsort((t, ray))
    face, ray, t = face[order], ray[order], t[order]
    assert len(ray) > 1000

    # All crossings ahead of the origin.
    runs = scene.crossings(origins, directions)
    line = np.repeat(np.arange(len(origins)), np.diff(runs.offsets))
    ahead = runs.t > 0
    assert np.array_equal(line[ahead], ray) and np.array_equal(runs.primitive[ahead], face)
    # A vertex is stored to 2^-25 of the frame, which is at most 4 metres; seen at a slant, t is off by more.
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    slope = np.einsum("ij,ij->i", normals[face], directions[ray])
    assert (np.abs(runs.t[ahead] - t) * np.abs(slope) < 4 * 2**-24 + 1e-12).all()
    assert np.array_equal(runs.entering[ahead], slope < 0)

    # The first of them.
    first = np.unique(ray, return_index=True)[1]
    hits = scene.closest(origins, directions)
    expected = np.full(len(origins), -1)
    expected[ray[first]] = face[first]
    assert np.array_equal(hits.primitive, expected)
    assert np.array_equal(hits.object, np.where(expected < 0, -1, 0))
    assert np.array_equal(hits.t[ray[first]], runs.t[ahead][first])
    assert np.array_equal(np.isinf(hits.t), expected < 0)
    assert np.array_equal(scene.occluded(origins, directions), expected >= 0)
    found = expected >= 0
    assert np.allclose(hits.normal[found], normals[expected[found]], atol=1e-4) and not hits.normal[~found].any()
    corners = triangles[expected[found]]
    weights = np.stack([1 - hits.u - hits.v, hits.u, hits.v], axis=1)[found]
    reached = (origins + np.where(found, hits.t, 0)[:, None] * directions)[found]
    assert weights.min() >= 0
    assert np.abs(np.einsum("ij,ijk->ik", weights, corners) - reached).max() < 1e-6


def test_the_crossings_tell_what_is_inside():
    ball = trimesh.creation.icosphere(subdivisions=2)
    points = np.random.default_rng(2).uniform(-1.2, 1.2, (2000, 3))
    runs = tilecast.mesh(ball.vertices, ball.faces).crossings(points, np.tile(UP, (2000, 1)))
    assert (np.diff(runs.offsets) % 2 == 0).all()
    line = np.repeat(np.arange(2000), np.diff(runs.offsets))
    inside = np.bincount(line, runs.t > 0, 2000) % 2 == 1
    # A convex body: inside is behind every face.
    distance = np.einsum("ijk,jk->ij", points[:, None] - ball.triangles[None, :, 0], ball.face_normals).max(axis=1)
    sure = np.abs(distance) > 1e-6
    assert sure.sum() > 1990 and np.array_equal(inside[sure], distance[sure] < 0)


def test_objects_are_numbered_as_in_the_scene_and_lights_come_after():
    ball = {"type": "sphere", "radius": 1}
    document = minimal(scene=[{"object": ball, "transform": [{"translate": [x, 0, 0]}]} for x in (0, 5)],
                       lights=[{"type": "area", "object": ball, "radiance": [1, 1, 1],
                                "transform": [{"translate": [10, 0, 0]}]}])
    hits = tilecast.load(document).closest([[x, 0, -9] for x in (5, 10, 0, 20)], np.tile(UP, (4, 1)))
    assert hits.object.tolist() == [1, 2, 0, -1]
    assert hits.t.tolist() == [8, 8, 8, np.inf]
    assert hits.normal.tolist() == [[0, 0, -1]] * 3 + [[0, 0, 0]]


def test_limits_are_numbers_or_arrays(tetrahedron):
    origins, directions = np.tile([[0.2, 0.2, -1.0]], (3, 1)), np.tile(UP, (3, 1))
    # The line enters at t = 1 and leaves at 1.6.
    assert tetrahedron.closest(origins, directions, t_max=1).t.tolist() == [1, 1, 1]
    assert np.isinf(tetrahedron.closest(origins, directions, t_min=0, t_max=0.999).t).all()
    assert tetrahedron.closest(origins, directions, t_min=1).t == pytest.approx([1.6] * 3)
    assert tetrahedron.closest(origins, directions, t_min=[0, 1, 2]).t == pytest.approx([1, 1.6, np.inf])
    assert tetrahedron.occluded(origins, directions, t_max=np.array([0.5, 1, 2], np.float32)).tolist() == [0, 1, 1]
    assert tetrahedron.occluded(origins, -directions, t_min=-np.inf).all()
    assert not tetrahedron.occluded(origins, directions, t_min=2, t_max=1).any()
    for limits in ({"t_min": np.nan}, {"t_max": np.nan}):
        assert not tetrahedron.occluded(origins, directions, **limits).any()
        assert np.isinf(tetrahedron.closest(origins, directions, **limits).t).all()


ODD = [np.nan, np.inf, -np.inf]


def test_rays_that_are_none_hit_nothing():
    solids = [{"type": "sphere", "radius": 1}, {"type": "box", "min": [-1, -1, -1], "max": [1, 1, 1]},
              {"type": "cylinder", "radius": 1, "height": 2}, {"type": "rectangle", "size": [2, 2]}]
    solids += [{"type": "difference", "of": solids[:2]},
               {"type": "mesh", "vertices": TETRAHEDRON[0], "faces": TETRAHEDRON[1]}]
    bad = [(np.zeros(3), np.zeros(3)), (np.zeros(3), -np.zeros(3))]
    for axis in range(3):
        for value in ODD:
            for which in range(2):
                ray = np.array([[0.1, 0.2, -5.0], [0.0, 0.0, 1.0]])
                ray[which, axis] = value
                bad.append(tuple(ray))
    origins, directions = (np.array(part) for part in zip(*bad))
    for solid in solids:
        scene = tilecast.load(minimal(scene=[{"object": solid}]))
        hits = scene.closest(origins, directions)
        assert np.isinf(hits.t).all() and (hits.primitive == -1).all() and not hits.normal.any()
        assert not scene.occluded(origins, directions).any()
        assert scene.crossings(origins, directions).offsets.tolist() == [0] * (len(bad) + 1)


@pytest.mark.parametrize("solid", [
    {"type": "capsule", "radius": 1e-50, "height": 1e-12},
    {"type": "capsule", "radius": 1e-90, "height": 1e-90},
    {"type": "box", "min": [-1e12] * 3, "max": [1e12] * 3, "radius": 1e-100},
    {"type": "box", "min": [-1e50] * 3, "max": [1.0] * 3, "radius": 1e12},
    {"type": "torus", "radius": 1e50, "minor_radius": 1e-100},
])
def test_normals_are_numbers_however_small_a_radius_is(solid):
    scene = tilecast.load(minimal(scene=[{"object": solid}])).scene
    generator = np.random.default_rng(1)
    centre, size = scene.bounds.mean(axis=0), np.ptp(scene.bounds, axis=0)
    origins = centre + size.max() * generator.normal(size=(2000, 3)) * generator.choice([0, 1, 1e3], (2000, 1))
    directions = centre + size * generator.uniform(-0.6, 0.6, (2000, 3)) - origins
    directions[:1000] = np.eye(3)[generator.integers(0, 3, 1000)]
    hits = scene.closest(origins, 1e-200 * directions)
    hit = np.isfinite(hits.t)
    assert hit.any()
    assert np.linalg.norm(hits.normal[hit], axis=1) == pytest.approx(1)


# --- Shapes and types

@pytest.mark.parametrize("accelerator", ["auto", "grid"])
def test_many_rays_at_once_answer_as_one_by_one(accelerator):
    mesh = tilecast.mesh(*soup(2000), accelerator=accelerator)
    generator = np.random.default_rng(1)
    origins = generator.uniform(-1, 1, (4000, 3))
    directions = np.concatenate([generator.normal(size=(2000, 3)), 0.5 - 2 * origins[2000:]])
    together, dark = mesh.closest(origins, directions), mesh.occluded(origins, directions, t_max=0.5)
    for i in range(0, 4000, 7):
        alone = mesh.closest(origins[i : i + 1], directions[i : i + 1])
        for field in ("t", "object", "primitive", "u", "v", "normal"):
            assert np.array_equal(getattr(together, field)[i], getattr(alone, field)[0]), (i, field)
        assert dark[i] == mesh.occluded(origins[i : i + 1], directions[i : i + 1], t_max=0.5)[0] == (alone.t[0] <= 0.5)


def test_no_rays_have_no_answers(tetrahedron):
    none = np.empty((0, 3))
    hits = tetrahedron.closest(none, none)
    assert hits.t.shape == (0,) and hits.normal.shape == (0, 3)
    assert tetrahedron.occluded(none, none, t_max=np.empty(0)).shape == (0,)
    assert tetrahedron.crossings(none, none).offsets.tolist() == [0]


def test_types_are_as_documented(tetrahedron):
    hits = tetrahedron.closest(UP, UP)
    assert [hits.t.dtype, hits.u.dtype, hits.v.dtype, hits.normal.dtype] == [np.float64] * 4
    assert hits.object.dtype == hits.primitive.dtype == np.int64
    assert tetrahedron.occluded(UP, UP).dtype == bool
    runs = tetrahedron.crossings(UP, UP)
    assert runs.offsets.dtype == runs.object.dtype == runs.primitive.dtype == np.int64
    assert runs.t.dtype == np.float64 and runs.entering.dtype == bool


def test_other_numbers_and_layouts_are_converted(tetrahedron):
    origins, directions = np.round(random_rays(50)[0] * 8) / 8, np.round(random_rays(50)[1] * 8)
    expected = tetrahedron.closest(origins, directions)
    packed = np.frombuffer(b"\0" + origins.tobytes(), np.float64, offset=1).reshape(-1, 3)
    assert not packed.flags.aligned
    for same in (origins.astype(np.float32), origins.tolist(), np.asfortranarray(origins), origins.astype(">f8"),
                 np.repeat(origins, 2, axis=0)[::2], packed):
        for other in (directions, directions.astype(np.int8), directions.tolist()):
            assert np.array_equal(tetrahedron.closest(same, other).t, expected.t)


@pytest.mark.parametrize("arguments, message", [
    ((np.zeros(3), UP), r"origins: must have shape \[n, 3\], got \[3\]"),
    ((np.zeros((4, 2)), np.zeros((4, 2))), r"origins: must have shape \[n, 3\], got \[4, 2\]"),
    ((np.zeros((3, 4)), np.zeros((3, 4))), r"origins: must have shape \[n, 3\], got \[3, 4\]"),
    ((np.zeros((4, 3)), np.zeros((5, 3))), r"directions: must have shape \[4, 3\], got \[5, 3\]"),
    (([], []), r"origins: must have shape \[n, 3\], got \[0\]")])
def test_a_wrong_shape_is_named(tetrahedron, arguments, message):
    for query in (tetrahedron.closest, tetrahedron.occluded, tetrahedron.crossings):
        with pytest.raises(ValueError, match=f"^{message}$"):
            query(*arguments)


@pytest.mark.parametrize("name", ["t_min", "t_max"])
def test_a_wrong_shape_of_a_limit_is_named(tetrahedron, name):
    for limit, got in ((np.zeros(2), r"\[2\]"), (np.zeros((3, 1)), r"\[3, 1\]")):
        with pytest.raises(ValueError, match=rf"^{name}: must have shape \[3\], got {got}$"):
            tetrahedron.closest(np.zeros((3, 3)), np.zeros((3, 3)), **{name: limit})


@pytest.mark.parametrize("value, got", [
    (None, "an array of object"), ([["a", "b", "c"]], "an array of <U1"),
    (np.zeros((1, 3), complex), "an array of complex128"),
    ([[1, 2], [3]], "a list that is no array"), ([[10**30, 0, 0]], "an array of object")])
def test_what_is_no_number_is_named(tetrahedron, value, got):
    with pytest.raises(TypeError, match=f"^origins: must be numbers, got {got}$"):
        tetrahedron.closest(value, UP)
    with pytest.raises(TypeError, match=f"^directions: must be numbers, got {got}$"):
        tetrahedron.occluded(UP, value)


@pytest.mark.parametrize("vertices, faces, path, message", [
    (TETRAHEDRON[0], [[0, 1, 4]], "faces", r"indices of the 4 vertices \(from 0\), got 0 to 4"),
    (TETRAHEDRON[0], [[0, 1, -1]], "faces", "got -1 to 1"),
    (TETRAHEDRON[0], np.array([[0, 1, 2**32 + 2]]), "faces", "got 0 to 4294967298"),
    (TETRAHEDRON[0], [[0, 1]], "faces", r"shape \[n, 3\], got \[1, 2\]"),
    (TETRAHEDRON[0], [[0, 1, 2], [0, 1]], "faces", "rows of several lengths"),
    (TETRAHEDRON[0], [[0, 1, 1.5]], "faces", "must be whole numbers, got float64"),
    ([0, 0, 0], [[0, 0, 0]], "vertices", r"shape \[n, 3\], got \[3\]"),
    ([["a", "b", "c"]], [[0, 0, 0]], "vertices", "must be numbers, got <U1")])
def test_what_is_no_mesh_is_refused(vertices, faces, path, message):
    with pytest.raises(SceneError, match=message) as caught:
        tilecast.mesh(vertices, faces)
    assert caught.value.path == path


@pytest.mark.parametrize("accelerator, message", [("foo", "foo"), (3, "must be a text, got int"), (None, "got NoneType")])
def test_an_accelerator_that_there_is_not_is_refused(accelerator, message):
    with pytest.raises(SceneError, match=message):
        tilecast.mesh(*TETRAHEDRON, accelerator=accelerator)


# --- Memory, threads, signals

def test_float64_in_c_order_is_not_copied(tetrahedron):
    origins = np.full((200_000, 3), 9.0)

    def peak(rays) -> int:
        tracemalloc.start()  # numpy tells it of its arrays
        try:
            tetrahedron.occluded(rays, rays)
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()

    assert peak(origins) < 100_000
    assert peak(origins.astype(np.float32)) > origins.nbytes


@pytest.fixture(scope="module")
def slow():
    """Some milliseconds a ray, and minutes for all."""
    rays = np.zeros((200_000, 3)), np.tile([1.0, 0.5, 0.25], (200_000, 1))
    return tilecast.mesh(*soup(100_000), accelerator="none"), rays


@pytest.mark.parametrize("query", ["closest", "occluded", "crossings"])
def test_a_long_query_ends_by_a_signal_and_lets_other_threads_run(slow, query):
    scene, rays = slow
    ticks = []

    class Stopped(Exception):
        pass

    def stop(*_):
        raise Stopped

    def tick():
        while not ended.wait(0.005):
            ticks.append(time.monotonic())

    ended = threading.Event()
    ticker = threading.Thread(target=tick)
    before = signal.signal(signal.SIGALRM, stop)
    try:
        ticker.start()
        start = time.monotonic()
        signal.setitimer(signal.ITIMER_REAL, 0.5)
        with pytest.raises(Stopped):
            getattr(scene, query)(*rays)
        end = time.monotonic()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
        ended.set()
        ticker.join()
    assert end - start < 30
    assert sum(start + 0.1 < at < start + 0.4 for at in ticks) > 5
