"""Display of loops: rules that repeat as repetitions, and chains in trees as one node.

The rules of a nonterminal A fall into three kinds: L A, which put something before A, A R, which
put something after it, and all others, Z. The strings of A are then those of L* Z R*, for any L, Z
and R, which may contain A. If L and Z are the same, this is L+. An L* next to an L is also written
as L+.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from motiondb.grammar.cfg.context_free import EMPTY, Grammar, Rule, Tree, format_grammar


def format_loops(grammar: Grammar) -> str:
    r"""Return the grammar as text, rules that repeat as repetitions.

    ``X+ [0.6]`` is X, repeated each time with probability 0.6; ``X*`` is the same or the empty
    string. The probabilities of several things that may repeat are those of the rules.

    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> print(format_loops(read_grammar("S -> stand A B rest\nA -> l r A [0.6] | l r [0.4]\n"
    ...     "B -> B x [0.3] | B y [0.2] | z [0.5]")))
    S -> stand A B rest
    A -> (l r)+ [0.6]
    B -> z (x [0.3] | y [0.2])*
    """
    lines = []
    grammar = _once_or_more(grammar)
    for line in format_grammar(grammar).splitlines():
        left = line.split(" -> ", 1)[0]
        rules = [grammar.rules[number] for number in grammar.rules_of[left]]
        lines.append(_repetition(left, rules) or line)
    return "\n".join(lines)


def _once_or_more(grammar: Grammar) -> Grammar:
    """Return a grammar of the same language in which X* X and X X*, wherever X* stands, are X+."""
    rules = list(grammar.rules)
    for left in grammar.nonterminals:
        part = _repeated(left, [rule for rule in rules if rule.left == left])
        others = [rule.right for rule in rules if rule.left != left]
        shortened = {right: _without_part(right, left, part) for right in others} if part else {}
        if left == grammar.start or not part or None in shortened.values():
            continue
        for number, rule in enumerate(rules):
            if rule.left != left:
                rules[number] = replace(rule, right=shortened[rule.right] or ())
            elif not rule.right:
                rules[number] = replace(rule, right=part)
    return replace(grammar, rules=tuple(rules))


def _repeated(left: str, rules: Sequence[Rule]) -> tuple[str, ...]:
    """Return X if the rules of a nonterminal make it X*, else nothing."""
    rights = sorted((rule.right for rule in rules), key=len)
    if len(rights) != 2 or rights[0]:
        return ()
    for part, symbol in ((rights[1][:-1], rights[1][-1]), (rights[1][1:], rights[1][0])):
        if symbol == left and left not in part:
            return part
    return ()


def _without_part(
    right: tuple[str, ...], left: str, part: tuple[str, ...]
) -> tuple[str, ...] | None:
    """Return a right side without the X beside each X*; None if there is none beside one."""
    n, written, k = len(part), list(right), 0
    while k < len(written):
        if written[k] != left:
            k += 1
        elif tuple(written[k + 1 : k + 1 + n]) == part:
            del written[k + 1 : k + 1 + n]
            k += 1
        elif k >= n and tuple(written[k - n : k]) == part:
            del written[k - n : k]
            k += 1 - n
        else:
            return None
    return tuple(written)


def _repetition(left: str, rules: Sequence[Rule]) -> str | None:
    """Return the line of a nonterminal that repeats, None if it does not."""
    before = [rule for rule in rules if len(rule.right) > 1 and rule.right[-1] == left]
    after = [r for r in rules if len(r.right) > 1 and r.right[0] == left and r not in before]
    others = [rule for rule in rules if rule not in before and rule not in after]
    if not (before or after) or not others:
        return None
    loops = [rule.right[:-1] for rule in before] + [rule.right[1:] for rule in after]
    if len(loops) == len(others) == 1 and others[0].right in (loops[0], ()):
        mark = "+" if others[0].right else "*"
        chance = (before + after)[0].probability
        return f"{left} -> {_group(loops[0])}{mark} [{chance:.4g}]"
    parts = []
    if before:
        parts.append(_choice([(r.right[:-1], r.probability) for r in before]) + "*")
    if len(others) > 1:
        parts.append(_choice([(rule.right, rule.probability) for rule in others]))
    elif others[0].right:
        parts.append(" ".join(others[0].right))
    if after:
        parts.append(_choice([(rule.right[1:], rule.probability) for rule in after]) + "*")
    return f"{left} -> {' '.join(parts)}"


def _group(right: Sequence[str]) -> str:
    return right[0] if len(right) == 1 else f"({' '.join(right)})"


def _choice(ways: Sequence[tuple[tuple[str, ...], float]]) -> str:
    texts = [f"{' '.join(right) or EMPTY} [{chance:.4g}]" for right, chance in ways]
    return f"({' | '.join(texts)})"


def with_loops(tree: Tree) -> Tree:
    r"""Return a tree in which a node that repeats is drawn once, with all its rounds below it.

    A node whose first or last part is a node of the same symbol takes the parts of that node in its
    place. It is named by the symbol and the number of nodes that became one. The result is for
    pictures; it is not a derivation.

    >>> from motiondb.grammar.cfg.context_free import derive_by, read_grammar
    >>> drawn = with_loops(derive_by(read_grammar("S -> A r\nA -> x A | x"), (0, 1, 1, 2)))
    >>> drawn.children[0].symbol, drawn.children[0].leaves()
    ('A x3', ('x', 'x', 'x'))
    """
    done: list[Tree] = []
    waiting: list[tuple[Tree, bool]] = [(tree, False)]
    while waiting:  # a loop, because derivations can be too deep for recursion
        node, is_ready = waiting.pop()
        if node.is_leaf:
            done.append(node)
        elif is_ready:
            n = len(node.children)
            parts = done[len(done) - n :] if n else []
            del done[len(done) - n :]
            done.append(_joined(node, parts))
        else:
            waiting.append((node, True))
            waiting.extend((child, False) for child in reversed(node.children))
    return done[0]


def with_loops_around(tree: Tree, path: Sequence[int]) -> tuple[Tree, range]:
    r"""Return a tree with its loops drawn as by :func:`with_loops`, except for one node.

    This node stays separate even if it is a round of a loop, so that it can be marked.
    Loops within it are drawn as loops too.

    >>> from motiondb.grammar.cfg.context_free import derive_by, read_grammar
    >>> drawn, numbers = with_loops_around(
    ...     derive_by(read_grammar("S -> A r\nA -> x A | x"), (0, 1, 1, 1, 2)), (0, 1, 1)
    ... )
    >>> print(drawn), numbers
    S(A x2(x x A x2(x x)) r)
    (None, range(4, 7))
    """
    line = [tree]
    for child in path:
        line.append(line[-1].children[child])
    kept = with_loops(line[-1])
    mark = Tree("")  # a leaf, which is never part of a loop
    outer = mark
    for child, parent in zip(reversed(path), reversed(line[:-1]), strict=True):
        children = (*parent.children[:child], outer, *parent.children[child + 1 :])
        outer = replace(parent, children=children)
    nodes = list(with_loops(outer).nodes())
    first = next(number for number, node in enumerate(nodes) if node is mark)
    drawn = _in_place_of(nodes, mark, kept)
    return drawn, range(first, first + sum(1 for _ in kept.nodes()))


def _in_place_of(nodes: Sequence[Tree], mark: Tree, kept: Tree) -> Tree:
    """Return the tree of nodes in preorder with a subtree in place of a leaf."""
    done: list[Tree] = []
    for node in reversed(nodes):
        if node.is_leaf:
            done.append(kept if node is mark else node)
            continue
        children = tuple(done.pop() for _ in node.children)
        done.append(replace(node, children=children))
    return done[0]


def _joined(node: Tree, parts: Sequence[Tree]) -> Tree:
    """Return a node with the parts of a first or last part of the same symbol in its place."""
    ends = [0, len(parts) - 1] if len(parts) > 1 else []
    same = [k for k in ends if not parts[k].is_leaf and node.children[k].symbol == node.symbol]
    if not same:
        return Tree(node.symbol, node.rule, tuple(parts))
    k = same[-1]
    inner = parts[k]
    rounds = 1 + int(inner.symbol[len(node.symbol) + 2 :] or 1)
    children = (*parts[:k], *inner.children, *parts[k + 1 :])
    return Tree(f"{node.symbol} x{rounds}", node.rule, children)
