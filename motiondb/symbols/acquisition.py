"""Motion symbols without labels: competitive learning with the number chosen by description length.

Each segment is assigned to the left-to-right HMM (the symbol) under which it is most likely, and
every symbol is fitted again to the segments that it won. New symbols are created for segments
that no symbol explains well. Symbols whose parameters cost more than they save are removed. The
objective is the description length of the segments, in nats:

    L = - sum_i log P(o_i | winner(i))        the motion, given its symbols
        + n ln S                              which symbol each of n segments is
        + S K (2 D + 1) / 2 ln(F)             the symbols: means, variances, self-loops

with S symbols of K states in D dimensions and F frames. An update is accepted only if L falls.
Then every capture is segmented again by the best path through the network of all symbols, each
passed from its first state to its last, and the symbols are fitted to the new segments. So the
segments of one symbol begin in the same phase of the movement.

Source: paper A, section 2 (competitive learning of motion symbols); the description length follows
Rissanen (1978).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Annotated

import numpy as np

from motiondb.errors import MotionDBError
from motiondb.records import Float32Array, FloatArray, IntArray, MotionSymbols
from motiondb.records.declared import Within
from motiondb.symbols import description, hmm
from motiondb.symbols.seeding import describe_segments, n_distinct, seed_groups

Progress = Callable[[str, float], None]


AT_LEAST_ONE = Within(1.0, 1e6, "a switch cost and a shortest length of at least 1")


@dataclass(frozen=True)
class RecutSettings:
    """How symbols cut a motion into segments."""

    # Nats that each further symbol costs. Not tuned
    switch_cost: Annotated[float, AT_LEAST_ONE] = 20.0
    # Least length of a segment: 8 feature frames, about half a second
    shortest: Annotated[int, AT_LEAST_ONE] = 8


@dataclass(frozen=True)
class AcquisitionSettings(RecutSettings):
    """Settings of the acquisition; lengths in feature frames, 15 a second.

    The defaults were chosen by hand on the sample data and on CMU captures; no table of
    ``docs/quality.md`` compares other values, except as noted below.
    """

    n_symbols: int | None = None  # Number of symbols. None: the number of least description length
    n_states: int = 6  # States of a symbol. Not tuned
    # Least variance of a state; the variance of all whitened frames is 1. With 0.1 in place of 0.3,
    # and exact removal, planted symbols of synthetic data are recovered
    variance_floor: float = 0.1
    max_symbols: int = 240  # Largest number of symbols. It bounds time and memory
    # Rounds of removing, creating and refitting at most. The search usually ends earlier
    rounds: int = 12
    recuts: int = 3  # Times that the captures are segmented again at most


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

    Shapes: `frames` (frames, dimensions); `bounds` (captures + 1,); `starts`, `ends` (segments,).

    `progress`: Called with the name of the step and the share of it that is done, 0 to 1.
    """
    settings = settings or AcquisitionSettings()
    tell = progress or (lambda _what, _share: None)
    descriptors = describe_segments(frames, starts, ends)
    _check(descriptors, settings)
    floor = np.full(frames.shape[1], settings.variance_floor)
    n_first = settings.n_symbols or int(np.clip(len(starts) // 8, 1, settings.max_symbols))
    arena = _Arena(frames, starts, ends, floor, settings, rng)
    state = _judge(arena, _fit_new(arena, starts, ends, seed_groups(descriptors, n_first, rng)))
    lengths = [state.length]
    state = _compete(arena, state, lengths, tell)
    for number in range(settings.recuts):
        tell("cutting anew", number / settings.recuts)
        recut_arena, judged = _recut(arena, bounds, state)
        if judged.length >= state.length:
            break
        arena, state = recut_arena, judged
        lengths.append(state.length)
    symbols, winners = state.symbols, state.winners
    if settings.n_symbols is None:
        symbols, winners = _drop_idle(symbols, winners)
    return Acquired(symbols, Cutting(arena.starts, arena.ends, winners), tuple(lengths))


def _compete(arena: _Arena, state: _State, lengths: list[float], tell: Progress) -> _State:
    """Remove, create and refit symbols in rounds, while the description length falls."""
    settings = arena.settings
    for number in range(settings.rounds):
        tell("symbols compete", number / settings.rounds)
        before = state.length
        for propose in (_refit,) if settings.n_symbols else (_kill, _thin, _create, _refit):
            candidate = propose(arena, state)
            judged = None if candidate is None else _judge(arena, candidate)
            if judged is not None and judged.length < state.length:
                state = judged
                lengths.append(state.length)
        if before - state.length < 1e-4 * abs(before):
            break
    return state


@dataclass(frozen=True, eq=False)
class _Arena:
    """The constants of the competition: frames, segments, variance floor, settings, rng."""

    frames: Float32Array
    starts: IntArray
    ends: IntArray
    floor: FloatArray
    settings: AcquisitionSettings
    rng: np.random.Generator


@dataclass(frozen=True, eq=False)
class _State:
    """Symbols, the scores of all segments, the winner of each, and the description length."""

    symbols: MotionSymbols
    scores: Float32Array
    winners: IntArray
    length: float


def _judge(arena: _Arena, symbols: MotionSymbols) -> _State:
    scores = hmm.score(symbols, arena.frames, arena.starts, arena.ends)
    winners = np.argmax(scores, axis=1)
    total = float(scores[np.arange(len(scores)), winners].sum(dtype=np.float64))
    length = description.description_length(total, len(scores), symbols, len(arena.frames))
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
    return hmm.fit(
        symbols,
        arena.frames,
        starts,
        ends,
        winners,
        n_iterations=n_iterations,
        variance_floor=arena.floor,
    )[0]


def _refit(arena: _Arena, state: _State) -> MotionSymbols:
    """EM of every symbol on the segments that it won."""
    return _fit(arena, state.symbols, arena.starts, arena.ends, state.winners)


def _kill(arena: _Arena, state: _State) -> MotionSymbols | None:
    """Remove the symbols whose parameters cost more than they save."""
    price = description.prices(state.symbols, len(arena.frames))
    order, gains = description.deaths(state.scores, price)
    return _without(state, order[gains > 0])


def _thin(arena: _Arena, state: _State) -> MotionSymbols | None:
    """Remove the least useful twentieth of the symbols and refit the others.

    Where two symbols share the segments of one movement, each seems useful, because neither is
    fitted to the segments of the other. A twentieth was chosen by hand.
    """
    price = description.prices(state.symbols, len(arena.frames))
    least = max(1, state.symbols.n_symbols // 20)
    left = _without(state, description.deaths(state.scores, price, least)[0])
    if left is None:
        return None
    winners = np.argmax(hmm.score(left, arena.frames, arena.starts, arena.ends), axis=1)
    return _fit(arena, left, arena.starts, arena.ends, winners)


def _without(state: _State, dead: IntArray) -> MotionSymbols | None:
    if len(dead) == 0:
        return None
    return take(state.symbols, np.setdiff1d(np.arange(state.symbols.n_symbols), dead))


def _create(arena: _Arena, state: _State) -> MotionSymbols | None:
    """New symbols for the tenth of the segments of least likelihood per frame.

    One symbol for every six of these segments at most; both shares were chosen by hand.
    """
    room = arena.settings.max_symbols - state.symbols.n_symbols
    per_frame = state.scores.max(axis=1) / (arena.ends - arena.starts)
    worst = np.flatnonzero(per_frame < np.quantile(per_frame, 0.1))
    n_new = min(room, len(worst) // 6)
    if n_new < 1:
        return None
    starts, ends = arena.starts[worst], arena.ends[worst]
    groups = seed_groups(describe_segments(arena.frames, starts, ends), n_new, arena.rng)
    joined = join(state.symbols, _fit_new(arena, starts, ends, groups))
    winners = np.argmax(hmm.score(joined, arena.frames, arena.starts, arena.ends), axis=1)
    return _fit(arena, joined, arena.starts, arena.ends, winners)


def _recut(arena: _Arena, bounds: IntArray, state: _State) -> tuple[_Arena, _State]:
    """Segment every capture again by the symbols, then refit these to the new segments."""
    cutting = recut(arena.frames, bounds, state.symbols, arena.settings)
    fresh = replace(arena, starts=cutting.starts, ends=cutting.ends)
    symbols = _fit(fresh, state.symbols, cutting.starts, cutting.ends, cutting.winners)
    return fresh, _judge(fresh, symbols)


def recut(
    frames: Float32Array, bounds: IntArray, symbols: MotionSymbols, settings: RecutSettings
) -> Cutting:
    """Segment every capture by the symbols: the path of largest likelihood less switch costs.

    Shapes: `frames` (frames, dimensions); `bounds` (captures + 1,).
    """
    starts, ends, winners = [], [], []
    for low, high in pairwise(bounds):
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
