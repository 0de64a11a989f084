"""Grammars: learn one, see it, make a sequence, edit it through its tree, keep and export it."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest
from page_tools import AXE, WAIT, pixels, serious, settled, wait_for, wait_for_figure

import motiondb

CAPTURES = ["chidi/long_play_1", "fatou/long_play_2"]
STRING = "() => [...document.querySelectorAll('.strip-item b')].map(b => b.textContent).join(' ')"


@pytest.fixture
def serve_grammar(serve_copy, grammar_database, tmp_path):
    """Serve a copy of that database."""

    def serve(*options: str) -> str:
        database = shutil.copy(grammar_database, tmp_path / "play.duckdb")
        return serve_copy(*options, database=Path(database))

    return serve


def made(page: Any, seed: int = 0) -> Any:
    """The page with a new sequence of the grammar."""
    page.get_by_label("Seed", exact=True).fill(str(seed))
    page.get_by_role("button", name="Make a sequence").click()
    page.locator(".strip-item").first.wait_for()
    return page


def choose_terminal(page: Any, at: int) -> None:
    """Click a terminal of the strip and wait for its alternatives."""
    page.locator(f".strip-item[data-at='{at}']").click()
    wait_for(page, "at => location.hash.includes(`at=${at}`)", at)
    wait_for(page, "() => document.querySelector('.corner') && !document.querySelector('[inert]')")


def string_of(page: Any) -> str:
    """The terminals of the strip."""
    text: str = page.evaluate(STRING)
    return text


def region_of(page: Any) -> str:
    """The terminals of the chosen region."""
    letters = page.locator(".region-string .letter").all_inner_texts()
    return " ".join(letters)


def test_grammars_are_listed_with_their_facts(grammar_server, new_page):
    page = new_page(f"{grammar_server}#/grammar")
    page.get_by_role("link", name="play", exact=True).wait_for()
    cells = page.locator(".grammar-table tbody tr").locator("td").all_inner_texts()
    assert cells[:6] == ["2", "46.8 s", "33", "8", "5", "6"]
    assert cells[-1] == "yes"
    page.get_by_role("link", name="play", exact=True).click()
    page.get_by_role("heading", name="play", exact=True).wait_for()
    assert "142.0 bits" in page.locator(".grammar-head").inner_text()
    rules = page.locator(".grammar-rules").inner_text()
    assert "S -> a b A [0.4]" in rules
    page.get_by_text("It derives sentences that were not in the captures.").wait_for()


def test_a_terminal_plays_its_medoid(grammar_server, new_page):
    page = new_page(f"{grammar_server}#/grammar?name=play")
    page.locator(".terminal[data-terminal='g']").click()
    wait_for_figure(page, ".terminal-clip .clip-canvas")
    assert "fatou/long_play_2" in page.locator(".terminal-clip").inner_text()
    assert "dribble" in page.locator(".terminal[data-terminal='g']").inner_text()


def test_a_grammar_is_learned_and_removed(serve_copy, new_page):
    page = new_page(f"{serve_copy()}#/grammar")
    page.get_by_role("heading", name="No grammars yet").wait_for()
    page.get_by_role("button", name="Learn a grammar…").click()
    assert page.get_by_role("button", name="Learn", exact=True).is_disabled()
    page.get_by_label("Filter").fill("nonsense===")
    page.locator("#grammar-where[aria-invalid=true]").wait_for()
    page.get_by_label("Filter").fill("")
    for name in CAPTURES:
        page.get_by_label(name).check()
    page.get_by_text("2 captures chosen, 46.8 s.").wait_for()
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("Name", exact=True).fill("ours")
    dialog.get_by_label("Terminals", exact=True).select_option("count")
    dialog.get_by_label("Number of terminals").fill("8")
    dialog.get_by_label("Longest sentence").fill("8")
    dialog.get_by_role("button", name="Learn", exact=True).click()
    page.locator(".grammar-job progress").wait_for()
    page.wait_for_function("() => location.hash.includes('name=ours')", timeout=3 * WAIT)
    page.get_by_text("grammar ours: Learned.").wait_for()
    page.locator(".terminal").first.wait_for()
    page.get_by_role("button", name="Remove…").click()
    page.get_by_role("button", name="Remove", exact=True).click()
    page.get_by_role("heading", name="No grammars yet").wait_for()


def test_what_cannot_be_learned_is_said(grammar_server, new_page):
    page = new_page(f"{grammar_server}#/grammar")
    page.get_by_role("button", name="Learn a grammar…").click()
    page.get_by_label("ana/bow_1").check()
    page.get_by_label("Shortest sentence").fill("9")
    page.get_by_label("Longest sentence").fill("2")
    page.get_by_role("button", name="Learn", exact=True).click()
    page.locator(".view-grammar .fault-state").wait_for()
    assert "longest" in page.locator(".view-grammar .fault-state").inner_text()


def test_a_sequence_is_edited_in_the_corners(grammar_server, new_page):
    page = made(new_page(f"{grammar_server}#/grammar?name=play"))
    wait_for_figure(page, ".editor .player-canvas")
    before = string_of(page)
    assert before == "c f b g c d b e"
    assert page.locator(".plan-path polyline").count() == 8
    choose_terminal(page, 5)
    panel = page.locator(".region-panel").inner_text()
    assert "generated by A" in panel
    assert region_of(page) == "c d b e"
    assert page.locator(".corner").count() == 1  # A has one other string
    wait_for_figure(page, ".corner .clip-canvas")
    page.get_by_role("button", name="Wider").click()
    wait_for(page, "() => document.querySelectorAll('.corner').length === 4")
    assert region_of(page) == before
    assert page.get_by_role("button", name="Wider").is_disabled()
    first = page.locator(".corner").first.get_attribute("aria-label")
    page.get_by_role("button", name="Four others").click()
    wait_for(page, "() => !document.querySelector('[inert]') && /draw=1/.test(location.hash)")
    assert page.locator(".corner").first.get_attribute("aria-label") is not None
    assert first is not None
    page.get_by_role("button", name="Narrower").click()
    wait_for(page, "() => document.querySelectorAll('.corner').length === 1")
    page.get_by_role("button", name="Choose alternative 1").click()
    wait_for(page, f"({STRING})", None)
    wait_for(page, "before => document.querySelectorAll('.strip-item').length === 10")
    assert string_of(page) == "c f b g g e c d b g"
    assert page.locator(".strip-edited").is_visible()
    page.get_by_role("button", name="Undo").click()
    wait_for(page, "() => document.querySelectorAll('.strip-item').length === 8")
    assert string_of(page) == before
    page.get_by_role("button", name="Redo").click()
    wait_for(page, "() => document.querySelectorAll('.strip-item').length === 10")
    page.go_back()
    wait_for(page, "() => document.querySelectorAll('.strip-item').length === 8")


def test_the_parse_tree_lights_and_chooses_regions(grammar_server, new_page):
    page = made(new_page(f"{grammar_server}#/grammar?name=play"))
    page.get_by_role("button", name="Parse tree").click()
    assert page.locator(".tree-bar").all_inner_texts() == ["S", "A"]
    choose_terminal(page, 5)
    assert page.locator(".tree-bar.chosen").inner_text() == "A"
    page.get_by_role("treeitem", name="S: c f b g c d b e").click()
    wait_for(page, "() => document.querySelector('.tree-bar.chosen').textContent === 'S'")
    assert region_of(page) == "c f b g c d b e"
    page.locator(".tree-bar.chosen").focus()
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    wait_for(page, "() => document.querySelector('.tree-bar.chosen').textContent === 'A'")


def test_everything_is_done_with_the_keyboard(grammar_server, new_page):
    page = made(new_page(f"{grammar_server}#/grammar?name=play"))
    page.locator(".strip-item").first.focus()
    page.keyboard.press("End")
    page.keyboard.press("ArrowLeft")
    assert page.evaluate("() => document.activeElement.dataset.at") == "6"
    page.keyboard.press("Enter")
    ready = """n => document.querySelectorAll('.corner').length === n
        && !document.querySelector('[inert]')"""
    wait_for(page, ready, 1)
    said = page.get_by_role("status", name="Chosen region")
    assert "b is generated by A. Region A: c d b e. 1 alternative" in said.inner_text()
    page.keyboard.press("w")
    wait_for(page, ready, 4)
    page.keyboard.press("n")
    wait_for(page, ready, 1)
    page.keyboard.press("1")
    wait_for(page, "() => document.querySelectorAll('.strip-item').length === 10")
    assert page.evaluate("() => document.activeElement.className") == "strip-item"
    page.keyboard.press("Control+z")
    wait_for(page, "() => document.querySelectorAll('.strip-item').length === 8")
    page.keyboard.press("Control+y")
    wait_for(page, "() => document.querySelectorAll('.strip-item').length === 10")
    page.keyboard.press("Enter")
    page.locator(".corner").first.wait_for()
    page.keyboard.press("Escape")
    page.locator(".corner").first.wait_for(state="detached")


def test_a_reload_keeps_the_sequence_the_region_and_redo(grammar_server, new_page):
    page = made(new_page(f"{grammar_server}#/grammar?name=play"))
    choose_terminal(page, 5)
    page.get_by_role("button", name="Choose alternative 1").click()
    wait_for(page, "() => document.querySelectorAll('.strip-item').length === 10")
    page.get_by_role("button", name="Undo").click()
    wait_for(page, "() => document.querySelectorAll('.strip-item').length === 8")
    choose_terminal(page, 2)
    page.get_by_role("button", name="Parse tree").click()
    page.reload()
    page.locator(".corner").first.wait_for()
    assert page.locator(".strip-item[aria-selected=true]").get_attribute("data-at") == "2"
    assert page.locator(".tree-bar").first.is_visible()
    page.get_by_role("button", name="Redo").click()
    wait_for(page, "() => document.querySelectorAll('.strip-item').length === 10")


def test_seed_length_and_pattern_are_obeyed(grammar_server, new_page):
    page = made(new_page(f"{grammar_server}#/grammar?name=play"), seed=3)
    assert string_of(page) == "a b c d b e"
    page.get_by_role("spinbutton", name="Terminals").fill("3")
    page.get_by_role("button", name="Make a sequence").click()
    wait_for(page, "() => document.querySelectorAll('.strip-item').length === 3")
    assert string_of(page) == "c h a"
    page.get_by_role("spinbutton", name="Terminals").fill("")
    page.get_by_label("Like").fill("e ... a")
    page.get_by_role("button", name="Next seed").click()
    wait_for(page, "() => location.hash.includes('seed=4')")
    wait_for(page, f"() => ({STRING})().startsWith('e ')")
    page.get_by_label("Like").fill("a a a")
    page.get_by_role("button", name="Make a sequence").click()
    page.locator(".view-grammar .fault-state").wait_for()


def test_a_sequence_is_kept_exported_and_opened_again(serve_grammar, new_page, tmp_path):
    address = serve_grammar()
    page = made(new_page(f"{address}#/grammar?name=play"), seed=3)
    with page.expect_download() as download:
        page.get_by_role("button", name="Download as BVH").click()
    # A generated motion comes with the sources of its frames: a zip of both.
    assert Path(download.value.path()).stat().st_size > 10_000
    with page.expect_download() as download:
        page.get_by_role("button", name="Download as glTF").click()
    assert Path(download.value.path()).stat().st_size > 10_000
    page.get_by_role("button", name="Keep…").click()
    page.get_by_label("Name of the capture").fill("new/ours")
    page.get_by_role("button", name="Keep", exact=True).click()
    page.locator(".editor-bar").get_by_role("link", name="new/ours").wait_for()
    page.locator(".editor-bar").get_by_role("link", name="new/ours").click()
    page.get_by_role("link", name="Open in the editor").click()
    page.locator(".strip-item").first.wait_for()
    assert string_of(page) == "a b c d b e"
    assert "name=play&sequence=q" in page.url
    page.get_by_text("Rules and terminals").click()
    assert page.get_by_role("link", name="new/ours").count() == 1
    with motiondb.open(tmp_path / "play.duckdb", read_only=True, wait=60.0) as db:
        assert db.grammars.saved("play") == ["new/ours"]


def test_an_alternative_that_cannot_be_played_says_why(serve_grammar, new_page, tmp_path):
    address = serve_grammar()
    with motiondb.open(tmp_path / "play.duckdb", wait=60.0) as db:
        db.remove(["chidi/long_play_1"])
    page = new_page(f"{address}#/grammar?name=play")
    page.get_by_text("removed: add it again to play its segments").wait_for()
    page.get_by_label("Like").fill("a b c d b e")
    made(page)
    choose_terminal(page, 0)
    reason = page.locator(".corner.not-playable").first
    reason.wait_for()
    assert "removed" in reason.inner_text()
    assert reason.get_by_role("button", name="Choose").count() == 0


def test_a_sequence_that_is_gone_is_said(grammar_server, new_page):
    page = new_page(f"{grammar_server}#/grammar?name=play&sequence=q0")
    page.locator(".editor .fault-state").wait_for()
    assert "Make it again" in page.locator(".editor .fault-state").inner_text()
    made(page)
    page.locator(".editor .fault-state").wait_for(state="detached")
    page.evaluate("() => { location.hash = '#/grammar?name=nothing'; }")
    page.get_by_role("button", name="All grammars").click()
    page.get_by_role("link", name="play", exact=True).wait_for()


def test_a_read_only_page_makes_sequences_but_changes_nothing(serve_grammar, new_page):
    page = new_page(f"{serve_grammar('--read-only')}#/grammar")
    page.get_by_role("link", name="play", exact=True).wait_for()
    assert page.get_by_role("button", name="Learn a grammar…").count() == 0
    page.get_by_role("link", name="play", exact=True).click()
    made(page)
    assert not page.get_by_role("button", name="Keep…").is_visible()
    assert page.get_by_role("button", name="Remove…").count() == 0
    choose_terminal(page, 5)


def test_a_tree_of_three_hundred_levels_is_shown(grammar_server, new_page):
    levels = 300
    page = new_page(f"{grammar_server}#/grammar?name=play")

    def deepen(route: Any) -> None:
        facts = route.fetch().json()
        item = facts["strip"][0]
        facts["string"] = [item["terminal"]] * levels
        facts["strip"] = [
            item | {"at": n, "start": 0.04 * n, "end": 0.04 * (n + 1)} for n in range(levels)
        ]
        facts["nodes"] = []
        for n in range(levels):
            parent = 2 * n - 2 if n else -1
            node = {
                "symbol": "X",
                "parent": parent,
                "start": n,
                "end": levels,
                "is_terminal": False,
            }
            leaf = {"symbol": item["terminal"], "parent": 2 * n, "start": n, "end": n + 1}
            facts["nodes"] += [node, leaf | {"is_terminal": True}]
        route.fulfill(body=json.dumps(facts), content_type="application/json")

    page.route("**/api/sequence?*", deepen)
    made(page)
    page.get_by_role("button", name="Parse tree").click()
    assert page.locator(".tree-bar").count() == levels
    page.locator(".strip-item[data-at='150']").click()
    wait_for(page, "() => document.querySelector('.tree-bar.chosen')?.dataset.node === '300'")
    assert page.locator(".tree-bar.chosen").get_attribute("aria-level") == "151"
    lit = page.locator(".tree-bar.chosen").bounding_box()
    box = page.locator(".strip-box").bounding_box()
    assert box["y"] <= lit["y"] <= box["y"] + box["height"]
    assert page.evaluate("() => document.documentElement.scrollWidth") <= 1400


def test_the_stage_shows_the_path_and_the_region(grammar_server, new_page):
    page = made(new_page(f"{grammar_server}#/grammar?name=play"))
    wait_for_figure(page, ".editor .player-canvas")
    before = settled(page, ".editor .player-canvas")
    choose_terminal(page, 1)
    wait_for(
        page,
        "before => document.querySelector('.editor .player-canvas').toDataURL() !== before",
        before,
    )
    assert pixels(page, ".editor .player-canvas") != before
    assert page.locator(".plan-region polyline").count() == 1


def test_an_emptied_player_keeps_no_picture(grammar_server, new_page):
    page = made(new_page(f"{grammar_server}#/grammar?name=play"))
    wait_for_figure(page, ".editor .player-canvas")
    page.evaluate("() => { location.hash = '#/grammar?name=play' }")
    page.locator(".editor").first.wait_for(state="hidden")
    page.route("**/api/motion?*", lambda request: None)  # the next motion does not come
    made(page, 3)
    wait_for(
        page,
        """() => {
            const canvas = document.querySelector('.editor .player-canvas');
            const { width, height } = canvas;
            const { data } = canvas.getContext('2d').getImageData(0, 0, width, height);
            return data.every((value, i) => value === data[i % 4]);
        }""",
    )


@pytest.mark.skipif(not AXE.is_file(), reason="axe-core is not installed: npm ci")
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious(grammar_server, new_page, scheme):
    page = new_page(f"{grammar_server}#/grammar", color_scheme=scheme)
    page.get_by_role("link", name="play", exact=True).wait_for()
    assert serious(page) == []
    page.get_by_role("button", name="Learn a grammar…").click()
    page.get_by_label("ana/bow_1").wait_for()
    assert serious(page) == []
    page.keyboard.press("Escape")
    page.get_by_role("link", name="play", exact=True).click()
    page.locator(".terminal").first.click()
    assert serious(page) == []
    made(page)
    page.get_by_role("button", name="Parse tree").click()
    choose_terminal(page, 0)
    assert serious(page) == []


def test_a_narrow_window_does_not_scroll_sideways(grammar_server, new_page):
    page = new_page(f"{grammar_server}#/grammar", size=(390, 780))
    page.get_by_role("link", name="play", exact=True).wait_for()
    width = "() => document.documentElement.scrollWidth"
    assert page.evaluate(width) <= 390
    page.get_by_role("link", name="play", exact=True).click()
    page.locator(".terminal").first.wait_for()
    assert page.evaluate(width) <= 390
    made(page)
    page.get_by_role("button", name="Parse tree").click()
    choose_terminal(page, 0)
    assert page.evaluate(width) <= 390
