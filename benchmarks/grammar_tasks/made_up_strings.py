"""Description length and the search of sentences: times, comparison with random search.

Run as ``PYTHONPATH=benchmarks python -m grammar_tasks.made_up_strings``. Strings are drawn from a
chain in which each symbol is followed by few others, so that there are repeats; seeds are fixed.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from motiondb.grammar.sentences.cutting import Room, cutting_room, draw_best, search_cuts

N_SENTENCES = 40
"""Sentences into which a string is cut. Chosen by hand; not tuned."""


def chain_symbols(n: int, k: int, seed: int) -> np.ndarray:
    """Symbols of a chain over k states, each state followed mostly by a few."""
    rng = np.random.default_rng(seed)
    ladder = np.cumsum(rng.dirichlet(np.full(k, 0.1), k), axis=1)
    draws = rng.random(n)
    symbols = np.zeros(n, dtype=np.int64)
    for i in range(1, n):
        symbols[i] = min(k - 1, np.searchsorted(ladder[symbols[i - 1]], draws[i]))
    return symbols


def chain_string(n: int, k: int, seed: int) -> tuple[str, ...]:
    """The same as terminal names."""
    return tuple(f"t{symbol}" for symbol in chain_symbols(n, k, seed))


def seconds(work: Callable[[], object], times: int = 3) -> float:
    """Processor seconds, the least of several runs."""
    durations = []
    for _ in range(times):
        start = time.process_time()
        work()
        durations.append(time.process_time() - start)
    return min(durations)


def partition_time(n: int, k: int, seed: int = 0) -> tuple[int, float]:
    """Sentences, and seconds for the description length of a partition, its grammar induced."""
    room = cutting_room([chain_string(n, k, seed)], 1, n)
    rng = np.random.default_rng(seed)
    cuts = tuple(sorted(rng.choice(room.allowed, N_SENTENCES - 1, replace=False).tolist()))
    room.bits(cuts)
    return len(cuts) + 1, seconds(lambda: [room.bits(cuts) for _ in range(100)]) / 100


def against_random(room: Room, evaluations: int, n_seeds: int = 10) -> tuple[list, list]:
    """Bits found by the search and by best-of-random at equal evaluations, per seed."""
    searched = [search_cuts(room, np.random.default_rng(s), evaluations)[1] for s in range(n_seeds)]
    drawn = [draw_best(room, np.random.default_rng(s), evaluations)[1] for s in range(n_seeds)]
    return searched, drawn


def main() -> None:
    """Print all figures."""
    for n, k in ((367, 20), (885, 20), (885, 60)):
        count, spent = partition_time(n, k)
        print(f"description length of {count} sentences of {n} symbols: {spent * 1e3:.3f} ms")
    for n, k in ((156, 12), (367, 20), (367, 40)):
        room = cutting_room([chain_string(n, k, 1)])
        for evaluations in (300, 1000, 4000):
            searched, drawn = against_random(room, evaluations)
            less = np.array(drawn) - np.array(searched)
            print(
                f"{n} symbols, {k} kinds, {evaluations} evaluations: search"
                f" {np.mean(searched):.1f} bits ({min(searched):.1f} to {max(searched):.1f}), best"
                f" of random {np.mean(drawn):.1f} ({min(drawn):.1f} to {max(drawn):.1f}); seeds"
                f" with fewer bits, as many, more: {(less > 1e-6).sum()},"
                f" {(abs(less) <= 1e-6).sum()}, {(less < -1e-6).sum()}"
            )


if __name__ == "__main__":
    main()
