"""The frame of the page: navigation, empty and error states, narrow windows, accessibility."""

from __future__ import annotations

import pytest
from page_tools import AXE, serious, wait_for, wait_for_figure

import motiondb

VIEWS = {
    "wall": ("#/", ".tile"),
    "catalogue": ("#/catalogue?capture=ana/long_1", ".caption"),
    "copies": ("#/catalogue?show=duplicates", ".duplicate-group"),
    "search": ("#/search?q=walk,+turn+left&limit=5", ".answer"),
    "nothing": ("#/search?q=walk,+kick&where=performer%3Dana&limit=5", ".not-here"),
    "example": ("#/search?like=capture:fatou/kick_1&limit=5", ".answer"),
    "generate": ("#/generate?q=walk&seed=1", ".variant"),
    "rhythm": ("#/search?q=walk&rhythm=0+0.5+1+1.5", ".answer"),
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


def test_work_that_goes_on_leaves_the_head_of_a_phone_whole(asked_server, new_page):
    page = new_page("about:blank", size=(390, 780))
    job = {"id": "j1", "kind": "scene", "title": "scene of Pass and Shoot", "state": "running"}
    unknown = ("error", "preview", "message", "error_kind", "result")
    job |= {"what": "sampling", "share": 0.5, "started": 1.0, "seconds": 9.0, "curve": []}
    job |= dict.fromkeys(unknown)
    page.route("**/api/jobs", lambda route: route.fulfill(json={"jobs": [job]}))
    page.goto(f"{asked_server}#/catalogue")
    page.locator(".jobs-button.active").wait_for()
    assert page.locator(".jobs-button").inner_text().strip() == "50 %"
    nav, box = page.locator(".nav").bounding_box(), page.locator("#question").bounding_box()
    head = page.locator(".top").bounding_box()
    assert nav["y"] >= 0
    assert box["y"] + box["height"] <= head["height"]


def test_views_are_reached_by_keyboard_and_named(asked_server, new_page):
    page = new_page(f"{asked_server}#/catalogue")
    page.locator(".row-capture").first.wait_for()
    page.keyboard.press("Tab")
    assert page.evaluate("() => document.activeElement.textContent") == "Skip to the content"
    page.keyboard.press("Enter")
    assert page.evaluate("() => document.activeElement.id") == "view"
    page.get_by_text("Explore", exact=True).click()
    page.get_by_role("link", name="Symbols").click()
    wait_for(page, "() => document.title === 'Symbols · motiondb'")
    page.evaluate("() => { location.hash = '#/board?board=give-and-go'; }")
    wait_for(page, "() => document.title === 'give-and-go · Board · motiondb'")
    page.go_back()
    page.get_by_text("Explore", exact=True).click()
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
    for name, view in (("Generate", "generate"), ("Symbols", "symbols"), ("Grammars", "grammar")):
        if name != "Generate":
            page.get_by_text("Explore", exact=True).click()
        page.get_by_role("link", name=name).click()
        page.locator(f".view-{view}").get_by_role(
            "heading", name="This database is empty"
        ).wait_for()
        page.get_by_role("button", name="Try it with 101 sample captures").wait_for()
    page.get_by_role("button", name="Add captures").click()
    page.get_by_role("dialog").get_by_text("Drop captures here").wait_for()


def test_captures_without_captions_are_searched_with_words_of_others(
    serve_copy, new_page, some, tmp_path
):
    with motiondb.open(tmp_path / "wordless.duckdb") as db:
        db.add(some)
    page = new_page(f"{serve_copy(database=tmp_path / 'wordless.duckdb')}#/search?q=jump")
    page.get_by_text("expected a database that has learned, found only captures").wait_for()
    page.get_by_role("button", name="Learn…").click()
    dialog = page.get_by_role("dialog")
    assert dialog.get_by_label("Learn from").input_value() == "cmu"
    dialog.get_by_text(
        "The data used in this project was obtained from mocap.cs.cmu.edu"
    ).wait_for()
    dialog.get_by_role("button", name="Learn", exact=True).click()
    page.get_by_role("heading", name="Learning…").wait_for()
    page.locator(".answer").first.wait_for()  # the question is asked again by itself
    page.locator(".message", has_text="Started from cmu.").wait_for()
    page.get_by_role("link", name="motiondb").click()
    page.get_by_text("Words that it knows").wait_for()


def test_a_server_that_ended_is_noticed(browser, asked_server, new_page):
    page = new_page("about:blank")
    page.route("**/api/status", lambda route: route.abort())
    page.goto(asked_server)
    page.get_by_role("heading", name="motiondb cannot be reached").wait_for()
    page.unroute("**/api/status")
    page.get_by_role("button", name="Try again").click()
    page.locator(".tile").first.wait_for()


def test_a_change_by_another_program_appears(serve_copy, new_page, tmp_path):
    page = new_page(f"{serve_copy()}#/catalogue?where=performer%3Dana")
    page.locator(".row-capture").first.wait_for()
    with motiondb.open(tmp_path / "copy.duckdb", wait=60.0) as db:
        db.words.set("ana/bow_1", "a deep curtsy")
    page.locator(".row-capture", has_text="a deep curtsy").wait_for()


def test_an_unknown_address_shows_the_wall(asked_server, new_page):
    page = new_page(f"{asked_server}#/nowhere")
    page.locator(".tile").first.wait_for()
    assert page.url.endswith("#/wall")


def test_the_page_opens_on_a_question_that_finds_something(asked_server, new_page):
    page = new_page(asked_server)
    page.get_by_text("A library of human motion that you can ask.").wait_for()
    box = page.get_by_role("searchbox", name="What to search for")
    examples = page.locator(".examples .chip")
    examples.first.wait_for()
    questions = examples.all_inner_texts()
    assert len(questions) > 2
    assert any("," in question for question in questions)
    for question in questions:  # each is true of this database
        answer = page.request.get(f"{asked_server}api/search", params={"q": question}).json()
        assert answer["matches_anything"]
        assert answer["matches"][0]["probability"] >= 0.5
    examples.first.click()
    page.locator(".answer").first.wait_for()
    assert box.input_value() == questions[0]
    assert page.title() == f"{questions[0]} · Search · motiondb"
    for view in ("board", "symbols", "generate"):
        page.goto(f"{asked_server}#/{view}")
        page.keyboard.press("/")
        assert page.evaluate("() => document.activeElement.id") == "question"
    page.keyboard.type("kick")
    page.keyboard.press("Enter")
    page.locator(".answer", has_text="kick").first.wait_for()
    box.fill("")
    page.keyboard.press("Enter")
    page.get_by_label("Filter").wait_for()


def test_small_things_are_where_they_are_looked_for(asked_server, new_page):
    page = new_page(f"{asked_server}#/catalogue?capture=fatou/kick_1")
    row = page.locator(".row-capture[aria-selected=true]")
    row.wait_for()  # far down the table: it is brought into sight
    box, table = row.bounding_box(), page.locator(".table").bounding_box()
    assert table["y"] < box["y"] < table["y"] + table["height"]
    page.locator(".details .timeline-cursor").wait_for()
    assert page.title() == "fatou/kick_1 · Catalogue · motiondb"
    slider = page.locator(".details .player-slider").bounding_box()
    area = page.locator(".details .timeline-area").bounding_box()
    assert abs(slider["x"] + 8 - area["x"]) < 2.5  # one zero; the thumb has a radius of 8
    assert abs(slider["x"] + slider["width"] - 8 - (area["x"] + area["width"])) < 2.5
    page.locator(".player-canvas").focus()
    page.keyboard.press("?")
    page.get_by_role("dialog").wait_for()
    page.keyboard.press("Escape")
    page.get_by_role("dialog").wait_for(state="detached")
    page.get_by_role("heading", name="fatou/kick_1").wait_for()  # only the dialog was closed
    page.locator(".player-canvas").focus()
    page.keyboard.press("Escape")
    wait_for(page, "() => location.hash === '#/catalogue'")
    wait_for(page, "() => document.activeElement.textContent.includes('fatou/kick_1')")

    page.goto(f"{asked_server}#/search?q=walk+or+kick&limit=20")
    page.locator(".answer").nth(11).wait_for()
    page.evaluate("() => scrollTo(0, 900)")
    wait_for(page, "() => scrollY === 900")
    page.wait_for_timeout(300)
    page.locator(".answer .capture-name").nth(8).click()
    page.locator(".details .timeline-cursor").wait_for()
    page.go_back()
    wait_for(page, "() => scrollY === 900")

    page.goto(f"{asked_server}#/search?like=capture:fatou/kick_1&limit=5")
    page.locator(".answer").first.wait_for()
    wait_for(  # the example beside the answers, not above
        page,
        """() => {
          const [example, answer] = [".example", ".answer"].map((one) =>
            document.querySelector(one)?.getBoundingClientRect());
          return example && answer && example.right < answer.left;
        }""",
    )
    script = page.request.get(f"{asked_server}app.js", headers={"Accept-Encoding": "gzip"})
    assert script.headers["content-encoding"] == "gzip"
    assert "import" in script.text()
