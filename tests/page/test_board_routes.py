"""Boards: what is known of a diagram, and the text that it is saved as."""

from __future__ import annotations

from pathlib import Path

import pytest
from page_serving import Serve, get, post, refused
from starlette.testclient import TestClient

from motiondb.database.scenes.scene_texts import (
    TACTICS,
    read_board,
    read_scene_text,
    shipped,
)
from motiondb.scene.language.tactics import Diagram
from motiondb.scene.language.tactics_file import format_diagram, read_diagram

DRILL = """diagram "Drill"
attack A1 at 0 8
attack A2 at 3 6
defence D1 at 0 6.5 guards A1
1 pass A1 to A2
2 cut A1 to 0.6 1.4
3 pass A2 to A1
4 layup A1
"""


def without_lines(diagram: Diagram) -> tuple[object, ...]:
    from dataclasses import replace

    return (
        replace(diagram, players=(), elements=()),
        [replace(player, line=0) for player in diagram.players],
        [replace(element, line=0) for element in diagram.elements],
    )


@pytest.mark.parametrize("name", shipped(TACTICS))
def test_a_shipped_diagram_is_the_same_after_writing_and_reading(name: str) -> None:
    text = read_scene_text(name)
    diagram, activity = text.diagram, text.grammar.activity
    again = read_diagram(format_diagram(diagram), name, activity)
    assert without_lines(again) == without_lines(diagram)
    assert format_diagram(again) == format_diagram(diagram)


def test_a_shipped_diagram_comes_back_from_its_json(client: TestClient) -> None:
    board = get(client, "/api/board", name="give-and-go")
    assert board["feasible"]
    again = post(client, "/api/board/check", {"diagram": board["diagram"]})
    lines = [e.pop("line") for e in [*board["diagram"]["elements"], *again["diagram"]["elements"]]]
    assert all(lines)
    assert again["diagram"] == board["diagram"]
    assert again["players"] == board["players"]


def test_a_diagram_that_can_be_played_has_strings_and_clips(client: TestClient) -> None:
    board = post(client, "/api/board/check", {"text": DRILL})
    assert board["feasible"]
    assert board["holder"] == "A1"
    strings = {player["name"]: player["shortest"] for player in board["players"]}
    assert strings["A1"] == ["hold", "pass", "run", "catch", "layup"]
    assert board["clips"]["pass"] > 0
    assert board["without_clips"] == []


@pytest.mark.parametrize(
    ("before", "after", "element", "said"),
    [
        ("1 pass A1 to A2", "1 pass A1 to D1", 2, "and A2 ('pass A2 to A1', line 7)"),
        ("2 cut A1 to 0.6 1.4", "2 cut A1 to 60 1.4", 1, "a point on the ground"),
        ("3 pass A2 to A1", "3 pass A2 to A9", 2, "one of the players"),
        (
            "1 pass A1 to A2",
            "1 pass A1 to A2 caught 9",
            2,
            "one player with the ball at the beginning",
        ),
    ],
)
def test_an_element_that_cannot_be_played_is_the_one_at_fault(
    client: TestClient, before: str, after: str, element: int, said: str
) -> None:
    board = post(client, "/api/board/check", {"text": DRILL.replace(before, after)})
    assert not board["feasible"]
    wrong = [each["element"] for each in board["elements"] if not each["feasible"]]
    assert element in wrong
    assert said in board["elements"][element]["reason"]


def test_what_a_grammar_does_not_allow_is_told_of_its_player(client: TestClient) -> None:
    text = 'diagram "D"\ndefence D1 at 0 6\nattack A1 at 0 8\n1 shoot A1\n2 feint D1 to 1 6\n'
    assert [(fault.line, fault.player) for fault in read_board(text).faults] == [(5, "D1")]
    board = post(client, "/api/board/check", {"text": text})
    assert [each["feasible"] for each in board["elements"]] == [True, False]
    reasons = {player["name"]: player["reason"] for player in board["players"]}
    assert reasons["A1"] is None
    assert reasons["D1"].startswith("expected of D1 what the grammar basketball allows")


def test_every_grammar_has_the_ground_that_its_diagrams_need(client: TestClient) -> None:
    grounds = {ground["grammar"]: ground for ground in get(client, "/api/board/kinds")["grounds"]}
    assert grounds["carrying"]["places"] == ["origin", "object", "goal"]
    assert grounds["carrying"]["teams"] == ["player"]
    verbs = {verb["name"]: verb for verb in grounds["carrying"]["verbs"]}
    assert [name for name, verb in verbs.items() if verb["declared"]] == ["walk", "carry"]
    assert verbs["walk"]["goes"]
    assert grounds["basketball"]["teams"] == ["attack", "defence"]
    assert grounds["basketball"]["object"] == "ball"
    looks = {verb["name"]: verb["look"] for verb in grounds["basketball"]["verbs"]}
    asked = ("pass", "shoot", "run", "screen", "guard", "feint")
    assert [looks[name] for name in asked] == ["give", "send", "way", "way", "link", "act"]


def test_a_text_that_cannot_be_read_is_an_answer_with_its_line(client: TestClient) -> None:
    board = post(client, "/api/board/check", {"text": DRILL + "5 dunk A1\n"})
    assert (board["diagram"], board["feasible"], board["line"]) == (None, False, 9)
    assert "expected what is done" in board["fault"]


def test_text_and_diagram_exclude_each_other(client: TestClient) -> None:
    assert client.post("/api/board/check", json={}).status_code == 400


@pytest.mark.parametrize(
    "wrong",
    [
        {"title": 'a"\nball A1'},
        {"title": "a" * 201},
        {"ball": "A 1"},
        {"court": {"width": -1.0}},
        {"players": [{"name": "A1", "team": "attack", "at": [0.0, 1001.0]}]},
        {"elements": [{"kind": "shoot", "step": 0, "player": "A1"}]},
    ],
)
def test_a_diagram_outside_the_limits_is_refused(client: TestClient, wrong: object) -> None:
    diagram = {"title": "a", "players": []} | dict(wrong)  # type: ignore[call-overload]
    assert client.post("/api/board/check", json={"diagram": diagram}).status_code == 422


def test_a_text_outside_the_limits_of_requests_is_answered(client: TestClient) -> None:
    text = f'diagram "{"long" * 60}"\nattack A1 at 0 2000\n1 shoot A1\n'
    board = post(client, "/api/board/check", {"text": text})
    assert board["diagram"]["players"][0]["at"] == [0.0, 2000.0]


def test_a_board_is_saved_as_the_file_that_the_command_line_reads(
    tmp_path: Path, serve: Serve
) -> None:
    client = serve(tmp_path / "new.duckdb")
    post(client, "/api/board", {"name": "my-drill", "text": DRILL}, "PUT")
    path = tmp_path / "boards" / "my-drill.tactics"
    assert path.read_text() == DRILL
    assert read_diagram(path.read_text(), str(path)).name == "Drill"
    drawn = [board for board in get(client, "/api/boards")["boards"] if not board["shipped"]]
    assert drawn == [{"name": "my-drill", "title": "Drill", "shipped": False}]
    assert get(client, "/api/board", name="my-drill")["text"] == DRILL
    assert client.delete("/api/board", params={"name": "my-drill"}).status_code == 200
    assert not path.exists()
    refused(client, "/api/board", 404, name="my-drill")


@pytest.mark.parametrize("name", ["../x", "/tmp/x", "con"])
def test_a_name_of_a_board_is_no_path(tmp_path: Path, serve: Serve, name: str) -> None:
    client = serve(tmp_path / "new.duckdb")
    answer = client.put("/api/board", json={"name": name, "text": DRILL})
    assert answer.status_code == 400
    assert "expected a name of letters" in answer.json()["error"]["message"]
    assert not (tmp_path / "boards").exists()


def test_a_shipped_board_is_not_overwritten(tmp_path: Path, serve: Serve) -> None:
    client = serve(tmp_path / "new.duckdb")
    answer = client.put("/api/board", json={"name": "give-and-go", "text": DRILL})
    assert answer.status_code == 409
    assert client.delete("/api/board", params={"name": "give-and-go"}).status_code == 404


def test_a_link_in_the_folder_of_boards_is_not_followed(tmp_path: Path, serve: Serve) -> None:
    client = serve(tmp_path / "new.duckdb")
    folder = tmp_path / "boards"
    folder.mkdir()
    secret = tmp_path / "secret"
    secret.write_text("private")
    (folder / "link.tactics").symlink_to(secret)
    refused(client, "/api/board", 404, name="link")
    assert client.put("/api/board", json={"name": "link", "text": DRILL}).status_code == 400
    assert secret.read_text() == "private"


def test_an_unreadable_scene_does_not_hide_the_others(tmp_path: Path, serve: Serve) -> None:
    client = serve(tmp_path / "new.duckdb")
    folder = client.app.state.page.folder / "scenes" / "s0123456789"  # type: ignore[attr-defined]
    folder.mkdir()
    (folder / "facts.json").write_text("{}")
    assert get(client, "/api/scenes") == {"scenes": []}
