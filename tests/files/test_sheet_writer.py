"""A sheet that was written is read again without loss."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from motiondb.files.sheet_writer import write_sheet, write_table
from motiondb.files.sheets import read_sheet, tag_fault
from motiondb.records import Caption

_LETTERS = st.characters(exclude_categories=("Cs", "Cc"), exclude_characters="\u2028\u2029")
_TEXT = st.text(_LETTERS, min_size=1, max_size=20).map(str.strip).filter(bool)
_TIMES = st.none() | st.floats(0.0, 1e6, allow_subnormal=False)
_CAPTIONS = st.builds(Caption, _TEXT, _TIMES, _TIMES).filter(
    lambda c: c.start is None or c.end is None or c.start < c.end
)
_KEYS = st.text(_LETTERS.filter(lambda c: c not in ";\t"), min_size=1, max_size=8).filter(
    lambda key: not tag_fault(key)
)
_NAMES = st.sampled_from(["ana/walk_1", "take.bvh", "a b", "x .bvh", "Straße/läuft", "1"])
_ROWS = st.dictionaries(
    _NAMES,
    st.tuples(
        st.lists(_CAPTIONS, max_size=3, unique=True), st.dictionaries(_KEYS, _TEXT, max_size=3)
    ),
)


@pytest.mark.parametrize("ending", ["tsv", "csv"])
@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(rows=_ROWS)
def test_captions_and_tags_come_back(
    tmp_path: Path, ending: str, rows: dict[str, tuple[list[Caption], dict[str, str]]]
) -> None:
    sheet = tmp_path / f"words.{ending}"
    notes = write_sheet(sheet, [(name, *told) for name, told in rows.items()])
    assert [note for note in notes if "like a formula" not in note] == []
    read = read_sheet(sheet)
    assert read.notes == ()
    assert {n: (list(e.captions), e.tags) for n, e in read.entries.items()} == rows


def test_what_a_sheet_cannot_hold_is_told(tmp_path: Path) -> None:
    captions = [Caption(" two\nlines"), Caption("walk"), Caption("walk")]
    notes = write_sheet(tmp_path / "w.csv", [("a", captions, {"x;y": "1", "Start": "2"})])
    assert notes == [
        "the tag 'Start' is left out: a sheet has no such column",
        "the tag 'x;y' is left out: a sheet has no such column",
        "a: 'two lines' is written without its line breaks and outer spaces",
        "a: captions that repeat another, or have no words, are left out",
    ]
    text = (tmp_path / "w.csv").read_text()
    assert text == "file,words,start,end,performer,licence\na,two lines,,,,\na,walk,,,,\n"


def test_formulas_are_counted_where_they_are_read_back_and_become_text_elsewhere(
    tmp_path: Path,
) -> None:
    cells = ["=HYPERLINK(1)", "+2a", "-cmd", "@x", "|calc", "-0.5", "+2", "walk -", "-"]
    captions = [Caption(cell) for cell in cells]
    (note,) = write_sheet(tmp_path / "w.tsv", [("a", captions, {"key": "=1"})])
    assert note.startswith("6 cells begin like a formula: in a spreadsheet, import the columns as")
    assert list(read_sheet(tmp_path / "w.tsv").entries["a"].captions) == captions
    write_table(tmp_path / "t.tsv", ["=head", "b"], [cells])
    head, row = ((tmp_path / "t.tsv").read_text()).splitlines()
    assert head == "'=head\tb"
    assert row.split("\t") == [f"'{cell}" for cell in cells[:5]] + cells[5:]
