"""Captures of an FBX file with several takes: names, sheets, export, rescue."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np

from motiondb import MotionDB
from motiondb.database.catalogue.rescuing import rescue

FBX = Path(__file__).parent.parent / "files" / "fbx" / "two_takes.fbx.gz"


def test_takes_are_captures_of_their_own(tmp_path: Path) -> None:
    data = gzip.decompress(FBX.read_bytes())
    folder = tmp_path / "day"
    folder.mkdir()
    (folder / "two.fbx").write_bytes(data)
    sheet = tmp_path / "words.tsv"
    sheet.write_text("file\twords\tperformer\ntwo.fbx\tmoves\tann\ntwo.fbx#jump_1\tjumps\tbob\n")
    with MotionDB(tmp_path / "a.duckdb", create=True) as base:
        report = base.add(folder, sheet)
        assert report.added == ("two#bow_1", "two#jump_1")
        assert report.problems == ()
        assert report.notes[0].startswith("two holds 2 takes: two#bow_1, two#jump_1; the sheet's")
        bow, jump = base.captures()
        assert (bow.tags, jump.tags) == ({"performer": "ann"}, {"performer": "bob"})
        assert [c.words for c in base.words.captions("two#jump_1")] == ["jumps"]
        assert base.words.captions("two#bow_1") == ()
        assert base.export("two#jump_1", tmp_path / "out.fbx").output.read_bytes() == data
        clip = base.clip("two#jump_1")
        assert (clip.format, clip.n_frames) == ("fbx", 9)
        example = base.motion(f"{folder / 'two.fbx'}#jump_1")
        np.testing.assert_array_equal(example.root_positions, base.motion(jump.name).root_positions)
        assert base.add(folder).known == (("two#bow_1", "two#bow_1"), ("two#jump_1", "two#jump_1"))
    rescue(tmp_path / "a.duckdb", tmp_path / "b.duckdb")
    with MotionDB(tmp_path / "b.duckdb") as base:
        assert base.clip("two#bow_1").n_frames == 9
