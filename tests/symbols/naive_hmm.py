"""Slow, obvious twins of ``motiondb.symbols.hmm``: every path is written out."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np
from scipy.stats import norm

from motiondb.records import FloatArray, MotionSymbols


def random_symbols(
    rng: np.random.Generator, n_states: list[int], n_dims: int, spread: float = 1.5
) -> MotionSymbols:
    """Symbols with random parameters, padded as the record says."""
    counts = np.array(n_states)
    shape = (len(counts), int(counts.max()))
    real = np.arange(shape[1]) < counts[:, None]
    return MotionSymbols(
        counts,
        np.where(real, rng.uniform(0.2, 0.9, shape), 0.0),
        np.where(real[..., None], rng.normal(0, spread, (*shape, n_dims)), 0.0),
        np.where(real[..., None], rng.uniform(0.3, 2.0, (*shape, n_dims)), 1.0),
    )


def passage(
    symbols: MotionSymbols, s: int, rng: np.random.Generator, length: int | None = None
) -> FloatArray:
    """Frames of a way through symbol s, of any length or drawn until it has the given one."""
    n_states = int(symbols.n_states[s])
    durations = rng.geometric(1.0 - symbols.self_loops[s, :n_states])
    while length is not None and durations.sum() != length:
        durations = rng.geometric(1.0 - symbols.self_loops[s, :n_states])
    states = np.repeat(np.arange(n_states), durations)
    return rng.normal(symbols.means[s, states], np.sqrt(symbols.covars[s, states]))


def log_densities(symbols: MotionSymbols, s: int, frames: FloatArray) -> FloatArray:
    """log b_k(o_t): array (frames, states)."""
    states = range(symbols.n_states[s])
    scale = np.sqrt(symbols.covars[s])
    columns = [norm.logpdf(frames, symbols.means[s, k], scale[k]).sum(axis=1) for k in states]
    return np.stack(columns, axis=1)


def paths(
    symbols: MotionSymbols, s: int, frames: FloatArray, exit: bool
) -> Iterator[tuple[tuple[int, ...], float]]:
    """Every state path of the frames with its log-probability, lowest path first."""
    n_states, loops = int(symbols.n_states[s]), symbols.self_loops[s]
    density = log_densities(symbols, s, frames)
    for moves in product([0, 1], repeat=len(frames) - 1):
        path = np.concatenate([[0], np.cumsum(moves)]).astype(int)
        if path[-1] >= n_states or (exit and path[-1] != n_states - 1):
            continue
        chances = [1 - loops[a] if m else loops[a] for a, m in zip(path, moves)]
        if exit:
            chances.append(1 - loops[n_states - 1])
        with np.errstate(divide="ignore"):
            total = np.log(chances).sum() + density[np.arange(len(path)), path].sum()
        yield tuple(path.tolist()), float(total)


def log_likelihood(symbols: MotionSymbols, s: int, frames: FloatArray, exit: bool) -> float:
    """The sum over all paths."""
    totals = [total for _, total in paths(symbols, s, frames, exit)]
    return float(np.logaddexp.reduce(totals)) if totals else -np.inf


def best_path(symbols: MotionSymbols, s: int, frames: FloatArray, exit: bool) -> tuple[int, ...]:
    """The best of all paths."""
    return max(paths(symbols, s, frames, exit), key=lambda pair: pair[1])[0]


def posteriors(symbols: MotionSymbols, s: int, frames: FloatArray, exit: bool) -> FloatArray:
    """gamma, by adding the paths through every state."""
    gamma = np.zeros((len(frames), symbols.n_states[s]))
    whole = log_likelihood(symbols, s, frames, exit)
    for path, total in paths(symbols, s, frames, exit):
        gamma[np.arange(len(path)), path] += np.exp(total - whole)
    return gamma


def best_segmentation(
    symbols: MotionSymbols,
    frames: FloatArray,
    switch_cost: float,
    minimum_duration: int = 1,
) -> tuple[float, list[tuple[int, int, int]]]:
    """The best sequence of symbols by dynamic programming over (end, last symbol)."""
    n_frames, n_symbols = len(frames), symbols.n_symbols
    best: dict[tuple[int, int], tuple[float, list[tuple[int, int, int]]]] = {}
    for end in range(1, n_frames + 1):
        for start in range(end - minimum_duration + 1):
            for s in range(n_symbols):
                totals = [p for _, p in paths(symbols, s, frames[start:end], True)]
                if not totals:
                    continue
                before = [(0.0, [])] if start == 0 else []
                for (cut, _last), (value, way) in best.items():
                    if cut == start:
                        before.append((value - switch_cost, way))
                for value, way in before:
                    candidate = (value + max(totals), [*way, (start, end, s)])
                    if candidate[0] > best.get((end, s), (-np.inf, []))[0]:
                        best[end, s] = candidate
    return max((best[key] for key in best if key[0] == n_frames), key=lambda pair: pair[0])
