"""A small scene polished whole: a pass, a catch, a shot, by bodies that stand and glide."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from motiondb.body import body, retarget, rotation
from motiondb.grammar.cfg.parse import parse
from motiondb.records import Event, Motion
from motiondb.scene.clips.clip_cutting import ShownMotion
from motiondb.scene.clips.clips import VariantSettings, make_library
from motiondb.scene.energy.binding import bind
from motiondb.scene.energy.energy import CONTACT_RADIUS
from motiondb.scene.energy.scene_arrays import PlayerState, SceneState
from motiondb.scene.language.grammar_file import read_motion_grammar
from motiondb.scene.language.tactics_file import read_diagram
from motiondb.scene.polish import polish as polishing
from motiondb.scene.polish.facing import MOST_YAW, follow
from motiondb.scene.polish.polish import polish
from motiondb.scene.report.scene_report import report_scene
from motiondb.scene.thing.thing_flight import REACHING, palms, reach
from motiondb.scene.timing.scene_schedule import schedule_scene

GRAMMAR = read_motion_grammar(
    """
    grammar short
    start S_A for attack
    place rim at 0 0 height 3.05 m size 45 cm
    object ball
    rest idle
    rest hold with ball
    hold: keep(ball)
    shoot: send(ball, rim)
    S_A -> M B | B | B M
    M -> run | run M
    B -> hold pass | catch shoot | idle
    run := "run"
    hold := "hold"
    pass := "pass" event release
    catch := "catch" event catch
    shoot := "shoot" event release
    idle := "idle"
    pass: direction(receiver), synchronisation(receiver, catch, flight)
    shoot: direction(rim), distance(rim, > 1.5 m)
    """,
    "short.grammar",
)
DIAGRAM = read_diagram(
    'diagram "short"\ngrammar short\ncourt half\nattack A1 at 0 7\nattack A2 at 3 4\n'
    "1 pass A1 to A2\n2 shoot A2\n",
    "short.tactics",
    GRAMMAR.activity,
)
INSTANTS = {"pass": "release", "catch": "catch", "shoot": "release"}


def posed(frames: int, speed: float = 0.0, apart: float = 0.0) -> Motion:
    """A body, both arms ahead (``apart``: turned out by so many radians), that glides along z."""
    local = np.tile(rotation.IDENTITY, (frames, len(body.JOINTS), 1))
    for joint, sign in (("l_shoulder", -1.0), ("r_shoulder", 1.0)):
        turn = rotation.from_axis_angle([0.0, 1.0, 0.0], sign * (math.pi / 2.0 - apart))
        local[:, body.INDEX[joint]] = turn
    root = np.zeros((frames, 3))
    root[:, 1] = body.LEG_LENGTH + body.ANKLE_HEIGHT
    root[:, 2] = np.arange(frames) * speed / 30.0
    return Motion(local.astype(np.float32), root.astype(np.float32), body.LEG_LENGTH)


MOTIONS = {
    name: posed(50, 2.0 if name == "run" else 0.0, 0.9 if name in ("idle", "hold") else 0.0)
    for name in ("run", "hold", "pass", "catch", "shoot", "idle")
}


@pytest.fixture(scope="module")
def library():
    shown = [
        ShownMotion(
            name, name, motion, 0, 50, INSTANTS.get(name, ""),
            (Event(25, INSTANTS[name], "r_wrist", "ball"),) if name in INSTANTS else (), "CC0",
        )
        for name, motion in MOTIONS.items()
    ]  # fmt: skip
    plain = VariantSettings((0.0,), (1.0,), (0.0,), (0.0,), mirror=False)
    return make_library(shown, [terminal.name for terminal in GRAMMAR.terminals], plain)


def scene(library, delays=(3, 60), origins=((0.2, 7.1, 2.6), (2.7, 4.2, 2.0))):
    strings = ("hold pass", "run catch shoot")
    trees = [parse(GRAMMAR.started(), string.split()) for string in strings]
    table = bind(DIAGRAM, GRAMMAR, trees)
    players = tuple(
        PlayerState(tree, np.array([library.of(a)[0] for a in tree.leaves()]), origin, delay)
        for tree, origin, delay in zip(trees, origins, delays, strict=True)
    )
    return SceneState(players), table


@pytest.fixture(scope="module")
def made(library):
    state, table = scene(library)
    return state, table, polish(state, library, MOTIONS, table)


@pytest.fixture(scope="module")
def told(library, made):
    return report_scene(made[0], library, MOTIONS, made[1], made[2])


def test_every_rule_holds_that_did_not(told) -> None:
    before = [rule for rule in told.rules if rule.before > rule.threshold]
    assert {rule.kind for rule in before} >= {"synchronisation", "direction"}
    assert told.clean, told.broken
    assert told.n_characters == 2
    assert told.n_instances == 5


def test_nobody_moves_faster_than_the_limit(told) -> None:
    assert [pace.player for pace in told.paces] == ["A1", "A2"]
    assert told.paces[1].before == pytest.approx(2.0, abs=0.05)  # gliding
    assert max(pace.after for pace in told.paces) < 4.0


def test_bones_keep_their_lengths(told) -> None:
    assert told.bone_error < 1e-5


def test_the_report_names_units_and_who_is_meant(told) -> None:
    (meets,) = [rule for rule in told.rules if rule.kind == "synchronisation"]
    assert (meets.player, meets.action, meets.about) == ("A1", "pass", "A2 catch")
    assert (meets.unit, meets.threshold) == ("frames", pytest.approx(2.0))
    (far,) = [rule for rule in told.rules if rule.kind == "distance"]
    assert (far.unit, far.about, far.after) == ("m", "(0, 0), >= 1.5 m", 0.0)


def test_every_frame_has_its_capture_and_licence(made, told) -> None:
    for placed in made[2].players:
        n_frames = placed.motion.n_frames
        assert n_frames == made[2].timeline.n_frames
        assert {len(placed.source_numbers), len(placed.edits), len(placed.warps)} == {n_frames}
        assert set(placed.licences) == {"CC0"}
        assert (placed.source_frames >= 0.0).all()
        assert (placed.source_frames < 50.0).all()
    runs = [run for run in told.sources if run.player == "A1"]
    assert runs[0].start == 0
    assert all(a.end == b.start for a, b in pairwise(runs))
    assert any("waits" in run.edit for run in runs)


def test_edits_name_hands_at_the_ball_and_heads_that_turn(library, made) -> None:
    state, table, out = made
    for number, placed in enumerate(out.players):
        hands = np.array(["hands brought to the ball" in e.split(", ") for e in placed.edits])
        heads = np.array(["head turned" in e.split(", ") for e in placed.edits])
        holds = np.flatnonzero(out.ball.holder == number)
        assert hands[holds].any()
        apart = np.abs(np.arange(len(hands))[:, None] - holds).min(axis=1)
        assert not hands[apart > REACHING].any()
        assert heads.any()
    plain = polish(state, library, MOTIONS, table, gaze=False)
    assert not any("head turned" in edit for placed in plain.players for edit in placed.edits)


def test_the_ball_is_in_hands_from_catch_to_release(made) -> None:
    ball, timeline = made[2].ball, made[2].timeline
    release, catch = timeline.instants[0][1], timeline.instants[1][1]
    shot = timeline.instants[1][2]
    assert set(ball.holder[: release + 1].tolist()) == {0}
    assert set(ball.holder[release + 1 : catch].tolist()) == {-1}
    assert set(ball.holder[catch : shot + 1].tolist()) == {1}
    assert np.nanmax(ball.gap) < 0.16
    steps = np.linalg.norm(np.diff(ball.positions, axis=0), axis=1)
    assert steps.max() < 0.6  # 18 m/s: it never leaps


def test_hands_come_to_a_ball_that_they_do_not_have(made) -> None:
    joints, _ = retarget.motion_positions(made[2].players[0].motion)
    both = palms(joints)[10]  # arms are spread in the capture
    assert np.linalg.norm(both - made[2].ball.positions[10], axis=1).max() < 0.16


def test_a_shot_goes_through_the_ring_and_down(made) -> None:
    ball = made[2].ball.positions[made[2].timeline.instants[1][2] :]
    through = np.linalg.norm(ball - np.array([0.0, 3.05, 0.0]), axis=1).min()
    assert through < 0.3  # nearest frame
    assert ball[:, 1].max() > 3.05
    assert ball[-1, 1] >= 0.12


def test_the_same_scene_polishes_to_the_same_bytes(library, made) -> None:
    again = polish(*scene(library)[:1], library, MOTIONS, made[1])
    for one, other in zip(made[2].players, again.players, strict=True):
        assert one.motion.local_rotations.tobytes() == other.motion.local_rotations.tobytes()
    assert made[2].ball.positions.tobytes() == again.ball.positions.tobytes()


def test_two_on_one_spot_are_pushed_apart_or_told(library) -> None:
    state, table = scene(library, origins=((0.2, 7.1, 2.6), (0.3, 7.0, 2.0)))
    out = polish(state, library, MOTIONS, table)
    report = report_scene(state, library, MOTIONS, table, out)
    assert report.collisions_before
    assert report.collisions == ()


def test_meetings_that_no_pace_allows_are_reported(library) -> None:
    state, table = scene(library)
    hasty = replace(state.players[1], entries=state.players[1].entries)
    rows = table.rows.copy()
    twice = np.concatenate([rows, rows[rows["kind"] == 2]])
    twice[-1]["lag"] = 3.0  # the same catch, three seconds after the pass
    doubled = replace(table, rows=twice, rules=(*table.rules, table.rules[0]))
    doubled = replace(doubled, items=np.append(table.items, -1))
    out = polish(SceneState((state.players[0], hasty)), library, MOTIONS, doubled)
    report = report_scene(state, library, MOTIONS, doubled, out)
    assert any(rule.kind == "synchronisation" or rule.unit == "frames" for rule in report.broken)
    assert not report.clean


def test_alone_and_without_a_ball_poses_are_held_where_nobody_can_wait() -> None:
    grammar = read_motion_grammar('grammar go\nstart S\nS -> run | run S\nrun := "run"\n', "go")
    diagram = read_diagram(
        'diagram "go"\ngrammar go\ncourt 9 x 9\nplayer P at 0 1\n1 run P to 0 3\n', "go"
    )
    shown = [ShownMotion("run", "run", MOTIONS["run"], 0, 50, "", (), "")]
    library = make_library(shown, ["run"], VariantSettings(mirror=False))
    tree = parse(grammar.started(), ["run"])
    state = SceneState((PlayerState(tree, np.array([0]), (0.0, 1.0, 0.5), 0),))
    table = bind(diagram, grammar, [tree])
    out = polish(state, library, MOTIONS, table)
    assert out.ball is None
    report = report_scene(state, library, MOTIONS, table, out)
    assert report.clean
    assert math.isnan(report.ball_gap)
    assert out.players[0].motion.n_frames == out.timeline.begins[0][-1]


def test_reach_brings_palms_and_keeps_bones() -> None:
    motion = posed(5, apart=0.6)
    target = np.tile(np.array([[0.1, 1.2, 0.35], [-0.1, 1.2, 0.35]]), (5, 1, 1))
    weights = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 0.5], [0.0, 1.0]])
    joints, _ = retarget.motion_positions(reach(motion, target, weights))
    there = np.linalg.norm(palms(joints) - target, axis=2)
    assert there[2].max() < 1e-3
    assert (there[1, 0], there[4, 1]) == pytest.approx((0.0, 0.0), abs=1e-3)
    before, _ = retarget.motion_positions(motion)
    np.testing.assert_allclose(joints[0], before[0], atol=1e-6)
    halfway = (palms(before)[3] + target[3]) / 2.0
    np.testing.assert_allclose(palms(joints)[3], halfway, atol=1e-3)


def test_heads_turn_to_the_ball_as_far_as_necks_do() -> None:
    motion = posed(60)
    ball = np.tile(np.array([0.0, 1.6, 5.0]), (60, 1))
    _, ahead = retarget.motion_positions(follow(motion, ball))
    ball[:] = [5.0, 1.6, 0.5]
    _, aside = retarget.motion_positions(follow(motion, ball))
    nose = [rotation.rotate(w[30, body.INDEX["head"]], np.array([0.0, 0.0, 1.0])) for w in
            (ahead, aside)]  # fmt: skip
    assert np.arctan2(nose[0][0], nose[0][2]) == pytest.approx(0.0, abs=1e-6)
    assert np.arctan2(nose[1][0], nose[1][2]) == pytest.approx(MOST_YAW, abs=0.02)


def each_way_anew(state, library, table):
    """The slow twin of the search for the best way: nothing is kept from one to the next."""
    tried = []
    for frame_cost, *how in polishing._WAYS:
        scheduled = schedule_scene(state, library, table, frame_cost)
        spliced = polishing._spliced(state, library, MOTIONS, scheduled, {}, table.activity)
        way = (*how, CONTACT_RADIUS)
        maps, edited = polishing._edit(state, library, table, (scheduled, spliced), way)
        tried.append((polishing._fault(table, edited), spliced, maps, edited))
        if tried[-1][0] == 0.0:
            break
    return min(tried, key=lambda one: one[0]), len(tried)


@pytest.mark.parametrize("fastest", [7.0, 0.5])
def test_what_ways_have_in_common_changes_nothing(library, monkeypatch, fastest) -> None:
    monkeypatch.setattr(polishing, "_FASTEST", fastest)  # 0.5: nobody can hold it, in no way
    state, table = scene(library, (3, 120))
    (fault, spliced, maps, edited), ways = each_way_anew(state, library, table)
    assert ways == (1 if fastest == 7.0 else len(polishing._WAYS))
    best = polishing._best(state, library, MOTIONS, table)
    assert best.fault == fault
    np.testing.assert_array_equal(best.edited.timeline.places, edited.timeline.places)
    for mine, other in zip(best.maps, maps, strict=True):
        np.testing.assert_array_equal(mine.shown, other.shown)
    for mine, other in zip(best.spliced, spliced, strict=True):
        for name in ("places", "heights", "rotations", "part", "source_frames", "contacts"):
            np.testing.assert_array_equal(getattr(mine, name), getattr(other, name))
