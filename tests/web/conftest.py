"""A real server and a real Chromium (Debian's)."""

import os

import pytest
from playwright.sync_api import Browser, Page, expect, sync_playwright
from process import ServerProcess

CHROMIUM = os.environ.get("CHROMIUM", "/usr/bin/chromium")
SWITCHES = [
    *["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"],
    *["--disable-background-networking", "--disable-component-update", "--disable-sync"],
]

PATIENCE = 20_000  # milliseconds; the machine may be busy
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


class Watched:
    """A page with what it complained of and where it went."""

    def __init__(self, browser: Browser, **options):
        self._context = browser.new_context(**options)
        self.page: Page = self._context.new_page()
        self.page.set_default_timeout(PATIENCE)
        self.complaints: list[str] = []
        self.addresses: set[str] = set()
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("console", self._console)
        self.page.on("request", lambda request: self.addresses.add(request.url))

    def close(self) -> None:
        self._context.close()

    def _console(self, message) -> None:
        # Chromium itself logs every answer of 400 and above, and every lost connection; the page's code handles those.
        if message.type == "error" and not message.text.startswith("Failed to load resource"):
            self.complaints.append(message.text)


@pytest.fixture
def watched(browser):
    watched = Watched(browser, viewport={"width": 1280, "height": 900})
    yield watched
    watched.close()
    assert watched.complaints == []


@pytest.fixture
def page(watched) -> Page:
    return watched.page
