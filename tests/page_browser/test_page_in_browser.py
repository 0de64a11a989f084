"""The frame of the page: navigation, empty and error states, narrow windows, accessibility."""

from __future__ import annotations

import pytest
from page_tools import AXE, serious, wait_for, wait_for_figure

VIEWS = {
    "catalogue": ("#/catalogue?capture=ana/long_1", ".caption"),
    "copies": ("#/catalogue?show=duplicates", ".duplicate-group"),
    "search": ("#/search?q=walk,+turn+left&limit=5", ".answer"),
    "nothing": ("#/search?q=walk,+kick&where=performer%3Dana&limit=5", ".not-here"),
    "example": ("#/search?like=capture:fatou/kick_1&limit=5", ".answer"),
    "generate": ("#/generate?q=walk&seed=1", ".variant"),
    "symbols": ("#/symbols?symbol=3", ".segment-list li"),
    "no grammars": ("#/grammar", ".empty"),
}


@pytest.mark.skipif(not AXE.is_file(), reason="axe-core is not installed: npm ci")
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("view", VIEWS)
def test_axe_finds_nothing_serious(asked_server, new_page, view, scheme):
    hash_, there = VIEWS[view]
    page = new_page(f"{asked_server}{hash_}", color_scheme=scheme)
    page.locator(there).first.wait_for()
    assert serious(page) == []


@pytest.mark.parametrize("view", VIEWS)
def test_a_narrow_window_does_not_scroll_sideways(asked_server, new_page, view):
    hash_, there = VIEWS[view]
    page = new_page(f"{asked_server}{hash_}", size=(390, 780))
    page.locator(there).first.wait_for()
    assert page.evaluate("() => document.documentElement.scrollWidth") <= 390


def test_views_are_reached_by_keyboard_and_named(asked_server, new_page):
    page = new_page(f"{asked_server}#/catalogue")
    page.locator(".row-capture").first.wait_for()
    page.keyboard.press("Tab")
    assert page.evaluate("() => document.activeElement.textContent") == "Skip to the content"
    page.keyboard.press("Enter")
    assert page.evaluate("() => document.activeElement.id") == "view"
    page.get_by_role("link", name="Symbols").click()
    wait_for(page, "() => document.title === 'Symbols · motiondb'")
    assert page.get_by_role("link", name="Symbols").get_attribute("aria-current") == "page"


def test_colours_follow_the_system(asked_server, new_page):
    page = new_page(f"{asked_server}#/catalogue?capture=ana/bow_1")
    wait_for_figure(page)
    corner = (
        "() => document.querySelector('.player-canvas').getContext('2d').getImageData(2, 2, 1, 1)"
        ".data[0]"
    )
    assert page.evaluate(corner) > 150
    page.emulate_media(color_scheme="dark")
    wait_for(page, f"() => ({corner})() < 90")


def test_an_empty_database_says_what_to_do(serve_copy, new_page, tmp_path):
    address = serve_copy(database=tmp_path / "empty.duckdb")
    page = new_page(f"{address}#/search")
    page.get_by_role("heading", name="This database is empty").wait_for()
    for name in ("Generate", "Symbols", "Grammars"):
        page.get_by_role("link", name=name).click()
        page.get_by_role("heading", name="This database is empty").wait_for()
    page.get_by_role("button", name="Go to the catalogue").click()
    page.get_by_role("button", name="Add captures").first.wait_for()


def test_a_server_that_ended_is_noticed(browser, asked_server, new_page):
    page = new_page("about:blank")
    page.route("**/api/status", lambda route: route.abort())
    page.goto(asked_server)
    page.get_by_role("heading", name="motiondb cannot be reached").wait_for()
    page.unroute("**/api/status")
    page.get_by_role("button", name="Try again").click()
    page.locator(".row-capture").first.wait_for()


def test_a_change_by_another_program_appears(serve_copy, new_page, tmp_path):
    import motiondb

    page = new_page(f"{serve_copy()}#/catalogue?where=performer%3Dana")
    page.locator(".row-capture").first.wait_for()
    with motiondb.open(tmp_path / "copy.duckdb", wait=60.0) as db:
        db.set_words("ana/bow_1", "a deep curtsy")
    page.locator(".row-capture", has_text="a deep curtsy").wait_for()


def test_an_unknown_address_shows_the_catalogue(asked_server, new_page):
    page = new_page(f"{asked_server}#/nowhere")
    page.locator(".row-capture").first.wait_for()
    assert page.url.endswith("#/catalogue")
