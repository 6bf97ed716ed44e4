"""A page under watch."""

from playwright.sync_api import Browser, Page

PATIENCE = 20_000  # milliseconds; the machine may be busy


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
