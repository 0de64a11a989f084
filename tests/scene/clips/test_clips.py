"""The library made of a few gliding bodies: order, steps, images, instants, seams, poses."""

from __future__ import annotations

import numpy as np
import pytest

from motiondb.body import body, pose_vectors, retarget, rotation
from motiondb.errors import SceneError
from motiondb.records import Event, Motion
from motiondb.scene.clips.clip_cutting import ShownMotion, body_frames, compose, relative
from motiondb.scene.clips.clips import (
    ClipLibrary,
    ClipSource,
    SeamEnds,
    VariantSettings,
    clip_motion,
    make_library,
    rest_costs,
    seam_costs,
    source_frames,
)

PLAIN = VariantSettings(bends=(0.0,), stretches=(1.0,), rest_bends=(0.0,), turns=(0.0,))
TERMINALS = ("run", "shoot", "pivot_left", "pivot_right", "catch")


def gliding(places: np.ndarray, arms: float = 0.0) -> Motion:
    """A body in T-pose, its right upper arm swung ahead by ``arms`` radians, along places."""
    local = np.zeros((len(places), len(body.JOINTS), 4))
    local[..., 0] = 1.0
    local[:, body.INDEX["r_shoulder"]] = rotation.from_axis_angle([0.0, 1.0, 0.0], arms)
    local[:, 0] = pose_vectors.yaw(places[:, 2])
    root = np.column_stack([places[:, 0], np.full(len(places), 0.93), places[:, 1]])
    return Motion(local.astype(np.float32), root.astype(np.float32))


def straight(n_frames: int, speed: float, heading: float, turn: float = 0.0) -> np.ndarray:
    way = np.arange(n_frames) * speed / 30.0
    turned = heading + np.linspace(0.0, turn, n_frames)
    return np.column_stack([5.0 + way * np.sin(heading), way * np.cos(heading), turned])


def strikes(*frames: int) -> tuple[Event, ...]:
    return tuple(Event(f, "foot_strike", "l_ankle", "ground") for f in frames)


RUN = gliding(straight(60, 3.0, heading=0.7))
SHOOT = gliding(straight(40, 0.3, heading=-1.0), arms=1.0)
PIVOT = gliding(straight(40, 0.3, heading=0.0, turn=np.radians(90.0)))
CATCH = gliding(straight(30, 0.3, heading=2.0))
MOTIONS = {"run": RUN, "shoot": SHOOT, "pivot": PIVOT, "catch": CATCH}


def shown() -> list[ShownMotion]:
    release = (Event(25, "release", "r_wrist", "ball"),)
    return [
        ShownMotion("catch", "catch", CATCH, 0, 30, "catch", (Event(12, "catch"),), "CC0"),
        ShownMotion("run", "run", RUN, 0, 60, "", strikes(10, 20, 30, 45), "CC0"),
        ShownMotion("shoot", "shoot", SHOOT, 0, 40, "release", release, "CMU"),
        ShownMotion("pivot_left", "pivot", PIVOT, 0, 40, "", (), "CC0"),
    ]


@pytest.fixture(scope="module")
def plain() -> ClipLibrary:
    return make_library(shown(), TERMINALS, PLAIN)


@pytest.fixture(scope="module")
def full() -> ClipLibrary:
    return make_library(shown(), TERMINALS)


def test_entries_stand_by_terminal(plain: ClipLibrary) -> None:
    """Strikes 10 20 30 45 give pieces 10-20 20-30 30-45 10-30 20-45, and as many images."""
    counts = dict(zip(plain.terminals, np.diff(plain.first).tolist()))
    assert counts == {"run": 10, "shoot": 1, "pivot_left": 1, "pivot_right": 1, "catch": 2}
    assert len(plain.terminal) == 15 == len(plain.source)
    assert (np.diff(plain.terminal) >= 0).all()
    for number, name in enumerate(plain.terminals):
        assert (plain.terminal[list(plain.of(name))] == number).all()
    assert plain.n_frames[: len(plain.of("run"))].tolist() == [10, 20, 10, 25, 15] * 2


def test_steps_lead_to_where_the_capture_goes_on(plain: ClipLibrary) -> None:
    first = plain.of("run")[0]
    np.testing.assert_allclose(plain.step[first], [0.0, 1.0, 0.0], atol=1e-5)  # 10 frames at 3 m/s
    np.testing.assert_allclose(plain.path_of(first)[:, 1], np.arange(10) * 0.1, atol=1e-5)
    pivot = plain.of("pivot_left")[0]
    turned = np.radians(90.0) * 40 / 39  # one step beyond the capture's end, as the one before
    np.testing.assert_allclose(plain.step[pivot, 2], turned, atol=1e-4)


def test_the_image_of_a_left_pivot_is_a_right_pivot_and_shots_have_none(
    plain: ClipLibrary,
) -> None:
    left, right = plain.of("pivot_left")[0], plain.of("pivot_right")[0]
    assert plain.source[right] == ClipSource("pivot", 0, 40, mirrored=True, licence="CC0")
    np.testing.assert_allclose(plain.step[right], plain.step[left] * [-1, 1, -1], atol=1e-6)
    assert not any(source.mirrored for source in plain.source if source.capture == "shoot")
    unmirrored = make_library(shown(), TERMINALS, VariantSettings(mirror=False))
    assert not any(source.mirrored for source in unmirrored.source)
    assert len(unmirrored.of("pivot_right")) == 0


def test_instants_and_hands_are_where_they_were_written_down(plain: ClipLibrary) -> None:
    shot, catch = plain.of("shoot")[0], plain.of("catch")[0]
    assert plain.event_frame[shot] == 25
    assert plain.instant_of(shot) == 25
    assert plain.source[shot].instant == "events"
    assert plain.event_frame[plain.of("run")[0]] == -1
    assert plain.instant_of(plain.of("run")[0]) == 4
    joints, _ = retarget.motion_positions(SHOOT)
    place = body_frames(SHOOT).places[0]
    wrist = joints[25, body.INDEX["r_wrist"]]  # the arms are apart: the hand that throws
    there = compose(place, np.array([plain.hand[shot, 0], plain.hand[shot, 2], 0.0]))
    np.testing.assert_allclose(there[:2], wrist[[0, 2]], atol=1e-5)
    np.testing.assert_allclose(plain.hand[shot, 1], wrist[1], atol=1e-5)
    assert plain.event_frame[catch] == 12
    # no joint was named: between the hands, straight under the neck of a T-pose
    assert abs(plain.hand[catch, 0]) < 1e-5


def test_without_events_the_source_says_wrists() -> None:
    bare = [ShownMotion("shoot", "shoot", SHOOT, 0, 40, "release")]
    library = make_library(bare, ("shoot",), PLAIN)
    assert library.source[0].instant == "wrists"
    assert 0 <= library.event_frame[0] < 40


def test_seams_are_free_only_between_true_neighbours(plain: ClipLibrary) -> None:
    runs = list(plain.of("run"))
    for a in runs:
        for b in runs:
            one, other = plain.source[a], plain.source[b]
            cost = plain.seam[plain.seam_class[a], plain.seam_class[b]]
            neighbours = one.end == other.start and one.mirrored == other.mirrored
            assert (cost == 0.0) == neighbours or cost < 1e-3
    shot = plain.seam[plain.seam_class[runs[0]], plain.seam_class[plain.of("shoot")[0]]]
    assert shot > 2.7  # 2.7 m/s slower alone


def test_rest_is_far_from_running(plain: ClipLibrary) -> None:
    assert plain.rest.shape == (len(plain.seam), 2)
    run, catch = plain.seam_class[plain.of("run")[0]], plain.seam_class[plain.of("catch")[0]]
    np.testing.assert_allclose(plain.rest[run], 3.0, rtol=1e-3)
    np.testing.assert_allclose(plain.rest[catch], 0.3, rtol=1e-3)


def test_events_of_a_clip_count_from_its_first_frame_and_change_sides(plain: ClipLibrary) -> None:
    run = plain.of("run")
    mine = [plain.events[plain.seam_class[k]] for k in run]
    assert mine[0] == (Event(0, "foot_strike", "l_ankle", "ground"),)
    assert mine[1] == strikes(0, 10)
    assert mine[5] == (Event(0, "foot_strike", "r_ankle", "ground"),)


def test_variants_share_the_seams_of_their_clip(full: ClipLibrary) -> None:
    bent = [k for k in full.of("run") if full.source[k].bend and not full.source[k].mirrored]
    assert len(bent) == 5 * 6 * 5  # clips, bends, stretches
    assert len(np.unique(full.seam_class[bent])) == 5
    k = next(k for k in bent if full.source[k].stretch == 1.3 and full.source[k].bend > 0.6)
    assert full.step[k, 2] == pytest.approx(np.radians(40.0), abs=1e-6)
    assert np.hypot(*full.step[k, :2]) == pytest.approx(1.3, rel=0.03)
    assert full.source[k].edit == "bend 40 deg, stretch 1.3"


def test_the_poses_of_every_entry_go_along_its_path(full: ClipLibrary) -> None:
    rng = np.random.default_rng(0)
    at = (1.0, -2.0, 0.4)
    for k in rng.choice(len(full.source), 40, replace=False):
        motion = clip_motion(full.source[k], MOTIONS, at)
        assert motion.n_frames == full.n_frames[k]
        places = body_frames(motion).places
        np.testing.assert_allclose(relative(places, np.array(at)), full.path_of(int(k)), atol=1e-5)


def test_an_unedited_entry_is_its_capture(plain: ClipLibrary) -> None:
    shot = plain.of("shoot")[0]
    place = body_frames(SHOOT).places[0]
    motion = clip_motion(plain.source[shot], MOTIONS, tuple(place))
    np.testing.assert_allclose(motion.root_positions, SHOOT.root_positions, atol=1e-5)
    mine, _ = retarget.motion_positions(motion)
    theirs, _ = retarget.motion_positions(SHOOT)
    np.testing.assert_allclose(mine, theirs, atol=1e-5)


def test_frames_before_and_after_are_those_of_the_capture_held_at_its_ends() -> None:
    source = ClipSource("run", 10, 20)
    assert source_frames(source, 60, 2, 3).tolist() == list(range(8, 23))
    assert source_frames(ClipSource("run", 1, 59), 60, 2, 2).tolist()[-3:] == [58, 59, 59]
    motion = clip_motion(source, MOTIONS, before=2, after=3)
    np.testing.assert_allclose(motion.root_positions[:, 2], np.arange(-2, 13) * 0.1, atol=1e-5)
    np.testing.assert_allclose(motion.root_positions[:, 1], 0.93, atol=1e-6)


def test_a_capture_that_is_gone_is_named() -> None:
    with pytest.raises(SceneError, match="gone: expected the capture that a clip was taken from"):
        clip_motion(ClipSource("gone", 0, 5), MOTIONS)


def test_where_there_is_plenty_captures_are_left_out_evenly() -> None:
    many = [
        ShownMotion("run", f"run {n}", gliding(straight(60, 3.0, 0.0)), 0, 60, "",
                    strikes(10, 20, 30, 45))
        for n in range(7)
    ]  # fmt: skip
    few = VariantSettings(most=17, mirror=False)
    library = make_library(many, ("run",), few)
    assert sorted({source.capture for source in library.source}) == ["run 0", "run 3", "run 6"]
    one = make_library(many, ("run",), VariantSettings(most=1, mirror=False))
    assert {source.capture for source in one.source} == {"run 0"}


def test_nothing_shown_gives_an_empty_library() -> None:
    library = make_library([], ("run", "shoot"))
    assert len(library.source) == 0
    assert library.first.tolist() == [0, 0, 0]
    assert library.path.shape == library.step.shape == library.hand.shape == (0, 3)


def seam_ends(n: int, seed: int = 0) -> SeamEnds:
    rng = np.random.default_rng(seed)
    shape = (n, 2, 21, 3)
    return SeamEnds(
        captures=np.arange(n) % 3,
        starts=np.arange(n) * 10,
        ends=np.arange(n) * 10 + 30,
        entries=rng.normal(size=shape),
        exits=rng.normal(size=shape),
    )


def test_costs_equal_those_of_the_slow_twin() -> None:
    clips = seam_ends(150, seed=1)
    costs = seam_costs(clips)
    assert costs.dtype == np.float32
    rng = np.random.default_rng(2)
    for a, b in rng.integers(150, size=(200, 2)):
        pose = np.mean([np.linalg.norm(clips.exits[a, 0, j] - clips.entries[b, 0, j])
                        for j in range(21)])  # fmt: skip
        speed = np.mean([np.linalg.norm(clips.exits[a, 1, j] - clips.entries[b, 1, j])
                         for j in range(21)])  # fmt: skip
        follows = clips.captures[a] == clips.captures[b] and clips.ends[a] == clips.starts[b]
        expected = 0.0 if follows else pose / 0.10 + speed / 1.0
        np.testing.assert_allclose(costs[a, b], expected, rtol=1e-5)
    assert costs[0, 3] == 0.0  # frames 0..30 and 30..60 of capture 0
    assert costs[1, 2] > 0.0


def test_to_begin_and_to_stop_costs_as_much_as_one_moves() -> None:
    clips = seam_ends(3)
    clips.entries[:, 1] = 0.0
    clips.entries[0, 1, :, 2] = 3.0  # runs at 3 m/s when it begins
    clips.exits[:, 1] = 0.0
    clips.exits[1, 1, :7, 0] = 1.5  # a third of the joints moves when it ends
    np.testing.assert_allclose(rest_costs(clips), [[3.0, 0.0], [0.0, 0.5], [0.0, 0.0]])
