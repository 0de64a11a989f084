"""Words of direction, measured in the motion."""

import numpy as np
import pytest

from motiondb.body import body, rotation
from motiondb.meaning import direction
from motiondb.meaning.direction import furthest_part, gone
from motiondb.meaning.extents import whole_occurrences
from motiondb.meaning.occurrences import COUNTED, find_occurrences, measured_track
from motiondb.records import FloatArray, Motion

HEIGHT, SIDEWAYS, AHEAD, YAW = range(4)
Steps = tuple[tuple[float, int], ...]


def path_of(column: int, *steps: tuple[float, int]) -> np.ndarray:
    """A path (frames, 4) with one column in steps of (value, frames)."""
    path = np.zeros((sum(n for _, n in steps), 4))
    path[:, column] = np.concatenate([np.full(n, value) for value, n in steps])
    return path


RUN, REST = (1.2, 60), (0.0, 30)


@pytest.mark.parametrize(
    ("column", "steps", "gone"),
    [
        (HEIGHT, ((0.5, 60), (0.8, 60)), {"up": 2.0, "down": -2.0}),
        (HEIGHT, ((0.9, 60), (1.3, 12), (0.9, 60)), {"up": 0.0}),  # a jump is no way up
        (YAW, ((0.7, 30),), {"turn left": 1.0, "left": 1.0, "right": 0.0}),
        (SIDEWAYS, ((0.4, 30),), {"sideways": 1.0, "left": 1.0, "turn left": 0.0}),
        (SIDEWAYS, ((-0.2, 30),), {"sideways": 0.5, "right": 0.5}),
        (YAW, ((1.4, 30), (0.0, 31)), {"turn": 2.0, "turn around": 1.4 / 2.1 / 2.0}),
        (YAW, ((-2.5, 30), (0.0, 31)), {"turn": 2.5 / 0.7, "turn around": 1.0}),
        (AHEAD, ((-0.3, 30),), {"backward": 1.0, "forward": 0.0, "stationary": 1.0}),
        (AHEAD, ((1.0, 60),), {"forward": 4.0, "stationary": 14 / 60 / 0.8 / 2.0}),
        (AHEAD, (RUN, REST), {"stop": 1.2, "start": 0.0}),
        (AHEAD, (REST, RUN), {"start": 1.2}),
        (AHEAD, (REST, RUN, REST), {"stop": 1.2}),
        (AHEAD, (RUN, REST, RUN), {"stop": 0.0}),
        (AHEAD, ((3.5, 60), (1.5, 60)), {"stop": 0.0}),  # to run slower is no stop
    ],
)
def test_words_of_direction_are_measured(column: int, steps: Steps, gone: dict) -> None:
    path = path_of(column, *steps)
    actual = {word: direction.gone(path, word) for word in gone}
    assert actual == pytest.approx(gone)


def test_the_furthest_part_is_the_shortest_that_goes_nearly_as_far() -> None:
    assert direction.furthest_part(path_of(HEIGHT, (0.5, 50), (0.9, 80)), "up", 130) == (49, 51)
    first, behind = direction.furthest_part(path_of(AHEAD, RUN, REST, RUN), "stop", 90)
    assert 55 <= first <= 60 < behind <= 70  # cut where the speed falls


def test_a_jump_leaves_the_usual_height_and_a_run_does_not() -> None:
    height = np.full((90, 1), 0.9)
    jump, run = np.zeros((90, 6)), np.zeros((90, 6))
    jump[:, :1] = run[:, :1] = height
    jump[40:49, [0, 4, 5]] += 0.3
    run[:, 0] += 0.04 * np.sin(2 * np.pi * np.arange(90) / 10)
    assert direction.gone(jump, "jump") == pytest.approx(9 / 30 / 0.2)
    assert direction.gone(run, "hop") < 0.5
    assert direction.gone(np.full((90, 6), 0.9), "hop") == 0.0


N_FRAMES = 150


def _track() -> np.ndarray:
    """Somebody who stands on both feet, arms down."""
    track = np.zeros((N_FRAMES, 20))
    track[:, 0] = 0.9
    track[:, 16:18] = body.LEG_LENGTH
    return track


def _fly(track: np.ndarray, start: int, end: int, feet: tuple[slice, slice]) -> None:
    """A flight; each foot is up in some frames."""
    track[start:end, 0] = 1.1
    for foot, frames in enumerate(feet):
        track[frames, 4 + foot] = 0.2


def test_flights_are_counted() -> None:
    track = _track()
    for start in (30, 90):
        _fly(track, start, start + 10, (slice(start, start + 10), slice(start, start + 10)))
    for word in ("jump", "leap", "jete", "hop"):
        assert find_occurrences(track, word) == [(30, 40), (90, 100)]
    track[60:62, 0] = 1.1  # too short
    assert len(find_occurrences(track, "jump")) == 2


@pytest.mark.parametrize(
    ("left", "right", "hops", "leaps"),
    [
        ((50, 60), (30, 80), 1, 1),  # on the left foot
        ((30, 80), (50, 60), 1, 1),  # on the right foot
        ((50, 60), (50, 60), 1, 1),  # with both feet
        ((30, 60), (50, 80), 0, 1),  # from the right foot to the left: a leap
        ((30, 50), (50, 80), 0, 0),  # one foot is always on the ground
    ],
)
def test_a_hop_ends_on_a_foot_that_it_began_on(
    left: tuple[int, int], right: tuple[int, int], hops: int, leaps: int
) -> None:
    track = _track()
    _fly(track, 50, 60, (slice(*left), slice(*right)))
    assert len(find_occurrences(track, "hop")) == hops
    assert len(find_occurrences(track, "leap")) == leaps
    assert gone(track, "hop") == pytest.approx(hops)


def test_a_hop_on_one_leg_has_the_other_foot_above_it() -> None:
    both, left = _track(), _track()
    _fly(both, 50, 60, (slice(50, 60), slice(50, 60)))
    _fly(left, 50, 60, (slice(50, 60), slice(30, 80)))
    for word, hops in (("hop left", 1), ("hop one", 1), ("hop right", 0)):
        assert len(find_occurrences(left, word)) == hops
        assert gone(left, word) == pytest.approx(hops)
        assert find_occurrences(both, word) == []


def test_kicks_of_both_legs_at_once_are_one() -> None:
    track = _track()
    track[20:32, 4] = track[28:40, 5] = track[80:90, 5] = 0.8
    track[15:25, 10] = track[25:35, 11] = track[78:85, 11] = 5.0
    track[110:120, 4] = 0.3  # a step
    assert find_occurrences(track, "kick") == [(20, 40), (80, 90)]
    assert gone(track, "kick") == pytest.approx(2.0)
    assert furthest_part(track, "kick", 30) == (79, 89)


@pytest.mark.parametrize(
    ("column", "value"),
    [(10, 2.0), (16, 0.5), (14, 1.3), (18, -0.4)],
    ids=["slow", "bent", "upside down", "behind"],
)
def test_no_kick_is_slow_or_bent_or_upside_down_or_behind(column: int, value: float) -> None:
    track = _track()
    track[20:32, 4], track[18:32, 10] = 0.8, 5.0
    assert find_occurrences(track, "kick") == [(20, 32)]
    track[:, column] = value
    assert find_occurrences(track, "kick") == []


def test_who_climbs_stands_higher_and_who_hangs_or_sits_does_not() -> None:
    track = _track()
    track[:, 0] = body.LEG_LENGTH + body.ANKLE_HEIGHT
    track[60:, 4:6] = 0.5  # hangs
    assert gone(track, "climb") == 0.0
    track[60:, 0] += 0.6
    assert gone(track, "climb") == pytest.approx(0.5 / 0.4)
    assert gone(track[::-1], "climb") == 0.0
    track[:, 4:6] = 0.0
    assert gone(track, "climb") == 0.0


def test_what_lacks_of_a_side_is_the_share_of_the_other_limb() -> None:
    track = _track()
    track[:, 7], track[:, 9], track[:, 11] = 1.0, 2.0, 3.0  # hands at 1 and 2 m/s; the right foot
    amounts = {limb: gone(track, limb) for limb in ("right hand", "left hand", "right foot")}
    assert amounts == pytest.approx({"right hand": 1.2, "left hand": 0.3, "right foot": 1.5})
    assert gone(_track(), "left hand") == 0.0  # both rest
    track[:50, 7] = 3.0
    assert furthest_part(track, "left hand", 90)[1] <= 50


def test_the_side_of_a_punch_is_that_of_the_hand_that_goes_out() -> None:
    track = _track()
    track[:, 7] = track[:, 9] = 2.0  # both hands move alike
    track[:, 13] = 2.0  # the right one goes out
    assert gone(track, "right hand") == gone(track, "left hand") == pytest.approx(0.75)
    assert gone(track, "right hand out") == pytest.approx(1.5)
    assert gone(track, "left hand out") == 0.0


@pytest.mark.parametrize(
    ("column", "value", "word", "amount"),
    [
        (14, 0.7, "bend", 1.0),
        (14, 0.7, "bow", 1.4),
        (14, 1.0, "cartwheel", 0.5),
        (0, 0.6, "squat", 1.0),
        (0, 0.8, "crouch", 0.5),
        (15, 1.3, "duck", 1.0),
    ],
)
def test_postures_are_measured_at_their_extreme(
    column: int, value: float, word: str, amount: float
) -> None:
    track = _track()
    track[:, 15] = 1.6
    assert gone(track, word) == 0.0
    track[60:70, column] = value
    assert gone(track, word) == pytest.approx(amount)
    first, behind = furthest_part(track, word, 60)
    assert first <= 60 < behind


def test_a_punch_begins_quickly() -> None:
    track = _track()
    track[20:25, 6] = track[60:90, 6] = track[100:104, 8] = 1.0
    track[17:20, 7] = 4.0
    track[55:60, 7] = 0.8  # reaching
    track[98:101, 9] = 2.5
    assert find_occurrences(track, "punch") == [(20, 25), (100, 104)]


def test_a_hand_that_stays_out_does_not_hide_the_punch_of_the_other() -> None:
    track = _track()
    for hand, start, end in ((6, 10, 42), (8, 40, 72), (6, 70, 100), (8, 72, 90)):
        track[start:end, hand] = 1.0
        track[start - 2 : start, hand + 1] = 4.0
    # the last two go out together
    assert find_occurrences(track, "punch") == [(10, 40), (40, 70), (70, 100)]
    assert gone(track, "punch") == pytest.approx(3.0)


def test_a_track_is_measured_in_a_motion() -> None:
    rotations = np.tile(np.array([1.0, 0.0, 0.0, 0.0]), (60, len(body.JOINTS), 1))
    roots = np.tile([0.0, body.LEG_LENGTH + body.ANKLE_HEIGHT, 0.0], (60, 1))
    lifted = rotations.copy()
    quarter = rotation.from_axis_angle(np.array([1.0, 0.0, 0.0]), np.array(-np.pi / 2.0))
    lifted[20:30, body.INDEX["l_hip"]] = quarter
    for local, kicks in ((rotations, []), (lifted, [(20, 30)])):
        motion = Motion(local.astype(np.float32), roots.astype(np.float32), body.LEG_LENGTH)
        track = measured_track(motion)
        assert track.shape == (60, 37)
        np.testing.assert_allclose(track[:10, :6], [[0.93, 0, 0, 0, 0, 0]] * 10, atol=1e-3)
        assert find_occurrences(track, "kick") == kicks
        assert all(find_occurrences(track, word) == [] for word in COUNTED if word != "kick")


def _posed(angles: dict[str, tuple[float, float, float]], height: float) -> FloatArray:
    """The track of a body with hanging arms that takes a pose from frame 30 to 90.

    `angles`: Joint -> its rotation vector, rad; `height`: that of the pelvis in the pose, m.
    """
    rotations = np.tile(np.array([1.0, 0.0, 0.0, 0.0]), (120, len(body.JOINTS), 1))
    roots = np.tile([0.0, body.LEG_LENGTH + body.ANKLE_HEIGHT, 0.0], (120, 1))
    roots[30:90, 1] = height
    hanging = {"l_shoulder": (0.0, 0.0, -UP), "r_shoulder": (0.0, 0.0, UP)}
    for part, pose in ((slice(None), hanging), (slice(30, 90), angles)):
        for joint, vector in pose.items():
            size = float(np.linalg.norm(vector))
            turned = rotation.from_axis_angle(np.array(vector) / size, np.array(size))
            rotations[part, body.INDEX[joint]] = turned
    motion = Motion(rotations.astype(np.float32), roots.astype(np.float32), body.LEG_LENGTH)
    return measured_track(motion)


UP, LEVEL, FOLDED = 1.4, np.pi / 2, 1.9  # Angles of an arm, a trunk and a knee, rad


@pytest.mark.parametrize(
    ("angles", "height", "shown"),
    [
        ({"l_shoulder": (0.0, 0.0, UP)}, 0.93, {"raise", "raise left", "overhead left"}),
        ({"r_shoulder": (0.0, 0.0, -UP)}, 0.93, {"raise right", "overhead", "overhead right"}),
        (
            {"l_shoulder": (0.0, 0.0, UP), "r_shoulder": (0.0, 0.0, -UP)},
            0.93,
            {"raise both", "overhead left", "overhead right", "overhead both"},
        ),
        ({"pelvis": (-LEVEL, 0.0, 0.0)}, 0.12, {"lie"}),
        ({"l_knee": (FOLDED, 0.0, 0.0), "r_knee": (FOLDED, 0.0, 0.0)}, 0.5, {"kneel"}),
        ({"l_knee": (FOLDED, 0.0, 0.0)}, 0.93, {"on right leg", "on one leg"}),
    ],
)
def test_a_posture_is_seen_where_it_is_held(
    angles: dict[str, tuple[float, float, float]], height: float, shown: set[str]
) -> None:
    track = _posed(angles, height)
    sided = [
        f"{what} {side}" for what in ("raise", "overhead") for side in ("left", "right", "both")
    ]
    every = [
        *sided,
        "raise",
        "overhead",
        "lie",
        "kneel",
        "on left leg",
        "on right leg",
        "on one leg",
    ]
    found = {posture for posture in every if find_occurrences(track, posture)}
    plain = {posture.split()[0] for posture in shown if posture.startswith(("raise", "over"))}
    arms = {f"raise {p.split()[1]}" for p in shown if p.startswith("overhead ")}
    assert found == shown | plain | arms
    assert all(find_occurrences(track, posture) == [(30, 90)] for posture in found)


@pytest.mark.parametrize(
    ("column", "value", "word"), [(0, 0.55, "squat"), (14, 0.6, "bow"), (0, 0.6, "duck")]
)
def test_who_goes_down_and_comes_back_twice_is_counted_twice(
    column: int, value: float, word: str
) -> None:
    track = _track()
    track[:, 15] = 1.6
    standing = track[0, column]
    for start in (30, 90):
        track[start : start + 20, column] = value
    track[130:140, column] = standing + 0.3 * (value - standing)  # not far enough
    assert find_occurrences(track, word) == [(30, 50), (90, 110)]
    (first, behind), (second, last) = whole_occurrences(track, word)
    assert first < 30 < 50 < behind <= second < 90 < 110 < last


def test_a_whole_jump_begins_before_its_crouch_and_ends_after_its_landing() -> None:
    track = _track()
    track[40:55, 0] = np.linspace(0.9, 0.6, 15)
    track[55:60, 0] = np.linspace(0.6, 0.95, 5)
    track[60:70, 0], track[60:70, 4:6] = 1.2, 0.3
    track[70:85, 0] = np.linspace(0.6, 0.9, 15)
    assert len(find_occurrences(track, "jump")) == 1
    ((first, behind),) = whole_occurrences(track, "jump")
    assert 30 < first <= 40
    assert 84 < behind < 95
    track[:45] = track[45]  # the capture begins in the crouch: the calmest frame there is
    assert whole_occurrences(track, "jump")[0][0] < 50
