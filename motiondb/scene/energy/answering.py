"""Which answer belongs to which act: one to one and in order.

An alignment of two short sequences by dynamic programming: as many pairs as possible, and among
these those whose two sides are drawn at the same step of the diagram.
"""

from __future__ import annotations

from collections.abc import Sequence


def aligned(
    acts: Sequence[tuple[int, int]], replies: Sequence[tuple[int, int]]
) -> list[tuple[int, int]]:
    """Return pairs of acts and answers in order, as many as possible, of the same step if possible.

    Acts and answers are given by number and step. -1 stands for one that is missing.

    >>> aligned([(0, 1), (3, 2)], [(1, 2)])
    [(0, -1), (3, 1)]
    """
    best: list[list[tuple[float, list[tuple[int, int]]]]]
    best = [[(0.0, [(-1, m) for m, _ in replies[:j]]) for j in range(len(replies) + 1)]]
    for i, (k, step) in enumerate(acts, start=1):
        row = [(best[i - 1][0][0], [*best[i - 1][0][1], (k, -1)])]
        for j, (m, their) in enumerate(replies, start=1):
            (left, one), (up, two), (both, three) = row[j - 1], best[i - 1][j], best[i - 1][j - 1]
            row.append(
                max(
                    (up, [*two, (k, -1)]),  # the earliest of several that are as good
                    (left, [*one, (-1, m)]),
                    (both + 1.0 + 0.5 * (step == their), [*three, (k, m)]),
                    key=lambda found: found[0],
                )
            )
        best.append(row)
    return best[-1][-1][1]
