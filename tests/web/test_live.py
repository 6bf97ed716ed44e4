"""A job in the browser: tiles before it is done, the finished picture after; through reloads and restarts."""

import pictures
import pytest
from pictures import canvas, change, expect_picture, known, open_job, png, post, scene, wait_for_known, wait_for_state
from playwright.sync_api import expect


def test_tiles_show_before_the_job_is_done_and_the_finished_picture_after(server, page, tmp_path):
    page.goto(server.url)
    job = post(server.url, scene(seconds=6), name="live")
    open_job(page, server.url, job["id"])
    wait_for_known(page, 0.01)
    assert pictures.job(server.url, job["id"])["state"] in {"queued", "running"}
    first = canvas(page)

    wait_for_state(page, "done")
    image = png(server.url, job["id"], tmp_path)
    page.wait_for_function("() => document.querySelector('.status').textContent.startsWith('100%')")
    expect_picture(page, image)
    assert (first != canvas(page)).any(), "the picture got better in the meantime"


def test_curve_and_statistics_are_shown(server, page):
    job = post(server.url, scene(samples=64))
    open_job(page, server.url, job["id"])
    wait_for_state(page, "done")
    expect(page.locator(".curve-line").first).to_be_attached()
    expect(page.locator(".curve-band").first).to_be_attached()
    expect(page.locator(".curve-title")).to_have_text(["Render time (seconds)", "Relative MSE"])
    page.get_by_text("Figures", exact=True).click()
    counts = page.locator("tbody tr td:nth-child(2)").all_inner_texts()
    assert counts == sorted(counts, key=int) and counts[-1] == "64"
    expect(page.locator(".features .used").first).to_be_visible()
    assert "csg" in page.locator(".features .left-out").all_inner_texts()
    expect(page.locator("dt", has_text="Kernel")).to_be_visible()


@pytest.mark.parametrize(
    ("label", "name", "start"),
    [("PNG", ".png", b"\x89PNG"), ("EXR", ".exr", b"v/1\x01"), ("Statistics", "-stats.json", b"{"), ("Curve", "-curve.json", b"{")],
)
def test_downloads(server, page, label, name, start):
    job = post(server.url, scene())
    open_job(page, server.url, job["id"])
    wait_for_state(page, "done")
    with page.expect_download() as download:
        page.locator(".downloads").get_by_role("link", name=label, exact=True).click()
    assert download.value.suggested_filename == job["id"] + name
    assert download.value.path().read_bytes().startswith(start)


def test_exposure_brightens_what_is_shown_and_leaves_the_image_alone(server, page, tmp_path):
    job = post(server.url, scene())
    open_job(page, server.url, job["id"])
    wait_for_state(page, "done")
    image = png(server.url, job["id"], tmp_path)
    expect_picture(page, image)
    before = canvas(page)
    page.get_by_label("Exposure").press("ArrowRight")
    page.wait_for_function("() => document.querySelector('output').textContent === '+0.1 EV'")
    page.wait_for_timeout(100)
    after = canvas(page)
    assert (after[..., :3] >= before[..., :3]).all() and after[..., :3].sum() > before[..., :3].sum()
    page.get_by_role("button", name="Reset").click()
    expect_picture(page, image)


def test_reload_in_the_middle_goes_on(server, page, tmp_path):
    page.goto(server.url)
    job = post(server.url, scene(seconds=8))
    open_job(page, server.url, job["id"])
    wait_for_known(page, 0.01)
    change(server.url, job["id"], state="paused")  # so that the middle lasts for as long as the reload takes
    page.reload()
    page.locator("canvas").wait_for()
    wait_for_known(page, 0.01)
    wait_for_state(page, "paused")
    change(server.url, job["id"], state="queued")
    wait_for_state(page, "done")
    expect_picture(page, png(server.url, job["id"], tmp_path))


def test_killed_and_restarted_server_is_found_again(own_server, page, tmp_path):
    page.goto(own_server.url)
    job = post(own_server.url, scene(seconds=5))
    open_job(page, own_server.url, job["id"])
    wait_for_known(page, 1)
    own_server.kill()
    expect(page.locator("#lost")).to_be_visible()
    assert known(page) == 1, "what was there stays"
    own_server.start()
    expect(page.locator("#lost")).to_be_hidden()
    wait_for_state(page, "done")
    expect_picture(page, png(own_server.url, job["id"], tmp_path))


def test_unknown_job_says_so(server, page):
    page.goto(f"{server.url}/#/jobs/no-such-job")
    expect(page.get_by_role("alert")).to_contain_text("There is no such job")


def test_the_map_of_the_error_takes_the_picture_s_place_and_gives_it_back(server, page):
    job = post(server.url, scene())
    open_job(page, server.url, job["id"])
    wait_for_state(page, "done")
    button, shown = page.get_by_role("button", name="Error map"), page.locator(".stage img")
    button.click()
    expect(shown).to_be_visible()
    page.wait_for_function("() => document.querySelector('.stage img').naturalWidth === document.querySelector('.stage canvas').width")
    expect(page.locator(".stage canvas")).to_be_hidden()
    button.click()
    expect(shown).to_be_hidden()
    expect(page.locator(".stage canvas")).to_be_visible()
