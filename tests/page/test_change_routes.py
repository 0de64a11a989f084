"""Changes of several captures at once, and their undo."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

from page_serving import Serve

from motiondb.database import MotionDB

NAMES = ["ana/bow_1", "ana/jump_1"]


def test_several_captures_are_changed_and_each_change_is_undone(
    few_copy: Path, serve: Serve
) -> None:
    client = serve(few_copy)

    def facts(name: str) -> dict:
        answer = client.get("/api/capture", params={"name": name, "described": False})
        kept = ("name", "tags", "words")  # its segments are found anew when it comes back
        found = answer.json() if answer.status_code == 200 else {}
        return {key: found[key] for key in kept if found}

    def change(path: str, **body: object) -> dict:
        answer = client.post(f"/api/captures/{path}", json=body)
        assert answer.status_code == 200, answer.text
        return answer.json()

    before = {name: facts(name) for name in NAMES}
    tags = {"performer": "bea", "licence": "CC-BY-4.0"}
    assert change("tags", captures=NAMES, tags=tags) == {"changed": NAMES, "undo": 1}
    assert change("tags", captures=NAMES, tags=tags) == {"changed": [], "undo": 1}
    assert facts("ana/bow_1")["tags"]["performer"] == "bea"
    assert change("words", captures=NAMES, words="a test of words")["undo"] == 2
    again = {"captures": NAMES, "words": "a test of words"}
    assert change("words", **again) == {"changed": [], "undo": 2}
    assert "a test of words" in [caption["words"] for caption in facts("ana/jump_1")["words"]]
    renamed = change("rename", old="ana/*_1", new="bea/*_1", captures=NAMES)["changed"]
    assert renamed == NAMES
    assert facts("bea/bow_1")
    assert change("remove", captures=["bea/jump_1", "bea/bow_1"])["undo"] == 4
    assert facts("ana/jump_1") == {}
    undone = [client.post("/api/undo", json={}).json() for _ in range(4)]
    assert [one["what"] for one in undone] == ["removal", "name", "words", "tags"]
    assert [one["captures"] for one in undone] == [2, 2, 2, 2]
    assert {name: facts(name) for name in NAMES} == before
    assert client.post("/api/undo", json={}).status_code == 409
    missing = client.post("/api/captures/remove", json={"captures": ["ana/bow_1", "no/such"]})
    assert missing.status_code == 404
    assert facts("ana/bow_1")
    refused = serve(few_copy, read_only=True)
    assert refused.post("/api/captures/remove", json={"captures": NAMES}).status_code == 403


def test_words_of_several_captures_are_one_run_and_undone_together_or_not_at_all(
    few_copy: Path, serve: Serve
) -> None:
    client = serve(few_copy)

    def words(name: str) -> list[str]:
        found = client.get("/api/capture", params={"name": name, "described": False}).json()
        return [caption["words"] for caption in found["words"]]

    new = {"words": "a test of words"}
    one = client.post("/api/captures/words", json={"captures": NAMES[:1], **new}).json()
    assert one == {"changed": NAMES[:1], "undo": 1}
    two = client.post("/api/captures/words", json={"captures": NAMES, **new}).json()
    assert two == {"changed": NAMES[1:], "undo": 2}  # the first has it already
    more = {"captures": NAMES, "words": "more words"}
    assert client.post("/api/captures/words", json=more).json() == {"changed": NAMES, "undo": 3}
    with MotionDB(few_copy, wait=30.0) as db:
        newest = max(db.runs(), key=lambda run: int(run["run_id"]))
        assert newest["kind"] == "words"
        assert "more words" in [caption.words for caption in db.words.captions(NAMES[0])]
        db.words.set_captions(NAMES[0], [])  # another program changes one of them
    refused = client.post("/api/undo", json={})
    assert refused.status_code == 409
    assert "more words" in words(NAMES[1])
    assert client.get("/api/undo").json()["left"] == 2


def test_a_selection_is_made_shown_packed_and_taken_back(few_copy: Path, serve: Serve) -> None:
    client = serve(few_copy)

    def change(verb: str, *items: dict) -> dict:
        answer = client.post(f"/api/selection/{verb}", json={"name": "day 2", "items": list(items)})
        assert answer.status_code == 200, answer.text
        return answer.json()

    whole, part = {"ref": "capture:ana/bow_1"}, {"ref": "capture:ana/jump_1", "start": 0, "end": 1}
    assert change("add", whole, part) == {"changed": NAMES, "undo": 1}
    assert change("add", whole) == {"changed": [], "undo": 1}
    assert client.get("/api/selections").json()["selections"][0]["parts"] == 2
    parts = client.get("/api/selection", params={"name": "day 2"}).json()["parts"]
    assert [(p["ref"], p["whole"], p["end"]) for p in parts[1:]] == [(part["ref"], False, 1.0)]
    pack = client.get("/api/selection/pack", params={"name": "day 2", "format": "glb"})
    assert "day_2.zip" in pack.headers["content-disposition"]
    with zipfile.ZipFile(io.BytesIO(pack.content)) as archive:
        assert sorted(archive.namelist()) == [
            "00001_ana-bow_1.glb", "00002_ana-jump_1.glb", "manifest.csv", "manifest.json",
        ]  # fmt: skip
    assert change("take", part)["changed"] == NAMES[1:]
    assert client.delete("/api/selection", params={"name": "day 2"}).json()["changed"] == NAMES[:1]
    undone = client.post("/api/undo", json={}).json()
    assert (undone["what"], undone["captures"]) == ("selection", 1)
    assert client.get("/api/captures", params={"where": "selection='day 2'"}).json()["total"] == 1
    made = client.post(
        "/api/selection/add", json={"name": "day 2", "items": [{"ref": "made:m1"}]}
    ).json()
    assert "expected a stored capture" in made["error"]["message"]
