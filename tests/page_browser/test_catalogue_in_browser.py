"""The catalogue: table, figures, facets, words, adding, learning, removing."""

from __future__ import annotations

import io
import json
import re
import zipfile
from urllib.parse import urlparse

from page_tools import AXE, drag_on, drop_files, pixels, serious, wait_for, wait_for_figure

import motiondb


def _names(page):
    return page.locator(".row-capture .capture-name").all_inner_texts()


def _row(page, name):
    return page.locator(".row-capture", has=page.get_by_text(name, exact=True))


def test_rows_show_what_is_known_and_figures_move(asked_server, new_page):
    page = new_page(f"{asked_server}#/catalogue", reduced_motion="no-preference")
    first = page.locator(".row-capture").first
    first.wait_for()
    text = first.inner_text()
    assert "ana/bow_1" in text
    assert "2.70 s" in text
    assert "someone bows politely" in text
    assert "CC0-1.0" in text
    wait_for_canvas = """() => document.querySelector('.thumb').getContext('2d')
        .getImageData(0, 0, 48, 60).data.some((value) => value > 0)"""
    wait_for(page, wait_for_canvas)
    seen = pixels(page, ".thumb")
    wait_for(page, "seen => document.querySelector('.thumb').toDataURL() !== seen", seen)


def test_ten_thousand_captures_are_scrolled_through(asked_server, new_page):
    page = new_page("about:blank")

    def answer(route):
        query = dict(pair.split("=") for pair in urlparse(route.request.url).query.split("&"))
        offset, limit = int(query["offset"]), int(query["limit"])
        rows = [
            {
                "name": f"take/{i:05}", "ref": f"capture:take/{i:05}", "kind": "captured",
                "format": "bvh", "fps": 30.0, "frames": 90, "duration": 3.0, "performer": "x",
                "licence": "CC0-1.0", "tags": {}, "words": [], "notes": [], "learned": True,
                "copies": 0,
            }
            for i in range(offset, min(offset + limit, 10_000))
        ]  # fmt: skip
        body = {"total": 10_000, "offset": offset, "revision": 1, "captures": rows}
        route.fulfill(json=body)

    page.route("**/api/captures?*", answer)
    page.goto(f"{asked_server}#/catalogue")
    page.get_by_text("take/00000", exact=True).wait_for()
    for share in (0.25, 0.5, 1.0):
        page.locator(".table").evaluate(
            "(table, share) => { table.scrollTop = share * table.scrollHeight; }", share
        )
    page.get_by_text("take/09999", exact=True).wait_for()
    assert page.locator(".row-capture").count() < 40
    assert page.locator(".table").get_attribute("aria-rowcount") == "10001"


def test_a_click_on_a_head_sorts_both_ways(asked_server, new_page):
    page = new_page(f"{asked_server}#/catalogue")
    page.get_by_role("button", name="Length").click()
    page.locator("[aria-sort=ascending]", has_text="Length").wait_for()
    page.get_by_role("button", name="Length").click()
    page.locator("[aria-sort=descending]", has_text="Length").wait_for()
    lengths = page.locator(".row-capture .cell-length").all_inner_texts()
    seconds = [float(text.split()[0]) for text in lengths]
    assert seconds == sorted(seconds, reverse=True)


def test_facets_and_filter_narrow_down(asked_server, new_page):
    page = new_page(f"{asked_server}#/catalogue")
    page.get_by_role("checkbox", name=re.compile("^dora")).check()
    page.get_by_text("11 of 101 captures").wait_for()
    page.get_by_role("checkbox", name=re.compile("^ana")).check()
    page.get_by_text("23 of 101 captures").wait_for()
    page.get_by_label("Filter").fill("duration>20")
    page.keyboard.press("Enter")
    wait_for(page, "() => !document.querySelector('.summary').textContent.startsWith('23')")
    assert {name.split("/")[0] for name in _names(page)} <= {"ana", "dora"}
    page.reload()
    page.locator(".row-capture").first.wait_for()
    assert page.get_by_role("checkbox", name=re.compile("^dora")).is_checked()


def test_rows_are_walked_and_opened_by_keyboard(asked_server, new_page):
    page = new_page(f"{asked_server}#/catalogue")
    page.locator(".row-capture").first.wait_for()
    page.locator(".table").focus()
    for _ in range(3):
        page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    page.get_by_role("heading", name="ana/jump_1").wait_for()
    page.keyboard.press("End")
    wait_for(page, "() => document.activeElement.getAttribute('aria-rowindex') === '102'")


def test_words_are_edited_in_the_row_and_undone(serve_copy, new_page):
    page = new_page(f"{serve_copy()}#/catalogue?where=performer%3Dana")
    row = _row(page, "ana/bow_1")
    row.locator(".words-button").click()
    page.get_by_label("Words of ana/bow_1").fill("a performer bows deeply; bow")
    page.keyboard.press("Enter")
    row.get_by_text("a performer bows deeply; bow").wait_for()
    page.get_by_text("Words of ana/bow_1 saved.").wait_for()
    page.reload()
    _row(page, "ana/bow_1").get_by_text("a performer bows deeply; bow").wait_for()
    page.get_by_role("button", name="Undo", exact=True).first.click()
    _row(page, "ana/bow_1").get_by_text("someone bows politely; bow").wait_for()


def test_words_are_written_about_a_dragged_part(serve_copy, new_page):
    page = new_page(f"{serve_copy()}#/catalogue?capture=ana/walk_1")
    wait_for_figure(page)
    drag_on(page, ".details .timeline-area", 0.2, 0.6)
    page.get_by_role("button", name="Write words").click()
    page.get_by_label("What happens in this part?").fill("takes two steps")
    page.get_by_role("button", name="Save words").click()
    caption = page.locator(".caption", has_text="takes two steps")
    caption.wait_for()
    start, end = (
        float(one) for one in re.findall(r"[\d.]+", caption.locator(".time").inner_text())
    )
    assert abs(start - 0.2 * 4.9) < 0.2
    assert abs(end - 0.6 * 4.9) < 0.2
    page.locator(".lane-captions .block", has_text="takes two steps").wait_for()
    caption.get_by_role("button", name="Remove “takes two steps”").click()
    caption.wait_for(state="detached")


def test_a_capture_is_removed_after_a_question(serve_copy, new_page):
    page = new_page(f"{serve_copy()}#/catalogue?capture=ana/bow_1")
    page.get_by_role("button", name="Remove this capture…").click()
    page.get_by_role("dialog").get_by_role("button", name="Cancel").click()
    page.get_by_role("button", name="Remove this capture…").click()
    page.get_by_role("dialog").get_by_role("button", name="Remove", exact=True).click()
    page.get_by_text("ana/bow_1 is removed.").wait_for()
    page.get_by_text("100 captures,").wait_for()


def test_dropped_files_are_added_and_a_reload_keeps_the_job(
    serve_copy, new_page, samples_folder, tmp_path
):
    address = serve_copy(database=tmp_path / "empty.duckdb")
    page = new_page(f"{address}#/catalogue")
    page.get_by_role("heading", name="This database is empty").wait_for()
    sheet = tmp_path / "words.tsv"
    sheet.write_text("file\twords\nwalk_1\ta person walks\n")
    files = [samples_folder / "ana" / f"{name}_1.bvh" for name in ("walk", "run", "jump")]
    drop_files(page, "#view", [*files, sheet])
    page.get_by_text("3 files ready to be added.").wait_for()
    page.get_by_text("How the files are to be read").click()
    page.get_by_label("Axis up").select_option("y")
    page.get_by_role("button", name="Add to the database").click()
    page.get_by_text("Adding has begun").wait_for()
    page.reload()
    page.locator(".jobs-button").click()
    page.locator(".job", has_text="3 added").wait_for()
    page.locator(".row-capture", has_text="a person walks").wait_for()
    filled = page.locator(".table-head .cell:visible").all_inner_texts()
    assert filled == ["Figure", "Capture", "Length", "Words"]  # nothing else is known of them
    with motiondb.open(tmp_path / "empty.duckdb", read_only=True) as db:
        assert len(db.captures()) == 3
        assert db.runs()[0]["parameters"]["up"] == "y"


def test_an_empty_database_to_which_captures_are_added_says_so(serve_copy, new_page, tmp_path):
    page = new_page("about:blank")
    adding = {"id": "j1", "kind": "add", "title": "add captures", "state": "running",
              "what": "reading", "share": 0.5, "error": None, "preview": None, "started": 1.0,
              "seconds": 9.0, "message": None, "error_kind": None, "result": None,
              "curve": []}  # fmt: skip
    page.route("**/api/jobs", lambda route: route.fulfill(json={"jobs": [adding]}))
    page.goto(f"{serve_copy(database=tmp_path / 'empty.duckdb')}#/catalogue")
    page.get_by_role("heading", name="Adding captures…").wait_for()
    assert page.get_by_role("heading", name="This database is empty").count() == 0


def test_a_folder_of_the_computer_is_added(serve_copy, new_page, samples_folder, tmp_path):
    address = serve_copy(str(samples_folder), database=tmp_path / "empty.duckdb")
    page = new_page("about:blank")
    held = []
    page.route("**/api/captures?*", lambda route: held.append(route))
    page.goto(f"{address}#/catalogue")
    page.locator(".catalogue-bar").wait_for(state="attached")
    while not held:
        page.wait_for_timeout(50)
    hidden = "!document.querySelector('.catalogue-bar .button')?.checkVisibility()"
    page.wait_for_function(hidden)  # while the rows are awaited: a button must not vanish later
    page.unroute("**/api/captures?*")
    page.reload()
    page.get_by_role("button", name="Add captures").click()
    page.get_by_text(re.compile("Folder captures on the server")).click()
    page.get_by_role("button", name="ana/").click()
    page.get_by_text("12 captures here").wait_for()
    page.get_by_role("button", name="Add to the database").click()
    page.locator(".message", has_text="12 added").wait_for()


def test_learning_shows_progress_over_a_reload_and_can_be_cancelled(serve_copy, new_page):
    address = serve_copy()
    page = new_page(f"{address}#/catalogue")
    page.get_by_role("button", name="Learn…").first.click()
    page.get_by_text("Settings").click()
    page.get_by_label("Number of movements").fill("6")
    page.get_by_role("dialog").get_by_role("button", name="Learn", exact=True).click()
    page.locator(".jobs-button.active").wait_for()
    page.reload()
    page.locator(".jobs-button.active").wait_for()
    page.locator(".jobs-button").click()
    page.locator(".job progress").first.wait_for()
    page.get_by_role("button", name="Cancel").click()
    page.locator(".job", has_text="Cancelled. The database stays as it was.").wait_for()
    status = json.loads(page.request.get(f"{address}api/status").text())
    assert status["symbols"] != 6


def test_a_read_only_page_offers_no_changes(serve_copy, new_page):
    page = new_page(f"{serve_copy('--read-only')}#/catalogue?capture=ana/bow_1")
    wait_for_figure(page)
    for name in ("Add captures", "Learn…", "Add words", "Remove this capture…"):
        assert page.get_by_role("button", name=name).count() == 0
    assert page.get_by_text("read only").count() > 0


def test_words_being_typed_are_neither_drawn_over_nor_saved(serve_copy, new_page, tmp_path):
    page = new_page(f"{serve_copy()}#/catalogue?where=performer%3Dana")
    row = _row(page, "ana/bow_1")
    row.locator(".words-button").click()
    field = page.get_by_label("Words of ana/bow_1")
    field.fill("half of a sen")
    changed = page.expect_response(lambda answer: "/api/status" in answer.url)
    with changed, motiondb.open(tmp_path / "copy.duckdb", wait=60.0) as db:
        db.words.set("ana/bow_1", "a deep curtsy")
    page.wait_for_timeout(1000)  # the rows would be drawn by now
    assert field.input_value() == "half of a sen"
    assert page.evaluate("() => document.activeElement.className") == "in-place"
    assert _row(page, "ana/bow_1").count() == 1
    with motiondb.open(tmp_path / "copy.duckdb", read_only=True, wait=60.0) as db:
        assert [caption.words for caption in db.words.captions("ana/bow_1")] == ["a deep curtsy"]
    field.press("Enter")  # versions are compared
    dialog = page.get_by_role("dialog")
    dialog.get_by_text("found others: a deep curtsy").wait_for()
    dialog.get_by_role("button", name="Cancel").click()
    row.get_by_text("a deep curtsy").wait_for()
    row.locator(".words-button").click()
    page.get_by_label("Words of ana/bow_1").fill("a very deep curtsy")
    page.get_by_label("Words of ana/bow_1").press("Enter")
    row.get_by_text("a very deep curtsy").wait_for()  # nobody changed it since
    page.get_by_text("Words of ana/bow_1 saved").wait_for()


def test_after_a_restart_of_the_server_nothing_stale_stays(serve_copy, new_page, tmp_path):
    address = serve_copy()
    page = new_page(f"{address}#/catalogue?capture=ana/bow_1")
    wait_for_figure(page)
    lost = {"id": "j1", "kind": "learn", "title": "learn", "state": "running", "what": "words",
            "share": 0.5, "error": None, "preview": None, "started": 1.0, "seconds": 9.0,
            "message": None, "error_kind": None, "result": None, "curve": []}  # fmt: skip
    page.route("**/api/jobs", lambda route: route.fulfill(json={"jobs": [lost]}))
    page.reload()
    page.locator(".jobs-button", has_text="learn 50 %").wait_for()
    page.locator(".row-capture .capture-name").first.wait_for()
    page.unroute("**/api/jobs")
    page.context.set_offline(True)
    page.get_by_label("Filter").fill("bow")
    page.keyboard.press("Enter")
    page.locator(".message.fault", has_text="The server does not answer").wait_for()
    assert page.locator(".row-capture .capture-name").count() > 0  # what is known stays
    page.evaluate("() => document.dispatchEvent(new Event('visibilitychange'))")  # connects again
    page.locator(".lost:visible").wait_for()
    page.context.set_offline(False)
    page.evaluate("() => document.dispatchEvent(new Event('visibilitychange'))")
    page.locator(".lost:visible").wait_for(state="hidden")
    page.locator(".message.fault").wait_for(state="hidden")
    page.locator(".jobs").wait_for(state="hidden")
    page.locator(".summary", has_text=" of 101 captures").wait_for()  # asked again


def test_bad_files_are_named_and_what_was_added_is_linked(
    serve_copy, new_page, samples_folder, tmp_path
):
    good = tmp_path / "good.bvh"
    good.write_bytes((samples_folder / "ana" / "bow_1.bvh").read_bytes())
    (tmp_path / "odd.txt").write_bytes(good.read_bytes())
    (tmp_path / "empty.bvh").write_bytes(b"")
    (tmp_path / "binary.bvh").write_bytes(bytes(range(256)) * 8)
    page = new_page(f"{serve_copy(database=tmp_path / 'new.duckdb')}#/catalogue")
    page.get_by_role("button", name="Add captures").click()
    names = ("good.bvh", "odd.txt", "empty.bvh", "binary.bvh")
    page.get_by_label("Choose files…").set_input_files([tmp_path / name for name in names])
    page.get_by_text("3 files ready to be added.").wait_for()
    refused = page.locator(".refused").inner_text()
    assert "odd.txt" in refused
    assert "found BVH. Let its name end in .bvh." in refused
    page.get_by_role("button", name="Add to the database").click()
    page.get_by_role("button", name="Show the problems").click()
    listed = page.locator(".job li").all_inner_texts()
    assert len(listed) == 2
    assert any(text.startswith("empty.bvh:") for text in listed)
    assert any(text.startswith("binary.bvh:") for text in listed)
    page.locator(".job-added").get_by_role("link", name="good", exact=True).click()
    page.get_by_role("heading", name="good", exact=True).wait_for()


def test_captures_are_browsed_as_previews_and_changed_together(serve_copy, new_page, tmp_path):
    page = new_page(f"{serve_copy()}#/catalogue?where=performer%3Dana")
    page.locator(".row-capture").first.wait_for()
    page.get_by_role("button", name="Previews").click()
    card = page.locator(".card", has_text="ana/jump_1")
    card.wait_for()
    wait_for_canvas = """() => [...document.querySelectorAll('.card')]
        .find((card) => card.textContent.includes('ana/jump_1')).querySelector('canvas')
        .getContext('2d').getImageData(0, 0, 220, 160).data.some((value) => value > 0)"""
    wait_for(page, wait_for_canvas)
    still = card.locator("canvas").evaluate("canvas => canvas.toDataURL()")
    card.hover()  # it plays while it is pointed at
    wait_for(
        page,
        """still => [...document.querySelectorAll('.card')]
            .find((card) => card.textContent.includes('ana/jump_1')).querySelector('canvas')
            .toDataURL() !== still""",
        still,
    )
    page.get_by_role("checkbox", name="Select ana/bow_1").click()
    page.get_by_role("checkbox", name="Select ana/jump_1").focus()
    page.keyboard.press("Space")
    page.get_by_text("2 captures selected").wait_for()
    focused = page.evaluate("() => document.activeElement.getAttribute('aria-label')")
    assert focused == "Select ana/jump_1"  # the card was not made anew
    bar = page.get_by_role("region", name="Selected captures")
    bar.get_by_text("2 captures selected").wait_for()
    bar.get_by_role("button", name="Tags…").click()
    page.get_by_role("dialog").get_by_role("textbox").fill("hall")
    page.keyboard.press("Enter")
    page.get_by_role("dialog").get_by_text("Write a tag and its value").wait_for()
    page.keyboard.press("Escape")
    bar.get_by_role("button", name="Licence…").click()
    page.get_by_label("The licence of all of them").fill("CC-BY-4.0")
    page.get_by_role("dialog").get_by_role("button", name="Set the licence").click()
    page.get_by_text("Licence of 2 captures.").wait_for()
    bar.get_by_role("button", name="Remove…").click()
    page.get_by_role("dialog").get_by_role("button", name="Remove", exact=True).click()
    page.get_by_text("10 of 99 captures").wait_for()
    page.locator(".message", has_text="Removal of 2").get_by_role("button", name="Undo").click()
    page.get_by_text("12 of 101 captures").wait_for()
    page.get_by_role("button", name="Previews").click()
    row = _row(page, "ana/jump_1")
    row.get_by_text("CC-BY-4.0").wait_for()
    row.get_by_role("checkbox").click()
    _row(page, "ana/bow_1").get_by_role("checkbox").click()
    bar.get_by_role("button", name="Rename…").click()
    assert page.get_by_label("Names like").input_value() == "ana/*"
    page.get_by_label("Names like").fill("ana/*_1")
    page.get_by_label("become").fill("ana/my_*_1")
    page.get_by_text("ana/jump_1 → ana/my_jump_1; ana/bow_1 → ana/my_bow_1").wait_for()
    page.get_by_role("dialog").get_by_role("button", name="Rename", exact=True).click()
    page.get_by_text("Name of 2 captures.").wait_for()
    held = []
    page.route("**/api/describe?*", lambda route: held.append(route))
    page.route("**/api/capture?*", lambda route: held.append(route))
    _row(page, "ana/my_bow_1").get_by_text("ana/my_bow_1").click()
    page.get_by_role("button", name="Download as BVH").wait_for()  # before anything is known of it
    page.unroute("**/api/capture?*")
    held.pop().continue_()
    page.locator(".details .lane-captions .block").first.wait_for()
    wait_for(page, "() => document.querySelector('.lane-words') === null")
    for route in held:
        route.continue_()
    page.locator(".details .lane-words .block").first.wait_for()
    drag_on(page, ".details .timeline-area", 0.3, 0.6)
    page.get_by_text("Download this part").click()
    with page.expect_download() as download:  # every format also of a part
        page.get_by_role("button", name="Download as CSV").first.click()
    assert download.value.suggested_filename.endswith(".csv")
    page.locator(".details .actions").get_by_role("button", name="Download as BVH").click()
    page.get_by_text("A BVH file has no place for its licence, which is CC-BY-4.0").wait_for()
    page.set_viewport_size({"width": 1400, "height": 700})
    page.locator(".details .actions summary").click()  # all of the menu is in sight
    wait_for(
        page,
        """() => [...document.querySelectorAll('.details .actions .menu-items button')].at(-1)
            .getBoundingClientRect().bottom <= innerHeight""",
    )


def test_a_filter_that_finds_nothing_or_cannot_be_read_leads_on(asked_server, new_page):
    page = new_page(f"{asked_server}#/catalogue", size=(390, 780))
    page.locator(".row-capture").first.wait_for()
    page.get_by_label("Filter").fill("lenght > 10")
    page.keyboard.press("Enter")
    page.get_by_text("Did you mean length or").wait_for()
    page.get_by_role("heading", name="The filter could not be read").wait_for()
    assert page.locator(".row-capture").count() == 0  # nothing that seems to be on its way
    page.get_by_label("Filter").fill("strolling")
    page.keyboard.press("Enter")
    page.get_by_role("button", name="Ask for “strolling”").click()
    page.locator(".answer").first.wait_for()


def test_captures_and_answers_are_kept_in_a_selection(serve_copy, new_page):
    address = serve_copy()
    page = new_page(f"{address}#/catalogue?where=performer%3Dana", size=(390, 844))

    def add(bar, name):
        page.get_by_role("region", name=bar).get_by_role("button", name="Add to a").click()
        page.get_by_label("Name of the selection").fill(name)
        page.get_by_role("dialog").get_by_role("button", name="Add", exact=True).click()
        page.get_by_text(f"Added to “{name}”.").last.wait_for()

    page.get_by_role("checkbox", name="Select ana/bow_1").click()
    add("Selected captures", "day 2")
    page.goto(f"{address}#/search?q=kick&limit=5")
    page.locator(".answer-head input[type=checkbox]").first.check()
    add("Selected answers", "day 2")
    page.goto(f"{address}#/catalogue?show=selections")
    kept = page.locator(".kept-selection")
    kept.get_by_text("2 parts of 2 captures").wait_for()  # open, as it is the only one
    kept.locator(".selected-part").nth(1).get_by_text(re.compile(r"\d–\d")).wait_for()
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    assert not AXE.is_file() or serious(page) == []
    kept.get_by_text("Download").click()
    with page.expect_download() as download:
        kept.get_by_role("button", name="Download as glTF").click()
    with zipfile.ZipFile(io.BytesIO(download.value.path().read_bytes())) as archive:
        assert "manifest.csv" in archive.namelist()
        assert sum(name.endswith(".glb") for name in archive.namelist()) == 2
    kept.get_by_role("button", name="Take ana/bow_1, whole, out of day 2").press("Enter")
    kept.get_by_text("1 part of 1 capture").wait_for()
    wait_for(page, "() => document.activeElement.matches('.kept-selection > summary')")
    kept.get_by_role("button", name="Remove selection").click()
    page.get_by_text("No selections").wait_for()
    page.get_by_role("button", name="Undo").last.click()
    kept.get_by_text("1 part of 1 capture").wait_for()
    kept.get_by_role("link", name="Filter by it").click()
    page.get_by_text("1 of 101 captures").wait_for()
