"""Scenes from diagram to folder and store, on the sample data: small and quick ones."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain, repeat
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import motiondb
from motiondb import store
from motiondb.body import kinematics, retarget
from motiondb.database.scenes import scene_folder, scene_making, scene_records
from motiondb.database.scenes.scene_records import (
    action_captions,
    from_json,
    record_state,
    record_text,
    to_json,
)
from motiondb.database.scenes.scene_texts import (
    GRAMMAR,
    TACTICS,
    read_scene_text,
    shipped,
    shipped_text,
    stored_text,
)
from motiondb.database.scenes.scenes import Scene, SceneSettings
from motiondb.errors import MotionDBError, QueryError, SceneError
from motiondb.files.formats import read_capture
from motiondb.files.safe_files import whole_folder
from motiondb.grammar.cfg.context_free import Tree
from motiondb.scene.clips.clips import ClipSource
from motiondb.scene.polish.polish import PolishedScene
from motiondb.store import SceneClip

DIAGRAM = """diagram "Two"
grammar basketball
attack A1 at 0 7
attack A2 at -3.5 5
1 pass A1 to A2
2 shoot A2
"""
PIPED: dict[str, Any] = {"capture_output": True, "text": True, "check": True}
DEEDS = "keep|bounce|take|give|send|put"
QUICK = SceneSettings(seed=2, rounds=2, chains=1, tries=1)


@dataclass
class Made:
    """A scene, its folder and its database."""

    scene: Scene
    folder: Path
    diagram: Path
    file: Path


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory, learned_file: Path) -> Made:
    folder = tmp_path_factory.mktemp("scenes")
    diagram = folder / "two.tactics"
    diagram.write_text(DIAGRAM)
    with motiondb.open(learned_file, read_only=True) as db:
        scene = db.scenes.make(diagram, QUICK)
        db.scenes.write(scene, folder / "two", drawn=False)
    return Made(scene, folder / "two", diagram, learned_file)


@pytest.fixture
def writable(learned_copy: Path) -> Iterator[motiondb.MotionDB]:
    with motiondb.open(learned_copy) as db:
        yield db


def test_everybody_does_what_the_diagram_asks(made: Made) -> None:
    actions = {p.name: [c.terminal for c in p.clips] for p in made.scene.record.players}
    assert "pass" in actions["A1"]
    assert actions["A2"].index("catch") < actions["A2"].index("shoot")
    assert made.scene.record.name == "Two"
    assert made.scene.record.n_frames == len(made.scene.record.ball)


def test_the_folder_is_complete(made: Made) -> None:
    assert sorted(path.name for path in made.folder.iterdir()) == [
        "A1.bvh", "A1.bvh.provenance.json", "A2.bvh", "A2.bvh.provenance.json",
        "basketball.grammar", "diagram.tactics", "report.json", "report.txt", "scene.glb",
        "scene.json",
    ]  # fmt: skip
    assert (made.folder / "diagram.tactics").read_text() == DIAGRAM
    assert [p.name for p in made.folder.parent.iterdir() if p.name.startswith(".")] == []


def test_the_files_together_are_the_scene(made: Made) -> None:
    for placed in made.scene.made.polished.players:
        clip = read_capture(made.folder / f"{placed.player}.bvh")
        actual, _ = kinematics.clip_positions(clip)
        wanted, _ = retarget.motion_positions(placed.motion)
        np.testing.assert_allclose(actual, wanted, atol=2e-4)
        at = made.scene.made.text.diagram.player[placed.player].at
        assert np.hypot(actual[0, 0, 0] - at.x, actual[0, 0, 2] - at.z) < 2.0


def test_every_frame_has_a_source_and_a_licence(made: Made) -> None:
    for name in ("A1", "A2"):
        facts = json.loads((made.folder / f"{name}.bvh.provenance.json").read_text())
        runs = facts["frames"]
        assert [run["start"] for run in runs[1:]] == [run["end"] for run in runs[:-1]]
        assert (runs[0]["start"], runs[-1]["end"]) == (0, made.scene.record.n_frames)
        assert sum(source["frames"] for source in facts["sources"]) == runs[-1]["end"]
        assert {source["licence"] for source in facts["sources"]} == {"CC0-1.0"}


def test_waiting_and_what_was_left_out_are_told_apart() -> None:
    edits = ("waits, feet held",) * 2 + ("feet held",) * 6
    origin = store.Provenance(
        (store.SourceCapture("a", "", "CC0"), store.SourceCapture("b", "", "CC0")),
        np.array([0, 0, 0, 0, 0, 0, 1, 1]),
        np.array([8.0, 7.0, 30.0, 31.3, 60.0, 61.0, 61.0, 62.0]),
        np.ones(8),
        edits,
    )
    diagram = SimpleNamespace(players=[SimpleNamespace(name="A1")])
    players = [SimpleNamespace(tree=Tree("S", 0, (Tree("hold"), Tree("pass"))))]
    made: Any = SimpleNamespace(
        text=SimpleNamespace(diagram=diagram), state=SimpleNamespace(players=players)
    )
    clips = np.array([0, 0, 0, 0, 0, 0, 1, 1])
    runs = scene_folder.action_runs(clips, made, "A1", origin)
    told = [(run["start"], run["end"], run["action"], run["source_start"]) for run in runs]
    assert told == [(0, 2, "hold", 8.0), (2, 4, "hold", 30.0), (4, 6, "hold", 60.0),
                    (6, 8, "pass", 61.0)]  # fmt: skip
    assert ["waits" in run["edits"] for run in runs] == [True, False, False, False]
    placed: Any = SimpleNamespace(clips=clips, edits=edits)
    said = [(c.words, c.start, c.end) for c in action_captions(placed, ("hold", "pass"))]
    assert said == [("hold", 2 / 30, 6 / 30), ("pass", 6 / 30, 8 / 30)]


def test_the_report_tells_every_rule(made: Made) -> None:
    facts = json.loads((made.folder / "report.json").read_text())
    assert len(facts["by_rule"]) == facts["rules"] == len(made.scene.record.rules)
    for row in facts["by_rule"]:
        assert row["kept"] == (row["after"] <= row["threshold"] + 1e-3)
    assert facts["broken"] == len(made.scene.broken)
    text = (made.folder / "report.txt").read_text()
    assert text.count("BROKEN") == facts["broken"]
    assert "licence CC0-1.0" in text


def test_the_record_comes_back(made: Made) -> None:
    record = scene_folder.read_scene_folder(made.folder)
    again = from_json(to_json(record), "again")
    np.testing.assert_allclose(again.ball, made.scene.record.ball, atol=1e-4)
    assert replace(again, ball=record.ball).__dict__ == record.__dict__
    state = record_state(record, record_text(record), made.scene.made.clips.library)
    for one, other in zip(state.players, made.scene.made.state.players, strict=True):
        assert one.tree == other.tree
        np.testing.assert_array_equal(one.entries, other.entries)
        assert (one.origin, one.delay) == (tuple(other.origin), other.delay)


def test_a_small_change_keeps_who_is_not_touched(made: Made, tmp_path: Path) -> None:
    changed = tmp_path / "changed.tactics"
    changed.write_text(DIAGRAM.replace("-3.5 5", "-3.2 5.2"))
    with motiondb.open(made.file, read_only=True) as db:
        scene = db.scenes.update(db.scenes.find(made.folder), changed)
    assert scene.record.name == "Two"
    assert scene.record.diagram == changed.read_text()
    assert scene.made.text.diagram.player["A2"].at.x == -3.2
    for player in scene.record.players:
        assert {"A1": "pass", "A2": "shoot"}[player.name] in [c.terminal for c in player.clips]


def test_a_first_motion_is_shown_and_changes_nothing_of_the_scene(made: Made) -> None:
    shown: list[PolishedScene] = []
    with motiondb.open(made.file, read_only=True) as db:
        scene = db.scenes.make(made.diagram, QUICK, shown=shown.append)
    (first,) = shown
    assert [one.player for one in first.players] == ["A1", "A2"]
    for one, other in zip(scene.made.polished.players, made.scene.made.polished.players):
        np.testing.assert_array_equal(one.motion.local_rotations, other.motion.local_rotations)


@pytest.mark.parametrize(
    ("seconds", "cut_short"),
    [([], False), ([0.0, 0.0], True)],  # when it began; 1000 s later, after the first round
)
def test_a_scene_tells_whether_time_ended_its_sampling(
    made: Made, monkeypatch: pytest.MonkeyPatch, seconds: list[float], cut_short: bool
) -> None:
    clock = chain(seconds, repeat(1000.0))
    monkeypatch.setattr(scene_making, "time", SimpleNamespace(monotonic=lambda: next(clock)))
    with motiondb.open(made.file, read_only=True) as db:
        timed = replace(QUICK, minutes=0.02)
        scene = db.scenes.update(db.scenes.find(made.folder), made.diagram, timed)
    assert (len(scene.made.trace.best) == 2) == cut_short  # the start and one round
    assert scene.record.report["cut_short"] is cut_short
    if cut_short:
        assert scene.record.report["cut_at"]["rounds"] == 1


@pytest.mark.parametrize(
    ("tries", "late", "cut_short"),
    [
        # of each try the rules broken and whether time ended it; after which time is up
        ([(0, False), (0, False)], 1, False),  # all is well: nothing was left out
        ([(1, False), (0, False)], 2, False),
        ([(1, False), (0, False)], 1, True),  # the second try was left out
        ([(1, False), (1, False)], 2, False),  # there was no third
        ([(1, False), (2, True)], 2, True),  # the best is the first, the second might have been
        ([(0, True), (0, False)], 1, True),
    ],
)
def test_time_that_ends_any_try_counts(
    made: Made,
    monkeypatch: pytest.MonkeyPatch,
    tries: list[tuple[int, bool]],
    late: int,
    cut_short: bool,
) -> None:
    scene, done = made.scene.made, []
    rule = replace(scene.report.rules[0], kept=False)

    def attempt(*_: object) -> scene_making.MadeScene:
        broken, ended = tries[len(done)]
        done.append(broken)
        rules = (rule,) * broken
        report = replace(scene.report, rules=rules, collisions=(), paces=(), impossible=())
        return replace(scene, report=report, cut_short=ended)

    clock = SimpleNamespace(monotonic=lambda: 100.0 * (len(done) >= late))
    monkeypatch.setattr(scene_making, "time", clock)
    monkeypatch.setattr(scene_making._Making, "attempt", attempt)
    settings = SceneSettings(minutes=1.0, tries=len(tries))
    actual = scene_making.make(scene.text, scene.clips, settings, lambda *_: None)
    assert actual.cut_short == cut_short
    assert len(actual.report.rules) == min(done)


def test_a_scene_is_kept_replaced_and_removed(made: Made, writable: motiondb.MotionDB) -> None:
    before = store.count_rows(writable.store)
    named = replace(made.scene, record=replace(made.scene.record, name="play"))
    for _ in range(2):  # the second takes the place of the first
        writable.scenes.keep(named)
    assert writable.scenes.names() == ["play"]
    assert [i.name for i in writable.captures() if i.kind == "generated"] == ["play/A1", "play/A2"]
    assert writable.check() == []
    kept = writable.scenes.load("play")
    info = next(i for i in writable.captures() if i.name == "play/A2")
    assert kept.players[1].capture_id == info.capture_id
    assert "shoot" in " ".join(
        c.words for c in store.load_captions(writable.store)[info.capture_id]
    )
    png = writable.scenes.draw("play", made.folder.parent / "play.png")
    assert png.stat().st_size > 10_000
    assert writable.scenes.remove("play") == ["play/A1", "play/A2"]
    after = store.count_rows(writable.store)
    # runs stay, and removed captures can be brought back
    left = {k: v for k, v in after.items() if k not in ("run", "edit") and "trash" not in k}
    assert left == {k: before[k] for k in left}


def test_folder_and_database_change_together(
    made: Made, writable: motiondb.MotionDB, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = store.count_rows(writable.store)
    whole = {**made.scene.record.report, "cut_short": False}
    named = replace(made.scene, record=replace(made.scene.record, name="play", report=whole))

    def lost(*_: object) -> None:
        raise QueryError("the database went away")

    with monkeypatch.context() as patched:
        patched.setattr(store, "save_scene", lost)
        with pytest.raises(QueryError, match="went away"):
            writable.scenes.write(named, tmp_path / "play", drawn=False, kept=True)
    assert store.count_rows(writable.store) == before
    assert list(tmp_path.glob("*play*")) == []
    writable.scenes.write(named, str(tmp_path / "play"), drawn=False, kept=True)
    assert writable.scenes.names() == ["play"]
    assert (tmp_path / "play" / "scene.json").is_file()

    writable.scenes.check_name("play", ["A1", "A2"])  # its own place may be taken
    writable.scenes.check_name("new", ["A1"])
    with pytest.raises(QueryError, match="ana/jump_1: expected a name that is free"):
        writable.scenes.check_name("ana", ["jump_1"])
    with pytest.raises(QueryError, match="expected a name for the scene"):
        writable.scenes.check_name(" ", ["A1"])

    text = writable.scenes.read_diagram(made.diagram)
    writable.scenes.check_new("play", text, QUICK)  # it is replaced
    writable.scenes.check_new("new", text, replace(QUICK, seed=QUICK.seed + 1))
    with pytest.raises(QueryError, match="new: expected a scene that is not kept yet, found the"):
        writable.scenes.check_new("new", text, QUICK)
    writable.set_words("ana/bow_1", "bow deeply")  # captions decide which clips there are
    writable.scenes.check_new("new", text, QUICK)


def test_a_scene_outlives_a_players_capture(made: Made, writable: motiondb.MotionDB) -> None:
    writable.scenes.keep(replace(made.scene, record=replace(made.scene.record, name="play")))
    writable.remove(["play/A1"])
    assert writable.check() == []
    assert [p.capture_id == -1 for p in writable.scenes.load("play").players] == [True, False]
    with pytest.raises(QueryError, match="captures of A1 were removed"):
        writable.scenes.draw("play", made.folder.parent / "gone.png")


def test_others_may_write_while_a_scene_is_made_and_its_captures_must_stay(
    made: Made, learned_copy: Path
) -> None:
    def rename_all(what: str, share: float, _error: float) -> None:
        if what == "sampling" and share == 0.0:
            with motiondb.open(learned_copy, wait=10.0) as other:
                other.rename("ana/", "anna/")
                other.rename("boris/", "bob/")

    with (
        motiondb.open(learned_copy, read_only=True) as db,
        pytest.raises(SceneError, match=r"^two: expected the captures of the scene to stay as"),
    ):
        db.scenes.make(made.diagram, QUICK, rename_all, "two")


def test_an_action_without_clips_is_named(made: Made, tmp_path: Path) -> None:
    text = (made.folder / "basketball.grammar").read_text()
    line = next(line for line in text.splitlines() if line.startswith("shoot :="))
    (tmp_path / "basketball.grammar").write_text(text.replace(line, 'shoot := "yodel"'))
    (tmp_path / "two.tactics").write_text(DIAGRAM)
    with (
        motiondb.open(made.file, read_only=True) as db,
        pytest.raises(SceneError, match=r"found none for a terminal: shoot \('yodel"),
    ):
        db.scenes.make(tmp_path / "two.tactics", QUICK)


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("", "a fault: Expecting value"),
        ("{}", "the format"),
        ('{"format": "other"}', "the format"),
        ("[" * 100_000, "at most 50 lists and objects within one another"),
    ],
)
def test_other_files_are_no_scenes(tmp_path: Path, text: str, error: str) -> None:
    (tmp_path / "scene.json").write_text(text)
    with pytest.raises(SceneError, match=f"expected a scene as motiondb.*{error}"):
        scene_folder.read_scene_folder(tmp_path)


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("name", {}, "a text for name, found an object"),
        ("diagram", 7, "a text for diagram, found a whole number"),
        ("grammar", [], "a text for grammar, found a list"),
        ("error", "low", "a number for error, found a text"),
        ("n_frames", None, "a whole number for n_frames, found null"),
        ("report", 7, "an object for report, found a whole number"),
        ("report", {"feet": 7}, "expected a record that can be reported, found"),
        (
            "settings",
            7,
            "expected a scene as motiondb scene make writes it, .*an object for settings",
        ),
        ("settings", {"chains": -3}, "expected a scene as .*chains: expected 1 to 64"),
        ("settings", {"wings": 2}, "expected a scene as .*wings"),
        ("players", [{"name": "A1"}], "expected a scene as .*a field 'team'"),
        ("rules", [[]], "an object for rules.0., found a list"),
        ("ball", {}, "a table of numbers for ball"),
    ],
)
def test_a_record_that_was_changed_is_refused(
    made: Made, tmp_path: Path, key: str, value: object, said: str
) -> None:
    facts = json.loads((made.folder / "scene.json").read_text())
    (tmp_path / "scene.json").write_text(json.dumps(facts | {key: value}))
    with pytest.raises(SceneError, match=f"scene.json: .*{said}"):
        scene_folder.read_scene_folder(tmp_path)


def test_another_players_record_does_not_go_on(made: Made, tmp_path: Path) -> None:
    facts = json.loads((made.folder / "scene.json").read_text())
    facts["players"][0]["name"] = "Z9"
    (tmp_path / "scene.json").write_text(json.dumps(facts))
    with (
        motiondb.open(made.file, read_only=True) as db,
        pytest.raises(SceneError, match="expected the player A1 of its diagram, found none"),
    ):
        db.scenes.update(db.scenes.find(tmp_path), made.diagram)


def test_nothing_is_overwritten_but_scenes(made: Made, tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("dear")
    with motiondb.open(made.file, read_only=True) as db:
        with pytest.raises(MotionDBError, match="found other files"):
            db.scenes.write(made.scene, tmp_path / "mine", drawn=False)
        with pytest.raises(MotionDBError, match="Make the folder first"):
            db.scenes.write(made.scene, tmp_path / "no" / "folder", drawn=False)
        db.scenes.write(made.scene, tmp_path / "two", drawn=False)
        (tmp_path / "two" / "scene.glb").unlink()
        db.scenes.write(made.scene, tmp_path / "two", drawn=False)
    assert (tmp_path / "two" / "scene.glb").is_file()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mine", "two"]


def test_what_killed_processes_left_is_put_right(made: Made, tmp_path: Path) -> None:
    """One was killed while it wrote, another between moving the old away and the new in place."""
    ended = subprocess.run([sys.executable, "-c", "import os; print(os.getpid())"], **PIPED)
    dead = int(ended.stdout)
    with whole_folder(tmp_path / "two", scene_folder.check_scene_folder) as part:
        (part / "scene.json").write_text("{}")
    (tmp_path / "two").rename(tmp_path / f".two.{dead}.old")
    (tmp_path / f".two.{dead}.part").mkdir()
    mine = tmp_path / f".two.{os.getppid()}.part"  # still at work
    mine.mkdir()
    check = scene_folder.check_scene_folder
    with pytest.raises(KeyboardInterrupt), whole_folder(tmp_path / "two", check):
        raise KeyboardInterrupt
    assert sorted(tmp_path.iterdir()) == [mine, tmp_path / "two"]
    assert (tmp_path / "two" / "scene.json").read_text() == "{}"


def test_nothing_half_is_left(made: Made, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with motiondb.open(made.file, read_only=True) as db:
        db.scenes.write(made.scene, tmp_path / "two", drawn=False)
        before = {p.name: p.read_bytes() for p in (tmp_path / "two").iterdir()}

        def full(*_: object) -> None:
            raise OSError(28, "No space left on device")

        monkeypatch.setattr(scene_folder, "report_text", full)
        with pytest.raises(MotionDBError, match="No space left"):
            db.scenes.write(made.scene, tmp_path / "two", drawn=False)
        with pytest.raises(MotionDBError, match="No space left"):
            db.scenes.write(made.scene, tmp_path / "new", drawn=False)
    assert {p.name: p.read_bytes() for p in (tmp_path / "two").iterdir()} == before
    assert [path.name for path in tmp_path.iterdir()] == ["two"]


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"chains": 0}, "chains: expected 1 to 64"),
        ({"minutes": 0.0}, "minutes: expected a number above 0"),
        ({"minutes": float("nan")}, "minutes: expected a number above 0"),
        ({"rounds": 0}, "rounds: expected at least 1"),
        ({"tries": 0}, "tries: expected at least 1"),
    ],
)
def test_settings_that_make_no_sense(settings: dict, said: str) -> None:
    with pytest.raises(SceneError, match=said):
        SceneSettings(**settings)


PLACES = st.tuples(
    st.sampled_from(["a", "b", "c"]), st.integers(0, 3000), st.integers(0, 3000), st.booleans(),
    st.sampled_from([-0.1, 0.0, 0.1]), st.sampled_from([0.9, 1.0]),
)  # fmt: skip


def library_of(places: list[tuple]) -> SimpleNamespace:
    source = tuple(ClipSource(*place) for place in places)
    return SimpleNamespace(terminals=("run",), of=lambda _: range(len(source)), source=source)


def kept_at(place: tuple) -> SceneClip:
    capture, *rest = place
    return SceneClip("run", capture, "", *rest)


@given(places=st.lists(PLACES, min_size=1, max_size=12), wanted=PLACES)
def test_the_most_similar_entry_is_that_of_a_search_through_all(places, wanted):
    clips = library_of(places)
    clip = kept_at(wanted)
    costs = [scene_records._unlike(source, clip) for source in clips.source]
    assert scene_records._entry(clips, clip) == int(np.argmin(costs))


def test_an_entry_that_is_there_is_found_itself():
    places = [("a", 0, 30, False, 0.0, 1.0), ("b", 0, 30, False, 0.0, 1.0)]
    assert scene_records._entry(library_of(places), kept_at(places[1])) == 1


def test_an_action_that_lost_its_clips_is_named():
    with pytest.raises(SceneError, match="run: expected clips of this action, found none"):
        scene_records._entry(library_of([]), kept_at(("a", 0, 30, False, 0.0, 1.0)))


def test_scenes_of_earlier_grammars_are_read_as_before() -> None:
    said = r"role|place|ground|mark|verb|object|rest"
    lines = shipped_text("basketball", GRAMMAR).replace(" when asked", "").splitlines()
    lines = [line for line in lines if not re.match(rf"({said}) |[a-z_, ]+: ({DEEDS})\(", line)]
    earlier = "\n".join([*lines, "place rim"])
    assert "verb" not in earlier
    for name in shipped(TACTICS):
        text = shipped_text(name, TACTICS)
        if "grammar basketball" in text:
            read, now = stored_text(text, earlier, name), read_scene_text(name)
            assert read.expressions == now.expressions
            assert set(read.grammar.only_asked) == set(now.grammar.only_asked)
    named = earlier.replace("grammar basketball", "grammar mine")
    with pytest.raises(SceneError, match="expected what is done"):
        stored_text(shipped_text("give-and-go", TACTICS), named, "mine")


def test_scenes_whose_texts_say_something_twice_open_as_before() -> None:
    """Earlier versions read a repeated alternative as a rule of its own, and numbered it."""
    said = """start S
        S -> wait | wait | walk S
        wait := "wait"
        walk := "walk"
        walk: position(bench) at end
        walk: position(bench) at end
        place bench
    """
    drawn = "plaec A at 0 0\nplayer B at 2 0\nplace bench at 1 1\n1 wait A\n1 wait A"
    read = stored_text(drawn, said, "mine")
    assert [one.player for one in read.diagram.elements] == ["A", "A"]
    grammar = read.grammar.grammar
    for rules in ((2, 1), (1, 0)):  # as it was kept: S -> walk S, S -> wait the second; and today
        tree = scene_records._tree(grammar, rules, ("walk", "wait"))
        assert tree is not None
        assert tree.leaves() == ("walk", "wait")
    assert scene_records._tree(grammar, (1, 0), ("wait", "walk")) is None
