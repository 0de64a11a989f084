"""Symbols' HMMs against hmmlearn: all segments under all symbols, and one fit of every symbol.

    python benchmarks/hmm.py [--segments 3000] [--symbols 120] [--states 6] [--repeats 5] [--json]

Both sides do the same in one process: hmmlearn scores every segment under every symbol in a loop
(timed on a share of the segments, ``--share``, and scaled up, because the whole takes minutes;
``--share 1`` runs it all) and fits every symbol with as many iterations. Results are compared
before anything is printed. Times are medians; compilation is not counted.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median

import numpy as np
from hmmlearn.hmm import GaussianHMM

from motiondb.records import Float32Array, FloatArray, IntArray, MotionSymbols
from motiondb.symbols import hmm
from motiondb.symbols.network import segment_by_symbols
from motiondb.symbols.space import divergence


@dataclass(frozen=True)
class Workload:
    """Segments of random walks, whitened, with a symbol for each."""

    frames: FloatArray
    starts: IntArray
    ends: IntArray
    assignment: IntArray
    symbols: MotionSymbols


def make_workload(n_segments: int, n_symbols: int, n_states: int, n_dims: int) -> Workload:
    """Segments of 15 to 45 frames drawn from hidden symbols; a start that EM has to improve."""
    rng = np.random.default_rng(0)
    shape = (n_symbols, n_states, n_dims)
    truth = MotionSymbols(
        np.full(n_symbols, n_states),
        rng.uniform(0.6, 0.9, shape[:2]),
        rng.normal(0, 1.0, (n_symbols, 1, n_dims)) + rng.normal(0, 0.5, shape),
        rng.uniform(0.3, 1.0, shape),
    )
    assignment = np.arange(n_segments) % n_symbols
    lengths = rng.integers(15, 46, n_segments)
    states = [np.arange(n) * n_states // n for n in lengths]
    parts = [
        rng.normal(truth.means[s, part], np.sqrt(truth.covars[s, part]))
        for s, part in zip(assignment, states)
    ]
    ends = np.cumsum(lengths)
    starts, frames = ends - lengths, np.concatenate(parts)
    first = hmm.initialise(frames, starts, ends, assignment, truth.n_states, np.full(n_dims, 0.01))
    first.self_loops[:, -1] = 1.0  # as hmmlearn has it: no way out
    return Workload(frames, starts, ends, assignment, first)


def as_hmmlearn(symbols: MotionSymbols, s: int, n_iterations: int) -> GaussianHMM:
    """The same symbol in hmmlearn, with priors that do nothing."""
    n = int(symbols.n_states[s])
    model = GaussianHMM(
        n, "diag", n_iter=n_iterations, tol=-np.inf, init_params="", params="tmc", covars_prior=0.0
    )
    model.startprob_ = np.eye(n)[0]
    model.transmat_ = np.diag(symbols.self_loops[s, :n])
    model.transmat_ += np.diag(1 - symbols.self_loops[s, : n - 1], 1)
    model.means_, model.covars_ = symbols.means[s, :n].copy(), symbols.covars[s, :n].copy()
    return model


def timed(work: Callable[[], object], repeats: int) -> float:
    """Median seconds."""
    times = []
    for _ in range(repeats):
        began = time.perf_counter()
        work()
        times.append(time.perf_counter() - began)
    return median(times)


def compare_scores(load: Workload, share: float, repeats: int) -> dict[str, float]:
    """Every segment under every symbol."""
    n = max(1, round(share * len(load.starts)))
    frames = load.frames.astype(np.float32)
    models = [as_hmmlearn(load.symbols, s, 1) for s in range(load.symbols.n_symbols)]

    def theirs() -> FloatArray:
        pieces = [load.frames[a:b] for a, b in zip(load.starts[:n], load.ends[:n])]
        return np.array([[model.score(piece) for model in models] for piece in pieces])

    def ours() -> Float32Array:
        return hmm.score(load.symbols, frames, load.starts, load.ends)

    expected, actual = theirs(), ours()[:n]
    seconds, whole = timed(ours, repeats), timed(theirs, max(1, repeats // 2)) / n
    return {
        "motiondb_s": seconds,
        "hmmlearn_s": whole * len(load.starts),
        "hmmlearn_share": n / len(load.starts),
        "times_faster": whole * len(load.starts) / seconds,
        # a squared and weighted distance in each dimension, as two products
        "multiply_adds": 2.0 * float(np.sum(load.ends - load.starts)) * load.symbols.means.size,
        "bytes": float(frames.nbytes + 4 * len(load.starts) * load.symbols.n_symbols),
        "largest_relative_difference": float(np.max(np.abs(actual / expected - 1))),
        "same_best_symbol": float(np.mean(actual.argmax(axis=1) == expected.argmax(axis=1))),
    }


def compare_fits(load: Workload, repeats: int, n_iterations: int = 5) -> dict[str, float]:
    """Every symbol from its segments."""
    symbols = load.symbols
    members = [np.flatnonzero(load.assignment == s) for s in range(symbols.n_symbols)]
    pieces = [[load.frames[load.starts[i] : load.ends[i]] for i in rows] for rows in members]

    def theirs() -> list[GaussianHMM]:
        models = []
        for s, mine in enumerate(pieces):
            model = as_hmmlearn(symbols, s, n_iterations)
            models.append(model.fit(np.concatenate(mine), [len(piece) for piece in mine]))
        return models

    def ours() -> MotionSymbols:
        return hmm.fit(
            symbols,
            load.frames,
            load.starts,
            load.ends,
            load.assignment,
            n_iterations=n_iterations,
            variance_floor=1e-9,
            exit_required=False,
        )[0]

    expected, actual = theirs(), ours()
    means = np.stack([model.means_ for model in expected])
    covars = np.stack([np.diagonal(model.covars_, axis1=1, axis2=2) for model in expected])
    seconds, slow = timed(ours, repeats), timed(theirs, max(1, repeats // 2))
    return {
        "iterations": n_iterations,
        "motiondb_s": seconds,
        "hmmlearn_s": slow,
        "times_faster": slow / seconds,
        # densities, and sums for mean and variance, in each dimension of the states of one symbol
        "multiply_adds": 4.0
        * n_iterations
        * float(np.sum(load.ends - load.starts))
        * symbols.means[0].size,
        "bytes": float(load.frames.nbytes),  # once: later iterations may find them in a cache
        "largest_difference_of_means": float(np.max(np.abs(actual.means - means))),
        "largest_difference_of_variances": float(np.max(np.abs(actual.covars - covars))),
    }


def measure(arguments: argparse.Namespace) -> dict[str, dict[str, float]]:
    """All figures by name."""
    load = make_workload(arguments.segments, arguments.symbols, arguments.states, arguments.dims)
    long_take = load.frames[:14000]
    cut = hmm.fit(
        load.symbols,
        load.frames,
        load.starts,
        load.ends,
        load.assignment,
        n_iterations=0,
        variance_floor=1e-9,
    )[0]
    cut.self_loops[:, -1] = 0.8
    segment_by_symbols(cut, long_take[:50], switch_cost=20.0, minimum_duration=8)
    return {
        "score": compare_scores(load, arguments.share, arguments.repeats),
        "fit": compare_fits(load, arguments.repeats),
        "segment_by_symbols": {
            "frames": len(long_take),
            "motiondb_s": timed(
                lambda: segment_by_symbols(cut, long_take, switch_cost=20.0, minimum_duration=8),
                arguments.repeats,
            ),
        },
        "divergence": {
            "symbols": cut.n_symbols,
            "motiondb_s": timed(
                lambda: divergence(cut, np.random.default_rng(0)), arguments.repeats
            ),
        },
    }


def main() -> int:
    """Measure, check that the results are equal, print; 1 if they are not."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--segments", type=int, default=3000)
    parser.add_argument("--symbols", type=int, default=120)
    parser.add_argument("--states", type=int, default=6)
    parser.add_argument("--dims", type=int, default=24)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--share", type=float, default=0.02, help="of the segments for hmmlearn")
    parser.add_argument("--json", action="store_true")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        arguments = parser.parse_args()
        figures = measure(arguments)
    if arguments.json:
        print(json.dumps({"workload": vars(arguments), **figures}, indent=2))
    else:
        for name, values in figures.items():
            print(name)
            for key, value in values.items():
                print(f"  {key:32} {value:.6g}")
    equal = (
        figures["score"]["largest_relative_difference"] < 1e-3
        and figures["score"]["same_best_symbol"] == 1.0
        and figures["fit"]["largest_difference_of_means"] < 1e-6
        and figures["fit"]["largest_difference_of_variances"] < 1e-6
    )
    return 0 if equal else 1


if __name__ == "__main__":
    sys.exit(main())
