"""The opening: a wall of moving bodies, which becomes the answers; an empty database."""

from __future__ import annotations

import pytest
from page_tools import pixels, wait_for

PICTURES = "() => [...document.querySelectorAll('.tile canvas')].map((one) => one.toDataURL())"
DRAWN = f"""() => {{
    const pictures = ({PICTURES})();
    return pictures.length >= 12 && new Set(pictures).size === pictures.length;
}}"""
SHIFT = """() => new Promise((done) => new PerformanceObserver((list) =>
    done(list.getEntries().reduce((sum, one) => sum + one.value, 0))
).observe({ type: 'layout-shift', buffered: true }) || setTimeout(() => done(0), 500))"""


def test_the_page_opens_on_bodies_that_move(asked_server, new_page):
    page = new_page(asked_server, size=(1440, 900), reduced_motion="no-preference")
    wait_for(page, DRAWN)
    before = page.evaluate(PICTURES)
    wait_for(page, f"before => ({PICTURES})().every((one, i) => one !== before[i])", before)
    page.locator(".examples .chip").first.wait_for()
    assert page.evaluate(SHIFT) < 0.02
    box = page.locator("#question").bounding_box()
    assert 200 < box["x"] + box["width"] / 2 < 1240
    assert 250 < box["y"] < 650
    seen = [one.bounding_box() for one in page.locator(".tile").all()]
    assert all(one["y"] + one["height"] <= 901 for one in seen)


def test_bodies_stand_where_no_motion_is_wanted(asked_server, new_page):
    page = new_page(asked_server, size=(390, 844), reduced_motion="reduce")
    wait_for(page, DRAWN)
    before = page.evaluate(PICTURES)
    page.wait_for_timeout(400)
    assert page.evaluate(PICTURES) == before


def test_the_wall_turns_into_the_answers(asked_server, new_page):
    page = new_page(asked_server, reduced_motion="no-preference")
    page.locator(".tile").first.wait_for()
    held = []
    page.route("**/api/search?*", lambda route: held.append(route))
    page.locator("#question").fill("kick")
    page.keyboard.press("Enter")
    page.get_by_text("Looking for “kick”…").wait_for()
    assert page.locator(".tile").count() >= 12  # nothing goes before something comes
    wait_for(page, "() => true")
    while not held:
        page.wait_for_timeout(50)
    held[0].continue_()
    page.locator(".answer", has_text="kick").first.wait_for()
    assert len(held) == 1  # the answers were asked for once
    assert page.locator(".top #question").input_value() == "kick"
    page.go_back()
    page.locator(".tile").first.wait_for()
    assert page.locator(".wall-box #question").input_value() == ""
    page.locator(".tile").first.click()
    page.locator(".details .timeline-cursor").wait_for()
    assert "start=" in page.url


def test_the_table_is_there_on_demand(asked_server, new_page):
    page = new_page(asked_server)
    page.get_by_role("link", name="101 captures").click()
    page.locator(".row-capture").first.wait_for()
    assert page.url.endswith("#/catalogue")
    page.reload()
    page.locator(".row-capture").first.wait_for()
    page.get_by_role("link", name="Wall").click()
    page.locator(".tile").first.wait_for()


@pytest.mark.slow
def test_an_empty_database_is_filled_by_one_click(serve_copy, new_page, tmp_path):
    page = new_page(serve_copy(database=tmp_path / "empty.duckdb"))
    page.get_by_role("button", name="Try it with 101 sample captures").click()
    page.get_by_role("heading", name="Adding captures…").wait_for()
    page.locator(".tile").first.wait_for(timeout=600_000)
    page.locator(".message", has_text="Learned from 101 captures").wait_for(timeout=600_000)
    page.locator("#question").fill("kick")
    page.keyboard.press("Enter")
    card = page.locator(".answer.likely").first
    card.wait_for()
    card.get_by_role("button", name="Play").click()
    seen = pixels(page, ".answer.likely .clip-canvas")
    wait_for(
        page,
        "seen => document.querySelector('.answer.likely .clip-canvas').toDataURL() !== seen",
        seen,
    )
