"""Terminals that may show one action: medoids that are alike, as they are or mirrored.

The search for terminals gives several terminals to one action if the action is shown in several
ways, such as a kick with the left and with the right leg. The distance of two terminals is the
median distance of the segments of one from the medoid of the other, or from the mirror image of
that medoid, whichever is less. Terminals are joined in order of this distance (complete linkage).
Each level of joining is a partition of the terminals into classes. Here the levels are only
proposed: whether a class saves bits is decided by the rules
(:mod:`motiondb.grammar.sentences.classes`), since actions that are alike may still have different
places in a sentence.

Proposed are the levels before the greatest steps of the distance. Where some terminals are variants
of one action and the others are different actions, the distance takes a great step between them.

Source for the levels of least dissimilarity: S. C. Johnson, "Hierarchical clustering schemes",
Psychometrika 32 (1967).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motiondb.body import retarget
from motiondb.grammar.terminals.pose_distance import make_poses
from motiondb.grammar.terminals.segment_distance import distances_to
from motiondb.grammar.terminals.terminals import Terminals
from motiondb.records import FloatArray, IntArray, Motion

Classes = tuple[tuple[str, ...], ...]
"""A partition of the names of terminals; every name is in one class."""

PROPOSED = 3  # Number of levels that are proposed. Chosen by hand, to bound the time; not tuned

FEWEST, FEWEST_SHARE = 3, 0.5
"""Fewest classes of a level, and fewest as a share of the terminals. Chosen by hand: with four
classes of ten terminals, a salsa became sentences of any three terminals of one large class, in
about as many bits as a list. On takes of fights the proposals are the same without the share."""


def class_levels(takes: Sequence[Motion], terminals: Terminals) -> tuple[Classes, ...]:
    """Propose partitions of terminals into classes of like motion."""
    joined = joinings(terminal_distances(takes, terminals))
    return tuple(
        tuple(tuple(terminals.names[k] for k in members) for members in groups)
        for groups in steepest(joined, PROPOSED)
    )


def terminal_distances(takes: Sequence[Motion], terminals: Terminals) -> FloatArray:
    """Return the distances between terminals, mirror images included; result (K, K)."""
    poses = make_poses([*takes, *map(retarget.mirror, takes)])
    offsets = poses.bounds[terminals.takes]
    starts, ends = terminals.starts + offsets, terminals.ends + offsets
    n_groups, mirrored = len(terminals.names), int(poses.bounds[len(takes)])
    table = np.zeros((n_groups, n_groups))
    for k, medoid in enumerate(terminals.medoids):
        a, b = int(starts[medoid]), int(ends[medoid])
        ways = [distances_to(poses.values, a + s, b + s, starts, ends) for s in (0, mirrored)]
        for j in range(n_groups):
            table[j, k] = min(float(np.median(way[terminals.labels == j])) for way in ways)
    table = np.minimum(table, table.T)
    np.fill_diagonal(table, 0.0)
    return table


Groups = tuple[tuple[int, ...], ...]


def joinings(distances: FloatArray) -> list[tuple[float, Groups]]:
    """Join groups by complete linkage, one pair at a time.

    Shapes: `distances` (K, K).

    >>> joinings(np.array([[0.0, 1.0, 5.0], [1.0, 0.0, 4.0], [5.0, 4.0, 0.0]]))
    [(1.0, ((0, 1), (2,))), (5.0, ((0, 1, 2),))]
    """
    n = len(distances)
    table = np.where(np.eye(n, dtype=np.bool_), np.inf, distances)
    groups: dict[int, tuple[int, ...]] = {k: (k,) for k in range(n)}
    joined = []
    for _ in range(n - 1):
        i, j = sorted(divmod(int(np.argmin(table)), n))
        height = float(table[i, j])
        table[i] = table[:, i] = np.maximum(table[i], table[j])
        table[j] = table[:, j] = table[i, i] = np.inf
        groups[i] = tuple(sorted(groups[i] + groups.pop(j)))
        joined.append((height, tuple(sorted(groups.values()))))
    return joined


def steepest(joined: Sequence[tuple[float, Groups]], most: int) -> list[Groups]:
    """Return the groups before the greatest relative steps of the distance.

    >>> levels = [(1.0, ((0, 1), (2,), (3,), (4,))), (4.0, ((0, 1), (2, 3), (4,)))]
    >>> steepest([*levels, (5.0, ((0, 1), (2, 3, 4))), (9.0, ((0, 1, 2, 3, 4),))], 2)
    [((0, 1), (2,), (3,), (4,)), ((0, 1), (2, 3), (4,))]
    """
    heights = np.array([height for height, _ in joined])
    steps: IntArray = np.argsort(-(heights[1:] / np.maximum(heights[:-1], 1e-12)), kind="stable")
    groups = [joined[step][1] for step in steps.tolist()]
    fewest = max(FEWEST, FEWEST_SHARE * (len(joined) + 1))
    return [one for one in groups if len(one) >= fewest][:most]
