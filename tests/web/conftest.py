"""A real server and a real Chromium (Debian's)."""

import os

import pytest
from playwright.sync_api import Page, expect, sync_playwright
from process import ServerProcess
from watching import PATIENCE, Watched

CHROMIUM = os.environ.get("CHROMIUM", "/usr/bin/chromium")
SWITCHES = [
    *["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"],
    *["--disable-background-networking", "--disable-component-update", "--disable-sync"],
]

expect.set_options(timeout=PATIENCE)


@pytest.fixture(scope="session")
def server(tmp_path_factory):
    """One server for the tests that leave it as it is."""
    server = ServerProcess(tmp_path_factory.mktemp("server"))
    server.start()
    yield server
    server.stop()


@pytest.fixture
def own_server(tmp_path):
    """A server that the test may kill."""
    server = ServerProcess(tmp_path)
    server.start()
    yield server
    server.stop()


@pytest.fixture(scope="session")
def browser():
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=SWITCHES)
        yield browser
        browser.close()


@pytest.fixture
def watched(browser):
    watched = Watched(browser, viewport={"width": 1280, "height": 900})
    yield watched
    watched.close()
    assert watched.complaints == []


@pytest.fixture
def page(watched) -> Page:
    return watched.page
