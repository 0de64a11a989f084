"""Many questions, descriptions and answers at once."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import motiondb


def test_questions_of_a_file_are_answered_in_one_process(command: Any, learned_file: Path) -> None:
    Path("lines.txt").write_text("walk\n\n# a remark\nxqzzy\n")
    ended = command("batch", "lines.txt", "--limit", 2, "--db", learned_file)
    rows = list(csv.DictReader(ended.out.splitlines(), delimiter="\t"))
    assert [(row["line"], row["question"], row["rank"]) for row in rows] == [
        ("1", "walk", "1"),
        ("1", "walk", "2"),
    ]
    assert (ended.code, "lines.txt:4: " in ended.err) == (1, True)
    Path("rows.tsv").write_text(
        "question\tlike\tstart\twhere\tlimit\nkick\t\t\tperformer=ana\t1\n"
        "\tana/bow_1\t0.5\t\t3\nkick\tana/bow_1\t\t\t\n"
    )
    ended = command("batch", "rows.tsv", "--json", "--db", learned_file)
    told = [json.loads(line) for line in ended.out.splitlines()]
    assert [len(one.get("matches", ())) for one in told] == [1, 3, 0]
    assert told[0]["matches"][0]["capture"].startswith("ana/")
    assert told[1]["matches"][0]["capture"] == "ana/bow_1"
    assert told[2]["error"].endswith("found both.")
    assert [one.get("question", {}).get("text") for one in told] == ["kick", None, "kick"]
    Path("rows.csv").write_text('question,limit\n"walk, turn left",1\n')
    ended = command("batch", "rows.csv", "--db", learned_file)
    assert (ended.code, ended.out.splitlines()[1].split("\t")[1]) == (0, "walk, turn left")
    Path("quoted.csv").write_text('"question","limit"\n"walk, turn left","1"\n')
    assert command("batch", "quoted.csv", "--db", learned_file).out == ended.out
    Path("odd.csv").write_text("Question;limit\nwalk;1\n")
    ended = command("batch", "odd.csv", "--db", learned_file)
    assert (ended.code, "divided by commas or tabs, found semicolons" in ended.err) == (2, True)
    for header in ("question\tspeed\n", "qestion\tlimit\n", "limit,question,speed\n"):
        Path("odd.tsv").write_text(header)
        ended = command("batch", "odd.tsv", "--db", learned_file)
        assert (ended.code, "odd.tsv:1: expected any of the columns" in ended.err) == (2, True)


def test_rows_that_are_no_questions_are_named(command: Any, learned_file: Path) -> None:
    Path("odd.tsv").write_text('question\tlimit\nkick\t1\tmore\nkick\t1e3\nkick\t-1\n"kick\t1\n')
    ended = command("batch", "odd.tsv", "--db", learned_file)
    assert (ended.code, len(ended.out.splitlines())) == (1, 1)
    assert [line.strip() for line in ended.err.splitlines()] == [
        "odd.tsv:2: expected at most 2 cells, as in the header, found 3.",
        "odd.tsv:3: expected a whole number in the column limit, found '1e3'.",
        "odd.tsv:4: expected a limit of at least 1.",
        'odd.tsv:5: expected quotation marks in pairs, found one alone (").',
    ]
    for text in ("", "question\tlimit\n"):
        Path("empty.tsv").write_text(text)
        ended = command("batch", "empty.tsv", "--db", learned_file)
        assert (ended.code, ended.err) == (
            1, "error: empty.tsv: expected a question in a line, found none. Write some.\n"
        )  # fmt: skip


def test_answers_are_written_with_their_origin(command: Any, learned_file: Path) -> None:
    asked = ("search", "kick", "--limit", 2, "--export", "out", "--db", learned_file)
    for _ in range(2):  # the second time over its own files
        ended = command(*asked)
        assert (ended.code, "licences: CC0-1.0" in ended.err) == (0, True)
    motions = sorted(Path("out").glob("*.bvh"))
    assert len(motions) == 2
    origin = json.loads(Path(f"{motions[0]}.provenance.json").read_text())
    assert (origin["question"], origin["rank"], origin["licence"]) == ("kick", 1, "CC0-1.0")
    clip = motiondb.read_capture(motions[0])
    assert abs(clip.duration - (origin["end"] - origin["start"])) < 0.04
    motions[1].write_text("mine")
    assert command(*asked).code == 2


def test_many_captures_are_described(command: Any, learned_file: Path) -> None:
    asked = ("describe", "--where", "name~ana/bow", "--db", learned_file)
    assert command(*asked, "-o", "words.csv").code == 0
    rows = list(csv.DictReader(Path("words.csv").read_text().splitlines()))
    assert {row["file"] for row in rows} == {"ana/bow_1"}
    assert all(len(r["words"].split()) == len(r["probabilities"].split()) for r in rows)
    assert list(json.loads(command(*asked, "--json").out)) == ["ana/bow_1"]
    assert command("describe", "--db", learned_file).code == 2


def test_the_catalogue_sorted_and_as_csv(command: Any, learned_file: Path) -> None:
    asked = ("list", "--sort", "-duration", "--where", "performer=ana", "--db", learned_file)
    rows = list(csv.DictReader(command(*asked, "--csv").out.splitlines()))
    lengths = [float(row["duration"]) for row in rows]
    assert lengths == sorted(lengths, reverse=True)
    by_head = [*asked[:2], "-Length", *asked[3:]]  # as filters call it
    assert command(*by_head, "--csv").out == command(*asked, "--csv").out
    assert {row["performer"] for row in rows} == {"ana"}
    assert any("someone bows politely" in row["caption"] for row in rows)
    assert command("list", "--sort", "mod", "--db", learned_file).code == 2
    assert command("list", "--faulty", "--json", "--db", learned_file).out == "[]\n"


def test_two_motions_are_compared(command: Any, learned_file: Path) -> None:
    asked = ("compare", "ana/walk_1", "boris/walk_1", "--db", learned_file)
    told = json.loads(command(*asked, "--json").out)
    assert told["alignment"][0] == [0.0, 0.0]
    assert 0.0 < told["distance"] < 0.3
    other = json.loads(command("compare", "ana/walk_1", "ana/bow_1", *asked[3:], "--json").out)
    assert other["distance"] > told["distance"]
    ended = command(*asked, "--png", "both.png")
    assert ended.out.startswith("mean distance of joints: ")
    assert Path("both.png").read_bytes()[:4] == b"\x89PNG"
