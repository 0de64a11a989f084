"""Proposals of clips: uniform, another variant of the same piece, or by the seams.

The entries of a terminal fall into groups of one seam class (the variants of one clip: bent and
stretched, with the same poses). There are three ways to draw a new entry for an action. For each,
Metropolis-Hastings needs the logarithm of the ratio q(old) / q(new):

    uniform   among the terminal's entries (the paper's Q_I)                ratio 1
    variant   among those of the same group                                 ratio 1
    by seams  a group with weight size * exp(-(cost of both its seams) / T), then uniform in it.
              The neighbours stay, so both directions have the same normaliser: the ratio is that of
              the two exponentials, and the acceptance depends on everything but the seams

The clips of several consecutive actions can be drawn by their seams at once
(:func:`smooth_string`): a backward pass sums over all strings of clips between the neighbours, then
a forward pass draws one group after the other. The probability of a string of clips is exp(-its
seams / T) over that sum.

Source: forward filtering and backward sampling, S. L. Scott, "Bayesian methods for hidden Markov
models", Journal of the American Statistical Association 97 (2002); proposals from a part of the
target, W. K. Hastings, "Monte Carlo sampling methods using Markov chains and their applications",
Biometrika 57 (1970).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from motiondb.grammar.kernels import kernel, maker
from motiondb.records import FloatArray, IntArray
from motiondb.scene.energy.placement import ClipArrays


class ClipGroups(NamedTuple):
    """The entries of a library by terminal and seam class: G groups, K entries, C classes."""

    members: IntArray  # (K,), int: entries, sorted by group
    first: IntArray  # (G + 1,), int: where each group begins in ``members``
    group: IntArray  # (K,), int: the group of an entry
    seam: IntArray  # (G,), int: the seam class of a group
    # (K, 2), int: for every entry the first group of its terminal, and the one after the last
    near: IntArray
    follow: FloatArray  # (C, C): exp(-seam cost / T) of class a before b
    precede: FloatArray  # (C, C): the transpose of ``follow``


def clip_groups(library: ClipArrays, smooth: float, temperature: float) -> ClipGroups:
    """Return the groups of a library."""
    clips = library.clips
    keys = np.stack([clips["first"], clips["seam"]], axis=1)
    groups, group = np.unique(keys, axis=0, return_inverse=True)
    group = group.reshape(-1).astype(np.int64)
    members = np.argsort(group, kind="stable").astype(np.int64)
    first = np.searchsorted(group[members], np.arange(len(groups) + 1)).astype(np.int64)
    starts = groups[:, 0]
    near = np.stack(
        [
            np.searchsorted(starts, clips["first"], "left"),
            np.searchsorted(starts, clips["first"], "right"),
        ],
        axis=1,
    ).astype(np.int64)
    none = np.zeros((0, 0))
    cold = ClipGroups(members, first, group, groups[:, 1].astype(np.int64), near, none, none)
    return tempered(cold, library, smooth, temperature)


def tempered(
    groups: ClipGroups, library: ClipArrays, smooth: float, temperature: float
) -> ClipGroups:
    """Return the groups for a chain of another temperature; see :func:`clip_groups`."""
    follow = np.exp(-np.asarray(library.seams) / (smooth * temperature))
    return groups._replace(follow=follow, precede=np.ascontiguousarray(follow.T))


@kernel
def uniform_entry(library: ClipArrays, entry: int, u: float) -> int:
    """Return an entry of the same terminal; ``u`` is uniform in [0, 1)."""
    clip = library.clips[entry]
    return int(clip.first + int(u * (clip.last - clip.first)))


@kernel
def variant_entry(groups: ClipGroups, entry: int, u: float) -> int:
    """Return an entry of the same group; ``u`` is uniform in [0, 1)."""
    g = groups.group[entry]
    first = groups.first[g]
    return int(groups.members[first + int(u * (groups.first[g + 1] - first))])


@kernel
def _seam_weight(groups: ClipGroups, g: int, before: int, after: int) -> float:
    """Return exp(-(its seams) / T) of a group between two classes; -1 means no neighbour."""
    c = groups.seam[g]
    weight = 1.0
    if before >= 0:
        weight = groups.follow[before, c]
    if after >= 0:
        weight *= groups.precede[after, c]
    return max(weight, 1e-200)


@kernel
def smooth_entry(
    groups: ClipGroups, entry: int, before: int, after: int, u: float
) -> tuple[int, float]:
    """Return an entry of the same terminal drawn by its seams, and log(q(old) / q(new)).

    Parameters
    ----------
    groups : ClipGroups
        The groups.
    entry : int
        The old entry.
    before : int
        Seam class of the entry before it, -1 if there is none.
    after : int
        Seam class of the entry after it, -1 if there is none.
    u : float
        Uniform random number in [0, 1).
    """
    since, until = groups.near[entry]
    total = 0.0
    for g in range(since, until):
        size = groups.first[g + 1] - groups.first[g]
        total += size * _seam_weight(groups, g, before, after)
    left = u * total
    chosen, share = until - 1, 0.0
    for g in range(since, until):
        size = groups.first[g + 1] - groups.first[g]
        weight = size * _seam_weight(groups, g, before, after)
        if left < weight:
            chosen, share = g, left / weight
            break
        left -= weight
    first = groups.first[chosen]
    size = groups.first[chosen + 1] - first
    new = groups.members[first + min(int(share * size), size - 1)]
    old_weight = _seam_weight(groups, groups.group[entry], before, after)
    return int(new), np.log(old_weight / _seam_weight(groups, chosen, before, after))


def smooth_string(
    groups: ClipGroups,
    ranges: IntArray,
    before: int,
    after: int,
    rng: np.random.Generator | None,
    entries: IntArray | None = None,
) -> tuple[IntArray, float]:
    """Return a clip for each of several actions, drawn by the seams, and its log probability.

    Shapes: `ranges` (actions, 2), int; `entries` (actions,), int.
    """
    n = len(ranges)
    if n == 0:
        return np.zeros(0, np.int64), 0.0
    chosen = np.zeros(n, np.int64) if entries is None else np.array(entries, np.int64)
    draws = np.zeros((0, 2)) if entries is not None or rng is None else rng.random((n, 2))
    firsts = np.ascontiguousarray(ranges[:, 0])
    return chosen, float(_string(groups, firsts, before, after, draws, chosen))


@maker
def _string(
    groups: ClipGroups,
    firsts: IntArray,
    before: int,
    after: int,
    draws: FloatArray,
    entries: IntArray,
) -> float:
    """Fill ``entries`` from ``draws`` (actions, 2), or keep them; return their log probability."""
    n = len(firsts)
    near = groups.near[firsts]
    rests = np.zeros((n, np.max(near[:, 1] - near[:, 0])))
    for k in range(n - 1, -1, -1):
        since, until = near[k]
        for i in range(until - since):
            c = groups.seam[since + i]
            if k == n - 1:
                rests[k, i] = _end_weight(groups.precede, after, c)
                continue
            for j in range(near[k + 1, 1] - near[k + 1, 0]):
                g = near[k + 1, 0] + j
                size = groups.first[g + 1] - groups.first[g]
                rests[k, i] += groups.follow[c, groups.seam[g]] * size * rests[k + 1, j]
        if k < n - 1:
            rests[k] /= np.max(rests[k])
    log_probability = 0.0
    for k in range(n):
        since, until = near[k]
        weights = np.zeros(until - since)  # of one entry of each group
        total = 0.0
        for i in range(until - since):
            weights[i] = _end_weight(groups.follow, before, groups.seam[since + i]) * rests[k, i]
            total += weights[i] * (groups.first[since + i + 1] - groups.first[since + i])
        if len(draws) > 0:
            g = _group_at(groups, weights, since, draws[k, 0] * total)
            size = groups.first[g + 1] - groups.first[g]
            entries[k] = groups.members[groups.first[g] + min(int(draws[k, 1] * size), size - 1)]
        g = groups.group[entries[k]]
        log_probability += np.log(weights[g - since] / total)
        before = groups.seam[g]
    return log_probability


@kernel
def _group_at(groups: ClipGroups, weights: FloatArray, since: int, left: float) -> int:
    """Return the group at the point ``left`` of the cumulative weights of groups from ``since``."""
    for i in range(len(weights)):
        left -= weights[i] * (groups.first[since + i + 1] - groups.first[since + i])
        if left < 0.0:
            return since + i
    return since + len(weights) - 1


@kernel
def _end_weight(table: FloatArray, neighbour: int, c: int) -> float:
    """Return exp(-seam / T) of a neighbour and class ``c``; 1 if there is no neighbour."""
    return max(table[neighbour, c], 1e-200) if neighbour >= 0 else 1.0
