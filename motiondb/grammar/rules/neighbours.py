"""Neighbours of recursive nonterminals, moved into their rules or out of them.

If every occurrence of A is followed by x, then A x derives the same strings as a nonterminal whose
rules end with x. This shortens rules such as ``S -> A b, A -> a A b | a`` to ``S -> a S b | a b``,
which annealing reaches only through rules of more bits. The language and the use of every rule stay
the same, so that whatever supports the loops still does.

Conversely, ``S -> a A, A -> b A | b x`` becomes ``S -> a A x, A -> b A | b`` where this costs no
bits, because the second A is a repetition and is shown as one.
"""

from __future__ import annotations

from motiondb.grammar.rules.rule_laws import recursive_lefts
from motiondb.grammar.rules.rule_set import Right, Rules, RuleSet


def absorb_neighbours(rule_set: RuleSet) -> RuleSet:
    """Move common neighbours into recursive nonterminals as long as this saves bits.

    Constants and singles are left where they are: no loop may hold them.

    >>> rules = {2: {(3, 1): 2}, 3: {(0, 3, 1): 1, (0,): 2}}
    >>> absorb_neighbours(RuleSet(2, rules, loops=True)).rules
    {2: {(0, 2, 1): 1, (0, 1): 2}}
    """
    current = rule_set
    while True:
        tried = [
            absorbed
            for left in sorted(recursive_lefts(current.rules))
            for after in (True, False)
            if (absorbed := _absorb(current, left, after)) is not None
        ]
        best = min(tried, key=RuleSet.bits, default=current)
        if best.bits() >= current.bits() - 1e-9:
            return current
        current = best


def release_ends(rule_set: RuleSet) -> RuleSet:
    """Move the common end of a repetition out of its rules where this costs no bits.

    >>> rules = {3: {(0, 4): 2}, 4: {(1, 4): 1, (1, 2): 2}}
    >>> release_ends(RuleSet(3, rules, loops=True)).rules
    {3: {(0, 4, 2): 2}, 4: {(1, 4): 1, (1,): 2}}
    """
    current = rule_set
    for left in sorted(recursive_lefts(rule_set.rules) - {rule_set.start}):
        for after in (True, False):
            released = _release(current, left, after)
            if released is not None and released.bits() <= current.bits() + 1e-9:
                current = released
    return current


def _release(rule_set: RuleSet, left: int, after: bool) -> RuleSet | None:
    """Return the rules with the common end of ``left`` outside; None if it has none.

    ``after`` tells whether it is the end of a repetition to the right, or the begin of one to the
    left.
    """
    edge = -1 if after else 0
    rights = rule_set.rules[left]
    again = [right for right in rights if left in right]
    others = [right for right in rights if left not in right]
    if any(right.count(left) > 1 or right[edge] != left for right in again):
        return None
    if not again or any(len(right) < 2 for right in others):
        return None
    ends = {right[edge] for right in others}
    (end,) = ends if len(ends) == 1 else (None,)
    if end is None or end >= rule_set.n_terminals:
        return None
    kept = slice(None, -1) if after else slice(1, None)
    rules: Rules = {}
    for symbol, uses in rule_set.rules.items():
        rules[symbol] = {}
        for right, count in uses.items():
            if symbol != left:
                changed = _with(right, left, end, after)
            else:
                changed = right if left in right else right[kept]
            rules[symbol][changed] = rules[symbol].get(changed, 0) + count
    return rule_set.with_rules(rules)


def _with(right: Right, left: int, end: int, after: bool) -> Right:
    """The right side with ``end`` beside each occurrence of ``left``."""
    pair = (left, end) if after else (end, left)
    return tuple(one for symbol in right for one in (pair if symbol == left else (symbol,)))


def _absorb(rule_set: RuleSet, left: int, after: bool) -> RuleSet | None:
    """Return the rules with the neighbour in the rules of ``left``; None if there is no common one.

    ``after`` tells whether it is the neighbour that follows, or the one that precedes.
    """
    neighbours = {
        _neighbour(right, k, after)
        for _, right in rule_set.uses()
        for k, symbol in enumerate(right)
        if symbol == left
    }
    (neighbour,) = neighbours if len(neighbours) == 1 else (None,)
    held = {*rule_set.constants, *rule_set.singles}
    if neighbour is None or neighbour == left or neighbour in held or left == rule_set.start:
        return None
    if neighbour >= rule_set.n_terminals:
        return None
    rules: Rules = {}
    for symbol, rights in rule_set.rules.items():
        changed: dict[Right, int] = {}
        for right, count in rights.items():
            short = _without(right, left, after)
            if symbol == left:
                short = (*short, neighbour) if after else (neighbour, *short)
            changed[short] = changed.get(short, 0) + count
        rules[symbol] = changed
    return rule_set.with_rules(rules).without_idle_start()


def _neighbour(right: Right, k: int, after: bool) -> int | None:
    beside = k + 1 if after else k - 1
    return right[beside] if 0 <= beside < len(right) else None


def _without(right: Right, left: int, after: bool) -> Right:
    """The right side without the neighbour of each occurrence of ``left``."""
    dropped = {k + 1 if after else k - 1 for k, symbol in enumerate(right) if symbol == left}
    return tuple(symbol for k, symbol in enumerate(right) if k not in dropped)
