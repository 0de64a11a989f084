"""Rule probabilities from sentences: expected counts over all trees, or counts of the best trees.

The expected number of times that a rule is used in the derivation of a sentence is a sum over all
its trees, found from inside and outside probabilities (J. K. Baker, "Trainable Grammars for Speech
Recognition", 1979). Taking these counts as new probabilities never lowers the likelihood of the
sentences; doing so again and again climbs to a local maximum (expectation maximisation). Counts of
the most probable trees (Viterbi) are quicker and climb on the probability of those trees.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, ldexp

import numpy as np
from numba import njit

from motiondb.grammar.cfg import Grammar, Tree, choices_of
from motiondb.grammar.chart import place_of
from motiondb.grammar.closure import transpose
from motiondb.grammar.compiled import CompiledGrammar, list_steps, numbered
from motiondb.grammar.least_solution import sparse_graph
from motiondb.grammar.parse import (
    AnyGrammar,
    ParseError,
    compiled_form,
    explain,
    log_probability,
    parse,
    sum_chart,
    tree_log_probability,
)
from motiondb.records import FloatArray, IntArray

Sentences = Sequence[Sequence[str]]


@dataclass(frozen=True)
class Estimate:
    """A grammar with new probabilities, and the log-likelihood before each round and at the end."""

    grammar: Grammar
    log_likelihoods: tuple[float, ...]


def rule_counts(grammar: AnyGrammar, trees: Sequence[Tree]) -> FloatArray:
    """How often each rule of the grammar (rules,) stands in trees."""
    used = Counter(node.rule for tree in trees for node in tree.nodes() if not node.is_leaf)
    return np.array([float(used[r]) for r in range(len(compiled_form(grammar).grammar.rules))])


def expected_counts(grammar: AnyGrammar, sentence: Sequence[str]) -> FloatArray:
    """Expected uses (rules,) of each rule in the derivation of a sentence, over all its trees.

    Raises
    ------
    ParseError where the grammar does not derive the sentence.

    >>> from motiondb.grammar.cfg import read_grammar
    >>> toy = read_grammar("S -> a S [0.5] | A [0.5]\\nA -> a | a a")
    >>> expected_counts(toy, ["a", "a"]).round(4).tolist()
    [0.3333, 1.0, 0.3333, 0.6667]
    """
    compiled = compiled_form(grammar)
    symbols = numbered(compiled, sentence)
    fault = explain(compiled, sentence)
    if fault is not None:
        raise fault
    counts, empty = np.zeros(len(compiled.rule_numbers)), np.zeros(compiled.n_symbols)
    if len(symbols):
        _count_spoken(compiled, symbols, counts, empty)
    else:
        empty[compiled.start] = 1.0
    _count_empty(compiled, counts, empty)
    found = np.zeros(len(compiled.grammar.rules))
    found[compiled.rule_numbers] = counts
    return found


def estimate(
    grammar: Grammar, sentences: Sentences, *, rounds: int = 100, tolerance: float = 1e-6
) -> Estimate:
    """Maximise the likelihood of sentences over the rule probabilities, from those given.

    Stops when a round gains less than ``tolerance`` per sentence. A rule with probability 0 keeps
    it; rules of a left side that no tree uses become equally likely.

    Raises
    ------
    ParseError, with the number of the sentence, where the grammar does not derive one.
    """
    weights = Counter(tuple(sentence) for sentence in sentences)
    likelihoods: list[float] = []
    for _ in range(rounds):
        counts = np.zeros(len(grammar.rules))
        for sentence, number in weights.items():
            counts += number * _counts_or_fault(grammar, sentence, sentences)
        likelihoods.append(log_likelihood(grammar, sentences))
        if len(likelihoods) > 1 and _gain(likelihoods) < tolerance * len(sentences):
            return Estimate(grammar, tuple(likelihoods))
        grammar = grammar.with_probabilities(counts.tolist())
    return Estimate(grammar, (*likelihoods, log_likelihood(grammar, sentences)))


def estimate_from_best_trees(
    grammar: Grammar, sentences: Sentences, *, rounds: int = 20
) -> Estimate:
    """Probabilities by counting rules in the most probable trees, until these stay the same.

    The log-likelihoods are those of the best trees; they never fall either.

    Raises
    ------
    ParseError, with the number of the sentence, where the grammar does not derive one.
    """
    likelihoods: list[float] = []
    before: list[tuple[int, ...]] = []
    for _ in range(rounds):
        trees = [_parse_or_fault(grammar, sentence, k) for k, sentence in enumerate(sentences)]
        likelihoods.append(sum(tree_log_probability(grammar, tree) for tree in trees))
        rules = [choices_of(tree) for tree in trees]
        if rules == before:
            break
        grammar = grammar.with_probabilities(rule_counts(grammar, trees).tolist())
        before = rules
    return Estimate(grammar, tuple(likelihoods))


def log_likelihood(grammar: AnyGrammar, sentences: Sentences) -> float:
    """Sum of the natural logarithms of the sentences' probabilities; -inf where one is 0."""
    weights = Counter(tuple(sentence) for sentence in sentences)
    return sum(number * log_probability(grammar, sentence) for sentence, number in weights.items())


def _gain(likelihoods: list[float]) -> float:
    return likelihoods[-1] - likelihoods[-2] if likelihoods[-2] > -inf else inf


def _counts_or_fault(
    grammar: Grammar, sentence: tuple[str, ...], sentences: Sentences
) -> FloatArray:
    try:
        return expected_counts(grammar, sentence)
    except ParseError as fault:
        number = [tuple(other) for other in sentences].index(sentence)
        raise _with_number(fault, number) from None


def _parse_or_fault(grammar: Grammar, sentence: Sequence[str], number: int) -> Tree:
    try:
        return parse(grammar, sentence)
    except ParseError as fault:
        raise _with_number(fault, number) from None


def _with_number(fault: ParseError, number: int) -> ParseError:
    message = f"sentence {number}, {fault}"
    return ParseError(message, fault.position, fault.found, fault.expected, fault.may_end)


def _count_spoken(
    compiled: CompiledGrammar, symbols: IntArray, counts: FloatArray, empty: FloatArray
) -> None:
    """Add the uses of rules in what speaks, and how often a symbol of a tail became empty."""
    chart = sum_chart(compiled, symbols)
    sources, targets, values, origins = list_steps(
        compiled, compiled.probabilities, compiled.empties
    )
    order = np.argsort(sources, kind="stable")
    steps = sparse_graph(compiled.n_symbols, sources, targets, values)
    forms = (compiled.left, compiled.right, steps, transpose(*compiled.all_chains))
    used = _outside(chart, len(symbols), compiled.start, forms)
    sources, targets, origins = sources[order], targets[order], origins[order]
    ruled = origins >= 0
    np.add.at(counts, origins[ruled], used[ruled])
    tails, speaking, used = sources[~ruled], targets[~ruled], used[~ruled]
    left, right = compiled.left[tails], compiled.right[tails]
    # a tail of one symbol twice has two steps to it; either way that symbol is the empty one
    np.add.at(empty, np.where(left == speaking, right, left), used)


def _count_empty(compiled: CompiledGrammar, counts: FloatArray, empty: FloatArray) -> None:
    """Add the uses of rules in what became empty, given how often each symbol did."""
    nullable, e, right = compiled.nullable, compiled.empties, compiled.rule_right
    if not empty.any():
        return
    rules = np.flatnonzero((right < 0) | nullable[right])
    left, below = compiled.rule_left[rules], right[rules]
    shares = compiled.probabilities[rules] * np.where(below < 0, 1.0, e[below]) / e[left]
    tails = np.flatnonzero((compiled.left >= 0) & nullable)
    index = np.cumsum(nullable) - 1
    passes = np.zeros((int(nullable.sum()),) * 2)
    real = below >= 0
    np.add.at(passes, (index[below[real]], index[left[real]]), shares[real])
    np.add.at(passes, (index[compiled.left[tails]], index[tails]), 1.0)
    np.add.at(passes, (index[compiled.right[tails]], index[tails]), 1.0)
    # a hair below 1: at the critical point the mean number of empty symbols is infinite
    uses = np.linalg.solve(np.eye(len(passes)) - (1 - 1e-12) * passes, empty[nullable])
    np.add.at(counts, rules, shares * uses[index[left]])


@njit(cache=True)
def _outside(chart, n, start, forms):  # type: ignore[no-untyped-def]
    """Expected uses of each step (steps,) that reads nothing, over all trees of a sentence."""
    begin, end, exponents, symbols, values = chart
    left, right, steps, chains = forms
    step_starts, step_targets, step_weights = steps
    chain_starts, chain_symbols, chain_weights = chains
    used, outer = np.zeros(len(step_targets)), np.zeros(len(symbols))
    inner, total = np.zeros(len(left)), np.zeros(len(left))
    for entry in range(begin[0, n], end[0, n]):
        if symbols[entry] == start:
            outer[entry] = 1.0 / values[entry]
    for i in range(n):
        for j in range(n, i, -1):
            cell = range(begin[i, j], end[i, j])
            for entry in cell:
                inner[symbols[entry]] = values[entry]
            for entry in cell:
                if outer[entry] == 0.0:
                    continue
                for c in range(chain_starts[symbols[entry]], chain_starts[symbols[entry] + 1]):
                    below = chain_symbols[c]
                    if inner[below] > 0.0:
                        total[below] += outer[entry] * chain_weights[c]
            for entry in cell:
                symbol = symbols[entry]
                if total[symbol] == 0.0:
                    continue
                for s in range(step_starts[symbol], step_starts[symbol + 1]):
                    used[s] += total[symbol] * step_weights[s] * inner[step_targets[s]]
                if left[symbol] < 0:
                    continue
                for k in range(i + 1, j):
                    a = _entry(chart, left[symbol], i, k)
                    b = _entry(chart, right[symbol], k, j)
                    if a >= 0 and b >= 0:
                        shift = exponents[i, k] + exponents[k, j] - exponents[i, j]
                        value = total[symbol] * ldexp(1.0, shift)
                        outer[a] += value * values[b]
                        outer[b] += value * values[a]
            for entry in cell:
                inner[symbols[entry]] = total[symbols[entry]] = 0.0
    return used


@njit(cache=True)
def _entry(chart, symbol, i, j):  # type: ignore[no-untyped-def]
    begin, end, _, symbols, _ = chart
    place = place_of(symbols, symbol, begin[i, j], end[i, j])
    return place if place < end[i, j] and symbols[place] == symbol else -1
