"""Views over HTTP: an EXR holds their numbers, all else shows them as a screen can."""

import numpy as np
from servers import exr, locally, long_scene, scene

import tilecast
from tilecast import _images
from tilecast.render import display, output


def tile(server, job, column=0, row=0) -> np.ndarray:
    return np.frombuffer(server.client.get(f"{job['links']['tiles']}/{column}/{row}.f16").content, "<f2")


def test_depth_is_metres_in_the_exr_and_a_ramp_elsewhere(server, tmp_path):
    document = scene(integrator="depth")
    job = server.reach(server.submit(document), "done")
    metres = exr(server, job, tmp_path)
    assert np.array_equal(metres, locally(document)) and metres.max() > 4
    shown = display.shown(metres, tilecast.load(document).facts())

    (tmp_path / "image.png").write_bytes(server.client.get(job["links"]["image"]).content)
    found = _images.read(str(tmp_path / "image.png"))[0]
    assert np.array_equal(np.rint(found[..., :3] * 255).astype(np.uint8), output.srgb(shown))
    assert server.client.get(job["links"]["thumbnail"]).content == output.thumbnail(shown)
    size = job["tiles"]["size"]
    assert np.array_equal(tile(server, job), shown[:size, :size].astype(np.float16).ravel())


def test_tiles_of_a_view_are_shown_so_from_the_first(server):
    job = server.submit(long_scene(integrator="depth"))
    server.progressed(job, 0.001)
    drawn = [tile for tile in server.client.get(job["links"]["tiles"]).json()["tiles"] if tile["version"]]
    for place in drawn:
        assert tile(server, job, place["column"], place["row"]).max() <= 1
    server.client.delete(job["links"]["self"])
