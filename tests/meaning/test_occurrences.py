"""Events in a track that is made by hand: seats, rises, bows, turns, cartwheels, flips, degrees."""

from __future__ import annotations

import numpy as np
import pytest

from motiondb.meaning.amounts import Degree, degree_of
from motiondb.meaning.direction import gone_anywhere, trodden_anywhere
from motiondb.meaning.limb_sides import HAND_PLACES
from motiondb.meaning.occurrences import event_of, find_occurrences
from motiondb.meaning.postures import EVERY_POSTURE, STANDING, posture_of
from motiondb.meaning.travelled import longest_going, steady_speed
from motiondb.records import FloatArray

HEIGHT, AHEAD, TURNING, LEAN = 0, 2, 3, 14
FEET, THIGHS = slice(4, 6), slice(20, 22)


def standing(n_frames: int = 150) -> FloatArray:
    """The track of somebody who stands still."""
    track = np.zeros((n_frames, 22))
    track[:, HEIGHT] = STANDING
    return track


def seated(first: int, behind: int, n_frames: int = 150) -> FloatArray:
    """The track of somebody who sits from one frame to another."""
    track = standing(n_frames)
    track[first:behind, THIGHS] = 1.4
    track[first:behind, HEIGHT] = 0.5
    return track


def test_who_sits_down_and_stands_up() -> None:
    track = seated(40, 100)
    assert find_occurrences(track, "sit") == [(40, 100)]
    assert find_occurrences(track, "seat") == [(20, 60)]
    assert find_occurrences(track, "rise") == [(90, 120)]


def test_who_sits_from_the_first_to_the_last_frame_neither_sits_down_nor_stands_up() -> None:
    track = seated(0, 150)
    assert find_occurrences(track, "sit") == [(0, 150)]
    assert find_occurrences(track, "seat") == find_occurrences(track, "rise") == []


def test_a_squat_is_no_seat() -> None:
    track = seated(40, 60)  # 0.7 s
    assert find_occurrences(track, "sit") == []
    assert find_occurrences(track, "squat") == [(40, 60)]


def test_a_seat_is_no_squat() -> None:
    """Feet ahead of the pelvis do not bear it."""
    track = standing()
    track[40:80, HEIGHT] -= 0.4
    assert find_occurrences(track, "squat") == [(40, 80)]
    track[40:80, 18:20] = 0.35
    assert find_occurrences(track, "squat") == []
    assert find_occurrences(track, "duck") == [(40, 80)]


def test_who_bows_is_not_upside_down() -> None:
    track = standing()
    track[30:60, LEAN] = 1.0
    assert find_occurrences(track, "bow") == find_occurrences(track, "bend") == [(30, 60)]
    assert find_occurrences(track, "cartwheel") == find_occurrences(track, "roll") == []


def test_upside_down_with_what_leads_there() -> None:
    """A second upside down is a handstand; a flip is shorter, and in the air."""
    track = standing()
    track[30:70, LEAN] = 0.8
    track[35:65, LEAN] = 3.0
    assert find_occurrences(track, "handstand") == []  # who bends down stays on the feet
    track[35:65, FEET] = 1.5
    assert find_occurrences(track, "handstand") == [(30, 70)]
    assert find_occurrences(track, "cartwheel") == [(30, 70)]
    assert find_occurrences(track, "roll") == [(35, 65)]
    assert find_occurrences(track, "flip") == []
    quick = standing()
    quick[30:50, LEAN] = 0.8
    quick[35:45, LEAN] = 3.0
    assert find_occurrences(quick, "flip") == find_occurrences(quick, "handstand") == []
    quick[35:45, HEIGHT], quick[35:45, FEET] = STANDING + 0.2, 1.5
    assert find_occurrences(quick, "flip") == [(30, 50)]


def test_a_hand_is_lowered_that_comes_to_hang_down_from_the_shoulder() -> None:
    track = np.hstack([standing(), np.zeros((150, 6))])
    track[:, 22:24] = -0.5
    track[30:60, 22] = 0.2  # the left hand, which then hangs
    track[80:150, 23] = 0.2  # the right hand stays up
    assert find_occurrences(track, "lower left") == find_occurrences(track, "lower") == [(45, 61)]
    assert find_occurrences(track, "lower right") == find_occurrences(track, "lower both") == []
    track[60:110, 22] = -0.1  # it stays half way
    assert find_occurrences(track, "lower") == []


def test_the_stride_of_a_run_is_no_jump() -> None:
    """Flights of 9 cm: one in place, one at 3 m/s, and one at 3 m/s that rises by 25 cm."""
    track = standing(200)
    for start, speed, height in ((20, 0.0, 0.09), (80, 3.0, 0.09), (140, 3.0, 0.25)):
        track[start - 10 : start + 20, AHEAD] = speed
        track[start : start + 10, HEIGHT] += height
        track[start : start + 10, FEET] = 0.3
    assert find_occurrences(track, "jump") == [(20, 30), (140, 150)]


def test_walks_and_runs_last() -> None:
    track = standing(300)
    track[20:100, AHEAD], track[120:200, AHEAD], track[220:228, AHEAD] = 1.2, 3.0, 1.2
    (walk,), (run,) = (find_occurrences(track, word) for word in ("walk", "run"))
    assert np.abs(np.subtract((*walk, *run), (20, 100, 120, 200))).max() < 10
    track[:, LEAN] = 1.2  # on hands and feet
    assert find_occurrences(track, "walk") == []


def test_turns_and_spins_go_far_enough_to_one_side() -> None:
    track = standing()
    track[30:60, TURNING] = 1.0  # 1 rad
    track[90:120, TURNING] = -3.0  # 3 rad
    assert find_occurrences(track, "turn") == [(30, 60), (90, 120)]
    assert find_occurrences(track, "spin") == [(90, 120)]


@pytest.mark.parametrize(
    ("words", "event"),
    [
        (("jump", "jack"), "jump"),
        (("turn", "around"), "turn"),
        (("pirouette",), "spin"),
        (("get", "up"), "rise"),
        (("jump", "up"), "jump"),
        (("walk",), ""),
    ],
)
def test_the_event_of_an_action(words: tuple[str, ...], event: str) -> None:
    assert event_of(words) == event


def test_degrees_of_speed_height_and_way() -> None:
    """The fastest second within the part, and the rise and the way of its flights."""
    track = standing()
    track[:60, AHEAD], track[60:, AHEAD] = 1.0, 3.0
    speed = Degree("speed", 1.0, frozenset())
    assert speed.amount(track, 0, 60) == pytest.approx(1.0)
    assert speed.amount(track, 0, 150) == pytest.approx(3.0)
    track[100:110, HEIGHT], track[100:110, FEET] = STANDING + 0.25, 0.3
    assert Degree("height", 1.0, frozenset()).amount(track, 0, 150) == pytest.approx(0.25)
    assert Degree("way", 1.0, frozenset()).amount(track, 0, 150) == pytest.approx(1.0)
    assert np.isnan(Degree("way", 1.0, frozenset()).amount(track, 0, 90))
    assert degree_of(("walk", "slow", "fast")) is None
    walked = np.hstack([track, np.zeros((150, 6))])
    walked[:, 18] = 0.3 * np.sign(np.sin(np.arange(150) * np.pi / 15 + 0.1))  # every .5 s, at 1 m/s
    assert Degree("step", 1.0, frozenset()).amount(walked, 0, 60) == pytest.approx(0.5)
    assert degree_of(("walk", "slow", "long", "step")).measure == "speed"


def test_degrees_of_turns_and_squats_are_those_of_their_events() -> None:
    """The fastest half second of a turn, and how low a squat is; nothing where there is none."""
    track = standing()
    track[20:50, 3], track[70:90, 3] = 2.0, 6.0
    quick = degree_of(("turn", "left", "quick"))
    assert quick is not None
    assert quick.amount(track, 0, 60) == pytest.approx(np.degrees(2.0))
    assert quick.amount(track, 60, 150) == pytest.approx(np.degrees(6.0))
    track[100:130, HEIGHT] -= 0.4
    deep, high = degree_of(("squat", "deep")), degree_of(("kick", "high"))
    assert deep is not None
    assert high is not None
    assert deep.amount(track, 60, 150) == pytest.approx(0.4)
    assert np.isnan(deep.amount(track, 0, 60))
    assert np.isnan(high.amount(track, 0, 150))


def test_who_rests_does_not_go_on() -> None:
    speeds = np.zeros((90, 3))
    speeds[30:, 1] = 1.5
    lasting, first, behind = longest_going(steady_speed(speeds), ("stand", "still"))
    assert (first, lasting) == (0, behind / 15.0)
    assert 20 <= behind <= 30


def test_feet_that_rise_walk_up_and_hips_that_rise_alone_do_not() -> None:
    track = standing()
    track[:50, HEIGHT] -= 0.3  # crouches first
    assert gone_anywhere(track, "up") == pytest.approx(2.0)
    assert trodden_anywhere(track, "up") == pytest.approx(0.0)
    track[50:, 4:6] += 0.3
    assert trodden_anywhere(track, "up") == pytest.approx(2.0)
    assert trodden_anywhere(track, "down") == pytest.approx(0.0)


def test_going_up_is_looked_for_in_the_whole_take() -> None:
    track = standing()
    track[50:100, HEIGHT] += 0.3
    assert gone_anywhere(track, "up") == pytest.approx(2.0)
    assert gone_anywhere(track[:40], "up") == pytest.approx(0.0)


@pytest.mark.parametrize(
    ("action", "posture"),
    [
        (("raise", "left", "knee"), "lift left"),
        (("stay", "low"), "low"),
        (("stoop", "over"), "stoop"),
        (("land", "theone", "foot"), "land one"),
        (("land", "both", "foot"), "land both"),
        (("takeoff", "left", "foot"), "takeoff left"),
        (("hand", "hip"), "at any hip"),
        (("jump", "low"), ""),
        (("lunge", "forward"), "lunge"),
        (("crawl", "floor"), "allfours"),
    ],
)
def test_the_posture_of_an_action(action: tuple[str, ...], posture: str) -> None:
    assert posture_of(action) == posture
    assert not posture or posture in EVERY_POSTURE


def test_lunges_and_all_fours() -> None:
    track = np.hstack([standing(), np.zeros((150, 7))])
    track[:, 26:28] = 0.5
    track[20:50, 18], track[20:40, HEIGHT] = 0.7, STANDING - 0.15  # the left foot is ahead
    assert find_occurrences(track, "lunge") == [(20, 40)]
    track[80:110, [HEIGHT, 14]] = 0.5, 1.2
    assert find_occurrences(track, "allfours") == []
    track[80:110, 26] = 0.1
    track[85:110, 28] = 2.0 ** HAND_PLACES.index("floor")
    assert find_occurrences(track, "allfours") == [(85, 110)]


def test_postures_last_while_they_are_held() -> None:
    """A raised knee, a bent trunk and low walking, each for half a second; and two landings."""
    track = np.hstack([standing(), np.zeros((150, 6))])
    track[10:35, 20], track[20:35, 4] = 1.4, 0.2  # the left thigh is level, then its foot is up
    assert find_occurrences(track, "lift left") == [(20, 35)]
    assert find_occurrences(track, "lift right") == []
    track[40:55, HEIGHT] -= 0.2
    assert find_occurrences(track, "low") == [(40, 55)]
    track[60:75, 14] = 0.6
    assert find_occurrences(track, "stoop") == [(60, 75)]
    for start, foot in ((90, 4), (120, 5)):
        track[start : start + 10, HEIGHT], track[start : start + 10, FEET] = STANDING + 0.25, 0.3
        track[start + 10 : start + 20, foot] = 0.3  # stays in the air
    assert [len(find_occurrences(track, f"land {side}")) for side in ("left", "right")] == [1, 1]
    assert find_occurrences(track, "land both") == []
    assert len(find_occurrences(track, "land one")) == 2
    assert [a for a, _ in find_occurrences(track, "takeoff both")] == [84, 114]
    assert find_occurrences(track, "takeoff one") == []
    (landing,) = find_occurrences(track, "land left")  # backwards in time
    assert find_occurrences(track[::-1].copy(), "takeoff left") == [
        (150 - landing[1], 150 - landing[0])
    ]
    aloft = track[89:118].copy()  # the take begins just before
    aloft[2:11, 5] = 0.0
    assert find_occurrences(aloft, "land one")[0][0] == 0
