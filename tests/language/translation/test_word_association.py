"""IBM Model 1 and 2 against the sum over all alignments."""

import functools
import itertools
import operator

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.language.translation.association import (
    em_step,
    fit_association,
    lay_out,
    uniform_start,
)
from motiondb.language.translation.explanation import (
    alignment_posterior,
    alignment_table,
    diagonal_alignment,
    log_probability,
    pair_counts,
    smoothed,
    with_counts,
)


def pair(symbols, words):
    return np.array(symbols, dtype=np.int64), np.array(words, dtype=np.int64)


REPEATED = [pair([0], [0, 0]), pair([0, 1], [0, 1]), pair([0, 2], [0])]
"""Word 0 stands twice beside symbol 0. After one step t(0 | symbol 0) is
(1/2 + 1/2 + 1/3 + 1/3) / (that + 1/3) = 5/6; divided per word type it would be 7/9."""


def enumerate_step(pairs, t, a, n_symbols, n_words):
    """New t (symbols + 1, words) and a by the sum over every alignment of every pair."""
    t_counts = np.zeros((n_symbols + 1, n_words))
    a_counts = {shape: np.zeros_like(table) for shape, table in a.items()}
    log_likelihood = 0.0
    for symbols, words in pairs:
        sources = [0, *(s + 1 for s in symbols)]
        shape = (len(symbols), len(words))
        weights = {}
        for alignment in itertools.product(range(len(sources)), repeat=len(words)):
            weights[alignment] = np.prod(
                [a[shape][j, i] * t[sources[i], words[j]] for j, i in enumerate(alignment)]
            )
        total = sum(weights.values())
        log_likelihood += np.log(total)
        for alignment, weight in weights.items():
            for j, i in enumerate(alignment):
                t_counts[sources[i], words[j]] += weight / total
                a_counts[shape][j, i] += weight / total
    sums = t_counts.sum(axis=1, keepdims=True)
    new_t = np.divide(t_counts, sums, out=t.copy(), where=sums > 0)
    new_a = {shape: table / table.sum(axis=1, keepdims=True) for shape, table in a_counts.items()}
    return new_t, new_a, log_likelihood


def random_pairs(rng, n_pairs, n_symbols, n_words, longest=4):
    return [
        pair(
            rng.integers(0, n_symbols, rng.integers(1, longest + 1)),
            rng.integers(0, n_words, rng.integers(1, longest)),
        )
        for _ in range(n_pairs)
    ]


def vocabulary(n_words):
    return [f"w{k}" for k in range(n_words)]


def test_repeated_word_is_explained_at_each_position():
    one = fit_association(REPEATED, 3, vocabulary(2), model1_iterations=1, model2_iterations=0)
    assert one.translation[1, 0] == pytest.approx(5 / 6)
    assert abs(one.translation[1, 0] - 7 / 9) > 0.05


def test_one_step_by_hand():
    """Two symbols, one pair, l = 1, m = 1: NULL and the symbol share the word."""
    table = lay_out([pair([0], [0]), pair([0], [1])])
    t, a = uniform_start(table, 1, 2)
    new_t, new_a, log_likelihood = em_step(table, t, a, learn_a=True)
    assert new_t.tolist() == [[0.5, 0.5], [0.5, 0.5]]
    assert new_a.tolist() == [0.5, 0.5]
    assert log_likelihood == pytest.approx(2 * np.log(0.5))


@pytest.mark.parametrize("seed", range(3))
def test_both_models_equal_the_sum_over_all_alignments(seed):
    rng = np.random.default_rng(seed)
    pairs = [*random_pairs(rng, 5, 3, 3), *REPEATED]
    n_symbols, n_words = 3, 3
    start = lay_out(pairs)
    flat_t, _ = uniform_start(start, n_symbols, n_words)
    t = flat_t.T.copy()
    uniform = {(len(s), len(w)): np.full((len(w), len(s) + 1), 1 / (len(s) + 1)) for s, w in pairs}
    traced = []
    for _ in range(2):
        t, _, value = enumerate_step(pairs, t, uniform, n_symbols, n_words)
        traced.append(value)
    a = uniform
    for _ in range(2):
        t, a, value = enumerate_step(pairs, t, a, n_symbols, n_words)
        traced.append(value)
    traced.append(enumerate_step(pairs, t, a, n_symbols, n_words)[2])
    fit = fit_association(
        pairs, n_symbols, vocabulary(n_words),
        model1_iterations=2, model2_iterations=2, tolerance=-np.inf,
    )  # fmt: skip
    np.testing.assert_allclose(fit.translation, t, atol=1e-12)
    for shape, table in a.items():
        np.testing.assert_allclose(fit.alignment[shape], table, atol=1e-12)
    np.testing.assert_allclose(fit.log_likelihoods, traced[1:], atol=1e-9)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 12), st.integers(1, 5), st.integers(1, 5))
def test_likelihood_never_falls_and_rows_sum_to_one(seed, n_pairs, n_symbols, n_words):
    pairs = random_pairs(np.random.default_rng(seed), n_pairs, n_symbols, n_words)
    fit = fit_association(pairs, n_symbols, vocabulary(n_words), tolerance=-np.inf)
    assert len(fit.log_likelihoods) == 30
    assert np.diff(fit.log_likelihoods).min() > -1e-9 * (1 + abs(fit.log_likelihoods[0]))
    seen = np.unique(np.concatenate([[-1], *(s for s, _ in pairs)])) + 1
    np.testing.assert_allclose(fit.translation[seen].sum(axis=1), 1.0)
    unseen = np.setdiff1d(np.arange(n_symbols + 1), seen)
    assert not fit.translation[unseen].any()
    for table in fit.alignment.values():
        np.testing.assert_allclose(table.sum(axis=1), 1.0)
    total = sum(log_probability(fit, s, w) for s, w in pairs)
    assert total == pytest.approx(fit.log_likelihoods[-1])


def test_stops_when_it_stands_still():
    fit = fit_association([pair([0], [0])], 1, ["walk"])
    assert len(fit.log_likelihoods) == 2
    assert fit.counts.tolist() == [1]


def test_captures_without_words_or_symbols_are_no_fault():
    fit = fit_association([pair([0], []), pair([], [0])], 1, ["walk", "sit"])
    assert fit.translation[0].tolist() == [1.0, 0.0]
    assert not fit.translation[1].any()
    assert list(fit.alignment) == [(0, 1)]
    nothing = fit_association([], 2, [])
    assert nothing.translation.shape == (3, 0)
    assert nothing.alignment == {}


def test_numbers_out_of_range_are_named():
    with pytest.raises(ValueError, match=r"^pair 1: expected symbol numbers from 0 to 1, found 7"):
        fit_association([pair([0], [0]), pair([7], [0])], 2, ["walk"])
    with pytest.raises(ValueError, match=r"^pair 0: expected word numbers from 0 to 0, found -1"):
        fit_association([pair([0], [-1])], 2, ["walk"])


def fitted(seed=0):
    pairs = [*random_pairs(np.random.default_rng(seed), 8, 3, 3), *REPEATED]
    return pairs, fit_association(pairs, 3, vocabulary(3), model2_iterations=2)


def test_probability_and_posterior_equal_the_sum_over_all_alignments():
    _, fit = fitted()
    symbols, words = np.array([0, 2, 0]), np.array([1, 1, 0])
    a = alignment_table(fit, 3, 3)
    sources = [0, 1, 3, 1]
    weights = {
        i: np.prod([a[j, i[j]] * fit.translation[sources[i[j]], words[j]] for j in range(3)])
        for i in itertools.product(range(4), repeat=3)
    }
    total = sum(weights.values())
    assert log_probability(fit, symbols, words) == pytest.approx(np.log(total))
    posterior = alignment_posterior(fit, symbols, words)
    for j, i in itertools.product(range(3), range(4)):
        share = sum(w for alignment, w in weights.items() if alignment[j] == i) / total
        assert posterior[j, i] == pytest.approx(share)


def test_counts_of_all_captures_make_the_next_step():
    pairs, fit = fitted()
    table = lay_out(pairs)
    flat = np.concatenate([fit.alignment[shape].ravel() for shape in table.shapes])
    t, a, _ = em_step(table, np.ascontiguousarray(fit.translation.T), flat, learn_a=True)
    step = with_counts(fit, functools.reduce(operator.add, [pair_counts(fit, *p) for p in pairs]))
    np.testing.assert_allclose(step.translation, t.T, atol=1e-8)
    tables = np.concatenate([step.alignment[shape].ravel() for shape in table.shapes])
    np.testing.assert_allclose(tables, a, atol=1e-8)


@settings(max_examples=30, deadline=None)
@given(st.permutations(range(11)), st.integers(1, 10))
def test_removal_is_exact_in_any_order(order, n_removed):
    pairs, fit = fitted()
    counts = [pair_counts(fit, *p) for p in pairs]
    total = functools.reduce(operator.add, [counts[k] for k in order])
    for k in order[:n_removed]:
        total = total - counts[k]
    kept = functools.reduce(operator.add, [counts[k] for k in sorted(order[n_removed:])])
    assert np.array_equal(total.translation, kept.translation)
    assert total.n_pairs == kept.n_pairs
    assert total.alignment.keys() == kept.alignment.keys()
    for shape, table in total.alignment.items():
        assert np.array_equal(table, kept.alignment[shape])


def test_unseen_lengths_fall_back_to_the_diagonal():
    fit = fit_association([pair([0], [0])], 1, ["walk"])
    np.testing.assert_array_equal(alignment_table(fit, 1, 1), fit.alignment[1, 1])
    table = alignment_table(fit, 5, 3)
    np.testing.assert_allclose(table.sum(axis=1), 1.0)
    np.testing.assert_allclose(table[:, 0], 0.08)
    assert table[:, 1:].argmax(axis=1).tolist() == [0, 2, 4]
    np.testing.assert_allclose(diagonal_alignment(4, 2, 0.0)[:, 1:], 0.92 / 4)
    assert diagonal_alignment(0, 2, 4.0).tolist() == [[1.0], [1.0]]


def test_smoothing_leaves_distributions_without_zeros():
    pairs, fit = fitted()
    soft = smoothed(fit, {(1, 2): 3}, share=0.1)
    np.testing.assert_allclose(soft.translation.sum(axis=1), 1.0)
    assert soft.translation.min() > 0
    for shape, table in soft.alignment.items():
        np.testing.assert_allclose(table.sum(axis=1), 1.0)
        trust = 3 / 8 if shape == (1, 2) else 1 / 6
        mixed = trust * fit.alignment[shape] + (1 - trust) * diagonal_alignment(*shape, 4.0)
        np.testing.assert_allclose(table, mixed)
    assert np.isfinite(sum(log_probability(soft, s, w) for s, w in pairs))
