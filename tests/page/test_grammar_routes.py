"""Grammars in the page: learn, derive, edit, save."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from page_serving import ADDRESS, get, post, refused
from starlette.testclient import TestClient
from test_job_routes import ended

from motiondb.page.app import make_application
from motiondb.page.settings import PageSettings

CAPTURES = ["fatou/long_play_2", "chidi/long_play_1"]


@pytest.fixture(scope="module")
def editor(tmp_path_factory: pytest.TempPathFactory, learned_file: Path) -> Iterator[TestClient]:
    """A server over a copy of the sample data, with a grammar that it learned."""
    import shutil

    folder = tmp_path_factory.mktemp("editor")
    copy = Path(shutil.copy(learned_file, folder / "motions.duckdb"))
    (folder / "private").mkdir()
    application = make_application(PageSettings(copy, warm=False), folder / "private", folder)
    with TestClient(application, base_url=ADDRESS) as client:
        body = {"captures": CAPTURES, "name": "play", "sentences": "captures", "terminals": 8}
        job = ended(client, post(client, "/api/grammars", body))
        assert job["result"] == {
            "kind": "grammar",
            "grammar": "play",
            "no_longer_editable": [],
        }
        yield client


def test_a_grammar_is_listed_and_shown(editor: TestClient) -> None:
    (row,) = get(editor, "/api/grammars")["grammars"]
    facts = get(editor, "/api/grammar", name="play")
    assert (row["grammar"], row["captures"]) == ("play", 2)
    assert row["seconds"] == pytest.approx(sum(c["seconds"] for c in facts["captures"]), abs=0.01)
    assert row["bits"] == pytest.approx(facts["bits"])
    assert row["derives_new"] == facts["derives_new"]
    assert len(facts["terminals"]) == row["terminals"]
    assert [c["capture"] for c in facts["captures"]] == CAPTURES
    refused(editor, "/api/grammar", 404, name="pla")


def test_a_sequence_is_a_strip_a_path_and_a_tree(editor: TestClient) -> None:
    made = post(editor, "/api/sequences", {"grammar": "play", "seed": 2})
    strip, tree = made["strip"], made["nodes"]
    assert [each["terminal"] for each in strip] == made["string"]
    assert (strip[0]["start"], strip[-1]["end"]) == (0.0, pytest.approx(made["seconds"], abs=0.01))
    leaves = [node for node in tree if node["is_terminal"]]
    assert [leaf["symbol"] for leaf in leaves] == made["string"]
    assert [leaf["start"] for leaf in leaves] == list(range(len(leaves)))
    for number, node in enumerate(tree[1:], start=1):
        above = tree[node["parent"]]
        assert node["parent"] < number
        assert above["start"] <= node["start"] <= node["end"] <= above["end"]
    for each, leaf in zip(strip, leaves):
        assert each["nonterminal"] == tree[leaf["parent"]]["symbol"]
    assert len(made["path"]["points"]) == pytest.approx(made["seconds"] * 10, abs=1)
    assert get(editor, "/api/sequence", id=made["id"]) == made


def test_a_sequence_is_like_a_pattern(editor: TestClient) -> None:
    made = post(editor, "/api/sequences", {"grammar": "play", "seed": 2})
    first, last = made["string"][0], made["string"][-1]
    body = {"grammar": "play", "seed": 5, "like": f"{first} ... {last}"}
    string = post(editor, "/api/sequences", body)["string"]
    assert (string[0], string[-1]) == (first, last)
    for path, wrong in (
        ("/api/sequences", {"grammar": "play", "length": 3, "like": first}),
        ("/api/sequences/alternatives", {"id": made["id"], "at": 9999}),
    ):
        assert editor.post(path, json=wrong).status_code == 400


def test_looking_at_many_alternatives_keeps_the_sequences_of_undo(editor: TestClient) -> None:
    shelf = editor.app.state.page.sequences  # type: ignore[attr-defined]  # an application of ours
    made = post(editor, "/api/sequences", {"grammar": "play", "seed": 2})
    body = {"id": made["id"], "at": 1}
    edited = post(editor, "/api/sequences/alternatives", body)["alternatives"][0]
    for _ in range(3):
        for _ in range(150):
            shelf.put(shelf.get(edited["id"]))
        post(editor, "/api/sequences/alternatives", {"id": edited["id"], "at": 0})
    assert get(editor, "/api/sequence", id=made["id"])["string"] == made["string"]


def test_an_alternative_is_a_sequence_whose_parent_is_the_edited_one(editor: TestClient) -> None:
    made = post(editor, "/api/sequences", {"grammar": "play", "seed": 2})
    body = {"id": made["id"], "at": 1}
    actual = post(editor, "/api/sequences/alternatives", body)
    region = actual["region"]
    assert region["start"] <= 1 < region["end"]
    assert actual["can_widen"] == (len(region["path"]) > 0)
    assert actual["alternatives"]
    for other in actual["alternatives"]:
        assert other["parent"] == made["id"]
        string = made["string"]
        expected = string[: region["start"]] + other["region"] + string[region["end"] :]
        assert other["string"] == expected
        edited = other["edited"]
        assert other["string"][edited["start"] : edited["end"]] == other["region"]
    again = post(editor, "/api/sequences/alternatives", body)
    assert [o["string"] for o in again["alternatives"]] == [
        o["string"] for o in actual["alternatives"]
    ]


def test_a_saved_sequence_is_opened_as_it_was(editor: TestClient) -> None:
    made = post(editor, "/api/sequences", {"grammar": "play", "seed": 4})
    saved = post(editor, "/api/sequences/save", {"id": made["id"], "name": "kept/one"})
    assert saved == {"capture": "kept/one", "ref": "capture:kept/one"}
    opened = post(editor, "/api/sequences/open", {"capture": "kept/one"})
    for key in ("string", "strip", "tree", "nodes", "path", "stretches"):
        assert opened[key] == made[key]
    assert get(editor, "/api/grammar", name="play")["sequences"] == ["kept/one"]
    assert get(editor, "/api/capture", name="kept/one")["grammar"] == "play"
    wrong = editor.post("/api/sequences/open", json={"capture": "ana/walk_1"})
    assert wrong.status_code == 400


def test_a_grammar_is_removed(editor: TestClient) -> None:
    body = {"captures": CAPTURES[:1], "name": "gone", "sentences": "captures", "terminals": 4}
    ended(editor, post(editor, "/api/grammars", body))
    removed = editor.delete("/api/grammar", params={"name": "gone"}).json()
    assert removed == {"removed": "gone", "no_longer_editable": []}
    refused(editor, "/api/grammar", 404, name="gone")
