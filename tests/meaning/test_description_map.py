"""Words told of a motion: kernel ridge regression by hand, performers, centres, calibration."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_takes import made_captions
from threadpoolctl import threadpool_limits

from motiondb.meaning import description_map
from motiondb.meaning.counting import described_intervals
from motiondb.meaning.description_map import (
    ALPHA,
    BETA,
    RIDGE,
    TAU,
    effective_performers,
    fit_description_calibration,
    fit_description_map,
    kernel,
    map_descriptions,
    score_probabilities,
)
from motiondb.meaning.regression import calibrate
from motiondb.meaning.score_vectors import fit_score_space, unit
from motiondb.records import Caption, SegmentTable

Rows = tuple[np.ndarray, np.ndarray, np.ndarray]


def made_up(n: int, seed: int = 0) -> Rows:
    """Intervals of six performers."""
    return *made_captions(n, seed), np.random.default_rng(seed + 1000).integers(0, 6, n)


def naive_scores(rows: Rows, asked: np.ndarray) -> np.ndarray:
    """The regression in its dual form, with a constant, by the conditions of its minimum."""
    vectors, presence, groups = rows
    n = len(vectors)
    omega = np.array([(groups == g).sum() ** -0.5 for g in groups])
    omega = omega / omega.mean()
    k = np.empty((n, n))
    for i in range(n):
        for j in range(n):
            cosine = float(vectors[i] @ vectors[j])
            k[i, j] = cosine + BETA * np.exp((cosine - 1.0) / TAU)
    t = presence / np.sqrt(presence.sum(axis=1, keepdims=True))
    # a = omega (t - K a - b) / RIDGE and sum of a = 0
    left = np.block([[k + RIDGE * np.diag(1.0 / omega), np.ones((n, 1))], [np.ones((1, n)), 0.0]])
    solved = np.linalg.solve(left, np.vstack([t, np.zeros(t.shape[1])]))
    cosines = asked @ vectors.T
    told = (cosines + BETA * np.exp((cosines - 1.0) / TAU)) @ solved[:-1] + solved[-1]
    effective = np.zeros(presence.shape[1])
    for w in range(presence.shape[1]):
        counts = np.array([presence[groups == g, w].sum() for g in np.unique(groups)])
        p = counts[counts > 0] / counts.sum()
        effective[w] = np.exp(-(p * np.log(p)).sum())
    return np.asarray(told + ALPHA * np.log(effective))


@given(st.integers(0, 1000))
@settings(max_examples=20, deadline=None)
def test_it_is_the_kernel_ridge_regression_of_captions_of_length_1(seed: int) -> None:
    rows = made_up(30, seed)
    asked = made_up(4, seed + 1)[0]
    scores = fit_description_map(*rows).scores(asked)
    np.testing.assert_allclose(scores, naive_scores(rows, asked), atol=1e-5)


def test_effective_performers_by_hand() -> None:
    """All of one performer: 1; three to one: exp(.5623); of none: one half."""
    groups = np.array([7, 7, 7, 9, 9])
    presence = np.array([[1, 1, 0], [1, 1, 0], [1, 1, 0], [0, 1, 0], [0, 0, 0]], dtype=bool)
    np.testing.assert_allclose(
        effective_performers(presence, groups), [1.0, np.exp(0.562335), 0.5], 1e-5
    )


def test_fewer_centres_than_intervals(monkeypatch: pytest.MonkeyPatch) -> None:
    """Centres come from all performers in turn; the regression counts all intervals."""
    vectors, presence, _ = made_up(60)
    groups = np.array([0] * 50 + [1] * 6 + [2] * 4)
    monkeypatch.setattr(description_map, "MOST_CENTRES", 12)
    fitted = fit_description_map(vectors, presence, groups)
    centres = vectors[[0, 1, 2, 3, 50, 51, 52, 53, 56, 57, 58, 59]]
    np.testing.assert_array_equal(fitted.centres, centres)
    omega = np.array([50.0] * 50 + [6.0] * 6 + [4.0] * 4) ** -0.5
    omega /= omega.mean()
    columns = np.hstack([kernel(vectors, centres), np.ones((60, 1))])
    penalty = np.zeros((13, 13))
    penalty[:12, :12] = RIDGE * kernel(centres, centres)
    t = unit(presence.astype(float))
    solved = np.linalg.solve(
        (columns.T * omega) @ columns + penalty, (columns.T * omega) @ t
    )  # the last row is the constant
    told = columns @ solved + ALPHA * np.log(effective_performers(presence, groups))
    np.testing.assert_allclose(fitted.scores(vectors), told, atol=1e-5)


def test_one_interval_tells_its_words() -> None:
    fitted = fit_description_map(np.array([[1.0, 0.0]]), np.array([[True, False]]), np.array([3]))
    told = fitted.scores(np.array([[0.0, 1.0]]))[0]
    np.testing.assert_allclose(told, [1.0, ALPHA * np.log(0.5)], atol=1e-9)


def test_words_are_told_in_the_order_of_their_scores() -> None:
    rows = made_up(60)
    scores = fit_description_map(*rows).scores(rows[0])
    calibration = fit_description_calibration(*rows)
    told = score_probabilities(scores, calibration)
    assert calibration[0] > 0.0
    np.testing.assert_array_equal(np.argsort(-told, axis=1), np.argsort(-scores, axis=1))
    assert ((told > 0.0) & (told < 1.0)).all()


@pytest.mark.parametrize("n_performers", [8, 30])
def test_probabilities_are_as_large_as_words_are_frequent(n_performers: int) -> None:
    """Maximum likelihood with a constant: on the intervals left out, the sums agree."""
    vectors, presence, _ = made_up(90, 2)
    groups = np.arange(90) % n_performers
    calibration = fit_description_calibration(vectors, presence, groups)
    told = []
    for parts in (groups % 20, np.arange(90) % 10):
        for part in np.unique(parts):
            rest = parts != part
            fitted = fit_description_map(vectors[rest], presence[rest], groups[rest])
            told.append(score_probabilities(fitted.scores(vectors[~rest]), calibration))
    assert np.concatenate(told).sum() == pytest.approx(2.0 * presence.sum(), rel=1e-4)


@pytest.mark.parametrize("group", [7])
def test_one_performer_alone_is_calibrated_by_the_map_of_one_performer(group: int) -> None:
    """Fifths are left out, but the map keeps its performer: the mean said is the mean true."""
    vectors, presence, _ = made_up(40)
    groups = np.full(40, group)
    calibration = fit_description_calibration(vectors, presence, groups)
    told = []
    for parts in (np.arange(40) % 5, np.arange(40) % 10):
        for part in np.unique(parts):
            rest = parts != part
            fitted = fit_description_map(vectors[rest], presence[rest], groups[rest])
            told.append(score_probabilities(fitted.scores(vectors[~rest]), calibration))
    assert np.concatenate(told).mean() == pytest.approx(presence.mean(), rel=1e-4)


def test_with_one_performer_words_of_one_fifth_are_not_used() -> None:
    """A word of the first fifth alone is not among those calibrated."""
    vectors, presence, _ = made_up(40)
    groups = np.zeros(40, dtype=np.int64)
    assert all(presence[:, w].reshape(8, 5).any(axis=0).sum() > 1 for w in range(5))
    rare = np.zeros((40, 1), dtype=bool)
    seen = []

    def keep(z: np.ndarray, logits: np.ndarray, truth: np.ndarray) -> np.ndarray:
        seen.append(truth.shape)
        return calibrate(z, logits, truth)

    rare[[0, 5, 10]] = True
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(description_map, "calibrate", keep)
        fit_description_calibration(vectors, np.hstack([presence, rare]), groups)
    assert seen == [(80, 5)]


def test_scores_are_the_same_on_any_number_of_threads() -> None:
    """The last bits too."""
    rng = np.random.default_rng(0)
    vectors = unit(rng.normal(size=(400, 300)))
    fitted = fit_description_map(vectors, rng.random((400, 40)) < 0.2, np.arange(400) % 7)
    with threadpool_limits(1):
        alone = fitted.scores(vectors)
    np.testing.assert_array_equal(fitted.scores(vectors), alone)


PERFORMERS = {10: "ana", 11: "boris", 12: "ana"}


def three_captures() -> SegmentTable:
    """Captures of two segments of 30 frames (1 s) each."""
    ids, starts = np.array([10, 10, 11, 11, 12, 12]), np.tile([0, 30], 3)
    scores = np.random.default_rng(0).normal(size=(6, 4)).astype(np.float32)
    best = scores.argmax(axis=1)
    return SegmentTable(ids, starts, starts + 30, best, scores.max(axis=1), best * 0.0, scores)


def test_it_is_fitted_to_vectors_words_and_performers_of_the_intervals() -> None:
    """A whole capture, a first half, and a whole capture of which one word is not known."""
    table = three_captures()
    captions = {
        10: (Caption("walk", None, None),),
        11: (Caption("walk, jump", 0.0, 1.0),),
        12: (Caption("jump, somersault", None, None),),
    }
    space = fit_score_space(table.scores, table.ends - table.starts)
    described = described_intervals(table, captions, {})
    told = map_descriptions(table, described, space, {"walk": 0, "jump": 1}, PERFORMERS)
    assert told is not None
    rows = space.standardise(table.scores, None)
    vectors = unit(np.stack([rows[:2].sum(axis=0), rows[2], rows[4:].sum(axis=0)]))
    presence = np.array([[1, 0], [1, 1], [0, 1]], dtype=bool)
    fitted = fit_description_map(vectors, presence, np.array([0, 1, 0]))
    np.testing.assert_allclose(told.scores(vectors), fitted.scores(vectors), atol=1e-6)


def test_without_known_words_there_is_no_map() -> None:
    table = three_captures()
    captions = {10: (Caption("somersault", None, None),)}
    space = fit_score_space(table.scores, table.ends - table.starts)
    described = described_intervals(table, captions, {})
    assert map_descriptions(table, described, space, {"walk": 0}, PERFORMERS) is None
    assert map_descriptions(table, [], space, {"walk": 0}, PERFORMERS) is None
