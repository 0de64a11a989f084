"""Laws of rules, each as a function of the right sides of every nonterminal.

The rules may be recursive. The properties of what a nonterminal derives are therefore a fixed
point: the least set of nonterminals that derive the empty string, the least sets of terminals that
their strings hold, the one number of constant terminals that agrees with all rules.

Rules are given as ``rules[left][right] = count``, with the symbols of
:mod:`motiondb.grammar.rules.rule_set`. Counts are not read.

Source: J. E. Hopcroft and J. D. Ullman, "Introduction to Automata Theory, Languages, and
Computation" (1979), chapter 4, for symbols that are of use and for nonterminals that derive the
empty string; R. Tarjan, "Depth-First Search and Linear Graph Algorithms", SIAM Journal on Computing
1 (1972), for components.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping

Right = tuple[int, ...]
Rules = dict[int, dict[Right, int]]


def components(rules: Rules) -> list[list[int]]:
    """Return the strongly connected components of the nonterminals, bottom-up.

    Nonterminals that derive each other are in one component. Each component comes after those that
    its rules use. Within a component nonterminals are in ascending order.

    >>> components({3: {(4, 5): 1}, 4: {(3, 0): 1, (0,): 1}, 5: {(1,): 1}})
    [[5], [3, 4]]
    """
    children = {
        left: sorted({symbol for right in rights for symbol in right if symbol in rules})
        for left, rights in rules.items()
    }
    number: dict[int, int] = {}
    lowest: dict[int, int] = {}
    stack: list[int] = []
    done: set[int] = set()
    groups: list[list[int]] = []
    for root in sorted(rules):
        waiting = [(root, iter(children[root]))] if root not in number else []
        for left, _ in waiting:
            number[left] = lowest[left] = len(number)
            stack.append(left)
        while waiting:
            left, rest = waiting[-1]
            child = next(rest, None)
            if child is None:
                waiting.pop()
                if waiting:
                    lowest[waiting[-1][0]] = min(lowest[waiting[-1][0]], lowest[left])
                if lowest[left] == number[left]:
                    place = stack.index(left)
                    groups.append(sorted(stack[place:]))
                    done.update(stack[place:])
                    del stack[place:]
            elif child not in number:
                number[child] = lowest[child] = len(number)
                stack.append(child)
                waiting.append((child, iter(children[child])))
            elif child not in done:
                lowest[left] = min(lowest[left], number[child])
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
    return _least(rules, set())


def all_end(rules: Rules, n_terminals: int) -> bool:
    """Whether every nonterminal derives a string of terminals."""
    return len(_least(rules, set(range(n_terminals)))) == len(rules)


def _least(rules: Rules, leaves: set[int]) -> frozenset[int]:
    """Return the nonterminals that derive a string of these leaves only."""
    reached: set[int] = set()
    while True:
        more = {
            left
            for left, rights in rules.items()
            if left not in reached
            and any(all(s in reached or s in leaves for s in right) for right in rights)
        }
        if not more:
            return frozenset(reached)
        reached |= more


def all_reached(rules: Rules, start: int) -> bool:
    """Whether derivations from the start symbol reach every nonterminal."""
    reached = [start]
    seen = {start}
    for left in reached:
        for symbol in itertools.chain.from_iterable(rules[left]):
            if symbol in rules and symbol not in seen:
                seen.add(symbol)
                reached.append(symbol)
    return len(reached) == len(rules)


def derives_itself_alone(rules: Rules) -> bool:
    """Whether a nonterminal derives exactly itself, so that a tree can be infinite.

    >>> derives_itself_alone({2: {(3, 2): 1, (0,): 1}, 3: {(): 1, (1,): 1}})
    True
    """
    nullable = nullable_lefts(rules)
    alone: Rules = {left: {} for left in rules}
    for left, rights in rules.items():
        for right in rights:
            for k, symbol in enumerate(right):
                if symbol in rules and nullable.issuperset(right[:k] + right[k + 1 :]):
                    alone[left][(symbol,)] = 1
    return bool(recursive_lefts(alone))


def empty_beside_itself(rules: Rules, nullable: frozenset[int]) -> bool:
    """Whether a nonterminal that derives the empty string occurs next to itself."""
    return bool(nullable) and any(
        one == other and one in nullable
        for right in _rights(rules)
        for one, other in itertools.pairwise(right)
    )


def keeps_constants(
    rules: Rules, n_terminals: int, start: int, constants: Mapping[int, int]
) -> bool:
    """Whether every string holds each constant terminal the required number of times."""
    if not constants:
        return True
    numbers: dict[int, Right] = {
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


def keeps_singles(rules: Rules, n_terminals: int, singles: frozenset[int]) -> bool:
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


def _rights(rules: Rules) -> Iterator[Right]:
    return (right for rights in rules.values() for right in rights)
