"""What rules with numbers derive: components, nonterminals that loop, and those that may be empty.

Rules are given as ``rules[left][right] = count``, with the symbols of
:mod:`motiondb.grammar.rules.rule_set`. Counts are not read.

Source: R. Tarjan, "Depth-First Search and Linear Graph Algorithms", SIAM Journal on Computing 1
(1972), for components.
"""

from __future__ import annotations

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
