"""Search, like, describe, the symbol space, and what is generated."""

from __future__ import annotations

import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest
from page_serving import Serve, get, post, refused
from starlette.testclient import TestClient

import motiondb
from motiondb.database.curating import Gathered
from motiondb.page.motion import read_tracks
from motiondb.page.routes import asking


def test_search_gives_what_the_class_gives(client: TestClient, learned_file: Path) -> None:
    """The route's answer holds all that ``--json`` prints, and more about each match."""
    facts = get(client, "/api/search", q="walk but not run", limit=5)
    with motiondb.open(learned_file, read_only=True) as db:
        printed = motiondb.to_json(motiondb.search_answer(db.search("walk but not run", limit=5)))
    for match, same in zip(facts["matches"], printed["matches"], strict=True):
        assert {key: match[key] for key in same} == same
    assert {key: facts[key] for key in printed} == printed | {"matches": facts["matches"]}


def test_every_match_has_the_timeline_of_its_take(client: TestClient) -> None:
    for match in get(client, "/api/search", q="kick", limit=5)["matches"]:
        segments = match["timeline"]["segments"]
        assert segments[0]["start"] == 0.0
        for one, following in pairwise(segments):
            assert one["end"] == following["start"]
        assert match["end"] <= match["duration"]


def test_a_wrong_ref_is_told(client: TestClient) -> None:
    assert "expected one of capture:NAME" in refused(client, "/api/like", 400, ref="walk")
    refused(client, "/api/like", 404, ref="made:m0")
    refused(client, "/api/like", 400, ref="scene:s0")


def test_symbols_have_a_place_and_their_segments(client: TestClient) -> None:
    space = get(client, "/api/symbols")
    assert all(len(s["at"]) == space["dimensions"] for s in space["symbols"])
    first = space["symbols"][0]
    facts = get(client, "/api/symbol", symbol=0, limit=1000)
    assert facts["total"] == first["count"] == len(facts["segments"])
    likely = [s["log_likelihood"] for s in facts["segments"]]
    assert likely == sorted(likely, reverse=True)
    assert "expected 0 to" in refused(client, "/api/symbol", 400, symbol=9999)


def test_choices_of_a_few_shares_are_kept(
    few_copy: Path, serve: Serve, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another process writes while one is made, which is then not kept."""
    made, choose, client = [], asking._choice, serve(few_copy)

    def choosing(gathered: Gathered) -> asking.ChoiceReply:
        made.append(gathered.asked.share)
        if len(made) == 5:
            code = "import motiondb, sys; db = motiondb.open(sys.argv[1]); db.remove(['ana/bow_1'])"
            assert subprocess.run([sys.executable, "-c", code, few_copy]).returncode == 0
        return choose(gathered)

    assert "looked at" in refused(client, "/api/choice", 400, share=0.1)
    with motiondb.open(few_copy, wait=10.0) as db:
        db.captures.quality()
    monkeypatch.setattr(asking, "_choice", choosing)
    monkeypatch.setattr(asking, "MOST_CHOICES", 2)
    for share in (0.1, 0.2, 0.1, 0.3, 0.2, 0.1, 0.4, 0.4):
        reply = get(client, "/api/choice", share=share)
        assert 0.0 < reply["choice"]["chosen"] < 2.0 * share * reply["choice"]["seconds"]
    assert made == [0.1, 0.2, 0.3, 0.1, 0.4, 0.4]


def test_variants_have_their_seeds_and_say_what_they_show(client: TestClient) -> None:
    body = {"words": "a person walks then kicks", "seed": 7, "variants": 2}
    facts = post(client, "/api/generate", body)
    assert [v["seed"] for v in facts["variants"]] == [7, 8]
    made = facts["variants"][0]
    assert [(s["words"], s["shown"]) for s in made["shown_actions"]] == [
        (["walk"], True),
        (["kick"], True),
    ]
    assert made["stretches"][0]["start"] == 0.0
    assert made["stretches"][-1]["end"] == pytest.approx(made["seconds"], abs=1e-3)
    assert {s["licence"] for s in made["stretches"]} == {"CC0-1.0"}
    (track,) = read_tracks(client.get("/api/motion", params={"ref": made["ref"]}).content)
    assert len(track.points) / 30.0 == pytest.approx(made["seconds"], abs=1e-3)
    assert get(client, "/api/made", id=made["id"])["variants"] == [made]


def test_a_generated_motion_is_saved_once(learned_copy: Path, serve: Serve) -> None:
    client = serve(learned_copy)
    made = post(client, "/api/generate", {"words": "jump"})["variants"][0]
    body = {"id": made["id"], "name": "new/jump"}
    assert post(client, "/api/made/save", body) == {
        "capture": "new/jump", "ref": "capture:new/jump",
    }  # fmt: skip
    assert client.post("/api/made/save", json=body).status_code == 409
    facts = get(client, "/api/capture", name="new/jump")
    assert facts["kind"] == "generated"
    assert facts["sources"] == made["sources"]
    taken = post(client, "/api/generate", {"words": "jump", "seed": 1})["variants"][0]
    answer = client.post("/api/made/save", json={"id": taken["id"], "name": "new/jump"})
    assert answer.status_code == 400


def test_small_motions_come_in_the_order_asked_for(client: TestClient) -> None:
    asked = ["ana/walk_1", "nobody", "boris/kick_1"]
    tracks = read_tracks(client.get("/api/thumbs", params={"name": asked}).content)
    assert [track.name for track in tracks] == asked
    assert [0 < len(track.points) <= 31 for track in tracks] == [True, False, True]
    assert abs(tracks[0].points[0, 0, [0, 2]]).max() < 0.01


def test_a_part_of_a_motion_says_where_it_begins(client: TestClient) -> None:
    query = {"ref": "capture:ana/long_1", "start": 1.5, "end": 3.0, "fps": 15}
    (track,) = read_tracks(client.get("/api/motion", params=query).content)
    assert (track.start, track.fps) == (pytest.approx(22 * 2 / 30, abs=1e-3), 15.0)
    refused(client, "/api/motion", 400, ref="capture:ana/long_1", start=99, end=100)


def test_downloads_are_files_or_a_zip(client: TestClient, samples_folder: Path) -> None:
    import io
    import zipfile

    source = {"ref": "capture:ana/walk_1", "format": "source"}
    answer = client.get("/api/download", params=source)
    assert answer.content == (samples_folder / "ana" / "walk_1.bvh").read_bytes()
    assert answer.headers["content-disposition"] == 'attachment; filename="ana_walk_1.bvh"'
    items = [{"ref": "capture:ana/walk_1"}, {"ref": "capture:ana/walk_1", "start": 0.5, "end": 1}]
    several = client.post("/api/download", json={"items": items, "format": "glb"})
    with zipfile.ZipFile(io.BytesIO(several.content)) as archive:
        names = ["ana_walk_1.glb", "ana_walk_1_0.50-1.00.glb", "LICENCES.txt"]
        assert archive.namelist() == names
        assert archive.read("ana_walk_1.glb")[:4] == b"glTF"
        assert b'"copyright":"ana/walk_1, licence CC0-1.0"' in archive.read("ana_walk_1.glb")
        assert archive.read("LICENCES.txt") == b"ana/walk_1: licence CC0-1.0\n"
    made = post(client, "/api/generate", {"words": "jump"})["variants"][0]
    only = {"items": [{"ref": made["ref"]}], "alone": True}
    alone = client.post("/api/download", json=only)
    assert alone.headers["content-disposition"] == 'attachment; filename="jump.bvh"'
    assert alone.content.startswith(b"HIERARCHY")
    again = client.post("/api/download", json=only | {"format": "glb"})
    for source in made["sources"]:
        assert f"{source['capture']}, licence CC0-1.0".encode() in again.content
    both = client.post("/api/download", json={"items": [{"ref": made["ref"]}, *items[:1]]})
    said = both.headers["content-disposition"]
    assert said == 'attachment; filename="jump-and-1-more.zip"'
    with zipfile.ZipFile(io.BytesIO(both.content)) as archive:
        assert "jump.bvh.provenance.json" in archive.namelist()
    twice = client.post("/api/download", json={"items": [{"ref": made["ref"]}] * 2})
    with zipfile.ZipFile(io.BytesIO(twice.content)) as archive:
        files = ["jump.bvh", "jump-2.bvh"]
        assert archive.namelist() == [*files, *(f"{name}.provenance.json" for name in files)]
