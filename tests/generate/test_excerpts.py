"""Excerpts: how they grow, are cut, and are repeated."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motiondb.body import body, pose_vectors, rotation
from motiondb.generate import cycles, excerpt_motion
from motiondb.generate.action_sources import Source, usual_directions
from motiondb.generate.excerpt_motion import ShownExcerpt
from motiondb.generate.excerpt_report import _say_places, miscounted
from motiondb.generate.excerpts import (
    CLEAR,
    COMPARABLE,
    Excerpt,
    Layout,
    Movement,
    find_excerpts,
    lay_out,
    number_places,
    recount,
)
from motiondb.generate.sentence_plan import Amount, PlannedAction


def _source(values: list[float], frames: int = 60) -> Source:
    starts = np.arange(len(values)) * frames
    rows = slice(0, len(values))
    return Source(7, rows, starts, starts + frames, np.array(values), 0.5)


@pytest.mark.parametrize(
    ("values", "frames", "spans"),
    [
        ([-4.0, 2.0, 1.0, -4.0], 60, {(60, 180)}),  # grows to what is nearly as good
        ([-9.0, -5.0, 3.0, -2.0, -9.0], 30, {(45, 120)}),  # 15 of -5, 30 of 3, 30 of -2
        ([3.0, -9.0], 20, {(0, 40)}),  # too short a capture is used whole
        ([0.0, 0.0, -9.0, 4.0, -9.0, 2.5], 90, {(270, 360), (450, 540)}),  # no approach alone
    ],
)
def test_excerpts_grow_to_their_length(values: list[float], frames: int, spans: set) -> None:
    assert {(e.start, e.end) for e in find_excerpts([_source(values, frames)], 150)} >= spans


def test_a_long_stretch_is_cut_into_windows() -> None:
    actual = find_excerpts([_source([2.0] * 6)], 150)
    assert len(actual) > 1
    assert {e.end - e.start for e in actual} == {150}
    assert all(e.start >= 0 and e.end <= 360 for e in actual)


def _wave(n_frames: int, period: int) -> np.ndarray:
    phase = 2 * np.pi * np.arange(n_frames) / period
    return np.stack([np.sin(phase), np.cos(phase) * 0.3], axis=1)


def _laid(action: PlannedAction, poses: np.ndarray) -> int:
    edges = np.concatenate([poses, poses[-1:]])
    return lay_out(action, (0, len(poses)), Movement(poses, edges)).n_frames


@pytest.mark.parametrize(
    ("frames", "asked", "laid"),
    [
        (100, {"times": Amount(1, 1)}, 25),
        (100, {"times": Amount(7, 7)}, 175),
        (80, {"seconds": Amount(10.0, 10.0)}, 300),
        (80, {"seconds": Amount(1.0, 1.0)}, 30),
    ],
)
def test_counts_and_durations_are_reached_by_cycles(frames: int, asked: dict, laid: int) -> None:
    assert _laid(PlannedAction((("walk",),), **asked), _wave(frames, 25)) == laid


def test_a_count_of_a_single_movement_repeats_the_whole() -> None:
    bump = np.exp(-0.5 * ((np.arange(90) - 45) / 8.0) ** 2)[:, None]
    action = PlannedAction((("jump",),), times=Amount(3, 3))
    actual = lay_out(action, (0, 90), Movement(bump, np.concatenate([bump, bump[-1:]])))
    assert len(actual.parts) == 3
    assert len(set(actual.parts)) == 1
    assert actual.said.endswith("3 times")


def test_what_is_over_when_it_is_done_is_not_lengthened() -> None:
    poses = _wave(70, 25)
    edges = np.concatenate([poses, poses[-1:]])
    action = PlannedAction((("stop",),))
    assert lay_out(action, (0, 70), Movement(poses, edges)).n_frames == 90
    assert lay_out(action, (0, 70), Movement(poses, edges, is_once=True)).parts == ((0, 70),)


def test_at_least_is_meant_strictly() -> None:
    poses = np.cumsum(np.random.default_rng(0).normal(size=(90, 3)), axis=0)
    edges = np.concatenate([poses, poses[-1:]])
    for seconds in (4.0, 5.0, 7.3, 10.0):
        action = PlannedAction((("climb",),), seconds=Amount(seconds, None))
        assert lay_out(action, (0, 90), Movement(poses, edges)).n_frames >= seconds * 30


def test_a_direction_that_captions_mostly_say_belongs_to_the_action() -> None:
    numbers = {"stand": 0, "up": 1, "still": 2, "back": 3}
    sources = [replace(_source([1.0]), beside=frozenset({w})) for w in (1, 1, 1, 2)]
    assert usual_directions(numbers, sources) == ("up",)
    assert usual_directions(numbers, sources[2:]) == ()
    assert usual_directions(numbers, []) == ()
    back = [replace(_source([1.0]), beside=frozenset({3}))]  # "bend back" goes nowhere
    assert usual_directions(numbers, back) == ()


def _measured(times: int, *occurrences: tuple[int, int]) -> Layout:
    poses = np.random.default_rng(0).normal(size=(200, 3)).cumsum(axis=0)
    edges = np.concatenate([poses, poses[-1:]])
    action = PlannedAction((("kick",),), times=Amount(times, times))
    return lay_out(action, (30, 130), Movement(poses, edges, True, occurrences))


def test_measured_occurrences_are_counted_one_by_one() -> None:
    occurrences = (40, 50), (70, 80), (100, 110)
    assert _measured(1, *occurrences).parts == ((30, 60),)
    assert _measured(1, *occurrences).said == "once, measured in the motion"
    assert _measured(2, *occurrences).parts == ((30, 90),)
    assert _measured(3, *occurrences).parts == ((30, 130),)
    assert _measured(3, *occurrences).said == "3 times, measured in the motion"


def test_too_few_measured_occurrences_are_repeated() -> None:
    layout = _measured(5, (45, 55), (85, 95))
    assert len(layout.parts) == 3
    first, second, last = layout.parts
    assert first == second
    assert first[0] <= 45
    assert first[1] >= 95
    assert last == (first[0], 70)
    assert "2 in an excerpt of" in layout.said
    assert layout.times == 5


def test_a_jumping_jack_has_two_flights() -> None:
    frames = np.arange(200)
    poses = np.column_stack([np.sin(2 * np.pi * frames / 36), np.zeros(200)])
    flights = tuple((n, n + 7) for n in range(9, 190, 18))
    movement = Movement(poses, np.zeros((201, 2)), occurrences=flights)
    action = PlannedAction((("jump", "jack"),), times=Amount(2, 2))
    layout = lay_out(action, (0, 200), movement)
    assert layout.said == "2 times, measured in the motion, 2 flights each"
    assert 63 + 7 <= layout.n_frames < 81  # the fourth flight is whole, the fifth is not there
    plain = lay_out(PlannedAction((("jump",),), times=Amount(2, 2)), (0, 200), movement)
    assert 27 + 7 <= plain.n_frames < 45


def _kicks(number: int) -> np.ndarray:
    """A measured track with a number of kicks of the left leg."""
    track = np.zeros((100, 20))
    track[:, 10], track[:, 16] = 5.0, 0.8  # quick, stretched
    for n in range(number):
        track[10 + 30 * n : 20 + 30 * n, 4] = 0.6
    return track


def test_a_number_is_said_only_if_the_motion_has_it() -> None:
    action = PlannedAction((("kick",),), times=Amount(3, 3))
    layout = _measured(3, (40, 50), (70, 80), (100, 110))
    shown = ShownExcerpt(action, Excerpt(7, 30, 130, 0.0, (30, 130)), layout)
    for number in (0, 1, 3):
        said = recount(action, layout, _kicks(number)).said
        left = [str(one.reason) for one in miscounted(shown, _kicks(number))]
        is_right = number == 3
        assert said == ("3 times, measured in the motion" if is_right else "")
        assert left == ([] if is_right else [f"{number} measured in the motion"])


def test_other_places_are_counted_in_words() -> None:
    excerpt = Excerpt(7, 30, 130, 0.0, (30, 130))
    shown = ShownExcerpt(PlannedAction((("kick",),)), excerpt, Layout(((30, 130),)), place=-1)
    assert _say_places(shown) == ["1 other excerpt shows it more clearly, but joins less well"]
    assert _say_places(replace(shown, n_places=2)) == [
        "2 other excerpts show it more clearly, but join less well"
    ]
    assert _say_places(replace(shown, does=False)) == []


def _number(
    spans: list[tuple[int, int, int]], values: list[float], does: list[bool] | None = None
) -> list[int]:
    excerpts = [Excerpt(c, a, b, 0.0, (a, b)) for c, a, b in spans]
    does = [True] * len(spans) if does is None else does
    numbers = number_places(excerpts, np.array(values), np.array(does, dtype=bool))
    return [int(number) for number in numbers]


def test_what_is_much_worse_is_no_place_unless_it_is_clear() -> None:
    spans = [(1, 0, 90), (2, 0, 90), (3, 0, 90)]
    assert _number(spans, [0.0, -COMPARABLE, -COMPARABLE - 0.1]) == [0, 1, -1]
    best = CLEAR + COMPARABLE + 3.0
    assert _number(spans, [best, CLEAR, CLEAR - 0.1]) == [0, 1, -1]


def test_what_does_not_do_what_is_measured_is_no_place_if_the_best_does() -> None:
    spans = [(1, 0, 90), (2, 0, 90)]
    assert _number(spans, [1.0, 0.9], [True, False]) == [0, -1]
    assert _number(spans, [1.0, 0.9], [False, False]) == [0, 1]


SPANS = st.tuples(st.integers(0, 3), st.integers(0, 200), st.integers(10, 90))


@given(st.lists(st.tuples(SPANS, st.floats(-4.0, 4.0)), min_size=1, max_size=20))
def test_numbers_run_from_the_best_on_without_gaps(drawn: list) -> None:
    spans = [(c, a, a + n) for (c, a, n), _ in drawn]
    values = [value for _, value in drawn]
    numbers = _number(spans, values)
    assert numbers[int(np.argmax(values))] == 0
    assert set(numbers) - {-1} == set(range(max(numbers) + 1))
    for number in set(numbers) - {-1}:
        assert len({spans[n][0] for n in range(len(spans)) if numbers[n] == number}) == 1


def _path(n_frames: int, speed: float) -> tuple[np.ndarray, np.ndarray]:
    path = np.zeros((n_frames, 4))
    path[:, 0], path[:, 2] = 0.9, speed
    return path, np.tile(rotation.IDENTITY, (n_frames, len(body.JOINTS), 1))


@given(st.floats(0.7, 1.4))
def test_another_rate_keeps_the_way(rate: float) -> None:
    path, turned = _path(61, 1.0)
    played, _ = excerpt_motion.resample(path, turned, rate)
    assert len(played) == int(60 / rate + 1e-9) + 1
    way = pose_vectors.from_path(path, turned).root_positions[-1, 2]
    turned = np.tile(turned[:1], (len(played), 1, 1))
    new = pose_vectors.from_path(played, turned).root_positions[-1, 2]
    assert new == pytest.approx(way, abs=rate / 30 + 1e-6)


def test_twice_the_rate_takes_every_second_frame() -> None:
    path, turned = _path(9, 1.0)
    path[:, 0] = np.arange(9)
    played, _ = excerpt_motion.resample(path, turned, 2.0)
    assert played[:, 0].tolist() == [0.0, 2.0, 4.0, 6.0, 8.0]
    assert played[:, 2].tolist() == [2.0] * 5


def test_speed_is_the_mean_over_the_joints() -> None:
    motion = pose_vectors.from_path(*_path(30, 1.5))
    np.testing.assert_allclose(excerpt_motion.joint_speeds(motion), 1.5, atol=1e-3)
    still = pose_vectors.from_path(*_path(1, 1.5))
    assert excerpt_motion.joint_speeds(still).tolist() == [0.0]


@given(st.floats(0.2, 4.0), st.lists(st.floats(0.2, 4.0), min_size=2, max_size=8), st.booleans())
def test_a_natural_rate_stays_within_the_captures(
    speed: float, speeds: list[float], fast: bool
) -> None:
    recorded = np.array([speed, *speeds])
    wanted = excerpt_motion.wanted_speed(recorded, fast)
    rate = excerpt_motion.natural_rate(speed, wanted, recorded, fast)
    assert recorded.min() - 1e-9 <= speed * rate <= recorded.max() + 1e-9
    assert (rate >= 1.0) if fast else (rate <= 1.0)
    assert 1.0 / excerpt_motion.MOST_CHANGE - 1e-9 <= rate <= excerpt_motion.MOST_CHANGE + 1e-9


def naive_self_difference(poses: np.ndarray, longest: int) -> list[float]:
    """D(T), one pair of frames after the other."""
    spread = 2.0 * sum(float(np.var(poses[:, d])) for d in range(poses.shape[1]))
    actual = [0.0]
    for lag in range(1, longest + 1):
        pairs = [(poses[t + lag] - poses[t]) for t in range(len(poses) - lag)]
        actual.append(float(np.mean([d @ d for d in pairs])) / spread)
    return actual


def test_self_difference_is_that_of_the_slow_twin() -> None:
    poses = np.random.default_rng(0).normal(size=(30, 3))
    np.testing.assert_allclose(
        cycles.self_difference(poses, 12), naive_self_difference(poses, 12), rtol=1e-9
    )


@given(st.integers(15, 40), st.integers(0, 100))
def test_the_period_of_a_wave_is_found(period: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    phase = 2 * np.pi * (np.arange(4 * period) / period + rng.random())
    poses = np.stack([np.sin(phase), np.cos(phase)], axis=1)
    poses += rng.normal(scale=0.02, size=poses.shape)
    actual = cycles.find_period(poses)
    assert actual is not None
    assert abs(actual - period) <= 1


@given(st.integers(0, 9), st.integers(1, 20), st.integers(0, 6), st.integers(0, 15))
def test_repetition_plays_the_loop_more_often(a: int, length: int, times: int, rest: int) -> None:
    loop = cycles.Loop(a, a + length, 0.0)
    parts = cycles.repeat(0, a + length + rest, loop, times)
    assert sum(end - start for start, end in parts) == a + length + rest + times * length
    assert parts[0][0] == 0
    assert parts[-1][1] == a + length + rest
    assert all(after[0] == a and before[1] == a + length
               for before, after in itertools.pairwise(parts))  # fmt: skip
