"""Bigrams with begin and end, plain and clustered."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.language.translation.transition import (
    count_transitions,
    log_bigram,
    log_clustered_bigram,
    log_interpolated_bigram,
)

SEQUENCES = st.lists(st.lists(st.integers(0, 5), max_size=6), max_size=6)


def counted(sequences, n_symbols=6):
    return count_transitions([np.array(s, dtype=np.int64) for s in sequences], n_symbols)


def test_by_hand():
    """walk walk sit; sit. Begin goes to each once; walk to walk and sit; sit ends twice."""
    counts = counted([[0, 0, 1], [1]], 3)
    expected = [[0, 0.5, 0.5, 0], [0, 0.5, 0.5, 0], [1, 0, 0, 0], [1, 0, 0, 0]]
    np.testing.assert_allclose(np.exp(log_bigram(counts)), expected)
    bigram = log_bigram(counts)
    walk_walk_sit = [bigram[0, 1], bigram[1, 1], bigram[1, 2], bigram[2, 0]]
    assert sum(walk_walk_sit) == pytest.approx(3 * np.log(0.5))
    assert bigram[2, 1] == -np.inf


@settings(max_examples=60, deadline=None)
@given(SEQUENCES, st.lists(st.integers(0, 3), min_size=6, max_size=6))
def test_rows_sum_to_one_and_zeros_are_those_of_the_clusters(sequences, clusters):
    counts = counted(sequences)
    plain, clustered = log_bigram(counts), log_clustered_bigram(counts, np.array(clusters))
    np.testing.assert_allclose(np.exp(plain).sum(axis=1), 1.0)
    np.testing.assert_allclose(np.exp(clustered).sum(axis=1), 1.0)
    groups = ["edge", *clusters]
    seen = {(groups[r], groups[c]) for r, c in zip(*np.nonzero(counts))}
    for r in range(7):
        if counts[r].any():
            for c in range(7):
                assert (clustered[r, c] > -np.inf) == ((groups[r], groups[c]) in seen)


@settings(max_examples=40, deadline=None)
@given(SEQUENCES)
def test_one_symbol_per_cluster_is_the_plain_bigram(sequences):
    counts = counted(sequences)
    np.testing.assert_allclose(
        np.exp(log_clustered_bigram(counts, np.arange(6) * 3)), np.exp(log_bigram(counts)),
        atol=1e-15,
    )  # fmt: skip


@settings(max_examples=40, deadline=None)
@given(SEQUENCES, SEQUENCES)
def test_counts_are_additive_so_removal_is_exact(first, second):
    assert np.array_equal(counted(first + second) - counted(second), counted(first))


def test_clusters_by_hand():
    """Symbols 0 and 1 share a cluster; only 0 was seen to lead to 2."""
    counts = counted([[0, 2], [1]], 3)
    probability = np.exp(log_clustered_bigram(counts, np.array([7, 7, 9])))
    np.testing.assert_allclose(probability[0], [0, 0.5, 0.5, 0])
    np.testing.assert_allclose(probability[1], [0.5, 0, 0, 0.5])
    np.testing.assert_allclose(probability[2], probability[1])
    np.testing.assert_allclose(probability[3], [1, 0, 0, 0])


def test_shares_within_a_cluster_follow_the_counts():
    """Symbol 0 twice, symbol 1 once: (2 + 1/2) to (1 + 1/2)."""
    probability = np.exp(log_clustered_bigram(counted([[0], [0], [1]], 2), np.array([0, 0])))
    np.testing.assert_allclose(probability[0], [0, 2.5 / 4, 1.5 / 4])


def test_a_row_trusts_what_it_saw_often_and_always_alike() -> None:
    """N / (N + D): 4 counts on 1 follower keep 4 / 5, 4 counts on 4 followers keep 1 / 2."""
    counts = np.zeros((6, 6))
    counts[1, 2] = 4.0
    counts[2, 1:5] = 1.0
    clusters = np.zeros(5, dtype=int)
    mixed = np.exp(log_interpolated_bigram(counts, clusters))
    plain = np.exp(log_bigram(counts))
    clustered = np.exp(log_clustered_bigram(counts, clusters))
    assert np.allclose(mixed[1], 0.8 * plain[1] + 0.2 * clustered[1])
    assert np.allclose(mixed[2], 0.5 * plain[2] + 0.5 * clustered[2])
    assert np.allclose(mixed[5], clustered[5])  # never followed: the clusters alone
    assert np.allclose(mixed.sum(axis=1), 1.0)
