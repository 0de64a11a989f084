"""Task ``curve`` of ``benchmarks/grammar.py``: how many sentences a language must be learned from.

Sentences are drawn from known grammars, n to learn from and others to test. A test sentence counts
as foreseen as in :mod:`grammar_tasks.foreseen`. In *play, two ways* every label is written as one
of two symbols at random, as terminals of real takes often are.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grammar_tasks.foreseen import String, learned_ranks
from grammar_tasks.tables import table, table_rows
from grammar_tasks.truth import load_truth
from motiondb.grammar.cfg.context_free import Grammar
from motiondb.grammar.derivation.derive import derive
from motiondb.grammar.induction.induction import induce
from motiondb.grammar.languages import finite_state_grammar

NUMBERS, DRAWS, TESTED = (7, 13, 25, 50), 2, 100
"""Sentences to learn from (13 are the clips of basketball), draws, and sentences to test."""
SIZES = (100, 10_000)
"""Numbers of most probable strings among which a sentence counts as foreseen."""
SEED = 7
"""Nothing was chosen on strings of this seed."""
LANGUAGES = ("dance", "fight", "play", "play, two ways")


def curve_rows(names: Sequence[str], before: str) -> str:
    """A row for each language, number of sentences and learner."""
    rows = [row for row in table_rows(before) if row[0] not in names]
    grammars, _ = load_truth()
    for name in names:
        for n in NUMBERS:
            truth, two_ways = grammars[name.split(",")[0]], name.endswith("two ways")
            rows += [[name, str(n), *row] for row in _measured(truth, n, two_ways)]
            print(" ", *rows[-2], " / ", *rows[-1], flush=True)
    heads = ["language", "sentences", "learner", "in the language"]
    rows.sort(key=lambda row: (row[0], int(row[1])))
    return table([*heads, *(f"n = {size:,}" for size in SIZES)], rows)


def _measured(truth: Grammar, n: int, two_ways: bool) -> list[list[str]]:
    ranks: dict[str, list[float]] = {"motiondb": [], "finite state machine": []}
    for draw in range(DRAWS):
        rng = np.random.default_rng([SEED, draw])
        drawn = [_drawn(truth, rng, two_ways) for _ in range(n + TESTED)]
        for kind, learn in (("motiondb", induce), ("finite state machine", finite_state_grammar)):
            ranks[kind] += learned_ranks(learn(drawn[:n]), drawn[n:])
    return [
        [kind, *(f"{np.mean(np.array(some) <= size):.0%}" for size in (1e300, *SIZES))]
        for kind, some in ranks.items()
    ]


def _drawn(truth: Grammar, rng: np.random.Generator, two_ways: bool) -> String:
    string = derive(truth, rng).leaves()
    if not two_ways:
        return string
    return tuple(f"{label}{rng.integers(2)}" for label in string)
