"""What the page does with a job: cancel, pause, resume, retry, delete."""

import pictures
from pictures import open_job, post, scene, wait_for_known, wait_for_state
from playwright.sync_api import expect


def button(page, name):
    return page.get_by_role("group", name="Actions").get_by_role("button", name=name, exact=True)


def test_cancel_then_retry(server, page):
    job = post(server.url, scene(seconds=10))  # longer than it takes to click, on a machine that has more to do
    open_job(page, server.url, job["id"])
    wait_for_known(page, 0.01)
    button(page, "Cancel").click()
    wait_for_state(page, "cancelled")
    assert pictures.job(server.url, job["id"])["state"] == "cancelled"
    button(page, "Retry").click()
    wait_for_state(page, "done")
    wait_for_known(page, 1)


def test_pause_then_resume(server, page):
    job = post(server.url, scene(seconds=8))
    open_job(page, server.url, job["id"])
    wait_for_known(page, 0.01)
    button(page, "Pause").click()
    wait_for_state(page, "paused")
    page.wait_for_timeout(1500)  # what was in flight comes to its end
    before = pictures.job(server.url, job["id"])["progress"]
    page.wait_for_timeout(1500)
    assert pictures.job(server.url, job["id"])["progress"] == before
    button(page, "Resume").click()
    wait_for_state(page, "done")


def test_delete_asks_first(server, page):
    job = post(server.url, scene())
    open_job(page, server.url, job["id"])
    wait_for_state(page, "done")
    button(page, "Delete").click()
    dialog = page.get_by_role("dialog")
    expect(dialog.get_by_role("button", name="Keep")).to_be_focused()
    page.keyboard.press("Escape")
    expect(dialog).to_be_hidden()
    assert pictures.job(server.url, job["id"])["state"] == "done"

    button(page, "Delete").click()
    dialog.get_by_role("button", name="Delete").click()
    expect(page).to_have_url(f"{server.url}/#/")
    expect(page.locator(f'a[href="#/jobs/{job["id"]}"]')).to_have_count(0)


def test_a_change_made_elsewhere_shows(server, page):
    job = post(server.url, scene(seconds=30))
    open_job(page, server.url, job["id"])
    wait_for_known(page, 0.01)
    pictures.httpx.delete(f"{server.url}/v1/jobs/{job['id']}").raise_for_status()
    wait_for_state(page, "cancelled", seconds=5)


def test_cancel_comes_too_late_to_harm_a_finished_picture(server, page):
    job = post(server.url, scene())
    while pictures.job(server.url, job["id"])["state"] != "done":
        page.wait_for_timeout(50)

    def told_late(route):  # the page does not know yet that the job has ended
        route.fulfill(json=job) if route.request.method == "GET" else route.continue_()

    page.route(f"**/v1/jobs/{job['id']}", told_late)
    open_job(page, server.url, job["id"])
    wait_for_state(page, "queued")
    button(page, "Cancel").click()
    expect(page.get_by_role("alert")).to_contain_text("the job has ended (done)")
    assert pictures.job(server.url, job["id"])["state"] == "done"
    page.unroute_all()
    wait_for_state(page, "done")


def test_a_second_click_on_cancel_deletes_nothing(server, page):
    job = post(server.url, scene(seconds=30))
    open_job(page, server.url, job["id"])
    wait_for_known(page, 0.01)
    box = button(page, "Cancel").bounding_box()
    for pause in (40, 300):
        page.mouse.click(box["x"] + 5, box["y"] + 5)
        page.wait_for_timeout(pause)
    page.mouse.click(box["x"] + 5, box["y"] + 5)
    wait_for_state(page, "cancelled")
    assert pictures.job(server.url, job["id"])["state"] == "cancelled"
    expect(page.get_by_role("alert")).to_be_hidden()


def test_the_keyboard_stays_with_the_actions(server, page):
    job = post(server.url, scene(seconds=30))
    open_job(page, server.url, job["id"])
    wait_for_known(page, 0.01)
    button(page, "Cancel").focus()
    page.keyboard.press("Enter")
    wait_for_state(page, "cancelled")
    expect(button(page, "Retry")).to_be_focused()


def test_a_job_deleted_elsewhere_is_let_go(server, watched):
    page = watched.page
    job = post(server.url, scene(seconds=30))
    open_job(page, server.url, job["id"])
    wait_for_known(page, 0.01)
    for _ in range(2):
        pictures.httpx.delete(f"{server.url}/v1/jobs/{job['id']}").raise_for_status()
    expect(page.get_by_role("alert")).to_contain_text("It may have been deleted")
    expect(page.get_by_role("group", name="Actions")).to_be_hidden()
    expect(page.locator(".job-header .state")).to_have_text("deleted")
    page.wait_for_timeout(500)
    asked = []
    page.on("request", lambda request: asked.append(request.url))
    page.evaluate("document.dispatchEvent(new Event('visibilitychange'))")
    page.wait_for_timeout(7000)
    assert asked == []
