"""The symbol space: the map, a click, the segments."""

from __future__ import annotations

import shutil
from pathlib import Path

from page_tools import wait_for, wait_for_figure

import motiondb


def test_the_map_has_every_symbol_and_a_click_plays_one(asked_server, new_page):
    page = new_page(f"{asked_server}#/symbols")
    page.locator(".dot").first.wait_for()
    symbols = page.request.get(f"{asked_server}api/symbols").json()["symbols"]
    assert page.locator(".dot").count() == len(symbols)
    assert page.locator("ellipse.cluster").count() == 0  # one cluster alone says nothing
    ends = page.locator(".map-axis").all_text_contents()  # what the axes are about
    assert len(ends) == 4
    low, high = ends[0].removeprefix("← "), ends[1].removesuffix(" →")
    axis = page.get_by_label("Horizontal axis").locator("option").first.inner_text()
    assert axis == f"axis 1: {low.split(', ')[0]} to {high.split(', ')[0]}"
    page.locator(".dot[data-symbol='3'] circle").click(force=True)
    page.get_by_role("heading", name="Symbol 3", exact=True).wait_for()
    wait_for_figure(page, ".symbol-clip .clip-canvas")
    segments = page.request.get(f"{asked_server}api/symbol?symbol=3").json()
    rows = page.locator(".segment-list li")
    assert rows.count() == min(len(segments["segments"]), 30)
    assert segments["segments"][0]["capture"] in rows.first.inner_text()


def test_a_symbol_is_chosen_by_keyboard(asked_server, new_page):
    page = new_page(f"{asked_server}#/symbols")
    page.locator(".dot[data-symbol='9']").focus()
    page.keyboard.press("Enter")
    page.get_by_role("heading", name="Symbol 9", exact=True).wait_for()
    assert page.locator(".dot.chosen").get_attribute("data-symbol") == "9"
    assert page.locator(".dot").last.get_attribute("data-symbol") == "9"  # nothing lies over it
    assert page.evaluate("() => document.activeElement.dataset.symbol") == "9"


def test_the_map_is_enlarged_and_shown_whole_again(asked_server, new_page):
    page = new_page(f"{asked_server}#/symbols")
    dot = page.locator(".dot[data-symbol='5']")
    before = dot.get_attribute("transform")
    page.get_by_role("button", name="Enlarge the map").click()
    assert dot.get_attribute("transform") != before
    page.get_by_role("button", name="All", exact=True).click()
    assert dot.get_attribute("transform") == before
    page.locator(".symbol-map").hover()
    page.mouse.wheel(0, -400)
    wait_for(
        page,
        """text => document.querySelector('.dot[data-symbol="5"]')
            .getAttribute('transform') !== text""",
        before,
    )


def test_a_movement_leads_to_the_map_with_figures_search_and_named_colours(asked_server, new_page):
    page = new_page(f"{asked_server}#/catalogue?capture=ana/long_1")

    def in_two_clusters(route):
        space = route.fetch().json()
        space["clusters"].append(space["clusters"][0] | {"cluster": 1})
        space["symbols"][0]["cluster"] = 1
        route.fulfill(json=space)

    page.route("**/api/symbols", in_two_clusters)
    block = page.locator(".details .lane-symbols .block").first
    block.wait_for()
    block.click()
    page.get_by_role("link", name="Show on the map of movements").click()
    page.locator(".dot.chosen").wait_for()
    wait_for(  # small people stand on the dots
        page,
        """() => {
            const canvas = document.querySelector('.symbol-figures');
            if (!canvas.width || !canvas.height) return false;
            const { width, height } = canvas;
            const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
            return data.filter((value, i) => i % 4 === 3 && value > 0).length > 500;
        }""",
    )
    legend = page.get_by_role("list", name="Clusters").inner_text()
    assert "walk" in legend
    assert page.locator("ellipse.cluster").count() == 2
    page.get_by_label("Find", exact=True).fill("kick")
    page.locator(".dot.other").first.wait_for()
    assert 0 < page.locator(".dot:not(.other)").count() < page.locator(".dot").count() / 2
    page.keyboard.press("Enter")
    page.locator(".symbol-panel .chip", has_text="kick").wait_for()


def test_who_leaves_is_not_brought_back_by_the_view_before(asked_server, new_page):
    """The catalogue writes the time of the player into its address while the map is loaded."""
    page = new_page(f"{asked_server}#/catalogue?capture=ana/long_1")
    held = []
    page.route("**/symbols-*.js", lambda route: held.append(route))
    block = page.locator(".details .lane-symbols .block").first
    block.wait_for()
    block.click()
    page.get_by_role("link", name="Show on the map of movements").click()
    wait_for(page, "() => location.hash.startsWith('#/symbols')")
    page.wait_for_timeout(1500)  # longer than the catalogue waits
    for route in held:
        route.continue_()
    page.locator(".dot.chosen").wait_for()
    assert page.evaluate("() => location.hash").startswith("#/symbols?symbol=")


def test_what_to_train_on_is_marked_on_the_map(serve_copy, new_page, learned_database, tmp_path):
    """A larger share covers more symbols; a library that was not measured says so."""
    path = shutil.copy(learned_database, tmp_path / "measured.duckdb")
    page = new_page(f"{serve_copy()}#/symbols")
    page.locator(".dot").first.wait_for()
    slider = page.get_by_role("slider", name="To train on")
    slider.fill("5")
    said = page.locator("[aria-label='What to train on'] output")
    wait_for(page, "() => document.body.innerText.includes('motiondb quality')")
    with motiondb.open(path) as db:
        db.captures.quality()
        wanted = db.curate(motiondb.CurateSettings(share=0.2)).splits[0]
    page.goto(f"{serve_copy(database=Path(path))}#/symbols")
    page.locator(".dot").first.wait_for()
    counts = []
    for share in ("2", "20"):
        slider.fill(share)
        wait_for(page, "() => document.body.innerText.includes('mean distance to the choice')")
        reply = page.request.get(f"{page.url.split('#')[0]}api/choice?share={int(share) / 100}")
        symbols = reply.json()["symbols"]
        counts.append(len(symbols))
        page.locator(f"text=of {len(symbols)} symbol").wait_for()
        found = page.locator(".dot:not(.other)")
        assert sorted(int(one) for one in found.evaluate_all(
            "(all) => all.map((one) => one.dataset.symbol)")) == symbols  # fmt: skip
    assert counts[0] < counts[1]
    assert f"{wanted.intervals} interval" in said.inner_text()
