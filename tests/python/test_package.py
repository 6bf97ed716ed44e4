"""`import tilecast` gives the public names, in whatever order they are asked for, and loads nothing
before."""

import json
import subprocess
import sys

import pytest
from documents import diffuse

import tilecast


def python(code: str) -> str:
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    return result.stdout


def test_importing_the_package_loads_nothing_else():
    assert python("import sys, tilecast; print([m for m in ('numpy', 'pydantic', 'tilecast.scene', 'tilecast._core') "
                  "if m in sys.modules])") == "[]\n"


def test_openimageio_is_loaded_where_there_is_an_image():
    """With what it needs it is larger than all else together: half a second, 100 MB."""
    code = f"""
import numpy, tilecast
from tilecast.render import output
loaded = lambda: "libOpenImageIO" in open("/proc/self/maps").read()
image = tilecast.render(tilecast.load({json.dumps(diffuse(2, 4, 3))}), samples=2)
print(loaded())
output.to_png(numpy.zeros((2, 2, 3), numpy.float32))
print(loaded())
"""
    assert python(code) == "False\nTrue\n"


@pytest.mark.parametrize("imports", [
    "import tilecast; render = tilecast.render",
    "import tilecast.render.plan; render = tilecast.render",
    "from tilecast.render import local; import tilecast; render = tilecast.render",
    "import tilecast; tilecast.load; import tilecast.render.local; render = tilecast.render",
    "from tilecast import render, load; import tilecast"])
def test_render_can_be_called_whatever_is_imported_first(imports):
    document = json.dumps(diffuse(2, 4, 3))
    assert python(f"{imports}\nprint(render(tilecast.load({document}), samples=2).pixels.shape)") == "(3, 4, 3)\n"
    assert python(f"{imports}\nimport tilecast.render.plan as plan\nprint(plan.Plan.__name__)") == "Plan\n"


def test_a_scene_is_loaded_from_a_path_or_a_dictionary(tmp_path):
    path = tmp_path / "a.json"
    path.write_text(json.dumps(diffuse(2)))
    for source in (path, str(path), diffuse(2)):
        scene = tilecast.load(source)
        assert scene.document.render.samples == 2
        assert set(scene.seconds) == {"load", "compile"}
    assert tilecast.load(path, settings=["image.width=7"]).scene.width == 7


def test_meshes_are_beside_the_file_or_where_it_is_said(tmp_path, monkeypatch):
    (tmp_path / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    document = diffuse(2)
    document["scene"].append({"object": {"type": "mesh", "file": "m.obj"}})
    (tmp_path / "a.json").write_text(json.dumps(document))
    tilecast.load(tmp_path / "a.json")
    tilecast.load(document, folder=tmp_path)
    with pytest.raises(tilecast.SceneError):
        tilecast.load(document)
    monkeypatch.chdir(tmp_path)
    tilecast.load(document)


def test_what_is_not_there_is_an_attribute_error():
    with pytest.raises(AttributeError, match="nothing"):
        tilecast.nothing
