"""The same page as one file: answers and motions inside it, and no request."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from urllib.parse import quote

import pytest
from page_tools import wait_for, wait_for_figure

import motiondb
from motiondb import StandalonePage

_BUNDLE = Path(__file__).parents[2] / "motiondb" / "page" / "bundle"


def _file(page, server, kind, answer, parts):
    """One self-contained page, as ``--html`` writes it."""
    motions = {}
    for ref, start, end in parts:
        query = f"ref={quote(ref)}" + (f"&start={start}&end={end}" if end else "")
        body = page.request.get(f"{server}api/motion?{query}").body()
        motions[ref] = base64.b64encode(body).decode()
    data = {
        "format": 1, "kind": kind, "title": "walk, turn left", "version": "0",
        "database": "x.duckdb", "answer": answer, "motions": motions,
    }  # fmt: skip
    text = json.dumps(data).replace("<", "\\u003c")
    script = (_BUNDLE / "app.js").read_text().replace("</script", "<\\/script")
    html = (_BUNDLE / "index.html").read_text()
    html = html.replace(
        '<link rel="stylesheet" href="app.css">',
        f"<style>{(_BUNDLE / 'app.css').read_text()}</style>",
    )
    data_element = f'<script type="application/json" id="motiondb-data">{text}</script>'
    html = html.replace('<script defer src="app.js"></script>', "")
    return html.replace("</body>", f"{data_element}<script>{script}</script></body>")


@pytest.fixture
def open_file(asked_server, new_page, tmp_path):
    """Write a page with an answer, and open it without a server."""

    def opened(kind, answer, parts):
        page = new_page("about:blank")
        path = tmp_path / "answer.html"
        path.write_text(_file(page, asked_server, kind, answer, parts))
        asked = []
        page.on("request", lambda request: asked.append(request.url))
        page.goto(path.as_uri())
        return page, asked

    return opened


def _get(new_page, server, path):
    page = new_page("about:blank")
    return page.request.get(f"{server}{path}").json()


def test_answers_play_without_a_request(asked_server, new_page, open_file):
    answer = _get(new_page, asked_server, "api/search?q=walk,%20turn%20left&limit=3")
    parts = [(m["ref"], max(m["start"] - 1, 0), m["end"] + 1) for m in answer["matches"]]
    page, asked = open_file("search", answer, parts)
    wait_for_figure(page, ".answer .clip-canvas")
    assert page.locator(".answer").count() == 3
    assert page.locator(".question .chip").first.inner_text() == "walk"
    page.get_by_text("Why this answer").first.click()
    assert page.locator(".reasons tbody tr").first.is_visible()
    assert "CC0-1.0" in page.locator(".answer").first.inner_text()
    assert page.locator(".answer a").count() == 0
    assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []


def test_generated_motion_keeps_its_sources(asked_server, new_page, open_file):
    page = new_page("about:blank")
    answer = page.request.post(
        f"{asked_server}api/generate", data={"words": "walk then kick", "seed": 7, "variants": 1}
    ).json()
    page, _ = open_file("generate", answer, [(answer["variants"][0]["ref"], 0, 0)])
    wait_for_figure(page, ".variant .clip-canvas")
    page.get_by_text("Sources and licences").click()
    page.get_by_text("licence CC0-1.0").first.wait_for()
    assert page.get_by_role("button", name="Download as BVH").count() == 0


def test_one_capture_has_its_timeline_and_licence(asked_server, new_page, open_file):
    answer = _get(new_page, asked_server, "api/capture?name=ana/long_1")
    page, _ = open_file("capture", answer, [("capture:ana/long_1", 0, 0)])
    wait_for_figure(page)
    assert page.locator(".lane-symbols .block").count() == len(answer["segments"])
    page.get_by_text("licence CC0-1.0").wait_for()


def test_an_example_plays_above_its_answers(asked_server, new_page, open_file):
    answer = _get(new_page, asked_server, "api/like?ref=capture:fatou/kick_1&limit=2")
    parts = {m["ref"]: (m["ref"], 0, 0) for m in answer["matches"]}
    parts["capture:fatou/kick_1"] = ("capture:fatou/kick_1", 0, 0)
    page, _ = open_file("like", answer, list(parts.values()))
    wait_for_figure(page)
    wait_for_figure(page, ".answer .clip-canvas")


def test_damaged_data_is_said(new_page, tmp_path):
    path = tmp_path / "broken.html"
    html = (
        (_BUNDLE / "index.html")
        .read_text()
        .replace(
            '<script defer src="app.js"></script>',
            '<script type="application/json" id="motiondb-data">{"format": 9}</script>'
            f'<script defer src="{(_BUNDLE / "app.js").as_uri()}"></script>',
        )
    )
    path.write_text(html)
    page = new_page(path.as_uri())
    page.get_by_role("heading", name="This file cannot be shown").wait_for()


def test_several_characters_and_their_actions_play_together(asked_server, new_page, tmp_path):
    page = new_page("about:blank")
    names = ("ana/walk_1", "boris/walk_1", "fatou/kick_1")
    items = [{"ref": f"capture:{name}"} for name in names]
    body = page.request.post(f"{asked_server}api/motions", data={"items": items}).body()
    answer = {
        "ref": "scene:x", "text": 'diagram "x"',
        "actions": {name: [{"terminal": "walk", "start": 0.0, "end": 2.0}] for name in names},
    }  # fmt: skip
    html = _file(page, asked_server, "scene", answer, [])
    path = tmp_path / "scene.html"
    path.write_text(
        html.replace(
            '"motions": {}', f'"motions": {{"scene:x": "{base64.b64encode(body).decode()}"}}'
        )
    )
    page.goto(path.as_uri())
    wait_for_figure(page)
    assert page.locator(".lane").count() == 3
    assert page.locator(".lane-name").all_inner_texts() == list(names)


def test_the_file_that_motiondb_writes_opens(learned_database, new_page, tmp_path):
    with motiondb.open(learned_database, read_only=True) as db:
        path = StandalonePage.of_search(db, db.search("kick", limit=2)).write(tmp_path / "out.html")
    page = new_page(path.as_uri())
    wait_for_figure(page, ".answer .clip-canvas")
    assert page.locator(".answer").count() == 2


def _plays(page) -> None:
    """Play, and wait until another time is shown."""
    wait_for_figure(page)
    time = "() => document.querySelector('.player-time').textContent"
    before = page.evaluate(time)
    page.get_by_role("button", name="Play (Space)").click()
    wait_for(page, f"before => ({time})() !== before", before)


def _requests(page) -> list[str]:
    """The addresses that a page asks for from now on, apart from what it holds itself."""
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    return asked


def test_a_sequence_that_grammar_generate_writes_opens_and_plays(
    grammar_database, command, new_page, tmp_path
):
    options = ("--seed", 3, "--html", "new.html", "--db", grammar_database)
    ended = command("grammar", "generate", "play", "-o", "new.bvh", *options)
    assert ended.code == 0, ended.err
    page = new_page("about:blank")
    asked = _requests(page)
    page.goto((tmp_path / "new.html").as_uri())
    _plays(page)
    labels = page.locator(".lane-symbols .block").all_inner_texts()
    assert [label.split()[0] for label in labels] == ["a", "b", "c", "d", "b", "e"]
    assert page.locator(".plan-path polyline").count() == 6
    page.get_by_text("chidi/long_play_1").first.wait_for()
    page.get_by_text("licence CC0-1.0").first.wait_for()
    assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []


def test_a_scene_that_scene_make_writes_opens_and_plays(
    learned_database, command, new_page, tmp_path
):
    (tmp_path / "walk.tactics").write_text(
        'diagram "A walk"\ngrammar basketball\ncourt half\n\nattack A1 at 0 8\n1 walk A1 to 0 6\n'
    )
    options = ("--rounds", 5, "--no-pictures", "--html", "walk.html", "--db", learned_database)
    ended = command("scene", "make", "walk.tactics", "-o", "scene", *options)
    assert ended.code == 0, ended.err
    page = new_page("about:blank")
    asked = _requests(page)
    page.goto((tmp_path / "walk.html").as_uri())
    _plays(page)
    assert page.locator(".lane-name").all_inner_texts() == ["A1"]
    assert "walk" in page.locator(".lane .block").first.inner_text()
    page.get_by_text("The diagram as text").click()
    assert "1 walk A1 to 0 6" in page.locator("pre").inner_text()
    assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []
