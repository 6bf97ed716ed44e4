"""The box for a new scene."""

import json

import pictures
import pytest
from pictures import scene, wait_for_state
from playwright.sync_api import expect


def open_box(page, server):
    page.goto(f"{server.url}/#/new")
    return page.get_by_label("Scene (JSON)")


def render(page):
    page.get_by_role("button", name="Render", exact=True).click()


def selected(page) -> str:
    return page.evaluate("() => { const b = document.activeElement; return b.value.slice(b.selectionStart, b.selectionEnd); }")


def test_pasted_scene_is_rendered(server, page):
    open_box(page, server).fill(json.dumps(scene(seed=7)))
    page.get_by_label("Name").fill("pasted")
    page.get_by_label("Priority").select_option("High")
    render(page)
    wait_for_state(page, "done")
    expect(page.get_by_role("heading", level=1)).to_have_text("pasted")
    job = pictures.job(server.url, page.url.rsplit("/", 1)[1])
    assert (job["name"], job["priority"], job["width"]) == ("pasted", 1, 96)


def test_an_example_fills_the_box_and_renders(server, page):
    box = open_box(page, server)
    options = page.get_by_label("Example").locator("option:not([value=''])")
    expect(options.first).to_be_attached()
    name = options.first.get_attribute("value")
    page.get_by_label("Example").select_option(name)
    expect(page.get_by_label("Name")).to_have_value(name)
    assert json.loads(box.input_value())["version"] == 1
    render(page)
    expect(page.locator("canvas")).to_be_visible()
    page.get_by_role("button", name="Cancel", exact=True).click()


def test_a_file_fills_the_box(server, page, tmp_path):
    box = open_box(page, server)
    file = tmp_path / "lamp.json"
    file.write_text(json.dumps(scene()))
    page.get_by_label("File").set_input_files(file)
    expect(box).to_have_value(file.read_text())
    expect(page.get_by_label("Name")).to_have_value("lamp")


def test_what_the_server_refuses_stands_beside_the_box_and_leads_to_its_place(server, page):
    document = scene()
    document["scene"][1]["object"]["radius"] = -0.5
    document["render"]["samples"] = 0
    box = open_box(page, server)
    box.fill(json.dumps(document, indent=2))
    render(page)
    faults = page.get_by_role("alert")
    radius = faults.get_by_role("button", name="scene[1].object.radius")
    expect(radius).to_contain_text("-0.5")
    expect(faults.get_by_role("button", name="render.samples")).to_be_visible()
    expect(box).to_have_attribute("aria-invalid", "true")
    assert faults.bounding_box()["x"] > box.bounding_box()["x"] + box.bounding_box()["width"]
    radius.click()
    assert selected(page) == "-0.5"

    document["scene"][1]["object"]["radius"] = 0.5
    document["render"]["samples"] = 4
    box.fill(json.dumps(document))
    render(page)
    wait_for_state(page, "done")


def test_broken_json_is_told_without_asking_the_server(server, watched):
    page = watched.page
    box = open_box(page, server)
    box.fill('{"version": 1,\n  "image": {"width": 64,}}')
    place = page.get_by_role("alert").get_by_role("button", name="line 2, column 24")
    expect(place).to_contain_text("a comma before }")
    place.click()
    assert selected(page) == ","
    posts = []
    page.on("request", lambda request: posts.append(request) if request.method == "POST" else None)
    render(page)
    expect(place).to_be_visible()
    assert posts == []
    box.fill('{"version": 1}')
    expect(page.get_by_role("alert")).to_be_empty()


def test_an_empty_box_says_what_to_do(server, page):
    box = open_box(page, server)
    render(page)
    expect(page.get_by_role("alert")).to_contain_text("There is no scene yet")
    expect(box).to_be_focused()


def test_a_lost_answer_makes_no_second_job(server, page):
    lost = []

    def lose_first(route):
        if route.request.method == "POST" and not lost:
            lost.append(route.fetch().status)  # it reached the server, but its answer is lost
            route.abort("connectionreset")
        else:
            route.continue_()

    page.route("**/v1/jobs", lose_first)
    open_box(page, server).fill(json.dumps(scene()))
    page.get_by_label("Name").fill("sent twice")
    render(page)
    expect(page.get_by_role("alert")).to_contain_text("The server does not answer")
    render(page)
    wait_for_state(page, "done")
    jobs = pictures.httpx.get(f"{server.url}/v1/jobs").json()["jobs"]
    assert lost == [202] and [job["name"] for job in jobs].count("sent twice") == 1


def test_what_was_typed_outlives_a_turn_of_the_page(server, page):
    text = json.dumps(scene(seed=17))
    open_box(page, server).fill(text)
    page.get_by_label("Name").fill("kept")
    page.get_by_label("Priority").select_option("High")

    def expect_kept():
        expect(page.get_by_label("Scene (JSON)")).to_have_value(text)
        expect(page.get_by_label("Name")).to_have_value("kept")
        expect(page.get_by_label("Priority")).to_have_value("1")

    page.get_by_role("link", name="Jobs", exact=True).click()
    expect(page.get_by_role("heading", level=1)).to_have_text("Jobs")
    page.go_back()
    expect_kept()
    page.reload()
    expect_kept()
    render(page)
    wait_for_state(page, "done")
    open_box(page, server)
    expect_kept()


def test_a_scene_too_large_to_be_kept_is_rendered_all_the_same(server, page):
    text = json.dumps(scene(seed=18)) + " " * 6_000_000  # beyond the quota of a page
    box = open_box(page, server)
    box.evaluate("(box, text) => { box.value = text; box.dispatchEvent(new Event('input')); }", text)
    page.wait_for_timeout(1000)
    render(page)
    wait_for_state(page, "done")


@pytest.mark.parametrize("fields", [{}, {"name": "its own", "priority": 3}])
def test_a_scene_may_come_wrapped_as_the_server_takes_it(server, page, fields):
    open_box(page, server).fill(json.dumps({"scene": scene(), **fields}, indent=1))
    render(page)
    wait_for_state(page, "done")
    job = pictures.job(server.url, page.url.rsplit("/", 1)[1])
    assert (job["name"], job["priority"]) == (fields.get("name", ""), fields.get("priority", 0))


def test_a_wrapped_scene_s_faults_lead_to_their_places(server, page):
    document = scene()
    document["scene"][1]["object"]["radius"] = -0.25
    open_box(page, server).fill(json.dumps({"scene": document}, indent=1))
    render(page)
    page.get_by_role("alert").get_by_role("button", name="scene[1].object.radius").click()
    assert selected(page) == "-0.25"


def test_a_key_given_twice_is_named_as_in_the_scene(server, page):
    text = json.dumps(scene(samples=2)).replace('"samples": 2', '"samples": 2, "samples": 3')
    open_box(page, server).fill(text)
    render(page)
    place = page.get_by_role("alert").get_by_role("button")
    expect(place.locator("code")).to_have_text("render.samples")
    place.click()
    assert selected(page) == "2"
