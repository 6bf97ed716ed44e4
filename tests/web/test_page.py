"""The page as such: nothing from elsewhere, any width, the keyboard alone, contrast, and no growth over hours."""

import re
from urllib.parse import urlsplit

import pytest
from pictures import open_job, post, scene, wait_for_state
from playwright.sync_api import expect
from watching import Watched


def test_everything_comes_from_the_server(server, watched):
    job = post(server.url, scene())
    open_job(watched.page, server.url, job["id"])
    wait_for_state(watched.page, "done")
    watched.page.goto(f"{server.url}/#/new")
    watched.page.goto(f"{server.url}/#/")
    expect(watched.page.locator("a.job").first).to_be_visible()
    assert {urlsplit(address).netloc for address in watched.addresses} == {urlsplit(server.url).netloc}


def test_scripts_and_styles_stand_in_files(server):
    """So that a content security policy without 'unsafe-inline' holds; the page carries one itself."""
    from pictures import httpx

    text = httpx.get(server.url).raise_for_status().text
    policy = re.search(r'http-equiv="Content-Security-Policy" content="([^"]*)"', text)[1]
    assert "script-src 'self'" in policy and "unsafe" not in policy
    assert not re.search(r"<script(?![^>]*\bsrc=)|<style|\bstyle=|\son\w+=", text)


@pytest.mark.parametrize("width", [320, 390, 768])
def test_no_view_is_wider_than_the_screen(server, browser, width):
    job = post(server.url, scene(), name="a-name-without-any-space-in-it-" * 4)
    watched = Watched(browser, viewport={"width": width, "height": 800})
    page = watched.page
    open_job(page, server.url, job["id"])
    wait_for_state(page, "done")
    for address in (f"#/jobs/{job['id']}", "#/", "#/new"):
        page.goto(f"{server.url}/{address}")
        expect(page.get_by_role("heading", level=1)).to_be_visible()
        page.wait_for_timeout(200)
        assert page.evaluate("document.documentElement.scrollWidth") <= width, address
    watched.close()
    assert watched.complaints == []


CONTRAST = """() => {
  const paint = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  const light = (colour) => {
    paint.fillStyle = colour;
    paint.fillRect(0, 0, 1, 1);
    const [r, g, b] = Array.from(paint.getImageData(0, 0, 1, 1).data, (v) => {
      const s = v / 255;
      return s <= 0.04045 ? s / 12.92 : ((s + 0.055) / 1.055) ** 2.4;
    });
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name);
  return (front, back) => {
    const [a, b] = [light(colour(front)), light(colour(back))].sort((x, y) => y - x);
    return (a + 0.05) / (b + 0.05);
  };
}"""


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_has_the_contrast_of_wcag_aa(server, browser, scheme):
    watched = Watched(browser, color_scheme=scheme)
    watched.page.goto(server.url)
    pairs = [
        *[(front, back) for back in ("--page", "--panel") for front in ("--text", "--quiet", "--accent", "--good", "--warn", "--bad")],
        *[("--on-accent", "--accent"), ("--page", "--warn"), ("--text", "--bad-page")],
    ]
    for front, back in pairs:
        ratio = watched.page.evaluate(f"([front, back]) => ({CONTRAST})()(front, back)", [front, back])
        assert ratio >= 4.5, f"{front} on {back}: {ratio:.2f}"
    watched.close()


def test_a_scene_can_be_submitted_with_the_keyboard_alone(server, page):
    page.goto(server.url)
    page.get_by_role("heading", level=1).wait_for()
    page.keyboard.press("Tab")
    expect(page.get_by_role("link", name="Skip to the content")).to_be_focused()
    reach(page, page.get_by_role("navigation").get_by_role("link", name="New render"))
    page.keyboard.press("Enter")
    expect(page.get_by_role("heading", level=1)).to_have_text("New render")
    reach(page, page.get_by_label("Scene (JSON)"))
    page.keyboard.insert_text('{"version": 2}')
    reach(page, page.get_by_role("button", name="Render", exact=True))
    page.keyboard.press("Enter")
    expect(page.get_by_role("alert").get_by_role("button").first).to_be_visible()
    reach(page, page.get_by_role("alert").get_by_role("button").first, backwards=True)
    page.keyboard.press("Enter")
    expect(page.get_by_label("Scene (JSON)")).to_be_focused()


def reach(page, target, backwards=False):
    """Tabs until the target has the focus; every stop on the way is visible."""
    for _ in range(40):
        page.keyboard.press("Shift+Tab" if backwards else "Tab")
        if target.evaluate("(node) => node === document.activeElement"):
            return
    raise AssertionError(f"the keyboard does not reach {target}")


def test_views_leave_nothing_behind(server, page):
    """Nodes and listeners after many turns between the views are those of a few turns."""
    jobs = [post(server.url, scene(size=(256, 256), samples=1)) for _ in range(3)]
    session = page.context.new_cdp_session(page)

    def turn():
        for job in jobs:
            page.goto(f"{server.url}/#/jobs/{job['id']}")
            page.locator(".curve-line, .curve-empty").first.wait_for(state="attached")
            page.goto(f"{server.url}/#/new")
            page.goto(f"{server.url}/#/")
            page.locator("a.job").first.wait_for()

    def counters():
        session.send("HeapProfiler.collectGarbage")
        now = session.send("Memory.getDOMCounters")
        heap = session.send("Runtime.getHeapUsage")["usedSize"]
        return now["nodes"], now["jsEventListeners"], heap

    for _ in range(2):
        turn()
    nodes, listeners, heap = counters()
    for _ in range(6):
        turn()
    nodes_after, listeners_after, heap_after = counters()
    assert nodes_after <= nodes + 200
    assert listeners_after <= listeners + 20
    assert heap_after <= heap + 1_000_000
