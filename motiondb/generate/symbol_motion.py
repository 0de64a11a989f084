"""Motion from the symbols of a sentence: the most probable trajectory of their HMMs.

Symbols. Every action is decoded in turn, for its duration. Captions speak of whole captures, so
t(word | symbol) alone cannot tell the jump from the standing before it. It is therefore replaced by
a measure of how clearly a symbol's own segments show the action and nothing else, combined with t.
The number of symbols of an action follows from its duration in captures and the durations of the
symbols that show it.

Clarity: p_r(w) the probability that segment r shows word w; A the requested words. A segment that
shows a kick and a handstand is a worse example of "kick" than one that shows a kick alone, so

    c_r(w) = p_r(w) [prod_{v not in A} (1 - p_r(v))]^h,    w in A.

For h = 1 this is the probability that the word is shown and no other, if words are independent.
They are not: a motion of sitting on a stool shows "stool" too. Hence the exponent h < 1. The
clarity of a symbol is the geometric mean of two means over its segments: over all of them, and over
the few clearest.

Motion. A symbol's HMM sees whitened features, from which there is no way back to rotations. So the
frames of a symbol's segments are divided among its states by the most probable path, and a second
HMM with the same states is fitted to pose vectors (:mod:`motiondb.body.pose_vectors`), from which a
motion can be made. Durations, counts and speeds are not supported.

A generated motion is recognised like a new capture, from its movement alone. Where the words of an
action are not recognised in its part, the motion is made again without the symbol that shows the
action least clearly.

The most probable smooth trajectory of motion symbols in series.

Fine symbols: recognition needs few broad states; a smooth trajectory needs at least eight states a
second. After Viterbi alignment, each state of a symbol is divided into ``SPLIT`` parts of equal
length within every segment of the symbol. Mean, variance and duration of each part are estimated
over these segments, on pose vectors with first and second differences, at 30 frames a second. The
result is again a set of left-to-right HMMs.

Series: a state with self-loop a is left with probability 1 - a, in the last state of symbol k for
the first state of symbol k + 1, so that every row of the transition matrix sums to 1. (Paper A sets
this exit to 1, which gives rows of a larger sum.)

Trajectory: c (frames, D) the static values sought; W stacks them with their time differences

    delta c_t = (c_{t+1} - c_{t-1}) / 2,    delta^2 c_t = c_{t+1} - 2 c_t + c_{t-1}

(ends repeated); mu and U the means and variances of all three along the state sequence. The most
probable c solves W' U^-1 W c = W' U^-1 mu, a banded system for each dimension. Its variance is too
small; ``widen`` raises the variance of each dimension towards that of the states.

Source: Tokuda et al., Speech parameter generation algorithms for HMM-based speech synthesis (2000);
Toda and Tokuda (2007) for the global variance.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from motiondb.body import pose_vectors
from motiondb.body.features import FEATURE_STEP
from motiondb.errors import QueryError
from motiondb.generate.contact import lock_feet
from motiondb.generate.material import Material, SequenceMotion, Takes, gather
from motiondb.language.translation import decoding
from motiondb.learn.learned import Learned
from motiondb.learn.recognition import ChainEnds, decode, recognise
from motiondb.records import MOTION_FPS, Association, FloatArray, IntArray, Motion, MotionSymbols
from motiondb.symbols import hmm

SHORTEST, LONGEST = 2.0, 5.0  # Bounds on the duration of an action, seconds
MOST_SYMBOLS = 4  # Largest number of symbols of one action
CLEAR_WEIGHT = 3.0  # w: weight of the symbol's own segments relative to t
CLEAREST = 3  # Number of clearest segments
UNASKED_SHARE = 0.5  # h
UNSAID = 1e-4  # Bound on t(word | NULL), because the symbols must explain requested actions
ATTEMPTS = 4  # Largest number of attempts until every action is recognised
RECOGNISED_FROM = 0.5  # Smallest mean probability of a recognised word: more probable than not
LEAST_PROBABILITY = 1e-6
"""Probabilities are kept away from 0 and 1 by this much, so that logarithms stay finite."""
MEMBERS = 60  # Largest number of segments per symbol; the most probable ones are used


@dataclass(frozen=True, eq=False)
class SymbolMotion:
    """A motion made from symbols."""

    made: SequenceMotion  # The motion; its lengths are those of the symbols
    symbols: IntArray  # (symbols,): the decoded symbols in their order
    positions: tuple[int, ...]  # Per symbol the number of its action
    decodings: tuple[decoding.Decoding, ...]  # Per action
    captures: frozenset[int]  # Captures from whose segments the HMMs were estimated


def symbol_motion(learned: Learned, takes: Takes, actions: Sequence[Sequence[str]]) -> SymbolMotion:
    """Make a motion from the symbols of actions: the clearest of up to ATTEMPTS attempts."""
    avoided: list[set[int]] = [set() for _ in actions]
    best, best_clarity = None, -np.inf
    for _ in range(ATTEMPTS):
        symbols, positions, decodings = decode_actions(learned, actions, avoided)
        made, captures = _trajectory_motion(learned, takes, symbols)
        probabilities = _frame_probabilities(learned, made.motion)
        clarities, unclear = _check_actions(
            learned, actions, symbols, positions, made.lengths, probabilities
        )
        if best is None or np.mean(clarities) > best_clarity:
            best_clarity = float(np.mean(clarities))
            best = SymbolMotion(made, symbols, tuple(positions), tuple(decodings), captures)
        if not unclear:
            break
        for action, symbol in unclear.items():
            avoided[action].add(symbol)
    assert best is not None
    return best


def decode_actions(
    learned: Learned,
    actions: Sequence[Sequence[str]],
    avoided: Sequence[Collection[int]] = (),
) -> tuple[IntArray, list[int], list[decoding.Decoding]]:
    """Symbols of all actions, the action of every symbol, and the decoding of every action.

    Each decoding starts where the one before it ended, and may begin and end within a movement.

    `avoided`: Per action, the symbols that must not show it. An action that avoids some may follow
    any symbol.
    """
    symbols: list[int] = []
    positions: list[int] = []
    decodings = []
    seconds = typical_seconds(learned, actions)
    for number, action in enumerate(actions):
        clear = symbol_clarity(
            learned.segment_probabilities,
            word_numbers(learned, action),
            learned.segments.symbols,
            learned.symbols.n_symbols,
        )
        banned = list(avoided[number]) if avoided else []
        clear[banned] = 0.0
        association = _shown_association(learned, action, clear)
        length = _count_symbols(learned, clear, seconds[number])
        for n_symbols in dict.fromkeys((length, 1)):  # one symbol, where none ever followed
            decoded = decode(
                learned,
                _said_throughout(action, n_symbols),
                ends=ChainEnds(
                    symbols[-1] if symbols and not banned else None, first=False, last=False
                ),
                length=n_symbols,
                association=association,
            )
            if decoded is not None:
                break
        if decoded is None:
            raise QueryError(
                f"generate: expected symbols for {' '.join(action)!r}, found none that "
                "occur together with these words. Add captures with these words and learn again."
            )
        symbols += decoded.symbols
        positions += [number] * len(decoded.symbols)
        decodings.append(decoded)
    return np.array(symbols), positions, decodings


def typical_seconds(learned: Learned, actions: Sequence[Sequence[str]]) -> list[float]:
    """Durations of actions: medians over captures described with their words, within bounds.

    A capture of several actions gives each an equal share. If no caption of this database holds a
    word of the action, the duration is that of the knowledge it started from.
    """
    described = learned.described
    start = {} if learned.started is None else learned.started.seconds
    if not described and not start:
        raise QueryError(
            "generate: expected captures with words, found none. Write some down (motiondb words "
            "set) and learn again."
        )
    seconds = []
    for action in actions:
        said = [d for d in described if set(action) <= set(d.words)]
        said = said or [d for d in described if set(action) & set(d.words)]
        taught = [start[word] for word in action if word in start]
        if not said and not taught:
            said, taught = list(described), list(start.values())
        if said:
            typical = np.median([(d.end - d.start) / d.n_actions for d in said]) / MOTION_FPS
        else:
            typical = np.median(taught)
        seconds.append(float(np.clip(typical, SHORTEST, LONGEST)))
    return seconds


def word_numbers(learned: Learned, action: Sequence[str]) -> IntArray:
    """Numbers of an action's words, each once."""
    numbers = dict.fromkeys(learned.word_numbers[w] for w in action)
    return np.array(list(numbers), dtype=np.int64)


def _count_symbols(learned: Learned, clear: FloatArray, seconds: float) -> int:
    """Number of symbols that fill a duration, by the durations of those that show the action."""
    table = learned.segments
    count = np.maximum(np.bincount(table.symbols, minlength=len(clear)), 1)
    frames = np.bincount(table.symbols, table.ends - table.starts, minlength=len(clear)) / count
    weights = clear.prod(axis=1) ** 2
    if weights.sum() <= 0.0:
        weights = np.ones(len(clear))
    typical = float(np.average(frames, weights=weights)) / MOTION_FPS
    return int(np.clip(round(seconds / max(typical, 1e-6)), 1, MOST_SYMBOLS))


def _said_throughout(action: Sequence[str], n_symbols: int) -> list[str]:
    """Repeat the words of an action once per symbol, because every symbol is to show it.

    >>> _said_throughout(["turn", "left"], 3)
    ['turn', 'left', 'turn', 'left']
    """
    return list(action) * -(-n_symbols // len(action))


def _shown_association(learned: Learned, action: Sequence[str], clear: FloatArray) -> Association:
    """How well a symbol shows a word of an action, in place of t(word | symbol): (t + w c) c.

    Rows need not sum to 1: a symbol that shows nothing clearly has a small sum.
    """
    asked = word_numbers(learned, action)
    t = learned.smoothed_association.translation.copy()
    t[0] = np.minimum(t[0], UNSAID)
    t[1:, asked] = (t[1:, asked] + CLEAR_WEIGHT * clear) * clear
    return replace(learned.smoothed_association, translation=t)


def log_unasked(probabilities: FloatArray, asked: IntArray) -> FloatArray:
    """sum_{v not in A} log(1 - p_r(v)) of every segment: array (segments,), at most 0.

    `probabilities` (segments, words); `asked`: numbers of the words of A.

    >>> np.exp(log_unasked(np.array([[0.9, 0.5, 0.2]]), np.array([0]))).round(6)
    array([0.4])
    """
    others = np.ones(probabilities.shape[1], dtype=bool)
    others[asked] = False
    return np.asarray(np.log1p(-probabilities[:, others]).sum(axis=1))


def symbol_clarity(
    probabilities: FloatArray,
    asked: IntArray,
    symbols: IntArray,
    n_symbols: int,
    unasked_share: float = UNASKED_SHARE,
) -> FloatArray:
    """Clarity of the requested words in every symbol: array (symbols, requested words), 0 to 1.

    `probabilities` (segments, words); `symbols` (segments,).

    >>> symbol_clarity(np.array([[0.8, 0.5], [0.2, 0.0]]), np.array([0]), np.array([0, 1]), 2, 1.0)
    array([[0.4],
           [0.2]])
    """
    clear = probabilities[:, asked]
    clear = clear * np.exp(unasked_share * log_unasked(probabilities, asked))[:, None]
    answer = np.zeros((n_symbols, len(asked)))
    for symbol in np.unique(symbols):
        rising = np.sort(clear[symbols == symbol], axis=0)
        answer[symbol] = np.sqrt(rising.mean(axis=0) * rising[-CLEAREST:].mean(axis=0))
    return answer


def _trajectory_motion(
    learned: Learned, takes: Takes, sequence: IntArray
) -> tuple[SequenceMotion, frozenset[int]]:
    """Motion along the most probable trajectory of symbols, and the captures it was learned from.

    `sequence` (symbols,).
    """
    used, numbers = np.unique(sequence, return_inverse=True)
    members = [_members(learned, int(s)) for s in used]
    captures = frozenset(int(learned.segments.capture_ids[i]) for rows in members for i in rows)
    material = gather(takes, captures)
    hmms = _fit_hmms(learned, takes, material, used, members)
    joined = join_series(hmms, numbers)
    states = np.repeat(np.arange(len(joined.self_loops)), expected_durations(joined))
    means, covars = joined.means[states], joined.covars[states]
    values = most_probable(means, covars)
    n_dims = values.shape[1]
    values = widen(values, means[:, :n_dims], covars[:, :n_dims])
    leg_length = float(np.median([m.leg_length for m in material.motions.values()]))
    motion = pose_vectors.from_vectors(values, material.means, leg_length=leg_length)
    lengths = np.bincount(joined.positions[states], minlength=len(sequence))
    n_frames = motion.n_frames
    made = SequenceMotion(
        lock_feet(motion),
        np.full(n_frames, -1),
        np.zeros(n_frames),
        ("trajectory",) * n_frames,
        tuple(lengths.tolist()),
    )
    return made, captures


def _fit_hmms(
    learned: Learned, takes: Takes, material: Material, used: IntArray, members: Sequence[IntArray]
) -> MotionSymbols:
    """HMMs on pose vectors, one per symbol used."""
    table = learned.segments
    segments, states = [], []
    for symbol, rows in zip(used, members):
        of_symbol, paths = [], []
        for row in rows:
            capture, start, end = (
                int(column[row]) for column in (table.capture_ids, table.starts, table.ends)
            )
            whitened = takes.frames.whitened(capture)
            features = whitened[start // FEATURE_STEP : -(-end // FEATURE_STEP)]
            path = hmm.viterbi(learned.symbols, int(symbol), features)
            of_symbol.append(material.vectors[capture][start:end])
            paths.append(np.repeat(path, FEATURE_STEP)[: end - start])
        segments.append(of_symbol)
        states.append(paths)
    return fine_symbols(segments, states, int(learned.symbols.n_states.max()))


def _members(learned: Learned, symbol: int) -> IntArray:
    """Rows of the most probable segments of a symbol."""
    rows = np.flatnonzero(learned.segments.symbols == symbol)
    if len(rows) == 0:
        raise QueryError(
            f"symbol {symbol}: expected segments in the database, found none. Learn again."
        )
    order = np.argsort(-learned.segments.log_likelihoods[rows], kind="stable")
    return np.sort(rows[order[:MEMBERS]])


def _frame_probabilities(learned: Learned, motion: Motion) -> FloatArray:
    """Probability of every word at every frame, 30 a second: array (frames, words)."""
    seen = recognise(learned, motion)
    probabilities = learned.word_map.probabilities(seen.window_vectors())
    frames = np.repeat(
        np.repeat(probabilities, seen.ends - seen.starts, axis=0), FEATURE_STEP, axis=0
    )
    which = np.minimum(np.arange(motion.n_frames), len(frames) - 1)
    return np.clip(frames[which], LEAST_PROBABILITY, 1.0 - LEAST_PROBABILITY)


def _check_actions(
    learned: Learned,
    actions: Sequence[Sequence[str]],
    symbols: IntArray,
    positions: Sequence[int],
    lengths: Sequence[int],
    probabilities: FloatArray,
) -> tuple[list[float], Mapping[int, int]]:
    """log c of every action, and the least clear symbol of those that are not recognised."""
    bounds = np.minimum(np.cumsum([0, *lengths]), len(probabilities) - 1)
    clarities, unclear = [], {}
    for number, action in enumerate(actions):
        asked = word_numbers(learned, action)
        places = [k for k, position in enumerate(positions) if position == number]
        part = probabilities[bounds[places[0]] : bounds[places[-1] + 1] + 1]
        clarities.append(log_clarity(part, asked))
        if (part[:, asked].mean(axis=0) < RECOGNISED_FROM).any():
            parts = [probabilities[bounds[k] : bounds[k + 1] + 1] for k in places]
            least = int(np.argmin([log_clarity(one, asked) for one in parts]))
            unclear[number] = int(symbols[places[least]])
    return clarities, unclear


def log_clarity(probabilities: FloatArray, asked: IntArray) -> float:
    """log c of a part of a motion, mean over its frames and the words asked for.

    `probabilities` (frames, words); `asked` (n,).
    """
    said = np.log(probabilities[:, asked]).mean(axis=1)
    return float(np.mean(said + UNASKED_SHARE * log_unasked(probabilities, asked)))


SPLIT = 3  # Number of parts of a recognition state
VARIANCE_FLOOR = 1e-3  # Least variance of a state, as a share of the overall variance


@dataclass(frozen=True, eq=False)
class Series:
    """The states of joined HMMs in their order, N in all."""

    self_loops: FloatArray  # (N,): probability to stay in a state
    means: FloatArray  # (N, dimensions)
    covars: FloatArray  # (N, dimensions): variances
    positions: IntArray  # (N,): position in the sequence of the symbol that each state belongs to


def join_series(symbols: MotionSymbols, sequence: IntArray) -> Series:
    """Put the HMMs of a symbol sequence in series; `sequence` (length,)."""
    counts = symbols.n_states[sequence]
    picks = [(s, k) for s, n in zip(sequence, counts) for k in range(n)]
    rows, states = np.array(picks).T
    return Series(
        symbols.self_loops[rows, states],
        symbols.means[rows, states],
        symbols.covars[rows, states],
        np.repeat(np.arange(len(sequence)), counts),
    )


def expected_durations(series: Series) -> IntArray:
    """Number of frames of each state: array (N,), the rounded mean 1 / (1 - self-loop), at least 1.

    Rounding errors are carried over to the next state, so the total is correct to one frame.
    """
    mean = 1.0 / np.maximum(1.0 - series.self_loops, 1e-3)
    ends = np.round(np.cumsum(mean)).astype(np.int64)
    return np.maximum(np.diff(ends, prepend=0), 1)


def fine_symbols(
    segments: Sequence[Sequence[FloatArray]], states: Sequence[Sequence[IntArray]], n_states: int
) -> MotionSymbols:
    """Estimate the finer symbols; `segments` each (frames, D); `states` each (frames,)."""
    n_fine = SPLIT * n_states
    everything = np.concatenate([with_deltas(v) for group in segments for v in group])
    floor = np.maximum(VARIANCE_FLOOR * everything.var(axis=0), 1e-10)
    means = np.empty((len(segments), n_fine, everything.shape[1]))
    covars = np.empty_like(means)
    loops = np.empty((len(segments), n_fine))
    for s, (group, paths) in enumerate(zip(segments, states)):
        values = np.concatenate([with_deltas(v) for v in group])
        fine = np.concatenate([fine_states(path, n_states) for path in paths])
        count = np.bincount(fine, minlength=n_fine).astype(float)
        for k in range(n_fine):
            inside = values[fine == k] if count[k] else values[[_nearest(fine, k)]]
            means[s, k] = inside.mean(axis=0)
            covars[s, k] = np.maximum(inside.var(axis=0), floor)
        duration = np.maximum(count / len(group), 1.0)
        loops[s] = 1.0 - 1.0 / duration
    return MotionSymbols(np.full(len(segments), n_fine), loops, means, covars)


def fine_states(path: IntArray, n_states: int) -> IntArray:
    """Divide every visit of a state in a path (frames,) into SPLIT equal parts.

    A skipped state has no frames.

    >>> fine_states(np.array([0, 0, 0, 1, 1, 1, 1]), 2)
    array([0, 1, 2, 3, 3, 4, 5])
    """
    fine = np.empty(len(path), dtype=np.int64)
    for state in range(n_states):
        inside = np.flatnonzero(path == state)
        fine[inside] = SPLIT * state + np.arange(len(inside)) * SPLIT // max(len(inside), 1)
    return fine


def _nearest(fine: IntArray, k: int) -> int:
    return int(np.argmin(np.abs(fine - k)))


def with_deltas(values: FloatArray) -> FloatArray:
    """Append first and second differences: array (frames, 3 D), from `values` (frames, D)."""
    padded = np.concatenate([values[:1], values, values[-1:]])
    delta = (padded[2:] - padded[:-2]) / 2.0
    delta2 = padded[2:] - 2.0 * padded[1:-1] + padded[:-2]
    return np.concatenate([values, delta, delta2], axis=1)


def most_probable(means: FloatArray, covars: FloatArray) -> FloatArray:
    """Most probable trajectory c: array (frames, D), from `means`, `covars` (frames, 3 D)."""
    from scipy.linalg import solveh_banded

    n_frames, n_dims = len(means), means.shape[1] // 3
    result = np.empty((n_frames, n_dims))
    for d in range(n_dims):
        columns = [d, d + n_dims, d + 2 * n_dims]
        band, right = _normal_equations(means[:, columns], 1.0 / covars[:, columns])
        result[:, d] = solveh_banded(band, right, lower=True)
    return result


def _normal_equations(mean: FloatArray, precision: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Lower band (3, frames) of W' P W and the vector W' P mu for one dimension."""
    n = len(mean)
    band = np.zeros((3, n))
    right = np.zeros(n)
    windows = (((0, 1.0),), ((-1, -0.5), (1, 0.5)), ((-1, 1.0), (0, -2.0), (1, 1.0)))
    time = np.arange(n)
    for w, window in enumerate(windows):
        weighted = precision[:, w]
        for step, factor in window:
            column = np.clip(time + step, 0, n - 1)
            np.add.at(right, column, factor * weighted * mean[:, w])
            for other_step, other in window:
                row = np.clip(time + other_step, 0, n - 1)
                lag = row - column
                keep = lag >= 0
                np.add.at(band, (lag[keep], column[keep]), (factor * other * weighted)[keep])
    return band, right


def widen(
    trajectory: FloatArray, means: FloatArray, covars: FloatArray, strength: float = 0.8
) -> FloatArray:
    """Scale every dimension about its mean, by 1 to 1.6, towards the variance of the states.

    All arrays (frames, D).
    """
    centre = trajectory.mean(axis=0)
    wanted = means.var(axis=0) + covars.mean(axis=0)
    variance = np.maximum(trajectory.var(axis=0), 1e-12)
    factor = np.clip(np.sqrt(wanted / variance), 1.0, 1.6)
    return centre + (trajectory - centre) * (1.0 + strength * (factor - 1.0))
