"""The reason of an answer: its parts sum to the number that ranks it."""

import math

import numpy as np
import pytest

from motiondb.meaning.by_question import Statement
from motiondb.meaning.score_vectors import interval_vectors
from motiondb.search import reasons

RNG = np.random.default_rng(5)
STARTS, ENDS = np.array([0, 30, 50, 90]), np.array([30, 50, 90, 120])


def make_evidence(written: float = 0.0) -> reasons.Evidence:
    return reasons.Evidence(
        constant=-2.5,
        slope=RNG.normal(size=6),
        standardised=RNG.normal(size=(4, 6)),
        starts=STARTS,
        ends=ENDS,
        symbols=np.array([3, 3, 1, 0]),
        written=np.array([0.0, written, written, 0.0]),
    )


def test_segment_shares_by_hand() -> None:
    evidence = reasons.Evidence(
        0.0, np.array([2.0, 0.0]), np.array([[3.0, 0.0], [0.0, 4.0]]),
        np.array([0, 10]), np.array([10, 20]), np.array([0, 1]), np.zeros(2),
    )  # fmt: skip
    # 10 * (3, 0) + 10 * (0, 4) has length 50; the first segment adds 10 * 3 * 2 / 50
    assert reasons.segment_shares(evidence, 0, 20).tolist() == [pytest.approx(1.2), 0.0]
    assert reasons.segment_shares(evidence, 10, 20).tolist() == [0.0, 0.0]


@pytest.mark.parametrize("window", [(0, 120), (20, 60), (85, 120), (-20, 55)])
def test_shares_sum_to_the_linear_map(window: tuple[int, int]) -> None:
    evidence = make_evidence()
    vector = interval_vectors(
        evidence.standardised, STARTS, ENDS, np.array([window[0]]), np.array([window[1]])
    )[0]
    shares = reasons.segment_shares(evidence, *window)
    assert math.isclose(math.fsum(shares), float(vector @ evidence.slope), rel_tol=1e-12)


def near_and_whole(segment: int) -> Statement:
    """The window around one segment, which counts as much as the whole capture."""
    return Statement((), 0, -1, ((int(STARTS[segment]), 1.0),), 0.5, (0.0,))


def test_all_parts_sum_exactly_to_the_total() -> None:
    here, there = near_and_whole(1), near_and_whole(3)
    words = [
        reasons.explain_word(make_evidence(4.0), 7, 0, here, 0.25),
        reasons.explain_word(make_evidence(-1.0), 2, 0, here, 0.25),
        reasons.explain_word(make_evidence(), 5, 1, there, 0.5),
    ]
    parts = [part for word in words for part in word.parts]
    joint = reasons.together(words)
    assert reasons.total(words) == math.fsum([*parts, joint])
    odds = [math.exp(word.log_odds) for word in words]
    by_action = [math.log(1.0 / (1.0 / odds[0] + 1.0 / odds[1])), words[2].log_odds]
    probability = math.prod(1.0 / (1.0 + math.exp(-odds)) for odds in by_action)
    expected = math.log(probability / (1.0 - probability))
    assert math.isclose(reasons.total(words), expected, rel_tol=1e-12)
    assert reasons.together(words[2:]) == 0.0
    assert words[0].written == 0.25 * 4.0
    assert words[0].log_probability == pytest.approx(-math.log1p(math.exp(-words[0].log_odds)))


def test_strongest_joins_neighbours_of_one_symbol() -> None:
    shares = (
        reasons.SymbolShare(3, 0.0, 1.0, 0.5), reasons.SymbolShare(3, 1.0, 1.5, 0.25),
        reasons.SymbolShare(1, 1.5, 3.0, -2.0), reasons.SymbolShare(3, 3.0, 4.0, 0.1),
    )  # fmt: skip
    reason = reasons.WordReason(0, 0, 1.0, 0.0, 0.0, shares)
    assert reasons.strongest(reason, 2) == [
        reasons.SymbolShare(1, 1.5, 3.0, -2.0),
        reasons.SymbolShare(3, 0.0, 1.5, 0.75),
    ]
