"""Questions about pairs of terminals, and grammars that keep to the answers.

A question asks whether a terminal can come straight after another (or after itself: a repetition).
Ten questions of all pairs are asked about what is missed most: of the pairs (a, b) that were
observed at most once, those that the smoothed pairs expect most often,

    n_a P(b | a)

A *no* is worth nearly so many nats. Of 11 ways to order pairs none let answers raise foresight more
(``docs/measured/grammar.md``); by the bits of an answer times the number of shuffles that it
concerns they raised it half as much.

An answer is a constraint of the next learning. *Yes* adds an example: a sentence up to a, followed
by another from b on. *No* removes all strings with the pair from the language, exactly
(:func:`without_pairs`). In smoothed pairs, yes counts as two observations, and no divides the
chance by twenty: people err.

Source: Y. Bar-Hillel, M. Perles and E. Shamir, "On formal properties of simple phrase structure
grammars", Zeitschrift für Phonetik 14 (1961), for the intersection with a regular language.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import count, pairwise
from math import prod

import numpy as np

from motiondb.grammar.cfg.automata import from_steps
from motiondb.grammar.cfg.compiled import compile_grammar
from motiondb.grammar.cfg.context_free import Grammar, GrammarError, Rule
from motiondb.grammar.cfg.inside import inside
from motiondb.grammar.foresight import Pairs, String, Take, passage

Pair = tuple[str, str]
MOST_RULES = 2_000  # Largest number of rules that a grammar without pairs may have
_Key = tuple[str, int, int]
"""A symbol, and the states of an automaton before and after its strings."""


@dataclass(frozen=True)
class PairQuestion:
    """Whether ``then`` can come straight after ``first``; ``gain`` orders the questions."""

    first: str
    then: str
    observed: int  # How often it does in the captures
    gain: float  # How often the smoothed pairs expect it


def find_questions(
    takes: Sequence[Take],
    terminals: Sequence[str],
    answered: Collection[Pair] = (),
    n: int = 10,
    repetitions: bool = True,
) -> list[PairQuestion]:
    """Return the questions about what is missed most; see the module."""
    pairs = Pairs([passage(take) for take in takes], terminals)
    found = []
    for a in pairs.singles:
        for b in pairs.singles:
            observed = pairs.pairs[a, b]
            if observed > 1 or (a, b) in answered or (a == b and not repetitions):
                continue
            found.append(PairQuestion(a, b, observed, pairs.singles[a] * pairs.chance(b, a)))
    return sorted(found, key=lambda one: (-one.gain, one.first, one.then))[:n]


def spliced(sentences: Sequence[String], yes: Collection[Pair]) -> list[String]:
    """Return an example of each pair: the shortest sentence up to its first, another from its then.

    >>> spliced([tuple("xay"), tuple("cbz")], [("a", "b")])
    [('x', 'a', 'b', 'z')]
    """
    examples = []
    for first, then in sorted(yes):
        heads = [s[: n + 1] for s in sentences for n, symbol in enumerate(s) if symbol == first]
        tails = [s[n:] for s in sentences for n, symbol in enumerate(s) if symbol == then]
        if heads and tails and not any((first, then) in pairwise(s) for s in sentences):
            examples.append(min(heads, key=len) + min(tails, key=len))
    return examples


def without_pairs(grammar: Grammar, no: Collection[Pair]) -> Grammar:
    """Return the grammar of the strings without the pairs; chances are those given that.

    An automaton remembers the last terminal, as far as pairs distinguish it. Each nonterminal is
    divided by the states before and after its strings (:mod:`.cfg.inside`). GrammarError: no string
    is left, or rules become too many.

    >>> from motiondb.grammar.cfg.context_free import format_grammar, read_grammar
    >>> toy = read_grammar("S -> A B" + chr(10) + "A -> a [0.5] | b [0.5]" + chr(10) + "B -> c | d")
    >>> print(format_grammar(without_pairs(toy, [("a", "d")])))
    S -> A B [0.6667] | A_2 B_2 [0.3333]
    A -> b
    B -> c [0.5] | d [0.5]
    A_2 -> a
    B_2 -> c
    """
    if not no:
        return grammar
    last = ["", *sorted({first for first, _ in no})]
    chance = _chances(grammar, no, last)
    order = [key for t in range(len(last)) if chance(key := (grammar.start, 0, t)) > 0.0]
    if not order:
        raise GrammarError(
            "answers: expected pairs that leave a sentence, found none left. Answer less with no."
        )
    names, n_starts = dict[_Key, str](), len(order)
    taken = {*grammar.nonterminals, *grammar.terminals}
    found: list[tuple[_Key, tuple[_Key, ...], float]] = []
    for key in order:  # which grows
        free = (name for n in count(2) if (name := f"{key[0]}_{n}") not in taken)
        names[key] = next(free) if key[0] in names.values() else key[0]
        taken.add(names[key])
        for rule in (rule for rule in grammar.rules if rule.left == key[0]):
            for right in _ways(rule.right, key[1], key[2], len(last), chance):
                share = rule.probability * prod(map(chance, right)) / chance(key)
                found.append((key, right, share))
                new = (part for part in right if grammar.is_nonterminal(part[0]))
                order += [part for part in dict.fromkeys(new) if part not in order]
                if len(found) > MOST_RULES:
                    raise GrammarError(
                        f"answers: expected at most {MOST_RULES} rules that keep to them, found"
                        " more. Answer less with no."
                    )
    rules = [
        Rule(names[key], tuple(names.get(part, part[0]) for part in right), share)
        for key, right, share in found
    ]
    if n_starts == 1:
        return Grammar(names[order[0]], tuple(rules), grammar.terminals)
    start = next(name for n in count(1) if (name := grammar.start + "'" * n) not in taken)
    total = sum(map(chance, order[:n_starts]))
    tops = [Rule(start, (names[key],), chance(key) / total) for key in order[:n_starts]]
    return Grammar(start, (*tops, *rules), grammar.terminals)


def _chances(
    grammar: Grammar, no: Collection[Pair], last: Sequence[str]
) -> Callable[[_Key], float]:
    """Return the chance that a symbol leads from one last terminal to another without the pairs."""
    compiled = compile_grammar(grammar)
    number = {name: n for n, name in enumerate(compiled.names)}
    after = {t: last.index(t) if t in last else 0 for t in grammar.terminals}
    read = compiled.names[compiled.terminals]
    steps = np.zeros((len(last), len(read), len(last)), dtype=bool)
    for s, k in np.ndindex(steps.shape[:2]):
        steps[s, k, after[read[k]]] = (last[s], read[k]) not in no
    final, bounds = np.ones(len(last), dtype=bool), np.array([0, len(last)])
    made = inside(compiled, from_steps(steps, final, bounds))

    @cache
    def chance(key: _Key) -> float:
        symbol, s, t = key
        if not grammar.is_nonterminal(symbol):
            return float(t == after[symbol] and (last[s], symbol) not in no)
        return made.weight(number[symbol], s, t) if symbol in number else 0.0

    return chance


def _ways(
    right: String, s: int, t: int, n_states: int, chance: Callable[[_Key], float]
) -> Iterator[tuple[_Key, ...]]:
    """Yield the parts of a right side by which it leads from state s to t."""
    if not right:
        if s == t:
            yield ()
        return
    for u in range(n_states):
        part = right[0], s, u
        if chance(part) > 0.0:
            yield from ((part, *rest) for rest in _ways(right[1:], u, t, n_states, chance))
