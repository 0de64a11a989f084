"""Own captions joined with a start: sums, weights, and which intervals teach which words."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from small_knowledge import N_COLUMNS, N_SYMBOLS, small_knowledge, small_rows

from motiondb.language.translation.explanation import ExpectedCounts
from motiondb.learn import checking, joining
from motiondb.learn.joining import OwnRows, choose_ridge_and_calibration
from motiondb.learn.knowledge import Started, begin
from motiondb.meaning import regression as certainty
from motiondb.meaning.counting import Counted, Counts, make_reference
from motiondb.meaning.regression import Certainties, Certainty, KindCertainty
from motiondb.meaning.score_vectors import ScoreSpace
from motiondb.meaning.word_map import map_words, word_moments
from motiondb.records import Association, SegmentTable

JOINT = ("dash", "jump", "run", "walk")
CALIBRATION = np.array([4.0, 1.0, -0.5])


def started(synonyms: dict[str, str] | None = None) -> Started:
    return begin(small_knowledge(), synonyms or {})


def own_rows(n: int = 10) -> tuple[np.ndarray, np.ndarray]:
    """Own intervals: half say dash, half walk; nobody says run or jump."""
    vectors, _ = small_rows(7, n)
    presence = np.zeros((n, 4), dtype=bool)
    presence[::2, 0] = presence[1::2, 3] = True
    return vectors, presence


def weighted_ridge(
    vectors: np.ndarray, target: np.ndarray, weights: np.ndarray, ridge: float
) -> tuple[np.ndarray, float]:
    """Slope and constant of one word by weighted least squares, the slow way."""
    total = weights.sum()
    mean_v, mean_y = weights @ vectors / total, weights @ target / total
    root = np.sqrt(weights)[:, None]
    rows = np.concatenate([root * (vectors - mean_v), np.sqrt(ridge) * np.eye(vectors.shape[1])])
    goal = np.concatenate([root[:, 0] * (target - mean_y), np.zeros(vectors.shape[1])])
    slope = np.linalg.lstsq(rows, goal, rcond=None)[0]
    return slope, -float(mean_v @ slope)


def test_the_weight_of_the_start_falls_with_own_captions() -> None:
    assert joining.start_weight(0) == 1.0
    assert joining.start_weight(joining.TRUST) == 0.5
    assert joining.start_weight(99 * joining.TRUST) == pytest.approx(0.01)


@given(st.floats(0, 1e6), st.floats(0, 1e6))
def test_more_own_captions_never_weigh_the_start_more(first: float, second: float) -> None:
    low, high = sorted((first, second))
    assert 0.0 < joining.start_weight(high) <= joining.start_weight(low) <= 1.0


def test_every_word_is_fitted_to_the_intervals_whose_writers_use_it() -> None:
    theirs, their_words = small_rows(0)
    ours, our_words = own_rows()
    first = started()
    fit = joining.join_word_map(
        word_moments(ours, our_words), JOINT, first, ridge=1.0, calibration=CALIBRATION
    )
    weight = joining.start_weight(len(ours))
    both = np.concatenate([theirs, ours])
    cases = {
        "dash": (ours, our_words[:, 0], np.ones(len(ours)), 1.0),
        "jump": (theirs, their_words[:, 0], np.ones(len(theirs)), first.taught.ridge),
        "walk": (
            both,
            np.concatenate([their_words[:, 2], our_words[:, 3]]),
            np.repeat([weight, 1.0], [len(theirs), len(ours)]),
            1.0,
        ),
    }
    for word, (vectors, target, weights, ridge) in cases.items():
        slope, constant = weighted_ridge(vectors, target.astype(float), weights, ridge)
        number = JOINT.index(word)
        np.testing.assert_allclose(fit.weights[:, number], slope, atol=1e-8)
        assert fit.offsets[number] == pytest.approx(constant, abs=1e-8)
        share = np.average(target, weights=weights)
        assert fit.priors[number] == pytest.approx(share)


def test_without_own_captions_the_map_is_that_of_the_start() -> None:
    vectors, presence = small_rows(0)
    first = started()
    nothing = word_moments(np.zeros((0, N_COLUMNS)), np.zeros((0, 3), dtype=bool))
    taught = first.taught
    fit = joining.join_word_map(nothing, taught.words, first, taught.ridge, taught.calibration)
    same = map_words(vectors, presence, taught.ridge, taught.calibration)
    np.testing.assert_allclose(fit.log_odds(vectors), same.log_odds(vectors), atol=1e-7)


def test_synonyms_of_the_user_rename_and_join_words_of_the_start() -> None:
    first = started({"run": "walk", "jump": "hop"})
    assert first.names == ("hop", "walk", "walk")
    words = joining.join_vocabulary(("sit",), first)
    assert words == ("hop", "sit", "walk")
    assert first.said == {"hop": 4, "walk": 8}
    np.testing.assert_array_equal(
        joining.join_said(np.array([0, 2, 0]), words, first, 0.5), [2, 2, 4]
    )


def test_a_word_of_the_start_counts_at_least_once_however_small_its_weight() -> None:
    joint = joining.join_said(np.array([0, 0, 0, 5]), JOINT, started(), 0.01)
    np.testing.assert_array_equal(joint, [0, 1, 1, 6])


def test_standardisations_meet_half_way_at_as_many_segments_as_the_start_is_trusted() -> None:
    own_space = ScoreSpace(np.full(N_COLUMNS, 2.0), np.full(N_COLUMNS, 3.0))
    half = joining.adapt_score_space(started(), own_space, int(joining.TRUSTED_SEGMENTS))
    np.testing.assert_allclose(half.mean, 1.0)
    np.testing.assert_allclose(half.spread, np.sqrt((1.0 + 9.0) / 2.0))
    none = joining.adapt_score_space(started(), own_space, 0)
    np.testing.assert_array_equal(none.mean, 0.0)


def test_certainties_are_joined_by_the_weight_and_one_alone_stands() -> None:
    first, own_certainty = (
        Certainty(np.array([1.0]), -1.0, 4.0),
        Certainty(np.array([2.0]), 0.0, 2.0),
    )
    joint = joining.join_certainty(own_certainty, first, joining.TRUST)
    assert joint is not None
    assert (joint.weights[0], joint.constant, joint.threshold) == (1.5, -0.5, 3.0)
    assert joining.join_certainty(None, first, 50.0) is first
    assert joining.join_certainty(own_certainty, None, 50.0) is own_certainty
    unknown = Certainty(np.array([2.0]), 0.0, np.nan)
    kept = joining.join_certainty(unknown, first, 10.0)
    assert kept is not None
    assert kept.threshold == 4.0


def test_published_counts_are_own_ones_and_the_weighted_ones_of_the_start() -> None:
    vectors, presence = own_rows()
    t = np.full((N_SYMBOLS + 1, 4), 0.25)
    fitted = Association(JOINT, np.array([5, 0, 0, 5]), t, {}, np.zeros(0))
    reference = make_reference(fitted, {}, small_knowledge().score_space)
    translation = np.zeros((N_SYMBOLS + 1, 4))
    translation[1, 0] = translation[2, 3] = 5.0
    transitions = np.zeros((N_SYMBOLS + 1, N_SYMBOLS + 1))
    transitions[0, 1] = 30.0  # captures
    counts = Counts(
        transitions, np.array([5, 0, 0, 5]), Counter({(1, 1): 10}),
        ExpectedCounts(translation, {(1, 1): np.array([[4.0, 6.0]])}, 10),
        word_moments(vectors, presence),
    )  # fmt: skip
    first = started()
    joint = joining.publish(Counted(counts, reference), first, 1.0, CALIBRATION)
    taught, weight = first.taught, joining.start_weight(10)
    expected = translation + weight * taught.expected.translation @ first.columns(JOINT)
    np.testing.assert_allclose(
        joint.association.translation, expected / expected.sum(axis=1, keepdims=True)
    )
    np.testing.assert_array_equal(joint.association.counts, [5, 2, 2, 7])
    np.testing.assert_allclose(
        joint.transition_counts, transitions + joining.start_weight(30) * taught.transitions
    )
    assert joint.lengths == {(1, 1): 10, (2, 1): 4, (3, 2): 2}
    np.testing.assert_allclose(joint.association.alignment[1, 1], [[0.4, 0.6]])


def test_few_own_captions_leave_ridge_and_calibration_to_the_start() -> None:
    vectors, presence = own_rows(6)
    rows = OwnRows(vectors, presence, np.arange(6), JOINT, started())
    ridge, calibration = choose_ridge_and_calibration(rows)
    assert ridge == 0.3
    np.testing.assert_array_equal(calibration, CALIBRATION)


def test_many_own_captions_move_the_calibration() -> None:
    rng = np.random.default_rng(3)
    presence = np.arange(60)[:, None] % 2 == np.array([0, 5, 5, 1])
    vectors = rng.normal(size=(60, N_COLUMNS)) * 0.3
    vectors[:, 0] += np.where(presence[:, 0], 2.0, -2.0)
    vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
    rows = OwnRows(vectors, presence, np.arange(60) % 4, JOINT, started())
    ridge, calibration = choose_ridge_and_calibration(rows)
    assert ridge in (0.1, 0.3, 1.0)
    assert calibration[0] > 4.0  # own words are told apart better than the start's were
    whole = rows.without(np.zeros(60, dtype=bool), ridge, calibration)
    held = rows.without(np.arange(60) % 4 == 0, ridge, calibration)
    assert np.abs(whole.weights - held.weights).max() > 0.0


def segments(log_likelihoods: list[float], lengths: list[int]) -> SegmentTable:
    """Segments of one capture whose background is -10 throughout."""
    ends = np.cumsum(lengths)
    n = len(lengths)
    return SegmentTable(
        np.zeros(n, dtype=np.int64), ends - lengths, ends, np.zeros(n, dtype=np.int64),
        np.array(log_likelihoods), np.full(n, -10.0), np.zeros((n, 1), dtype=np.float32),
    )  # fmt: skip


def test_motion_is_strange_where_the_background_explains_it_better() -> None:
    table = segments([-5.0, -20.0, -9.0], [50, 30, 20])
    assert joining.strange_share(table) == pytest.approx(0.3)


def test_a_start_that_does_not_fit_is_set_aside_where_captions_are_enough() -> None:
    strange, fitting = segments([-5.0, -20.0], [50, 50]), segments([-5.0, -20.0], [90, 10])
    assert joining.is_set_aside(strange, joining.ENOUGH)
    assert not joining.is_set_aside(strange, joining.ENOUGH - 1)
    assert not joining.is_set_aside(fitting, 10_000)


def test_probabilities_of_a_start_come_nearer_to_a_half_and_keep_their_order() -> None:
    """A probability of the start is the mean over what its log-odds may be off by elsewhere."""
    first = Certainties(
        words=Certainty(np.array([2.0]), -1.0, 0.7),
        example=Certainty(np.array([2.0]), -1.0, 0.7),
        without=KindCertainty(Certainty(np.array([3.0]), 0.5, np.nan)),
    )
    carried = checking.carry(first)
    cues = np.linspace(-2.0, 3.0, 11)[:, None]
    assert first.words is not None
    assert carried.words is not None
    inside, outside = (
        certainty.probability(s.log_odds(cues)) for s in (first.words, carried.words)
    )
    assert (np.diff(outside) > 0.0).all()
    assert (np.abs(outside - 0.5) <= np.abs(inside - 0.5)).all()
    nodes, weights = np.polynomial.hermite_e.hermegauss(61)
    odds = first.words.log_odds(cues)[:, None] + checking.SPREAD * nodes
    exact = certainty.probability(odds) @ weights / weights.sum()
    np.testing.assert_allclose(outside, exact, atol=0.02)
    assert carried.words.threshold == 0.7
    assert carried.example is first.example
    assert carried.without.whole is not None
    assert carried.without.whole.weights[0] < 3.0
    assert carried.without.part is None


def test_certainties_of_questions_with_without_or_either_are_joined_too() -> None:
    def sure(weight: float) -> KindCertainty:
        return KindCertainty(Certainty(np.array([weight]), 0.0, 0.0))

    first = Certainties(without=sure(3.0), either=sure(5.0))
    joined = checking.join_certainties(Certainties(without=sure(1.0)), first, 90.0)
    assert joined.without.whole is not None
    assert joined.without.whole.weights.tolist() == pytest.approx([1.2])
    assert joined.either.whole is None
    assert joined.words is None
    before = checking.join_certainties(Certainties(without=sure(1.0)), first, 49.0)
    assert before.without.whole is None
