"""The same page as one file: answers and motions inside it, and no request."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from page_tools import wait_for, wait_for_figure

import motiondb
from motiondb import StandalonePage

_BUNDLE = Path(__file__).parents[2] / "motiondb" / "page" / "bundle"


@pytest.fixture
def asked(learned_database) -> Iterator[motiondb.MotionDB]:
    with motiondb.open(learned_database, read_only=True) as db:
        yield db


@pytest.fixture
def open_file(new_page, tmp_path):
    """Write a page, open it without a server, and list what it asks for from elsewhere."""

    def opened(shown: StandalonePage):
        page, requests = new_page("about:blank"), []
        page.on("request", lambda request: requests.append(request.url))
        page.goto(shown.write(tmp_path / "answer.html").as_uri())
        return page, requests

    return opened


def _elsewhere(requests: list[str]) -> list[str]:
    """The requests for what the file does not hold itself."""
    return [url for url in requests if not url.startswith(("file:", "data:", "blob:"))]


def test_answers_play_without_a_request(asked, open_file):
    page, requests = open_file(StandalonePage.of_search(asked, asked.search("walk", limit=3)))
    wait_for_figure(page, ".answer .clip-canvas")
    assert page.locator(".answer").count() == 3
    assert page.locator(".question .chip").first.inner_text() == "walk"
    page.get_by_text("Why this answer").first.click()
    assert page.locator(".reasons tbody tr").first.is_visible()
    assert "CC0-1.0" in page.locator(".answer").first.inner_text()
    assert page.locator(".answer a").count() == 0
    assert _elsewhere(requests) == []


def test_generated_motion_keeps_its_sources(asked, open_file):
    page, _ = open_file(StandalonePage.of_generated(asked, asked.generate("walk then kick", 7)))
    wait_for_figure(page, ".variant .clip-canvas")
    page.get_by_text("Sources and licences").click()
    page.get_by_text("licence CC0-1.0").first.wait_for()
    assert page.get_by_role("button", name="Download as BVH").count() == 0


def test_one_capture_has_its_timeline_and_licence(asked, open_file):
    page, _ = open_file(StandalonePage.of_capture(asked, "ana/long_1"))
    wait_for_figure(page)
    assert page.locator(".lane-symbols .block").count() == len(asked.show("ana/long_1").segments)
    page.get_by_text("licence CC0-1.0").wait_for()


def test_an_example_plays_above_its_answers(asked, open_file):
    answer = asked.like("fatou/kick_1", limit=2)
    page, _ = open_file(StandalonePage.of_like(asked, answer, "fatou/kick_1", 0, 1))
    wait_for_figure(page)
    wait_for_figure(page, ".answer .clip-canvas")


def test_damaged_data_is_said(new_page, tmp_path):
    path = tmp_path / "broken.html"
    html = (
        (_BUNDLE / "index.html")
        .read_text()
        .replace(
            '<script type="module" src="app.js"></script>',
            '<script type="application/json" id="motiondb-data">{"format": 9}</script>'
            f'<script defer src="{(_BUNDLE / "file.js").as_uri()}"></script>',
        )
    )
    path.write_text(html)
    page = new_page(path.as_uri())
    page.get_by_role("heading", name="This file cannot be shown").wait_for()


def test_several_characters_and_their_actions_play_together(asked_server, new_page, open_file):
    names = ("ana/walk_1", "boris/walk_1", "fatou/kick_1")
    items = [{"ref": f"capture:{name}"} for name in names]
    request = new_page("about:blank").request
    motions = request.post(f"{asked_server}api/motions", data={"items": items}).body()
    actions = {name: [{"terminal": "walk", "start": 0.0, "end": 2.0}] for name in names}
    answer = {"ref": "scene:x", "text": 'diagram "x"', "actions": actions}
    page, _ = open_file(StandalonePage("scene", "x", "x.duckdb", answer, {"scene:x": motions}))
    wait_for_figure(page)
    assert page.locator(".lane-name").all_inner_texts() == list(names)


def _plays(page) -> None:
    """Play, and wait until another time is shown."""
    wait_for_figure(page)
    time = "() => document.querySelector('.player-time').textContent"
    before = page.evaluate(time)
    page.get_by_role("button", name="Play (Space)").click()
    wait_for(page, f"before => ({time})() !== before", before)


def test_a_sequence_that_grammar_generate_writes_opens_and_plays(
    grammar_database, command, new_page, tmp_path
):
    options = ("--like", "a b c d b e", "--html", "new.html", "--db", grammar_database)
    ended = command("grammar", "generate", "play", "-o", "new.bvh", *options)
    assert ended.code == 0, ended.err
    page = new_page((tmp_path / "new.html").as_uri())
    _plays(page)
    labels = page.locator(".lane-symbols .block").all_inner_texts()
    assert [label.split()[0] for label in labels] == ["a", "b", "c", "d", "b", "e"]
    assert page.locator(".plan-path polyline").count() == 6
    page.get_by_text("chidi/long_play_1").first.wait_for()
    page.get_by_text("licence CC0-1.0").first.wait_for()


def test_a_scene_that_scene_make_writes_opens_and_plays(
    learned_database, command, new_page, tmp_path
):
    (tmp_path / "walk.tactics").write_text(
        'diagram "A walk"\ngrammar basketball\ncourt half\n\nattack A1 at 0 8\n1 walk A1 to 0 6\n'
    )
    options = ("--rounds", 5, "--no-pictures", "--html", "walk.html", "--db", learned_database)
    ended = command("scene", "make", "walk.tactics", "-o", "scene", *options)
    assert ended.code == 0, ended.err
    page = new_page((tmp_path / "walk.html").as_uri())
    _plays(page)
    assert page.locator(".lane-name").all_inner_texts() == ["A1"]
    assert "walk" in page.locator(".lane .block").first.inner_text()
    page.get_by_text("The diagram as text").click()
    assert "1 walk A1 to 0 6" in page.locator("pre").inner_text()
