"""Search by words and by example: chips, answers, reasons, parts, downloads."""

from __future__ import annotations

import io
import re
import zipfile

from page_tools import drag_on, drop_files, wait_for, wait_for_figure


def _open(new_page, server, hash_="#/search", **options):
    return new_page(f"{server}{hash_}", **options)


def _ask(page, question):
    page.get_by_role("searchbox", name="What to search for").fill(question)
    page.keyboard.press("Enter")


def test_a_question_is_understood_as_chips_and_answered(asked_server, new_page):
    page = _open(new_page, asked_server)
    _ask(page, "walk, turn left, sit down")
    page.locator(".answer").first.wait_for()
    chips = page.locator(".question .chips").first
    assert chips.inner_text().split() == [
        "Understood", "walk", "then", "turn", "left", "then", "sit", "down",
    ]  # fmt: skip
    first = page.locator(".answer").first
    assert "ana/long_1" in first.inner_text()
    assert first.locator(".found li").count() == 3
    assert first.locator(".answer-verdict .meter-value").count() == 1  # its certainty once
    assert first.locator(".timeline-lit").count() == 3
    assert first.locator(".lane-symbols .block").count() > 3
    assert first.locator(".lane-captions .block").count() > 0
    wait_for_figure(page, ".answer .clip-canvas")


def test_answers_play_only_the_matched_interval(asked_server, new_page):
    page = _open(new_page, asked_server, "#/search?q=jump&limit=5", reduced_motion="no-preference")
    wait_for_figure(page, ".answer .clip-canvas")
    interval = page.locator(".answer .found .time").first.inner_text()
    start, end = (float(number) for number in re.findall(r"[\d.]+", interval))
    places = page.evaluate(
        """async () => {
            const cursor = document.querySelector('.answer .timeline-cursor');
            const seen = [];
            for (let i = 0; i < 40; i += 1) {
                seen.push(parseFloat(cursor.style.left));
                await new Promise((done) => setTimeout(done, 100));
            }
            return seen;
        }"""
    )
    lit = page.locator(".answer .timeline-lit").first.evaluate(
        "e => [parseFloat(e.style.left), parseFloat(e.style.left) + parseFloat(e.style.width)]"
    )
    assert end > start
    assert len(set(places)) > 3
    assert min(places) >= lit[0] - 1
    assert max(places) <= lit[1] + 1


def test_what_is_seen_follows_what_is_likely(asked_server, new_page):
    page = _open(new_page, asked_server, "#/search?q=bow&limit=20")
    page.locator(".answer").first.wait_for()
    answer = page.request.get(f"{asked_server}api/search?q=bow&limit=20").json()
    chances = [match["probability"] for match in answer["matches"]]
    expected = ["likely" if p >= 0.5 else "unlikely" if p >= 0.05 else "folded" for p in chances]
    assert {"likely", "folded"} <= set(expected)
    for grade in ("likely", "unlikely", "folded"):
        assert page.locator(f".answer.{grade}").count() == expected.count(grade)
    assert page.locator(".answer.folded").first.is_hidden()
    page.get_by_text(f"{expected.count('folded')} more, all below 0.05").click()
    assert page.locator(".answer.folded").first.is_visible()
    assert page.locator(".answer .timeline-lit:not(.unlikely)").count() == expected.count("likely")
    words = page.locator(".answer .lane-symbols .block").all_inner_texts()
    assert any(word.isalpha() for word in words)  # the word of a symbol, not its number
    page.goto(f"{asked_server}#/search?q=stroll&limit=5")
    page.get_by_text("walk, for “stroll”").first.wait_for()
    page.get_by_text("from beginning to end").first.wait_for()
    asked = page.request.get(f"{asked_server}api/search?q=walk&limit=1").json()["matches"][0]
    assert (asked["start"], asked["end"]) == (0.0, asked["duration"])
    assert asked["interval_probability"] == asked["probability"]  # there is no other place
    page.locator(".answer", has_text="no probability").first.wait_for()  # who walks may not stroll
    assert page.locator(".answer .meter-value").count() == 0
    page.goto(f"{asked_server}#/search?q=wlak,+wave&limit=5")
    page.locator(".remarks", has_text="wlak").wait_for()
    assert page.locator(".remarks").inner_text().count("wlak") == 1


def test_an_unknown_word_is_named_and_can_be_replaced(asked_server, new_page):
    page = _open(new_page, asked_server, "#/search?q=wlak,+wave&limit=5")
    page.locator(".remarks", has_text="'wlak'").wait_for()
    page.get_by_role("button", name="walk", exact=True).click()
    wait_for(page, "() => document.querySelector('#question').value === 'walk, wave'")
    page.locator(".answer").first.wait_for()


def test_the_motions_of_answers_in_sight_travel_in_one_request(asked_server, new_page):
    page = new_page(f"{asked_server}#/search")
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url.partition("?")[0]))
    page.goto(f"{asked_server}#/search?q=walk")
    wait_for_figure(page, ".answer .clip-canvas")
    motions = [url for url in asked if "/api/motion" in url]
    assert motions == [f"{asked_server}api/motions"]


def test_a_dropped_file_is_the_example(asked_server, new_page, samples_folder):
    page = _open(new_page, asked_server, "#/search?q=walk&limit=5")
    page.locator(".answer").first.wait_for()
    drop_files(page, "#view", [samples_folder / "fatou" / "kick_1.bvh"])
    page.get_by_role("heading", name="Like kick_1.bvh").wait_for()
    page.locator(".answer").first.wait_for()
    page.locator(".answer", has_text="kick").first.wait_for()
    assert "like=upload" in page.url


def test_a_part_of_the_example_is_dragged_on_its_timeline(asked_server, new_page):
    page = _open(new_page, asked_server, "#/search?like=capture:ana/long_1&limit=5")
    wait_for_figure(page, ".example .player-canvas")
    page.locator(".answer").first.wait_for()
    drag_on(page, ".example .timeline-area", 0.5, 0.62)
    wait_for(page, "() => location.hash.includes('start=')")
    start = float(re.search(r"start=([\d.]+)", page.url).group(1))
    assert abs(start - 0.5 * 23.07) < 0.5
    field = page.get_by_role("spinbutton", name="Start of the part, seconds")
    assert abs(float(field.input_value()) - start) < 0.02
    wait_for(page, "() => document.querySelector('.answers').getAttribute('aria-busy') === 'false'")
    assert page.locator(".answer").count() > 0


def test_several_answers_are_downloaded(asked_server, new_page):
    page = _open(new_page, asked_server, "#/search?q=walk&limit=5")
    boxes = page.locator(".answer-head input[type=checkbox]")
    boxes.nth(0).check()
    boxes.nth(1).check()
    page.get_by_text("2 answers selected").wait_for()
    with page.expect_download() as download:
        page.get_by_role("button", name="Download as BVH").click()
    with zipfile.ZipFile(io.BytesIO(download.value.path().read_bytes())) as archive:
        motions = [name for name in archive.namelist() if name.endswith(".bvh")]
        assert len(motions) == 2
        assert archive.read(motions[0]).startswith(b"HIERARCHY")
    boxes.nth(1).uncheck()
    with page.expect_download() as download:
        page.get_by_role("button", name="Download as glTF").click()
    assert download.value.path().read_bytes().startswith(b"glTF")


def test_going_back_brings_the_last_question(asked_server, new_page):
    page = _open(new_page, asked_server, "#/search?q=walk&limit=5")
    page.locator(".answer").first.wait_for()
    _ask(page, "kick")
    wait_for(page, "() => location.hash.includes('kick')")
    page.go_back()
    wait_for(page, "() => document.querySelector('#question').value === 'walk'")


def test_a_card_says_the_probability_of_all_that_was_asked(asked_server, new_page):
    page = _open(new_page, asked_server, "#/search?q=not+walking&limit=5")
    page.locator(".answer").first.wait_for()
    asked = page.request.get(f"{asked_server}api/search?q=not+walking&limit=5").json()["matches"]
    assert asked[0]["parts"][0]["probability"] is None  # it is measured for the whole alone
    card = page.locator(".answer").first
    assert card.locator(".meter-value").inner_text() == f"{asked[0]['probability']:.2f}"
    assert "not measured" not in card.inner_text()

    def elsewhere(route):
        answer = route.fetch().json()
        answer["matches"][0]["parts"][0]["interval_probability"] = 0.04
        answer["matches"][0]["parts"][0]["end"] = answer["matches"][0]["end"] = 1.0
        answer["matches"][0]["probability"] = 0.3  # it stands below the likely one
        route.fulfill(json=answer)

    page.route("**/api/search?*", elsewhere)
    page.goto(f"{asked_server}#/search?q=walk&limit=2")
    page.locator(".answer.unlikely .time[title*='0.04']", has_text="about").wait_for()
    assert page.locator(".rank").all_text_contents() == ["1", "2"]
    placed = page.locator(".answer.unlikely").locator(".timeline-lit:not(.unlikely)")
    assert placed.count() == 0


COLOURS = """canvas => {
    const image = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
    return new Set(Array.from({ length: image.length / 28 }, (_, i) =>
        image[28 * i] + 256 * image[28 * i + 1] + 65536 * image[28 * i + 2])).size;
}"""


def test_no_box_is_empty_while_one_waits(asked_server, new_page):
    page = _open(new_page, asked_server, "#/catalogue")
    asked = []
    page.route("**/api/search?*", lambda route: asked.append(route))
    page.route("**/api/motion*", lambda _route: None)  # none arrives
    _ask(page, "kick")
    page.get_by_text("Looking for “kick”…").wait_for()
    assert page.locator(".skeleton").count() > 3
    asked[0].continue_()
    page.locator(".answer").first.wait_for()
    assert page.locator(".skeleton").count() == 0
    page.locator(".answer .clip-canvas[width='300']").first.wait_for(state="detached")
    canvas = page.locator(".answer .clip-canvas").first
    wait_for(page, f"() => ({COLOURS})(document.querySelector('.answer .clip-canvas')) > 12")
    assert canvas.evaluate(COLOURS) > 12  # a figure in the found pose


def test_a_place_plays_and_numbers_do_not_rise(asked_server, new_page):
    page = _open(new_page, asked_server, "#/search?like=capture:fatou/kick_1&start=0.4&end=1.8")
    page.locator(".answer").first.wait_for()
    chances = [float(text) for text in page.locator(".answer .meter-value").all_text_contents()]
    assert len(chances) > 1
    for group in page.locator(".answer-grid").all():
        told = [float(text) for text in group.locator(".meter-value").all_text_contents()]
        assert told == sorted(told, reverse=True)
    assert page.locator(".answer .capture-name", has_text="fatou/kick_1").count() == 0
    card = page.locator(".answer").first
    wait_for_figure(page, ".answer .clip-canvas")
    card.get_by_role("button", name="Play").wait_for()  # still: no motion is wanted
    place = "() => document.querySelector('.answer .timeline-cursor').style.left"
    before = page.evaluate(place)
    card.locator(".found .time").click()
    card.get_by_role("button", name="Pause").wait_for()
    wait_for(page, f"before => ({place})() !== before", before)


def test_figures_stand_still_while_an_answer_is_awaited(asked_server, new_page):
    page = _open(new_page, asked_server, "#/search?q=jump", reduced_motion="no-preference")
    wait_for_figure(page, ".answer .clip-canvas")
    held = []
    page.route("**/api/search?*", lambda route: held.append(route))
    _ask(page, "kick")
    wait_for(page, "() => document.querySelector('.view').classList.contains('busy')")
    place = "() => document.querySelector('.answer .timeline-cursor').style.left"
    before = page.evaluate(place)
    page.wait_for_timeout(700)
    assert page.evaluate(place) == before
    for route in held:
        route.continue_()
    page.locator(".answer", has_text="kick").first.wait_for()
    before = page.evaluate(place)
    wait_for(page, f"before => ({place})() !== before", before)  # and go on


def test_a_drawn_path_is_searched(asked_server, new_page):
    page = _open(new_page, asked_server, "#/search?q=walk")
    page.locator(".answer").first.wait_for()
    page.get_by_text("Options").click()
    box = page.locator(".path-floor").bounding_box()

    def to(right, up):
        page.mouse.move(
            box["x"] + (right + 4) / 8 * box["width"], box["y"] + (4 - up) / 8 * box["height"]
        )

    to(0, -2)
    page.mouse.down()
    for step in range(1, 21):
        to(0, -2 + step / 5)
    page.mouse.up()
    page.wait_for_url("**path=*")
    said = page.locator(".answer-verdict").first
    said.get_by_text("cm off a path of").wait_for()
    assert "walk" in said.inner_text()
    drawn = page.get_by_label("Along a path").input_value()
    assert len(drawn.split()) > 10
    to(2, 2)
    page.mouse.down()  # a click draws nothing
    page.mouse.up()
    assert page.get_by_label("Along a path").input_value() == drawn
    page.get_by_label("Along a path").fill("0,0 x")
    page.get_by_role("button", name="Search again").click()
    page.get_by_text("expected points such as").wait_for()


def test_a_tapped_rhythm_is_searched(asked_server, new_page):
    page = _open(new_page, asked_server, "#/search?q=walk", size=(390, 844))
    page.locator(".answer").first.wait_for()
    page.get_by_text("Options").click()
    pad = page.get_by_role("button", name="Tap", exact=True)
    times = page.get_by_label("In a rhythm")
    pad.press("Tab")  # moves on, and is no tap
    pad.click()
    pad.focus()
    for _ in range(4):
        page.wait_for_timeout(500)
        page.keyboard.press("Space")
    page.wait_for_url("**rhythm=*")
    taps = [float(tap) for tap in times.input_value().split()]
    assert len(taps) == 5
    assert 1.8 < taps[-1] < 3
    page.get_by_text(re.compile(r"5 taps, [12].\d a second")).wait_for()
    said = page.locator(".answer-verdict").first
    said.get_by_text("ms off the rhythm").wait_for()
    assert "walk" in said.inner_text()
    assert page.locator(".tap-mark").count() == 5
    page.get_by_role("button", name="Replay").click()
    page.locator(".tap-dot.on").wait_for()
    page.get_by_role("button", name="Stop").click()
    assert page.locator(".tap-dot.on").count() == 0
    times.fill("0 x")
    page.get_by_role("button", name="Search again").click()
    page.get_by_text("expected the times of 3 to 200 taps").wait_for()
    page.get_by_role("button", name="Clear").last.click()
    assert times.input_value() == ""
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
