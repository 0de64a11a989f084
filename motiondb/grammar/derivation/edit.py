"""Edit a sentence through its tree: pick a symbol, derive its region again, choose.

A *region* is a node of the tree. It is the nonterminal that generated the picked terminal, or one
of its ancestors. It covers the symbols from ``start`` up to, but not including, ``end``. It can
widen to its ancestor, or narrow towards the picked terminal. An *alternative* is another derivation
of the region's nonterminal. Replacing the region by an alternative gives a tree of the same
grammar; nothing outside the region changes.

Source: J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from Human Motion Data",
Computer Graphics Forum 30 (2011), section 6.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from motiondb.grammar.cfg.context_free import GrammarError, Tree
from motiondb.grammar.cfg.parse import (
    AnyGrammar,
    best_strings,
    compiled_form,
    log_probability,
    parse,
)
from motiondb.grammar.derivation.derive import MEAN_LENGTH, derive

_TRIES = 25  # draws for each alternative; chosen by hand, not tuned
_STEPS = 400  # prefixes to extend if the draws gave too few; chosen by hand


@dataclass(frozen=True)
class Region:
    """A node of a tree, with the symbols that it generates."""

    path: tuple[int, ...]  # Numbers of the children from the root to the node
    symbol: str  # The nonterminal of the node
    start: int  # Its first symbol in the sentence, from 0
    end: int  # The symbol after its last one
    position: int  # The symbol that was picked, from 0


@dataclass(frozen=True)
class Alternative:
    """Another derivation of a region."""

    tree: Tree  # The derivation; its root is the nonterminal of the region
    string: tuple[str, ...]  # The terminals that it derives
    # Natural logarithm of the probability of the string, given the nonterminal of the region
    log_probability: float


def region_at(tree: Tree, position: int) -> Region:
    """Return the region of the nonterminal that generated a terminal."""
    path = _path_to(tree, position)
    return _region(tree, path[:-1], position)


def wider(tree: Tree, region: Region, levels: int = 1) -> Region:
    """Return the region of an ancestor."""
    if not 0 <= levels <= len(region.path):
        raise GrammarError(
            f"region: expected 0 to {len(region.path)} levels up from {region.symbol!r} to the"
            f" whole sentence, found {levels}. Ask for fewer."
        )
    return _region(tree, region.path[: len(region.path) - levels], region.position)


def narrower(tree: Tree, region: Region, levels: int = 1) -> Region:
    """Return the region of a descendant, towards the picked terminal."""
    path = _path_to(tree, region.position)[:-1]
    depth = len(path) - len(region.path)
    if path[: len(region.path)] != region.path or not 0 <= levels <= depth:
        raise GrammarError(
            f"region: expected 0 to {max(depth, 0)} levels down from {region.symbol!r} to the"
            f" symbol at {region.position}, found {levels}. Ask for fewer, or pick another symbol."
        )
    return _region(tree, path[: len(region.path) + levels], region.position)


def alternatives(
    grammar: AnyGrammar,
    tree: Tree,
    region: Region,
    n: int,
    rng: np.random.Generator,
    *,
    most: float = MEAN_LENGTH,
) -> tuple[Alternative, ...]:
    """Return up to `n` other strings for a region, the most probable first, each once.

    The strings are drawn at random from the nonterminal of the region. If fewer than `n` are drawn,
    the most probable strings that were not drawn are added. Fewer than `n` are returned if the
    nonterminal has no more strings, or if the search does not reach them.
    """
    if n < 1:
        raise GrammarError(f"alternatives: expected at least 1, found {n}. Ask for one or more.")
    whole = compiled_form(grammar).grammar
    if not whole.is_nonterminal(region.symbol):
        raise GrammarError(
            f"region: expected a nonterminal of the grammar, found {region.symbol!r}."
            " The tree belongs to another grammar: parse again."
        )
    local = compiled_form(replace(whole, start=region.symbol))
    old = _node(tree, region.path).leaves()
    trees: dict[tuple[str, ...], Tree] = {}
    for _ in range(_TRIES * n):
        drawn = derive(local, rng, most=most)
        string = drawn.leaves()
        if string != old:
            trees.setdefault(string, drawn)
        if len(trees) == n:
            break
    if len(trees) < n:
        for string, _ in best_strings(local, n + 1 + len(trees), steps=_STEPS):
            if string != old and string not in trees and len(trees) < n:
                trees[string] = parse(local, string)
    ranked = [
        Alternative(subtree, string, log_probability(local, string))
        for string, subtree in trees.items()
    ]
    return tuple(sorted(ranked, key=lambda a: (-a.log_probability, a.string)))


def replace_region(tree: Tree, region: Region, subtree: Tree) -> Tree:
    """Return the tree with another derivation of a region; the rest of the tree is unchanged."""
    if subtree.symbol != region.symbol or _node(tree, region.path).symbol != region.symbol:
        raise GrammarError(
            f"region: expected a derivation of {region.symbol!r}, found one of"
            f" {subtree.symbol!r}. Take an alternative of this region."
        )
    line = [tree]
    for child in region.path:
        line.append(line[-1].children[child])
    new = subtree
    for child, parent in zip(reversed(region.path), reversed(line[:-1]), strict=True):
        children = (*parent.children[:child], new, *parent.children[child + 1 :])
        new = replace(parent, children=children)
    return new


def _path_to(tree: Tree, position: int) -> tuple[int, ...]:
    """Return the path from the root to the leaf at a position, as numbers of children."""
    waiting: list[tuple[Tree, tuple[int, ...]]] = [(tree, ())]
    seen = 0
    while waiting:
        node, path = waiting.pop()
        if node.is_leaf:
            if seen == position:
                return path
            seen += 1
        children = [(child, (*path, k)) for k, child in enumerate(node.children)]
        waiting.extend(reversed(children))
    raise GrammarError(
        f"position {position}: expected 0 to {seen - 1}, the symbols of the sentence, found"
        f" {position}. Pick a symbol of the sentence."
        if seen
        else f"position {position}: expected a symbol to pick, found an empty sentence."
        " Generate a longer one."
    )


def _node(tree: Tree, path: tuple[int, ...]) -> Tree:
    """Return the node at the end of a path."""
    for child in path:
        tree = tree.children[child]
    return tree


def _region(tree: Tree, path: tuple[int, ...], position: int) -> Region:
    """Return the region of the node at the end of a path."""
    start, node = 0, tree
    for child in path:
        start += sum(len(before.leaves()) for before in node.children[:child])
        node = node.children[child]
    return Region(path, node.symbol, start, start + len(node.leaves()), position)
