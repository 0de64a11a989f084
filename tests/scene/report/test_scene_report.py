"""Which frames a rule looks at: a guard who keeps on while the opponent leaves is not looked at."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motiondb.body import body, retarget
from motiondb.grammar.cfg.parse import parse
from motiondb.records import Motion
from motiondb.scene.energy.binding import bind
from motiondb.scene.energy.scene_arrays import PlayerState, SceneState
from motiondb.scene.language.grammar_file import read_motion_grammar
from motiondb.scene.language.tactics_file import read_diagram
from motiondb.scene.report.report_records import JumpReport, LimbReport
from motiondb.scene.report.scene_report import _leaps, _rule, _touching
from motiondb.scene.report.seen import guard_reports, kept_reports, seen_faults
from motiondb.scene.report.visible_motion import (
    JUMP_LIMIT,
    STANDING,
    WAITING,
    FootJump,
    GaitRange,
    crossing_limbs,
    foot_jump,
    gait_range,
    impossible_gait,
    impossible_jump,
    limb_distances,
    near_limbs,
    on_the_ground,
    segment_distances,
    travel_speeds,
)
from motiondb.scene.thing.thing_flight import Ball, Sent
from motiondb.scene.timing.timeline import Timeline, guarded

GRAMMAR = read_motion_grammar(
    """
    grammar short
    start S for attack
    place rim at 0 0
    object ball
    rest hold with ball
    S -> hold guard pass | catch
    hold := "hold"
    guard := "guard"
    pass := "pass" event release
    catch := "catch" event catch
    guard: distance(rim, 0.5 m .. 2 m), direction(rim)
    pass: give(ball)
    catch: take(ball)
    pass: distance(rim, 0.5 m .. 2 m), synchronisation(receiver, catch, 0 s)
    """,
    "short.grammar",
)
DIAGRAM = read_diagram(
    'diagram "short"\ngrammar short\ncourt half\nattack A1 at 0 1\nattack A2 at 3 4\n'
    "1 pass A1 to A2\n",
    "short.tactics",
    GRAMMAR.activity,
)


@pytest.fixture(scope="module")
def rules():
    """A1 holds, guards in frames 40 to 126, waits, passes at 200; 1 m away, at 60 2.5 m."""
    trees = [parse(GRAMMAR.started(), string.split()) for string in ("hold guard pass", "catch")]
    table = bind(DIAGRAM, GRAMMAR, trees)
    places = np.zeros((2, 328, 3))
    places[0, :, 1] = 1.0
    places[0, 60, 1] = 2.5
    places[0, 127:180, 1] = 9.0  # behind the guard's own frames: no rule looks
    clips = [np.array([4, 40, 180, 328])], [np.array([20, 83, 200])], [np.array([40, 127, 328])]
    other = np.array([0, 328]), np.array([201]), np.array([328])
    begins, instants, ends = ((*clip, alone) for clip, alone in zip(clips, other, strict=True))
    timeline = Timeline(places, begins, instants, ends)
    actual = [_rule(table, number, timeline, timeline) for number in range(len(table.rows))]
    return {(rule.action, rule.kind): rule for rule in actual}


def test_throughout_looks_at_its_actions_own_frames(rules) -> None:
    guard = rules["guard", "distance"]
    assert (guard.start, guard.end) == (40, 127)  # 87 of 328
    assert guard.frame == 60
    assert guard.after == pytest.approx(0.5)  # and not the 7 m of frames 127 to 179
    assert not guard.kept
    facing = rules["guard", "direction"]
    assert (facing.start, facing.end) == (40, 127)
    assert facing.after == pytest.approx(180.0)


def test_an_instant_is_one_frame(rules) -> None:
    for kind in ("distance", "synchronisation"):
        assert (rules["pass", kind].start, rules["pass", kind].end) == (200, 201)
        assert rules["pass", kind].frame == 200
    assert rules["pass", "synchronisation"].after == pytest.approx(1.0)


def test_a_guards_distance_is_told_over_all_frames() -> None:
    grammar = read_motion_grammar(
        "grammar g\nstart S\nS -> guard | walk\nguard := 'guard'\nwalk := 'walk'\n".replace(
            "'", '"'
        )
        + "rest walk\nrest guard for guard\nguard: distance(opponent, 0.5 m .. 2 m)\n",
        "g.grammar",
    )
    diagram = read_diagram(
        'diagram "g"\ngrammar g\ncourt half\nattack A1 at 0 1\ndefence D1 at 0 2 guards A1\n',
        "g.tactics",
    )
    trees = [parse(grammar.started(), [action]) for action in ("walk", "guard")]
    table = bind(diagram, grammar, trees)
    places = np.zeros((2, 100, 3))
    places[1, :40, 1] = 1.5  # guards in frames 0 to 39, and then stays where A1 leaves
    places[1, 40:, 1] = 3.0
    places[1, 70, 1] = 4.5
    begins, instants, ends = [np.array([0, 100])] * 2, [np.array([20])] * 2, [np.array([40])] * 2
    timeline = Timeline(places, tuple(begins), tuple(instants), tuple(ends))
    (guard,) = guard_reports(table, timeline)
    assert (guard.player, guard.target, guard.near, guard.far) == ("D1", "A1", 0.5, 2.0)
    assert (guard.n_frames, guard.outside) == (40, pytest.approx(0.6))
    assert (guard.farthest, guard.frame) == (4.5, 70)


def test_a_guard_who_is_drawn_to_another_is_measured_from_them_then() -> None:
    grammar = read_motion_grammar(
        """
        start S
        role attack, defence
        S -> walk | guard | guard S | walk S
        guard := "guard"
        walk := "walk"
        verb guard = guard on opponent
        rest walk
        rest guard for guard
        guard: distance(opponent, 0.5 m .. 2 m)
        """,
        "g.grammar",
    )
    diagram = read_diagram(
        "attack A1 at 0 1\nattack A2 at 5 1\ndefence D1 at 0 2 guards A1\n"
        "1 walk D1\n2 guard D1 on A2",
        "g.tactics",
        grammar.activity,
    )
    trees = [parse(grammar.started(), one.split()) for one in ("walk", "walk", "walk guard")]
    table = bind(diagram, grammar, trees)
    assert [guarded(table, *one) for one in ((2,), (2, 1), (0,))] == [1, 0, -1]
    assert table.unasked[2] == ("guard", "walk")
    places = np.zeros((3, 100, 3))
    places[1:, :, 0] = 5.0
    places[1:, :, 1] = [[0.0], [1.0]]
    places[2, :40, 0] = 0.0  # beside A1 for 40 frames, then beside A2
    begins = np.array([0, 100]), np.array([0, 100]), np.array([0, 30, 100])
    timeline = Timeline(places, begins, begins, tuple(each[1:] for each in begins))
    (guard,) = guard_reports(table, timeline)
    assert (guard.target, guard.outside) == ("A2", pytest.approx(0.1))  # frames 30 to 39


WALK = GaitRange(airborne=0, step=0.7, speed=1.6)
RANGES = {"walk": WALK, "run": GaitRange(airborne=8, step=1.0, speed=5.0), WAITING: STANDING}
FEET = {side: [body.INDEX[f"{side}_ankle"], body.INDEX[f"{side}_toe"]] for side in ("l", "r")}


def standing(n_frames: int) -> np.ndarray:
    """Joints of somebody who stands upright on flat feet: array (frames, 21, 3)."""
    rotations = np.tile(np.array([1.0, 0.0, 0.0, 0.0]), (n_frames, len(body.JOINTS), 1))
    roots = np.zeros((n_frames, 3))
    roots[:, 1] = body.LEG_LENGTH + body.ANKLE_HEIGHT
    motion = Motion(rotations.astype(np.float32), roots.astype(np.float32), body.LEG_LENGTH)
    return retarget.motion_positions(motion)[0]


def kinds(joints: np.ndarray, labels: list[str]) -> list[tuple[str, int, int]]:
    gaits = impossible_gait("A1", joints, labels, RANGES)
    return [(motion.kind, motion.start, motion.end) for motion in gaits]


@pytest.mark.parametrize(("frames", "seen"), [(3, False), (4, True), (12, True)])
def test_both_feet_in_the_air_are_no_walk(frames: int, seen: bool) -> None:
    joints = standing(60)
    joints[20 : 20 + frames, :, 1] += 0.1
    expected = [("airborne", 20, 20 + frames)] if seen else []
    assert kinds(joints, ["walk"] * 60) == expected
    assert kinds(joints, [WAITING] * 60) == expected


def test_a_run_may_fly_as_long_as_its_captures_and_a_walk_beside_it_too() -> None:
    joints = standing(60)
    joints[20:32, :, 1] += 0.1  # 12 frames; 1.25 * 8 + 3 are allowed
    assert kinds(joints, ["run"] * 60) == []
    assert kinds(joints, ["run"] * 28 + ["walk"] * 32) == []
    joints[20:34, :, 1] += 0.1
    assert kinds(joints, ["run"] * 60) == [("airborne", 20, 34)]


@pytest.mark.parametrize(("speed", "seen"), [(2.6, False), (4.0, True)])
def test_four_metres_a_second_are_no_walk(speed: float, seen: bool) -> None:
    joints = standing(60)
    joints[:, :, 2] += np.arange(60)[:, None] * speed / 30.0
    np.testing.assert_allclose(travel_speeds(joints), speed)
    assert kinds(joints, ["walk"] * 60) == ([("speed", 0, 60)] if seen else [])
    assert kinds(joints, ["run"] * 60) == []


@pytest.mark.parametrize(("apart", "seen"), [(1.0, False), (1.3, True)])
def test_splits_are_no_step(apart: float, seen: bool) -> None:
    joints = standing(60)
    joints[20:30, FEET["l"], 2] += np.sqrt(apart**2 - 0.18**2)
    assert kinds(joints, ["walk"] * 60) == ([("step", 20, 30)] if seen else [])


def test_the_gait_of_captures_is_that_of_their_intervals() -> None:
    joints = standing(100)
    joints[10:20, :, 1] += 0.1
    joints[50:56, :, 1] += 0.1
    joints[70:80, FEET["r"], 2] += 0.6
    assert gait_range(joints, [(52, 90)]).airborne == 6  # as a whole, though it began before
    assert gait_range(joints, [(0, 15), (12, 40)]).airborne == 10
    assert gait_range(joints, [(52, 90)]).step == pytest.approx(np.hypot(0.18, 0.6))
    assert gait_range(joints, [(20, 40)]) == GaitRange(0, pytest.approx(0.18), 0.0)
    assert gait_range(joints, []) == GaitRange()


def test_a_planted_foot_that_jumps_is_found_and_a_slow_slide_is_not() -> None:
    joints = standing(60)
    planted = np.ones((60, 2), dtype=bool)
    assert foot_jump(joints, planted) == FootJump()
    joints[30:, FEET["r"], 0] += 0.13
    jump = foot_jump(joints, planted)
    assert (jump.metres, jump.foot) == (pytest.approx(0.13), 1)
    assert (jump.start, jump.end) == (28, 30)
    slow = standing(60)
    slow[:, FEET["r"], 0] += np.linspace(0.0, 0.13, 60)[:, None]
    assert foot_jump(slow, planted).metres == pytest.approx(0.13 * 9 / 59)


def test_a_foot_that_rolls_over_its_toe_does_not_jump() -> None:
    joints = standing(60)
    joints[30:, body.INDEX["l_ankle"], 2] += 0.1
    assert foot_jump(joints, np.ones((60, 2), dtype=bool)).metres == pytest.approx(0.0)


def test_a_foot_in_the_air_does_not_jump() -> None:
    joints = standing(60)
    joints[30:, FEET["r"], 0] += 0.13
    planted = np.ones((60, 2), dtype=bool)
    planted[26:34, 1] = False
    assert foot_jump(joints, planted).metres == 0.0
    edited, captured = np.ones(60, dtype=bool), np.zeros(60, dtype=bool)
    assert foot_jump(joints, on_the_ground(joints, planted, captured)).metres == 0.0
    assert foot_jump(joints, on_the_ground(joints, planted, edited)).metres == pytest.approx(0.13)
    joints[29, FEET["r"], 1] += 0.04  # now it is lifted: a step
    assert foot_jump(joints, on_the_ground(joints, planted, edited)).metres == 0.0


def test_jumps_are_impossible_beyond_the_limit_or_what_captures_show() -> None:
    labels = ["walk"] * 60
    for metres, source, seen in (
        (JUMP_LIMIT, 0.0, False),
        (0.2, 0.0, True),
        (0.2, 0.18, False),
        (0.3, 0.18, True),
    ):
        jump = JumpReport("A1", "left", metres, 10, 14, source)
        actual = impossible_jump(jump, labels)
        assert [(m.kind, m.start, m.end, m.frame) for m in actual] == (
            [("foot jump", 10, 15, 14)] if seen else []
        )


def naive_distance(a, b, c, d) -> float:
    """The distance of two segments by looking at many points of both."""
    share = np.linspace(0.0, 1.0, 201)[:, None]
    one, other = a + share * (b - a), c + share * (d - c)
    return float(np.linalg.norm(one[:, None] - other[None], axis=2).min())


@given(st.lists(st.floats(-1.0, 1.0), min_size=12, max_size=12))
def test_distances_of_segments_beside_a_slow_twin(values: list[float]) -> None:
    a, b, c, d = np.array(values).reshape(4, 3)
    fast = float(segment_distances(a, b, c, d))
    slow = naive_distance(a, b, c, d)
    assert fast <= slow + 1e-6  # segments shorter than a micrometre count as points
    assert slow <= fast + 0.02
    assert fast == pytest.approx(float(segment_distances(c, d, a, b)), abs=1e-6)


def test_limbs_that_come_near_and_limbs_that_cross() -> None:
    one, other = standing(10), standing(10)
    other[:, :, 0] += 3.0
    assert np.isinf(limb_distances(one, other)).all()  # out of reach
    assert list(near_limbs(("A1", "D1"), [one, other])) == []
    # arms reach 0.70 m to each side: in frame 4 the wrists are 3 cm apart, in frame 5 they cross
    reach = one[0, body.INDEX["l_wrist"], 0] - one[0, 0, 0]
    other[:, :, 0] -= 3.0
    other[:, :, 0] += 2.0 * reach + 0.2
    other[4, :, 0] -= 0.17
    assert limb_distances(one, other)[[0, 4]] == pytest.approx([0.2, 0.03])
    (pair,) = near_limbs(("A1", "D1"), [one, other])
    assert (pair.players, pair.frame, pair.n_frames) == (("A1", "D1"), 4, 1)
    assert pair.metres == pytest.approx(0.03)
    assert crossing_limbs([pair]) == []
    other[5, :, 0] -= 0.3
    (pair,) = near_limbs(("A1", "D1"), [one, other])
    assert (pair.frame, pair.n_frames) == (5, 2)
    (actual,) = crossing_limbs([pair])
    assert (actual.kind, actual.players, actual.frame) == ("limbs", ("A1", "D1"), 5)
    assert crossing_limbs([LimbReport(("A1", "D1"), 0.02, 3, 1)]) == []


KEEPING = """attack A1 at 0 1
defence D1 at 0 2 guards A1
1 walk A1 to 0 5
D1 keeps 0.5 m .. 2 m to A1 from 1 to 1
D1 keeps moving
"""


def test_what_is_kept_up_is_measured_between_its_steps_in_the_written_frames() -> None:
    grammar = read_motion_grammar(
        'grammar g\nstart S\nS -> guard | walk\nguard := "guard"\nwalk := "walk"\n', "g.grammar"
    )
    diagram = read_diagram(KEEPING, "g.tactics", grammar.activity)
    trees = [parse(grammar.started(), [action]) for action in ("walk", "guard")]
    table = bind(diagram, grammar, trees)
    assert (
        table.rows["kind"].tolist().count(3) == 1
    )  # a distance, while A1 acts: nothing is drawn for D1
    places = np.zeros((2, 100, 3))
    places[1, :, 1] = 1.0
    places[1, 50, 1] = 2.5  # half a metre too far, in one frame
    places[1, 80:, 1] = 9.0  # after the step
    begins = (np.array([0, 70]), np.array([0, 40]))
    ends = (np.array([70]), np.array([40]))
    timeline = Timeline(places, begins, (np.array([30]), np.array([20])), ends)
    joints = np.zeros((100, 21, 3))
    joints[:, :, 2] = np.concatenate([np.linspace(0.0, 2.0, 20), np.full(80, 2.0)])[:, None]
    distance, moving = kept_reports(table, timeline, [joints, joints])
    assert (distance.start, distance.end, distance.frame) == (0, 70, 50)
    assert distance.after == pytest.approx(0.5)
    assert not distance.kept
    assert (moving.start, moving.end) == (0, 70)  # until the last act ends
    assert moving.after == pytest.approx(50 / 30, abs=0.3)  # stands from frame 20 on
    assert not moving.kept
    other = read_diagram(KEEPING + "A1 keeps moving\n", "g.tactics", grammar.activity)
    *_, acting = kept_reports(bind(other, grammar, trees), timeline, [joints, joints])
    assert (acting.player, acting.after) == ("A1", 0.0)  # does in place what is drawn
    seen = {
        (one.kind, one.players[0]) for one in seen_faults(table, timeline, [joints] * 2, [], None)
    }
    assert seen == {("held pose", "A1"), ("held pose", "D1")}


def test_a_step_after_a_later_one_and_a_way_through_a_table_are_seen() -> None:
    grammar = read_motion_grammar(
        "grammar g\nstart S\nplace table at 0 2 height 75 cm size 1 m\nplace ring at 0 4 height 3 m"
        ' size 1 m\nS -> walk\nwalk := "walk"\n',
        "g.grammar",
    )
    text = "player A at 0 0\nplayer B at 5 0\n1 walk A\n2 walk B"
    diagram = read_diagram(text, "g", grammar.activity)
    table = bind(diagram, grammar, [parse(grammar.started(), ["walk"])] * 2)
    stands = np.zeros((60, 21, 3))
    stands[..., 1] = 0.95
    for joint, height in (("neck", 1.5), ("l_knee", 0.5), ("r_knee", 0.5)):
        stands[:, body.INDEX[joint], 1] = height
    walks, other = stands.copy(), stands.copy()
    walks[..., 2] = np.linspace(0.0, 6.0, 60)[:, None]
    other[..., 0] = 5.0 + np.linspace(0.0, 6.0, 60)[:, None]
    for event, found in ((22, {"place"}), (25, {"place", "order"})):  # B's is in frame 20
        timeline = Timeline(
            np.zeros((2, 60, 3)),
            (np.array([0]), np.array([0])),
            (np.array([event]), np.array([20])),
            (np.array([60]), np.array([40])),
        )
        seen = list(seen_faults(table, timeline, [walks, other], [], None))
        assert {one.kind for one in seen} == found
        (place,) = (one for one in seen if one.kind == "place")
        assert place.players == ("A", "table")
        middle = walks[place.start : place.end, 0, 2]
        np.testing.assert_allclose([middle.min(), middle.max()], [1.55, 2.45], atol=0.11)


def test_who_sits_on_a_chair_is_not_in_its_way_and_who_walked_through_it_was() -> None:
    grammar = read_motion_grammar(
        "grammar g\nstart S\nplace chair at 0 2 height 45 cm size 60 cm\nS -> walk sit\n"
        'walk := "walk"\nsit := "sit"\nverb sit = sit on target\nsit: distance(chair, <= 20 cm)',
        "g.grammar",
    )
    diagram = read_diagram("player A at 0 0\n1 sit A on chair", "g", grammar.activity)
    table = bind(diagram, grammar, [parse(grammar.started(), ["walk", "sit"])])
    joints = np.zeros((60, 21, 3))
    joints[..., 1], joints[..., 2] = 0.95, 2.0
    joints[:10, :, 2] = joints[20:25, :, 2] = 0.0
    joints[:, [body.INDEX["l_knee"], body.INDEX["r_knee"]], 1] = 0.4
    timeline = Timeline(np.zeros((1, 60, 3)), (np.array([0, 30, 60]),), (np.array([15, 45]),))
    places = [
        one for one in seen_faults(table, timeline, [joints], [], None) if one.kind == "place"
    ]
    assert [(one.start, one.end) for one in places] == [(10, 20), (25, 30)]


def test_limbs_that_touch_and_poses_that_leap_are_seen() -> None:
    trees = [parse(GRAMMAR.started(), string.split()) for string in ("hold guard pass", "catch")]
    table = bind(DIAGRAM, GRAMMAR, trees)
    pairs = [LimbReport(("A1", "A2"), metres, 7, 2) for metres in (0.04, 0.0)]
    (touch,) = _touching(table, pairs)  # the second pass through one another: that is impossible
    assert (touch.players, touch.start, touch.value) == (("A1", "A2"), 7, 0.04)
    state = SceneState(tuple(PlayerState(t, np.arange(len(t.leaves())), (0, 0, 0)) for t in trees))
    seam = np.array([[0.0, 2.9, 0.0], [0.0, 0.0, 3.1], [0.0, 0.0, 0.0]])
    timeline = Timeline(
        np.zeros((2, 90, 3)), (np.array([0, 30, 60, 90]), np.array([0, 90])), ((), ())
    )
    (leap,) = _leaps(state, SimpleNamespace(seam=seam, seam_class=np.arange(3)), table, timeline)
    assert leap.players == ("A1", "guard", "pass")
    assert leap.start < 60 < leap.end


def test_what_misses_its_target_or_goes_through_somebody_is_seen() -> None:
    grammar = read_motion_grammar(
        "grammar g\nstart S\nplace goal at 0 9 height 1 m size 1 m\nobject ball size 40 cm\n"
        'S -> kick\nkick := "kick"\nkick: send(ball, goal)\n',
        "g.grammar",
    )
    diagram = read_diagram("player A at 0 0\nplayer B at 0 4\n1 kick A", "g", grammar.activity)
    table = bind(diagram, grammar, [parse(grammar.started(), ["kick"])] * 2)
    joints = np.zeros((2, 60, 21, 3))
    joints[1, :, :, 2] = 4.0
    joints[1, :, :, 1] = np.linspace(0.0, 1.7, 21)
    way = np.zeros((60, 3))
    way[:, 1] = 1.0
    way[:, 2] = np.linspace(0.0, 8.0, 60)  # ends a metre before the goal
    sent = (Sent(0, 5, "goal", (0.0, 1.0, 9.0), 1.0),)
    ball = Ball(way, np.full(60, -1), np.full(60, np.nan), 0.4, sent)
    still = Timeline(
        np.zeros((2, 60, 3)), (np.zeros(1),) * 2, (np.zeros(1),) * 2, (np.full(1, 60),) * 2
    )
    found = {one.kind: one for one in seen_faults(table, still, list(joints), [], ball)}
    assert found["misses"].value == pytest.approx(1.0, abs=0.05)
    assert found["object"].players == ("B",)
