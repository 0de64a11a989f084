"""What is left when captures or their words are taken out of a database that has learned."""

from pathlib import Path

import pytest

import motiondb
from motiondb.database.catalogue.sheets import ImportReport
from motiondb.errors import QueryError, SheetError
from motiondb.files.sheets import capture_name, read_sheet


def test_all_removed_and_added_again(learned_copy: Path, samples_folder: Path) -> None:
    with motiondb.open(learned_copy) as db:
        db.remove([info.name for info in db.captures()])
        report = db.add(samples_folder / "ana" / "bow_1.bvh")
        assert report.added == ("bow_1",)
        assert [match.capture for match in db.like("bow_1", limit=1)] == ["bow_1"]
        assert db.check() == []
        with pytest.raises(QueryError, match="walk"):
            db.search("walk")
        with pytest.raises(QueryError):
            db.generate("walk")
        assert all(d.words == () for d in db.describe("bow_1"))


def test_words_of_the_last_described_captures_are_no_longer_known(learned_copy: Path) -> None:
    with motiondb.open(learned_copy) as db:
        described = db.captures("action ~ bow")
        db.remove([info.name for info in described if "long" not in info.name])
        db.remove([info.name for info in db.captures() if "bow" in str(db.captions(info.name))])
        with pytest.raises(QueryError, match="bow"):
            db.search("bow")


def test_a_sheet_without_words_keeps_them(learned_copy: Path, tmp_path: Path) -> None:
    sheet = tmp_path / "tags.tsv"
    sheet.write_text("file\tmood\nana/bow_1\thappy\n")
    with motiondb.open(learned_copy) as db:
        before = db.captions("ana/bow_1")
        assert before
        assert db.import_words(sheet) == ImportReport(1)
        assert db.captions("ana/bow_1") == before
        assert db.captures("mood=happy")[0].name == "ana/bow_1"


@pytest.mark.parametrize(
    ("words", "start", "end"),
    [("walk", None, 0.0), ("walk", None, 9999.0), ("walk", float("inf"), None), ("  ", None, None)],
)
def test_words_that_say_nothing_are_refused(
    learned_copy: Path, words: str, start: float | None, end: float | None
) -> None:
    with motiondb.open(learned_copy) as db:
        before = db.captions("ana/bow_1")
        with pytest.raises(QueryError, match="ana/bow_1: expected"):
            db.set_words("ana/bow_1", words, start, end)
        assert db.captions("ana/bow_1") == before


def test_infinite_times_are_refused(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        with pytest.raises(QueryError, match="expected an interval within"):
            db.like("ana/bow_1", start=float("inf"))
        with pytest.raises(QueryError, match="expected an interval within"):
            db.like("ana/bow_1", end=float("inf"))


def test_a_quote_never_swallows_the_rows_below(tmp_path: Path) -> None:
    sheet = tmp_path / "words.tsv"
    sheet.write_text('file\twords\njump.bvh\t"jump high\nwalk.bvh\twalk\n')
    with pytest.raises(SheetError) as error:
        read_sheet(sheet)
    assert str(error.value) == (
        f"{sheet}:2: expected a quote that ends in its own line, found one that does not. "
        "Close it, or double a quote that is part of the words."
    )


def test_names_may_hold_dots() -> None:
    assert capture_name("take.2") == "take.2"
    assert capture_name("take.2.bvh") == "take.2"
