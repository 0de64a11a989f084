"""Importing words: what of a sheet is left out is said."""

from __future__ import annotations

from pathlib import Path

import motiondb
from motiondb.database.catalogue.sheets import ImportReport


def test_what_does_nothing_is_said(learned_copy: Path, tmp_path: Path) -> None:
    sheet = tmp_path / "s.tsv"
    sheet.write_text(
        "file\twords\tstart\tfps\tskeleton\n"
        "ana/bow_1\ta late bow\t99\t60\t\n"
        "ana/walk_1\tstrolls\t\t60\tbody\n"
        "ghost\tflies\t\t25\t\n"
    )
    with motiondb.open(learned_copy) as db:
        before, fps = db.captions("ana/bow_1"), db.captures('name="ana/bow_1"')[0].fps
        report = db.import_words(sheet)
        assert report == ImportReport(
            2,
            (
                f"{sheet}:4: expected a capture of the added folder, found 'ghost'. "
                "Correct the file column.",
            ),
            (
                f"{sheet}: has a column fps for 2 captures that were read already; it was left out "
                "(remove and add them to read them by another fps)",
                f"{sheet}: has a column skeleton for 1 captures that were read already; it was "
                "left out (remove and add them to read them by another skeleton)",
                "ana/bow_1: words 'a late bow' start at 99 s, after the capture's end at 2.7 s, "
                "and were left out",
            ),
        )
        assert db.captions("ana/bow_1") == before
        assert db.captures('name="ana/bow_1"')[0].fps == fps
        assert [c.words for c in db.captions("ana/walk_1")] == ["strolls"]
