"""Captures replaced, renamed, tagged and removed, and every change taken back."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

import motiondb
from motiondb import AddSettings, MotionDB, QueryError, store
from motiondb.database.catalogue.sheets import ImportReport
from motiondb.database.learn import updating

TABLES = ("capture", "capture_tag", "caption", "event", "motion", "relation", "source")


def catalogue(db: MotionDB) -> dict[str, list[tuple[object, ...]]]:
    """Every row that people or files brought in."""
    run = db.store.connection.execute
    return {t: sorted(run(f"FROM {t}").fetchall(), key=repr) for t in TABLES}


@pytest.fixture
def base(tmp_path: Path, some: Path) -> MotionDB:
    with motiondb.open(tmp_path / "motions.duckdb") as db:
        events = tmp_path / "events.tsv"
        events.write_text("file\tevent\tframe\nana/jump_1\tfoot_strike\t5\nana/jump_1\tcatch\t70\n")
        db.add(some, events=events)
        db.words.set("ana/jump_1", "she jumps")
        yield db


def test_every_change_is_taken_back_in_turn_and_done_again(base: MotionDB, tmp_path: Path) -> None:
    sheet = tmp_path / "sheet.tsv"
    sheet.write_text("file\twords\tmood\nana/bow_1\ta bow\tglad\nboris/kick_1\ta kick\t\n")
    events = tmp_path / "more.tsv"
    events.write_text("file\tevent\tframe\nana/jump_1\trelease\t7\n")
    changes = (
        lambda: base.captures.set_tags({"performer": "A", "mood": ""}, where="name~ana"),
        lambda: base.captures.rename("ana/", "studio/"),
        lambda: base.words.import_sheet(sheet),
        lambda: base.captures.rename("studio/*", "ana/*", ["studio/bow_1", "studio/jump_1"]),
        lambda: base.words.import_sheet(sheet),
        lambda: base.captures.import_events(events),
        lambda: base.captures.remove(["ana/bow_1"], "name~kick"),
    )
    states = [catalogue(base)]
    for change in changes:
        change()
        states.append(catalogue(base))
    undone = []
    for before in states[-2::-1]:
        if catalogue(base) != before:  # an import that changes nothing is not undone
            undone.append(base.undo().run)
        assert catalogue(base) == before
    for run in reversed(undone):
        base.undo(run)
    assert catalogue(base) == states[-1]
    assert base.check() == []


def test_new_files_take_the_place_of_old_ones_and_keep_their_words(
    base: MotionDB, tmp_path: Path, samples_folder: Path
) -> None:
    base.captures.set_tags({"performer": "ana", "mood": "glad"}, ["ana/jump_1"])
    again = tmp_path / "again"
    (again / "ana").mkdir(parents=True)
    shutil.copy(samples_folder / "boris" / "idle_1.bvh", again / "ana" / "jump_1.bvh")
    refused = base.add(again)
    assert refused.added == ()
    assert "found another capture called ana/jump_1" in refused.problems[0]
    before = catalogue(base)
    sheet = tmp_path / "words.tsv"
    sheet.write_text("file\tmood\nana/jump_1\tcalm\n")
    report = base.add(again, words=sheet, settings=AddSettings(replace=True))
    assert (report.added, report.replaced) == (("ana/jump_1",), ("ana/jump_1",))
    (info,) = base.captures("name=ana/jump_1")
    assert info.tags == {"performer": "ana", "mood": "calm"}
    assert [c.words for c in base.words.captions("ana/jump_1")] == ["she jumps"]
    assert [event.frame for event in base.captures.events("ana/jump_1")] == [5, 70]
    after = catalogue(base)
    done = base.undo()
    assert (done.restored, done.removed) == (("ana/jump_1",), ("ana/jump_1",))
    assert catalogue(base) == before
    base.undo(done.run)
    assert catalogue(base) == after
    second = base.add(again, settings=AddSettings(prefix="studio2/"))
    assert second.known == (("studio2/ana/jump_1", "ana/jump_1"),)


def test_a_change_is_not_taken_back_where_a_later_one_would_be_lost(base: MotionDB) -> None:
    words = base.words.set("ana/bow_1", "a bow").run_id
    later = base.words.set("ana/bow_1", "two bows").run_id
    with pytest.raises(QueryError) as error:
        base.undo(words)
    assert str(error.value) == (
        f"run {words} (words): expected captures that nothing has changed since, found that run "
        f"{later} (words) changed some. Undo that one first."
    )
    base.undo(later)
    base.undo(words)
    assert base.words.captions("ana/bow_1") == ()
    kinds = [(v.kind, [c.words for c in v.words]) for v in base.words.history("ana/bow_1")]
    bows = [("words", ["a bow"]), ("words", ["two bows"]), ("undo", ["a bow"]), ("undo", [])]
    assert kinds == [("add", []), *bows]
    with pytest.raises(QueryError, match="found one that was undone"):
        base.undo(words)


def test_a_change_before_one_that_cannot_be_undone_stays(base: MotionDB) -> None:
    earlier = base.captures.set_tags({"mood": "glad"}, ["ana/jump_1"])
    words = base.words.set("ana/bow_1", "a bow").run_id
    number = base.captures("name=ana/bow_1")[0].capture_id
    with updating.changing(base.store, "scene remove", {}, [number]):  # as of a player of a scene
        store.remove_captures(base.store, [number])
    with pytest.raises(QueryError) as error:
        base.undo()
    assert str(error.value) == (
        f"run {words} (words): expected captures that nothing has changed since, found that run "
        f"{words + 1} (scene remove) changed some. That cannot be undone. motiondb undo {words - 1}"
        " takes back the change before."
    )
    assert list(base.undo(words - 1).changed) == earlier


def test_names_that_are_taken_are_refused(base: MotionDB) -> None:
    with pytest.raises(QueryError, match=r"^ana/jump_1: expected a name that is free"):
        base.captures.rename("ana/bow_1", "ana/jump_1")
    with pytest.raises(QueryError, match=r"Give 'new/'"):
        base.captures.rename("ana/", "new")
    with pytest.raises(QueryError, match=r"^'bow': expected a pattern with one '\*'"):
        base.captures.rename("ana/*", "bow")
    with pytest.raises(QueryError, match=r"^'a\*b': expected a name without '\*', found one"):
        base.captures.rename("ana/bow_1", "a*b")
    with pytest.raises(QueryError, match="found no capture that fits"):
        base.captures.rename("ana/*", "bow_*", ["boris/kick_1"])
    with pytest.raises(QueryError, match="Did you mean boris/"):
        base.captures.rename("borys/", "new/")
    for key in ("Start", "duration", "license", "a=b"):
        with pytest.raises(QueryError, match="expected the name of a tag"):
            base.captures.set_tags({key: "x"}, ["ana/bow_1"])


def test_a_removed_capture_that_comes_back_is_counted_again(learned_copy: Path) -> None:
    with motiondb.open(learned_copy) as db:
        before = [(m.capture, m.score) for m in db.search("bow").matches]
        db.captures.remove(where="performer=ana")
        assert not any(m.capture.startswith("ana/") for m in db.search("bow").matches)
        db.undo()
        after = [(m.capture, m.score) for m in db.search("bow").matches]
        assert [name for name, _ in after] == [name for name, _ in before]
        scores = [score for _, score in before]  # learn cuts a little otherwise than add
        assert [score for _, score in after] == pytest.approx(scores, abs=0.01)
        assert db.check() == []


def test_files_of_known_content_are_noted(base: MotionDB, some: Path) -> None:
    same = some / "boris" / "again.bvh"
    shutil.copy(some / "ana" / "bow_1.bvh", same)
    base.add(some)
    (noted,) = base.captures.same_files()
    assert (noted.path, noted.capture) == (str(same), "ana/bow_1")
    assert base.captures.show("ana/bow_1").copies == [f"{same} is the same file"]
    base.captures.remove(["ana/bow_1"])
    assert base.captures.same_files() == []
    base.undo()
    assert base.captures.same_files() == [noted]
    assert base.check() == []


def test_faulty_files_are_noted_until_they_are_mended(base: MotionDB, some: Path) -> None:
    good = some / "ana" / "bow_1.bvh"
    bad = some / "boris" / "bad.bvh"
    bad.write_text("nothing")
    base.add(some)
    (fault,) = base.captures.faulty_files()
    assert (fault.path, "expected a ROOT joint" in fault.problem) == (str(bad), True)
    base.add(good)  # says nothing about others
    assert base.captures.faulty_files() == [fault]
    bad.unlink()
    base.add(some)
    assert base.captures.faulty_files() == []


def test_content_that_was_removed_twice_is_brought_back(base: MotionDB, some: Path) -> None:
    before = catalogue(base)
    base.captures.remove(["ana/bow_1"])
    base.add(some)
    base.captures.remove(["ana/bow_1"])
    base.undo()  # the second removal
    assert "ana/bow_1" in {info.name for info in base.captures()}
    base.undo()  # the adding
    base.undo()  # the first removal
    assert catalogue(base) == before
    assert base.check() == []


def test_an_undoing_of_an_earlier_change_counts_as_later(base: MotionDB) -> None:
    for value in ("1", "2"):
        base.captures.set_tags({"a": value}, ["ana/bow_1"])
    first = base.undo().run
    second = base.undo().run
    with pytest.raises(QueryError, match=rf"found that run {second} \(undo\) changed some"):
        base.undo(first)
    base.undo(second)
    base.undo(first)
    (info,) = base.captures("name=ana/bow_1")
    assert info.tags["a"] == "2"


def test_a_name_that_is_taken_since_is_not_given_back(base: MotionDB) -> None:
    base.captures.rename("ana/bow_1", "ana/bowing")
    run = base.session.store.connection.execute("SELECT max(run_id) FROM edit").fetchone()[0]
    base.captures.rename("ana/jump_1", "ana/bow_1")
    with pytest.raises(QueryError, match="expected the name to be free"):
        base.undo(run)


def test_compacting_makes_removals_final(base: MotionDB) -> None:
    base.captures.set_tags({"a": "1"}, ["ana/bow_1"])
    base.captures.remove(["boris/kick_1"])
    path = base.store.path
    base.close()
    motiondb.compact(path)
    with motiondb.open(path) as db:
        with pytest.raises(QueryError, match=r"motiondb undo (\d+) takes back") as refused:
            db.undo()
        assert "found that it was emptied" in str(refused.value)
        run = int(str(refused.value).split("motiondb undo ")[1].split()[0])
        assert db.undo(run).changed == ("ana/bow_1",)


def test_a_file_that_repeats_another_capture_replaces_nothing_and_says_so(
    base: MotionDB, tmp_path: Path, samples_folder: Path
) -> None:
    again = tmp_path / "again"
    (again / "ana").mkdir(parents=True)
    shutil.copy(samples_folder / "ana" / "jump_1.bvh", again / "ana" / "bow_1.bvh")
    report = base.add(again, settings=AddSettings(replace=True))
    assert report.added == ()
    assert "ana/bow_1 was not replaced" in report.problems[0]


def test_known_files_are_read_in_another_way_by_replace_alone(
    base: MotionDB, tmp_path: Path, samples_folder: Path
) -> None:
    shutil.copytree(samples_folder / "ana", tmp_path / "again" / "ana")
    kept = base.add(tmp_path / "again", settings=AddSettings(fps=60.0))
    before = catalogue(base)
    assert kept.replaced == ()
    assert "--replace reads them in another way" in kept.notes[0]
    for _ in range(2):  # whether or not the way is noted
        report = base.add(tmp_path / "again", settings=AddSettings(fps=60.0, replace=True))
        assert "ana/jump_1" in report.replaced
        assert base.captures("name=ana/jump_1")[0].fps == 60.0
        assert [c.words for c in base.words.captions("ana/jump_1")] == ["she jumps"]
    base.undo()
    base.undo()
    assert catalogue(base) == before
    assert base.check() == []


def test_synonyms_are_taken_back_before_what_was_changed_before_them(
    base: MotionDB, tmp_path: Path
) -> None:
    table = tmp_path / "synonyms.txt"
    for text in ("hop = jump\n", "leap = jump\n"):
        table.write_text(text)
        base.words.set_synonyms(table)
    assert base.undo().changed == ("synonyms",)
    assert motiondb.store.load_synonyms(base.store) == {"hop": "jump"}
    done = base.undo()
    assert motiondb.store.load_synonyms(base.store) == {}
    base.undo(done.run)
    assert motiondb.store.load_synonyms(base.store) == {"hop": "jump"}
    assert base.words.captions("ana/jump_1")[0].words == "she jumps"
    assert base.check() == []


def test_the_history_of_words_goes_on_through_a_replacement(
    base: MotionDB, tmp_path: Path, samples_folder: Path
) -> None:
    again = tmp_path / "again"
    (again / "ana").mkdir(parents=True)
    shutil.copy(samples_folder / "boris" / "idle_1.bvh", again / "ana" / "jump_1.bvh")
    base.add(again, settings=AddSettings(replace=True))
    base.words.set("ana/jump_1", "she waits")
    said = [(v.kind, [c.words for c in v.words]) for v in base.words.history("ana/jump_1")]
    assert said == [
        ("add", []), ("words", ["she jumps"]), ("add", ["she jumps"]), ("words", ["she waits"])
    ]  # fmt: skip


def test_a_sheet_without_words_keeps_them(base: MotionDB, tmp_path: Path) -> None:
    sheet = tmp_path / "tags.tsv"
    sheet.write_text("file\tmood\nana/jump_1\thappy\n")
    assert base.words.import_sheet(sheet) == ImportReport(1)
    assert [c.words for c in base.words.captions("ana/jump_1")] == ["she jumps"]
    assert base.captures("mood=happy")[0].name == "ana/jump_1"


def test_a_tag_named_like_a_word_of_filters_is_quoted_there(base: MotionDB) -> None:
    base.captures.set_tags({"in": "yes"}, ["ana/jump_1"])
    assert [info.name for info in base.captures('"in"=yes and not "in"=no')] == ["ana/jump_1"]
    with pytest.raises(QueryError, match="characters that can be printed"):
        base.captures.set_tags({"mood": "a\tb"}, ["ana/jump_1"])


@pytest.mark.parametrize("order", [(False, True), (True, False), (False, False, True, False)])
def test_an_original_is_never_lost_to_one_that_was_left_out(
    tmp_path: Path, some: Path, order: tuple[bool, ...]
) -> None:
    file = some / "ana" / "jump_1.bvh"
    with motiondb.open(tmp_path / "m.duckdb") as db:
        for originals in order:
            db.add(file, settings=AddSettings(originals=originals))
            db.captures.remove(["jump_1"])
        db.undo()
        (back,) = db.captures()
        assert store.load_source(db.store, back.capture_id).data == file.read_bytes()
        assert db.check() == []


def test_check_names_a_capture_that_lost_its_original(base: MotionDB) -> None:
    base.store.connection.execute("UPDATE source SET data = '' WHERE file_name = 'jump_1.bvh'")
    assert base.check() == [
        "ana/jump_1: expected the bytes of its file, which it was added with (motiondb add FILE "
        "fills them in), found others."
    ]


@pytest.mark.parametrize("way", ["add", "replace", "merge"])
def test_an_original_that_is_missing_is_filled_in(
    tmp_path: Path, some: Path, base: MotionDB, way: str
) -> None:
    name = "ana/jump_1"
    with motiondb.open(tmp_path / "without.duckdb") as db:
        db.add(some, settings=AddSettings(originals=False))
        db.words.set(name, "she jumps")
        if way == "merge":
            base.close()
            changed = db.merge(tmp_path / "motions.duckdb").changed
            assert set(changed) == {info.name for info in db.captures()}
            assert db.merge(tmp_path / "motions.duckdb").changed == ()
        else:
            report = db.add(some, settings=AddSettings(replace=way == "replace"))
            assert f"{name}: its file, which was left out, is kept now" in report.notes
            assert report.added == ()
            assert db.runs()[-1]["kind"] == "add"
            assert db.add(some).notes == ()
        number = db.captures(f"name={name}")[0].capture_id
        assert store.load_source(db.store, number).data == (some / f"{name}.bvh").read_bytes()
        assert db.words.captions(name)[0].words == "she jumps"
        assert db.check() == []
