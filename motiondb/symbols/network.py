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
    tokens = np.full((n_symbols, n_padded, n_ages), NEVER)
    begun = np.zeros((n_symbols, n_padded), dtype=np.int64)
    entry, leaving = np.zeros(n_symbols), np.zeros(n_symbols)
    entered = np.empty((n_frames, n_symbols), dtype=np.int64)
    before = np.empty(n_frames, dtype=np.int64)
    prepared = log_symbols(symbols)
    step = max(1, BLOCK_VALUES // (n_symbols * n_padded))
    for low in range(0, n_frames, step):
        blocks = [block for _, block in log_density_blocks(symbols, frames[low : low + step])]
        densities = blocks[0] if len(blocks) == 1 else np.concatenate(blocks, axis=2)
        state, records = (tokens, begun, entry, leaving), (entered, before)
        _advance(densities, low, prepared, switch_cost, state, records)
    return entered, before, int(np.argmax(leaving))


@njit(cache=True, nogil=True)
def _advance(
    densities: Float32Array,
    low: int,
    symbols: LogSymbols,
    switch_cost: float,
    state: tuple[FloatArray, IntArray, FloatArray, FloatArray],
    records: tuple[IntArray, IntArray],
) -> None:
    """Pass the tokens through a block of frames; ``state`` and ``records`` are changed in place."""
    tokens, begun, entry, leaving = state
    entered, before = records
    n_symbols = len(symbols.n_states)
    for number in range(len(densities)):
        t = low + number
        for s in range(n_symbols):
            last = symbols.n_states[s] - 1
            _advance_symbol(
                densities[number, :, s],
                symbols.log_stay[s],
                symbols.log_leave[s],
                (tokens[s, : last + 1], begun[s]),
                (t, entry[s]),
            )
            leaving[s] = tokens[s, last, -1] + symbols.log_leave[s, last]
            entered[t, s] = begun[s, last]
        best = np.argmax(leaving)
        before[t] = best
        entry[:] = max(leaving[best] - switch_cost, NEVER)


@njit(cache=True, nogil=True)
def _advance_symbol(
    densities: Float32Array,
    stay: FloatArray,
    leave: FloatArray,
    state: tuple[FloatArray, IntArray],
    entrant: tuple[int, float],
) -> None:
    """One frame of one symbol; the last age stands for all from ``minimum_duration`` on."""
    tokens, begun = state
    t, entry = entrant
    old = tokens.shape[1] - 1
    for k in range(len(tokens) - 1, -1, -1):
        best, when = tokens[k, old] + stay[k], begun[k]
        if k > 0 and tokens[k - 1, old] + leave[k - 1] > best:
            best, when = tokens[k - 1, old] + leave[k - 1], begun[k - 1]
        if old == 0:
            if k == 0 and entry > best:
                best, when = entry, t
        else:
            grown = tokens[k, old - 1] + stay[k]
            if k > 0:
                grown = max(grown, tokens[k - 1, old - 1] + leave[k - 1])
            if grown > best:
                best, when = grown, t - old
        tokens[k, old], begun[k] = max(best + densities[k], NEVER), when
        for age in range(old - 1, 0, -1):
            value = tokens[k, age - 1] + stay[k]
            if k > 0:
                value = max(value, tokens[k - 1, age - 1] + leave[k - 1])
            tokens[k, age] = max(value + densities[k], NEVER)
        if old > 0:
            tokens[k, 0] = max(entry + densities[0], NEVER) if k == 0 else NEVER


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
