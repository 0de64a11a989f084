"""How sure a place is: joined takes, their questions, cues by hand, and what comes true."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motiondb.meaning.place_certainty import (
    IntervalCues,
    JoinedPart,
    Judged,
    PlaceCertainty,
    PlaceQuestion,
    ShortCapture,
    count_performers,
    cues_of,
    fit_certainty,
    hear,
    interval_cues,
    join,
    join_captures,
    join_pairs,
    judge,
    questions_of,
    single_cues,
    tell_place,
    union_share,
)
from motiondb.meaning.place_map import PlaceMap
from motiondb.meaning.regression import Certainty

N_WORDS = 4


def short(word: int, group: str = "ana", noise: float = 0.0, seed: int = 0) -> ShortCapture:
    """Two segments of two seconds that say their word."""
    rng = np.random.default_rng(seed)
    rows = np.eye(N_WORDS)[[word, word]] + noise * rng.normal(size=(2, N_WORDS))
    return ShortCapture(rows, np.array([0, 60]), np.array([60, 120]), (word,), group)


def plain_map() -> PlaceMap:
    """Every column speaks for the word of its number."""
    return PlaceMap(np.eye(N_WORDS), np.zeros(N_WORDS), np.ones(N_WORDS))


def all_known() -> Any:
    """Every performer knows every word, and every map is the plain one."""
    listed = dict.fromkeys(("ana", "ben", "cai", "dia", "eve"), range(N_WORDS))
    return SimpleNamespace(without=lambda _: plain_map(), listed_by=listed)


def test_joined_captures_lie_one_after_another() -> None:
    take = join([short(0), short(2), short(2)])
    assert take.starts.tolist() == [0, 60, 120, 180, 240, 300]
    assert take.ends.tolist() == [60, 120, 180, 240, 300, 360]
    assert take.parts == (
        JoinedPart(0, 120, (0,), "ana"),
        JoinedPart(120, 240, (2,), "ana"),
        JoinedPart(240, 360, (2,), "ana"),
    )
    assert questions_of(take) == [
        PlaceQuestion((0,), "ana", ((0, 120),)),
        PlaceQuestion((2,), "ana", ((120, 360),)),
    ]


def test_an_action_of_all_parts_is_asked_of_a_single_capture_only() -> None:
    assert questions_of(join([short(1), short(1)])) == []
    assert questions_of(join([short(1)])) == [PlaceQuestion((1,), "ana", ((0, 120),))]


def test_captures_are_joined_within_one_performer_each_once() -> None:
    captures = [short(k % 4, group) for group in ("ana", "ben", "cai") for k in range(8)]
    takes = join_captures([*captures, short(0, "dia")], np.random.default_rng(0))
    assert {group for take in takes for group in take.groups} == {"ana", "ben", "cai"}
    assert all(len(take.groups) == 1 for take in takes)
    assert all(3 <= len(take.parts) <= 6 for take in takes)
    assert sum(len(take.parts) for take in takes) <= len(captures)


def test_captures_of_two_performers_are_joined_each_once() -> None:
    captures = [short(k % 4, group) for group in ("ana", "ben", "cai") for k in range(4)]
    takes = join_pairs(captures, np.random.default_rng(0))
    assert {len(take.groups) for take in takes} <= {1, 2}
    assert len({group for take in takes for group in take.groups}) == 2  # the third has no partner
    assert sum(len(take.parts) for take in takes) <= 8


def test_a_question_names_the_performer_of_its_action() -> None:
    take = join([short(0), short(2, "ben"), short(3)])
    assert [asked.group for asked in questions_of(take)] == ["ana", "ben", "ana"]
    assert take.groups == {"ana", "ben"}


def test_cues_by_hand() -> None:
    evidence = np.array([0.0, 1.0, 5.0, 4.0, 2.0])  # lower quartile 1
    share, size, three = 2 / 5, np.log(5), np.log(4)
    expected = [5, 3, 4, three, share, size, -share, -size]
    assert cues_of(evidence, 2, 4, 3) == pytest.approx(expected)
    assert cues_of(evidence, 3, 4, 3)[1] == 0.0  # 5 outside is more than 4 inside
    assert cues_of(evidence, 0, 5, 0) == pytest.approx([5, 4, 4, 0, 1, size, -1, -size])


def test_cues_of_a_take_of_one_action_by_hand() -> None:
    evidence = np.array([0.0, 1.0, 5.0, 4.0, 2.0])
    size, seconds = np.log(5), np.log(10.0)
    expected = [size, seconds, 4, -size, -seconds, -4]
    assert single_cues(evidence, 10.0) == pytest.approx(expected)


def test_an_interval_of_a_take_of_one_action_is_right_from_half_of_the_take() -> None:
    evidence, ends = np.zeros(4), np.array([30, 90, 120, 240])
    assert not interval_cues(evidence, ends, 0, 2, 1).covers  # 90 of 240 frames
    assert interval_cues(evidence, ends, 0, 3, 1).covers
    assert interval_cues(evidence, ends, 3, 4, 1).covers
    assert not interval_cues(evidence, ends, 1, 3, 1).covers
    assert interval_cues(evidence, ends, 1, 3, 1).single[1] == pytest.approx(np.log(8.0))


def test_the_two_cases_are_mixed() -> None:
    several = Certainty(np.zeros(8), float(np.log(3.0)), float("nan"))  # 3/4
    single = Certainty(np.zeros(6), -float(np.log(4.0)), float("nan"))  # 1/5
    half, none = (IntervalCues(np.zeros(8), np.zeros(6), covers) for covers in (True, False))
    assert PlaceCertainty(several, single).probability(half) == pytest.approx(0.2 + 0.8 * 0.75)
    assert PlaceCertainty(several, single).probability(none) == pytest.approx(0.8 * 0.75)


def test_performers_of_several_words_are_those_of_the_rarest() -> None:
    listed = {"ana": {0, 1}, "ben": {0}, "cai": {0, 1}}
    assert count_performers(listed, [0], []) == 3
    assert count_performers(listed, [0, 1], ["ana"]) == 1
    assert count_performers(listed, [2], []) == 0


def test_what_no_other_performer_shows_is_not_asked() -> None:
    take = join([short(0), short(2), short(3)])
    known = SimpleNamespace(without=lambda _: plain_map(), listed_by={"ana": {0, 2, 3}, "ben": {2}})
    assert [one.kind for one in judge(take, known)] == [("ana", (2,), 3)]


def test_the_map_without_all_performers_of_a_take_judges_it() -> None:
    asked: list[frozenset[str]] = []

    def without(performers: frozenset[str]) -> PlaceMap:
        asked.append(performers)
        return plain_map()

    listed = dict.fromkeys(("ana", "ben", "cai"), range(N_WORDS))
    judge(
        join([short(0), short(1, "ben"), short(2)]),
        SimpleNamespace(without=without, listed_by=listed),
    )
    assert set(asked) == {frozenset({"ana", "ben"})}


def test_a_clear_place_is_found_and_right() -> None:
    take = join([short(0), short(2), short(3)])
    (start, end), _ = tell_place(hear(take, plain_map()), [2], 1)
    assert (start, end) == (120, 240)
    assert [one.right for one in judge(take, all_known())] == [True, True, True]


def test_union_share_of_intervals_apart_is_0() -> None:
    assert union_share((0, 10), (10, 20)) == 0.0
    assert union_share((0, 10), (0, 10)) == 1.0


def test_probabilities_come_true_on_other_draws() -> None:
    def captures(seed: int) -> list[ShortCapture]:
        return [
            short(k % N_WORDS, group, 0.9, 1000 * seed + 100 * g + k)
            for g, group in enumerate(("ana", "ben", "cai", "dia")) for k in range(24)
        ]  # fmt: skip

    sure = fit_certainty(captures(1), all_known(), np.random.default_rng(1))
    assert sure is not None
    told: list[Judged] = []
    for seed in range(2, 8):
        rng = np.random.default_rng(seed)
        for take in join_captures(captures(seed), rng):
            told += judge(take, all_known())
    p = np.array([sure.probability(one.cues) for one in told])
    right = np.array([one.right for one in told])
    assert 0.05 < right.mean() < 0.95
    assert p[right].mean() > p[~right].mean() + 0.05
    assert (sure.several.weights >= 0.0).all()
    assert sure.single is not None
    assert (sure.single.weights >= 0.0).all()
    alone = [one for each in captures(9) for one in judge(join([each]), all_known())]
    p_alone = np.array([sure.probability(one.cues) for one in alone])
    covers = np.array([one.cues.covers for one in alone])
    assert [one.right for one in alone] == covers.tolist()
    assert p_alone.mean() == pytest.approx(covers.mean(), abs=0.1)


def test_too_few_captures_give_none() -> None:
    few = [short(0), short(1)]
    assert fit_certainty(few, all_known(), np.random.default_rng(0)) is None
    assert fit_certainty([], all_known(), np.random.default_rng(0)) is None
