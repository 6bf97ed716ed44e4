"""The list of jobs."""

import pictures
from pictures import post, scene
from playwright.sync_api import expect


def row(page, job):
    return page.locator(f'a.job[href="#/jobs/{job["id"]}"]')


def test_a_new_job_appears_and_its_row_follows_it_to_the_end(server, page):
    page.goto(f"{server.url}/#/")
    page.get_by_role("heading", name="Jobs").wait_for()
    job = post(server.url, scene(seconds=10), name="followed")
    expect(row(page, job)).to_contain_text("followed")
    expect(row(page, job).locator(".state")).to_have_text("running")
    expect(row(page, job).locator("progress")).to_be_visible()
    expect(row(page, job)).to_contain_text("left")
    expect(row(page, job).locator(".state")).to_have_text("done")
    expect(row(page, job)).to_contain_text("relMSE")
    page.wait_for_function("() => document.querySelector('a.job img').naturalWidth > 0")
    row(page, job).click()
    expect(page.get_by_role("heading", level=1)).to_have_text("followed")
    page.go_back()
    expect(row(page, job)).to_be_visible()


def test_newest_first_and_by_state(server, page):
    first, second = post(server.url, scene(), name="first"), post(server.url, scene(seconds=60), name="second")
    page.goto(f"{server.url}/#/")
    expect(row(page, first).locator(".state")).to_have_text("done")
    order = page.locator("a.job").evaluate_all("(rows) => rows.map((row) => row.getAttribute('href'))")
    assert order.index(f"#/jobs/{second['id']}") < order.index(f"#/jobs/{first['id']}")

    page.get_by_label("Show").select_option("running")
    expect(row(page, first)).to_have_count(0)
    expect(row(page, second)).to_have_count(1)
    pictures.httpx.delete(f"{server.url}/v1/jobs/{second['id']}").raise_for_status()
    expect(row(page, second)).to_have_count(0)


def test_more_jobs_than_a_page(own_server, page):
    jobs = [post(own_server.url, scene(samples=1, size=(8, 8))) for _ in range(53)]
    page.goto(f"{own_server.url}/#/")
    expect(page.locator("a.job")).to_have_count(50)
    page.get_by_role("button", name="Show more").click()
    expect(page.locator("a.job")).to_have_count(53)
    expect(page.get_by_role("button", name="Show more")).to_be_hidden()
    order = page.locator("a.job").evaluate_all("(rows) => rows.map((row) => row.getAttribute('href'))")
    assert order == [f"#/jobs/{job['id']}" for job in reversed(jobs)]


def test_text_from_outside_stays_text(server, page):
    name = '<img src="/nothing" onerror="document.title = 1"> & "quotes"'
    job = post(server.url, scene(), name=name)
    page.goto(f"{server.url}/#/")
    expect(row(page, job).locator(".job-name")).to_have_text(name)
    row(page, job).click()
    expect(page.get_by_role("heading", level=1)).to_have_text(name)
    assert page.locator('img[src="/nothing"]').count() == 0


def test_an_empty_list_leads_on(own_server, page):
    page.goto(own_server.url)
    page.get_by_role("link", name="Render an example scene").click()
    expect(page.get_by_role("heading", level=1)).to_have_text("New render")
