"""The frames at which an action begins and ends, by evidence for each frame.

Segments last about a second, and captions of whole takes also cover the standing before and after
an action, so that the interval of a short action needs evidence at the resolution of frames. It is
a linear map, learned from the same places of words as :mod:`motiondb.meaning.place_map`:

    y_tw    probability that word w is shown at frame t,
    c_t     cues of the frame: soft levels of its whitened features and of their change,
    z_tw    (c_t . u_w) / sd_w + floor_w, by ridge regression from c_t to y_tw.

First y of a frame is that of its segment. Frames that look as frames do where the word is not
listed (standing before a jump) then have a low predicted y, and y is lowered there in each further
round: with r the predicted y by the map without this take, and p its 98th percentile over the
frames of the take where the word may be shown,

    y <- (y of the segment) s(SHARPNESS (r / p - 1/2)),

s the logistic function. An activity that fills its take keeps its y, because r is near p
throughout. ``floor_w`` is the mean of y over sd_w, so that z = 0 where y is predicted to be 0.

An interval is trimmed, or extended, to the frames at which z, averaged over ``AVERAGED`` frames on
both sides, reaches half of its largest value in the interval: from the first of them to the last,
so that the repeats of an action stay together.

**Actions in order.** With e_k(t) the averaged evidence of action k, relative to its largest value
in the take, the intervals I_1, I_2, ... are one for every action, each behind the one before, and
maximise

    sum over k of the sum over t in I_k of (e_k(t) - 1/2),

by a dynamic program. The order is *seen* if every action reaches half of its largest evidence
inside its interval. An action that the take does not show at all is not told by this.
``docs/measured/quality.md``, "Order by frames", has how often right and wrong orders are seen.

Source: multiple-instance learning with soft labels; half of the peak is the rule by which intervals
of segments grow (:mod:`motiondb.meaning.word_evidence`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.body.features import FEATURE_FPS
from motiondb.meaning.extents import best_spans
from motiondb.meaning.place_map import spreads_of
from motiondb.meaning.regression import residuals_without
from motiondb.meaning.score_vectors import averaged_rows, soft_levels
from motiondb.records import Float32Array, FloatArray

REACH = 3  # Feature frames (0.2 s) before and after a frame between which change is measured
RIDGE = 150.0
"""Ridge of the regression on standardised cues. On short actions marked in real captures, a third
and three times as much separated the frames inside from those outside as well."""
ROUNDS = 5
"""Number of fits of the map. With 8, the boundaries of marked actions were .17 s off in the median,
with 5 .21 s, which is within chance."""
SHARPNESS = 6.0
"""Slope of the logistic function. With 12, the boundaries of marked actions were .19 s off in
the median in place of .21, which is within chance."""
MOST = 20.0  # Bound on z relative to its peak; larger values would overflow and make no difference
AVERAGED = 3
"""Feature frames (0.2 s) before and after a frame over which z is averaged. In earlier variants of
the rule for y, boundaries of marked actions were as good with 2 and 4, and worse with 6."""
MOST_FRAMES, RARE = 160_000, 20
"""Frames (3 hours) of the takes that the map is fitted to, at most, and takes of a word up to which
all of them take part. Of more hours, the other takes are chosen at even distances."""
LEAST_SPREAD = 0.05
"""Share of the mean standard deviation that is added to that of each cue, so that cues that hardly
vary do not count."""
LEAST_SHOWN = 0.05
FAINT = 0.2
"""Least y at which a word may be shown in a take, and the share of its largest y from which a frame
counts."""
HALF = 0.5  # Share of the largest evidence that must be reached at the ends of an interval


@dataclass(frozen=True, eq=False)
class EdgeMap:
    """Linear map from cues of frames to evidence that words are shown."""

    centre: FloatArray  # (cues,): weighted mean of the cues
    spread: FloatArray  # (cues,): standard deviation of the cues
    weights: FloatArray  # (cues, words): slopes u_w / sd_w
    floors: FloatArray  # (words,): ``floor_w`` of the module's docstring

    def evidence(self, frames: Float32Array | FloatArray, words: Sequence[int]) -> FloatArray:
        """Mean evidence for some words at every frame of a take: array (frames,).

        Shapes: `frames` (frames, D).
        """
        return self.of_cues(frame_cues(frames), words)

    def of_cues(self, cues: FloatArray, words: Sequence[int]) -> FloatArray:
        """As :meth:`evidence`, from the cues of the frames: array (frames, cues)."""
        slopes = self.weights[:, list(words)].mean(axis=1) / self.spread
        return np.asarray(cues @ slopes + (self.floors[list(words)].mean() - self.centre @ slopes))


@dataclass(frozen=True, eq=False)
class FrameTake:
    """One take whose listed words have places."""

    frames: Float32Array  # (frames, D): whitened features, 15 a second
    words: tuple[int, ...]  # Numbers of the listed words
    shown: FloatArray  # (frames, listed words): y of the segment of each frame


def frame_cues(frames: Float32Array | FloatArray) -> FloatArray:
    """Soft levels of the features of a take and of their change: array (frames, 10 D).

    Features are averaged over three frames first. At the ends of the take change is measured up to
    its first and last frame.

    Shapes: `frames` (frames, D).
    """
    smooth = averaged_rows(np.asarray(frames, dtype=np.float64), 1)
    now, last = np.arange(len(smooth)), len(smooth) - 1
    change = smooth[np.minimum(now + REACH, last)] - smooth[np.maximum(now - REACH, 0)]
    return np.concatenate([soft_levels(smooth), soft_levels(change)], axis=1)


def fit_edge_map(takes: Sequence[FrameTake], n_words: int) -> EdgeMap:
    """Fit the map.

    A frame weighs one over the square root of its take's seconds, as in the map of places. Cues
    are computed anew in every pass, so that memory does not grow with the takes.
    """
    takes = _enough(takes)
    regression = _Regression(takes, n_words)
    shown = [take.shown for take in takes]
    mean, slopes = regression.mean(shown, n_words), regression.inverse @ regression.cross
    for _ in range(ROUNDS - 1):
        cross = np.zeros_like(regression.cross)
        for n, take in enumerate(takes):
            words, cues = list(take.words), regression.cues(n)
            predicted = regression.left_out(n, cues, shown[n] - mean[words], slopes[:, words])
            shown[n] = _sharpened(take.shown, predicted + mean[words])
            cross[:, words] += regression.products(n, cues, shown[n])
        mean, slopes = regression.mean(shown, n_words), regression.inverse @ cross
    spreads = spreads_of(mean)
    return EdgeMap(regression.centre, regression.spread, slopes / spreads, mean / spreads)


def _enough(takes: Sequence[FrameTake]) -> Sequence[FrameTake]:
    """The takes of rare words, and as many of the others as make up ``MOST_FRAMES``."""
    lengths = np.array([len(take.frames) for take in takes])
    if lengths.sum() <= MOST_FRAMES:
        return takes
    count = Counter(word for take in takes for word in take.words)
    is_rare = np.array([any(count[word] <= RARE for word in take.words) for take in takes])
    share = max(MOST_FRAMES - lengths[is_rare].sum(), 0) / max(lengths[~is_rare].sum(), 1)
    reached = np.floor(share * np.cumsum(np.where(is_rare, 0, lengths)) / lengths.mean())
    chosen = is_rare | (np.diff(reached, prepend=0.0) > 0.0)
    return [take for take, is_chosen in zip(takes, chosen) if is_chosen]


def refine_interval(
    evidence: FloatArray, interval: tuple[int, int], limits: tuple[int, int]
) -> tuple[int, int]:
    """Frames [a, b) from the first to the last at which the evidence reaches half of its peak.

    Shapes: `evidence` (frames,).

    >>> evidence = np.concatenate([np.zeros(40), np.ones(40), np.zeros(40)])
    >>> refine_interval(evidence, (20, 110), (0, 120))
    (40, 80)
    """
    return around_half(averaged(evidence), interval, limits)


def around_half(
    smooth: FloatArray, interval: tuple[int, int], limits: tuple[int, int]
) -> tuple[int, int]:
    """As :func:`refine_interval`, of evidence that is averaged already."""
    low, high = interval
    threshold = HALF * float(smooth[low:high].max())
    if threshold <= 0.0:
        return interval
    inside = low + np.flatnonzero(smooth[low:high] >= threshold)
    first, last = int(inside[0]), int(inside[-1])
    while first > limits[0] and smooth[first - 1] >= threshold:
        first -= 1
    while last + 1 < limits[1] and smooth[last + 1] >= threshold:
        last += 1
    return first, last + 1


class _Regression:
    """Sums of the regression that all rounds share: they depend on cues and weights only."""

    def __init__(self, takes: Sequence[FrameTake], n_words: int) -> None:
        self.takes = takes
        n_frames = np.array([len(take.frames) for take in takes])
        self.weights = np.sqrt(FEATURE_FPS / n_frames)
        self.total = float(self.weights @ n_frames)
        sums = np.array([frame_cues(take.frames).sum(axis=0) for take in takes])
        self.centre: FloatArray = np.asarray(self.weights @ sums / self.total)
        self.spread: FloatArray = np.ones(len(self.centre))
        gram, self.cross = np.zeros((len(self.centre),) * 2), np.zeros((len(self.centre), n_words))
        for n, take in enumerate(takes):
            cues = self.cues(n)
            gram += cues.T @ cues
            self.cross[:, list(take.words)] += self.products(n, cues, take.shown)
        deviation = np.sqrt(np.diag(gram) / self.total)
        self.spread = np.asarray(deviation + LEAST_SPREAD * deviation.mean() + 1e-9)
        self.cross /= self.spread[:, None]  # with y of the segments
        gram /= np.outer(self.spread, self.spread)
        self.gram: FloatArray = gram + RIDGE * np.eye(len(gram))
        self.inverse: FloatArray = np.asarray(np.linalg.inv(self.gram))

    def cues(self, n: int) -> FloatArray:
        """Standardised cues of one take, times the root of the weight: array (frames, cues)."""
        cues = (frame_cues(self.takes[n].frames) - self.centre) / self.spread
        return np.asarray(np.sqrt(self.weights[n]) * cues)

    def mean(self, shown: Sequence[FloatArray], n_words: int) -> FloatArray:
        """Weighted mean of y over all frames: array (words,)."""
        mean = np.zeros(n_words)
        for take, weight, y in zip(self.takes, self.weights, shown):
            mean[list(take.words)] += weight * y.sum(axis=0)
        return mean / self.total

    def products(self, n: int, cues: FloatArray, y: FloatArray) -> FloatArray:
        """Products of cues and y of a take: (cues, listed words). Centred cues need no centred y.

        Their sum over the takes, by the inverse, gives the slopes of the regression.
        """
        return np.asarray(np.sqrt(self.weights[n]) * (cues.T @ y))

    def left_out(self, n: int, cues: FloatArray, y: FloatArray, slopes: FloatArray) -> FloatArray:
        """Prediction (frames, listed words) for a take without this take, up to a constant.

        Shapes: `cues` (frames, cues); `y` (frames, listed words); `slopes` (cues, listed words).
        """
        root = np.sqrt(self.weights[n])
        residuals = root * y - cues @ slopes
        return y - residuals_without(cues, self.gram, self.inverse, residuals) / root


def _sharpened(segment: FloatArray, predicted: FloatArray) -> FloatArray:
    """New y of a take from y of its segments and the predicted y: array (frames, words)."""
    sharpened = np.zeros_like(segment)
    for word in range(segment.shape[1]):
        y, z = segment[:, word], predicted[:, word]
        if y.max() < LEAST_SHOWN:
            continue
        peak = max(_high(z[y > FAINT * y.max()]), 1e-3)
        share = np.clip(z / peak, -MOST, MOST)
        sharpened[:, word] = y / (1.0 + np.exp(-SHARPNESS * (share - HALF)))
    return sharpened


def _high(values: FloatArray) -> float:
    """The 98th percentile, as ``np.quantile`` computes it, which takes ten times as long."""
    ordered = np.sort(values)
    place = 0.98 * (len(ordered) - 1)
    below, above = ordered[int(place)], ordered[min(int(place) + 1, len(ordered) - 1)]
    return float(below + (place - int(place)) * (above - below))


def averaged(evidence: FloatArray) -> FloatArray:
    """Evidence averaged over ``AVERAGED`` frames on both sides: array (..., frames) as given."""
    return averaged_rows(evidence.T, AVERAGED).T


SHORTEST = 3  # Least length of an interval, in feature frames (0.2 s)


@dataclass(frozen=True)
class FrameOrder:
    """Where a take shows some actions in order, and whether it does."""

    # Frames [a, b) of every action; empty where nothing is seen of one
    spans: tuple[tuple[int, int], ...]
    is_seen: bool  # Whether each reaches half of its largest evidence of the take there


def lay_in_order(evidence: FloatArray, room: tuple[int, int]) -> FrameOrder | None:
    """The intervals of actions in order; None if the room is too short.

    Shapes: `evidence` (actions, frames). `room`: Frames [a, b) in which the intervals lie.

    >>> run, stand = np.repeat([[1.0, 0.0], [0.0, 1.0]], 10, axis=1)
    >>> lay_in_order(np.stack([run, stand]), (0, 20))
    FrameOrder(spans=((0, 10), (10, 20)), is_seen=True)
    >>> lay_in_order(np.stack([run, stand, run]), (0, 20)).is_seen
    False
    """
    low, high = room
    peaks = evidence.max(axis=1, initial=0.0)
    if high - low < SHORTEST * len(evidence):
        return None
    if not (peaks > 0.0).all():
        return FrameOrder((), False)
    share = evidence[:, low:high] / peaks[:, None]
    spans = best_spans(share - HALF, SHORTEST)
    seen = all(share[k, a:b].max() >= HALF for k, (a, b) in enumerate(spans))
    return FrameOrder(tuple((low + a, low + b) for a, b in spans), seen)
