"""What to caption next: greedy choices against a slow twin, and the answers of a database."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import motiondb
from motiondb import store
from motiondb.records import Caption, FloatArray
from motiondb.search.suggestion import NOISE, suggest


def vectors_of(seed: int, n: int, n_symbols: int = 5) -> FloatArray:
    vectors = np.random.default_rng(seed).normal(size=(n, n_symbols))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def uncertainty(vectors: FloatArray, known: FloatArray, weights: FloatArray) -> float:
    """Sum of posterior variances, from the textbook formula, a capture at a time."""

    def kernel(a: FloatArray, b: FloatArray) -> float:
        return float(np.exp(-np.sum((a - b) ** 2) / 2))

    if not len(known):
        return float(weights.sum())
    inside = np.array([[kernel(a, b) for b in known] for a in known]) + NOISE * np.eye(len(known))
    total = 0.0
    for vector, weight in zip(vectors, weights):
        across = np.array([kernel(vector, b) for b in known])
        total += weight * (1.0 - across @ np.linalg.inv(inside) @ across)
    return total


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 10**6), st.integers(1, 9), st.integers(0, 3), st.integers(1, 4))
def test_choices_are_the_greedy_ones(seed: int, n: int, m: int, limit: int) -> None:
    """Every candidate tried anew at every step gives the same choices and gains."""
    vectors, described = vectors_of(seed, n), vectors_of(seed + 1, m)
    weights = np.random.default_rng(seed).uniform(0.5, 2.0, n)
    suggestions = suggest(vectors, described, limit, weights)
    assert len(suggestions) == min(limit, n)
    first = now = uncertainty(vectors, described, weights)
    known = described
    for one in suggestions:
        left = [uncertainty(vectors, np.vstack([known, v]), weights) for v in vectors]
        chosen = {s.index for s in suggestions[: suggestions.index(one)]}
        best = min(value for i, value in enumerate(left) if i not in chosen)
        assert left[one.index] == pytest.approx(best, abs=1e-9)
        assert one.gain == pytest.approx((now - best) / first, abs=1e-9)
        known, now = np.vstack([known, vectors[one.index]]), best
    assert 0 < sum(s.gain for s in suggestions) <= 1


def test_gains_by_hand() -> None:
    """Two captures that are one and the same: the first settles 1 / (1 + r) of either."""
    same = np.array([[1.0, 0.0], [1.0, 0.0]])
    first, second = suggest(same, np.zeros((0, 2)), 5)
    assert (first.index, first.known, first.served.tolist()) == (0, 0.0, [1])
    assert first.gain == pytest.approx(1 / 1.1)
    assert second.known == pytest.approx(1 / 1.1)
    assert second.gain < 0.1 * first.gain


def test_the_one_that_stands_for_many_comes_first_then_another_kind() -> None:
    a, b = np.array([1.0, 0.0]), np.array([0.0, 1.0])
    first, second = suggest(np.array([b, a, a, a]), np.zeros((0, 2)), 2)
    assert (first.index, first.served.tolist()) == (1, [2, 3])
    assert second.index == 0


def test_what_is_like_something_described_is_asked_for_last() -> None:
    vectors = vectors_of(4, 6, 12)
    suggestions = suggest(vectors, vectors[1:], 6)
    assert suggestions[0].index == 0
    assert suggest(vectors[:0], vectors, 6) == []


@pytest.fixture
def hidden(learned_copy: Path) -> Path:
    """The sample database with the words of all kicks and of some walks taken away."""
    with motiondb.open(learned_copy) as db, store.transaction(db.store):
        for info in db.captures():
            if "kick" in info.name or info.name in ("ana/walk_1", "boris/long_2"):
                store.save_captions(db.store, info.capture_id, [])
    return learned_copy


def test_captures_without_words_are_ranked(hidden: Path) -> None:
    with motiondb.open(hidden) as db:
        bare = {info.name for info in db.captures() if not db.captions(info.name)}
        suggestions = db.suggest_captions(limit=3)
        assert [one.rank for one in suggestions] == [1, 2, 3]
        assert {one.capture for one in suggestions} <= bare
        assert "kick" in suggestions[0].capture  # no kick has words any more; walks have
        assert set(suggestions[0].like) <= bare
        for one in suggestions:
            assert (f"similar to {len(one.like)} more" in one.reason) == bool(one.like)
        assert 0 < suggestions[2].gain < suggestions[0].gain < 1
        everything = db.suggest_captions(limit=1000)
        assert {one.capture for one in everything} == bare


def test_words_written_are_not_asked_for_again(hidden: Path) -> None:
    with motiondb.open(hidden) as db:
        first = db.suggest_captions(limit=1)[0]
        db.set_words(first.capture, "a kick")
        again = db.suggest_captions(limit=1)[0]
        assert again.capture != first.capture
        assert not any(
            one.capture == first.capture or first.capture in one.like
            for one in db.suggest_captions(limit=1000)
        )
        db.set_words(again.capture, "the 12")  # no motion word: still without words
        assert db.suggest_captions(limit=1)[0].capture == again.capture


def test_everything_described_leaves_nothing_to_suggest(learned_file: Path) -> None:
    with motiondb.open(learned_file, read_only=True) as db:
        assert db.suggest_captions() == []


def test_symbols_that_never_stood_beside_words_are_named(learned_copy: Path) -> None:
    with motiondb.open(learned_copy) as db:
        with store.transaction(db.store):
            for info in db.captures():
                words = [Caption("walk")] if info.name == "ana/walk_1" else []
                store.save_captions(db.store, info.capture_id, words)
        db.learn()
        first = db.suggest_captions(limit=1)[0]
        assert first.symbols
        assert first.reason.endswith(" never occurred with words")
