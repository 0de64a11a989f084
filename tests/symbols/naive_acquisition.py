"""Captures made of known symbols, and slow, obvious twins of the acquisition of symbols."""

from __future__ import annotations

from dataclasses import dataclass
from math import log

import numpy as np
from naive_hmm import passage

from motiondb.records import Float32Array, IntArray, MotionSymbols
from motiondb.symbols import hmm


@dataclass(frozen=True, eq=False)
class Planted:
    """Frames of ``n_captures`` captures, cut at known places into passages of known symbols."""

    frames: Float32Array
    bounds: IntArray
    starts: IntArray
    ends: IntArray
    truth: IntArray

    @property
    def labels(self) -> IntArray:
        """The true symbol of every frame."""
        return np.repeat(self.truth, self.ends - self.starts)


def plant(
    seed: int,
    n_symbols: int,
    *,
    n_states: int = 3,
    n_each: int = 20,
    variance: float = 0.1,
    n_captures: int = 5,
) -> Planted:
    """Every symbol ``n_each`` times, 9 to 17 frames long, in random order."""
    rng = np.random.default_rng(seed)
    shape = (n_symbols, n_states, 4)
    symbols = MotionSymbols(
        np.full(n_symbols, n_states),
        np.full(shape[:2], 0.75),
        rng.normal(0, 2, shape),
        np.full(shape, variance),
    )
    truth = rng.permutation(np.repeat(np.arange(n_symbols), n_each))
    lengths = rng.integers(9, 18, len(truth))
    parts = [passage(symbols, s, rng, int(n)) for s, n in zip(truth, lengths)]
    ends = np.cumsum(lengths)
    last = [group[-1] for group in np.array_split(np.arange(len(truth)), n_captures)]
    bounds = np.concatenate([[0], ends[last]])
    frames = np.concatenate(parts).astype(np.float32)
    return Planted(frames, bounds, ends - lengths, ends, truth)


def rand_index(first: IntArray, second: IntArray) -> float:
    """Adjusted Rand index, from the counts of pairs (Hubert and Arabie, 1985)."""
    table = np.zeros((first.max() + 1, second.max() + 1))
    np.add.at(table, (first, second), 1)

    def pairs(counts: np.ndarray) -> float:
        return float((counts * (counts - 1) / 2).sum())

    rows, columns, n = pairs(table.sum(axis=1)), pairs(table.sum(axis=0)), len(first)
    expected = rows * columns / (n * (n - 1) / 2)
    most = (rows + columns) / 2
    return 1.0 if most == expected else (pairs(table) - expected) / (most - expected)


def description_length(
    symbols: MotionSymbols, frames: Float32Array, starts: IntArray, ends: IntArray
) -> float:
    """L, a segment and a symbol at a time."""
    total = 0.0
    for a, b in zip(starts, ends):
        one = (np.array([a]), np.array([b]))
        total -= max(float(row) for row in hmm.score(symbols, frames, *one)[0])
        total += log(symbols.n_symbols)
    for n_states in symbols.n_states:
        total += 0.5 * n_states * (2 * frames.shape[1] + 1) * log(len(frames))
    return total


def total_length(scores: np.ndarray, prices: np.ndarray, alive: list[int]) -> float:
    """L of the symbols that live, a segment at a time."""
    each = -sum(max(row[s] for s in alive) for row in scores)
    return float(each + len(scores) * log(len(alive)) + sum(prices[s] for s in alive))


def symbols_that_pay(scores: np.ndarray, prices: np.ndarray) -> list[int]:
    """Kill by trying every death and writing out L; the symbols left."""
    alive = list(range(scores.shape[1]))
    while len(alive) > 1:
        without = [[s for s in alive if s != dead] for dead in alive]
        lengths = [total_length(scores, prices, left) for left in without]
        if min(lengths) >= total_length(scores, prices, alive):
            break
        alive = without[int(np.argmin(lengths))]
    return alive
