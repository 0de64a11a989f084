"""What the commands print: the promised JSON, tables, notes, and exit codes."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import motiondb
from motiondb import store
from motiondb.learn.checking import NO_EXAMPLES_CHECKED
from motiondb.learn.learned_model import from_stored, to_stored


def answer(ended: Any) -> Any:
    assert ended.code == 0, ended.err
    return json.loads(ended.out)


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
            assert 0.0 <= match["probability"] <= 1.0
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
    facts = answer(command("info", "--json"))
    assert (facts["captures"], facts["learned"], facts["not_yet_learned"]) == (101, True, 0)
    assert [run["kind"] for run in facts["runs"]] == ["add", "learn"]
    assert answer(command("check", "--json")) == {"faults": []}
    symbols = answer(command("symbols", "--json"))
    assert {s["symbol"] for s in symbols} == set(range(facts["symbols"]))
    assert sum(s["count"] for s in symbols) > 300
    words = answer(command("words", "--json"))
    assert len(words) == facts["words"]
    assert {"word", "count", "symbols"} == set(words[0])


def test_tables_for_people(command: Any, learned_file: Path) -> None:
    for words in (
        ("search", "walk, turn left, sit down"),
        ("search", "walk", "--by-symbols"),
        ("like", "ana/bow_1"),
        ("describe", "ana/bow_1"),
        ("list",),
        ("show", "ana/bow_1"),
        ("words",),
        ("symbols",),
        ("info",),
        ("check",),
    ):
        ended = command(*words, "--db", learned_file)
        assert (ended.code, ended.err) == (0, "")
        assert ended.out.strip()
    assert f"{learned_file} is sound" in ended.out


def test_pictures(command: Any, learned_file: Path) -> None:
    for name, words in {
        "a.png": ("show", "ana/bow_1"),
        "b.png": ("symbols",),
        "c.png": ("search", "bow", "--limit", 2),
        "d.png": ("like", "ana/bow_1", "--limit", 2),
    }.items():
        ended = command(*words, "--png", name, "--db", learned_file)
        assert ended.code == 0, ended.err
        assert Path(name).read_bytes()[:4] == b"\x89PNG"


def test_an_unknown_word_is_named_with_the_nearest(command: Any, learned_file: Path) -> None:
    ended = command("search", "wlak, kick", "--limit", 1, "--json", "--db", learned_file)
    assert ended.err == "unknown word 'wlak' left out; the nearest known: walk\n"
    assert answer(ended)["matches"][0]["words"] == ["kick"]
    ended = command("search", "xyzzy", "--db", learned_file)
    assert (ended.code, ended.out) == (2, "")
    assert ended.err == (
        "error: query: expected a known word, found 'xyzzy'. "
        "`motiondb words` lists the words that are known.\n"
    )


def test_generate_writes_motion_and_origin(command: Any, learned_copy: Path) -> None:
    sentence = ("generate", "a person walks then kicks", "--seed", 7, "--db", learned_copy)
    one = answer(command(*sentence, "-o", "one.bvh", "--save", "made/one", "--json"))
    two = answer(command(*sentence, "-o", "two.bvh", "--json"))
    assert Path("one.bvh").read_bytes() == Path("two.bvh").read_bytes()
    assert (one["output"], one["capture"]) == ("one.bvh", "made/one")
    assert one["symbols"] == two["symbols"]
    origin = json.loads(Path(one["provenance"]).read_text())
    assert origin["frames"][0]["start"] == 0
    assert origin["frames"][-1]["end"] == round(one["seconds"] * 30)
    shown = command("show", "made/one", "--db", learned_copy).out
    assert "kind:         generated" in shown
    assert "licence CC0-1.0" in shown
    ended = command(*sentence, "-o", "three.bvh", "--save", "made/one")
    assert ended.code == 2
    assert "made/one: expected a name that is free" in ended.err
    assert not Path("three.bvh").exists()
    ended = command(*sentence, "-o", "picture.glb", "--method", "trajectory", "--png", "p.png")
    missing = "not shown" in ended.out or "not confirmed" in ended.out
    assert ended.code == int(missing), ended.err
    assert Path("picture.glb").read_bytes()[:4] == b"glTF"
    assert Path("p.png").exists()
    assert answer(command("check", "--json", "--db", learned_copy)) == {"faults": []}


def test_what_is_added_after_learning_is_found(
    command: Any, learned_copy: Path, some: Path
) -> None:
    with (some / "boris/kick_1.bvh").open("a") as file:
        file.write("\n")
    assert command("add", some / "boris", "--db", learned_copy).code == 0
    left_out = answer(command("info", "--json", "--db", learned_copy))["not_yet_learned"]
    ended = command("like", "boris/kick_1", "--limit", 2, "--json", "--db", learned_copy)
    assert bool(ended.err) == bool(left_out)
    if not left_out:
        assert {m["capture"] for m in answer(ended)["matches"]} == {"boris/kick_1", "kick_1"}


@pytest.mark.parametrize(("count", "what"), [(1, "1 capture is"), (7, "7 captures are")])
def test_what_answers_leave_out_is_said(
    command: Any, learned_file: Path, monkeypatch: pytest.MonkeyPatch, count: int, what: str
) -> None:
    monkeypatch.setattr("motiondb.database.MotionDB.unlearned", lambda _: ["x"] * count)
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
    assert "1 already there, 1 problems; 4 captures in motions.duckdb." in ended.out
    assert "  bow again is the same file as ana/bow_1" in ended.out
    assert f"  {some}/broken.bvh" in ended.err
    assert all(line.startswith("  ") for line in ended.err.splitlines() if "broken" in line)
    report = json.loads(command("add", some, "--json").out)
    assert report["added"] == []
    assert report["captures"] == 4
    assert len(report["known"]) == 5
    assert answer(command("export", "ana/bow_1", "-o", "b.bvh", "--json"))["output"] == "b.bvh"
    assert Path("b.bvh").read_bytes() == (samples_folder / "ana/bow_1.bvh").read_bytes()
    assert answer(command("remove", "ana/bow_1", "--json")) == {"removed": ["ana/bow_1"]}
    sizes = answer(command("compact", "--json"))
    assert sizes["after"] <= sizes["before"]
    assert command("check").out == "motions.duckdb is sound\n"
    assert len(answer(command("list", "--json"))) == 3


def test_duplicates_are_listed_in_groups(command: Any, some: Path) -> None:
    command("add", some)
    for name, source in (("again", "boris/kick_1"), ("once more", "boris/kick_1")):
        text = (some / f"{source}.bvh").read_text()
        (some / f"{name}.bvh").write_text(text + "\n" * len(name))
    command("add", some)
    groups = answer(command("list", "--duplicates", "--json"))
    assert [group["captures"] for group in groups] == [["boris/kick_1", "again", "once more"]]
    assert {r["kind"] for r in groups[0]["relations"]} == {"same"}
    told = command("list", "--duplicates").out
    assert "1 groups, 2 captures repeat others" in told
    assert "is the same motion as boris/kick_1 (0.00-" in told
    assert answer(command("list", "--duplicates", "--where", "name=ana/bow_1", "--json")) == []


def test_words_are_set_imported_and_synonyms_kept(command: Any, some: Path) -> None:
    command("add", some)
    said = answer(command("words", "set", "ana/bow_1", "she bows", "--json"))
    assert (said["capture"], said["words"]) == ("ana/bow_1", ["she bows"])
    kept = answer(command("words", "set", "ana/bow_1", "deeply", "--from", 1, "--keep", "--json"))
    assert kept["words"] == ["she bows", "deeply"]
    Path("s.tsv").write_text("file\twords\tmood\nboris/kick_1\the boots\tcross\nghost\tflies\t\n")
    ended = command("words", "import", "s.tsv")
    assert ended.code == 1
    assert ended.out == (
        "1 captures have the sheet's words and tags now, 1 rows without a capture\n"
    )
    assert ended.err == (
        "  s.tsv:3: expected a capture of the added folder, found 'ghost'. "
        "Correct the file column.\n"
    )
    assert [c["name"] for c in answer(command("list", "--where", "mood=cross", "--json"))] == [
        "boris/kick_1"
    ]
    Path("synonyms").write_text("boot = kick\n")
    assert answer(command("words", "synonyms", "synonyms", "--json")) == {"boot": "kick"}
    assert command("learn").code == 0
    assert {w["word"] for w in answer(command("words", "--json"))} >= {"kick", "bow"}
    first = answer(command("search", "boot", "--limit", 1, "--json"))["matches"][0]
    assert first["capture"] == "boris/kick_1"
    assert command("words", "synonyms", "nothing").err == (
        "error: nothing: expected a readable file of synonyms, found: No such file or directory.\n"
    )


def test_nothing_matches_is_said_above_the_nearest(command: Any, learned_file: Path) -> None:
    where = ("--where", "name=ana/bow_1", "--db", learned_file)
    ended = command("search", "kick", *where)
    assert (ended.code, ended.err) == (0, "")
    understood, *told = ended.out.splitlines()
    assert understood == "understood: kick"
    assert told[0] == "nothing in this database matches; the nearest:"
    columns = "rank capture start end score probability interval words found"
    assert told[1].split() == columns.split()
    assert answer(command("search", "kick", "--json", *where))["matches_anything"] is False
    ended = command("like", "boris/kick_1", *where)
    assert ended.code == 0
    assert ended.out.startswith("nothing in this database matches; the nearest:\n")
    ended = command("search", "kick", "--where", "name=nobody", "--db", learned_file)
    assert (ended.code, ended.out) == (
        0, "understood: kick\nnothing in this database matches\n",
    )  # fmt: skip


def test_examples_without_probabilities_say_why(command: Any, learned_copy: Path) -> None:
    """The certainty of answers to words was learned, that of answers to examples was not."""
    with motiondb.open(learned_copy) as db, store.transaction(db.store):
        model = from_stored(store.load_learning(db.store))
        certainties = replace(model.certainties, example=None)
        store.save_learning(db.store, to_stored(replace(model, certainties=certainties)))
    asked = ("like", "boris/kick_1", "--limit", 2, "--db", learned_copy)
    ended = command(*asked)
    assert (ended.code, ended.err) == (0, f"note: {NO_EXAMPLES_CHECKED}\n")
    assert [line.split()[5] for line in ended.out.splitlines()] == ["probability", "-", "-"]
    told = answer(command(*asked, "--json"))
    assert told["unchecked"] == NO_EXAMPLES_CHECKED
    assert {m["probability"] for m in told["matches"]} == {None}
    assert command("search", "kick", "--db", learned_copy).err == ""


def test_answers_by_symbols_carry_their_certificate(command: Any, learned_file: Path) -> None:
    asked = ("search", "walk", "--by-symbols", "--limit", 1, "--db", learned_file)
    told = answer(command(*asked, "--json"))["decoding"]
    assert list(told) == [
        "symbols", "log_probability", "nodes_expanded", "certificate", "bound",
    ]  # fmt: skip
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
    assert answer(command("show", "ana/bow_1", "--json", "--db", learned_file))["activities"] == []
    ended = command(
        "show", "ana/long_1", "--gif", "a.gif", "--from", 1, "--to", 2, "--db", learned_file
    )
    assert "picture:      a.gif" in ended.out
    first = next(line for line in ended.out.splitlines() if line.startswith("activity:"))
    assert first.split()[1] == "0"
    assert Path("a.gif").read_bytes()[:6] == b"GIF89a"


def test_names_that_are_none_are_refused(command: Any, learned_copy: Path) -> None:
    ended = command("show", "ana/bow_1", "--png", "p.xyz", "--db", learned_copy)
    assert (ended.code, ended.out) == (2, "")
    assert ended.err == (
        "error: p.xyz: expected a name that ends in .png, found '.xyz'. Pictures are written as "
        "PNG.\n"
    )
    ended = command("generate", "walk", "-o", "w.bvh", "--save", "", "--db", learned_copy)
    assert ended.code == 2
    assert ended.err.endswith(
        "error: name: expected a name for the capture, found nothing. Give one.\n"
    )
    assert not Path("w.bvh").exists()
    ended = command("describe", "nix.bvh", "--db", learned_copy)
    assert ended.code == 2
    assert ended.err.startswith(
        "error: 'nix.bvh': expected a file or the name of a capture, found no"
    )
