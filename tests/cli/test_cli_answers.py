"""What the commands print: the promised JSON, tables, notes, and exit codes."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest
from command_answers import answer


def test_search_and_like_answer_as_promised(command: Any, learned_file: Path) -> None:
    for words in (("search", "walk, kick"), ("like", "ana/bow_1", "--from", 0.5, "--to", 2)):
        asked = (*words, "--where", "performer=ana", "--limit", 3, "--json", "--db", learned_file)
        told = answer(command(*asked))
        promised = {"matches_anything", "strength", "threshold", "matches"}
        assert promised | ({"question"} if words[0] == "search" else set()) <= set(told)
        assert told["matches_anything"] is (told["strength"] >= told["threshold"])
        actual = told["matches"]
        assert [m["rank"] for m in actual] == [1, 2, 3]
        for match in actual:
            keys = {"rank", "capture", "start", "end", "score", "probability", "words"}
            assert keys | {"interval_probability", "place", "parts"} <= set(match)
            assert match["probability"] is None or 0.0 <= match["probability"] <= 1.0
            assert match["capture"].startswith("ana/")
            assert 0 <= match["start"] < match["end"]
            assert all(isinstance(word, str) for word in match["words"])


def test_describe_answers_as_promised(command: Any, learned_file: Path) -> None:
    for part in answer(command("describe", "ana/bow_1", "--json", "--db", learned_file)):
        assert list(part) == ["start", "end", "words", "symbols"]
        assert all(list(word) == ["word", "probability"] for word in part["words"])


def test_the_environment_names_the_database(
    command: Any, learned_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MOTIONDB", str(learned_file))
    actual = answer(command("list", "--where", "performer=ana", "--limit", 2, "--json"))
    assert [c["tags"]["performer"] for c in actual] == ["ana", "ana"]
    assert actual[0]["words"][0]["words"] == "someone bows politely"
    assert answer(command("info", "--json"))["captures"] == 101
    assert answer(command("check", "--json")) == {"faults": []}
    assert sum(s["count"] for s in answer(command("symbols", "--json"))) > 300
    assert {"word", "count", "symbols"} == set(answer(command("words", "--json"))[0])


def test_tables_for_people(command: Any, learned_file: Path) -> None:
    """What the pages of the guide do not show."""
    for words in (
        ("search", "walk", "--by-symbols"), ("show", "ana/bow_1", "--png", "show.png"),
        ("words",), ("symbols", "--png", "symbols.png"), ("info",),
        ("like", "ana/bow_1", "--limit", 2, "--png", "like.png"),
        ("rhythm", "0 .5 1 1.5", "--words", "walk"),
    ):  # fmt: skip
        ended = command(*words, "--db", learned_file)
        assert (ended.code, ended.err) == (0, "")
        assert ended.out.strip()
    for name in ("show.png", "symbols.png", "like.png"):
        assert Path(name).read_bytes()[:4] == b"\x89PNG"


def test_generate_writes_motion_and_origin(command: Any, learned_copy: Path) -> None:
    sentence = ("generate", "a person walks then kicks", "--seed", 7, "--db", learned_copy)
    one = answer(command(*sentence, "-o", "one.bvh", "--save", "made/one", "--json"))
    assert (one["output"], one["capture"]) == ("one.bvh", "made/one")
    origin = json.loads(Path(one["provenance"]).read_text())
    assert origin["frames"][-1]["end"] == round(one["seconds"] * 30)
    assert "licence CC0-1.0" in command("show", "made/one", "--db", learned_copy).out
    ended = command(*sentence, "-o", "three.bvh", "--save", "made/one")
    assert (ended.code, Path("three.bvh").exists()) == (2, False)
    assert "made/one: expected a name that is free" in ended.err
    ended = command(*sentence, "-o", "picture.glb", "--method", "trajectory", "--png", "p.png")
    missing = "not shown" in ended.out or "not sure" in ended.out
    assert ended.code == int(missing), ended.err
    assert Path("picture.glb").read_bytes()[:4] == b"glTF"
    assert Path("p.png").exists()


@pytest.mark.parametrize(("count", "what"), [(1, "1 capture is"), (7, "7 captures are")])
def test_what_answers_leave_out_is_said(
    command: Any, learned_file: Path, monkeypatch: pytest.MonkeyPatch, count: int, what: str
) -> None:
    monkeypatch.setattr("motiondb.database.captures.Captures.unlearned", lambda _: ["x"] * count)
    for words in (("search", "walk"), ("like", "ana/bow_1")):
        ended = command(*words, "--limit", 1, "--json", "--db", learned_file)
        assert ended.err == f"note: {what} not yet learned: run motiondb learn to include them\n"
        assert len(answer(ended)["matches"]) == 1


def test_add_export_remove_compact(command: Any, some: Path, samples_folder: Path) -> None:
    (some / "broken.bvh").write_text("HIERARCHY\n")
    shutil.copy(some / "ana/bow_1.bvh", some / "bow again.bvh")
    ended = command("add", some)
    assert ended.code == 1
    assert ended.out.startswith("4 captures added (")
    assert "1 already there, 1 problem; 4 captures in motions.duckdb." in ended.out
    assert "  bow again is the same file as ana/bow_1" in ended.out
    assert f"  {some}/broken.bvh" in ended.err
    ended = command("add", some)
    assert (ended.code, ended.err) == (0, "")
    assert f"  known to be faulty, and as before: {some}/broken.bvh" in ended.out
    report = json.loads(command("add", some, "--json").out)
    assert len(report["known_faulty"]) > 0
    assert (report["added"], report["captures"], len(report["known"])) == ([], 4, 5)
    assert answer(command("export", "ana/bow_1", "-o", "b.bvh", "--json"))["output"] == "b.bvh"
    assert answer(command("remove", "ana/bow_1", "--json")) == {"removed": ["ana/bow_1"]}
    sizes = answer(command("compact", "--json"))
    assert sizes["after"] <= sizes["before"]
    assert command("check").out == "motions.duckdb is sound\n"
    assert command("check", "--quick").out.startswith("motions.duckdb: no faults found; motions")


def test_duplicates_are_listed_in_groups(command: Any, some: Path) -> None:
    text = (some / "boris/kick_1.bvh").read_text()
    for name in ("again", "once more"):
        (some / f"boris/{name}.bvh").write_text(text + "\n" * len(name))
    command("add", some / "boris")
    (group,) = answer(command("list", "--duplicates", "--json"))["groups"]
    assert sorted(group["captures"]) == ["again", "kick_1", "once more"]
    told = command("list", "--duplicates").out
    assert "1 group, 2 of the captures repeat others" in told
    assert f"is the same motion as {group['captures'][0]} (0.00-" in told


def test_words_are_set_imported_and_synonyms_kept(command: Any, some: Path) -> None:
    command("add", some)
    command("words", "set", "ana/bow_1", "she bows")
    kept = answer(command("words", "set", "ana/bow_1", "deeply", "--from", 1, "--keep", "--json"))
    assert kept["words"] == ["she bows", "deeply"]
    Path("s.tsv").write_text("file\twords\tmood\nboris/kick_1\the boots\tcross\nghost\tflies\t\n")
    ended = command("words", "import", "s.tsv")
    assert ended.code == 1
    assert ended.out == ("1 capture with the sheet's words and tags now, 1 row without a capture\n")
    assert ended.err.startswith("  s.tsv:3: expected a capture of the added folder")
    Path("synonyms").write_text("boot = kick\n")
    assert answer(command("words", "synonyms", "synonyms", "--json")) == {"boot": "kick"}
    assert command("learn").code == 0
    first = answer(command("search", "boot", "--limit", 1, "--json"))["matches"][0]
    assert first["capture"] == "boris/kick_1"
    assert command("words", "synonyms", "nothing").err == (
        "error: nothing: expected a file of synonyms, found no such file.\n"
    )


def test_nothing_matches_is_said_above_the_nearest(command: Any, learned_file: Path) -> None:
    where = ("--where", "name=ana/bow_1", "--db", learned_file)
    ended = command("search", "kick", *where)
    assert (ended.code, ended.err) == (0, "")
    understood, *told = ended.out.splitlines()
    assert understood == "read as: kick"
    assert told[0] == "nothing in this database matches; the nearest:"
    columns = "rank capture start end score probability interval words found"
    assert told[1].split() == columns.split()
    ended = command("like", "boris/kick_1", *where)
    assert ended.out.startswith("nothing in this database matches; the nearest:\n")
    ended = command("search", "kick", "--where", "name=nobody", "--db", learned_file)
    assert ended.out == "read as: kick\nnothing in this database matches\n"


def test_answers_by_symbols_carry_their_certificate(command: Any, learned_file: Path) -> None:
    asked = ("search", "walk", "--by-symbols", "--limit", 1, "--db", learned_file)
    told = answer(command(*asked, "--json"))["decoding"]
    assert told["certificate"] == "optimal"
    assert told["log_probability"] == pytest.approx(told["bound"])
    ended = command(*asked, "--explain")
    assert ended.code == 2
    assert ended.err.startswith("error: search: expected --explain or --by-symbols, found both.")


def test_like_by_words_and_by_motion_alone(command: Any, learned_file: Path) -> None:
    asked = ("like", "boris/kick_1", "--limit", 5, "--json", "--db", learned_file)
    plain, words, motion = (
        answer(command(*asked, *flag)) for flag in ((), ("--meaning",), ("--by-motion-alone",))
    )
    assert plain == words
    assert [m["score"] for m in motion["matches"]] != [m["score"] for m in words["matches"]]
    assert motion["matches"][0]["capture"] == words["matches"][0]["capture"] == "boris/kick_1"


def test_show_tells_activities_and_plays(command: Any, learned_file: Path) -> None:
    facts = answer(command("show", "ana/long_1", "--json", "--db", learned_file))
    doing = facts["activities"]
    assert len(doing) > 1
    assert [a["start"] for a in doing] == [0.0, *(a["end"] for a in doing[:-1])]
    assert doing[-1]["end"] == pytest.approx(facts["seconds"], abs=0.04)
    assert any("walk" in a["words"] for a in doing)
    part = ("--from", 1, "--to", 2, "--db", learned_file)
    ended = command("show", "ana/long_1", "--gif", "a.gif", *part)
    assert "picture:      a.gif" in ended.out
    assert "\nactivity: " in ended.out
    assert Path("a.gif").read_bytes()[:6] == b"GIF89a"
