"""The laws of rules, each written out plainly: a twin of the check in arrays."""

from __future__ import annotations

import itertools

from motiondb.grammar.rules.rule_set import nullable_lefts, recursive_lefts


def lawful(rule_set):
    """Whether a rule set keeps all its laws."""
    rules, nullable = rule_set.rules, nullable_lefts(rule_set.rules)
    loops = recursive_lefts(rules)
    if rule_set.loops:
        ends = all_end(rules, rule_set.n_terminals) and not derives_itself_alone(rules)
        if not ends or not all_reached(rules, rule_set.start):
            return False
    elif loops:
        return False
    return (
        (rule_set.empties or all(right for _, right in rule_set.uses()))
        and rule_set.start not in nullable
        and not empty_beside_itself(rules, nullable)
        and keeps_constants(rules, rule_set.n_terminals, rule_set.start, rule_set.constants)
        and keeps_singles(rules, rule_set.n_terminals, rule_set.singles)
    )


def all_end(rules, n_terminals):
    """Whether every nonterminal derives a string of terminals."""
    known = set(range(n_terminals))
    while more := {
        x for x in rules if x not in known and any(known.issuperset(r) for r in rules[x])
    }:
        known |= more
    return known.issuperset(rules)


def all_reached(rules, start):
    """Whether derivations from the start symbol reach every nonterminal."""
    reached = [start]
    seen = {start}
    for left in reached:
        for symbol in itertools.chain.from_iterable(rules[left]):
            if symbol in rules and symbol not in seen:
                seen.add(symbol)
                reached.append(symbol)
    return len(reached) == len(rules)


def derives_itself_alone(rules):
    """Whether a nonterminal derives exactly itself, so that a tree can be infinite."""
    nullable = nullable_lefts(rules)
    alone = {left: {} for left in rules}
    for left, rights in rules.items():
        for right in rights:
            for k, symbol in enumerate(right):
                if symbol in rules and nullable.issuperset(right[:k] + right[k + 1 :]):
                    alone[left][(symbol,)] = 1
    return bool(recursive_lefts(alone))


def empty_beside_itself(rules, nullable):
    """Whether a nonterminal that derives the empty string occurs next to itself."""
    return bool(nullable) and any(
        one == other and one in nullable
        for right in _rights(rules)
        for one, other in itertools.pairwise(right)
    )


def keeps_constants(rules, n_terminals, start, constants):
    """Whether every string holds each constant terminal the required number of times."""
    if not constants:
        return True
    numbers = {
        symbol: tuple(int(symbol == terminal) for terminal in constants)
        for symbol in range(n_terminals)
    }
    waiting = [(left, right) for left, rights in rules.items() for right in rights]
    while waiting:
        later = []
        for left, right in waiting:
            if any(symbol not in numbers for symbol in right):
                later.append((left, right))
                continue
            total = tuple(map(sum, zip((0,) * len(constants), *(numbers[s] for s in right))))
            if numbers.setdefault(left, total) != total:
                return False
        if len(later) == len(waiting):
            return False
        waiting = later
    return numbers[start] == tuple(constants.values())


def keeps_singles(rules, n_terminals, singles):
    """Whether no string can hold a single terminal twice."""
    if not singles:
        return True
    held = {symbol: frozenset({symbol} & singles) for symbol in range(n_terminals)}
    held.update(dict.fromkeys(rules, frozenset()))
    grown = True
    while grown:
        grown = False
        for left, rights in rules.items():
            more = held[left].union(*(held[symbol] for right in rights for symbol in right))
            grown = grown or more != held[left]
            held[left] = more
    return all(
        sum(len(held[symbol]) for symbol in right)
        == len(frozenset().union(*(held[s] for s in right)))
        for right in _rights(rules)
    )


def _rights(rules):
    return (right for rights in rules.values() for right in rights)
