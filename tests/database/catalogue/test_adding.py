"""Adding captures through the Python class: what is kept, what is known again, what is refused."""

from __future__ import annotations

import math
import os
import shutil
import weakref
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import motiondb
from motiondb.body import body, changes, kinematics, retarget, rotation, world
from motiondb.database.catalogue import cataloguing, file_reading, known_files
from motiondb.database.catalogue.file_reading import AddSettings, Readings, read_joint_map
from motiondb.database.catalogue.sheets import ImportReport
from motiondb.errors import MotionDBError, QueryError
from motiondb.files.bvh_writer import write_bvh
from motiondb.files.formats import read_capture
from motiondb.records import Clip, Motion


def mirrored(motion: Motion) -> Motion:
    """Left and right exchanged: reflected in the plane x = 0, joint by joint."""
    turned = motion.local_rotations[:, body.MIRROR] * np.array([1, 1, -1, -1], dtype=np.float32)
    placed = motion.root_positions * np.array([-1, 1, 1], dtype=np.float32)
    return replace(motion, local_rotations=turned, root_positions=placed)


def test_names_tags_words_and_rates_come_from_folder_and_sheet(tmp_path: Path, some: Path) -> None:
    sheet = tmp_path / "words.tsv"
    sheet.write_text(
        "file\twords\tstart\tend\tperformer\tfps\tmood\n"
        "ana/bow_1.bvh\tshe bows\t\t\tAna\t60\tcalm\n"
        "ana/bow_1\tstands up again\t0.7\t1.3\t\t\t\n"
    )
    with motiondb.open(tmp_path / "m.duckdb") as db:
        report = db.add(some, words=sheet)
        assert report.added == ("ana/bow_1", "ana/jump_1", "boris/kick_1", "boris/punch_1")
        assert report.problems == ()
        (bow,) = db.captures("mood=calm and performer=ana")
        assert (bow.name, bow.fps, bow.n_frames, bow.duration) == ("ana/bow_1", 60.0, 81, 81 / 60)
        assert [(c.words, c.start, c.end) for c in db.words.captions("ana/bow_1")] == [
            ("she bows", None, None),
            ("stands up again", 0.7, 1.3),
        ]
        assert report.seconds == pytest.approx(sum(c.duration for c in db.captures()))


def test_adding_again_changes_nothing(
    tmp_path: Path, some: Path, contents: Callable[[Path], object]
) -> None:
    path = tmp_path / "m.duckdb"
    with motiondb.open(path) as db:
        db.add(some)
    before = contents(path)
    with motiondb.open(path) as db:
        report = db.add(some)
        assert (report.added, len(report.known), report.problems) == ((), 4, ())
        shutil.copy(some / "ana/bow_1.bvh", some / "another name.bvh")
        again = db.add(some / "another name.bvh")
        assert again.known == (("another name", "ana/bow_1"),)
    after = contents(path)
    assert len(after.pop("same_file")) == 1  # nothing else is noted of the file,
    assert len(after.pop("known_file")) == 5  # but that it need not be read again
    assert {t: rows for t, rows in after.items() if t != "meta"} == {
        t: rows for t, rows in before.items() if t not in ("meta", "same_file", "known_file")
    }


def test_another_content_under_a_known_name_is_refused(tmp_path: Path, some: Path) -> None:
    with motiondb.open(tmp_path / "m.duckdb") as db:
        db.add(some)
        shutil.copy(some / "boris/kick_1.bvh", tmp_path / "x.bvh")
        text = (some / "ana/bow_1.bvh").read_text()
        (some / "ana/bow_1.bvh").write_text(text + "\n")
        (problem,) = db.add(some).problems
        assert problem == (
            f"{some}/ana/bow_1.bvh: expected a new name, found another capture called ana/bow_1. "
            "Put a folder before the new names (--prefix FOLDER/), or let the new files take the "
            "place of the old ones (--replace)."
        )


def test_same_motion_mirror_image_and_cut_are_reported(tmp_path: Path, some: Path) -> None:
    more = tmp_path / "more"
    more.mkdir()
    with motiondb.open(tmp_path / "m.duckdb") as db:
        db.add(some)
        db.export("boris/kick_1", more / "same.bvh", canonical=True)
        db.export("boris/kick_1", more / "cut.bvh", start=0.5, end=2.5)
        motiondb.write_bvh(
            retarget.to_clip(mirrored(db.motion("boris/kick_1"))), more / "mirror.bvh"
        )
        for name in ("same", "cut", "mirror"):
            relations = db.add(more / f"{name}.bvh").relations
            (actual,) = [r for r in relations if (r.capture, r.other) == (name, "boris/kick_1")]
            assert actual.kind == name
            whole = (0.0, db.captures("name=boris/kick_1")[0].duration)
            place = (0.5, 2.5) if name == "cut" else whole
            assert (actual.start, actual.end) == pytest.approx(place, abs=0.11)
        assert "mirror" in {r.kind for r in db.captures.relations("mirror")}


def test_a_cut_is_known_though_the_whole_take_comes_later(tmp_path: Path, some: Path) -> None:
    with motiondb.open(tmp_path / "a.duckdb") as db:
        db.add(some)
        db.export("boris/kick_1", tmp_path / "cut.bvh", start=0.5, end=2.5)
    with motiondb.open(tmp_path / "b.duckdb") as db:
        db.add(tmp_path / "cut.bvh")
        relations = db.add(some).relations
        assert [(r.capture, r.other, r.kind) for r in relations] == [("cut", "boris/kick_1", "cut")]


def test_export_gives_the_very_bytes_and_remove_forgets(tmp_path: Path, some: Path) -> None:
    with motiondb.open(tmp_path / "m.duckdb") as db:
        db.add(some)
        out = db.export("ana/jump_1", tmp_path / "j.bvh").output
        assert out.read_bytes() == (some / "ana/jump_1.bvh").read_bytes()
        assert db.export("ana/jump_1", tmp_path / "j.glb").output.read_bytes()[:4] == b"glTF"
        part = read_capture(db.export("ana/jump_1", tmp_path / "p.bvh", start=0.5, end=1.5).output)
        whole = read_capture(out)
        assert part.n_frames == 30
        assert np.allclose(part.root_positions, whole.root_positions[15:45], atol=1e-5)
        with pytest.raises(QueryError, match=r"j\.xyz: expected an ending \.bvh, \.fbx, \.glb"):
            db.export("ana/jump_1", tmp_path / "j.xyz")
        with pytest.raises(QueryError, match="expected the name of a capture"):
            db.captures.remove(["ana/jump_1", "nobody"])
        assert len(db.captures()) == 4
        assert db.captures.remove(["ana/jump_1", "boris/kick_1"]) == ["ana/jump_1", "boris/kick_1"]
        assert [c.name for c in db.captures()] == ["ana/bow_1", "boris/punch_1"]
        assert db.check() == []


AMC = ":FULLY-SPECIFIED\n:DEGREES\n1\nroot 0 0 0 0 0 0\n"


@pytest.mark.usefixtures("read_beside")
def test_broken_files_are_listed_and_the_good_ones_added(tmp_path: Path, some: Path) -> None:
    whole = (some / "ana/bow_1.bvh").read_text()
    (some / "cut.bvh").write_text(whole[: len(whole) // 2])
    (some / "empty.bvh").touch()
    (some / "lonely.amc").write_text(AMC)
    (some / "twin.bvh").write_text("x")
    (some / "twin.npz").write_text("x")
    (some / "readme.txt").write_text("no capture")
    for jobs in (1, 2):
        with motiondb.open(tmp_path / f"{jobs}.duckdb") as db:
            report = db.add(some, settings=AddSettings(jobs=jobs))
            assert len(report.added) == 4
            assert len(db.captures()) == 4
        problems = "\n".join(report.problems)
        assert f"{some}/cut.bvh:" in problems
        assert (
            f"{some}/empty.bvh: expected a capture, found an empty file. Export it again."
            in report.problems
        )
        assert (
            f"{some}/lonely.amc: expected its skeleton lonely.asf in the same folder, found no ASF "
            "file. Put the ASF beside the AMC, or name it in the sheet's column 'skeleton'."
            in report.problems
        )
        assert len(report.problems) == 5


def test_files_that_differ_in_their_ending_are_captures_of_their_own(
    tmp_path: Path, some: Path
) -> None:
    folder, other = tmp_path / "takes", tmp_path / "other"
    (folder / "sub").mkdir(parents=True)
    other.mkdir()
    sources = sorted(some.rglob("*.bvh"))
    for file, source in zip(("walk.bvh", "walk.BVH", "Walk.bvh", "sub/walk.bvh"), sources):
        (folder / file).write_bytes(source.read_bytes())
    (other / "sub").mkdir()
    shutil.copy(sources[0], other / "sub" / "walk.bvh")
    sheet = tmp_path / "s.tsv"
    sheet.write_text("file\twords\nwalk.BVH\tbow\nwalk.bvh\tstroll\nWalk\tkick\n")
    with motiondb.open(tmp_path / "m.duckdb") as db:
        shutil.move(folder / "walk.BVH", tmp_path / "later")
        assert db.add(folder, sheet).added == ("Walk", "sub/walk", "walk")
        shutil.move(tmp_path / "later", folder / "walk.BVH")
        report = db.add([folder, other], sheet)
        assert report.added == ("walk.BVH",)  # the other keeps the name that it has
        assert any("(walk.BVH, walk.bvh)" in note for note in report.notes)
        (problem,) = report.problems
        assert "sub/walk.bvh: expected one file per name, found" in problem
        said = {
            info.name: [c.words for c in db.words.captions(info.name)] for info in db.captures()
        }
        assert said == {"Walk": ["kick"], "sub/walk": [], "walk": ["stroll"], "walk.BVH": ["bow"]}
        again = db.add([folder, other], sheet)
        assert (again.added, len(again.known), len(again.problems)) == ((), 4, 1)
        db.words.export(tmp_path / "out.tsv")
        db.words.import_sheet(tmp_path / "out.tsv")
        assert {i.name: [c.words for c in db.words.captions(i.name)] for i in db.captures()} == said
    with motiondb.open(tmp_path / "n.duckdb") as db:
        sheet.write_text("file\twords\nwalk\tboth\n")
        db.add(folder, sheet)
        assert [c.words for n in ("walk.bvh", "walk.BVH") for c in db.words.captions(n)] == [
            "both"
        ] * 2


def test_odd_sheets(tmp_path: Path, some: Path) -> None:
    with motiondb.open(tmp_path / "m.duckdb") as db:
        sheet = tmp_path / "s.csv"
        sheet.write_text("file,words\nana/bow1,bow\nana/bow_1,bow\nana/bow_1,bow\n")
        report = db.add(some, words=sheet)
        assert report.problems == (
            f"{sheet}:2: expected a capture of the added folder, found 'ana/bow1'. "
            "Did you mean ana/bow_1? Correct the file column.",
        )
        assert report.notes == (f"{sheet}:4: repeats line 3 and was left out",)
        assert len(report.added) == 4
        sheet.write_text("")
        with pytest.raises(MotionDBError, match="found an empty sheet"):
            db.add(some, words=sheet)
        sheet.write_text("file,words\n")
        assert db.add(some, words=sheet).notes == (f"{sheet}: holds a header and no rows",)
        sheet.write_text("file,words\nana/bow_1,a deep bow\n")
        assert db.add(some, words=sheet).notes == (
            f"{sheet}: has other words for 1 captures that had been added before; they were not "
            f"changed (motiondb words import {sheet} replaces them)",
        )
        assert db.words.import_sheet(sheet) == ImportReport(1)
        assert [c.words for c in db.words.captions("ana/bow_1")] == ["a deep bow"]


def test_nothing_to_add(tmp_path: Path) -> None:
    with motiondb.open(tmp_path / "m.duckdb") as db:
        with pytest.raises(MotionDBError, match="expected a capture or a folder of captures"):
            db.add(tmp_path / "nothing")
        (tmp_path / "empty").mkdir()
        with pytest.raises(MotionDBError, match=r"expected captures \(\.bvh, \.amc, .*\), found"):
            db.add(tmp_path / "empty")


def test_joint_map_file(tmp_path: Path) -> None:
    path = tmp_path / "map"
    path.write_text("pelvis = Root # the lowest\n\nhead=Top\n")
    assert read_joint_map(path) == {"pelvis": "Root", "head": "Top"}
    path.write_text("pelvis Root\nhead =\n")
    with pytest.raises(MotionDBError) as refused:
        read_joint_map(path)
    assert str(refused.value) == (
        f"{path}:1: expected `role = joint`, found 'pelvis Root'.\n"
        f"{path}:2: expected `role = joint`, found 'head ='."
    )


def test_words_that_say_nothing_are_refused(tmp_path: Path, some: Path) -> None:
    with motiondb.open(tmp_path / "m.duckdb") as db:
        db.add(some / "ana")
        with pytest.raises(QueryError) as refused:
            db.words.set("bow_1", "flies", start=9.0)
        assert str(refused.value) == (
            "bow_1: expected an interval within 0 to 2.70 s, found 9 to the end. Times are seconds."
        )
        for words, at in (("walk", (None, 0.0)), ("walk", (math.inf, None)), ("  ", (None, None))):
            with pytest.raises(QueryError, match="bow_1: expected"):
                db.words.set("bow_1", words, *at)
        assert db.words.captions("bow_1") == ()


def test_what_does_nothing_is_said(learned_copy: Path, tmp_path: Path) -> None:
    sheet = tmp_path / "s.tsv"
    sheet.write_text(
        "file\twords\tstart\tfps\tskeleton\n"
        "ana/bow_1\ta late bow\t99\t60\t\n"
        "ana/walk_1\tstrolls\t\t60\tbody\n"
        "ghost\tflies\t\t25\t\n"
    )
    with motiondb.open(learned_copy) as db:
        before, fps = db.words.captions("ana/bow_1"), db.captures('name="ana/bow_1"')[0].fps
        report = db.words.import_sheet(sheet)
        assert report == ImportReport(
            2,
            (
                f"{sheet}:4: expected a capture of the added folder, found 'ghost'. "
                "Correct the file column.",
                f"{sheet}:2: expected words about a part of ana/bow_1, which ends at 2.7 s, "
                "found 'a late bow' from 99 s. Times are seconds; the words were left out.",
            ),
            (
                f"{sheet}: has a column fps for 2 captures that were read already; it was left out "
                "(remove and add them to read them by another fps)",
                f"{sheet}: has a column skeleton for 1 captures that were read already; it was "
                "left out (remove and add them to read them by another skeleton)",
            ),
        )
        assert db.words.captions("ana/bow_1") == before
        assert db.captures('name="ana/bow_1"')[0].fps == fps
        assert [c.words for c in db.words.captions("ana/walk_1")] == ["strolls"]


def test_batches_add_what_one_batch_adds(
    tmp_path: Path, some: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Copies are found across batches, and between them and captures that were there."""
    for number, source in enumerate(sorted(some.rglob("*.bvh"))):
        text = source.read_text().replace("HIERARCHY", "HIERARCHY ")
        (some / f"again_{number}.bvh").write_text(text)
    shutil.copy(some / "again_1.bvh", some / "same_file.bvh")
    (some / "broken.bvh").write_text("no capture")
    reports, relations = [], []
    for name, most in (("one", cataloguing.BATCH_BYTES), ("many", 1)):
        monkeypatch.setattr(cataloguing, "BATCH_BYTES", most)
        with motiondb.open(tmp_path / f"{name}.duckdb") as db:
            db.add(some / "ana")
            report = db.add(some)
            reports.append(replace(report, relations=(), problems=sorted(report.problems)))
            assert sorted(map(repr, report.relations)) == sorted(map(repr, db.captures.relations()))
            relations.append(sorted(map(repr, report.relations)))
            assert db.check() == []
            assert [run["kind"] for run in db.runs()] == ["add", "add"]
    assert reports[0] == reports[1]
    assert len(relations[0]) >= 4
    assert relations[0] == relations[1]


def test_a_batch_is_gone_before_the_next_one_is_read(
    tmp_path: Path, some: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So memory does not grow with the number of batches."""
    read_all, read, alive = known_files.read_all, list[weakref.ref[object]](), list[int]()

    def watched(*given: Any) -> Iterator[Readings]:
        for readings in read_all(*given):
            alive.append(sum(of_file() is not None for of_file in read))
            read.extend(weakref.ref(each) for each in readings)
            yield readings

    monkeypatch.setattr(known_files, "read_all", watched)
    monkeypatch.setattr(cataloguing, "BATCH_BYTES", 1)
    with motiondb.open(tmp_path / "m.duckdb") as db:
        assert len(db.add(some).added) == 4
    assert alive == [0, 0, 0, 0]


def test_files_may_be_left_out(tmp_path: Path, some: Path) -> None:
    """Motions are the same; what needs the file is refused, also in a rescued database."""
    with (
        motiondb.open(tmp_path / "all.duckdb") as whole,
        motiondb.open(tmp_path / "few.duckdb") as db,
    ):
        whole.add(some)
        assert db.add(some, settings=AddSettings(originals=False)).problems == ()
        assert len(db.add(some, settings=AddSettings(originals=False)).known) == 4
        np.testing.assert_array_equal(
            db.motion("ana/bow_1").root_positions, whole.motion("ana/bow_1").root_positions
        )
        for name in ("bow.bvh", "bow.glb"):
            with pytest.raises(QueryError, match=r"bow_1.bvh: .* left out \(--no-originals\). Exp"):
                db.export("ana/bow_1", tmp_path / name)
        db.export("ana/bow_1", tmp_path / "bow.bvh", canonical=True)
        assert db.check() == []
    report = motiondb.rescue(tmp_path / "few.duckdb", tmp_path / "rescued.duckdb")
    assert (len(report.captures), report.mended, report.lost) == (4, (), ())
    with motiondb.open(tmp_path / "rescued.duckdb") as rescued:
        assert len(rescued.add(some).known) == 4


def in_world(clip: Clip, up: str) -> Clip:
    """The same capture written in a world in which another axis is up."""
    back = rotation.conjugate(world.to_y_up(up))
    local = clip.local_rotations.copy()
    local[:, 0] = rotation.multiply(back, local[:, 0])
    root = rotation.rotate(back, clip.root_positions)
    return replace(clip, local_rotations=local, root_positions=root)


def lying(clip: Clip) -> Clip:
    """The first frame of a capture, tipped onto its back and held for a second."""
    still = changes.part(clip, 0, 1)
    local = np.repeat(still.local_rotations, 30, axis=0)
    local[:, 0] = rotation.multiply(rotation.from_euler([-90.0], "X"), local[:, 0])
    root = np.repeat([[0.0, 0.1, 0.0]], 30, axis=0)
    return replace(clip, local_rotations=local, root_positions=root, joint_positions=None)


def heights(db: motiondb.MotionDB, name: str) -> float:
    """How far the neck is above the hips, in the median, metres."""
    places = db.motion(name).joint_positions()
    return float(np.median(places[:, body.INDEX["neck"], 1] - places[:, 0, 1]))


def test_one_skeleton_is_read_in_one_world(tmp_path: Path, some: Path) -> None:
    walk = read_capture(some / "ana" / "jump_1.bvh")
    folder = tmp_path / "takes"
    folder.mkdir()
    write_bvh(in_world(lying(walk), "z"), folder / "lies.bvh")
    with motiondb.open(tmp_path / "alone.duckdb") as db:
        note, *_ = db.add(folder) and db.captures()[0].notes  # it is still, too
        assert "does not show for certain" in note
    feet = np.array([0.0, 0.2, -0.9])  # on a mattress, the feet at y = 0: alone it stands
    stands = lying(walk)
    write_bvh(
        in_world(replace(stands, root_positions=stands.root_positions + feet), "z"),
        folder / "stands.bvh",
    )
    for number in range(2):
        write_bvh(in_world(walk, "z"), folder / f"walk{number}.bvh")
        walk = replace(walk, root_positions=walk.root_positions + np.array([0.1, 0.0, 0.0]))
    with motiondb.open(tmp_path / "m.duckdb") as db:
        db.add(folder)
        assert abs(heights(db, "lies")) < 0.1
        assert heights(db, "walk0") > 0.3
        assert abs(heights(db, "stands")) < 0.1
        notes = {info.name: info.notes for info in db.captures()}
        for name in ("lies", "stands"):
            assert world.AS_OTHERS.format(up="z") in notes[name]
        # an export needs no evidence: the run says what was up
        db.export("lies", tmp_path / "lies.glb")
        assert db.clip("lies").up == "z"
        (run,) = db.runs()
        assert set(run["parameters"]["worlds"].values()) == {"z"}


def test_a_file_of_one_frame_is_told(tmp_path: Path, some: Path) -> None:
    clip = changes.part(read_capture(some / "ana" / "jump_1.bvh"), 0, 1)
    (tmp_path / "takes").mkdir()
    write_bvh(clip, tmp_path / "takes" / "pose.bvh")
    with motiondb.open(tmp_path / "m.duckdb") as db:
        assert (
            "pose: The file has one frame: a pose, no motion." in db.add(tmp_path / "takes").notes
        )


def test_an_axis_is_given_for_all_or_in_the_sheet(tmp_path: Path, some: Path) -> None:
    folder = tmp_path / "takes"
    folder.mkdir()
    lies = lying(read_capture(some / "ana" / "bow_1.bvh"))
    write_bvh(in_world(lies, "z"), folder / "z.bvh")
    write_bvh(in_world(lies, "-x"), folder / "x.bvh")
    sheet = tmp_path / "s.tsv"
    sheet.write_text("file\twords\tup\nx\tlies\t-x\nz\tlies\t\n")
    with motiondb.open(tmp_path / "m.duckdb") as db:
        db.add(folder, sheet, AddSettings(up="z"))
        assert [abs(heights(db, name)) < 0.1 for name in "xz"] == [True, True]
        assert [db.clip(name).up for name in "xz"] == ["-x", "z"]
        assert "up" not in db.captures()[0].tags
    sheet.write_text("file\twords\tup\nx\tlies\tw\n")
    with (
        motiondb.open(tmp_path / "n.duckdb") as db,
        pytest.raises(MotionDBError, match="2: expected an axis up, one of y, z, x, -y, -z, -x"),
    ):
        db.add(folder, sheet)


def test_a_usual_axis_that_was_given_or_found_together_is_read_again_so(
    tmp_path: Path, some: Path
) -> None:
    walk = read_capture(some / "ana" / "jump_1.bvh")
    folder = tmp_path / "takes"
    folder.mkdir()
    write_bvh(in_world(walk, "z"), folder / "odd.bvh")
    sheet = tmp_path / "s.tsv"
    sheet.write_text("file\twords\tup\nodd\tlies\ty\n")
    with motiondb.open(tmp_path / "given.duckdb") as db:
        db.add(folder, sheet)
        assert (heights(db, "odd") < 0.2, db.clip("odd").up) == (True, "y")
    for number in range(3):
        walk = replace(walk, root_positions=walk.root_positions + np.array([0.1, 0.0, 0.0]))
        write_bvh(walk, folder / f"walk{number}.bvh")
    write_bvh(in_world(lying(walk), "z"), folder / "odd.bvh")
    with motiondb.open(tmp_path / "together.duckdb") as db:
        # the others show that it lies, with y up
        assert [note.split(".")[0] for note in db.add(folder).notes] == [
            "odd: Nothing moves in the whole take"
        ]
        assert db.clip("odd").up == "y"


def test_mirrored_worlds_and_exchanged_sides_are_mended(tmp_path: Path, some: Path) -> None:
    clip = read_capture(some / "ana" / "jump_1.bvh")
    (tmp_path / "a").mkdir()
    write_bvh(kinematics.as_asked(clip, "", True, None), tmp_path / "a" / "left.bvh")
    settings = AddSettings(mirror_world=True)
    with motiondb.open(tmp_path / "m.duckdb") as db:
        db.add(tmp_path / "a", settings=settings)
        np.testing.assert_allclose(
            db.motion("left").joint_positions(),
            retarget.to_motion(clip).joint_positions(),
            atol=1e-4,
        )
        np.testing.assert_allclose(
            db.clip("left").world_positions(), clip.world_positions(), atol=1e-6
        )
    with motiondb.open(tmp_path / "n.duckdb") as db:
        (note,) = db.add(tmp_path / "a").notes
        assert note.startswith("left: Knees bend and toes point backwards")


def test_captions_beyond_the_end_are_problems_with_their_line(tmp_path: Path, some: Path) -> None:
    sheet = tmp_path / "s.tsv"
    sheet.write_text(
        "file\twords\tstart\tend\nana/bow_1\tframes as seconds\t0\t81\nana/bow_1\trounded\t0\t2.8\n"
    )
    with motiondb.open(tmp_path / "m.duckdb") as db:
        report = db.add(some, words=sheet)
        assert report.problems == (
            f"{sheet}:2: expected words about a part of ana/bow_1, which ends at 2.7 s, found "
            "'frames as seconds' from 0 s to 81 s. Times are seconds; the words were left out.",
        )
        assert [c.words for c in db.words.captions("ana/bow_1")] == ["rounded"]


def reads(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The names of the files that are read from now on."""
    names: list[str] = []
    read_all = file_reading.read_all

    def noting(jobs: list[Any], *more: Any) -> Iterator[Readings]:
        names.extend(job.name for job in jobs)
        return read_all(jobs, *more)

    monkeypatch.setattr(known_files, "read_all", noting)
    return names


def test_files_that_are_as_they_were_are_not_read_again(
    tmp_path: Path, some: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bow, kick, read = some / "ana/bow_1.bvh", some / "boris/kick_1.bvh", reads(monkeypatch)
    with motiondb.open(tmp_path / "m.duckdb") as db:
        assert len(db.add(some).added) == len(read) == 4
        read.clear()
        os.utime(bow)  # the same bytes at another time
        assert len(db.add(some, settings=AddSettings(replace=True)).known) == 4
        assert len(db.add(some, settings=AddSettings(check_bytes=True)).known) == 4
        assert read == []
        assert len(db.add(some, settings=AddSettings(up="z")).known) == 4
        assert len(read) == 4  # how they are read is another
        db.add(some)
        read.clear()
        times, text = kick.stat(), kick.read_text()
        kick.write_text(text.replace("0.0", "0.1", 1))  # in place, of the same size
        os.utime(kick, ns=(times.st_atime_ns, times.st_mtime_ns))
        assert len(db.add(some).known) == 4  # the limit, in the guide
        (problem,) = db.add(some, settings=AddSettings(check_bytes=True)).problems
        assert problem.startswith(f"{kick}: expected a new name")
        assert read == ["boris/kick_1"]
        read.clear()
        db.remove(["ana/bow_1"])
        shutil.move(some / "boris/punch_1.bvh", some / "moved.bvh")
        again = db.add(some)
        assert again.added == ("ana/bow_1",)
        assert ("moved", "boris/punch_1") in again.known
        assert {*read} == {"ana/bow_1", "boris/kick_1", "moved"}


def test_a_faulty_file_is_told_once_as_new(
    tmp_path: Path, some: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken = some / "broken.amc"
    broken.write_text(AMC)
    with motiondb.open(tmp_path / "m.duckdb") as db:
        (problem,) = db.add(some).problems
        assert "expected its skeleton" in problem
        again = db.add(some)
        assert (again.problems, again.known_faulty) == ((), (problem,))
        assert [f.problem for f in db.faulty_files()] == [problem]
        broken.write_text(AMC + "\n")
        (some / "broken.asf").write_text("no skeleton")
        assert problem not in db.add(some).problems  # another one, as it is read again
        read = reads(monkeypatch)
        again = db.add(some)
        assert (len(again.known_faulty), read) == (1, [])
        assert len(db.add(some, settings=AddSettings(check_bytes=True)).problems) == 1
        assert read == ["broken"]


def test_files_left_out_are_filled_in_though_they_are_known(tmp_path: Path, some: Path) -> None:
    with motiondb.open(tmp_path / "m.duckdb") as db:
        db.add(some, settings=AddSettings(originals=False))
        assert len(db.add(some).known) == 4
        out = db.export("ana/jump_1", tmp_path / "j.bvh").output
        assert out.read_bytes() == (some / "ana/jump_1.bvh").read_bytes()
