"""Which clip to try instead of another: uniformly, of the same piece, or by the seams.

The entries of a terminal fall into groups of one seam class (the variants of one clip: bent and
stretched, with the same poses). Three ways to draw a new entry for an action, with the logarithm of
the ratio q(old) / q(new) that Metropolis-Hastings asks for:

    uniform   among the terminal's entries (the paper's Q_I)                ratio 1
    variant   among those of the same group                                 ratio 1
    by seams  a group by size * exp(-(cost of both its seams) / T), then uniform in it. The
              neighbours stay, so both directions have the same normaliser: the ratio is that of the
              two exponentials, and what is left of the acceptance is everything but the seams

A whole stretch of actions is drawn by its seams at once (:func:`smooth_string`): backwards the sums
over all strings of clips between its neighbours, then forwards one group after the other. A clip
string's probability is exp(-its seams / T) over that sum.

Source: forward filtering and backward sampling, S. L. Scott, "Bayesian methods for hidden Markov
models", Journal of the American Statistical Association 97 (2002); proposals from a part of the
target, W. K. Hastings, "Monte Carlo sampling methods using Markov chains and their applications",
Biometrika 57 (1970).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from motiondb.records import FloatArray, IntArray
from motiondb.scene.compilation import compiled
from motiondb.scene.placement import ClipArrays


class ClipGroups(NamedTuple):
    """The entries of a library by terminal and seam class; G groups, K entries.

    Attributes
    ----------
    members (K,) : entries, sorted by group. first (G + 1,) : where each group begins there.
    group (K,) : the group of an entry. seam (G,) : the seam class of a group.
    near (K, 2) : for every entry the first group of its terminal, and behind the last.
    follow (C, C), precede (C, C) : exp(-seam cost / T); of class a before b, and transposed.
    """

    members: IntArray
    first: IntArray
    group: IntArray
    seam: IntArray
    near: IntArray
    follow: FloatArray
    precede: FloatArray


def clip_groups(library: ClipArrays, smooth: float, temperature: float) -> ClipGroups:
    """The groups of a library.

    Parameters
    ----------
    smooth : w_2, what a seam's mismatch is divided by.
    temperature : T of the chain that will draw.
    """
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
    follow = np.exp(-np.asarray(library.seams) / (smooth * temperature))
    seam = groups[:, 1].astype(np.int64)
    return ClipGroups(members, first, group, seam, near, follow, np.ascontiguousarray(follow.T))


@compiled
def uniform_entry(library: ClipArrays, entry: int, u: float) -> int:
    """Any entry of the same terminal; ``u`` in [0, 1)."""
    clip = library.clips[entry]
    return int(clip.first + int(u * (clip.last - clip.first)))


@compiled
def variant_entry(groups: ClipGroups, entry: int, u: float) -> int:
    """Any entry of the same group; ``u`` in [0, 1)."""
    g = groups.group[entry]
    first = groups.first[g]
    return int(groups.members[first + int(u * (groups.first[g + 1] - first))])


@compiled
def _seam_weight(groups: ClipGroups, g: int, before: int, after: int) -> float:
    """exp(-(its seams) / T) of a group between two classes; -1 where nothing stands there."""
    c = groups.seam[g]
    weight = 1.0
    if before >= 0:
        weight = groups.follow[before, c]
    if after >= 0:
        weight *= groups.precede[after, c]
    return max(weight, 1e-200)


@compiled
def smooth_entry(
    groups: ClipGroups, entry: int, before: int, after: int, u: float
) -> tuple[int, float]:
    """An entry of the same terminal by its seams, and log(q(old) / q(new)).

    Parameters
    ----------
    before, after : seam classes of the neighbours' entries, -1 where there is none.
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
    """A clip for every action of a stretch by the seams, and the logarithm of its probability.

    Parameters
    ----------
    ranges : array (actions, 2), the entries of each action's terminal.
    before, after : seam classes of the neighbours, -1 where there is none.
    entries : array (actions,), where given nothing is drawn: their probability is told.
    """
    n = len(ranges)
    if n == 0:
        return np.zeros(0, np.int64), 0.0
    spans = [groups.near[first] for first in ranges[:, 0]]
    classes = [groups.seam[a:b] for a, b in spans]
    sizes = [np.diff(groups.first[a : b + 1]).astype(float) for a, b in spans]
    rest = _ends(groups.precede, after, classes[-1])
    rests = [rest]
    for k in range(n - 2, -1, -1):
        steps = groups.follow[classes[k][:, None], classes[k + 1]]
        rest = steps @ (sizes[k + 1] * rest)
        rest = rest / rest.max()
        rests.append(rest)
    rests.reverse()
    found, log_probability = np.zeros(n, np.int64), 0.0
    ahead = _ends(groups.follow, before, classes[0])
    for k in range(n):
        weights = ahead * rests[k]  # of one entry of each group
        sums = np.cumsum(sizes[k] * weights)
        if entries is not None:
            found[k] = entries[k]
            g = int(groups.group[entries[k]]) - int(spans[k][0])
        elif rng is not None:
            u = rng.random() * sums[-1]
            g = min(int(np.searchsorted(sums, u, "right")), len(sums) - 1)
            first = int(groups.first[spans[k][0] + g])
            found[k] = groups.members[first + int(rng.integers(int(sizes[k][g])))]
        log_probability += float(np.log(weights[g] / sums[-1]))
        if k + 1 < n:
            ahead = _ends(groups.follow, int(classes[k][g]), classes[k + 1])
    return found, log_probability


def _ends(table: FloatArray, neighbour: int, classes: IntArray) -> FloatArray:
    """exp(-seam / T) of a neighbour and every group; 1 where there is no neighbour."""
    if neighbour < 0:
        return np.ones(len(classes))
    return np.maximum(table[neighbour, classes], 1e-200)
