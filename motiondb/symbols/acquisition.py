"""Motion symbols without labels: competitive learning with the number chosen by description length.

Segments compete for left-to-right HMMs: each goes to the symbol that gives it the highest
likelihood, the winners are refitted to what they won. Where no symbol explains segments well, new
ones are created for them; symbols that do not pay for their parameters die. What is minimised is
the description length of the segments, in nats:

    L = - sum_i log P(o_i | winner(i))        the motion, given its symbols
        + n ln S                              which symbol each of n segments is
        + S K (2 D + 1) / 2 ln(F)             the symbols: means, variances, self-loops

with S symbols of K states in D dimensions and F frames. An update is kept only if L does not rise.
Then the symbols cut the captures anew (the best path through all symbols, each passed from its
first state to its last) and are refitted to these segments, so that a symbol's segments begin in
the same phase of the movement.

Source: paper A, section 2 (competitive learning of motion symbols); the description length follows
Rissanen (1978).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from motiondb.errors import MotionDBError
from motiondb.records import Float32Array, FloatArray, IntArray, MotionSymbols
from motiondb.symbols import hmm

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class AcquisitionSettings:
    """What governs the acquisition; lengths in feature frames."""

    n_symbols: int | None = None
    n_states: int = 6
    variance_floor: float = 0.3
    max_symbols: int = 240
    rounds: int = 12
    recuts: int = 3
    switch_cost: float = 20.0
    shortest: int = 8


@dataclass(frozen=True, eq=False)
class Cutting:
    """Segments of all captures as frames of the concatenated features, and who won each."""

    starts: IntArray
    ends: IntArray
    winners: IntArray


@dataclass(frozen=True, eq=False)
class Acquired:
    """Symbols, the final cutting, and L after every accepted update."""

    symbols: MotionSymbols
    cutting: Cutting
    description_lengths: tuple[float, ...] = field(default=())


def acquire(
    frames: Float32Array,
    bounds: IntArray,
    starts: IntArray,
    ends: IntArray,
    rng: np.random.Generator,
    settings: AcquisitionSettings | None = None,
    progress: Progress | None = None,
) -> Acquired:
    """Learn motion symbols from segments that tile the captures.

    Parameters
    ----------
    frames : array (frames, dimensions), whitened features of all captures, one after another.
    bounds : array (captures + 1,), where each capture begins and ends in ``frames``.
    starts, ends : arrays (segments,), first segmentation, in ``frames``.
    rng : for the choice of the first symbols.

    Raises
    ------
    MotionDBError
        when there is no segment, or fewer segments than ``n_symbols``.
    """
    settings = settings or AcquisitionSettings()
    tell = progress or (lambda _what, _share: None)
    _check(starts, settings)
    descriptors = describe_segments(frames, starts, ends)
    n_first = settings.n_symbols or int(np.clip(len(starts) // 8, 1, settings.max_symbols))
    winners = seed_groups(descriptors, n_first, rng)
    symbols = _fit_new(frames, starts, ends, winners, settings)
    symbols, cutting, lengths = _compete(frames, Cutting(starts, ends, winners), symbols, settings, tell)
    for recut_round in range(settings.recuts):
        tell("cutting anew", recut_round / max(settings.recuts, 1))
        symbols, cutting = _recut(frames, bounds, symbols, settings)
        if settings.n_symbols is None:
            symbols, cutting = _drop_idle(symbols, cutting)
    return Acquired(symbols, cutting, tuple(lengths))


def describe_segments(frames: Float32Array, starts: IntArray, ends: IntArray) -> FloatArray:
    """Mean features of every third of a segment: array (segments, 3 * dimensions)."""
    sums = np.concatenate([np.zeros((1, frames.shape[1])), np.cumsum(frames, axis=0, dtype=float)])
    parts = []
    for third in range(3):
        low = starts + (ends - starts) * third // 3
        high = np.maximum(starts + (ends - starts) * (third + 1) // 3, low + 1)
        high = np.minimum(high, len(frames))
        parts.append((sums[high] - sums[low]) / (high - low)[:, None])
    return np.concatenate(parts, axis=1)


def seed_groups(descriptors: FloatArray, n_groups: int, rng: np.random.Generator) -> IntArray:
    """First groups by k-means (k-means++ start): array (segments,), every group non-empty."""
    from sklearn.cluster import KMeans

    distinct = len(np.unique(descriptors.round(9), axis=0))
    n_groups = min(n_groups, distinct)
    if n_groups == 1:
        return np.zeros(len(descriptors), dtype=np.int64)
    seed = int(rng.integers(2**31))
    labels = KMeans(n_groups, n_init=1, max_iter=30, random_state=seed).fit_predict(descriptors)
    return np.unique(labels, return_inverse=True)[1].astype(np.int64)


def description_length(
    log_likelihood: float, n_segments: int, symbols: MotionSymbols, n_frames: int
) -> float:
    """L of the module's docstring, nats.

    >>> s = MotionSymbols(np.array([1]), np.ones((1, 1)), np.zeros((1, 1, 2)), np.ones((1, 1, 2)))
    >>> round(description_length(-10.0, 3, s, 100), 4)  # 10 + 3 ln 1 + 5 / 2 ln 100
    21.5129
    """
    n_dims = symbols.means.shape[2]
    parameters = float(symbols.n_states.sum()) * (2 * n_dims + 1)
    names = n_segments * np.log(symbols.n_symbols)
    return float(-log_likelihood + names + 0.5 * parameters * np.log(max(n_frames, 2)))


def _check(starts: IntArray, settings: AcquisitionSettings) -> None:
    if len(starts) == 0:
        raise MotionDBError("learn: expected at least one segment, found none. Add captures first.")
    if settings.n_symbols is not None and not 1 <= settings.n_symbols <= len(starts):
        raise MotionDBError(
            f"learn: expected a number of symbols from 1 to {len(starts)} (the segments), found "
            f"{settings.n_symbols}. Ask for fewer symbols, or leave the number to motiondb."
        )


def _fit_new(
    frames: Float32Array,
    starts: IntArray,
    ends: IntArray,
    winners: IntArray,
    settings: AcquisitionSettings,
) -> MotionSymbols:
    """Symbols from groups of segments: uniform cut into states, then EM."""
    floor = np.full(frames.shape[1], settings.variance_floor)
    n_states = np.full(int(winners.max()) + 1, settings.n_states, dtype=np.int64)
    symbols = hmm.initialise(frames, starts, ends, winners, n_states, floor)
    return hmm.fit(symbols, frames, starts, ends, winners, n_iterations=3, variance_floor=floor)[0]


def _compete(
    frames: Float32Array,
    cutting: Cutting,
    symbols: MotionSymbols,
    settings: AcquisitionSettings,
    tell: Progress,
) -> tuple[MotionSymbols, Cutting, list[float]]:
    """Rounds of winning, refitting, dying and creating; L never rises on a kept update."""
    starts, ends = cutting.starts, cutting.ends
    floor = np.full(frames.shape[1], settings.variance_floor)
    scores = hmm.score(symbols, frames, starts, ends)
    best, winners = _state(scores)
    lengths = [description_length(best, len(starts), symbols, len(frames))]
    for number in range(settings.rounds):
        tell("symbols compete", number / settings.rounds)
        proposals = [_refit] if settings.n_symbols else [_kill, _create, _refit]
        improved = False
        for propose in proposals:
            candidate = propose(symbols, frames, starts, ends, scores, floor, settings)
            if candidate is None:
                continue
            new_scores = hmm.score(candidate, frames, starts, ends)
            best, new_winners = _state(new_scores)
            length = description_length(best, len(starts), candidate, len(frames))
            if length < lengths[-1]:
                improved = improved or lengths[-1] - length > 1e-4 * abs(lengths[-1])
                symbols, scores, winners = candidate, new_scores, new_winners
                lengths.append(length)
        if not improved:
            break
    return symbols, Cutting(starts, ends, winners), lengths


def _state(scores: Float32Array) -> tuple[float, IntArray]:
    winners = np.argmax(scores, axis=1)
    return float(scores[np.arange(len(scores)), winners].sum(dtype=np.float64)), winners


def _refit(symbols, frames, starts, ends, scores, floor, settings):  # type: ignore[no-untyped-def]
    """One EM step of every symbol on the segments that it won."""
    del settings
    winners = np.argmax(scores, axis=1)
    return hmm.fit(symbols, frames, starts, ends, winners, n_iterations=2, variance_floor=floor)[0]


def _kill(symbols, frames, starts, ends, scores, floor, settings):  # type: ignore[no-untyped-def]
    """Remove the symbols whose segments lose less elsewhere than the symbol's parameters cost.

    Symbols are tried from the cheapest; once one dies, the runners-up of its segments may not die
    in the same round, so that the losses add up as counted.
    """
    del floor, settings, starts, ends
    n_symbols = symbols.n_symbols
    if n_symbols < 2:
        return None
    order = np.argsort(-scores, axis=1)[:, :2]
    rows = np.arange(len(scores))
    margin = (scores[rows, order[:, 0]] - scores[rows, order[:, 1]]).astype(np.float64)
    loss = np.bincount(order[:, 0], weights=margin, minlength=n_symbols)
    price = 0.5 * symbols.n_states * (2 * symbols.means.shape[2] + 1) * np.log(len(frames))
    kept, alive = np.zeros(n_symbols, dtype=bool), np.ones(n_symbols, dtype=bool)
    for s in np.argsort(loss - price):
        if loss[s] >= price[s]:
            break
        if not kept[s]:
            alive[s] = False
            kept[order[order[:, 0] == s, 1]] = True
    if alive.all() or not alive.any():
        return None
    return take(symbols, np.flatnonzero(alive))


def _create(symbols, frames, starts, ends, scores, floor, settings):  # type: ignore[no-untyped-def]
    """New symbols for the segments that are explained worst for their length."""
    room = settings.max_symbols - symbols.n_symbols
    per_frame = scores.max(axis=1) / (ends - starts)
    worst = np.flatnonzero(per_frame < np.quantile(per_frame, 0.1))
    n_new = int(min(room, len(worst) // 6))
    if n_new < 1:
        return None
    groups = seed_groups(
        describe_segments(frames, starts[worst], ends[worst]), n_new, np.random.default_rng(0)
    )
    young = _fit_new(frames, starts[worst], ends[worst], groups, settings)
    joined = join(symbols, young)
    winners = np.argmax(hmm.score(joined, frames, starts, ends), axis=1)
    return hmm.fit(joined, frames, starts, ends, winners, n_iterations=2, variance_floor=floor)[0]


def _recut(
    frames: Float32Array, bounds: IntArray, symbols: MotionSymbols, settings: AcquisitionSettings
) -> tuple[MotionSymbols, Cutting]:
    """Cut every capture by the best path through the symbols, then refit them to what they won."""
    cutting = recut(frames, bounds, symbols, settings)
    floor = np.full(frames.shape[1], settings.variance_floor)
    symbols = hmm.fit(
        symbols,
        frames,
        cutting.starts,
        cutting.ends,
        cutting.winners,
        n_iterations=2,
        variance_floor=floor,
    )[0]
    winners = np.argmax(hmm.score(symbols, frames, cutting.starts, cutting.ends), axis=1)
    return symbols, Cutting(cutting.starts, cutting.ends, winners)


def recut(
    frames: Float32Array, bounds: IntArray, symbols: MotionSymbols, settings: AcquisitionSettings
) -> Cutting:
    """Segments of every capture by the symbols: the path of most likelihood less switch costs."""
    starts, ends, winners = [], [], []
    for low, high in zip(bounds[:-1], bounds[1:]):
        path = hmm.segment_by_symbols(
            symbols,
            frames[low:high],
            switch_cost=settings.switch_cost,
            minimum_duration=settings.shortest,
        )
        starts += [low + a for a, _, _ in path]
        ends += [low + b for _, b, _ in path]
        winners += [s for _, _, s in path]
    return Cutting(*(np.array(column, dtype=np.int64) for column in (starts, ends, winners)))


def _drop_idle(symbols: MotionSymbols, cutting: Cutting) -> tuple[MotionSymbols, Cutting]:
    """Symbols that won nothing leave; the others keep their order."""
    alive = np.unique(cutting.winners)
    number = np.full(symbols.n_symbols, -1)
    number[alive] = np.arange(len(alive))
    return take(symbols, alive), Cutting(cutting.starts, cutting.ends, number[cutting.winners])


def take(symbols: MotionSymbols, which: IntArray) -> MotionSymbols:
    """The chosen symbols, in the order given."""
    return MotionSymbols(
        symbols.n_states[which], symbols.self_loops[which], symbols.means[which], symbols.covars[which]
    )


def join(first: MotionSymbols, second: MotionSymbols) -> MotionSymbols:
    """Two sets of symbols with the same number of padded states, one after the other."""
    return MotionSymbols(
        np.concatenate([first.n_states, second.n_states]),
        np.concatenate([first.self_loops, second.self_loops]),
        np.concatenate([first.means, second.means]),
        np.concatenate([first.covars, second.covars]),
    )
