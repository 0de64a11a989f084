"""Closures of graphs against matrix inverses, shortest paths and counted paths."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motiondb.grammar.cfg.closure import (
    BEST,
    COUNT,
    SUM,
    Sparse,
    close_graph,
    strong_components,
)


@st.composite
def matrices(draw: st.DrawFn) -> np.ndarray:
    """Square matrices of weights whose rows sum to less than 1, many entries 0."""
    n = draw(st.integers(1, 7))
    weights = st.sampled_from([0.0, 0.0, 0.0, 0.1, 0.3, 0.6])
    matrix = np.array(draw(st.lists(weights, min_size=n * n, max_size=n * n))).reshape(n, n)
    return matrix / max(1.05, matrix.sum(axis=1).max() * 1.05)


def graph_of(matrix: np.ndarray) -> Sparse:
    rows, columns = np.nonzero(matrix)
    starts = np.searchsorted(rows, np.arange(len(matrix) + 1))
    return Sparse(starts, columns.copy(), matrix[rows, columns])  # contiguous, as a program's


def dense(n: int, starts: np.ndarray, columns: np.ndarray, values: np.ndarray) -> np.ndarray:
    matrix = np.zeros((n, n))
    matrix[np.repeat(np.arange(n), np.diff(starts)), columns] = values
    return matrix


@given(matrices())
@settings(max_examples=50, deadline=None)
def test_sums_are_the_inverse(matrix: np.ndarray) -> None:
    n = len(matrix)
    starts, columns, values = close_graph(SUM, graph_of(matrix))
    expected = np.linalg.inv(np.eye(n) - matrix)
    assert pytest.approx(expected, rel=1e-9, abs=1e-12) == dense(n, starts, columns, values).T
    for a in range(n):
        assert (np.diff(columns[starts[a] : starts[a + 1]]) > 0).all()


@given(matrices())
@settings(max_examples=50, deadline=None)
def test_best_is_the_best_of_all_paths(matrix: np.ndarray) -> None:
    best = np.maximum(np.eye(len(matrix)), matrix)
    for _ in matrix:
        best = np.maximum(best, (best[:, :, None] * best[None, :, :]).max(axis=1))
    actual = dense(len(matrix), *close_graph(BEST, graph_of(matrix)))
    assert pytest.approx(best, rel=1e-12) == actual.T


@given(matrices())
@settings(max_examples=50, deadline=None)
def test_numbers_of_paths(matrix: np.ndarray) -> None:
    n, step = len(matrix), (matrix > 0).astype(float)
    powers = [np.linalg.matrix_power(step, k) for k in range(2 * n + 1)]
    endless = sum(powers[n:]) > 0  # a path of n steps or more passes a node twice
    expected = np.where(endless, inf, sum(powers[:n]))
    starts, columns, _ = graph_of(matrix)
    actual = dense(n, *close_graph(COUNT, Sparse(starts, columns, np.ones(len(columns)))))
    assert (expected == actual.T).all()


@given(matrices())
@settings(max_examples=50, deadline=None)
def test_components_are_mutual_reach_parts_first(matrix: np.ndarray) -> None:
    starts, columns, _ = graph_of(matrix)
    label = strong_components(starts, columns)
    reach = np.linalg.matrix_power(np.eye(len(matrix)) + (matrix > 0), len(matrix)) > 0
    assert ((label[:, None] == label[None, :]) == (reach & reach.T)).all()
    assert (label[:, None] >= np.where(reach, label[None, :], 0)).all()
