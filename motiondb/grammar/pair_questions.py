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

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from motiondb.grammar.cfg.context_free import Grammar, GrammarError, Rule
from motiondb.grammar.foresight import Pairs, String, Take, passage

Pair = tuple[str, str]
MOST_RULES = 2_000  # Largest number of rules that a grammar without pairs may have
_ROUNDS = 200  # Rounds in which the chances of nonterminals without the pairs are found
_Ends = tuple[str, str] | None
"""First and last terminal of a string, "" for one that no pair has; None for the empty string."""


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

    Each nonterminal is divided by the first and last terminal of its strings, as far as pairs
    distinguish them. GrammarError: no string is left, or rules become too many.

    >>> from motiondb.grammar.cfg.context_free import format_grammar, read_grammar
    >>> toy = read_grammar("S -> A B" + chr(10) + "A -> a [0.5] | b [0.5]" + chr(10) + "B -> c | d")
    >>> print(format_grammar(without_pairs(toy, [("a", "d")])))
    S -> A B [0.3333] | A_2 B [0.3333] | A_2 B_2 [0.3333]
    A -> a
    B -> c
    A_2 -> b
    B_2 -> d
    """
    if not no:
        return grammar
    parts = _Division(grammar, frozenset(no))
    while parts.grow():
        pass
    chances = parts.chances()
    starts = [key for key in parts.rules if key[0] == grammar.start and chances[key] > 0.0]
    if not starts:
        raise GrammarError(
            "answers: expected pairs that leave a sentence, found none left. Answer less with no."
        )
    names = parts.names()
    rules = [
        Rule(names[key], tuple(names.get(part, part[0]) for part in right), share / chances[key])
        for key in _from_starts(starts, parts)
        for right, share in parts.shares(key, chances)
        if share > 0.0 and chances[key] > 0.0
    ]
    if len(starts) == 1:
        return Grammar(names[starts[0]], tuple(rules), grammar.terminals)
    total = sum(chances[key] for key in starts)
    taken = {*names.values(), *grammar.terminals}
    start = f"{grammar.start}'"
    while start in taken:
        start += "'"
    tops = [Rule(start, (names[key],), chances[key] / total) for key in starts]
    return Grammar(start, (*tops, *rules), grammar.terminals)


_Key = tuple[str, _Ends]
"""A symbol and the ends of its strings."""


class _Division:
    """Nonterminals divided by the ends of their strings, with their rules."""

    def __init__(self, grammar: Grammar, no: frozenset[Pair]) -> None:
        self.grammar, self.no = grammar, no
        self.firsts = {a for a, _ in no}
        self.thens = {b for _, b in no}
        self.rules: dict[_Key, dict[tuple[int, tuple[_Key, ...]], float]] = {}

    def grow(self) -> bool:
        """Add the rules that the known parts allow; whether some were new."""
        known: dict[str, list[_Ends]] = {}
        for symbol, ends in self.rules:
            known.setdefault(symbol, []).append(ends)
        new = False
        for number, rule in enumerate(self.grammar.rules):
            for ends, right in self._ways(rule.right, known):
                of_part = self.rules.setdefault((rule.left, ends), {})
                if (number, right) not in of_part:
                    of_part[number, right] = rule.probability
                    new = True
        if sum(map(len, self.rules.values())) > MOST_RULES:
            raise _too_many()
        return new

    def _ways(
        self, right: String, known: dict[str, list[_Ends]]
    ) -> Iterator[tuple[_Ends, tuple[_Key, ...]]]:
        """Yield the ends of a right side and its parts, wherever no pair is formed."""
        ways: dict[tuple[_Key, ...], _Ends] = {(): None}
        for symbol in right:
            own: list[_Ends] = (
                known.get(symbol, [])
                if self.grammar.is_nonterminal(symbol)
                else [
                    (
                        symbol if symbol in self.thens else "",
                        symbol if symbol in self.firsts else "",
                    )
                ]
            )
            longer: dict[tuple[_Key, ...], _Ends] = {}
            for parts, before in ways.items():
                for ends in own:
                    if before is None or ends is None:
                        longer[*parts, (symbol, ends)] = before or ends
                    elif (before[1], ends[0]) not in self.no:
                        longer[*parts, (symbol, ends)] = (before[0], ends[1])
            ways = longer
            if len(ways) > MOST_RULES:
                raise _too_many()
        for parts, ends in ways.items():
            if len(parts) == len(right):
                yield ends, parts

    def chances(self) -> dict[_Key, float]:
        """The chance of each part: that its symbol derives a string with its ends."""
        chances = dict.fromkeys(self.rules, 0.0)
        for _ in range(_ROUNDS + len(self.rules)):  # at least as often as rules lie one in another
            before = chances
            chances = {key: sum(s for _, s in self.shares(key, before)) for key in self.rules}
            if all(abs(chances[key] - before[key]) <= 1e-15 for key in chances):
                break
        return chances

    def shares(
        self, key: _Key, chances: dict[_Key, float]
    ) -> Iterator[tuple[tuple[_Key, ...], float]]:
        """Yield the right sides of a part with their chances."""
        for (_, right), probability in self.rules[key].items():
            share = probability
            for part in right:
                share *= chances.get(part, 0.0) if self.grammar.is_nonterminal(part[0]) else 1.0
            yield right, share

    def names(self) -> dict[_Key, str]:
        """A name for each part: that of its symbol for the first, then X_2, X_3, ..."""
        taken = {*self.grammar.nonterminals, *self.grammar.terminals}
        names: dict[_Key, str] = {}
        seen: set[str] = set()
        for key in self.rules:
            name, number = key[0], 1
            while name in (taken if number > 1 else seen):
                number += 1
                name = f"{key[0]}_{number}"
            seen.add(name)
            taken.add(name)
            names[key] = name
        return names


def _too_many() -> GrammarError:
    return GrammarError(
        f"answers: expected at most {MOST_RULES} rules that keep to them, found more."
        " Answer less with no."
    )


def _from_starts(starts: Sequence[_Key], parts: _Division) -> list[_Key]:
    """The parts that the start symbol reaches, in order of first use."""
    order = dict.fromkeys(starts)
    waiting = list(starts)
    while waiting:
        for _, right in parts.rules[waiting.pop(0)]:
            for part in right:
                if part in parts.rules and part not in order:
                    order[part] = None
                    waiting.append(part)
    return list(order)
