"""The catalogue page by page, words and their undo."""

from __future__ import annotations

from pathlib import Path

import pytest
from holding import holding
from page_serving import ADDRESS, Serve, get, post, refused
from starlette.testclient import TestClient

import motiondb
from motiondb import MotionDB
from motiondb.page.app import make_application
from motiondb.page.settings import PageSettings

NAME = "ana/walk_1"


def names(client: TestClient, **query: object) -> list[str]:
    return [row["name"] for row in get(client, "/api/captures", **query)["captures"]]


def test_pages_of_the_catalogue_join_to_the_whole(client: TestClient, learned_file: Path) -> None:
    whole = names(client, limit=1000)
    parts = [
        name for offset in range(0, 110, 20) for name in names(client, offset=offset, limit=20)
    ]
    assert parts == whole
    with motiondb.open(learned_file, read_only=True) as db:
        assert sorted(whole) == sorted(info.name for info in db.captures())


def test_a_filter_is_that_of_the_command_line(client: TestClient, learned_file: Path) -> None:
    where = "performer in (ana, boris) and duration>5"
    with motiondb.open(learned_file, read_only=True) as db:
        expected = sorted(info.name for info in db.captures(where))
    assert sorted(names(client, where=where, limit=1000)) == expected
    assert "Did you mean performer?" in refused(client, "/api/captures", 400, where="perfomer=ana")


def test_facets_count_every_capture_and_their_filters_hold(client: TestClient) -> None:
    facts = get(client, "/api/facets")
    performers = next(f for f in facts["facets"] if f["column"] == "performer")
    assert sum(v["count"] for v in performers["values"]) + performers["missing"] == facts["total"]
    for value in performers["values"][:3]:
        actual = get(client, "/api/captures", where=value["where"], limit=1)
        assert actual["total"] == value["count"]


def test_one_capture_has_what_the_class_knows(client: TestClient, learned_file: Path) -> None:
    facts = get(client, "/api/capture", name="ana/long_1")
    with motiondb.open(learned_file, read_only=True) as db:
        known = db.captures.show("ana/long_1")
        described = db.describe("ana/long_1")
    words = ("word", "word_probability")  # of its symbol
    bare = [{k: v for k, v in one.items() if k not in words} for one in facts["segments"]]
    assert bare == motiondb.to_json(known.segments)
    assert {one["word"] for one in facts["segments"]} != {None}
    assert facts["activities"] == motiondb.to_json(known.activities)
    assert facts["sha256"] == known.sha256
    assert [d["start"] for d in facts["recognised"]] == [d.start for d in described]
    assert facts["tags"]["licence"] == "CC0-1.0"


def test_what_is_not_there_is_named(client: TestClient) -> None:
    message = refused(client, "/api/capture", 404, name="ana/walk")
    assert message == (
        "capture: expected an existing one, found 'ana/walk'. It may have been removed or renamed."
    )


def test_words_are_set_and_undone_in_turn(learned_copy: Path, serve: Serve) -> None:
    client = serve(learned_copy)
    before = get(client, "/api/capture", name=NAME)["words"]
    first = post(client, "/api/words", {"capture": NAME, "words": "stroll", "start": 0, "end": 1})
    assert first["words"] == [*before, {"words": "stroll", "start": 0.0, "end": 1.0}]
    assert first["new_words"] == ["stroll"]
    second = post(client, "/api/words", {"capture": NAME, "words": "a person walks"})
    assert second["words"] == [{"words": "a person walks", "start": None, "end": None}]
    assert post(client, "/api/undo", {}) == {
        "capture": NAME, "words": first["words"], "left": 1, "what": "words", "captures": 1,
    }  # fmt: skip
    assert post(client, "/api/undo", {})["words"] == before
    assert client.post("/api/undo", json={}).status_code == 409
    with motiondb.open(learned_copy, read_only=True) as db:
        assert [c.words for c in db.words.captions(NAME)] == [c["words"] for c in before]


def test_an_edit_that_could_not_be_undone_can_be_undone_later(
    learned_copy: Path, serve: Serve, monkeypatch: pytest.MonkeyPatch
) -> None:
    client = serve(learned_copy)
    before = get(client, "/api/capture", name=NAME)["words"]
    post(client, "/api/words", {"capture": NAME, "words": "walk"})

    def full(*_arguments: object) -> None:
        raise motiondb.StoreError("expected room on the disk, found none")

    with monkeypatch.context() as disk:
        disk.setattr(motiondb.MotionDB, "undo", full)
        assert client.post("/api/undo", json={}).status_code == 400
    assert post(client, "/api/undo", {})["words"] == before


def test_a_database_that_is_held_is_told(learned_copy: Path, serve: Serve) -> None:
    client = serve(learned_copy, wait=0.2)
    with holding(learned_copy) as pid:
        answer = client.get("/api/captures")
    assert answer.status_code == 503
    assert answer.headers["retry-after"] == "1"
    assert f"held by process {pid}" in answer.json()["error"]["message"]
    assert client.get("/api/captures").status_code == 200


def test_a_new_database_is_an_empty_catalogue(tmp_path: Path, serve: Serve) -> None:
    client = serve(tmp_path / "new.duckdb")
    assert get(client, "/api/captures")["total"] == 0
    assert get(client, "/api/status")["learned"] is False
    answer = client.get("/api/search", params={"q": "walk"})
    assert (answer.status_code, answer.json()["error"]["kind"]) == (409, "NotLearnedError")


def test_a_removed_capture_is_gone(learned_copy: Path, serve: Serve) -> None:
    client = serve(learned_copy)
    assert client.delete("/api/capture", params={"name": NAME}).json() == {"removed": [NAME]}
    refused(client, "/api/capture", 404, name=NAME)
    refused(client, "/api/motion", 404, ref=f"capture:{NAME}")


def test_a_folder_whose_name_is_no_text_is_shown(
    learned_file: Path, serve: Serve, tmp_path: Path
) -> None:
    folder = tmp_path / "fold\udcff"
    folder.mkdir()
    client = serve(learned_file, folders=(folder,), read_only=True)
    assert get(client, "/api/status")["folders"] == [{"root": 0, "name": "fold?"}]


def test_a_fault_of_the_program_has_the_form_of_all_errors(
    learned_file: Path, bundle: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_db: MotionDB) -> None:
        raise KeyError("secret")

    monkeypatch.setattr(motiondb.Captures, "duplicates", fail)
    application = make_application(
        PageSettings(learned_file, read_only=True, warm=False), tmp_path, bundle
    )
    with TestClient(application, base_url=ADDRESS, raise_server_exceptions=False) as client:
        answer = client.get("/api/duplicates")
    assert answer.status_code == 500
    assert answer.headers["x-frame-options"] == "DENY"
    assert answer.json()["error"] == {
        "kind": "ProgramError",
        "message": "request: expected an answer, found a fault of the program (KeyError).",
        "status": 500,
    }


def test_words_that_were_changed_meanwhile_are_not_overwritten(
    learned_copy: Path, serve: Serve
) -> None:
    client = serve(learned_copy)
    before = client.get("/api/capture", params={"name": "ana/bow_1"}).json()["words"]
    body = {"capture": "ana/bow_1", "words": [{"words": "a deep curtsy"}], "before": before}
    assert client.put("/api/captions", json=body).status_code == 200
    refused = client.put("/api/captions", json=body | {"words": []})
    assert refused.status_code == 409
    assert refused.json()["error"]["message"] == (
        "ana/bow_1: expected the words that were edited, found others: a deep curtsy. They were "
        "changed meanwhile; nothing is saved."
    )
