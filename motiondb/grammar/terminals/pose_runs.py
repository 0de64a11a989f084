"""Terminals of about half a second: runs of poses of one cluster.

Poses with their velocities (:mod:`.distances`) are clustered by k-means. A take is then cut into
runs, each of one cluster and at least ``shortest`` frames, so that

    C = sum over frames t of |x_t - c_k(t)|^2 + price * number of runs

is least, which dynamic programming finds exactly. The price is found by bisection, so that runs
last the wanted seconds in the mean. No run crosses the end of a take, and neighbours have different
terminals. A take that was not clustered is cut by the same clusters and price.

Length and number are chosen by how well pairs of terminals foresee held-out takes
(:func:`choose_clusters`). Orders with equal neighbours are no shuffles there: runs never have any,
so they would count as foreseen without knowledge of the movement.

Sources: S. P. Lloyd, "Least squares quantization in PCM", IEEE Transactions on Information Theory
28 (1982), for k-means; P. F. Felzenszwalb and D. P. Huttenlocher, "Distance transforms of sampled
functions" (2012), for the minimum over earlier cuts that is carried along.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.grammar.foresight import (
    ABOVE,
    FEWEST_WINDOWS,
    Pairs,
    String,
    shuffles_of,
    windows_of,
)
from motiondb.grammar.kernels import maker
from motiondb.grammar.terminals.distances import Poses, make_poses
from motiondb.grammar.terminals.terminals import REPETITION_WEIGHT, Terminals, as_terminals
from motiondb.grammar.terminals.tuning import Grouping
from motiondb.records import MOTION_FPS, Float32Array, FloatArray, IntArray, Motion

PoseValues = FloatArray | Float32Array

NUMBERS = (8, 12, 16, 24)
"""Numbers of terminals that are tried."""
SECONDS = (0.5, 0.65, 0.8)
"""Mean lengths of runs that are tried: punches last 0.5 s, steps of dances and basketball 0.7 s."""
SHORTEST = 8  # Smallest number of frames of a run
PARTS = 5  # Most parts of the takes of which each is held out once
_HALVINGS = 14  # Bisection steps of the price
_STARTS = 4  # Starts of k-means; more change few clusters


@dataclass(frozen=True, eq=False)
class Clusters:
    """Clusters of poses, and the price of a run."""

    centres: FloatArray  # (K, dimensions), in the unit of the poses
    price: float  # Metres squared times frames
    shortest: int = SHORTEST

    def cut(self, values: PoseValues) -> tuple[IntArray, IntArray]:
        """Cut the poses of a take: first frame and cluster of each run, arrays (runs,)."""
        return _runs(_costs(values, self.centres), self.price, self.shortest)

    def string(self, values: PoseValues) -> String:
        """Return the poses of a take as numbers of clusters, as texts."""
        return tuple(map(str, self.cut(values)[1].tolist()))


def find_clusters(
    takes: Sequence[PoseValues], number: int, seconds: float, seed: int, shortest: int = SHORTEST
) -> Clusters:
    """Cluster the poses of takes, arrays (frames, dimensions), for runs of a mean length."""
    from sklearn.cluster import KMeans
    from threadpoolctl import threadpool_limits

    poses = np.concatenate(list(takes))[::2]  # neighbours are alike: 15 frames a second suffice
    if len(np.unique(poses, axis=0)) < number:
        raise GrammarError(
            f"terminals: expected takes with at least {number} different poses, found fewer."
            " Ask for fewer terminals, or add captures."
        )
    means = KMeans(number, n_init=_STARTS, random_state=seed)
    with threadpool_limits(1):  # sums of several threads differ in their last bits
        centres = means.fit(poses).cluster_centers_
    costs = [_costs(values, centres) for values in takes]
    wanted = sum(map(len, takes)) / MOTION_FPS / seconds
    low, high = 1e-4, 1e4
    for _ in range(_HALVINGS):
        price = float(np.sqrt(low * high))
        count = sum(len(_runs(cost, price, shortest)[0]) for cost in costs)
        low, high = (price, high) if count > wanted else (low, price)
    return Clusters(centres.astype(np.float64), high, shortest)


def _costs(values: PoseValues, centres: FloatArray) -> FloatArray:
    """Return the squared distances of poses from centres: array (frames, K)."""
    squares = (values**2).sum(axis=1)[:, None] + (centres**2).sum(axis=1)
    return np.maximum(squares - 2.0 * values @ centres.T, 0.0)


def _runs(costs: FloatArray, price: float, shortest: int) -> tuple[IntArray, IntArray]:
    """Return first frames and clusters of the runs of least cost; a short take is one run."""
    if len(costs) < 2 * shortest:
        return np.zeros(1, np.int64), np.array([int(np.argmin(costs.sum(axis=0)))])
    starts, labels = _best_runs(costs.astype(np.float64), price, shortest)
    end, firsts, kinds = len(costs), [], []
    while end > 0:
        firsts.append(int(starts[end]))
        kinds.append(int(labels[end]))
        end = firsts[-1]
    return np.array(firsts[::-1]), np.array(kinds[::-1])


@maker
def _best_runs(costs: FloatArray, price: float, shortest: int) -> tuple[IntArray, IntArray]:
    """Return start and cluster of the last run of the best cut up to each frame; -1 is none.

    ``least[k]`` is the least cost of the cuts before an open run of cluster k, minus the cost of k
    up to there: what k costs from there on is added when the run ends.
    """
    n_frames, n_kinds = costs.shape
    best = np.full(n_frames + 1, np.inf)
    best[0] = 0.0
    starts, labels = np.full(n_frames + 1, -1), np.full(n_frames + 1, -1)
    sums = np.zeros((n_frames + 1, n_kinds))
    for t in range(n_frames):
        sums[t + 1] = sums[t] + costs[t]
    least, begun = np.full(n_kinds, np.inf), np.full(n_kinds, -1)
    for end in range(shortest, n_frames + 1):
        start = end - shortest
        for k in range(n_kinds):
            opened = best[start] - sums[start, k] + price
            if labels[start] != k and opened < least[k]:
                least[k], begun[k] = opened, start
            if least[k] + sums[end, k] < best[end]:
                best[end] = least[k] + sums[end, k]
                starts[end], labels[end] = begun[k], k
    return starts, labels


def runs_as_terminals(poses: Poses, clusters: Clusters) -> Terminals:
    """Cut the poses of takes into runs; clusters without a run are no terminals."""
    cuts, labels, medoids = [], [], []
    for low, high in pairwise(poses.bounds.tolist()):
        firsts, kinds = clusters.cut(poses.values[low:high])
        cuts.append(firsts + low)
        labels.append(kinds)
    ends = np.append(np.concatenate(cuts), poses.n_frames)
    used, numbers = np.unique(np.concatenate(labels), return_inverse=True)
    for k, cluster in enumerate(used.tolist()):  # the medoid is nearest to the centre in the mean
        members = np.flatnonzero(numbers == k)
        gaps = [
            _costs(poses.values[ends[n] : ends[n + 1]], clusters.centres[[cluster]]).mean()
            for n in members.tolist()
        ]
        medoids.append(int(members[int(np.argmin(gaps))]))
    return as_terminals(
        poses, Grouping(ends, numbers.astype(np.int64), np.array(medoids)), REPETITION_WEIGHT
    )


def find_pose_runs(
    takes: Sequence[Motion],
    rng: np.random.Generator,
    progress: Callable[[int, int], None] | None = None,
) -> Terminals | None:
    """Find the pose runs of takes that foresee best; None where too few say which these are."""
    poses = make_poses(takes)
    values = [poses.values[low:high] for low, high in pairwise(poses.bounds.tolist())]
    try:
        clusters, tried = choose_clusters(values, rng, progress=progress)
    except GrammarError:  # too few different poses, as of somebody who stands still
        return None
    if max(one.windows for one in tried) < FEWEST_WINDOWS:
        return None
    return runs_as_terminals(poses, clusters)


@dataclass(frozen=True)
class Choice:
    """How well a number and a length foresee held-out takes."""

    number: int
    seconds: float
    foreseen: float  # Share of windows above 95 % of their shuffles without equal neighbours
    windows: int
    bits: float  # Bits of a second under pairs, of the held-out takes: the second judge


def choose_clusters(
    takes: Sequence[PoseValues],
    rng: np.random.Generator,
    *,
    numbers: Sequence[int] = NUMBERS,
    seconds: Sequence[float] = SECONDS,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[Clusters, list[Choice]]:
    """Return the clusters of the number and length that foresee best, and all that were tried.

    Of choices whose foresight is within one standard error of the best, the one of fewest bits is
    taken. Fewer than :data:`PARTS` takes are divided, so that each part may be held out.
    """
    seed, parts = int(rng.integers(2**31 - 1)), divided(takes, rng)
    tried = []
    for number in numbers:
        for length in seconds:
            tried.append(_judge(parts, number, length, seed))
            if progress:
                progress(len(tried), len(numbers) * len(seconds))
    best = max(tried, key=lambda one: one.foreseen)
    error = np.sqrt(best.foreseen * (1.0 - best.foreseen) / max(best.windows, 1))
    near = [one for one in tried if one.windows and one.foreseen >= best.foreseen - error]
    chosen = min(near or tried[:1], key=lambda one: one.bits)
    return find_clusters(takes, chosen.number, chosen.seconds, seed), tried


def divided(takes: Sequence[PoseValues], rng: np.random.Generator) -> list[list[PoseValues]]:
    """Divide takes at random into parts of whole takes; the longest are cut where they are few."""
    pieces = list(takes)
    while len(pieces) < PARTS:
        longest = max(range(len(pieces)), key=lambda n: len(pieces[n]))
        whole = pieces.pop(longest)
        pieces[longest:longest] = [whole[: len(whole) // 2], whole[len(whole) // 2 :]]
    order = rng.permutation(len(pieces))
    return [[pieces[n] for n in part] for part in np.array_split(order, PARTS)]


def _judge(parts: Sequence[Sequence[PoseValues]], number: int, length: float, seed: int) -> Choice:
    """Cluster and count pairs without each part in turn, and judge the windows of that part."""
    foreseen: list[bool] = []
    bits = n_frames = 0.0
    for held in parts:
        training = [take for part in parts if part is not held for take in part]
        try:
            clusters = find_clusters(training, number, length, seed)
        except GrammarError:  # too few poses for so many clusters
            return Choice(number, length, 0.0, 0, np.inf)
        names = [str(k) for k in range(number)]
        pairs = Pairs([clusters.string(take) for take in training], names)
        for take in held:
            string = clusters.string(take)
            chances = [pairs.chance(b, a) for a, b in pairwise((None, *string)) if b is not None]
            bits -= float(np.log2(chances).sum())
            n_frames += len(take)
            foreseen += [
                seen for w in windows_of(string) if (seen := _is_foreseen(pairs, w)) is not None
            ]
    return Choice(
        number,
        length,
        float(np.mean(foreseen or [False])),
        len(foreseen),
        bits / n_frames * MOTION_FPS,
    )


def _is_foreseen(pairs: Pairs, window: String) -> bool | None:
    """Whether a window is above 95 % of its shuffles without equal neighbours; None: has none."""
    shuffles = [s for s in shuffles_of(window) if all(a != b for a, b in pairwise(s))]
    if not shuffles:
        return None

    def log_chance(string: String) -> float:
        return float(sum(np.log(pairs.chance(b, a)) for a, b in pairwise((None, *string)) if b))

    own = log_chance(window)
    return bool(np.mean([log_chance(s) < own - 1e-9 for s in shuffles]) > ABOVE)
