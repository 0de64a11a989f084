"""How clearly segments, symbols and parts of a motion show what was asked for, and nothing else."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.generate.competing_words import (
    MOST_RIVALRY,
    NEIGHBOURS,
    SMALL,
    neighbour_gains,
    related_words,
    rival_gain,
)
from motiondb.generate.symbol_motion import log_clarity, symbol_clarity
from motiondb.learn.learned import DescribedSegments
from motiondb.meaning.nearest_captures import CaptureSegments


def test_clarity_of_a_stretch_is_the_mean_over_its_frames() -> None:
    probabilities = np.array([[0.5, 0.75], [0.25, 0.75]])
    expected = (np.log(0.5) + np.log(0.25)) / 2 + 0.5 * np.log(0.25)
    assert log_clarity(probabilities, np.array([0])) == pytest.approx(expected)


def test_a_symbol_is_as_clear_as_its_segments() -> None:
    probabilities = np.array([[0.9], [0.9], [0.9], [0.1]])
    actual = symbol_clarity(probabilities, np.array([0]), np.zeros(4, dtype=int), 2)
    assert np.allclose(actual, [[np.sqrt(0.7 * 0.9)], [0.0]])  # all on average, the clearest three


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**31), st.integers(1, 12), st.integers(1, 5))
def test_clarity_is_between_nothing_and_the_probability(
    seed: int, n_segments: int, n_words: int
) -> None:
    rng = np.random.default_rng(seed)
    probabilities = rng.uniform(0.0, 0.99, (n_segments, n_words))
    symbols = rng.integers(0, 3, n_segments)
    asked = rng.permutation(n_words)[: int(rng.integers(1, n_words + 1))]
    actual = symbol_clarity(probabilities, asked, symbols, 3)
    for symbol in range(3):
        of_symbol = probabilities[symbols == symbol][:, asked]
        most = of_symbol.max(axis=0) if len(of_symbol) else np.zeros(len(asked))
        assert (actual[symbol] >= 0.0).all()
        assert (actual[symbol] <= most + 1e-12).all()


SIT, CLIMB, STOOL = range(3)


def test_without_other_captures_nothing_is_gained() -> None:
    nothing = CaptureSegments(np.zeros((0, 2)), np.zeros((0, 2), dtype=np.int64))
    nobody = DescribedSegments(nothing, np.zeros(0, dtype=np.int64), np.zeros((0, 3)))
    assert neighbour_gains(nobody, {1: np.ones((4, 2))}, [SIT])[1].tolist() == [0.0] * 4


def test_the_gain_beside_a_slow_twin() -> None:
    rng = np.random.default_rng(4)
    lengths = rng.integers(1, 5, size=30)
    vectors = rng.normal(size=(int(lengths.sum()), 6))
    vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
    firsts = np.cumsum([0, *lengths])[:-1]
    says = (rng.random((30, 8)) < 0.2).astype(float)
    segments = CaptureSegments(vectors, np.stack([firsts, firsts + lengths], axis=1))
    others = DescribedSegments(segments, np.arange(30), says)
    asked, queries = [2, 5], rng.normal(size=(7, 6))
    gain = neighbour_gains(others, {3: queries}, asked)[3]
    rivals = [w for w in range(8) if w not in related_words(says, asked)]
    for query, value in zip(queries, gain):
        alike = []
        for n in range(30):
            if n != 3:
                vectors_of_capture = vectors[firsts[n] : firsts[n] + lengths[n]]
                cosine = max(float(v @ query / np.linalg.norm(query)) for v in vectors_of_capture)
                alike.append((max(cosine, 0.0), n))
        alike.sort(key=lambda pair: -pair[0])
        total = sum(cosine for cosine, _ in alike[:NEIGHBOURS])
        said = [
            sum(cosine * says[n, w] for cosine, n in alike[:NEIGHBOURS]) / total for w in range(8)
        ]
        wanted = np.mean([np.log(said[w] + SMALL) for w in asked])
        best = max((said[w] for w in rivals), default=0.0)
        # vectors are kept in single precision
        np.testing.assert_allclose(value, wanted - np.log(best + SMALL), atol=1e-6)


def test_rivalry_is_limited_both_ways() -> None:
    evidence = np.array([[90.0, 0.0, 0.0], [0.0, 90.0, 0.0]])
    assert rival_gain(evidence, [SIT], [CLIMB]).tolist() == [MOST_RIVALRY, -MOST_RIVALRY]
