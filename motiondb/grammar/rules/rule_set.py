"""Rules that count how often they are used: what induction works on, and what it may never break.

A rule set holds, for each nonterminal, its right sides with the number of nodes that use each in
the trees of the sentences. Everything that the description length asks for can be read from it: a
node of a nonterminal with h rules costs log2 h bits, so the sentences cost the sum over
nonterminals of nodes times log2 h. Trees themselves need not be kept.

Four laws keep the language sensible where there are few examples:

* no nonterminal derives itself (*acyclic*), so that no part is repeated without end;
* a terminal that stands equally often in every sentence keeps that number (*constant*): one shot
  in each basketball sentence means one shot in each derived one;
* a terminal of ten sentences or more that never stands twice in one stays at that (*single*);
* a nonterminal that may be empty does not stand beside itself, for one sentence would then be
  derived in several ways, and bits spent on saying in which. A search may also go without empty
  right sides altogether.

Symbols are numbers: terminals 0..T-1, the start symbol T, further nonterminals above.

Source: description length from J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures
from Human Motion Data", Computer Graphics Forum 30 (2011), section 5.1; the laws are ours, against
the cyclic references that section 7 reports.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from motiondb.grammar.cfg.context_free import Grammar, Rule

ENOUGH = 10
"""Sentences that must hold a terminal, none of them twice, before it counts as single."""

Right = tuple[int, ...]
Rules = dict[int, dict[Right, int]]


@dataclass
class RuleSet:
    """``rules[left][right]`` is the number of nodes; ``constants`` terminal -> its fixed number.

    ``empties`` : whether right sides may be empty; ``singles`` : the terminals that no string may
    hold twice.
    """

    n_terminals: int
    rules: Rules
    constants: Mapping[int, int] = field(default_factory=dict)
    empties: bool = True
    singles: frozenset[int] = frozenset()

    @property
    def start(self) -> int:
        """The start symbol."""
        return self.n_terminals

    def copy(self) -> RuleSet:
        """Return a rule set of its own, the laws shared."""
        rules = {left: dict(rights) for left, rights in self.rules.items()}
        return RuleSet(self.n_terminals, rules, self.constants, self.empties, self.singles)

    def bits(self) -> float:
        """Return the description length of grammar and sentences."""
        n_rules = symbols = 0
        sentences = 0.0
        for rights in self.rules.values():
            h = len(rights)
            n_rules += h
            symbols += sum(map(len, rights))
            if h > 1:
                sentences += sum(rights.values()) * math.log2(h)
        alphabet = len(self.rules) + self.n_terminals + 1
        return (symbols + 2 * n_rules - 1) * math.log2(alphabet) + sentences

    def add(self, left: int, right: Right, count: int) -> None:
        """Count more nodes of a rule, a new one perhaps."""
        rights = self.rules.setdefault(left, {})
        rights[right] = rights.get(right, 0) + count

    def uses(self) -> Iterator[tuple[int, Right]]:
        """All rules."""
        for left, rights in self.rules.items():
            for right in rights:
                yield left, right

    def references(self) -> Counter[int]:
        """How often each symbol stands in right sides."""
        return Counter(symbol for _, right in self.uses() for symbol in right)

    def rename(self, names: Mapping[int, int]) -> None:
        """Replace symbols everywhere; rules that become equal are one, their nodes added."""
        old, self.rules = self.rules, {}
        for left, rights in old.items():
            for right, count in rights.items():
                renamed = tuple(names.get(symbol, symbol) for symbol in right)
                new_left = names.get(left, left)
                if renamed != (new_left,):
                    self.add(new_left, renamed, count)

    def drop_unused(self) -> None:
        """Take away the nonterminals that no rule uses."""
        while True:
            references = self.references()
            idle = [left for left in self.rules if left != self.start and not references[left]]
            if not idle:
                return
            for left in idle:
                del self.rules[left]

    def order(self) -> list[int] | None:
        """Nonterminals, each before those in its rules; None where one derives itself."""
        waiting = dict.fromkeys(self.rules, 0)
        for _, right in self.uses():
            for symbol in right:
                if symbol in waiting:
                    waiting[symbol] += 1
        ready = [left for left, number in waiting.items() if number == 0]
        found = []
        while ready:
            left = ready.pop()
            found.append(left)
            for right in self.rules[left]:
                for symbol in right:
                    if symbol in waiting:
                        waiting[symbol] -= 1
                        if waiting[symbol] == 0:
                            ready.append(symbol)
        return found if len(found) == len(self.rules) else None

    def lawful(self) -> bool:
        """Whether the rules keep all laws."""
        order = self.order()
        if order is None or (not self.empties and any(not right for _, right in self.uses())):
            return False
        order.reverse()
        if self._empty_beside_itself(order) or not self._keeps_constants(order):
            return False
        return self._keeps_singles(order)

    def _empty_beside_itself(self, order: list[int]) -> bool:
        nullable: set[int] = set()
        for left in order:
            if any(nullable.issuperset(right) for right in self.rules[left]):
                nullable.add(left)
        return bool(nullable) and any(
            one == other and one in nullable
            for _, right in self.uses()
            for one, other in itertools.pairwise(right)
        )

    def _keeps_constants(self, order: list[int]) -> bool:
        if not self.constants:
            return True
        numbers: dict[int, Right] = {
            symbol: tuple(int(symbol == terminal) for terminal in self.constants)
            for symbol in range(self.n_terminals)
        }
        none = (0,) * len(self.constants)
        for left in order:
            found = {
                tuple(map(sum, zip(none, *(numbers[symbol] for symbol in right))))
                for right in self.rules[left]
            }
            if len(found) != 1:
                return False
            numbers[left] = found.pop()
        return numbers[self.start] == tuple(self.constants.values())

    def _keeps_singles(self, order: list[int]) -> bool:
        held = {symbol: {symbol} & self.singles for symbol in range(self.n_terminals)}
        for left in order:
            held[left] = set()
            for right in self.rules[left]:
                found = [terminal for symbol in right for terminal in held[symbol]]
                if len(found) != len(set(found)):
                    return False
                held[left] |= set(found)
        return True


def constant_terminals(sentences: Mapping[Right, int]) -> dict[int, int]:
    """Return the terminals that stand equally often, at least once, in two or more sentences.

    >>> constant_terminals({(0, 1, 2): 1, (0, 1, 1): 3})
    {0: 1}
    """
    if len(sentences) < 2:
        return {}
    tables = [Counter(sentence) for sentence in sentences]
    return {
        terminal: number
        for terminal, number in sorted(tables[0].items())
        if all(table[terminal] == number for table in tables)
    }


def single_terminals(sentences: Mapping[Right, int]) -> frozenset[int]:
    """Return the terminals that at least ten sentences hold, and none twice.

    Where n sentences hold a terminal and none twice, at most some 3 / n of all such sentences do
    (19 times in 20), so fewer say little. A compiled search keeps singles as bits of one number,
    so there are at most 62, the commonest. Sentences that are told again count again.

    >>> sorted(single_terminals({(0, 1, 2): 4, (0, 1, 1): 6, (0, 2): 5}))
    [0]
    """
    most: Counter[int] = Counter()
    standing: Counter[int] = Counter()
    for sentence, told in sentences.items():
        for terminal, number in Counter(sentence).items():
            most[terminal] = max(most[terminal], number)
            standing[terminal] += told
    found = [t for t in sorted(most) if most[t] == 1 and standing[t] >= ENOUGH]
    return frozenset(sorted(found, key=lambda terminal: -standing[terminal])[:62])


def flat_rules(
    sentences: Mapping[Right, int], n_terminals: int, *, empties: bool = True
) -> RuleSet:
    """One rule for each different sentence, in their order."""
    rights = {sentence: sentences[sentence] for sentence in sorted(sentences)}
    constants, singles = constant_terminals(sentences), single_terminals(sentences)
    return RuleSet(n_terminals, {n_terminals: rights}, constants, empties, singles)


def as_grammar(rule_set: RuleSet, names: Sequence[str]) -> Grammar:
    """Nonterminals S, A, B, ... in the order in which the rules, from the start symbol, name them.

    Alternatives stand in the order of how often they are used, then of their symbols' names.
    """
    labels = nonterminal_names(names)
    called: dict[int, str] = {rule_set.start: next(labels)}
    waiting = [rule_set.start]
    ordered: list[tuple[int, list[Right]]] = []
    for left in waiting:
        rights = rule_set.rules[left]
        chosen = sorted(
            rights, key=lambda right: (-rights[right], [s >= len(names) for s in right], right)
        )
        ordered.append((left, chosen))
        for symbol in (symbol for right in chosen for symbol in right):
            if symbol in rule_set.rules and symbol not in called:
                called[symbol] = next(labels)
                waiting.append(symbol)
    rules = [
        Rule(
            called[left],
            tuple(called[s] if s in called else names[s] for s in right),
        )
        for left, rights in ordered
        for right in rights
    ]
    return Grammar(called[rule_set.start], tuple(rules), tuple(names))


def nonterminal_names(terminals: Sequence[str]) -> Iterator[str]:
    """S, then A to Z without S, then A1, B1, ...: none the name of a terminal.

    >>> names = nonterminal_names(["a", "B"])
    >>> [next(names) for _ in range(4)]
    ['S', 'A', 'C', 'D']
    """
    taken = set(terminals)
    letters = "ABCDEFGHIJKLMNOPQRTUVWXYZ"
    start = "S"
    while start in taken:
        start += "'"
    yield start
    number = 0
    while True:
        for letter in letters:
            name = f"{letter}{number or ''}"
            if name not in taken:
                yield name
        number += 1
