"""Rule sets: rules with counts of their use, as induction changes them, and laws they must keep.

A rule set holds the right sides of each nonterminal. With each right side it holds the number of
nodes that use it in the trees of the sentences. This is enough for the description length: a node
of a nonterminal with h rules costs log2 h bits, so the sentences cost the sum over nonterminals of
nodes times log2 h. The trees themselves are not kept.

Four laws limit generalization where there are few examples:

* *acyclic*: no nonterminal derives itself, so nothing repeats without end;
* *constant*: a terminal that occurs equally often in every sentence keeps this number. One shot
  in each basketball sentence means one shot in each derived sentence;
* *single*: a terminal that at least ten sentences hold, and none twice, occurs at most once;
* a nonterminal that may be empty does not stand beside itself. Otherwise one sentence has several
  derivations, and bits are spent on the choice between them. A search may also forbid all empty
  right sides.

Symbols are numbers: terminals are 0..T-1, the start symbol is T, other nonterminals are above T.

Source: J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from Human Motion Data",
Computer Graphics Forum 30 (2011), section 5.1, for the description length. The laws are specific to
motiondb; they prevent the cyclic references that section 7 reports.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from motiondb.grammar.cfg.context_free import Grammar, Rule

ENOUGH = 10
"""Sentences that must hold a terminal, none of them twice, before it counts as single.

At 10 the bound of :func:`single_terminals` is 3 / 10. Chosen by hand; not tuned.
"""

Right = tuple[int, ...]
Rules = dict[int, dict[Right, int]]


@dataclass
class RuleSet:
    """Rules with counts, and the laws that they must keep.

    Attributes
    ----------
    n_terminals : int
        Number of terminals, T; this is also the number of the start symbol.
    rules : dict of int to dict of Right to int
        ``rules[left][right]`` is the number of nodes that use the rule.
    constants : mapping of int to int
        Terminals that occur equally often in every string, each with this number.
    empties : bool
        Whether right sides may be empty.
    singles : frozenset of int
        Terminals that no string may hold twice.
    """

    n_terminals: int
    rules: Rules
    constants: Mapping[int, int] = field(default_factory=dict)
    empties: bool = True
    singles: frozenset[int] = frozenset()

    @property
    def start(self) -> int:
        """The number of the start symbol."""
        return self.n_terminals

    def copy(self) -> RuleSet:
        """Return a copy with rules of its own; the laws are shared."""
        rules = {left: dict(rights) for left, rights in self.rules.items()}
        return RuleSet(self.n_terminals, rules, self.constants, self.empties, self.singles)

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
        """Add nodes to a rule; create the rule if it is new.

        Parameters
        ----------
        left : int
            The nonterminal.
        right : tuple of int
            Right side of the rule.
        count : int
            Number of nodes to add.
        """
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

        Parameters
        ----------
        names : mapping of int to int
            The new symbol for each symbol that changes.
        """
        old, self.rules = self.rules, {}
        for left, rights in old.items():
            for right, count in rights.items():
                renamed = tuple(names.get(symbol, symbol) for symbol in right)
                new_left = names.get(left, left)
                if renamed != (new_left,):
                    self.add(new_left, renamed, count)

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
        """Sort the nonterminals topologically, each before those in its rules.

        Returns
        -------
        list of int or None
            None if a nonterminal derives itself.
        """
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
        """Whether a symbol that may be empty stands beside itself; `order` is bottom-up."""
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
        """Whether every string has each constant terminal the required number of times."""
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
        """Whether no string can hold a single terminal twice."""
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
    """Return the terminals that occur equally often, at least once, in every sentence.

    Parameters
    ----------
    sentences : mapping of Right to int
        Different sentences as terminal numbers, each with how often it occurs.

    Returns
    -------
    dict of int to int
        Each such terminal with its number. Empty for fewer than two different sentences.

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
    sentences hold it twice, at 95 % confidence. A small n therefore says little. A compiled search
    stores these terminals as the bits of one integer, so only the 62 most frequent ones are
    returned.

    Parameters
    ----------
    sentences : mapping of Right to int
        Different sentences as terminal numbers, each with how often it occurs. Repeated sentences
        count each time.

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
    """Return a rule set with one rule for each different sentence.

    Parameters
    ----------
    sentences : mapping of Right to int
        Different sentences as terminal numbers, each with how often it occurs. The laws are taken
        from them.
    n_terminals : int
        Number of terminals.
    empties : bool, optional
        Whether right sides may be empty.

    Returns
    -------
    RuleSet
        Its rules are in ascending order of the sentences.
    """
    rights = {sentence: sentences[sentence] for sentence in sorted(sentences)}
    constants, singles = constant_terminals(sentences), single_terminals(sentences)
    return RuleSet(n_terminals, {n_terminals: rights}, constants, empties, singles)


def as_grammar(rule_set: RuleSet, names: Sequence[str]) -> Grammar:
    """Return a rule set as a grammar with named symbols.

    Nonterminals are S, A, B, ... in breadth-first order from the start symbol. The rules of a
    nonterminal are ordered by decreasing use, then by their symbols.

    Parameters
    ----------
    rule_set : RuleSet
        The rules; their counts decide the order only.
    names : sequence of str
        Names of the terminals.
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

    Parameters
    ----------
    terminals : sequence of str
        Names that are taken.

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
