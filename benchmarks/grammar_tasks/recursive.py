"""Task ``recursive`` of ``benchmarks/grammar.py``: languages that repeat and nest.

Sentences are drawn from grammars with loops; empty ones and those of more than 60 symbols are drawn
again. Each learner gets the same sentences: motiondb, motiondb without loops, the finite state
machine of observed transitions, the 3-testable language (every three neighbours were observed), and
ALERGIA (aalpy, if it is installed: ``pip install aalpy``). Precision is the share of its strings
that the true grammar derives, recall the share of true strings that it derives, *unseen* the same
of those that are no example. Strings are drawn at random, also those of the true grammar.

Sources: P. Garcia and E. Vidal, "Inference of k-Testable Languages in the Strict Sense", IEEE TPAMI
12 (1990); R. C. Carrasco and J. Oncina, "Learning Stochastic Regular Grammars by Means of a State
Merging Method", ICGI 1994, for ALERGIA.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from grammar_tasks.tables import table
from motiondb.grammar.baselines.finite_state import finite_state_grammar
from motiondb.grammar.baselines.language_measures import coverage, derived_strings
from motiondb.grammar.cfg.context_free import Grammar, Rule, read_grammar
from motiondb.grammar.derivation.derive import derive
from motiondb.grammar.induction.induction import induce
from motiondb.grammar.rules.description_length import description_length

String = tuple[str, ...]
LANGUAGES = {
    "repetition": "S -> stand A rest\nA -> left right A [0.6] | left right [0.4]",
    "separated list": "S -> walk L sit\nL -> I then L [0.6] | I [0.4]\nI -> wave | clap | bow",
    "brackets": "S -> l Q r S [0.45] | l Q r [0.55]\nQ -> S [0.4] | empty [0.6]",
    "two brackets": "S -> P S [0.4] | P [0.6]\nP -> l Q r | k Q t\nQ -> S [0.45] | empty [0.55]",
    "a^n b^n": "S -> a S b [0.65] | a b [0.35]",
    "mirror": "S -> a S a [0.35] | b S b [0.3] | m [0.35]",
    "arithmetic": (
        "E -> E plus T [0.4] | T [0.6]\nT -> T times F [0.35] | F [0.65]\n"
        "F -> l E r [0.28] | x [0.4] | y [0.32]"
    ),
    "nested play": "S -> start P shoot\nP -> dribble P [0.3] | pass P return [0.3] | fake [0.4]",
    "loop in a loop": (
        "S -> walk P shoot\nP -> D E P | D E\nD -> dribble D | dribble\nE -> pass | fake"
    ),
    "one to three times": "S -> stand A rest\nA -> l r | l r l r | l r l r l r",
}
BOUNDED = ("one to three times",)
SENTENCES, LONGEST, STRINGS, MEAN = 20, 60, 300, 40.0
"""Sentences given, symbols of the longest, strings drawn to compare languages, and the mean
length. Chosen by hand; not tuned."""
SEEDS = 2
"""Sets of sentences drawn from every language."""


def recursive_rows(n: int = SENTENCES, seeds: int = SEEDS) -> str:
    """The section: every language, every learner."""
    learners: dict[str, Callable[[list[String]], Grammar]] = {
        "motiondb": induce,
        "without loops": partial(induce, loops=False),
        "finite state machine": finite_state_grammar,
        "3-testable": three_testable,
    }
    if _has_aalpy():
        learners["ALERGIA"] = alergia
    rows = []
    for name, text in LANGUAGES.items():
        truth = read_grammar(text)
        drawn = [_drawn(truth, n, 700 + seed) for seed in range(seeds)]
        true_bits = np.mean([description_length(truth, sample).total for sample in drawn])
        for kind, learn in learners.items():
            figures = np.array([_figures(learn, truth, sample) for sample in drawn]).mean(axis=0)
            *shares, bits, spent = figures.tolist()
            rows.append(
                [name, kind, *(f"{share:.2f}" for share in shares), f"{bits:.0f}",
                 f"{true_bits:.0f}", f"{spent:.1f}"]
            )  # fmt: skip
            print("  " + " ".join(rows[-1]), flush=True)
    heads = ["language", "learner", "precision", "recall", "unseen", "bits", "true rules",
             "processor seconds"]  # fmt: skip
    said = f"{n} sentences, means of {seeds} draws; {STRINGS} strings for each figure."
    return f"{table(heads, rows)}\n\n{said}"


def _figures(
    learn: Callable[[list[String]], Grammar], truth: Grammar, sample: list[String]
) -> tuple[float, ...]:
    """Precision, recall, recall of unseen strings, bits, processor seconds."""
    started = time.process_time()
    learned = learn(sample)
    spent = time.process_time() - started
    strings = derived_strings(learned, np.random.default_rng(1), STRINGS, most=MEAN)
    true = derived_strings(truth, np.random.default_rng(2), STRINGS, most=MEAN)
    unseen = [string for string in true if string not in set(sample)]
    used = Grammar(learned.start, learned.rules)
    return (
        coverage(truth, strings),
        coverage(learned, true),
        coverage(learned, unseen) if unseen else 1.0,
        description_length(used, sample).total,
        spent,
    )


def _drawn(truth: Grammar, n: int, seed: int) -> list[String]:
    rng = np.random.default_rng(seed)
    sample: list[String] = []
    while len(sample) < n:
        string = derive(truth, rng).leaves()
        if 0 < len(string) <= LONGEST:
            sample.append(string)
    return sample


def three_testable(sentences: Sequence[String]) -> Grammar:
    """The language of strings whose three neighbours, ends included, were all observed."""
    counts: Counter[tuple[String, str]] = Counter()
    for sentence in sentences:
        before: String = ("<", "<")
        for symbol in (*sentence, ">"):
            counts[before, symbol] += 1
            before = (before[1], symbol)
    names: dict[String, str] = {("<", "<"): "S"}
    for state, _ in counts:
        names.setdefault(state, f"Q{len(names)}")
    rules = [
        Rule(
            names[state],
            () if symbol == ">" else (symbol, names[state[1], symbol]),
            float(number),
        )
        for (state, symbol), number in counts.items()
    ]
    return Grammar("S", tuple(rules)).with_probabilities([rule.probability for rule in rules])


def alergia(sentences: Sequence[String]) -> Grammar:
    """The Markov chain that ALERGIA learns, as a grammar."""
    from aalpy.learning_algs import run_Alergia

    chain = run_Alergia([["<", *sentence, ">"] for sentence in sentences], "mc")
    names = {id(state): f"Q{k}" for k, state in enumerate(chain.states)}
    rules = []
    for state in chain.states:
        for target, chance in state.transitions:
            right = () if target.output == ">" else (target.output, names[id(target)])
            rules.append(Rule(names[id(state)], right, float(chance)))
    return Grammar(names[id(chain.initial_state)], tuple(rules)).with_probabilities(
        [rule.probability for rule in rules]
    )


def _has_aalpy() -> bool:
    from importlib.util import find_spec

    return find_spec("aalpy") is not None
