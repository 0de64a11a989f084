"""Left-to-right Gaussian HMMs, all symbols at once: score, fit, align.

A symbol starts in state 0. It stays in state k with probability a_k and moves to state k + 1 with
probability 1 - a_k; from the last state that move leaves the symbol. There are no other moves. A
frame o_t of state k is Gaussian with diagonal covariance.

Two likelihoods of a segment o_1 ... o_T:

- free end (``exit=False``, for recognition): the symbol has not been left before o_T, and the path
  may end in any state. This is what hmmlearn's ``score`` computes
  (:meth:`motiondb.records.MotionSymbols.to_hmmlearn`).
- ``exit=True``: the path ends in the last state and leaves it after o_T. These are the densities of
  whole passages: they add up over symbols in series. Zero for segments of fewer frames than states.

Fitting is Baum-Welch, from equal parts of segments as first states. The E step computes, for state
k of a symbol and summed over its segments, the expected number of frames (gamma), of stays and of
leaves; the M step is

    a_k = stays / (stays + leaves),   m_k = sum gamma o / sum gamma,
    v_k = max(sum gamma (o - m_k)^2 / sum gamma, floor).

Each of these is the maximum of its own term, so that with a floor on v_k and bounds on a_k the
constrained maximum is the clipped one, and the likelihood cannot fall. A transition of probability
0 has no expected count and stays 0.

Frames are one array for all captures, segments are intervals [start, end) in it; they may overlap.
The results do not depend on the workers that compute them, nor on their number.

Source: Rabiner, A tutorial on hidden Markov models, 1989; left to right as in paper A.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from motiondb.records import Float32Array, FloatArray, IntArray, MotionSymbols
from motiondb.symbols import hmm_kernels as kernels
from motiondb.symbols.hmm_jobs import (
    FIT_SECONDS,
    SCORE_SECONDS,
    Block,
    check_assignment,
    check_segments,
    frame_blocks,
    shares,
)
from motiondb.symbols.hmm_kernels import check_symbols, log_density_blocks, log_symbols, weigh
from motiondb.symbols.spread import Frames, Part, Spread, as_spread
from motiondb.workers import is_array, runs, trusted

SELF_LOOP_BOUNDS = (0.01, 0.999)
"""EM keeps self-loops in these bounds, so that a state can be left and can be repeated. By hand."""


def initialise(
    frames: FloatArray | Float32Array,
    starts: IntArray,
    ends: IntArray,
    assignment: IntArray,
    n_states: IntArray,
    variance_floor: ArrayLike,
) -> MotionSymbols:
    """First symbols: segments cut into equal parts, one a state; unvisited ones take the mean."""
    n_states = np.asarray(n_states, dtype=np.int64)
    n_symbols, n_padded = len(n_states), int(n_states.max())
    floor = np.broadcast_to(np.asarray(variance_floor, dtype=np.float64), (frames.shape[1],))
    lengths = ends - starts
    place, number = _flatten(starts, ends)
    segment_states = n_states[assignment][number]
    within = place - starts[number]
    part = np.where(
        lengths[number] >= segment_states, within * segment_states // lengths[number], within
    )
    everything = _moments(frames, place, np.zeros(len(place), dtype=np.int64), 1)
    whole = _moments(frames, place, assignment[number], n_symbols)
    parts = _moments(frames, place, assignment[number] * n_padded + part, n_symbols * n_padded)
    shape = (n_symbols, n_padded, frames.shape[1])
    count = parts[0].reshape(shape[:2])
    chosen = []
    for all_of, symbol, state in zip(everything[1:], whole[1:], parts[1:]):
        fallback = np.where(whole[0][:, None] > 0, symbol, all_of)[:, None, :]
        chosen.append(np.where(count[..., None] > 0, state.reshape(shape), fallback))
    visits = np.maximum(np.bincount(assignment, minlength=n_symbols), 1)[:, None]
    loops = np.clip(1.0 - visits / np.maximum(count, visits), 0.1, SELF_LOOP_BOUNDS[1])
    real = np.arange(n_padded) < n_states[:, None]
    return MotionSymbols(
        n_states,
        np.where(real, loops, 0.0),
        np.where(real[..., None], chosen[0], 0.0),
        np.where(real[..., None], np.maximum(chosen[1], floor), 1.0),
    )


def fit(
    symbols: MotionSymbols,
    frames: Frames,
    starts: IntArray,
    ends: IntArray,
    assignment: IntArray,
    *,
    n_iterations: int,
    variance_floor: ArrayLike,
    exit_required: bool = True,
) -> tuple[MotionSymbols, FloatArray]:
    """Baum-Welch for all symbols at once, each from the segments assigned to it.

    Gives the symbols, and the log-likelihood before each iteration and after the last.

    Shapes: `frames` (frames, dimensions); `starts`, `ends`, `assignment` (segments,);
    `variance_floor` (dimensions,) or float.

    `exit_required`: Whether every segment is a whole passage, from the first state out of the last,
    as in generation and ``segment_by_symbols``. Segments of fewer frames than states may then end
    in any state. If False, all segments may end in any state, as in hmmlearn.
    """
    steps = _Steps.of(symbols, frames, (starts, ends, assignment), variance_floor, exit_required)
    symbols, trace = steps.take(symbols, n_iterations)
    last = _expectations(symbols, steps.held, steps.segments, exit_required)[1].sum()
    return symbols, np.array([*trace, last])


def refit(
    symbols: MotionSymbols,
    frames: Frames,
    segments: tuple[IntArray, IntArray, IntArray],
    *,
    n_iterations: int,
    variance_floor: ArrayLike,
) -> MotionSymbols:
    """The symbols of :func:`fit`, without the last log-likelihood: that takes an E step more.

    `segments`: Starts, ends and symbols of the segments.
    """
    return _Steps.of(symbols, frames, segments, variance_floor, True).take(symbols, n_iterations)[0]


@dataclass(frozen=True, eq=False)
class _Steps:
    """What all iterations of a fit share."""

    held: Spread
    segments: IntArray  # (segments, 4): start, end, symbol and number, sorted by symbol
    floor: FloatArray  # (dimensions,)
    must_exit: bool

    @classmethod
    def of(
        cls,
        symbols: MotionSymbols,
        frames: Frames,
        segments: tuple[IntArray, IntArray, IntArray],
        variance_floor: ArrayLike,
        must_exit: bool,
    ) -> _Steps:
        """Check symbols, frames and segments."""
        check_symbols(symbols)
        held = as_spread(frames)
        starts, ends = check_segments(symbols, held.frames, *segments[:2])
        floor = np.asarray(variance_floor, dtype=np.float64)
        return cls(
            held,
            check_assignment(symbols, starts, ends, segments[2]),
            np.broadcast_to(floor, (held.frames.shape[1],)),
            must_exit,
        )

    def take(self, symbols: MotionSymbols, n_steps: int) -> tuple[MotionSymbols, list[float]]:
        """The symbols after some iterations, and the log-likelihood before each of them."""
        symbols, trace = _within_bounds(symbols, self.floor), list[float]()
        for _ in range(n_steps):
            expected = _expectations(symbols, self.held, self.segments, self.must_exit)
            statistics, log_likelihoods = expected
            trace.append(float(log_likelihoods.sum()))
            symbols = _maximise(symbols, statistics, self.floor)
        return symbols, trace


def _expectations(
    symbols: MotionSymbols,
    frames: Spread,
    segments: IntArray,
    must_exit: bool,
) -> tuple[kernels.Statistics, FloatArray]:
    """E step by workers; sums run in the order of the segments of a part, then of the parts."""
    statistics = _no_statistics(symbols)
    log_likelihoods = np.zeros(len(segments))
    work = (segments[:, 1] - segments[:, 0]) * symbols.means[0].size
    n_pieces = frames.n_pieces(FIT_SECONDS * int(work.sum()))
    pieces = [
        (part, segments[own][share])
        for part, own in frames.of_parts(segments[:, 0])
        for share in shares(work[own], segments[own, 2], n_pieces)
    ]
    results = trusted(frames.workers, _are_expectations, _expect, pieces, symbols, must_exit)
    for (_, some), (own, likelihoods) in results:
        which = slice(int(some[0, 2]), int(some[-1, 2]) + 1)
        for total, part in zip(statistics, own):
            total[which] += part
        log_likelihoods[some[:, 3]] = likelihoods
    return statistics, log_likelihoods


def _are_expectations(
    found: tuple[kernels.Statistics, FloatArray],
    piece: tuple[Part, IntArray],
    symbols: MotionSymbols,
    _: object,
) -> bool:
    """Whether statistics and likelihoods can be those of some segments."""
    (statistics, likelihoods), segments = found, piece[1]
    n_symbols = int(segments[-1, 2] - segments[0, 2]) + 1
    return is_array(likelihoods, (len(segments),)) and all(
        is_array(each, (n_symbols, *none.shape[1:]))
        for each, none in zip(statistics, _no_statistics(symbols), strict=True)
    )


def _expect(
    piece: tuple[Part, IntArray], symbols: MotionSymbols, must_exit: bool
) -> tuple[kernels.Statistics, FloatArray]:
    """E step of some segments, sorted by symbol: statistics from the first symbol to the last."""
    part, segments = piece
    first, last = int(segments[0, 2]), int(segments[-1, 2]) + 1
    some = MotionSymbols(*(np.asarray(each)[first:last] for each in vars(symbols).values()))
    lengths = segments[:, 1] - segments[:, 0]
    rows = _flatten(segments[:, 0] - part.first, segments[:, 1] - part.first)[0]
    own = np.ascontiguousarray(part.frames[rows], np.float64)
    ends = np.cumsum(lengths)
    places = np.arange(len(segments))
    moved = np.stack([ends - lengths, ends, segments[:, 2] - first, places], axis=1)
    statistics, log_likelihoods = _no_statistics(some), np.zeros(len(segments))
    kernels.accumulate(own, log_symbols(some), must_exit, statistics, log_likelihoods, moved)
    return statistics, log_likelihoods


def _no_statistics(symbols: MotionSymbols) -> kernels.Statistics:
    """Statistics of no segments."""
    return kernels.Statistics(
        *(np.zeros(symbols.self_loops.shape) for _ in range(3)),
        *(np.zeros(symbols.means.shape) for _ in range(2)),
    )


def _maximise(
    symbols: MotionSymbols, statistics: kernels.Statistics, floor: FloatArray
) -> MotionSymbols:
    """M step; states without expected frames keep their parameters."""
    occupancy = statistics.occupancy[..., None]
    visited = occupancy > 1e-8
    weight = np.where(visited, occupancy, 1.0)
    shift = statistics.deviations / weight
    variance = np.maximum(statistics.squares / weight - shift**2, floor)
    moves = statistics.stays + statistics.leaves
    counted = (moves > 1e-8) & (symbols.self_loops > 0) & (symbols.self_loops < 1)
    loops = np.clip(statistics.stays / np.where(moves > 1e-8, moves, 1.0), *SELF_LOOP_BOUNDS)
    return MotionSymbols(
        symbols.n_states,
        np.where(counted, loops, symbols.self_loops),
        np.where(visited, symbols.means + shift, symbols.means),
        np.where(visited, variance, symbols.covars),
    )


def _within_bounds(symbols: MotionSymbols, floor: FloatArray) -> MotionSymbols:
    loops = symbols.self_loops
    free = (loops > 0) & (loops < 1)
    real = np.arange(loops.shape[1]) < symbols.n_states[:, None]
    return MotionSymbols(
        symbols.n_states,
        np.where(free, np.clip(loops, *SELF_LOOP_BOUNDS), loops),
        symbols.means,
        np.where(real[..., None], np.maximum(symbols.covars, floor), symbols.covars),
    )


def _moments(
    frames: FloatArray | Float32Array, place: IntArray, group: IntArray, n_groups: int
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Count (groups,), mean and variance (groups, dimensions) of the frames of every group.

    Shapes: `place`, `group` (n,): numbers of the frames, and the group of each.
    """
    count = np.bincount(group, minlength=n_groups)
    weight = np.maximum(count, 1)
    mean, variance = np.empty((2, n_groups, frames.shape[1]))
    for d in range(frames.shape[1]):  # all columns at once take as much memory as the frames, twice
        column = frames[place, d].astype(np.float64)
        mean[:, d] = np.bincount(group, column, n_groups) / weight
        variance[:, d] = np.bincount(group, (column - mean[group, d]) ** 2, n_groups) / weight
    return count, mean, variance


def _flatten(starts: IntArray, ends: IntArray) -> tuple[IntArray, IntArray]:
    """Frame number and segment number of every frame of every segment, segment after segment."""
    lengths = ends - starts
    number = np.repeat(np.arange(len(starts)), lengths)
    before = np.cumsum(lengths) - lengths
    return np.arange(len(number)) - before[number] + starts[number], number


def score(
    symbols: MotionSymbols,
    frames: Frames,
    starts: IntArray,
    ends: IntArray,
    *,
    exit: bool = False,
) -> Float32Array:
    """Log-likelihood of every segment under every symbol: (segments, symbols)."""
    check_symbols(symbols)
    held = as_spread(frames)
    starts, ends = check_segments(symbols, held.frames, starts, ends)
    scores = np.empty((len(starts), symbols.n_symbols), dtype=np.float32)
    n_pieces = held.n_pieces(SCORE_SECONDS * int((ends - starts).sum()) * symbols.means.size)
    pieces = [
        (part, blocks)
        for part, own in held.of_parts(starts)
        for blocks in runs(list(frame_blocks(starts, ends, own)), n_pieces)
    ]
    results = trusted(held.workers, _are_scores, _score_blocks, pieces, symbols, exit)
    for (_, blocks), some in results:
        scores[_rows_of(blocks)] = some
    return scores


def _rows_of(blocks: Sequence[Block]) -> IntArray:
    """Numbers of the segments of blocks of frames."""
    return np.concatenate([intervals[:, 2] for _, _, intervals in blocks])


def _are_scores(
    found: Float32Array, piece: tuple[Part, Sequence[Block]], symbols: MotionSymbols, _: object
) -> bool:
    """Whether scores can be those of the segments of blocks."""
    return is_array(found, (len(_rows_of(piece[1])), symbols.n_symbols))


def _score_blocks(
    piece: tuple[Part, Sequence[Block]], symbols: MotionSymbols, must_exit: bool
) -> Float32Array:
    """Scores of the segments of some blocks of frames: array (segments, symbols)."""
    part, blocks = piece
    prepared = log_symbols(symbols)
    scores = np.empty((len(_rows_of(blocks)), symbols.n_symbols), dtype=np.float32)
    done = 0
    for low, high, intervals in blocks:
        own = np.column_stack([intervals[:, :2], done + np.arange(len(intervals))])
        frames = part.frames[low - part.first : high - part.first]
        for which, densities in log_density_blocks(symbols, frames):
            kernels.score_block(densities, which, prepared, must_exit, scores, int(which[0]), own)
        done += len(intervals)
    return scores


def rescore(
    symbols: MotionSymbols,
    frames: Frames,
    starts: IntArray,
    ends: IntArray,
    scores: Float32Array,
    n_likely: int,
) -> Float32Array:
    """Score segments again under symbols that changed a little: array (segments, symbols).

    Each segment is scored under the ``n_likely`` symbols that were likeliest; its other scores are
    kept as they were.

    Shapes: `starts`, `ends` (segments,); `scores` (segments, symbols), by the symbols before.
    """
    if symbols.n_symbols <= 2 * n_likely:
        return score(symbols, frames, starts, ends)
    held, fresh = as_spread(frames), scores.copy()
    starts, ends = check_segments(symbols, held.frames, starts, ends)
    segments = np.stack([starts, ends, np.arange(len(starts))], axis=1)
    work = int((ends - starts).sum()) * symbols.means[0].size * n_likely
    n_pieces = held.n_pieces(SCORE_SECONDS * work)
    pieces = (  # made one after another: the places of the largest scores take twice their memory
        (part, segments[some], _likeliest(scores[some], n_likely))
        for part, own in held.of_parts(starts)
        for some in runs(own.tolist(), n_pieces)
    )
    results = trusted(held.workers, _are_rescored, _score_again, pieces, symbols)
    for (_, some, likely), values in results:
        fresh[some[:, 2:], likely] = values
    return fresh


def _likeliest(scores: Float32Array, n_likely: int) -> IntArray:
    """The symbols of the largest scores of every segment, rising: array (segments, n_likely)."""
    return np.sort(np.argpartition(scores, -n_likely, axis=1)[:, -n_likely:], axis=1)


_Rescored: TypeAlias = tuple[Part, IntArray, IntArray]
"""A part, start, end and number of segments in it (n, 3), and symbols of each (n, likely)."""


def _are_rescored(found: Float32Array, piece: _Rescored, _: MotionSymbols) -> bool:
    """Whether values can be scores of segments under the symbols of each."""
    return is_array(found, piece[2].shape)


def _score_again(piece: _Rescored, symbols: MotionSymbols) -> Float32Array:
    """Scores of segments, each under symbols of its own: array (segments, likely)."""
    part, segments, likely = piece
    values = np.empty(likely.shape, dtype=np.float32)
    places = np.ascontiguousarray(segments[:, :2] - part.first)
    kernels.score_again(part.frames, weigh(symbols), log_symbols(symbols), likely, places, values)
    return values


def viterbi(
    symbols: MotionSymbols, s: int, frames: FloatArray | Float32Array, *, exit: bool = False
) -> IntArray:
    """Most probable state of every frame (frames, dimensions) of a segment under symbol s.

    `exit`: Whether the path must end in the last state. A segment of fewer frames than states
    cannot, and then may end anywhere.
    """
    check_symbols(symbols)
    check_segments(symbols, frames, [0], [len(frames)])
    return kernels.best_path(
        np.ascontiguousarray(frames, dtype=np.float64), log_symbols(symbols), s, exit
    )
