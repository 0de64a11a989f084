"""Activities of a long take: segments of seconds, grouped without labels.

An activity lasts seconds and repeats poses, so that a single frame does not show it. The context
x_t of frame t is the mean and the standard deviation of the features over 2.6 s, on the principal
axes of the take's own contexts. The standard deviation has the larger weight: a bend to the left
and a bend to the right share it. Activities z_t are the labels of least cost

    sum_t |x_t - centre of z_t|^2 + switch * (number of changes),    runs of at least ``shortest``,

found by segmental k-means: given the centres, dynamic programming finds the cheapest z exactly;
given z, the centres are means. The best of several starts is kept. Contexts of 2.6 s blur the
changes, so these are located again: every activity is modelled by a mixture of Gaussians over
contexts of a fifth of a second, and z is replaced by the best path through all
mixtures, again with runs of at least ``shortest``, until it stays or the rounds end. All of this is
repeated, and the z of largest likelihood under its mixtures is returned.

A mixture of an activity with the frames G: k-means, started from frames far apart, splits G into
parts. Part p has the weight w_p = its share of G, the mean m_p, and the variance v_p plus a share
of the variance of the whole take, so that a part without movement keeps a finite density. The
surprise of a frame is -log sum_p w_p N(x_t; m_p, v_p), without the constant (D / 2) log 2 pi.

The number of activities n, where it is not given, minimises the description length

    -log P(x | mixtures, z) + price * n * (values of a mixture / 2) ln T,

which is Schwarz's criterion where ``price`` is 1. The likelihood is that of the mixtures, not of
the centres: the centres of walking ahead and of walking round a corner differ as much as those of
walking and jumping, although the two walks share most of their poses.

Source: Rabiner, Wilpon, Juang, A segmental k-means training procedure (1986); Truong, Oudre,
Vayatis (2020) for the cost of change points; Schwarz (1978).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numba import njit
from numpy.typing import NDArray

from motiondb.records import Float32Array, FloatArray, IntArray
from motiondb.symbols.segmentation import context

ROUNDS = 10  # Rounds of k-means at most. Chosen by hand; it usually ends earlier


def surprise(
    values: FloatArray,
    inside: NDArray[np.bool_],
    rng: np.random.Generator,
    n_parts: int,
    floor: float,
) -> FloatArray:
    """-log density (frames,), nats, under a mixture of some frames with a floor of variance."""
    fitted = np.ascontiguousarray(values[inside])
    centres = fitted[far_apart(fitted, min(n_parts, len(fitted)), rng)]
    least = floor * values.var(axis=0) + 1e-9
    return np.asarray(_surprise(np.ascontiguousarray(values), fitted, centres, least))


def far_apart(values: FloatArray, n: int, rng: np.random.Generator) -> list[int]:
    """Numbers of n frames that are far from one another, drawn as k-means++ does."""
    chosen = [int(rng.integers(len(values)))]
    distance = np.sum((values - values[chosen[0]]) ** 2, axis=1)
    while len(chosen) < n:
        total = distance.sum()
        shares = distance / total if total > 0 else np.full(len(values), 1.0 / len(values))
        chosen.append(int(rng.choice(len(values), p=shares)))
        distance = np.minimum(distance, np.sum((values - values[chosen[-1]]) ** 2, axis=1))
    return chosen


@njit(cache=True)
def _assign(fitted: FloatArray, centres: FloatArray) -> IntArray:
    """Nearest centre of every frame: array (frames,)."""
    nearest = np.zeros(len(fitted), np.int64)
    for t in range(len(fitted)):
        best = 1e300
        for p in range(len(centres)):
            distance = np.sum((fitted[t] - centres[p]) ** 2)
            if distance < best:
                best, nearest[t] = distance, p
    return nearest


@njit(cache=True)
def _partition(fitted: FloatArray, centres: FloatArray) -> IntArray:
    """k-means: the part of every frame; ``centres`` are moved in place."""
    n_parts, n_dims = centres.shape
    nearest = _assign(fitted, centres)
    count = np.zeros(n_parts)
    for _ in range(ROUNDS):
        sums = np.zeros((n_parts, n_dims))
        count[:] = 0.0
        for t in range(len(fitted)):
            count[nearest[t]] += 1.0
            sums[nearest[t]] += fitted[t]
        for p in range(n_parts):
            if count[p] > 0.0:
                centres[p] = sums[p] / count[p]
        assigned = _assign(fitted, centres)
        if (assigned == nearest).all():
            break
        nearest = assigned
    return nearest


@njit(cache=True)
def _surprise(
    values: FloatArray, fitted: FloatArray, centres: FloatArray, least: FloatArray
) -> FloatArray:
    """Negative log-likelihood of ``values`` under the mixture of ``fitted``: array (frames,)."""
    n_parts, n_dims = centres.shape
    nearest = _partition(fitted, centres)
    means, variances = np.zeros((n_parts, n_dims)), np.zeros((n_parts, n_dims))
    count = np.zeros(n_parts)
    for t in range(len(fitted)):
        count[nearest[t]] += 1.0
        means[nearest[t]] += fitted[t]
    for p in range(n_parts):
        means[p] /= max(count[p], 1.0)
    for t in range(len(fitted)):
        variances[nearest[t]] += (fitted[t] - means[nearest[t]]) ** 2
    heights = np.full(n_parts, -1e300)
    for p in range(n_parts):
        variances[p] = variances[p] / max(count[p], 1.0) + least
        if count[p] > 0.0:
            heights[p] = np.log(count[p] / len(fitted)) - 0.5 * np.sum(np.log(variances[p]))
    answer = np.empty(len(values))
    logs = np.empty(n_parts)
    for t in range(len(values)):
        for p in range(n_parts):
            logs[p] = heights[p] - 0.5 * np.sum((values[t] - means[p]) ** 2 / variances[p])
        highest = logs.max()
        answer[t] = -highest - np.log(np.sum(np.exp(logs - highest)))
    return answer


PATIENCE = 3
"""The search ends after so many numbers in a row that do not shorten the description. By hand."""


@dataclass(frozen=True)
class ActivitySettings:
    """Settings of the grouping; lengths in feature frames, 15 a second.

    The values were chosen by hand with the four long CMU takes in view that
    ``docs/measured/quality.md``
    measures ("Segmentation without labels"): no other takes with true parts are available.
    """

    window: int = 39  # Length of a context: 39 frames, 2.6 s
    spread_weight: float = 1.5  # Weight of the standard deviations beside the means
    n_axes: int = 16  # Principal axes that are kept
    shortest: int = 30  # Least length of a run: 30 frames, 2 s
    switch: float = 8.0  # Cost of a change, in mean squared distances from the mean
    starts: int = 4  # Starts of segmental k-means
    rounds: int = 15  # Rounds of segmental k-means at most
    attempts: int = 3  # Times that the whole procedure is repeated
    most: int = 10  # Largest number of activities tried where the number is not given
    price: float = 1.0  # Cost of one more activity, as a multiple of that of Schwarz's criterion
    sharp_window: int = 3  # Length of the short contexts: 3 frames, a fifth of a second
    n_parts: int = 6  # Components of an activity's mixture at most
    # Share of the take's variance that is added to the variance of every component
    floor: float = 0.1
    resegmentations: int = 6  # Times that the changes are located again at most


def find_activities(
    features: FloatArray | Float32Array,
    rng: np.random.Generator,
    n_activities: int | None = None,
    settings: ActivitySettings | None = None,
) -> list[tuple[int, int, int]]:
    """Group one capture into activities; `features` (frames, 130)."""
    settings = settings or ActivitySettings()
    n_frames = len(features)
    if n_frames == 0:
        return []
    most = min(n_activities or settings.most, n_frames // settings.shortest)
    values = np.asarray(features, dtype=np.float64)
    blurred = view(values, settings.window, settings.spread_weight, settings.n_axes)
    if most < 2 or not blurred.any():
        return [(0, n_frames, 0)]
    sharp = view(values, settings.sharp_window, 1.0, settings.n_axes)
    counts = [most] if n_activities else range(1, most + 1)
    tried: list[tuple[float, IntArray]] = []
    for count in counts:
        labels, cost = _best_of_attempts(blurred, sharp, count, rng, settings)
        tried.append((_description_length(labels, cost, settings), labels))
        if len(tried) - int(np.argmin([length for length, _ in tried])) > PATIENCE:
            break
    return to_runs(min(tried, key=lambda pair: pair[0])[1])


def view(features: FloatArray, window: int, spread_weight: float, n_axes: int) -> FloatArray:
    """Context of every frame on principal axes (frames, n_axes), with a mean square of 1."""
    values = context(features - features.mean(axis=0), window)
    values[:, features.shape[1] :] *= spread_weight
    values -= values.mean(axis=0)
    eigenvalues, axes = np.linalg.eigh(values.T @ values)
    projected = values @ axes[:, np.argsort(-eigenvalues)[:n_axes]]
    size = float(np.sqrt(np.mean(np.sum(projected**2, axis=1))))
    return projected / size if size > 1e-9 else np.zeros_like(projected)


def group(
    values: FloatArray, n_groups: int, rng: np.random.Generator, settings: ActivitySettings
) -> IntArray:
    """Segmental k-means: the label of every frame, array (frames,)."""
    starts = np.array([far_apart(values, n_groups, rng) for _ in range(settings.starts)])
    return _segmental_kmeans(values, starts, settings.switch, settings.shortest, settings.rounds)


def to_runs(labels: IntArray) -> list[tuple[int, int, int]]:
    """Runs of equal labels, numbered by first appearance.

    >>> to_runs(np.array([4, 4, 1, 4]))
    [(0, 2, 0), (2, 3, 1), (3, 4, 0)]
    """
    cuts = [0, *(np.flatnonzero(np.diff(labels)) + 1).tolist(), len(labels)]
    number: dict[int, int] = {}
    return [(a, b, number.setdefault(int(labels[a]), len(number))) for a, b in pairwise(cuts)]


def _description_length(labels: IntArray, cost: float, settings: ActivitySettings) -> float:
    n_values = settings.n_parts * (2 * settings.n_axes + 1) - 1
    one_more = settings.price * 0.5 * n_values * np.log(len(labels))
    return float(cost + one_more * len(np.unique(labels)))


def _best_of_attempts(
    blurred: FloatArray,
    sharp: FloatArray,
    n_activities: int,
    rng: np.random.Generator,
    settings: ActivitySettings,
) -> tuple[IntArray, float]:
    """Labels (frames,) of least negative log-likelihood over all attempts, and that value, nats."""
    if n_activities == 1:
        labels = np.zeros(len(sharp), dtype=np.int64)
        return labels, _total_surprise(sharp, labels, rng, settings)
    attempts = []
    for _ in range(settings.attempts):
        grouped = group(blurred, n_activities, rng, settings)
        labels = _resegment(sharp, grouped, rng, settings)
        attempts.append((labels, _total_surprise(sharp, labels, rng, settings)))
    return min(attempts, key=lambda attempt: attempt[1])


def _resegment(
    values: FloatArray, labels: IntArray, rng: np.random.Generator, settings: ActivitySettings
) -> IntArray:
    """Locate the changes again by mixtures over short contexts; stop before a label is lost."""
    for _ in range(settings.resegmentations):
        costs = np.stack(
            [
                surprise(values, labels == g, rng, settings.n_parts, settings.floor)
                for g in np.unique(labels)
            ],
            axis=1,
        )
        relabelled, _ = _best_runs(costs, 0.0, settings.shortest)
        if len(np.unique(relabelled)) < costs.shape[1]:
            return labels
        labels = relabelled
    return labels


def _total_surprise(
    values: FloatArray, labels: IntArray, rng: np.random.Generator, settings: ActivitySettings
) -> float:
    """-log density of all frames, each under the mixture of its own activity, nats."""
    return sum(
        float(
            surprise(values, labels == g, rng, settings.n_parts, settings.floor)[labels == g].sum()
        )
        for g in np.unique(labels)
    )


@njit(cache=True)
def _segmental_kmeans(
    values: FloatArray, starts: IntArray, switch: float, shortest: int, rounds: int
) -> IntArray:
    """Labels of least cost over all starts; a start is the frames that are the first centres."""
    n_frames, n_dims = values.shape
    n_groups = starts.shape[1]
    least = 1e300
    answer = np.zeros(n_frames, np.int64)
    costs = np.empty((n_frames, n_groups))
    for start in starts:
        centres = values[start].copy()
        labels = np.full(n_frames, -1)
        total = 1e300
        for _ in range(rounds):
            for t in range(n_frames):
                for g in range(n_groups):
                    costs[t, g] = np.sum((values[t] - centres[g]) ** 2)
            relabelled, total = _best_runs(costs, switch, shortest)
            if (relabelled == labels).all():
                break
            labels = relabelled
            count = np.zeros(n_groups)
            sums = np.zeros((n_groups, n_dims))
            for t in range(n_frames):
                count[labels[t]] += 1
                sums[labels[t]] += values[t]
            for g in range(n_groups):
                if count[g] > 0:
                    centres[g] = sums[g] / count[g]
        if total < least:
            least = total
            answer = labels
    return answer


@njit(cache=True)
def _best_runs(costs: FloatArray, switch: float, shortest: int) -> tuple[IntArray, float]:
    """Labels of least cost (frames, labels) in runs of at least ``shortest``, and that cost."""
    n_frames, n_labels = costs.shape
    sums = np.zeros((n_frames + 1, n_labels))
    for t in range(n_frames):
        sums[t + 1] = sums[t] + costs[t]
    inside = np.full((n_frames + 1, n_labels), 1e300)  # least cost, a long run at t
    begun = np.zeros((n_frames + 1, n_labels), np.int64)
    least = np.full(n_frames + 1, 1e300)
    last = np.zeros(n_frames + 1, np.int64)
    least[0] = -switch
    for t in range(shortest, n_frames + 1):
        for g in range(n_labels):
            if inside[t - 1, g] < 1e300:
                inside[t, g] = inside[t - 1, g] + costs[t - 1, g]
                begun[t, g] = begun[t - 1, g]
            if least[t - shortest] < 1e300:
                value = least[t - shortest] + switch + sums[t, g] - sums[t - shortest, g]
                if value < inside[t, g]:
                    inside[t, g], begun[t, g] = value, t - shortest
            if inside[t, g] < least[t]:
                least[t], last[t] = inside[t, g], g
    labels = np.zeros(n_frames, np.int64)
    end = n_frames
    while end > 0:
        start = int(begun[end, last[end]])
        labels[start:end] = last[end]
        end = start
    return labels, float(least[n_frames])
