"""Search by a rhythm: against all pairings of all parts, and steps of known times."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

import motiondb
from motiondb.errors import QueryError
from motiondb.records import MOTION_FPS
from motiondb.search.by_rhythm import GAP, MOST_OFF, PER_OCTAVE, SLOWEST, parts_in, read_rhythm

SKIP = [0.0, 0.25, 0.7, 0.95, 1.4, 1.65, 2.1]  # short, long


def test_a_worked_number() -> None:
    """Taps at 0, .5 and 1.2 s are .1 s off steps at 3, 3.6 and 4.2 s, and .3 s off for two gaps."""
    taps = read_rhythm([5.0, 5.5, 6.2])
    (one,) = parts_in({7: np.array([3.0, 3.6, 4.2])}, taps, [7])
    assert one.deviation == pytest.approx(0.1)
    assert (one.capture, one.start, one.end, one.said) == (7, 90, 126, "100 ms off the rhythm")
    (two,) = parts_in({7: np.array([3.0, 4.2])}, taps, [7])
    assert two.deviation == pytest.approx(GAP)
    assert two.said == "150 ms off the rhythm, 1 step fewer"
    assert not parts_in({7: np.array([3.0, 3.5]), 8: np.zeros(0)}, taps, [7, 8])  # too short


def naive_deviation(taps: list[float], steps: list[float]) -> float:
    """The deviation of a part from its first to its last step, by all pairings."""
    r = (steps[-1] - steps[0]) / (taps[-1] - taps[0])
    wanted = [tap - taps[0] for tap in taps[1:-1]]
    inside = [(step - steps[0]) / r for step in steps[1:-1]]
    least = np.inf
    for n in range(min(len(wanted), len(inside)) + 1):
        for some in combinations(wanted, n):
            for others in combinations(inside, n):
                alone = len(wanted) + len(inside) - 2 * n
                least = min(least, sum(abs(a - b) for a, b in zip(some, others)) + GAP * alone)
    return least / len(wanted) + PER_OCTAVE * abs(np.log2(r))


def test_parts_are_the_best_of_all_pairings_of_all_parts() -> None:
    rng = np.random.default_rng(0)
    steps = {n: np.cumsum(rng.uniform(0.15, 0.9, size=14)) for n in (1, 4, 6)}
    taps = [0.3, *(0.3 + np.cumsum(rng.uniform(0.2, 0.7, size=5)))]
    found = {one.capture: one for one in parts_in(steps, read_rhythm(taps), [1, 6, 9])}
    assert sorted(found) == [1, 6]
    for number, one in found.items():
        every = {}
        for j, k in combinations(range(14), 2):
            part = steps[number][j : k + 1].tolist()
            if 1 / SLOWEST <= (part[-1] - part[0]) / (taps[-1] - taps[0]) <= SLOWEST:
                every[part[0], part[-1]] = naive_deviation(taps, part)
        (start, end), least = min(every.items(), key=lambda each: each[1])
        assert one.deviation == pytest.approx(least, abs=1e-12)
        assert (one.start, one.end) == (round(MOTION_FPS * start), round(MOTION_FPS * end))


def test_jitter_finds_the_cadence_and_a_skip_is_no_walk() -> None:
    rng = np.random.default_rng(1)
    jitters = {n: n + np.arange(16) / rate for n, rate in ((1, 2.0), (2, 1.7), (3, 2.8))}
    skip = np.cumsum([5.0, *[0.25, 0.45] * 5])
    steps = {n: at + 0.02 * rng.normal(size=len(at)) for n, at in ({**jitters, 4: skip}).items()}
    for rate, first in ((2.0, 1), (2.8, 3)):
        for _ in range(20):
            taps = np.arange(7) / rate + 0.04 * rng.normal(size=7)
            found = sorted(parts_in(steps, read_rhythm(taps), steps), key=lambda o: o.deviation)
            assert found[0].capture == first
    found = sorted(parts_in(steps, read_rhythm(SKIP), steps), key=lambda one: one.deviation)
    assert found[0].capture == 4
    assert found[0].deviation < MOST_OFF < found[1].deviation


@pytest.mark.parametrize(
    ("taps", "said"),
    [
        ("0 x 1", "expected the times of 3 to 200 taps"),
        ("0 1", "expected the times of 3 to 200 taps"),
        ("0 1 1_0", "expected the times of 3 to 200 taps"),
        ("0 1 .5", "expected times of taps in their order"),
        ("0 .5 nan", "expected times of taps in their order"),
        ("0 .5 .55", "0.1 s apart or more"),
        ("0 30 61", "found 61 s"),
    ],
)
def test_what_is_no_rhythm_is_refused(taps: str, said: str) -> None:
    with pytest.raises(QueryError, match=said):
        read_rhythm(taps)


def test_a_rhythm_with_words_is_that_of_a_gait(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        strikes = sorted(
            e.seconds for e in db.captures.gait("ana/walk_1").events if e.name == "foot_strike"
        )
        answer = db.captures.rhythm(strikes[:5], "walk", limit=5)
        assert answer.read_as == "walk"
        assert answer.matches_anything
        mine = next(match for match in answer.matches if match.capture == "ana/walk_1")
        assert abs(mine.start - strikes[0]) < 0.05
        assert abs(mine.end - strikes[4]) < 0.05
        assert "ms off the rhythm" in mine.reason
        assert "walk" in mine.reason
        alone = db.captures.rhythm(" ".join(map(str, strikes[:5])), limit=1000)
        assert {m.capture for m in answer.matches} <= {m.capture for m in alone.matches}
