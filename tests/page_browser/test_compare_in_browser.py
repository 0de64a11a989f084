"""Compare: answers on one clock and one ground, with their difference; links name the place."""

from __future__ import annotations

from page_tools import drag_on, serious, wait_for, wait_for_figure


def test_answers_and_a_dragged_part_are_compared_and_the_address_says_where(asked_server, new_page):
    page = new_page(f"{asked_server}#/search?q=kick&limit=5")
    page.locator(".answer").nth(1).wait_for()
    for box in page.get_by_label("Select ").all()[:2]:
        box.check()
    page.get_by_role("button", name="Compare", exact=True).click()
    page.locator(".compare-parts li").nth(1).wait_for()
    wait_for_figure(page, ".view-compare .player-canvas")
    assert page.locator(".player-name").count() == 2
    assert page.locator(".view-compare .lane").count() == 2  # on one clock
    page.locator(".compare-curve").wait_for()
    assert " cm now, most at the " in page.locator(".compare-now li").inner_text()
    name = "document.querySelector('.player-name').style.transform"
    beside = page.evaluate(f"() => {name}")
    page.get_by_label("Figures", exact=True).select_option("one")
    wait_for(page, "() => location.hash.includes('ground=one')")
    wait_for(page, f"beside => {name} !== beside", beside)
    page.get_by_label("Same moment").select_option("poses")  # time is stretched
    wait_for(page, "() => location.hash.includes('at=poses')")
    page.locator(".lane li[title*='times its speed'], .lane [title*='times its speed']").wait_for()
    page.get_by_label("Time", exact=True).fill("0.5")
    wait_for(page, "() => location.hash.includes('time=0.50')")
    page.reload()
    page.locator(".player-time", has_text="0.50 /").wait_for()
    assert serious(page) == []

    page.locator(".compare-parts a").first.click()  # the found part, selected in its take
    page.locator(".details .part-fields:visible").wait_for()
    assert "start=" in page.url
    drag_on(page, ".details .timeline-area", 0.3, 0.6)
    page.get_by_role("button", name="Compare this part").click()
    page.locator(".compare-parts li").nth(2).wait_for()
    wait_for(page, "() => document.querySelectorAll('.compare-curve').length === 2")
