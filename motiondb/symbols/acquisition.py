"""Motion symbols without labels: competitive learning with the number chosen by description length.

Each segment is assigned to the left-to-right HMM (the symbol) under which it is most likely, and
every symbol is fitted again to the segments that it won. New symbols are created for segments
that no symbol explains well. Symbols whose parameters cost more than they save are removed. The
objective is the description length of the segments, in nats:

    L = - sum_i log P(o_i | winner(i))        the motion, given its symbols
        + n ln S                              which symbol each of n segments is
        + S K (2 D + 1) / 2 ln(F)             the symbols: means, variances, self-loops

with S symbols of K states in D dimensions and F frames. An update is accepted only if L falls.
The first symbols come from k-means on the mean features of each third of a segment, so that the
same poses in another order are described otherwise. In the end every capture is segmented again by
the best path through the network of all symbols, each passed from its first state to its last, and
the symbols are fitted to the new segments. So the segments of one symbol begin in the same phase of
the movement.

Source: paper A, section 2 (competitive learning of motion symbols); Rissanen, Modeling by shortest
data description, 1978; Arthur and Vassilvitskii, k-means++, 2007 (the start of k-means).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from motiondb.errors import MotionDBError
from motiondb.records import Float32Array, FloatArray, IntArray, MotionSymbols
from motiondb.symbols import hmm
from motiondb.symbols.hmm_jobs import CUT_SECONDS
from motiondb.symbols.network import segment_by_symbols
from motiondb.symbols.segmentation import sums_before
from motiondb.symbols.settings import AcquisitionSettings, RecutSettings
from motiondb.symbols.spread import Captures, Frames, Spread, are_segments, as_spread, frames_of
from motiondb.workers import trusted

N_LIKELY = 16
"""Likeliest symbols under which a segment is scored again after a refit; all others keep the score
that they had. By hand. Three seeds on an hour of warped CMU captures (86 symbols) gave the segments
and L of twice to five times as many, two on 3 hours (148 symbols) an L within 2e-4 of theirs; two
seeds differ by 3e-3 of it."""
LEAST_ROUNDS, ROUND_FRAMES = 5, 720_000
"""Rounds of competition that the number of frames does not lower, and what rounds times frames
reach at most: of an hour (60,000 frames) up to 12 rounds. By hand. On an hour of warped CMU
captures, 5 rounds in place of 12 gave an L smaller by 6e-4 and 6e-4 of it, and larger by 2e-4, with
three seeds; on 3 hours larger by 3e-4 and 1.1e-3 with two, which differ by 4e-3."""
Progress = Callable[[str, float], None]


@dataclass(frozen=True, eq=False)
class Cutting:
    """Segments of all captures, and the symbol that each is assigned to."""

    starts: IntArray  # (segments,): first frame of each segment, in the concatenated features
    ends: IntArray  # (segments,): one past the last frame of each segment
    winners: IntArray  # (segments,): the symbol of largest likelihood


@dataclass(frozen=True, eq=False)
class Acquired:
    """Result of the acquisition."""

    symbols: MotionSymbols
    cutting: Cutting  # The final segments and their symbols
    description_lengths: tuple[float, ...] = ()  # L after every accepted update, nats
    # (segments, symbols): log-likelihoods, where the last update scored all of them
    scores: Float32Array | None = None


def acquire(
    frames: Frames,
    bounds: IntArray,
    starts: IntArray,
    ends: IntArray,
    rng: np.random.Generator,
    settings: AcquisitionSettings | None = None,
    progress: Progress | None = None,
) -> Acquired:
    """Learn symbols from segments that tile captures; `progress`: step, and share done."""
    settings = settings or AcquisitionSettings()
    tell = progress or (lambda _what, _share: None)
    held = as_spread(frames)
    descriptors = describe_segments(held.frames, starts, ends)
    _check(descriptors, settings)
    floor = np.full(held.frames.shape[1], settings.variance_floor)
    n_first = settings.n_symbols or int(np.clip(len(starts) // 8, 1, settings.max_symbols))
    arena = _Arena(held, starts, ends, floor, settings, rng)
    state = _judge(arena, _fit_new(arena, starts, ends, seed_groups(descriptors, n_first, rng)))
    lengths = [state.length]
    state, scores = _compete(arena, state, lengths, tell), None
    for number in range(settings.recuts):
        tell("cutting anew", number / settings.recuts)
        recut_arena, judged = _recut(arena, bounds, state)
        if judged.length >= state.length:
            break
        arena, state, scores = recut_arena, judged, judged.scores
        lengths.append(state.length)
    symbols, winners = state.symbols, state.winners
    if settings.n_symbols is None:
        symbols, winners = _drop_idle(symbols, winners)
    if symbols.n_symbols < state.symbols.n_symbols:  # fewer have another centre, and last bits
        scores = None
    return Acquired(symbols, Cutting(arena.starts, arena.ends, winners), tuple(lengths), scores)


def _compete(arena: _Arena, state: _State, lengths: list[float], tell: Progress) -> _State:
    """Remove, create and refit symbols in rounds, while the description length falls."""
    settings = arena.settings
    rounds = min(settings.rounds, max(LEAST_ROUNDS, ROUND_FRAMES // len(arena.frames)))
    for number in range(rounds):
        tell("symbols compete", number / rounds)
        before = state.length
        for propose in (_refit,) if settings.n_symbols else (_kill, _thin, _create, _refit):
            judged = propose(arena, state)
            if judged is not None and judged.length < state.length:
                state = judged
                lengths.append(state.length)
        if before - state.length < 1e-4 * abs(before):
            break
    return state


@dataclass(frozen=True, eq=False)
class _Arena:
    """What stays the same in the competition."""

    held: Spread
    starts: IntArray
    ends: IntArray
    floor: FloatArray
    settings: AcquisitionSettings
    rng: np.random.Generator

    @property
    def frames(self) -> FloatArray | Float32Array:
        """Frames of all captures."""
        return self.held.frames

    def score(self, symbols: MotionSymbols) -> Float32Array:
        """Log-likelihood of every segment under every symbol."""
        return hmm.score(symbols, self.held, self.starts, self.ends)


@dataclass(frozen=True, eq=False)
class _State:
    """Symbols, the scores of all segments, the winner of each, and the description length."""

    symbols: MotionSymbols
    scores: Float32Array
    winners: IntArray
    length: float


def _judge(arena: _Arena, symbols: MotionSymbols, scores: Float32Array | None = None) -> _State:
    """Winners and description length, with the scores of these symbols where they are known."""
    scores = arena.score(symbols) if scores is None else scores
    winners = np.argmax(scores, axis=1)
    total = float(scores[np.arange(len(scores)), winners].sum(dtype=np.float64))
    length = description_length(total, len(scores), symbols, len(arena.frames))
    return _State(symbols, scores, winners, length)


def _check(descriptors: FloatArray, settings: AcquisitionSettings) -> None:
    if len(descriptors) == 0:
        raise MotionDBError("learn: expected at least one segment, found none. Add captures first.")
    if settings.n_symbols is None:
        return
    most = n_distinct(descriptors)
    if not 1 <= settings.n_symbols <= most:
        raise MotionDBError(
            f"learn: expected a number of symbols from 1 to {most} (the segments that differ), "
            f"found {settings.n_symbols}. Ask for fewer symbols, or leave the number to motiondb."
        )


def _fit_new(arena: _Arena, starts: IntArray, ends: IntArray, groups: IntArray) -> MotionSymbols:
    """Symbols from groups of segments: equal parts as first states, then EM."""
    n_states = np.full(int(groups.max()) + 1, arena.settings.n_states, dtype=np.int64)
    symbols = hmm.initialise(arena.frames, starts, ends, groups, n_states, arena.floor)
    return _fit(arena, symbols, starts, ends, groups, 3)


def _fit(
    arena: _Arena,
    symbols: MotionSymbols,
    starts: IntArray,
    ends: IntArray,
    winners: IntArray,
    n_iterations: int = 2,
) -> MotionSymbols:
    return hmm.refit(
        symbols,
        arena.held,
        (starts, ends, winners),
        n_iterations=n_iterations,
        variance_floor=arena.floor,
    )


def _refit(arena: _Arena, state: _State) -> _State:
    """EM of every symbol on the segments that it won."""
    symbols = _fit(arena, state.symbols, arena.starts, arena.ends, state.winners)
    scores = hmm.rescore(symbols, arena.held, arena.starts, arena.ends, state.scores, N_LIKELY)
    return _judge(arena, symbols, scores)


def _kill(arena: _Arena, state: _State) -> _State | None:
    """Remove the symbols whose parameters cost more than they save."""
    price = prices(state.symbols, len(arena.frames))
    order, gains = deaths(state.scores, price)
    return _without(arena, state, order[gains > 0])


def _thin(arena: _Arena, state: _State) -> _State | None:
    """Remove the least useful twentieth (by hand): two symbols of one movement seem useful."""
    price = prices(state.symbols, len(arena.frames))
    least = max(1, state.symbols.n_symbols // 20)
    left = _without(arena, state, deaths(state.scores, price, least)[0])
    return None if left is None else _refit(arena, left)


def _without(arena: _Arena, state: _State, dead: IntArray) -> _State | None:
    """Some symbols fewer; the others keep their scores."""
    if len(dead) == 0:
        return None
    alive = np.setdiff1d(np.arange(state.symbols.n_symbols), dead)
    return _judge(arena, take(state.symbols, alive), state.scores[:, alive])


def _create(arena: _Arena, state: _State) -> _State | None:
    """One new symbol for six of the segments of least likelihood (a tenth); by hand."""
    room = arena.settings.max_symbols - state.symbols.n_symbols
    per_frame = state.scores.max(axis=1) / (arena.ends - arena.starts)
    worst = np.flatnonzero(per_frame < np.quantile(per_frame, 0.1))
    n_new = min(room, len(worst) // 6)
    if n_new < 1:
        return None
    starts, ends = arena.starts[worst], arena.ends[worst]
    groups = seed_groups(describe_segments(arena.frames, starts, ends), n_new, arena.rng)
    new = _fit_new(arena, starts, ends, groups)
    scores = np.concatenate([state.scores, arena.score(new)], axis=1)
    return _refit(arena, _judge(arena, join(state.symbols, new), scores))


def _recut(arena: _Arena, bounds: IntArray, state: _State) -> tuple[_Arena, _State]:
    """Segment every capture again by the symbols, then refit these to the new segments."""
    cutting = recut(arena.held, bounds, state.symbols, arena.settings)
    fresh = replace(arena, starts=cutting.starts, ends=cutting.ends)
    symbols = _fit(fresh, state.symbols, cutting.starts, cutting.ends, cutting.winners)
    return fresh, _judge(fresh, symbols)


def recut(
    frames: Frames,
    bounds: IntArray,
    symbols: MotionSymbols,
    settings: RecutSettings,
) -> Cutting:
    """Segment every capture by the symbols: the path of largest likelihood less switch costs."""
    held = as_spread(frames)
    pieces = held.captures(bounds, CUT_SECONDS * symbols.means.size)
    cost, shortest = settings.switch_cost, settings.shortest
    cuts = trusted(held.workers, _are_cuts, _cut_captures, pieces, symbols, cost, shortest)
    paths = [path for _, path in cuts]
    return Cutting(*np.concatenate(paths, axis=1)) if paths else Cutting(*_NO_PATH)


_NO_PATH = np.zeros((3, 0), dtype=np.int64)


def _are_cuts(path: IntArray, piece: Captures, symbols: MotionSymbols, *_: object) -> bool:
    """Whether segments can be those of captures."""
    starts, ends, winners = path
    are_known = bool(np.isin(winners, np.arange(symbols.n_symbols)).all())
    return are_known and are_segments(np.stack([starts, ends]), piece)


def _cut_captures(
    piece: Captures, symbols: MotionSymbols, switch_cost: float, shortest: int
) -> IntArray:
    """Start, end and symbol of every segment of captures: array (3, n)."""
    parts = [_NO_PATH]
    for low, frames in frames_of(piece):
        path = segment_by_symbols(
            symbols, frames, switch_cost=switch_cost, minimum_duration=shortest
        )
        moved = [(low + a, low + b, s) for a, b, s in path]
        parts.append(np.array(moved, dtype=np.int64).reshape(-1, 3).T)
    return np.ascontiguousarray(np.concatenate(parts, axis=1))


def _drop_idle(symbols: MotionSymbols, winners: IntArray) -> tuple[MotionSymbols, IntArray]:
    """Leave out symbols without segments; the others keep their order."""
    alive, numbered = np.unique(winners, return_inverse=True)
    return take(symbols, alive), numbered.astype(np.int64)


def take(symbols: MotionSymbols, which: IntArray) -> MotionSymbols:
    """The chosen symbols, in the order given."""
    return MotionSymbols(
        symbols.n_states[which],
        symbols.self_loops[which],
        symbols.means[which],
        symbols.covars[which],
    )


def join(first: MotionSymbols, second: MotionSymbols) -> MotionSymbols:
    """Two sets of symbols with the same number of padded states, one after the other."""
    return MotionSymbols(
        np.concatenate([first.n_states, second.n_states]),
        np.concatenate([first.self_loops, second.self_loops]),
        np.concatenate([first.means, second.means]),
        np.concatenate([first.covars, second.covars]),
    )


def prices(symbols: MotionSymbols, n_frames: int) -> FloatArray:
    """Bits of each symbol's means, variances and self-loops, in nats: array (symbols,)."""
    each = 0.5 * (2 * symbols.means.shape[2] + 1) * np.log(max(n_frames, 2))
    return symbols.n_states * each


def description_length(
    log_likelihood: float, n_segments: int, symbols: MotionSymbols, n_frames: int
) -> float:
    """L, nats, given the segments' total log-likelihood under their symbols.

    >>> s = MotionSymbols(np.array([1]), np.ones((1, 1)), np.zeros((1, 1, 2)), np.ones((1, 1, 2)))
    >>> round(description_length(-10.0, 3, s, 100), 4)  # 10 + 3 ln 1 + 5 / 2 ln 100
    21.5129
    """
    names = n_segments * np.log(symbols.n_symbols)
    return float(-log_likelihood + names + prices(symbols, n_frames).sum())


def deaths(
    scores: Float32Array | FloatArray, prices: FloatArray, least: int = 1
) -> tuple[IntArray, FloatArray]:
    """Which symbols to remove, greedily, and how much each removal shortens the description.

    After each removal the loss of likelihood is computed again, so that the gains add up. The
    list ends with the first removal that lengthens the description, but holds at least ``least``
    symbols; one symbol always stays.

    Shapes: `scores` (segments, symbols); `prices` (symbols,); result (removals,).

    >>> scores = np.array([[-10.0, -50.0, -12.0], [-60.0, -10.0, -55.0]])
    >>> order, gains = deaths(scores, np.full(3, 20.0))
    >>> order, gains.round(1)  # 20 + 2 ln 3/2 - 0, then 20 + 2 ln 2 - 40
    (array([2, 0]), array([ 20.8, -18.6]))
    """
    alive, rows = np.arange(scores.shape[1]), np.arange(len(scores))
    order: list[int] = []
    gains: list[float] = []
    two, changed = np.zeros((2, len(scores)), dtype=np.int64), rows
    while len(alive) > 1 and (len(order) < least or gains[-1] > 0):
        for some in np.array_split(changed, 1 + len(changed) // ROWS_AT_ONCE):
            two[:, some] = _two_best(scores, some, alive)
        best, second = scores[rows, two].astype(np.float64)
        loss = np.bincount(two[0], weights=best - second, minlength=scores.shape[1])[alive]
        names = len(rows) * np.log(len(alive) / (len(alive) - 1))
        gain = prices[alive] + names - loss
        weakest = int(np.argmax(gain))
        order.append(int(alive[weakest]))
        gains.append(float(gain[weakest]))
        changed = np.flatnonzero((two == alive[weakest]).any(axis=0))
        alive = np.delete(alive, weakest)
    return np.array(order, dtype=np.int64), np.array(gains)


ROWS_AT_ONCE = 2**14  # Segments whose scores are looked at together: bounds memory


def _two_best(scores: Float32Array | FloatArray, rows: IntArray, alive: IntArray) -> IntArray:
    """The likeliest and the second of some symbols, for some segments: array (2, rows)."""
    some, numbers = scores[np.ix_(rows, alive)], np.arange(len(rows))
    best = np.argmax(some, axis=1)
    some[numbers, best] = -np.inf
    return np.stack([alive[best], alive[np.argmax(some, axis=1)]])


def describe_segments(
    frames: FloatArray | Float32Array, starts: IntArray, ends: IntArray
) -> FloatArray:
    """Mean features of every third of a segment: array (segments, 3 * dimensions)."""
    thirds = np.arange(3)[:, None]
    low = starts + (ends - starts) * thirds // 3
    high = np.maximum(starts + (ends - starts) * (thirds + 1) // 3, low + 1)
    high = np.minimum(high, len(frames))
    places, at = np.unique(np.stack([low, high]), return_inverse=True)
    before, behind = sums_before(frames, places)[at.reshape(2, 3, -1)]
    return np.concatenate((behind - before) / (high - low)[..., None], axis=1)


def seed_groups(descriptors: FloatArray, n_groups: int, rng: np.random.Generator) -> IntArray:
    """First groups of descriptors by k-means: array (segments,), no group empty."""
    from sklearn.cluster import KMeans
    from threadpoolctl import threadpool_limits

    n_groups = min(n_groups, n_distinct(descriptors))
    if n_groups == 1:
        return np.zeros(len(descriptors), dtype=np.int64)
    seed = int(rng.integers(2**31))
    means = KMeans(n_groups, n_init=1, max_iter=30, random_state=seed)
    with threadpool_limits(1):  # sums of several threads differ in their last bits
        labels = means.fit_predict(descriptors)
    return np.unique(labels, return_inverse=True)[1].astype(np.int64)


def n_distinct(descriptors: FloatArray) -> int:
    """Number of descriptors (segments, values) that differ by more than rounding errors.

    >>> n_distinct(np.array([[1.0, 2.0], [1.0, 2.0 + 1e-9], [1.0, 3.0]]))
    2
    """
    return len(np.unique(descriptors.round(6), axis=0))
