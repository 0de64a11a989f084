"""How sure a place is: joined takes, their questions, cues by hand, and what comes true."""

from __future__ import annotations

import numpy as np
import pytest

from motiondb.learning.certainty.place_certainty import (
    Judged,
    ShortCapture,
    cues_of,
    fit_certainty,
    join,
    join_captures,
    judge,
    questions_of,
    tell_place,
    union_share,
)
from motiondb.search.certainty import probability
from motiondb.words.maps.place_map import PlaceMap

N_WORDS = 4


def short(word: int, group: str = "ana", noise: float = 0.0, seed: int = 0) -> ShortCapture:
    """Two segments of two seconds that say their word."""
    rng = np.random.default_rng(seed)
    rows = np.eye(N_WORDS)[[word, word]] + noise * rng.normal(size=(2, N_WORDS))
    return ShortCapture(rows, np.array([0, 60]), np.array([60, 120]), (word,), group)


def plain_map() -> PlaceMap:
    """Every column speaks for the word of its number."""
    return PlaceMap(np.eye(N_WORDS), np.zeros(N_WORDS), np.ones(N_WORDS))


def test_joined_captures_lie_one_after_another() -> None:
    take = join([short(0), short(2), short(2)])
    assert take.starts.tolist() == [0, 60, 120, 180, 240, 300]
    assert take.ends.tolist() == [60, 120, 180, 240, 300, 360]
    assert take.parts == ((0, 120, (0,)), (120, 240, (2,)), (240, 360, (2,)))
    assert questions_of(take) == [((0,), [(0, 120)]), ((2,), [(120, 360)])]


def test_an_action_of_all_parts_is_asked_of_a_single_capture_only() -> None:
    assert questions_of(join([short(1), short(1)])) == []
    assert questions_of(join([short(1)])) == [((1,), [(0, 120)])]


def test_captures_are_joined_within_one_performer_each_once() -> None:
    captures = [short(k % 4, group) for group in ("ana", "ben", "cai") for k in range(8)]
    takes = join_captures([*captures, short(0, "dia")], np.random.default_rng(0))
    assert {take.group for take in takes} == {"ana", "ben", "cai"}
    assert all(3 <= len(take.parts) <= 6 for take in takes)
    assert sum(len(take.parts) for take in takes) <= len(captures)


def test_cues_by_hand() -> None:
    evidence = np.array([0.0, 1.0, 5.0, 4.0, 2.0])  # lower quartile 1
    share, size = 2 / 5, np.log(5)
    assert cues_of(evidence, 2, 4) == pytest.approx([5, 3, 4, share, size, -share, -size])
    assert cues_of(evidence, 0, 5) == pytest.approx([5, 4, 4, 1, size, -1, -size])


def test_a_clear_place_is_found_and_right() -> None:
    take = join([short(0), short(2), short(3)])
    (start, end), _ = tell_place(take, [2], plain_map())
    assert (start, end) == (120, 240)
    assert [one.right for one in judge(take, plain_map())] == [True, True, True]


def test_union_share_of_intervals_apart_is_0() -> None:
    assert union_share((0, 10), (10, 20)) == 0.0
    assert union_share((0, 10), (0, 10)) == 1.0


def test_probabilities_come_true_on_other_draws() -> None:
    def captures(seed: int) -> list[ShortCapture]:
        return [
            short(k % N_WORDS, group, 0.9, 1000 * seed + 100 * g + k)
            for g, group in enumerate(("ana", "ben", "cai", "dia")) for k in range(24)
        ]  # fmt: skip

    maps = dict.fromkeys(("ana", "ben", "cai", "dia"), plain_map())
    sure = fit_certainty(captures(1), maps, np.random.default_rng(1))
    assert sure is not None
    told: list[Judged] = []
    for seed in range(2, 8):
        rng = np.random.default_rng(seed)
        for take in join_captures(captures(seed), rng):
            told += judge(take, plain_map())
    p = np.array([float(probability(sure.log_odds(one.cues))) for one in told])
    right = np.array([one.right for one in told])
    assert 0.05 < right.mean() < 0.95
    assert p[right].mean() > p[~right].mean() + 0.05
    assert (sure.weights >= 0.0).all()


def test_too_few_captures_give_none() -> None:
    maps = {"ana": plain_map()}
    few = [short(0), short(1)]
    assert fit_certainty(few, maps, np.random.default_rng(0)) is None
    assert fit_certainty([], {}, np.random.default_rng(0)) is None
