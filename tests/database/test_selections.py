"""Selections: parts of captures under a name, kept, filtered by, taken back, and written."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import motiondb
from motiondb import MotionDB, QueryError
from motiondb.records import Match
from motiondb.store import MARKS, read_selections, write_selections

TIMES = st.integers(0, 10**6).map(lambda n: n / 1000)
PARTS = st.tuples(TIMES, TIMES).filter(lambda part: part[0] < part[1])
SPANS = st.frozensets(st.none() | PARTS, min_size=1, max_size=4)
NAMES = st.text(
    st.characters(exclude_characters=MARKS, exclude_categories=("C", "Z")), min_size=1, max_size=8
)


@given(st.dictionaries(NAMES, SPANS, max_size=4))
def test_the_value_of_the_tag_is_read_as_it_was_written(
    selections: dict[str, frozenset[tuple[float, float] | None]],
) -> None:
    assert read_selections(write_selections(selections)) == selections


@given(st.text(max_size=30))
def test_any_value_that_people_wrote_is_read(value: str) -> None:
    found = read_selections(value)
    assert all(name and spans for name, spans in found.items())


def names(db: MotionDB, where: str) -> list[str]:
    return [info.name for info in db.captures(where)]


def test_parts_are_kept_taken_and_taken_back(base: MotionDB) -> None:
    match = Match(1, "boris/kick_1", 0.5, 1.25, 1.0)
    assert base.selections.add("fight day 2", ["ana/jump_1:0-1", match]) == [
        "ana/jump_1", "boris/kick_1",
    ]  # fmt: skip
    assert base.selections.add("fight day 2", [("ana/jump_1", 0.0, 1.0)]) == []  # it has it
    base.selections.add("warm up", ["ana/jump_1"], where="name~bow")
    told = [(row.selection, row.captures, row.parts) for row in base.selections()]
    assert told == [("fight day 2", 2, 2), ("warm up", 2, 2)]
    assert base.selections()[0].seconds == pytest.approx(1.75)
    parts = [(p.capture, p.start, p.end, p.whole) for p in base.selections.show("fight day 2")]
    assert parts == [("ana/jump_1", 0.0, 1.0, False), ("boris/kick_1", 0.5, 1.25, False)]
    assert names(base, "selection = 'fight day 2'") == ["ana/jump_1", "boris/kick_1"]
    assert names(base, "selection in (x, 'warm up') and not selection ~ fight") == ["ana/bow_1"]
    facet = next(f for f in base.captures.facets() if f.column == "selection")
    assert facet.values == (("fight day 2", 2), ("warm up", 2))
    base.selections.take("fight day 2", [("ana/jump_1", 0.0, 1.0)])
    assert names(base, "selection = 'fight day 2'") == ["boris/kick_1"]
    base.undo()
    assert names(base, "selection = 'fight day 2'") == ["ana/jump_1", "boris/kick_1"]
    base.captures.remove(["boris/kick_1"])
    base.undo()  # with its selection
    assert base.selections.remove("fight day 2") == ["ana/jump_1", "boris/kick_1"]
    assert names(base, "selection = 'fight day 2'") == []
    assert [row.selection for row in base.selections()] == ["warm up"]
    base.undo()
    assert len(base.selections.show("fight day 2")) == 2
    (info,) = base.captures("name=boris/kick_1")
    base.selections.add("fight day 2", [("boris/kick_1", 0.0, info.duration)])
    assert base.selections.show("fight day 2")[1].whole
    base.selections.take("fight day 2", [("boris/kick_1", 0.0, info.duration)])  # this one alone
    assert [part.start for part in base.selections.show("fight day 2")] == [0.0, 0.5]
    assert base.check() == []


def test_captures_of_a_filter_are_whole_beside_parts_of_them(base: MotionDB) -> None:
    base.selections.add(" a ", [("ana/jump_1", -0.0001, 1.0)], where="name=ana/jump_1")
    assert [part.end for part in base.selections.show("a ") if not part.whole] == [1.0]
    assert len(base.selections.show("a")) == 2
    base.selections.take(" a", ["ana/jump_1:1-2"], where="name=ana/jump_1")
    assert base.selections() == []


def test_a_selection_is_another_files_when_it_is_opened_again(tmp_path: Path, some: Path) -> None:
    with motiondb.open(tmp_path / "motions.duckdb") as db:
        db.add(some)
        db.selections.add("kept", where="name~jump")
        db.words.export(tmp_path / "sheet.tsv")
    with motiondb.open(tmp_path / "motions.duckdb", read_only=True) as db:
        assert [part.capture for part in db.selections.show("kept")] == names(db, "name~jump")
    with motiondb.open(tmp_path / "other.duckdb") as db:  # a sheet holds selections, too
        db.add(some, words=tmp_path / "sheet.tsv")
        assert [part.capture for part in db.selections.show("kept")] == names(db, "name~jump")


def test_a_merge_joins_selections(base: MotionDB, tmp_path: Path, some: Path) -> None:
    base.selections.add("a", ["ana/jump_1:0-1"])
    with motiondb.open(tmp_path / "other.duckdb") as other:
        other.add(some)
        other.selections.add("a", ["ana/jump_1:1-1.5", "boris/kick_1"])
        other.selections.add("b", ["ana/jump_1"])
    base.merge(tmp_path / "other.duckdb")
    assert [(part.capture, part.start) for part in base.selections.show("a")] == [
        ("ana/jump_1", 0.0), ("ana/jump_1", 1.0), ("boris/kick_1", 0.0),
    ]  # fmt: skip
    assert base.selections.show("b")[0].whole


def test_what_is_no_selection_is_refused(base: MotionDB) -> None:
    with pytest.raises(QueryError, match="expected a name of a selection"):
        base.selections.add("a; b", ["ana/jump_1"])
    with pytest.raises(QueryError, match=r"ana/jump_1: expected an interval within 0 to"):
        base.selections.add("a", ["ana/jump_1:1-900"])
    behind = base.captures("name=ana/jump_1")[0].duration + 0.1
    with pytest.raises(QueryError, match=r"ana/jump_1: expected an interval within 0 to"):
        base.selections.add("a", [("ana/jump_1", behind, behind + 0.2)])  # an end has half a second
    assert read_selections("a [2-1]") == {"a [2-1]": frozenset({None})}
    base.selections.add("fights", ["ana/jump_1"])
    with pytest.raises(QueryError, match="Did you mean fights"):
        base.selections.show("fight")


def test_a_pack_has_a_manifest_with_interval_licence_and_source(
    base: MotionDB, tmp_path: Path
) -> None:
    base.captures.set_tags({"licence": "CC0-1.0", "performer": "ana"}, where="name~ana")
    base.selections.add("pack", ["ana/jump_1:0.5-1.5", "boris/kick_1"])
    done = base.selections.export("pack", tmp_path / "pack")
    assert (done.motions, done.licences) == (2, ("CC0-1.0", "unknown"))
    rows = list(csv.DictReader((tmp_path / "pack" / "manifest.csv").read_text().splitlines()))
    assert [row["file"] for row in rows] == ["00001_ana-jump_1.bvh", "00002_boris-kick_1.bvh"]
    assert (rows[0]["start"], rows[0]["end"], rows[0]["licence"]) == ("0.5", "1.5", "CC0-1.0")
    (info,) = base.captures("name=ana/jump_1")
    assert rows[0]["sha256"] == info.sha256
    told = json.loads((tmp_path / "pack" / "manifest.json").read_text())
    assert [each["capture"] for each in told["intervals"]] == ["ana/jump_1", "boris/kick_1"]
    cut, whole = (motiondb.read_capture(tmp_path / "pack" / row["file"]) for row in rows)
    assert cut.duration == pytest.approx(1.0, abs=2 / cut.fps)
    assert whole.n_frames == base.clip("boris/kick_1").n_frames
    with pytest.raises(QueryError, match="expected a new or an empty folder"):
        base.selections.export("pack", tmp_path / "pack")
