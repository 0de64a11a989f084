"""Describe and generate: variants, what is shown, sources, downloads, keeping."""

from __future__ import annotations

import json
from typing import Any

from page_tools import wait_for, wait_for_figure

ALL_PLAY = """() => [...document.querySelectorAll('.variant .timeline-cursor')]
    .every((cursor) => parseFloat(cursor.style.left) > 5)"""
ASKED = "#/generate?q=a+person+walks+then+kicks&seed=7"


def test_a_sentence_becomes_motion_with_its_sources(asked_server, new_page):
    page = new_page(f"{asked_server}#/generate")
    page.get_by_label("What the person does").fill("a person walks then kicks")
    page.get_by_label("Seed").fill("7")
    page.get_by_role("button", name="Generate", exact=True).click()
    wait_for_figure(page, ".variant .clip-canvas")
    shown = page.locator(".made-block").all_inner_texts()
    assert len(shown) == 2
    assert "walks" in shown[0]
    assert "shown" in shown[0]
    assert "kicks" in shown[1]
    sources = page.locator(".lane-stretches .block")
    assert sources.count() >= 1
    assert "licence CC0-1.0" in sources.first.get_attribute("title")
    page.get_by_text("Sources and licences").click()
    page.get_by_text("licence CC0-1.0").first.wait_for()


def test_variants_play_together_however_late_their_motion_comes(asked_server, new_page):
    page = new_page(f"{asked_server}#/generate")
    held: list[Any] = []
    page.route("**/api/motion?*", lambda request: held.append(request))
    page.goto(f"{asked_server}#/generate?q=walk&seed=3&variants=2")
    page.get_by_text("seed 4").wait_for()
    page.get_by_role("button", name="Play together").click()
    page.wait_for_timeout(500)  # some frames are drawn without a motion
    for request in held:
        request.continue_()
    wait_for(page, ALL_PLAY)
    assert page.get_by_role("button", name="Pause: walk, seed 3").count() == 1


def test_made_motion_is_downloaded_and_kept(serve_copy, new_page):
    page = new_page(f"{serve_copy()}{ASKED}")
    with page.expect_download() as download:
        page.get_by_role("button", name="Download as glTF").click()
    assert download.value.suggested_filename == "a-person-walks-then-kicks.glb"
    data = download.value.path().read_bytes()
    asset = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])["asset"]
    assert "licence CC0-1.0" in asset["copyright"]
    with page.expect_download() as download:
        page.get_by_role("button", name="Download as BVH").click()
    assert download.value.suggested_filename == "a-person-walks-then-kicks.bvh"
    assert download.value.path().read_text().startswith("HIERARCHY")
    page.get_by_text("A BVH file has no place for its licence, which is CC0-1.0").wait_for()
    page.get_by_role("button", name="Keep…").click()
    page.get_by_label("Name of the capture").fill("new/walk_kick")
    page.get_by_role("button", name="Keep", exact=True).click()
    page.get_by_role("link", name="new/walk_kick").click()
    page.get_by_role("heading", name="new/walk_kick").wait_for()
    page.locator(".lane-stretches .block").first.wait_for()


NAMES = "[...document.querySelectorAll('.made-block b')].map(one => one.textContent).join()"
SECONDS = """parseFloat(
    document.querySelector('.variant .answer-head .muted').textContent.split(', ')[1])"""


def drag(page, locator, x: float, at: float = 0.5) -> None:
    """Drag from a share of the width of an element, by pixels to the right."""
    box = locator.bounding_box()
    left, top = box["x"] + at * box["width"], box["y"] + box["height"] / 2
    page.mouse.move(left, top)
    page.mouse.down()
    page.mouse.move(left + x / 2, top, steps=3)
    page.mouse.move(left + x, top, steps=3)
    page.mouse.up()


def test_blocks_are_dragged_to_another_place_and_stretched_at_their_edge(asked_server, new_page):
    page = new_page(f"{asked_server}#/generate?q=walk,+then+kick&seed=0")
    wait_for(page, f"() => {NAMES} === 'walk,kick'")
    before = page.evaluate(SECONDS)
    lane = page.locator(".made-lane").bounding_box()
    drag(page, page.locator(".made-block-edge").nth(0), lane["width"] / before)  # by one second
    wait_for(page, f"before => Math.abs({SECONDS} - before - 1) < 0.35", before)
    assert page.get_by_label("Seconds of walk").count() == 1  # it stays chosen
    drag(page, page.locator(".made-block").nth(0), 0.8 * lane["width"], at=0.2)
    wait_for(page, f"() => {NAMES} === 'kick,walk'")
    page.locator(".made-block-body").nth(0).focus()
    page.keyboard.press("Alt+ArrowRight")
    wait_for(page, f"() => {NAMES} === 'walk,kick'")


def test_actions_are_moved_lengthened_and_taken_from_elsewhere(asked_server, new_page):
    page = new_page(f"{asked_server}#/generate?q=walk,+then+kick&seed=0")
    wait_for(page, f"() => {NAMES} === 'walk,kick'")
    page.get_by_text("More", exact=True).click()
    page.get_by_role("button", name="Move later: walk").click()
    wait_for(page, f"() => {NAMES} === 'kick,walk'")
    page.locator(".made-block").nth(0).click()
    before = page.locator(".made-tools").inner_text()
    page.get_by_role("button", name="Another place for kick").click()
    wait_for(page, "before => document.querySelector('.made-tools').innerText !== before", before)
    page.locator(".made-block").nth(1).click()
    page.get_by_label("Seconds of walk").fill("6")
    page.keyboard.press("Enter")
    wait_for(page, f"() => {SECONDS} > 6.5")
    page.locator(".made-block").nth(0).click()
    page.get_by_role("button", name="Pick an excerpt for kick").click()
    page.locator(".pick-list li").first.wait_for()
    page.get_by_label("Capture", exact=True).fill("ana/walk_1")
    page.get_by_label("from", exact=True).fill("0")
    page.get_by_label("to", exact=True).fill("1.6")
    page.get_by_role("button", name="Use this excerpt").click()
    page.get_by_text("picked: ana/walk_1, 0.00–1.60 s").wait_for()
    assert page.locator(".made-block.shown").count() == 1  # a walk is not called a kick
    page.reload()
    page.get_by_text("picked: ana/walk_1, 0.00–1.60 s").wait_for()
    page.get_by_label("A further action").fill("cartwheel")
    page.get_by_role("button", name="Add by hand…").click()  # no caption says it
    page.get_by_label("Capture", exact=True).fill("ana/bow_1")
    page.get_by_label("from", exact=True).fill("0")
    page.get_by_label("to", exact=True).fill("1.5")
    page.get_by_role("button", name="Use this excerpt").click()
    page.locator(".made-block.not-sure", has_text="cartwheel").wait_for()
    page.go_back()
    page.locator(".made-block", has_text="cartwheel").wait_for(state="detached")
    page.go_back()
    page.get_by_text("picked:").wait_for(state="detached")
    wait_for(page, f"() => {NAMES} === 'kick,walk'")


def test_a_question_that_cannot_be_made_is_refused_with_a_sentence(asked_server, new_page):
    page = new_page(f"{asked_server}#/generate?q=frobnicate&seed=0")
    fault = page.get_by_role("alert").filter(has_text="frobnicate")
    fault.wait_for()
    page.locator(".known-words button").first.wait_for()


def test_an_action_that_is_not_shown_is_a_red_block(asked_server, new_page):
    page = new_page("about:blank")

    def unshown(route):
        answer = route.fetch().json()
        answer["variants"][0]["shown_actions"][1]["shown"] = False
        route.fulfill(json=answer)

    page.route("**/api/generate", unshown)
    page.goto(f"{asked_server}{ASKED}")
    page.locator(".made-block.not-shown", has_text="kick").wait_for()
    assert page.locator(".made-block.not-shown").count() == 1
