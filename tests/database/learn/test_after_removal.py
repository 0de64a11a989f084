"""What is left when captures or their words are taken out of a database that has learned."""

from pathlib import Path

import pytest

import motiondb
from motiondb.database.catalogue.sheets import ImportReport
from motiondb.errors import QueryError, SheetError
from motiondb.files.sheets import read_sheet


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


def test_a_sheet_without_words_keeps_them(learned_copy: Path, tmp_path: Path) -> None:
    sheet = tmp_path / "tags.tsv"
    sheet.write_text("file\tmood\nana/bow_1\thappy\n")
    with motiondb.open(learned_copy) as db:
        before = db.captions("ana/bow_1")
        assert before
        assert db.import_words(sheet) == ImportReport(1)
        assert db.captions("ana/bow_1") == before
        assert db.captures("mood=happy")[0].name == "ana/bow_1"


def test_words_that_say_nothing_are_refused(learned_copy: Path) -> None:
    with motiondb.open(learned_copy) as db:
        before = db.captions("ana/bow_1")
        for words, start, end in (("walk", None, 0.0), ("walk", None, 9999.0),
                                  ("walk", float("inf"), None), ("  ", None, None)):  # fmt: skip
            with pytest.raises(QueryError, match="ana/bow_1: expected"):
                db.set_words("ana/bow_1", words, start, end)
        for at in ({"start": float("inf")}, {"end": float("inf")}):
            with pytest.raises(QueryError, match="expected an interval within"):
                db.like("ana/bow_1", **at)
        assert db.captions("ana/bow_1") == before


def test_a_quote_never_swallows_the_rows_below(tmp_path: Path) -> None:
    sheet = tmp_path / "words.tsv"
    sheet.write_text('file\twords\njump.bvh\t"jump high\nwalk.bvh\twalk\n')
    with pytest.raises(SheetError) as error:
        read_sheet(sheet)
    assert str(error.value) == (
        f"{sheet}:2: expected a quote that ends in its own line, found one that does not. "
        "Close it, or double a quote that is part of the words."
    )
