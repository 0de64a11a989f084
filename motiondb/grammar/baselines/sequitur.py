"""Sequitur: a grammar that represents a string by fewer symbols, built from left to right.

Symbols are appended to the start rule one by one. Two constraints are restored after each:

* *digram uniqueness*: no pair of neighbouring symbols occurs twice (without overlap) in the
  grammar. A repeated pair becomes a rule;
* *rule utility*: each rule is used at least twice. A rule that is used once is expanded in place.

Time and space are linear in the length of the string.

The grammar derives the given sentences and nothing else, and shows their hierarchy. Marks that
match nothing separate the sentences. Each sentence becomes one rule of the start symbol.

Source: C. G. Nevill-Manning and I. H. Witten, "Identifying Hierarchical Structure in Sequences: A
Linear-Time Algorithm", Journal of Artificial Intelligence Research 7 (1997).
"""

from __future__ import annotations

from motiondb.grammar.baselines.flat import Sentences, counted, unused_name
from motiondb.grammar.cfg.context_free import Grammar, Rule

_MARK = ""  # no terminal has this name


def sequitur_grammar(sentences: Sentences) -> Grammar:
    """Return the Sequitur grammar of the different sentences.

    The probability of a sentence is its relative frequency. Errors as in
    :func:`motiondb.grammar.baselines.flat.flat_grammar`.

    >>> from motiondb.grammar.cfg.context_free import format_grammar
    >>> print(format_grammar(sequitur_grammar(["abcdbcabcdbc"])))
    S -> R1 R1
    R1 -> a R2 d R2
    R2 -> b c
    """
    counts = counted(sentences)
    builder = _Builder()
    for sentence in counts:
        for symbol in (*sentence, _MARK):
            builder.append(symbol)
    return _as_grammar(builder.bodies(), list(counts.values()))


Symbol = str | int  # a terminal, or the number of a rule


def _as_grammar(bodies: dict[int, list[Symbol]], counts: list[int]) -> Grammar:
    """Return rules as a grammar; `counts` holds how often each sentence occurs."""
    terminals = {s for body in bodies.values() for s in body if isinstance(s, str)}
    start = unused_name("S", terminals)
    order = _by_appearance(bodies)
    names = {rule: unused_name(f"R{k}", terminals) for k, rule in enumerate(order, start=1)}

    def named(body: list[Symbol]) -> tuple[str, ...]:
        return tuple(names[symbol] if isinstance(symbol, int) else symbol for symbol in body)

    alternatives: list[list[Symbol]] = [[]]
    for symbol in bodies[0]:
        if symbol == _MARK:
            alternatives.append([])
        else:
            alternatives[-1].append(symbol)
    rules = [
        Rule(start, named(body), number / sum(counts))
        for body, number in zip(alternatives[:-1], counts, strict=True)
    ]
    return Grammar(start, (*rules, *(Rule(names[r], named(bodies[r])) for r in order)))


def _by_appearance(bodies: dict[int, list[Symbol]]) -> list[int]:
    """Return the rules in breadth-first order from the start rule, without it."""
    appeared: dict[int, None] = {}
    level = [0]
    while level:
        below = [s for rule in level for s in bodies[rule] if isinstance(s, int)]
        level = [rule for rule in dict.fromkeys(below) if rule not in appeared]
        appeared.update(dict.fromkeys(level))
    return list(appeared)


class _Builder:
    """Rules as rings of linked nodes around a guard; node numbers index the lists."""

    def __init__(self) -> None:
        self.value: list[Symbol] = []
        self.before: list[int] = []
        self.after: list[int] = []
        self.rule_of_guard: dict[int, int] = {}
        self.guards: dict[int, int] = {}
        self.uses: dict[int, set[int]] = {}
        self.place: dict[tuple[Symbol, Symbol], int] = {}  # digram -> node of its first symbol
        self.waiting: list[int] = []  # nodes whose digram must be checked
        self.n_rules = 0
        self._new_rule()

    def append(self, symbol: str) -> None:
        """Append a symbol to the start rule and restore both constraints."""
        guard = self.guards[0]
        last = self.before[guard]
        node = self._new_node(symbol)
        self._link(last, node)
        self._link(node, guard)
        self.waiting.append(last)
        while self.waiting:
            self._look_at(self.waiting.pop())

    def bodies(self) -> dict[int, list[Symbol]]:
        """Return the right side of each rule; rule 0 is the start."""
        return {rule: [self.value[node] for node in self._nodes(rule)] for rule in self.guards}

    def _nodes(self, rule: int) -> list[int]:
        """Return the nodes of a rule from left to right."""
        guard = self.guards[rule]
        nodes, node = [], self.after[guard]
        while node != guard:
            nodes.append(node)
            node = self.after[node]
        return nodes

    def _new_node(self, value: Symbol) -> int:
        """Create a node that is not linked yet."""
        self.value.append(value)
        self.before.append(-1)
        self.after.append(-1)
        node = len(self.value) - 1
        if isinstance(value, int):
            self.uses[value].add(node)
        return node

    def _new_rule(self) -> int:
        """Create a rule with an empty right side."""
        rule = self.n_rules
        self.n_rules += 1
        self.uses[rule] = set()
        guard = self._new_node(_MARK)
        self.rule_of_guard[guard], self.guards[rule] = rule, guard
        self._link(guard, guard)
        return rule

    def _link(self, left: int, right: int) -> None:
        """Make two nodes neighbours."""
        self.after[left], self.before[right] = right, left

    def _digram(self, node: int) -> tuple[Symbol, Symbol] | None:
        """Return the pair that begins at a node; None at a guard, a mark or a removed node."""
        if self.after[node] < 0:
            return None
        pair = self.value[node], self.value[self.after[node]]
        return None if _MARK in pair else pair

    def _forget(self, node: int) -> None:
        """Remove the digram at a node from the index."""
        pair = self._digram(node)
        if pair is not None and self.place.get(pair) == node:
            del self.place[pair]

    def _remove(self, node: int) -> None:
        """Mark a node as removed."""
        value = self.value[node]
        if isinstance(value, int):
            self.uses[value].discard(node)
        self.before[node] = self.after[node] = -1

    def _look_at(self, node: int) -> None:
        """Restore both constraints for the digram at a node."""
        pair = self._digram(node)
        if pair is None:
            return
        other = self.place.setdefault(pair, node)
        if other == node or self.after[other] == node or self.after[node] == other:
            return
        whole = self._whole_rule(other)
        if whole is not None:
            self._substitute(node, whole)
        elif (whole := self._whole_rule(node)) is not None:
            self._substitute(other, whole)
            self.place[pair] = node
        else:
            whole = self._new_rule()
            guard, first = self.guards[whole], self._new_node(pair[0])
            second = self._new_node(pair[1])
            self._link(guard, first)
            self._link(first, second)
            self._link(second, guard)
            self._substitute(other, whole)
            self._substitute(node, whole)
            self.place[pair] = first
        for symbol in pair:
            if isinstance(symbol, int) and len(self.uses.get(symbol, ())) == 1:
                self._put_back(symbol)

    def _whole_rule(self, node: int) -> int | None:
        """Return the rule whose right side is exactly the digram at a node, if any."""
        guard = self.rule_of_guard.get(self.before[node])
        end = self.after[self.after[node]]
        return guard if guard and self.rule_of_guard.get(end) == guard else None

    def _substitute(self, node: int, rule: int) -> None:
        """Replace the two symbols at a node by a rule."""
        second = self.after[node]
        left, right = self.before[node], self.after[second]
        for changed in (left, node, second):
            self._forget(changed)
        self._remove(node)
        self._remove(second)
        new = self._new_node(rule)
        self._link(left, new)
        self._link(new, right)
        # Of three equal symbols in a row, one pair is not indexed. Check the neighbours' pairs too.
        self.waiting += [right, new, left, self.before[left]]

    def _put_back(self, rule: int) -> None:
        """Replace the only use of a rule by its right side, and delete the rule."""
        (use,) = self.uses.pop(rule)
        guard = self.guards.pop(rule)
        del self.rule_of_guard[guard]
        left, right = self.before[use], self.after[use]
        first, last = self.after[guard], self.before[guard]
        self._forget(left)
        self._forget(use)
        self.before[use] = self.after[use] = self.before[guard] = self.after[guard] = -1
        self._link(left, first)
        self._link(last, right)
        self.waiting += [right, last, left, self.before[left]]
