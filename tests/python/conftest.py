"""Hypothesis for all tests here: no deadline, which a busy machine would miss, and no folder of found
examples: a test prints how to repeat a failure. And two dispatchers, and a small scene in a file."""

import json
from concurrent.futures import ThreadPoolExecutor

import pytest
from documents import diffuse
from hypothesis import settings
from works import Manual

from tilecast.render.dispatch import Dispatcher

settings.register_profile("tilecast", deadline=None, database=None, print_blob=True)
settings.load_profile("tilecast")


@pytest.fixture
def scene(tmp_path):
    """The file of a small scene: 24 x 16 pixels, 8 samples."""
    path = tmp_path / "ball.json"
    path.write_text(json.dumps(diffuse(8, 24, 16)))
    return path


@pytest.fixture
def threads():
    """A dispatcher over three threads."""
    with ThreadPoolExecutor(3) as executor:
        dispatcher = Dispatcher(executor, 3)
        yield dispatcher
        dispatcher.close()


@pytest.fixture
def manual():
    """An executor whose tasks end when the test says so, and a dispatcher over it."""
    executor = Manual()
    dispatcher = Dispatcher(executor, 1)
    yield executor, dispatcher
    dispatcher.close()
