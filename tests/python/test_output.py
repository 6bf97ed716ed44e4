"""Pixels become files: the right values, whole or not at all."""

import os
import stat
import time

import numpy as np
import pytest

from tilecast import _images
from tilecast.render import output


@pytest.fixture
def pixels():
    return np.random.default_rng(0).random((20, 30, 3), dtype=np.float32) * 1.2


def read(data, tmp_path, suffix):
    path = tmp_path / f"image{suffix}"
    path.write_bytes(data)
    pixels, channels, *_ = _images.read(str(path))
    return pixels, channels


def test_srgb_is_that_of_the_standard():
    assert output.srgb(np.float32([0, 1, 0.5, 0.0031308, 0.2140411, -1, 7])).tolist() == [0, 255, 188, 10, 127, 0, 255]
    codes = np.arange(256) / 255  # decoding by the standard and encoding again gives every code back
    linear = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
    assert output.srgb(linear.astype(np.float32)).tolist() == list(range(256))


def test_an_exr_holds_every_bit(pixels, tmp_path):
    pixels[0, 0] = [1e10, 1e-20, 0]
    found, channels = read(output.to_exr(pixels, {"scene": "x"}), tmp_path, ".exr")
    assert np.array_equal(found[..., [channels.index(c) for c in "RGB"]], pixels)


@pytest.mark.parametrize("suffix", [".png", ".exr"])
def test_an_image_makes_the_same_file_at_any_time(pixels, suffix):
    first = output.encode(suffix, pixels, {"Software": "x"})
    time.sleep(1.1)  # dates in files are of a second
    assert output.encode(suffix, pixels, {"Software": "x"}) == first


def test_a_png_holds_srgb(pixels, tmp_path):
    found, _ = read(output.to_png(pixels), tmp_path, ".png")
    assert np.array_equal(np.round(found[..., :3] * 255).astype(np.uint8), output.srgb(pixels))


def test_the_suffix_chooses_the_format(pixels):
    assert output.encode(".PNG", pixels)[:4] == b"\x89PNG"
    assert output.encode(".exr", pixels)[:4] == b"\x76\x2f\x31\x01"
    with pytest.raises(ValueError, match="ends in .png or .exr, got '.jpg'"):
        output.encode(".jpg", pixels)


def test_half_floats_are_little_endian_rows_and_never_infinite():
    pixels = np.float32([[[0, 1, 2], [3, 4, 1e9]]])
    found = np.frombuffer(output.to_f16(pixels), "<f2")
    assert found.tolist() == [0, 1, 2, 3, 4, 65504]


@pytest.mark.parametrize("shape, expected", [((480, 640), (120, 160)), ((1000, 10), (160, 2)), ((30, 40), (30, 40)),
                                             ((1, 1), (1, 1)), ((3, 999), (1, 160))])
def test_a_thumbnail_keeps_the_shape_and_the_mean(shape, expected, tmp_path):
    grey = np.full((*shape, 3), 0.25, np.float32)
    found, _ = read(output.thumbnail(grey), tmp_path, ".png")
    assert found.shape[:2] == expected
    assert np.array_equal(np.round(found * 255), np.full(found.shape, output.srgb(np.float32(0.25))))


def test_a_thumbnail_averages_linear_light(tmp_path):
    stripes = np.zeros((320, 320, 3), np.float32)
    stripes[::2] = 1
    found, _ = read(output.thumbnail(stripes), tmp_path, ".png")
    assert (np.round(found * 255) == 188).all()  # half of the light, not half of the code


def test_a_file_is_written_whole_or_not_at_all(tmp_path, monkeypatch):
    path = tmp_path / "image.png"
    output.write_file(path, b"old")
    output.write_file(path, b"new")
    assert path.read_bytes() == b"new"
    umask = os.umask(0o022)
    os.umask(umask)
    assert stat.S_IMODE(path.stat().st_mode) == 0o666 & ~umask
    monkeypatch.setattr(os, "replace", lambda *_: (_ for _ in ()).throw(OSError("full")))
    with pytest.raises(OSError, match="full"):
        output.write_file(path, b"newer")
    assert path.read_bytes() == b"new"
    assert list(tmp_path.iterdir()) == [path]
