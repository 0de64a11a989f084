"""Tasks ``recursive`` and ``development`` of ``benchmarks/grammar.py``: loops and nesting.

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

from grammar_tasks.recursive_languages import DEVELOPMENT, LANGUAGES
from grammar_tasks.tables import table, table_rows
from motiondb.grammar.cfg.context_free import Grammar, Rule, choices_of, read_grammar
from motiondb.grammar.cfg.parse import accepts, parse
from motiondb.grammar.derivation.derive import derive
from motiondb.grammar.induction.induction import induce, induce_quickly
from motiondb.grammar.languages import coverage, derived_strings, finite_state_grammar
from motiondb.grammar.rules.description_length import description_length
from motiondb.grammar.sentences.doubtful import find_doubtful

String = tuple[str, ...]
SIZES = (20, 50)
"""Numbers of sentences given. Chosen by hand; not tuned."""
LONGEST, STRINGS, MEAN = 60, 300, 40.0
"""Symbols of the longest sentence, strings drawn to compare languages, and their mean length.
Chosen by hand; not tuned."""
ERRORS, ERROR_SENTENCES = 0.05, 40  # Share of wrong sentences; sentences of a draw
SEEDS, DEVELOPMENT_SEEDS = 2, 3
"""Draws of sentences for the table, and for the languages of development. Chosen by hand."""
LOOPS, NO_LOOPS = "motiondb", "without loops"
HEADS = ["language", "learner", "precision", "recall", "unseen", "bits", "true rules",
         "processor seconds", "times without loops"]  # fmt: skip


def recursive_rows(n: int, names: Sequence[str], known: str) -> str:
    """The section of a number of sentences: every learner on some of the languages.

    Rows of other languages are taken from ``known``, the section as it is.
    """
    rows: dict[str, list[list[str]]] = {row[0]: [] for row in table_rows(known)}
    for row in table_rows(known):
        rows[row[0]].append(row)
    for name in names:
        rows[name] = _language_rows(name, n)
        for row in rows[name]:
            print("  " + " ".join(row), flush=True)
    ordered = [row for name in LANGUAGES for row in rows.get(name, [])]
    said = f"{n} sentences, means of {SEEDS} draws; {STRINGS} strings for each figure."
    return f"{table(HEADS, ordered)}\n\n{said}"


def _language_rows(name: str, n: int) -> list[list[str]]:
    """The rows of a language, one for each learner."""
    learners: dict[str, Callable[[list[String]], Grammar]] = {
        LOOPS: induce,
        NO_LOOPS: partial(induce, loops=False),
        "finite state machine": finite_state_grammar,
        "3-testable": three_testable,
    }
    if _has_aalpy():
        learners["ALERGIA"] = alergia
    truth = read_grammar(LANGUAGES[name])
    drawn = [_drawn(truth, n, 700 + seed) for seed in range(SEEDS)]
    true_bits = np.mean([description_length(truth, sample).total for sample in drawn])
    figures = {
        kind: np.array([_figures(learn, truth, sample) for sample in drawn]).mean(axis=0)
        for kind, learn in learners.items()
    }
    rows = []
    for kind, (*shares, bits, spent) in figures.items():
        times = f"{spent / figures[NO_LOOPS][-1]:.1f}" if kind == LOOPS else ""
        rows.append(
            [name, kind, *(f"{share:.2f}" for share in shares), f"{bits:.0f}", f"{true_bits:.0f}",
             f"{spent:.1f}", times]
        )  # fmt: skip
    return rows


def development_rows(names: Sequence[str], known: str) -> str:
    """The section of the languages on which faults were looked for: every draw of motiondb."""
    rows = {row[0]: row for row in table_rows(known)}
    for name in names:
        truth = read_grammar(DEVELOPMENT[name])
        cells = []
        for seed in range(1, DEVELOPMENT_SEEDS + 1):
            sample = _drawn(truth, SIZES[0], seed)
            *shares, bits, _ = _figures(induce, truth, sample)
            true_bits = description_length(truth, sample).total
            shown = " / ".join(f"{share:.2f}" for share in shares)
            cells += [shown, f"{bits:.0f} / {true_bits:.0f}"]
        rows[name] = [name, *cells]
        print("  " + " | ".join(rows[name]), flush=True)
    heads = ["language"]
    for seed in range(1, DEVELOPMENT_SEEDS + 1):
        heads += [f"draw {seed}: precision / recall / unseen", "bits / true rules"]
    ordered = [rows[name] for name in DEVELOPMENT if name in rows]
    return f"{table(heads, ordered)}\n\n{SIZES[0]} sentences."


def error_rows() -> str:
    """The section of wrong sentences: how many are found, and what leaving them out gains."""
    rows = []
    for kind, languages in (("table", LANGUAGES), ("development", DEVELOPMENT)):
        for share in (0.0, ERRORS):
            counts, figures = np.zeros(3, dtype=int), []
            for text in languages.values():
                truth = read_grammar(text)
                for seed in (1, 2):
                    sample = _drawn(truth, ERROR_SENTENCES, seed)
                    wrong = _make_errors(truth, sample, share, np.random.default_rng(seed))
                    learned = induce_quickly(sample)
                    parses = [choices_of(parse(learned, string)) for string in sample]
                    named = {one.sentence for one in find_doubtful(learned, sample, parses)}
                    counts += len(wrong), len(wrong & named), len(named - wrong)
                    rest = [s for n, s in enumerate(sample) if n not in named]
                    again = induce_quickly(rest) if named else learned
                    figures.append((*_shares(learned, truth), *_shares(again, truth)))
            means = np.mean(figures, axis=0)
            cells = [str(n) for n in (2 * ERROR_SENTENCES * len(languages), *counts)]
            rows.append([kind, *cells, *(f"{mean:.3f}" for mean in means)])
            print("  " + " | ".join(rows[-1]), flush=True)
    heads = ["languages", "sentences", "wrong", "found", "named, but right", "precision", "recall",
             "precision without", "recall without"]  # fmt: skip
    said = (
        f"{ERROR_SENTENCES} sentences of each language, two draws; a wrong one has a terminal"
        " exchanged, left out or added, and the language does not hold it."
    )
    return f"{table(heads, rows)}\n\n{said}"


def _make_errors(
    truth: Grammar, sample: list[String], share: float, rng: np.random.Generator
) -> set[int]:
    """Make some sentences wrong, in place; return their numbers."""
    wrong = set()
    for n in rng.permutation(len(sample))[: round(share * len(sample))].tolist():
        for _ in range(50):
            string, place = list(sample[n]), int(rng.integers(len(sample[n])))
            other = truth.terminals[int(rng.integers(len(truth.terminals)))]
            cuts: list[tuple[int, int, list[str]]] = [
                (place, place + 1, [other]),
                (place, place + 1, []),
                (place, place, [other]),
            ]
            first, end, new = cuts[int(rng.integers(3))]
            string[first:end] = new
            if string and not accepts(truth, string):
                sample[n] = tuple(string)
                wrong.add(n)
                break
    return wrong


def _shares(learned: Grammar, truth: Grammar) -> tuple[float, float]:
    """Precision and recall."""
    strings = derived_strings(learned, np.random.default_rng(1), STRINGS, most=MEAN)
    true = derived_strings(truth, np.random.default_rng(2), STRINGS, most=MEAN)
    return coverage(truth, strings), coverage(learned, true)


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
