"""The player: keys, buttons, camera, marks."""

from __future__ import annotations

import pytest
from page_tools import drag_on, settled, wait_for, wait_for_figure

import motiondb
from tests.sample_motions import SAMPLES

CAPTURE = "#/catalogue?capture=ana/long_1"


@pytest.fixture
def player(asked_server, new_page):
    page = new_page(f"{asked_server}{CAPTURE}")
    page.locator(".details .timeline-cursor").wait_for()  # the motion is there
    wait_for_figure(page)
    page.locator(".player-canvas").focus()
    return page


def _time(page):
    return float(page.locator(".player-time").inner_text().split()[0])


def _press(page, key):
    page.keyboard.press(key)
    page.wait_for_timeout(150)


def test_frames_step_by_one(player):
    _press(player, "Home")
    start = _time(player)
    _press(player, "ArrowRight")
    _press(player, "ArrowRight")
    assert _time(player) == pytest.approx(start + 2 / 30, abs=0.011)
    _press(player, "ArrowLeft")
    assert _time(player) == pytest.approx(start + 1 / 30, abs=0.011)


def test_space_plays_and_pauses(player):
    _press(player, "Home")
    player.keyboard.press(" ")
    wait_for(player, "() => parseFloat(document.querySelector('.player-time').value) > 0.4")
    player.keyboard.press(" ")
    player.wait_for_timeout(200)
    paused = _time(player)
    player.wait_for_timeout(400)
    assert _time(player) == paused


def test_dragging_turns_the_camera_and_r_brings_it_back(player):
    _press(player, "r")
    seen = settled(player, ".player-canvas")
    drag_on(player, ".player-canvas", 0.3, 0.6)
    assert settled(player, ".player-canvas") != seen
    _press(player, "r")
    assert settled(player, ".player-canvas") == seen


@pytest.mark.parametrize("key", ["g", "t", "c"])
def test_grid_trails_and_contacts_can_be_seen(player, key):
    for _ in range(20):
        player.keyboard.press("ArrowRight")
    seen = settled(player, ".player-canvas")
    _press(player, key)
    assert settled(player, ".player-canvas") != seen
    _press(player, key)
    assert settled(player, ".player-canvas") == seen


def test_figures_are_drawn_flat_where_there_is_no_webgl(asked_server, new_page):
    page = new_page("about:blank")
    page.add_init_script(
        "const get = HTMLCanvasElement.prototype.getContext;"
        "HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {"
        "  return kind.startsWith('webgl') ? null : get.call(this, kind, ...rest); };"
    )
    page.goto(f"{asked_server}{CAPTURE}")
    page.get_by_role("heading", name="ana/long_1").wait_for()
    wait_for(
        page,
        """() => {
            const canvas = document.querySelector('.player-canvas');
            if (!canvas?.width) return false;
            const { data } = canvas.getContext('2d')
                .getImageData(0, 0, canvas.width, canvas.height);
            const first = data[0];
            return data.some((value, i) => i % 4 === 0 && Math.abs(value - first) > 30);
        }""",
    )


def test_what_was_not_captured_stands_as_a_box_while_it_is_needed(serve_copy, new_page, tmp_path):
    """A seat under who sits down, at the height that its sentence says."""
    path = tmp_path / "seats.duckdb"
    with motiondb.open(path) as db:
        db.add(SAMPLES / "captures" / "ana" / "sit_down_1.bvh")
        db.captures.quality()
        (seat,) = db.captures.ghosts("sit_down_1")
    assert seat.start > 0.6
    page = new_page(f"{serve_copy(database=path)}#/catalogue?capture=sit_down_1")
    page.locator(".details .timeline-cursor").wait_for()
    wait_for_figure(page)
    canvas = page.locator(".player-canvas[data-ghosts]")
    canvas.wait_for()
    canvas.focus()
    if page.get_by_role("button", name="Pause (Space)").count():
        page.keyboard.press(" ")
    _press(page, "Home")
    wait_for(page, "() => document.querySelector('.player-canvas').dataset.ghosts === '0'")
    for _ in range(round(30 * seat.start) + 5):
        page.keyboard.press("ArrowRight")
    wait_for(page, "() => document.querySelector('.player-canvas').dataset.ghosts === '1'")


_IN_SIGHT = """(() => {
  const { left, right } = document.querySelector(".timeline-scroll").getBoundingClientRect();
  const marks = [...document.querySelector(".timeline-ruler").children];
  const places = marks.map((one) => one.getBoundingClientRect().left);
  return places.filter((x) => x > left && x < right).length;
})()"""


def test_a_timeline_is_shown_nearer(asked_server, new_page):
    page = new_page(f"{asked_server}{CAPTURE}")
    ruler = page.locator(".timeline-ruler").first
    ruler.locator("span").first.wait_for()
    whole = ruler.bounding_box()
    n_marks = ruler.locator("span").count()
    nearer = page.get_by_label("Show less of the time line")
    for _ in range(3):
        nearer.click()
    assert ruler.bounding_box()["width"] > 3 * whole["width"]
    assert ruler.locator("span").count() > 2 * n_marks
    page.locator(".timeline-scroll").first.evaluate("part => (part.scrollLeft = part.scrollWidth)")
    wait_for(page, f"() => {_IN_SIGHT} > 5")
    page.locator(".timeline-scroll").first.evaluate("part => (part.scrollLeft = 0)")
    wait_for(page, f"() => {_IN_SIGHT} > 5")
    for _ in range(3):
        page.get_by_label("Show more of the time line").click()
    assert abs(ruler.bounding_box()["width"] - whole["width"]) < 1


def test_the_turntable_goes_around_until_it_is_stopped(player):
    _press(player, "Home")
    seen = settled(player, ".player-canvas")
    player.get_by_role("button", name="Go around them").click()
    player.wait_for_timeout(700)
    player.locator(".player-canvas").focus()
    _press(player, "v")
    turned = settled(player, ".player-canvas")
    assert turned != seen
    assert _time(player) == 0.0  # while the motion stands still
