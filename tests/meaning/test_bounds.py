"""What the log-odds of a question are at most, and the search that stops by it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_takes import take

from motiondb.language.question.parse import parse
from motiondb.language.question.readings import Reading, readings
from motiondb.meaning import by_question
from motiondb.meaning.word_evidence import (
    SLACK,
    UNWRITTEN,
    WRITTEN,
    TakeEvidence,
    TakeExtremes,
    TakeScores,
    take_extremes,
    upper_bounds,
)
from motiondb.records import SegmentTable

NUMBER = {"walk": 0, "turn": 1, "sit": 2}
MIXED = {**NUMBER, "limp": 3, "golf": 4}
QUESTIONS = (
    "walk", "turn walk", "walk, turn, sit", "walk while turn", "walk or sit", "walk but not sit",
    "walk, turn, not walk", "not sit", "walk twice", "sit for 1 second", "walk twice, sit",
)  # fmt: skip


def asked(text: str) -> tuple[Reading, ...]:
    return readings(parse(text).tree)[0]


def random_takes(seed: int, count: int) -> dict[int, TakeScores]:
    """Captures of one to seven segments, with numbers out of order and with equal ones."""
    rng = np.random.default_rng(seed)
    takes = {}
    for capture in rng.permutation(3 * count)[:count]:
        n = int(rng.integers(1, 8))
        windows, whole = rng.normal(0.0, 3.0, (n, 3)).round(), rng.normal(0.0, 2.0, 3).round()
        takes[int(capture)] = take(windows.tolist(), whole.tolist())
    return takes


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from(QUESTIONS), st.sampled_from([1.0, 30.0, 200.0]))
def test_no_answer_is_above_the_bound_of_single_precision(
    seed: int, text: str, spread: float
) -> None:
    rng, read = np.random.default_rng(seed), asked(text)
    takes = {
        n: take((spread * rng.normal(size=(5, 3))).tolist(), [0.1, 0.7, -0.3]) for n in range(9)
    }
    seen = take_extremes(takes)
    single = {name: array.astype(np.float32) for name, array in vars(seen).items()}
    extremes = TakeExtremes(**{**single, "captures": seen.captures})
    for capture, bound in zip(extremes.captures, upper_bounds(extremes, read, NUMBER)):
        hit = by_question.search_take(takes[int(capture)], read, NUMBER)
        assert hit is None or hit.log_odds <= bound + SLACK


def test_extremes_by_hand() -> None:
    seen = take_extremes(
        {7: take([[1, 5, 0], [4, 2, 0]], [3, 3, 0]), 2: take([[0, 0, 9]], [1, 1, 1])}
    )
    assert seen.captures.tolist() == [7, 2]
    assert seen.highest.tolist() == [[4, 5, 0], [0, 0, 9]]
    assert seen.lowest.tolist() == [[1, 2, 0], [0, 0, 9]]
    assert seen.whole.tolist() == [[3, 3, 0], [1, 1, 1]]


def test_no_captures_have_no_bounds() -> None:
    assert upper_bounds(take_extremes({}), (), NUMBER).shape == (0,)


def test_the_bound_of_one_word_is_its_log_odds() -> None:
    takes = {0: take([[1, 0, 0], [4, 0, 0]], [2, 0, 0])}
    assert upper_bounds(take_extremes(takes), asked("walk"), NUMBER).tolist() == [0.5 * 4 + 0.5 * 2]


def test_the_bound_of_words_in_order_does_not_know_the_order() -> None:
    takes = {0: take([[0, 6, 0], [6, 0, 0]], [6, 6, 0])}
    bound = float(upper_bounds(take_extremes(takes), asked("walk, turn"), NUMBER)[0])
    both = (1 / (1 + np.exp(-6.0))) ** 2
    assert bound == pytest.approx(np.log(both / (1 - both)))


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from(QUESTIONS))
def test_no_answer_is_above_its_bound(seed: int, text: str) -> None:
    takes, read = random_takes(seed, 12), asked(text)
    extremes = take_extremes(takes)
    for capture, bound in zip(extremes.captures, upper_bounds(extremes, read, NUMBER)):
        hit = by_question.search_take(takes[int(capture)], read, NUMBER)
        assert hit is None or hit.log_odds <= bound + SLACK


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from(QUESTIONS), st.integers(0, 15))
def test_the_likeliest_are_those_of_a_search_of_everything(
    seed: int, text: str, limit: int
) -> None:
    takes, read = random_takes(seed, 12), asked(text)
    every = []
    for capture, each in takes.items():
        hit = by_question.search_take(each, read, NUMBER)
        if hit is not None:
            every.append((-hit.log_odds, capture))
    extremes = take_extremes(takes)
    likeliest = by_question.likeliest_takes(
        extremes.captures,
        upper_bounds(extremes, read, NUMBER),
        lambda capture: by_question.search_take(takes[capture], read, NUMBER),
        limit,
    )
    assert [capture for capture, _ in likeliest] == [c for _, c in sorted(every)[:limit]]


def test_captures_below_the_answers_are_not_looked_at() -> None:
    looked: list[int] = []

    def search(capture: int) -> by_question.QuestionHit:
        looked.append(capture)
        return by_question.QuestionHit(0, 1, 5.0 - capture, ((0, 1),), ())

    best = by_question.likeliest_takes(np.arange(100), 5.0 - np.arange(100), search, 3)
    assert [capture for capture, _ in best] == [0, 1, 2]
    assert looked == [0, 1, 2]


@settings(max_examples=60, deadline=None)
@given(
    st.integers(0, 10**6),
    st.sampled_from(["limp", "golf", "limp, golf", "limp turn", "walk but not golf", "not limp"]),
)
def test_bounds_hold_for_words_that_are_mixed_from_others(seed: int, text: str) -> None:
    """ "limp" stands for known words, also as written; "golf" is heard by its meaning alone."""
    rng, read = np.random.default_rng(seed), asked(text)
    rows = {7: slice(0, 4), 2: slice(4, 5), 5: slice(5, 7)}
    starts = np.concatenate([10 * np.arange(r.stop - r.start) for r in rows.values()])
    none = np.zeros(7, dtype=np.int64)
    single = np.zeros((7, 0), dtype=np.float32)
    table = SegmentTable(none, starts, starts + 10, none, none.astype(float), single, single)
    odds = {c: rng.normal(0.0, 3.0, (r.stop - r.start + 1, 3)) for c, r in rows.items()}
    said = {c: rng.choice([UNWRITTEN, 0.0, WRITTEN], odds[c][1:].shape) for c in (7, 5)}
    known = TakeEvidence(table, rows, odds, said)
    shares = np.array([[0.5, 0.0], [0.0, 0.3], [0.5, 0.7]])
    likeness = {c: rng.normal(size=2) for c in rows}
    mixed = known.mixed(shares, likeness, np.array([True, False]))
    evidence = known.with_columns(mixed)
    limp = evidence.takes[7].windows[:, 3]
    np.testing.assert_allclose(limp, (odds[7][:-1] + said[7]) @ shares[:, 0])
    golf = evidence.takes[7].whole[4]
    assert golf == pytest.approx(odds[7][-1] @ shares[:, 1] + 2.0 * likeness[7][1])
    bounds = upper_bounds(evidence.extremes, read, MIXED)
    for capture, bound in zip(evidence.extremes.captures.tolist(), bounds):
        hit = by_question.search_take(evidence.takes[capture], read, MIXED)
        assert hit is None or hit.log_odds <= bound + SLACK
