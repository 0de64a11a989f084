"""Parse a sentence with any context-free grammar: its best tree, its probability, its faults.

Ambiguous grammars, empty rules, unit cycles and left recursion are all allowed. Among the trees of
a sentence the most probable is taken; of equally probable ones that with the fewest rules, then at
each node, from the root down, the rule that is first in the grammar, then the shortest first part.
The probability of a sentence is the sum over all its trees, of which there may be infinitely many.
Rule probabilities are scaled to sum to 1 for each left side; a rule with probability 0 is never
used.

*Prefixes.* P(w ...) is the probability that a sentence begins with w: the sum over all trees of all
sentences that do, left recursion included, which is summed in closed form over the chains of left
corners. Then P(t | w) = P(w t ...) / P(w ...) for a terminal t, and P(end | w) = P(w) / P(w ...);
they sum to 1. All probabilities are given that the derivation ends: for a grammar with infinite
derivations, only the finite sentences count. A string is at most as probable as its prefixes. A
search that always extends the most probable prefix therefore yields the strings of a language in
the order of their probability (:func:`best_strings`).

Cost: n^3 for a sentence of n symbols, times the number of pairs of symbols that meet in a cell of
the chart.

Sources: F. Jelinek and J. D. Lafferty, "Computation of the Probability of Initial Substring
Generation by Stochastic Context-Free Grammars", Computational Linguistics 17 (1991); A. Stolcke,
"An Efficient Probabilistic Context-Free Parsing Algorithm that Computes Prefix Probabilities",
Computational Linguistics 21 (1995).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from heapq import heappop, heappush
from itertools import count
from math import frexp, inf, ldexp, log

import numpy as np

from motiondb.errors import suggestion
from motiondb.grammar.cfg import automata
from motiondb.grammar.cfg.closure import BEST, COUNT, SUM, Sparse
from motiondb.grammar.cfg.compiled import CompiledGrammar, Tails, compile_grammar, numbered
from motiondb.grammar.cfg.context_free import Grammar, GrammarError, Rule, Tree, derive_by
from motiondb.grammar.cfg.inside import Inside, find, inside
from motiondb.grammar.cfg.trees import best_rules
from motiondb.grammar.kernels import kernel, maker
from motiondb.records import FloatArray, IntArray

AnyGrammar = Grammar | CompiledGrammar

_SHOWN = 20  # largest number of expected terminals in a message; the error holds all


class ParseError(GrammarError):
    """A sentence that the grammar does not derive."""

    def __init__(
        self,
        message: str,
        position: int,
        symbol: str | None,
        expected: tuple[str, ...],
        may_end: bool,
    ) -> None:
        super().__init__(message)
        self.position, self.symbol = position, symbol
        self.expected, self.may_end = expected, may_end


def compiled_form(grammar: AnyGrammar) -> CompiledGrammar:
    """Return the compiled form of a grammar, which may be compiled already."""
    return grammar if isinstance(grammar, CompiledGrammar) else compile_grammar(grammar)


def parse(grammar: AnyGrammar, sentence: Sequence[str]) -> Tree:
    r"""Return the most probable tree of a sentence.

    >>> from motiondb.grammar.cfg.context_free import choices_of, read_grammar
    >>> toy = read_grammar("S -> hold A shoot\nA -> dribble A | empty")
    >>> choices_of(parse(toy, ("hold", "dribble", "shoot")))
    (0, 1, 2)
    >>> parse(toy, ("hold", "dribble"))  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    motiondb.grammar.cfg.parse.ParseError: end of the sentence (after symbol 1, 'dribble'): ...
    """
    compiled = compiled_form(grammar)
    symbols = numbered(compiled, sentence)
    choices = None
    if (symbols >= 0).all():
        choices = best_rules(compiled, _inside(compiled, symbols, BEST), compiled.weights(BEST))
    if choices is None:
        fault = explain(compiled, sentence)
        assert fault is not None
        raise fault
    return derive_by(compiled.grammar, compiled.rule_numbers[choices].tolist())


def accepts(grammar: AnyGrammar, sentence: Sequence[str]) -> bool:
    """Whether the grammar derives the sentence."""
    return log_probability(grammar, sentence) > -inf


def log_probability(grammar: AnyGrammar, sentence: Sequence[str]) -> float:
    """Return the natural logarithm of the summed probability of all trees; -inf if there is none.

    >>> from math import exp
    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> cycle = read_grammar("S -> S [0.5] | a [0.25] | b [0.25]")
    >>> round(exp(log_probability(cycle, ["a"])), 6)
    0.5
    """
    compiled = compiled_form(grammar)
    symbols = numbered(compiled, sentence)
    if (symbols < 0).any():
        return -inf
    return _inside(compiled, symbols, SUM).log_weight(compiled.start)


def count_trees(grammar: AnyGrammar, sentence: Sequence[str]) -> int | float:
    """Count the trees of a sentence: exact below 2^53, to 53 bits above, perhaps infinite.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> count_trees(read_grammar("S -> S S | a"), ["a"] * 5)
    14
    """
    compiled = compiled_form(grammar)
    symbols = numbered(compiled, sentence)
    if (symbols < 0).any():
        return 0
    value, exponent = find(_inside(compiled, symbols, COUNT), compiled.start, 0, len(symbols))
    if value == inf:
        return inf
    digits = 0 if value == int(value) else 60
    whole = int(ldexp(value, digits))
    shift = int(exponent) - digits
    return whole << shift if shift >= 0 else whole >> -shift


def explain(grammar: AnyGrammar, sentence: Sequence[str]) -> ParseError | None:
    """Return where and why a sentence fails, None if it does not.

    The place is that of the first symbol that cannot follow the symbols before it in any string of
    the grammar.
    """
    prefix = read_sentence(grammar, sentence)
    if prefix.position == len(sentence) and prefix.end > 0:
        return None
    return fault_at(compiled_form(grammar), tuple(sentence), prefix)


@dataclass(frozen=True, eq=False)
class ViablePrefix:
    """How far a sentence can be read from left to right, and the symbols that can occur there."""

    position: int  # Number of symbols that were read
    # (terminals,): times two to the ``exponent``: probability that a string begins with these
    # symbols and the terminal
    weights: FloatArray
    end: float  # Times two to the ``exponent``: probability that a string ends there
    exponent: int


def read_sentence(grammar: AnyGrammar, sentence: Sequence[str]) -> ViablePrefix:
    """Read a sentence, or a prefix of one, as far as it agrees with strings of the grammar."""
    compiled = compiled_form(grammar)
    symbols = numbered(compiled, sentence)
    unknown = np.flatnonzero(symbols < 0)
    known = symbols[: unknown[0]] if len(unknown) else symbols
    made = _inside(compiled, known, SUM)
    weights, exponents = forward(
        made, compiled.start, compiled.by_left, compiled.right, _corners(compiled)
    )
    position = 0
    while position < len(known) and weights[position, known[position]] > 0:
        position += 1
    value, exponent = find(made, compiled.start, 0, position)
    scale = int(exponents[position])
    may = weights[position, compiled.terminals]
    if not may.any():
        return ViablePrefix(position, may, value, int(exponent))
    return ViablePrefix(position, may, ldexp(value, int(exponent) - scale), scale)


@lru_cache(maxsize=16)
def _corners(compiled: CompiledGrammar) -> Sparse:
    """Return the chains between a state that nothing stays in and one that everything stays in."""
    return compiled.chains(SUM, compiled.empties, compiled.ends)


def fault_at(
    compiled: CompiledGrammar, sentence: tuple[str, ...], prefix: ViablePrefix
) -> ParseError:
    """Return the error that says where a sentence stops being a viable prefix."""
    terminals = compiled.names[compiled.terminals]
    expected = tuple(t for t, weight in zip(terminals, prefix.weights) if weight > 0)
    may_end = prefix.end > 0
    message = _say(compiled, sentence, prefix.position, expected, may_end)
    symbol = sentence[prefix.position] if prefix.position < len(sentence) else None
    return ParseError(message, prefix.position, symbol, expected, may_end)


END = None  # The end of the sentence among suggestions


def suggest(grammar: AnyGrammar, prefix: Sequence[str]) -> tuple[tuple[str | None, float], ...]:
    r"""Return the terminals that may come next, and the end (None), with their probabilities.

    Most probable first; equal ones in the grammar's order, the end after them. The probabilities
    sum to 1.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> toy = read_grammar("S -> hold A\nA -> dribble A [0.5] | shoot [0.3] | empty [0.2]")
    >>> [(symbol, round(p, 4)) for symbol, p in suggest(toy, ["hold", "dribble"])]
    [('dribble', 0.5), ('shoot', 0.3), (None, 0.2)]
    """
    compiled = compiled_form(grammar)
    viable = read_sentence(compiled, prefix)
    if viable.position < len(prefix):
        raise fault_at(compiled, tuple(prefix), viable)
    names = compiled.names[compiled.terminals]
    pairs: list[tuple[str | None, float]] = [*zip(names, viable.weights.tolist(), strict=True)]
    pairs.append((END, viable.end))
    total = sum(weight for _, weight in pairs)
    possible = [(name, weight / total) for name, weight in pairs if weight > 0]
    return tuple(sorted(possible, key=lambda pair: -pair[1]))


def prefix_log_probability(grammar: AnyGrammar, prefix: Sequence[str]) -> float:
    """Return the log-probability that a sentence begins with a prefix; -inf if none does.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> left = read_grammar("S -> S a [0.5] | b [0.5]")
    >>> round(prefix_log_probability(left, ["b", "a"]) / log(0.5), 4)
    1.0
    """
    compiled = compiled_form(grammar)
    viable = read_sentence(compiled, prefix)
    total = float(viable.weights.sum()) + viable.end
    if viable.position < len(prefix) or total <= 0:
        return -inf
    whole = compiled.ends[compiled.start]
    return log(total) + viable.exponent * log(2.0) - log(whole)


def best_strings(
    grammar: AnyGrammar, n: int, *, steps: int | float = inf
) -> Iterator[tuple[tuple[str, ...], float]]:
    """Yield the most probable strings with their log-probabilities, given that derivations end.

    Equal ones come in the order of the grammar's terminals. A finite language is yielded
    completely.

    `steps`: Bound on the number of prefixes that are extended; the search may then stop before the
    n-th string.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> toy = read_grammar("S -> a S [0.6] | b [0.4]")
    >>> ["".join(string) for string, _ in best_strings(toy, 3)]
    ['b', 'ab', 'aab']
    """
    compiled = compiled_form(grammar)
    order = count()
    agenda: list[tuple[float, int, tuple[str, ...], bool]] = [(0.0, next(order), (), False)]
    n_yielded = n_extended = 0
    while agenda and n_yielded < n:
        cost, _, string, complete = heappop(agenda)
        if complete:
            n_yielded += 1
            yield string, -cost
            continue
        n_extended += 1
        if n_extended > steps:
            return
        for symbol, chance in suggest(compiled, string):
            longer = string if symbol is None else (*string, symbol)
            heappush(agenda, (cost - log(chance), next(order), longer, symbol is None))


def passage_grammar(grammar: Grammar) -> Grammar:
    """Return the grammar of passages: sentences one after another, without marks between them.

    For a grammar with the start symbol S, the passages are the strings of P -> S P | S. The two
    rules come last, so that the rules of the grammar keep their numbers.
    """
    name = f"{grammar.start}+"
    while name in grammar.nonterminals or name in grammar.terminals:
        name += "+"
    rules = (Rule(name, (grammar.start, name), 0.5), Rule(name, (grammar.start,), 0.5))
    return Grammar(name, (*grammar.rules, *rules), grammar.terminals)


def parse_passage(grammar: Grammar, string: Sequence[str]) -> tuple[Tree, ...]:
    r"""Return the most probable sentences of a passage, each with its tree.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> toy = read_grammar("S -> a B\nB -> b | c c")
    >>> [" ".join(tree.leaves()) for tree in parse_passage(toy, "a b a c c".split())]
    ['a b', 'a c c']
    """
    tree = parse(passage_grammar(grammar), string)
    sentences = [tree.children[0]]
    while len(tree.children) == 2:
        tree = tree.children[1]
        sentences.append(tree.children[0])
    return tuple(sentences)


def _inside(compiled: CompiledGrammar, symbols: IntArray, kind: int) -> Inside:
    """Return the weights of all parts of a sentence of known terminals."""
    numbers = symbols - compiled.n_nonterminals
    return inside(compiled, automata.sentence(numbers, len(compiled.ids)), kind)


def _say(
    compiled: CompiledGrammar,
    sentence: tuple[str, ...],
    position: int,
    expected: tuple[str, ...],
    may_end: bool,
) -> str:
    """Write the message of a parse error."""
    options = [*expected[:_SHOWN], *(["the end"] if may_end else [])]
    wanted = f"one of {', '.join(options)}" if len(options) > 1 else "".join(options) or "nothing"
    if len(expected) > _SHOWN:
        wanted += f" and {len(expected) - _SHOWN} more"
    if position == len(sentence):
        last = f" (after symbol {position - 1}, {sentence[-1]!r})" if sentence else ""
        where = f"end of the sentence{last}"
        what = "one of them" if len(options) > 1 else "it"
        return f"{where}: expected {wanted}, found the end. Go on with {what}."
    symbol = sentence[position]
    where = f"symbol {position} ({symbol!r})"
    if symbol in compiled.ids:
        advice = " Put another symbol there, or learn the rules from sentences that hold this one."
        return f"{where}: expected {wanted}, found {symbol}.{advice}"
    if compiled.grammar.is_nonterminal(symbol):
        kind, advice = "a nonterminal", " A sentence holds terminals only."
    else:
        kind = "a symbol that the grammar does not know"
        advice = suggestion(symbol, compiled.ids) or " Use a terminal of the grammar."
    return f"{where}: expected {wanted}, found {symbol}, {kind}.{advice}"


@maker
def forward(
    made: Inside, start: int, by_left: Tails, right: IntArray, corners: Sparse
) -> tuple[FloatArray, IntArray]:
    """Differentiate: the weight of each next symbol at each place of a sentence.

    To the automaton of a sentence, let each state have an edge of every terminal to one more state,
    which stays on anything. The derivative of W(start) of the longer automaton by one of its edges
    is the weight of all strings that begin with the symbols before the place and go on with this
    terminal (F. Jelinek and J. D. Lafferty, 1991). Only the column of the new state counts: a tail
    Y Z that is needed from i on passes its derivative to Z from k on, times W(Y, i, k).

    Parameters
    ----------
    made : Inside
        The sums of a sentence.
    start : int
        The start symbol.
    by_left : Tails
        Tails by their left child.
    right : array (S,)
        Right child of a tail.
    corners : Sparse
        The chains between a state that nothing stays in and one that everything stays in.

    Returns
    -------
    weights : array (Q, S)
        For a terminal t, ``weights[i, t]`` times two to the exponent is the weight of strings that
        begin with the first i symbols and t.
    exponents : array (Q,)
        The exponents.
    """
    n, n_symbols = len(made.loops), len(right)
    needed, scale = np.zeros((n, n_symbols)), np.zeros(n, np.int64)
    seen, weights = np.zeros(n, np.bool_), np.zeros((n, n_symbols))
    needed[0, start] = 1.0
    for i in range(n):
        scale[i] += _descend(needed[i], weights[i], corners)
        for k in range(i + 1, n):
            exponent = scale[i] + made.exponents[i, k]
            for entry in range(made.begin[i, k], made.end[i, k]):
                symbol, value = made.symbols[entry], made.values[entry]
                for tail in by_left.tails[by_left.starts[symbol] : by_left.starts[symbol + 1]]:
                    if weights[i, tail] == 0.0:
                        continue
                    if not seen[k]:
                        seen[k], scale[k] = True, exponent
                    elif exponent > scale[k]:
                        _scale(needed[k], scale[k] - exponent)
                        scale[k] = exponent
                    part = weights[i, tail] * value
                    needed[k, right[tail]] += part * ldexp(1.0, exponent - scale[k])
    return weights, scale


@kernel
def _descend(needed: FloatArray, weights: FloatArray, corners: Sparse) -> int:
    """Follow the chains from the symbols above down to all below; return their power of two."""
    greatest = 0.0
    for value in needed:
        greatest = max(greatest, value)
    shift = frexp(greatest)[1] if greatest > 0.0 else 0
    _scale(needed, -shift)
    for symbol in range(len(needed)):
        for c in range(corners.starts[symbol], corners.starts[symbol + 1]):
            weights[symbol] += corners.values[c] * needed[corners.columns[c]]
    return shift


@kernel
def _scale(values: FloatArray, exponent: int) -> None:
    """Multiply values by a power of two."""
    for symbol in range(len(values)):
        values[symbol] = ldexp(values[symbol], exponent)
