"""Segmentation of a long capture by the symbols: the best path through a network of all of them.

Every symbol is entered in its first state and left from its last; then the next one begins. Over
all sequences of symbols s_1 ... s_n and all boundaries,

    sum_i log P(path of s_i, left at its end) - (n - 1) switch_cost

is maximised exactly, with every symbol lasting at least ``minimum_duration`` frames. A token in
state k of symbol s at age d carries its score and the frame in which it entered; all ages from
``minimum_duration`` on share one token. Only the entries of tokens that leave are stored for the
backtrace, so that memory is O(T S) and time O(T S K minimum_duration).

Source: Young, Russell, Thornton, Token passing, Cambridge 1989.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from motiondb.records import Float32Array, FloatArray, IntArray, MotionSymbols
from motiondb.symbols.hmm_jobs import check_segments
from motiondb.symbols.hmm_kernels import (
    BLOCK_VALUES,
    NEVER,
    LogSymbols,
    check_symbols,
    log_density_blocks,
    log_symbols,
    posteriors,
)


def segment_by_symbols(
    symbols: MotionSymbols,
    frames: FloatArray | Float32Array,
    *,
    switch_cost: float = 0.0,
    minimum_duration: int = 1,
) -> list[tuple[int, int, int]]:
    """Decode frames into symbols, each passed from its first state out of its last."""
    check_symbols(symbols)
    check_segments(symbols, frames, [], [])
    n_frames = len(frames)
    if n_frames == 0:
        return []
    if n_frames < max(minimum_duration, int(symbols.n_states.min())):
        return [(0, n_frames, _best_free_end(symbols, frames))]
    return _trace_back(*_pass_tokens(symbols, frames, switch_cost, minimum_duration))


def _pass_tokens(
    symbols: MotionSymbols,
    frames: FloatArray | Float32Array,
    switch_cost: float,
    minimum_duration: int,
) -> tuple[IntArray, IntArray, int]:
    """Entry frame of each leaving token, symbol before the next (frames,), last symbol."""
    n_symbols, n_padded = symbols.self_loops.shape
    n_frames = len(frames)
    n_ages = max(1, minimum_duration if minimum_duration > symbols.n_states.min() else 1)
    tokens = np.full((n_padded, n_ages, n_symbols), NEVER)
    begun = np.zeros((n_padded, n_symbols), dtype=np.int64)
    leaving = np.zeros(n_symbols)
    entered = np.empty((n_frames, n_symbols), dtype=np.int64)
    before = np.empty(n_frames, dtype=np.int64)
    prepared = log_symbols(symbols)
    entry, step = 0.0, max(1, BLOCK_VALUES // (n_symbols * n_padded))
    for low in range(0, n_frames, step):
        blocks = [block for _, block in log_density_blocks(symbols, frames[low : low + step])]
        densities = blocks[0] if len(blocks) == 1 else np.concatenate(blocks, axis=2)
        state, records = (tokens, begun, leaving), (entered, before)
        entry = _advance(densities, low, prepared, (switch_cost, entry), state, records)
    return entered, before, int(np.argmax(leaving))


@njit(cache=True, nogil=True)
def _advance(
    densities: Float32Array,
    low: int,
    symbols: LogSymbols,
    costs: tuple[float, float],
    state: tuple[FloatArray, IntArray, FloatArray],
    records: tuple[IntArray, IntArray],
) -> float:
    """Pass the tokens through a block of frames; ``state`` and ``records`` are changed in place.

    `costs`: That of a switch, and the score with which symbols are entered at the first frame.
    Gives the latter for the frame after the block.
    """
    tokens, begun, leaving = state
    entered, before = records
    switch_cost, entry = costs
    n_symbols = len(symbols.n_states)
    stay, onward = _moves(symbols)
    for number in range(len(densities)):
        t = low + number
        for k in range(len(tokens) - 1, -1, -1):
            _advance_state(tokens, begun, (stay, onward), densities[number, k], (k, t, entry))
        for s in range(n_symbols):
            last = symbols.n_states[s] - 1
            leaving[s] = tokens[last, -1, s] + symbols.log_leave[s, last]
            entered[t, s] = begun[last, s]
        best = np.argmax(leaving)
        before[t] = best
        entry = max(leaving[best] - switch_cost, NEVER)
    return entry


@njit(cache=True, nogil=True)
def _moves(symbols: LogSymbols) -> tuple[FloatArray, FloatArray]:
    """Log probabilities to stay, and to move to the next state of the symbol: (states, symbols)."""
    n_symbols, n_padded = symbols.log_stay.shape
    stay, onward = np.empty((n_padded, n_symbols)), np.full((n_padded, n_symbols), NEVER)
    for s in range(n_symbols):
        for k in range(n_padded):
            stay[k, s] = symbols.log_stay[s, k]
            if k + 1 < symbols.n_states[s]:
                onward[k, s] = symbols.log_leave[s, k]
    return stay, onward


@njit(cache=True, nogil=True, error_model="numpy")
def _advance_state(
    tokens: FloatArray,
    begun: IntArray,
    moves: tuple[FloatArray, FloatArray],
    densities: Float32Array,
    at: tuple[int, int, float],
) -> None:
    """One frame of one state of all symbols; the state before it is still that of the last frame.

    The last age stands for all from ``minimum_duration`` on. A token cannot be in state k before
    age k. `at`: the state, the frame, and the score with which symbols are entered.
    """
    k, t, entry = at
    stay, onward = moves
    old, n_symbols = tokens.shape[1] - 1, tokens.shape[2]
    here, there, loop, move = tokens[k], tokens[k - 1], stay[k], onward[k - 1]
    if k == 0:  # is entered, and not moved to
        there, move = np.full_like(here, NEVER), np.full_like(loop, NEVER)
    grown = np.full_like(loop, entry if k == 0 else NEVER)
    if old > 0:
        for s in range(n_symbols):
            grown[s] = max(here[old - 1, s] + loop[s], there[old - 1, s] + move[s])
    _oldest(
        here[old], there[old], (loop, move, grown, densities), (begun[k], begun[k - 1], t - old)
    )
    for age in range(old - 1, max(k, 1) - 1, -1):
        new, younger, moving = here[age], here[age - 1], there[age - 1]
        for s in range(n_symbols):
            value = max(younger[s] + loop[s], moving[s] + move[s])
            new[s] = max(value + densities[s], NEVER)
    if old > 0 and k == 0:
        for s in range(n_symbols):
            here[0, s] = max(entry + densities[s], NEVER)


@njit(cache=True, nogil=True, error_model="numpy")
def _oldest(
    here: FloatArray,
    there: FloatArray,
    scores: tuple[FloatArray, FloatArray, FloatArray, Float32Array],
    begun: tuple[IntArray, IntArray, int],
) -> None:
    """The tokens of the last age: those that stay, that move on, and that have grown old enough."""
    loop, move, grown, densities = scores
    since, since_there, now = begun
    for s in range(len(here)):  # without branches: the processor guesses half of these wrong
        when, moved_when = since[s], since_there[s]
        best, moved = here[s] + loop[s], there[s] + move[s]
        when = moved_when if moved > best else when
        best = moved if moved > best else best
        when = now if grown[s] > best else when
        best = grown[s] if grown[s] > best else best
        here[s], since[s] = max(best + densities[s], NEVER), when


def _trace_back(entered: IntArray, before: IntArray, last: int) -> list[tuple[int, int, int]]:
    """Follow the tokens back from the last frame, where symbol ``last`` is left."""
    path = []
    s, end = last, len(entered)
    while end > 0:
        start = int(entered[end - 1, s])
        path.append((start, end, s))
        if start > 0:
            s = int(before[start - 1])
        end = start
    return path[::-1]


def _best_free_end(symbols: MotionSymbols, frames: FloatArray | Float32Array) -> int:
    prepared = log_symbols(symbols)
    values = np.ascontiguousarray(frames, dtype=np.float64)
    totals = [posteriors(values, prepared, s, False)[3] for s in range(symbols.n_symbols)]
    return int(np.argmax(totals))
