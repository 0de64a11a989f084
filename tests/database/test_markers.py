"""Markers without a body: kept, found by words and tags, exported; never searched by motion."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from c3d_writer import c3d_bytes

import motiondb
from motiondb.files.formats import read_marker_bytes

LABELS = ("pen", "cup", "")


def places() -> np.ndarray:
    """Three points, millimetres, z up, one of them lost for a second."""
    points = np.tile([[100.0, 0.0, 900.0], [200.0, 0.0, 800.0], [1.0, 1.0, 1.0]], (200, 1, 1))
    points[:, 0, 0] += np.arange(200)
    points[50:150, 1] = np.nan
    return points


@pytest.fixture
def base(tmp_path: Path) -> motiondb.MotionDB:
    file = tmp_path / "hand.c3d"
    file.write_bytes(c3d_bytes(places(), LABELS))
    sheet = tmp_path / "words.tsv"
    sheet.write_text("file\twords\tperformer\nhand\ta pen is moved\tana\n")
    opened = motiondb.MotionDB(tmp_path / "a.motiondb")
    report = opened.add([tmp_path], words=sheet)
    assert report.added == ("hand",)
    assert report.problems == ()
    assert any("Kept as markers" in note for note in report.notes)
    return opened


def test_they_are_catalogued_and_found_by_words_and_tags(base: motiondb.MotionDB) -> None:
    (info,) = base.captures("caption~pen and performer=ana")
    assert (info.name, info.n_frames, info.fps, info.duration) == ("hand", 200, 100.0, 2.0)
    assert not info.has_body
    assert any("left as gaps: cup (1.0 s)" in note for note in info.notes)
    facts = base.captures.show("hand")
    assert facts.leg_length == ""
    assert facts.activities == []
    assert base.check() == []


def test_whoever_asks_for_motion_is_told(base: motiondb.MotionDB) -> None:
    for ask in (base.motion, base.like, base.captures.gait):
        with pytest.raises(motiondb.MotionDBError, match=r"markers|whole body"):
            ask("hand")
    with pytest.raises(motiondb.MotionDBError, match="expected captures to learn from"):
        base.learn()


@pytest.mark.parametrize("ending", ["npz", "csv", "trc"])
def test_they_are_exported_with_their_gaps(
    base: motiondb.MotionDB, tmp_path: Path, ending: str
) -> None:
    path = tmp_path / f"out.{ending}"
    base.export("hand", path)
    expected = places()[..., [0, 2, 1]] * [1e-3, 1e-3, -1e-3]  # y up, metres
    if ending == "npz":
        with np.load(path) as arrays:
            found, names = arrays["positions"], arrays["markers"].tolist()
            assert float(arrays["fps"]) == 100.0
        assert names == ["pen", "cup", "unnamed 3"]
    elif ending == "csv":
        table = np.genfromtxt(path, delimiter=",", skip_header=1)
        found = table[:, 1:].reshape(200, 3, 3)
        assert path.read_text().startswith("time,pen.x,pen.y,pen.z,cup.x")
    else:
        tracks = read_marker_bytes(path.read_bytes(), "trc", path=path)
        found = tracks.places
        assert (tracks.labels, tracks.fps) == (("pen", "cup", "unnamed 3"), 100.0)
    np.testing.assert_allclose(found, expected, atol=1e-7)


def test_the_file_comes_back_as_it_was_and_a_part_is_cut(
    base: motiondb.MotionDB, tmp_path: Path
) -> None:
    assert base.export("hand", tmp_path / "same.c3d").is_added_file
    assert (tmp_path / "same.c3d").read_bytes() == (tmp_path / "hand.c3d").read_bytes()
    base.export("hand", tmp_path / "part.npz", 0.5, 1.0)
    with np.load(tmp_path / "part.npz") as arrays:
        assert arrays["positions"].shape == (50, 3, 3)
    with pytest.raises(motiondb.QueryError, match="found markers without one"):
        base.export("hand", tmp_path / "body.bvh")


def test_they_are_merged_and_beside_them_bodies_are_learned(
    base: motiondb.MotionDB, tmp_path: Path
) -> None:
    base.close()
    with motiondb.MotionDB(tmp_path / "b.motiondb") as other:
        assert other.merge(tmp_path / "a.motiondb").added == ("hand",)
        assert not other.captures("name=hand")[0].has_body


def test_points_never_seen_are_refused(tmp_path: Path) -> None:
    (tmp_path / "none.c3d").write_bytes(c3d_bytes(np.full((20, 1, 3), np.nan), ["pen"]))
    with motiondb.MotionDB(tmp_path / "a.motiondb") as opened:
        (problem,) = opened.add([tmp_path / "none.c3d"]).problems
    assert "expected markers, found none that was ever seen" in problem


def test_events_of_a_c3d_are_those_of_its_capture_unless_a_sheet_has_others(
    tmp_path: Path,
) -> None:
    said = {"EVENT:TIMES": [0.0, 1.0], "EVENT:LABELS": ["Foot Off"], "EVENT:CONTEXTS": ["Left"]}
    (tmp_path / "foot.c3d").write_bytes(c3d_bytes(places(), LABELS, said=said))
    with motiondb.MotionDB(tmp_path / "a.motiondb") as opened:
        assert opened.add([tmp_path]).events == 1
        found = opened.captures.events("foot")
        assert found == (motiondb.Event(30, "foot_off", "l_ankle", "ground"),)
    sheet = tmp_path / "events.tsv"
    sheet.write_text("file\tevent\ttime\nfoot\tcatch\t0.5\n")
    with motiondb.MotionDB(tmp_path / "b.motiondb") as opened:
        opened.add([tmp_path], events=sheet)
        assert [e.name for e in opened.captures.events("foot")] == ["catch"]
