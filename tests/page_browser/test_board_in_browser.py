"""The tactics board: draw, see what cannot be played, make a scene, change it, save it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from page_tools import WAIT, wait_for, wait_for_figure

WALK = """diagram "A walk"
grammar basketball
court half

attack A1 at 0 8
1 walk A1 to 0 6
"""


def ground(page: Any, x: float, z: float) -> tuple[float, float]:
    """The place of the window that shows a place of the court."""
    px, py = page.evaluate(
        """([x, z]) => {
            const picture = document.querySelector('.board-court svg');
            const point = new DOMPoint(x, z).matrixTransform(picture.getScreenCTM());
            return [point.x, point.y];
        }""",
        [x, z],
    )
    return px, py


def drag(page: Any, start: tuple[float, float], end: tuple[float, float]) -> None:
    """Drag with the mouse from one place of the court to another."""
    page.mouse.move(*ground(page, *start))
    page.mouse.down()
    page.mouse.move(*ground(page, *end), steps=4)
    page.mouse.up()


def use_text(page: Any, text: str) -> None:
    """Give a board as text."""
    page.get_by_role("button", name="Text…").click()
    page.get_by_label("Text of the board").fill(text)
    page.get_by_role("button", name="Use this text").click()
    page.locator("[aria-label='step 1: A1 walk']").wait_for()


def opened(page: Any) -> Any:
    """The page, once its board is checked."""
    page.locator(".board-player").first.wait_for()
    wait_for(page, "() => document.querySelectorAll('.board-list li, .board-selected p').length")
    return page


def test_a_shipped_board_is_drawn_with_its_actions(asked_server, new_page):
    page = opened(new_page(f"{asked_server}#/board?board=give-and-go"))
    assert page.locator(".board-player").count() == 6
    assert page.locator(".board-element").count() == 8
    assert page.locator(".board-list li").first.inner_text() == "step 1: A1 pass to A2"
    assert page.get_by_role("button", name="Make the scene").is_enabled()


def test_people_stand_on_the_stage_before_anything_is_made_and_x_makes_it_large(
    asked_server, new_page
):
    page = opened(new_page(f"{asked_server}#/board?board=give-and-go"))
    wait_for_figure(page, ".board-scene .still .player-canvas")
    assert page.locator(".player-name").all_inner_texts() == ["A1", "A2", "A3", "D1", "D2", "D3"]
    wide = "() => document.querySelector('.board-scene .player-canvas').clientWidth"
    before = page.evaluate(wide)
    page.keyboard.press("x")
    wait_for(page, f"before => ({wide})() > 1.3 * before", before)
    page.get_by_role("button", name="Larger board").click()
    wait_for(page, f"before => ({wide})() === before", before)


def test_on_a_phone_the_court_stands_above_its_tools(asked_server, new_page):
    page = opened(new_page(f"{asked_server}#/board?board=give-and-go", size=(390, 844)))
    court, tools = (
        page.locator(name).bounding_box() for name in (".board-court svg", ".board-tools")
    )
    assert court["y"] + court["height"] <= tools["y"]
    assert court["y"] + court["height"] < 844


def test_an_action_that_cannot_be_played_turns_red_with_the_reason(asked_server, new_page):
    page = opened(new_page(f"{asked_server}#/board?board=give-and-go"))
    page.locator("[data-tool=dribble]").click()
    drag(page, (3.2, 0.6), (5.0, 4.0))
    page.locator(".board-element.infeasible").wait_for()
    reason = page.locator(".board-reason").first.inner_text()
    assert reason.strip().startswith("Only one player can have the ball at the beginning, here 2")
    assert "line" not in reason
    assert page.get_by_role("button", name="Make the scene").is_disabled()
    page.get_by_role("button", name="Undo").click()
    page.locator(".board-element.infeasible").wait_for(state="detached")


def test_a_drawing_goes_on_from_a_ghost_is_kept_and_dropped_only_when_asked(asked_server, new_page):
    page = opened(new_page(f"{asked_server}#/board"))
    page.locator("[data-tool=dribble]").click()
    drag(page, (0.0, 8.0), (1.0, 4.0))
    page.locator("[data-ghost='0']").wait_for()
    page.locator("[data-tool=shoot]").click()
    drag(page, (1.0, 4.0), (0.0, 0.0))  # a coach draws the shot from where the dribble ends
    page.locator("[aria-label^='step 2: A1 shoot']").wait_for()
    end = page.locator("[data-ghost='0']").get_attribute("transform")
    assert end == "translate(1 4)"  # and the dribble stays
    page.locator("[data-tool=pass]").click()
    drag(page, (1.0, 4.0), (-4.8, 5.6))  # between both: the shot comes a step later
    page.locator("[aria-label^='step 2: A1 pass to A2']").wait_for()
    page.locator("[aria-label^='step 3: A1 shoot']").wait_for()
    page.get_by_label("Board", exact=True).select_option("give-and-go")
    wait_for(page, "() => document.querySelectorAll('.board-element').length === 8")
    page.go_back()
    wait_for(page, "() => document.querySelectorAll('.board-element').length === 3")
    page.reload()
    wait_for(page, "() => document.querySelectorAll('.board-element').length === 3")
    page.get_by_label("Board", exact=True).select_option("new:carrying")
    dialog = page.get_by_role("dialog", name="Discard the unsaved drawing?")
    dialog.get_by_role("button", name="Cancel").click()
    wait_for(page, "() => document.querySelectorAll('.board-element').length === 3")
    page.get_by_label("Board", exact=True).select_option("new:carrying")
    dialog.get_by_role("button", name="Discard").click()
    page.locator("[data-place=object]").wait_for()  # the ground of another activity
    assert page.locator(".board-court-line, [data-tool=shoot]").count() == 0
    page.locator("[data-place=goal]").focus()
    page.keyboard.press("Shift+ArrowDown")
    page.locator("[data-place=goal][transform='translate(2 0.5)']").wait_for()


def test_players_and_actions_are_moved_by_pointer_and_keys(asked_server, new_page):
    page = opened(new_page(f"{asked_server}#/board?board=give-and-go"))
    drag(page, (0.4, 8.2), (2.0, 9.0))
    moved = page.locator("[data-player=A1]")
    wait_for(
        page,
        "() => /^translate\\((1\\.9|2)/.test("
        "document.querySelector('[data-player=A1]').getAttribute('transform'))",
    )
    before = moved.get_attribute("transform")
    moved.focus()
    page.keyboard.press("Shift+ArrowLeft")
    wait_for(
        page,
        "before => document.querySelector('[data-player=A1]').getAttribute('transform') !== before",
        before,
    )
    page.locator("[data-element='5']").focus()
    page.keyboard.press("Delete")
    wait_for(page, "() => document.querySelectorAll('.board-element').length === 7")


def test_a_player_is_placed_and_told_what_to_do_by_the_keyboard(asked_server, new_page):
    page = opened(new_page(f"{asked_server}#/board"))
    page.locator("[data-tool='team:defence']").click()
    page.mouse.click(*ground(page, 1.0, 6.5))
    page.locator("[data-player=D1]").wait_for()
    assert page.get_by_label("Guards").input_value() == "A1"
    page.get_by_label("Add", exact=True).select_option("run")
    page.locator("[aria-label^='step 1: D1 run']").wait_for()
    assert page.locator(".board-handle").count() == 1


def test_a_board_is_saved_as_the_text_that_the_command_line_reads(serve_copy, new_page, tmp_path):
    page = opened(new_page(f"{serve_copy()}#/board"))
    use_text(page, WALK)
    page.get_by_role("button", name="Save…").click()
    page.get_by_label("Name of the board").fill("stroll-1")
    page.get_by_role("button", name="Save", exact=True).click()
    wait_for(page, "() => location.hash.includes('board=stroll-1')")
    (saved,) = tmp_path.rglob("stroll-1.tactics")
    assert "1 walk A1 to 0 6" in saved.read_text()
    with page.expect_download() as download:
        page.get_by_role("button", name="Download", exact=True).first.click()
    assert download.value.suggested_filename == "stroll-1.tactics"
    assert "1 walk A1 to 0 6" in Path(download.value.path()).read_text()
    page.locator("[aria-label='step 1: A1 walk']").focus()
    page.keyboard.press("Delete")  # a drawing that is not saved
    wait_for(page, "() => localStorage.length === 1")
    saved.write_text(saved.read_text().replace("1 walk A1 to 0 6", "1 walk A1 to 0 5"))
    page.reload()
    page.get_by_text("Your unsaved drawing of the earlier one is kept here").wait_for()
    page.get_by_role("button", name="Show my drawing").click()
    page.get_by_text("with your unsaved changes").wait_for()
    assert page.locator("[aria-label='step 1: A1 walk']").count() == 0
    assert page.evaluate("() => localStorage.length") == 1
    saved.write_text("nothing of the kind")
    page.reload()
    page.get_by_role("button", name="Edit the text…").wait_for()
    assert page.locator(".board-player").count() == 0  # nobody of another board


def few_rounds(route: Any) -> None:
    """Let a scene be sampled in few rounds, so that the test is short."""
    route.continue_(post_data=json.dumps(json.loads(route.request.post_data) | {"rounds": 3}))


def made(page: Any) -> str:
    """The ref of the scene on the page, once its report is there."""
    page.locator(".board-rules").wait_for(state="attached", timeout=4 * WAIT)
    wait_for(page, "() => /scene=/.test(location.hash) && !location.hash.includes('job=')")
    return str(page.evaluate("() => new URLSearchParams(location.hash.split('?')[1]).get('scene')"))


def test_a_scene_is_made_survives_a_reload_and_follows_a_change(serve_copy, new_page):
    page = opened(new_page(f"{serve_copy()}#/board"))
    page.route("**/api/scenes", few_rounds)
    use_text(page, WALK)
    page.get_by_role("button", name="Make the scene").click()
    wait_for(page, "() => location.hash.includes('job=')")
    page.reload()
    page.locator("[aria-label='step 1: A1 walk']").wait_for()
    first = made(page)
    wait_for_figure(page, ".board-scene .player:not(.still) .player-canvas")
    report = page.locator(".board-report").inner_text()
    assert "A1 walk: at the end of its walk in step 1" in report
    assert "(0, 6)" not in report
    assert page.locator(".board-token").count() == 0
    page.locator(".board-scene .player-slider").fill("1")
    token = page.locator("[data-token=A1]")
    before = token.get_attribute("transform")
    page.locator(".board-scene .player-slider").fill("2")
    wait_for(
        page,
        "before => document.querySelector('[data-token=A1]').getAttribute('transform') !== before",
        before,
    )
    assert page.evaluate(
        "() => document.querySelector('.board-scene').scrollWidth"
        " <= document.querySelector('.board-right').clientWidth"
    )
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    drag(page, (0.0, 8.0), (0.5, 8.0))
    page.wait_for_function(
        "first => new URLSearchParams(location.hash.split('?')[1]).get('scene') !== first",
        arg=first, timeout=4 * WAIT,
    )  # fmt: skip
    second = made(page)
    moves = [url for url in asked if "/api/motion?" in url]
    assert any("ref=first" in url for url in moves)  # seen before its report was made
    assert any(second.removeprefix("scene:") in url for url in moves)
    page.goto(f"{page.url.split('#')[0]}#/")
    page.evaluate("() => localStorage.clear()")
    page.goto(f"{page.url.split('#')[0]}#/board?scene={second}")
    page.reload()
    page.locator("[aria-label='step 1: A1 walk']").wait_for()  # the board of the scene
