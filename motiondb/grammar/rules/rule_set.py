"""Rule sets: rules with counts of their use, as induction changes them, and laws they must keep.

A rule set holds the right sides of each nonterminal. With each right side it holds the number of
nodes that use it in the trees of the sentences. This is enough for the description length: a node
of a nonterminal with h rules costs log2 h bits, so the sentences cost the sum over nonterminals of
nodes times log2 h. The trees themselves are not kept.

Laws limit generalization if there are few examples:

* *loops*: unless loops are allowed, no nonterminal derives a string that holds itself, so nothing
  repeats without end. If they are allowed, every nonterminal derives a string of terminals and is
  reached from the start symbol, and none derives itself alone, so that every string has finitely
  many trees. Whether the sentences support a loop is not a law of the rules
  (:mod:`motiondb.grammar.induction.loop_evidence`);
* *constant*: a terminal that occurs equally often in every sentence keeps this number. One shot
  in each basketball sentence means one shot in each derived sentence;
* *single*: a terminal that at least ten sentences hold, and none twice, occurs at most once;
* *start*: no string is empty, because no sentence is;
* a nonterminal that may be empty does not occur next to itself. Otherwise one sentence has several
  derivations, and bits are spent on the choice between them. A search may also forbid all empty
  right sides.

Symbols are numbers: terminals are 0..T-1, the start symbol is T, other nonterminals are above T.

Source: J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from Human Motion Data",
Computer Graphics Forum 30 (2011), section 5.1, for the description length. The laws are specific to
motiondb; they prevent the cyclic references that section 7 reports.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from motiondb.grammar.cfg.closure import strong_components
from motiondb.grammar.cfg.context_free import Grammar, Rule

Right = tuple[int, ...]
Rules = dict[int, dict[Right, int]]

ENOUGH = 10
"""Sentences that must hold a terminal, none of them twice, before it counts as single. At 10 the
bound of :func:`single_terminals` is 3 / 10."""


@dataclass
class RuleSet:
    """Rules with counts, and the laws that they must keep."""

    n_terminals: int  # Number of terminals, T; this is also the number of the start symbol
    rules: Rules  # ``rules[left][right]`` is the number of nodes that use the rule
    # Terminals that occur equally often in every string, each with this number
    constants: Mapping[int, int] = field(default_factory=dict)
    empties: bool = True  # Whether right sides may be empty
    singles: frozenset[int] = frozenset()  # Terminals that no string may hold twice
    loops: bool = False  # Whether a nonterminal may derive a string that holds itself

    @property
    def start(self) -> int:
        """The number of the start symbol."""
        return self.n_terminals

    def copy(self) -> RuleSet:
        """Return a copy with separate rules; the laws are shared."""
        return self.with_rules({left: dict(rights) for left, rights in self.rules.items()})

    def with_rules(self, rules: Rules) -> RuleSet:
        """Return a rule set of other rules with the same laws."""
        return replace(self, rules=rules)

    def bits(self) -> float:
        """Return the description length of rules and sentences, in bits."""
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
        """Add nodes to a rule; create the rule if it is new."""
        rights = self.rules.setdefault(left, {})
        rights[right] = rights.get(right, 0) + count

    def uses(self) -> Iterator[tuple[int, Right]]:
        """Yield the left and the right side of each rule."""
        for left, rights in self.rules.items():
            for right in rights:
                yield left, right

    def references(self) -> Counter[int]:
        """Return how often each symbol occurs in right sides."""
        return Counter(symbol for _, right in self.uses() for symbol in right)

    def rename(self, names: Mapping[int, int]) -> None:
        """Replace symbols in all rules.

        Rules that become equal are merged and their counts added. A rule that becomes X -> X is
        removed.
        """
        old, self.rules = self.rules, {}
        for left, rights in old.items():
            for right, count in rights.items():
                renamed = tuple(names.get(symbol, symbol) for symbol in right)
                new_left = names.get(left, left)
                if renamed != (new_left,):
                    self.add(new_left, renamed, count)

    def without_idle_start(self) -> RuleSet:
        """Return the rules with S for A if the only rule of the start symbol S is S -> A.

        >>> RuleSet(2, {2: {(3,): 1}, 3: {(0, 3, 1): 1, (0, 1): 1}}).without_idle_start().rules
        {2: {(0, 2, 1): 1, (0, 1): 1}}
        """
        only = next(iter(self.rules[self.start]))
        if len(self.rules[self.start]) > 1 or len(only) != 1 or only[0] not in self.rules:
            return self
        changed = self.copy()
        changed.rename({only[0]: self.start})
        return changed

    def drop_unused(self) -> None:
        """Remove the nonterminals that no right side holds, until none is left."""
        while True:
            references = self.references()
            idle = [left for left in self.rules if left != self.start and not references[left]]
            if not idle:
                return
            for left in idle:
                del self.rules[left]

    def order(self) -> list[int] | None:
        """Sort the nonterminals topologically, each before those in its rules."""
        waiting = dict.fromkeys(self.rules, 0)
        for _, right in self.uses():
            for symbol in right:
                if symbol in waiting:
                    waiting[symbol] += 1
        ready = [left for left, number in waiting.items() if number == 0]
        ordered = []
        while ready:
            left = ready.pop()
            ordered.append(left)
            for right in self.rules[left]:
                for symbol in right:
                    if symbol in waiting:
                        waiting[symbol] -= 1
                        if waiting[symbol] == 0:
                            ready.append(symbol)
        return ordered if len(ordered) == len(self.rules) else None


def components(rules: Rules) -> list[list[int]]:
    """Return the strongly connected components of the nonterminals, bottom-up.

    Nonterminals that derive each other are in one component. Each component comes after those that
    its rules use. Within a component nonterminals are in ascending order.

    >>> components({3: {(4, 5): 1}, 4: {(3, 0): 1, (0,): 1}, 5: {(1,): 1}})
    [[5], [3, 4]]
    """
    place = {left: k for k, left in enumerate(sorted(rules))}
    children = [
        sorted({place[symbol] for right in rules[left] for symbol in right if symbol in place})
        for left in place
    ]
    starts = np.cumsum([0, *map(len, children)])
    targets = np.array([child for row in children for child in row], dtype=np.int64)
    label = strong_components(starts, targets).tolist()
    groups: list[list[int]] = [[] for _ in range(max(label) + 1)]
    for left, number in zip(place, label, strict=True):
        groups[number].append(left)
    return groups


def recursive_lefts(rules: Rules) -> frozenset[int]:
    """Return the nonterminals that derive a string which holds themselves.

    >>> sorted(recursive_lefts({3: {(4, 5): 1}, 4: {(4, 0): 1, (0,): 1}, 5: {(1,): 1}}))
    [4]
    """
    return frozenset(
        left
        for group in components(rules)
        for left in group
        if len(group) > 1 or any(left in right for right in rules[left])
    )


def nullable_lefts(rules: Rules) -> frozenset[int]:
    """Return the nonterminals that derive the empty string."""
    reached: set[int] = set()
    while True:
        more = {
            left
            for left, rights in rules.items()
            if left not in reached and any(reached.issuperset(right) for right in rights)
        }
        if not more:
            return frozenset(reached)
        reached |= more


def constant_terminals(sentences: Mapping[Right, int]) -> dict[int, int]:
    """Return the terminals that occur equally often, at least once, in every sentence.

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

    If n sentences hold a terminal and none of them twice, then at most about 3 / n of all such
    sentences hold it twice, at 95 % confidence. A small n is therefore little evidence. A compiled
    search stores these terminals as the bits of one integer, so only the 62 most frequent ones are
    returned.

    `sentences`: Different sentences as terminal numbers, each with how often it occurs. Repeated
    sentences count each time.

    >>> sorted(single_terminals({(0, 1, 2): 4, (0, 1, 1): 6, (0, 2): 5}))
    [0]
    """
    most: Counter[int] = Counter()
    standing: Counter[int] = Counter()
    for sentence, count in sentences.items():
        for terminal, number in Counter(sentence).items():
            most[terminal] = max(most[terminal], number)
            standing[terminal] += count
    terminals = [t for t in sorted(most) if most[t] == 1 and standing[t] >= ENOUGH]
    return frozenset(sorted(terminals, key=lambda terminal: -standing[terminal])[:62])


def flat_rules(
    sentences: Mapping[Right, int], n_terminals: int, *, empties: bool = True
) -> RuleSet:
    """Return a rule set with one rule for each different sentence.

    `sentences`: Different sentences as terminal numbers, each with how often it occurs. The laws
    are taken from them.
    """
    rights = {sentence: sentences[sentence] for sentence in sorted(sentences)}
    constants, singles = constant_terminals(sentences), single_terminals(sentences)
    return RuleSet(n_terminals, {n_terminals: rights}, constants, empties, singles)


def as_grammar(rule_set: RuleSet, names: Sequence[str]) -> Grammar:
    """Return a rule set as a grammar with named symbols.

    Nonterminals are S, A, B, ... in breadth-first order from the start symbol. The rules of a
    nonterminal are ordered by decreasing use, then by their symbols.
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
    """Yield S, then A to Z without S, then A1, B1, ...; names of terminals are skipped.

    Where S itself is the name of a terminal, primes are added to it.

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
