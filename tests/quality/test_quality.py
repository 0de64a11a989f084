"""What is said of bodies that are made here, whose needs and faults are known."""

from __future__ import annotations

import numpy as np
import pytest

from motiondb.body import body
from motiondb.quality.assess import assess, performer_rate, speed_of, to_mjcf, to_values, turned
from motiondb.quality.measured import joined, measure, smoothed
from motiondb.quality.supports import outside
from motiondb.records import Box, Finding, FloatArray, Quality
from tests.body.walker import SPEED, walker

I = body.INDEX  # noqa: E741
FPS = 60.0


def standing(seconds: float, fps: float = FPS, seed: int = 0) -> FloatArray:
    """A body that stands with its arms down and sways by millimetres: joints (frames, 21, 3)."""
    rest = np.zeros((len(body.JOINTS), 3))
    for joint, parent in enumerate(body.PARENTS):
        if parent >= 0:
            rest[joint] = rest[parent] + body.OFFSETS[joint]
    for s in "lr":
        shoulder = rest[I[f"{s}_shoulder"]]
        rest[I[f"{s}_elbow"]] = shoulder + np.array([0.0, -0.28, 0.02])
        rest[I[f"{s}_wrist"]] = shoulder + np.array([0.0, -0.52, 0.08])
    rest[:, 1] += body.LEG_LENGTH + body.ANKLE_HEIGHT
    t = np.arange(round(seconds * fps)) / fps
    phase = np.random.default_rng(seed).uniform(0.0, 6.0, (len(body.JOINTS), 3))
    high = np.clip(rest[:, 1:2], 0.0, 1.0)  # the feet stay
    return rest + 0.003 * high * np.sin(2.0 * t[:, None, None] + phase)


def sitting(p: FloatArray, height: float) -> FloatArray:
    """The same body on a seat of a height, with level thighs and feet in front."""
    q = p.copy()
    q[..., 1] += height + 0.10 - 0.93
    for s in "lr":
        hip = q[:, I[f"{s}_hip"]]
        q[:, I[f"{s}_knee"]] = hip + np.array([0.0, 0.0, 0.43])
        q[:, I[f"{s}_ankle"]] = hip * [1.0, 0.0, 1.0] + [0.0, 0.08, 0.43 + 0.1]
        q[:, I[f"{s}_toe"]] = q[:, I[f"{s}_ankle"]] + [0.0, -0.06, 0.14]
    return q


def blended(p: FloatArray, q: FloatArray, start: float, end: float) -> FloatArray:
    """From p to q and back, within half a second around two times."""
    t = np.arange(len(p)) / FPS
    share = np.clip((t - start + 0.25) / 0.5, 0, 1) * np.clip((end + 0.25 - t) / 0.5, 0, 1)
    share = share * share * (3.0 - 2.0 * share)
    return p + share[:, None, None] * (q - p)


def jumping(n: int, fps: float = FPS, g: float = 9.81) -> FloatArray:
    """A body that jumps n times by 0.5 s of flight."""
    p = standing(1.0 + 1.5 * n, fps)
    t = np.arange(len(p)) / fps
    for number in range(n):
        u = t - 0.75 - 1.5 * number
        rise = np.where((u > 0) & (u < 0.5), g / 2.0 * u * (0.5 - u), 0.0)
        p[..., 1] += rise[:, None]
        p[..., 2] += np.clip(u, 0.0, 0.5)[:, None]
    return p


def kinds(quality: Quality) -> set[str]:
    return {f.kind for f in quality.findings}


def only(quality: Quality, kind: str) -> Finding:
    (found,) = [f for f in quality.findings if f.kind == kind]
    return found


def test_a_body_that_stands_or_jumps_lacks_nothing() -> None:
    assert kinds(assess(standing(5.0), FPS)) == set()
    assert kinds(assess(jumping(4), FPS)) == set()
    assert kinds(assess(standing(5.0, 24.0), 24.0)) == set()
    assert kinds(assess(standing(5.0, 240.0), 240.0)) == set()


@pytest.mark.parametrize("height", [0.35, 0.5, 0.7])
def test_a_seat_is_told_with_height_time_and_place(height: float) -> None:
    p = standing(8.0) + np.array([2.0, 0.0, 1.0])
    found = only(assess(blended(p, sitting(p, height), 2.0, 6.0), FPS), "sits")
    assert found.measure == pytest.approx(height, abs=0.03)
    assert (found.start, found.end) == pytest.approx((2.0, 6.0), abs=0.3)
    assert found.family == "needs"
    assert found.part == "seat"
    assert found.unit == "m"
    (box,) = found.boxes
    assert box.size[1] == pytest.approx(height, abs=0.03)
    assert box.centre == pytest.approx((2.0, height / 2.0, 1.0), abs=0.03)
    start, end = f"{found.start:.1f}", f"{found.end:.1f}"
    assert found.sentence == (
        f"sits on something {100 * found.measure:.0f} cm high, {start} to {end} s"
    )


@pytest.mark.parametrize(("swings", "hertz"), [(0.3, 1.0), (0.1, 0.7)])
def test_one_who_hangs_is_told_at_the_height_of_the_hands(swings: float, hertz: float) -> None:
    p = standing(8.0)
    q = p + np.array([0.0, 0.5, 0.0])
    for s in "lr":
        shoulder = q[:, I[f"{s}_shoulder"]]
        q[:, I[f"{s}_elbow"]] = shoulder + np.array([0.0, 0.28, 0.0])
        q[:, I[f"{s}_wrist"]] = shoulder + np.array([0.0, 0.53, 0.0])
    swing = swings * np.sin(2.0 * np.pi * hertz * np.arange(len(q)) / FPS)
    q[..., 2] += swing[:, None] * np.clip((2.2 - q[..., 1]) / 2.0, 0.0, 1.0)
    found = only(assess(blended(p, q, 2.0, 6.0), FPS), "hangs")
    hand = np.median(q[:, I["l_wrist"], 1]) + 0.35 * 0.25
    assert found.measure == pytest.approx(hand, abs=0.05)
    assert (found.start, found.end) == pytest.approx((2.0, 6.0), abs=0.5)
    assert found.part == "hands"


def test_steps_are_told_by_their_heights() -> None:
    p = standing(8.0)
    t = np.arange(len(p)) / FPS
    for first, s in ((1.0, "l"), (1.5, "r"), (3.0, "l"), (3.5, "r")):
        part = [I[f"{s}_{n}"] for n in ("knee", "ankle", "toe")]
        up = np.clip((t - first) / 0.4, 0, 1)[:, None]
        p[:, part, 1] += 0.2 * up
        p[:, part, 2] += 0.3 * up
        rest = [j for j in range(21) if body.JOINTS[j][2:] not in ("knee", "ankle", "toe")]
        p[:, rest, 1] += 0.1 * up
        p[:, rest, 2] += 0.15 * up
    found = only(assess(p, FPS), "steps")
    assert [box.size[1] for box in found.boxes] == pytest.approx([0.2, 0.4], abs=0.02)
    assert found.sentence.startswith("climbs steps 20, 40 cm high")


def test_what_floats_for_a_second_is_no_step() -> None:
    p = standing(6.0)
    p[120:180, :, 1] += 0.10 * np.sin(np.linspace(0, np.pi, 60))[:, None] ** 0.3
    found = only(assess(p, FPS), "floats")
    assert found.family == "fault"
    assert (found.start, found.end) == pytest.approx((2.0, 3.0), abs=0.15)
    assert found.measure == pytest.approx(0.1, abs=0.02)


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        (("l_hip", "r_hip"), "left and right hips"),
        (("r_knee", "r_ankle"), "right knee and ankle"),
        (("l_elbow", "l_wrist"), "left elbow and wrist"),
    ],
)
def test_parts_that_change_places_are_named_and_do_not_jump(
    parts: tuple[str, str], said: str
) -> None:
    p = standing(4.0, 30.0)
    a, b = (I[part] for part in parts)
    p[45:60, [a, b]] = p[45:60, [b, a]]
    assert kinds(assess(p, 30.0)) == {"swapped"}
    found = only(assess(p, 30.0), "swapped")
    assert found.sentence == f"{said} change places, 1.5 to 2.0 s"


def test_a_hand_that_stays_while_the_arm_moves_is_frozen() -> None:
    p = standing(4.0)
    p[..., 0] += 0.3 * np.arange(len(p))[:, None] / FPS
    p[:, [I["l_toe"], I["l_ankle"]]] = p[0, [I["l_toe"], I["l_ankle"]]]  # a foot may stay
    p[60:120, I["r_wrist"]] = p[60, I["r_wrist"]]
    (found,) = [f for f in assess(p, FPS).findings if f.kind == "frozen"]
    assert found.part == "r_wrist"
    assert found.sentence == (
        "the right wrist stays where it is for 1.0 s while the rest moves, 1.0 to 2.0 s"
    )


def test_a_body_floats_although_the_tips_of_its_feet_lie_below_the_floor() -> None:
    p = standing(6.0)
    p[:, [I["l_toe"], I["r_toe"]], 1] = 0.05
    p[:, [I["l_ankle"], I["r_ankle"]], 1] = 0.12
    p[120:210, :, 1] += 0.08
    found = only(assess(p, FPS), "floats")
    assert (found.start, found.end) == pytest.approx((2.0, 3.5), abs=0.1)


def test_a_foot_that_sinks_5_cm_is_told_if_it_stays_there() -> None:
    p, foot = standing(4.0), [I["l_ankle"], I["l_toe"]]
    p[60:180, foot, 1] -= 0.05 * np.clip(np.arange(120) / 6.0, 0.0, 1.0)[:, None]
    p[60:180, foot, 2] += 0.4 * np.arange(120)[:, None] / FPS  # no rest, which would be a floor
    found = only(assess(p, FPS), "sinks")
    assert (found.start, found.end) == pytest.approx((1.1, 3.0), abs=0.1)
    assert found.measure == pytest.approx(0.05, abs=0.01)


@pytest.mark.parametrize("moved", ["left foot", "body"])
@pytest.mark.parametrize("floor", [0.0, 0.5])
def test_who_goes_down_where_he_stands_sinks_and_was_on_no_step(moved: str, floor: float) -> None:
    p = standing(6.0) + np.array([0.0, floor, 0.0])
    parts = [I["l_knee"], I["l_ankle"], I["l_toe"]] if moved == "left foot" else list(range(21))
    t = np.arange(len(p)) / FPS
    down = np.clip((t - 2.0) / 0.15, 0.0, 1.0) * np.clip((4.0 - t) / 0.15, 0.0, 1.0)
    p[:, parts, 1] -= 0.08 * down[:, None]
    found = only(assess(p, FPS), "sinks")
    assert not kinds(assess(p, FPS)) & {"stands on", "steps", "floats", "held"}
    assert (found.start, found.end) == pytest.approx((2.1, 3.9), abs=0.1)
    assert found.measure == pytest.approx(0.08, abs=0.01)


def test_a_body_that_sinks_for_most_of_a_take_did_not_stand_on_something_before() -> None:
    """Height 0 of the file is a floor where feet rest on it, as no room has a pit."""
    p = standing(6.0)
    t = np.arange(len(p)) / FPS
    depth = 0.12 * np.clip((t - 0.6) / 1.2, 0.0, 1.0) * np.clip((5.4 - t) / 1.2, 0.0, 1.0)
    p[..., 1] -= depth[:, None]
    quality = assess(p, FPS)
    assert kinds(quality) <= {"sinks", "floor tilts"}
    found = only(quality, "sinks")
    assert found.measure == pytest.approx(0.12, abs=0.01)
    assert (found.start, found.end) == pytest.approx((1.2, 4.8), abs=0.3)


@pytest.mark.parametrize("fps", [30.0, 60.0])
@pytest.mark.parametrize("frames", [1, 2])
def test_a_joint_that_is_elsewhere_in_the_first_or_last_frames_jumps(
    fps: float, frames: int
) -> None:
    for at in (slice(0, frames), slice(-frames, None)):
        p = standing(3.0, fps)
        forearm = p[at, I["l_wrist"]] - p[at, I["l_elbow"]]
        aside = np.cross(forearm, [0.0, 0.0, 1.0])
        p[at, I["l_wrist"]] += 0.14 * aside / np.linalg.norm(aside, axis=1, keepdims=True)
        found = only(assess(p, fps), "jumps")
        assert found.part == "l_wrist"
        assert found.measure == pytest.approx(0.14, abs=0.02)
        assert found.start < 0.1 or found.end > 2.9


@pytest.mark.parametrize("turn", [0.0, 0.5])
def test_a_walk_in_place_is_one_on_a_treadmill_also_where_it_turns(turn: float) -> None:
    """As programs write motion without the way of its root."""
    p = walker(FPS, 6.0)
    p[..., [0, 2]] -= p[:, :1, [0, 2]]
    angle = turn * np.arange(len(p)) / FPS
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    p[..., 0], p[..., 2] = c * p[..., 0] + s * p[..., 2], c * p[..., 2] - s * p[..., 0]
    found = only(assess(p, FPS), "treadmill")
    assert found.measure == pytest.approx(SPEED, rel=0.1)


def test_who_steps_down_aside_stood_on_something() -> None:
    p = standing(6.0) + np.array([0.0, 0.08, 0.0])
    t = np.arange(len(p)) / FPS
    for first, s in ((2.0, "l"), (2.4, "r")):
        part = [I[f"{s}_{n}"] for n in ("hip", "knee", "ankle", "toe")]
        share = np.clip((t - first) / 0.3, 0.0, 1.0)[:, None]
        p[:, part, 1] -= 0.08 * share
        p[:, part, 0] += 0.3 * share
    assert "sinks" not in kinds(assess(p, FPS))


@pytest.mark.parametrize("speed", [0.25, 0.5, 2.0])
def test_jumps_tell_the_speed_at_which_they_play(speed: float) -> None:
    p = jumping(6, 120.0)
    quality = assess(p, 120.0 * speed)
    found = only(quality, "rate")
    assert found.measure == pytest.approx(speed, rel=0.1)
    assert found.family == "file"
    assert len(quality.flights) == 6


def test_without_three_jumps_the_rate_cannot_be_told() -> None:
    none, two = assess(standing(3.0), FPS), assess(jumping(2), FPS)
    assert none.untold == ("cannot say whether the rate is right: no jump",)
    assert two.untold == ("cannot say whether the rate is right: only 2 of 3 jumps",)
    assert not kinds(assess(jumping(2), 2.0 * FPS)) & {"rate"}
    assert speed_of([(9.8, 0.1), (2.5, 0.1), (40.0, 0.1)]) is None  # they do not agree
    speed, error, said = performer_rate([(2.4, 0.1), (2.5, 0.1), (2.45, 0.1)], "Ann")
    assert speed == pytest.approx(0.5, rel=0.01)
    assert error is not None
    assert error < 0.02
    assert said == (
        "'Ann' plays at 0.5 times its speed, or its lengths are 0.25 times what they were: "
        "3 flights fall with 2.4 m/s2"
    )


@pytest.mark.parametrize(
    ("factor", "what"), [(2.54, "centimetres read as inches"), (0.01, "metres read as centimetres")]
)
def test_legs_tell_the_unit(factor: float, what: str) -> None:
    found = only(assess(standing(3.0) * factor, FPS), "unit")
    assert found.measure == pytest.approx(0.85 * factor, rel=0.01)
    assert what in found.sentence


def test_a_child_is_no_wrong_unit() -> None:
    child = standing(3.0) * 0.6
    assert "unit" not in kinds(assess(child, FPS))


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0, 240.0])
def test_a_joint_that_jumps_for_a_tenth_of_a_second_is_named(fps: float) -> None:
    p = standing(4.0, fps)
    p[round(2 * fps) : round(2.1 * fps), I["l_wrist"]] += [0.12, 0.0, 0.16]
    found = only(assess(p, fps), "jumps")
    assert found.part == "l_wrist"
    assert found.measure == pytest.approx(0.2, abs=0.03)
    assert found.start == pytest.approx(2.0, abs=0.05)


@pytest.mark.parametrize("fps", [120.0, 30.0])
def test_a_joint_that_is_off_in_a_single_frame_is_named_at_any_rate(fps: float) -> None:
    p = standing(4.0, fps)
    p[81, I["r_elbow"]] += [0.0, 0.0, 0.08]
    found = only(assess(p, fps), "jumps")
    assert found.part == "r_elbow"
    assert found.sentence.startswith("the right elbow jumps by 8 cm")
    assert found.start <= 81 / fps <= found.end


@pytest.mark.parametrize("joint", ["head", "neck", "l_toe", "r_shoulder"])
def test_a_joint_that_leaves_its_bones_slowly_is_named_at_30_frames(joint: str) -> None:
    p = standing(4.0, 30.0)
    away = np.clip(np.arange(-60, 60) / 3.0 + 1.0, 0.0, 1.0) * (np.arange(-60, 60) < 6)
    p[:, I[joint]] += 0.2 * away[:, None] * np.array([0.6, 0.0, 0.8])
    found = only(assess(p, 30.0), "jumps")
    assert found.part == joint
    assert (found.start, found.end) == pytest.approx((1.95, 2.2), abs=0.07)


def test_a_body_that_turns_or_is_thrown_at_once_has_a_seam() -> None:
    p = jumping(1)
    turned_, thrown = p.copy(), p.copy()
    turned_[30:] = turned_[30:, :, [2, 1, 0]] * [1.0, 1.0, -1.0]
    thrown += np.clip((np.arange(len(p)) - 30) / 6.0, 0, 1)[:, None, None] * [0.2, 0.0, 0.0]
    found = only(assess(turned_, FPS), "seam")
    assert found.sentence == "the whole body turns by 90 degrees, 0.50 to 0.52 s"
    found = only(assess(thrown, FPS), "seam")
    assert found.unit == "m/s2"
    assert found.start == pytest.approx(0.45, abs=0.1)


def test_one_joint_that_trembles_is_named() -> None:
    p = standing(4.0)
    p[:, I["r_wrist"], 1] += np.random.default_rng(0).normal(scale=0.01, size=len(p))
    found = only(assess(p, FPS), "noise")
    assert found.part == "r_wrist"
    assert found.sentence.startswith("the right wrist trembles by")


@pytest.mark.parametrize("n", range(16, 40))
def test_takes_of_few_frames_at_few_a_second_are_sound(n: int) -> None:
    assert kinds(assess(standing(4.0, 12.0)[:n], 12.0)) == set()


def test_the_names_of_arms_or_legs_alone_may_be_exchanged() -> None:
    p = standing(3.0)
    arms = [I[f"{s}_{j}"] for s in "lr" for j in ("collar", "shoulder", "elbow", "wrist")]
    legs = [I[f"{s}_{j}"] for s in "lr" for j in ("hip", "knee", "ankle", "toe")]
    for whose, said in ((arms, "left and right arm are"), (legs, "left and right of the legs are")):
        q = p.copy()
        q[:, whose] = p[:, whose[4:] + whose[:4]]
        assert said in only(assess(q, FPS), "names").sentence


def test_a_knee_that_bends_backwards_is_named() -> None:
    p = sitting(standing(3.0), 0.5)
    hip, knee, ankle = (I[f"l_{j}"] for j in ("hip", "knee", "ankle"))
    p[:, knee] = p[:, hip] + p[:, ankle] - p[:, knee]
    found = only(assess(p, FPS), "bends")
    assert found.sentence == "the left knee bends backwards, 0.0 to 3.0 s"


def test_a_need_that_ends_with_a_leg_that_jumps_is_doubted() -> None:
    p = standing(6.0)
    legs = [I[f"{s}_{name}"] for s in "lr" for name in ("knee", "ankle", "toe")]
    ahead = p.copy()
    ahead[:, legs, 2] += 0.3
    assert "leans" in kinds(assess(blended(p, ahead, 0.0, 3.0), FPS))
    p[:180] = ahead[:180]  # the legs were in a wrong place until they jump
    doubted = assess(p, FPS)
    assert kinds(doubted) == {"jumps"}
    assert doubted.untold[-1] == (
        "cannot say that it leans on something or somebody, 12 cm out of balance, 0.0 to 3.0 s: "
        "the left knee jumps by 30 cm, 3.00 to 3.02 s"
    )


def test_a_slide_for_two_seconds_is_told_with_its_time() -> None:
    p = standing(8.0)
    t = np.arange(len(p)) / FPS
    p[..., 0] += 0.2 * np.clip(t - 3.0, 0.0, 2.0)[:, None]
    found = only(assess(p, FPS), "slides")
    assert found.measure == pytest.approx(0.2, abs=0.01)
    assert abs(found.start - 3.0) < 0.5
    assert abs(found.end - 5.0) < 0.5


@pytest.mark.parametrize("aside", [0.0, 0.09])
def test_a_slide_is_told_though_feet_swing_low_and_drift_aside(aside: float) -> None:
    p = walker(FPS, 8.0)
    t = np.arange(len(p)) / FPS
    slid = (t > 3.0) & (t < 5.5)
    p[..., 0] += np.cumsum(0.2 * slid)[:, None] / FPS
    p[..., 2] += np.cumsum(aside * slid * np.sign(np.sin(2.0 * np.pi * t / 0.55)))[:, None] / FPS
    found = only(assess(p, FPS), "slides")
    assert found.start == pytest.approx(3.0, abs=0.4)
    assert found.end == pytest.approx(5.5, abs=0.5)


def test_faults_are_told_by_their_names() -> None:
    p = jumping(1)
    seam, frozen, noise, feet = (p.copy() for _ in range(4))
    seam[90:] += [0.2, 0.0, 0.0]
    frozen[20:40] = frozen[20]
    noise += np.random.default_rng(0).normal(scale=0.005, size=p.shape)
    for name in ("ankle", "toe"):
        left, right = I[f"l_{name}"], I[f"r_{name}"]
        feet[20:40, [left, right]] = feet[20:40, [right, left]]
    assert only(assess(seam, FPS), "seam").measure == pytest.approx(0.2, abs=0.02)
    still = only(assess(frozen, FPS), "frozen")
    assert (still.start, still.end) == pytest.approx((20 / FPS, 40 / FPS), abs=0.02)
    assert "noise" in kinds(assess(noise, FPS))
    swapped = only(assess(feet, FPS), "swapped")
    assert (swapped.start, swapped.end) == pytest.approx((20 / FPS, 40 / FPS))
    assert "names" in kinds(assess(p[:, body.MIRROR], FPS))


def test_a_rest_pose_before_the_take_is_told() -> None:
    p = standing(3.0)
    pose = p[:1].copy()
    for s, sign in (("l", 1.0), ("r", -1.0)):
        shoulder = pose[:, I[f"{s}_shoulder"]]
        pose[:, I[f"{s}_elbow"]] = shoulder + np.array([sign * 0.28, 0.0, 0.0])
        pose[:, I[f"{s}_wrist"]] = shoulder + np.array([sign * 0.53, 0.0, 0.0])
    found = only(assess(np.concatenate([np.repeat(pose, 30, axis=0), p]), FPS), "rest pose")
    assert (found.start, found.end) == pytest.approx((0.0, 0.5), abs=0.02)


def test_gaps_are_told_and_do_not_hide_the_rest() -> None:
    p = standing(8.0)
    p = blended(p, sitting(p, 0.5), 2.0, 6.0)
    p[60:90, I["l_wrist"]] = np.nan
    quality = assess(p, FPS)
    gap = only(quality, "gap")
    assert (gap.start, gap.end) == pytest.approx((1.0, 1.5))
    assert "sits" in kinds(quality)
    nothing = assess(np.full((100, 21, 3), np.nan), FPS)
    assert nothing.findings == ()
    assert len(nothing.untold) == 1


def test_the_numbers_of_seconds_are_low_where_faults_are_and_not_where_help_is_needed() -> None:
    p = standing(8.0)
    clean, needs = assess(p, FPS), assess(blended(p, sitting(p, 0.5), 2.0, 6.0), FPS)
    p[300:306, I["l_wrist"]] += [0.2, 0.0, 0.0]
    broken = assess(p, FPS)
    assert len(clean.seconds) == 8
    np.testing.assert_array_equal(needs.seconds[3:5], clean.seconds[3:5])  # it sits
    assert broken.seconds[5] < 0.5 < broken.seconds[4] == clean.seconds[4]


def test_balance_is_the_distance_from_the_outline_of_the_feet() -> None:
    p = standing(2.0)
    legs = ("pelvis", "hip", "knee", "ankle", "toe")
    p[:, [j for j in range(21) if not body.JOINTS[j].endswith(legs)], 2] += 0.8
    m = measure(p, FPS)
    assert m is not None
    tip = 0.14 + 0.06 * 0.14 / np.hypot(0.06, 0.14)  # the toe joint, and 6 cm beyond
    np.testing.assert_allclose(outside(m), m.com[:, 2] - tip - 0.045, atol=0.005)
    assert outside(m).min() > 0.1
    assert outside(measure(standing(2.0), FPS)).max() == 0.0


def test_a_sliding_quadratic_gives_the_derivatives_of_a_parabola() -> None:
    t = np.arange(40) / FPS
    y = (3.0 + 2.0 * t - 4.9 * t * t)[:, None]
    value, speed, pull = smoothed(y, FPS, 0.13, (0, 1, 2))
    inside = slice(5, -5)
    np.testing.assert_allclose(value[inside], y[inside], atol=1e-9)
    np.testing.assert_allclose(speed[inside, 0], (2.0 - 9.8 * t)[inside], atol=1e-9)
    np.testing.assert_allclose(pull[inside, 0], -9.8, atol=1e-6)
    assert joined([(5, 6), (0, 3)], 2) == [(0, 6)]


def test_boxes_leave_in_the_axes_of_the_file() -> None:
    p = standing(8.0) + np.array([1.0, 0.0, 3.0])
    findings = assess(blended(p, sitting(p, 0.5), 2.0, 6.0), FPS).findings
    ((row,),) = (to_values(findings, "z"),)
    x, y, z = row["centre"]  # type: ignore[misc]
    assert (x, y, z) == pytest.approx((1.0, -3.0, 0.25), abs=0.03)
    text = to_mjcf(findings, "y", "a<b")
    assert '<mujoco model="a&lt;b">' in text
    assert text.count("<geom") == 1
    assert turned(Box((1.0, 2.0, 3.0), (1.0, 2.0, 3.0)), "y").size == (1.0, 2.0, 3.0)


def test_knees_that_markers_let_look_bent_a_little_are_sound() -> None:
    p = standing(3.0)
    for s in "lr":
        hip, knee, ankle = (I[f"{s}_{j}"] for j in ("hip", "knee", "ankle"))
        p[:, knee] = (p[:, hip] + p[:, ankle]) / 2.0 - [0.0, 0.0, 0.065 * 0.85]
    assert "bends" not in kinds(assess(p, FPS))


def test_a_neck_that_curls_slowly_does_not_jump_as_a_head_that_is_elsewhere_does() -> None:
    p = standing(4.0)
    p[:, I["head"]] = p[:, I["neck"]] + [0.0, 0.1, 0.0]
    curled = p.copy()
    hump = np.exp(-(((np.arange(len(p)) / FPS - 2.0) / 0.12) ** 2))
    curled[:, I["head"], 1] -= 0.043 * hump
    assert "jumps" not in kinds(assess(curled, FPS))
    p[120:150, I["head"], 1] -= 0.043
    found = only(assess(p, FPS), "jumps")
    assert found.sentence.startswith("the head jumps by 4 cm")
    assert found.measure > found.threshold


def test_a_joint_that_is_off_in_two_frames_of_120_a_second_jumps() -> None:
    p = standing(4.0, 120.0)
    p[240:242, I["r_shoulder"], 2] += 0.06
    assert only(assess(p, 120.0), "jumps").part == "r_shoulder"


def test_legs_that_jump_do_not_throw_the_whole_body() -> None:
    p = standing(4.0)
    legs = [I[f"{s}_{j}"] for s in "lr" for j in ("knee", "ankle", "toe")]
    p[120:123, legs, 0] += 0.5
    assert kinds(assess(p, FPS)) == {"jumps"}
