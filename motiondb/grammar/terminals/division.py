"""Divide a medoid in two, and give up another: exchanges that need two steps at once.

The search of :mod:`.exchange` exchanges one medoid at a time. It cannot leave a segmentation in
which one terminal holds two movements that always follow each other, such as lowering the fists at
the end of a bout and raising them at the beginning of the next. If only one of the two parts
becomes a medoid, the other part is like no medoid, wherever it occurs, so this step costs much.
Both parts together may cost less than the whole: they also stand for the places at which one of
them occurs alone, such as the two ends of a take.

A division takes the place of medoid k. Its cell, or that of a segment like it, [a, b) is cut at a
candidate c, the cell [a, c) becomes medoid k, and [c, b) is exchanged for the medoid that is least
needed then. So their number does not change. All medoids, some segments of each and all their
candidates are tried, and the division of least G is made, until none lowers G.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from motiondb.grammar.terminals.exchange import (
    LEAST_GAIN,
    State,
    Task,
    cell_costs,
    exchange_of,
    settle,
)

_SEGMENTS = 6
"""Segments of each terminal that are tried in the place of its medoid. Not every segment has a
candidate cut at the right frame. Chosen by hand, to bound the time; not tuned."""


def divide(task: Task, state: State) -> State:
    """Divide medoids as long as that lowers G."""
    while True:
        divided = (  # one at a time: each holds a table of distances
            one
            for k in range(len(state.medoids))
            for cell in _cells_of(task, state, k)
            for first, second in parts_of(task, cell)
            if (one := _division(task, state, k, first, second)) is not None
        )
        best = min(divided, key=lambda one: one.cost, default=None)
        if best is None:
            return state
        state = best


def _cells_of(task: Task, state: State, k: int) -> list[int]:
    """Return medoid k and the segments of its terminal that are most like it."""
    path = state.path[state.nearest[state.path] == k]
    lengths = task.cells.ends[path] - task.cells.starts[path]
    near = path[np.argsort(state.table[k, path] / lengths, kind="stable")[:_SEGMENTS]]
    return list(dict.fromkeys([int(state.medoids[k]), *near.tolist()]))


def parts_of(task: Task, medoid: int) -> Iterator[tuple[int, int]]:
    """Yield the pairs of cells into which a cell can be cut, in order of the cut."""
    cells = task.cells
    first, last = int(cells.firsts[medoid]), int(cells.lasts[medoid])
    for cut in range(first + 1, last):
        before, after = _cell(task, first, cut), _cell(task, cut, last)
        if before >= 0 and after >= 0:
            yield before, after


def _cell(task: Task, first: int, last: int) -> int:
    """Return the cell between two cuts, -1 if it is not allowed."""
    low, high = task.cells.pointers[last : last + 2]
    places = np.flatnonzero(task.cells.firsts[low:high] == first)
    return int(low + places[0]) if len(places) else -1


def _division(task: Task, state: State, k: int, first: int, second: int) -> State | None:
    """Return the state with ``first`` in place of medoid k and ``second`` of another.

    The other one is the medoid that is least needed then. None if that does not lower G.
    """
    if first in state.medoids or second in state.medoids:
        return None
    medoids, table = state.medoids.copy(), state.table.copy()
    medoids[k] = first
    cell_costs(task, first, table[k])
    begun = settle(task, medoids, table)
    tried = np.empty_like(begun.least)
    cell_costs(task, second, tried)
    given_up = exchange_of(task, begun, second, tried, state.cost * (1.0 - LEAST_GAIN))
    if given_up < 0:
        return None
    medoids[given_up], table[given_up] = second, tried
    return settle(task, medoids, table)
