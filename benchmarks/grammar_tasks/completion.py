"""Task ``completion`` of ``benchmarks/grammar.py``: how long it takes to complete a pattern.

Patterns are made from sentences of the grammar: some terminals stay, the others become ``?`` or
``...``. For each, the five most probable sentences are asked for, and one drawn sentence. The
grammar is compiled and the code warm; the times are those of one question.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from grammar_tasks.recursive_languages import DEVELOPMENT, LANGUAGES
from grammar_tasks.speed_table import random_grammar
from grammar_tasks.tables import table
from motiondb.grammar.cfg.context_free import Grammar, read_grammar
from motiondb.grammar.cfg.parse import compiled_form
from motiondb.grammar.derivation.complete import complete, sample_completions
from motiondb.grammar.derivation.derive import derive
from motiondb.grammar.derivation.pattern import ANY, GAP, Pattern, read_pattern

PATTERNS, STRINGS, LONGEST = 20, 5, 14
"""Patterns of each grammar, completions of each pattern, and places of the longest one. Chosen by
hand; not tuned."""
NAMES = ("nested play", "arithmetic", "two brackets", "steps and kicks")


def completion_rows() -> str:
    """The section: processor milliseconds of each grammar."""
    known = {**LANGUAGES, **DEVELOPMENT}
    grammars = {name: read_grammar(known[name]) for name in NAMES}
    grammars["random, 150 rules"] = random_grammar(np.random.default_rng(0))
    rows = [[name, str(len(g.rules)), *_times(g)] for name, g in grammars.items()]
    heads = ["grammar", "rules", f"{STRINGS} best, mean", "longest", "drawn, mean", "longest"]
    said = f"Processor milliseconds of {PATTERNS} patterns of at most {LONGEST} positions."
    return f"{table(heads, rows)}\n\n{said}"


def _times(grammar: Grammar) -> list[str]:
    rng = np.random.default_rng(1)
    compiled = compiled_form(grammar)
    patterns: list[Pattern] = []
    while len(patterns) < PATTERNS:
        string = derive(grammar, rng, length=int(rng.integers(4, LONGEST))).leaves()
        if string:
            patterns.append(read_pattern(_holes(string, rng)))
    works: tuple[Callable[[int], object], ...] = (
        lambda k: complete(compiled, patterns[k], STRINGS),
        lambda k: next(sample_completions(compiled, patterns[k], np.random.default_rng(k))),
    )
    cells = []
    for work in works:
        work(0)
        spent = []
        for k in range(PATTERNS):
            started = time.process_time()
            work(k)
            spent.append(1e3 * (time.process_time() - started))
        cells += [f"{np.mean(spent):.1f}", f"{max(spent):.1f}"]
    return cells


def _holes(string: tuple[str, ...], rng: np.random.Generator) -> list[str]:
    """Replace terminals by ``?``, and one part by ``...``."""
    tokens = [ANY if rng.random() < 0.25 else name for name in string]
    first, last = sorted(rng.integers(0, len(tokens) + 1, 2).tolist())
    return [*tokens[:first], GAP, *tokens[last:]]
