"""Intervals of actions in order, against a search through all of them."""

from itertools import pairwise, product

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from motiondb.meaning.edge_map import SHORTEST, FrameOrder, lay_in_order
from motiondb.meaning.extents import best_spans
from motiondb.records import FloatArray


def _best_of_all(values: FloatArray) -> float:
    """The largest sum over every way to lay the intervals."""
    n_actions, n = values.shape
    spans = [(a, b) for a in range(n) for b in range(a + SHORTEST, n + 1)]
    sums = [
        sum(values[k, a:b].sum() for k, (a, b) in enumerate(laid))
        for laid in product(spans, repeat=n_actions)
        if all(before[1] <= after[0] for before, after in pairwise(laid))
    ]
    return float(max(sums))


@given(st.integers(0, 10_000), st.integers(1, 2))
def test_the_best_spans_are_those_of_a_search_through_all(seed: int, n_actions: int) -> None:
    rng = np.random.default_rng(seed)
    values = rng.normal(size=(n_actions, int(rng.integers(SHORTEST * n_actions, 12))))
    spans = best_spans(values, SHORTEST)
    assert all(b - a >= SHORTEST for a, b in spans)
    assert all(before[1] <= after[0] for before, after in pairwise(spans))
    laid = sum(values[k, a:b].sum() for k, (a, b) in enumerate(spans))
    assert np.isclose(laid, _best_of_all(values))


def _take(*pieces: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    """Evidence of two actions in pieces of ten frames."""
    first, second = np.repeat(np.array(pieces), 10, axis=0).T
    return first, second


def test_a_frame_belongs_to_the_action_that_it_shows_better() -> None:
    run, jump = _take((1.0, 0.1), (0.8, 1.0), (0.2, 0.1))
    order = lay_in_order(np.stack([run, jump]), (0, 30))
    assert order is not None
    assert order.spans == ((0, 10), (10, 20))
    assert order.is_seen


def test_a_second_run_must_run() -> None:
    run, stop = _take((2.0, 0.0), (0.1, 0.5), (0.1, 0.4))
    stands = lay_in_order(np.stack([run, stop, run]), (0, 30))
    run, stop = _take((2.0, 0.0), (0.1, 0.5), (1.2, 0.1))
    runs = lay_in_order(np.stack([run, stop, run]), (0, 30))
    assert stands is not None
    assert not stands.is_seen
    assert runs is not None
    assert runs.is_seen
    assert runs.spans == ((0, 10), (10, 20), (20, 30))


def test_the_reverse_of_an_order_is_not_seen() -> None:
    first, second = _take((1.0, 0.0), (0.0, 1.0))
    order = lay_in_order(np.stack([second, first]), (0, 20))
    assert order is not None
    assert not order.is_seen


def test_the_largest_evidence_may_lie_outside_the_room() -> None:
    first, second = _take((0.4, 0.0), (0.0, 1.0), (1.0, 0.0))
    order = lay_in_order(np.stack([first, second]), (0, 20))
    assert order is not None
    assert not order.is_seen


def test_without_room_or_evidence_there_is_no_answer() -> None:
    assert lay_in_order(np.ones((2, 30)), (0, 2 * SHORTEST - 1)) is None
    assert lay_in_order(np.stack([np.ones(30), np.zeros(30)]), (0, 30)) == FrameOrder((), False)
