"""Context-free grammars as records: rules, derivation trees, their text, their faults.

A grammar G = {V, Sigma, R, S} of nonterminals V, terminals Sigma, production rules R and a start
symbol S in V. A rule rewrites one nonterminal into a string of terminals and nonterminals, which
may be empty. Symbols are names; a name is a nonterminal exactly where a rule has it on its left.

As text, a rule a line, alternatives divided by ``|``, ``empty`` for the empty string, and a
probability in brackets where the alternatives are not equally likely::

    S -> a b A c d
    A -> x [0.75] | y [0.25]

Source: J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from Human Motion Data",
Computer Graphics Forum 30 (2011), section 3.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from motiondb.errors import MotionDBError

EMPTY = "empty"
"""How the empty string is written in the text of a grammar; no symbol may have this name."""

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_'.-]*|<[0-9]+>")
_ALTERNATIVE = re.compile(r"^(?P<right>[^\[\]]*?)\s*(?:\[(?P<probability>[0-9.eE+-]+)\])?$")


class GrammarError(MotionDBError):
    """A grammar, or a string asked of it, is not what it should be."""


@dataclass(frozen=True)
class Rule:
    """``left -> right``, taken with ``probability`` among the rules of ``left``."""

    left: str
    right: tuple[str, ...]
    probability: float = 1.0

    def __str__(self) -> str:
        return f"{self.left} -> {' '.join(self.right) or EMPTY}"


@dataclass(frozen=True)
class Tree:
    """A derivation: ``rule`` is the number of the rule that rewrites ``symbol``, -1 at a leaf."""

    symbol: str
    rule: int = -1
    children: tuple[Tree, ...] = ()

    @property
    def is_leaf(self) -> bool:
        """Whether this is a terminal."""
        return self.rule < 0

    def leaves(self) -> tuple[str, ...]:
        """The string that the tree derives."""
        found: list[str] = []
        waiting = [self]
        while waiting:
            tree = waiting.pop()
            if tree.is_leaf:
                found.append(tree.symbol)
            waiting.extend(reversed(tree.children))
        return tuple(found)

    def nodes(self) -> Iterator[Tree]:
        """All nodes in preorder."""
        waiting = [self]
        while waiting:
            tree = waiting.pop()
            yield tree
            waiting.extend(reversed(tree.children))


@dataclass(frozen=True)
class Grammar:
    """A start symbol and rules; the order of rules is kept, their number names them.

    ``terminals`` may hold more than the rules use (a terminal that was heard but stands in no
    sentence); every terminal of the rules is in it.
    """

    start: str
    rules: tuple[Rule, ...]
    terminals: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        used = {symbol for rule in self.rules for symbol in rule.right} - set(self.nonterminals)
        missing = sorted(used - set(self.terminals))
        object.__setattr__(self, "terminals", (*self.terminals, *missing))

    @cached_property
    def nonterminals(self) -> tuple[str, ...]:
        """V in the order of their first rules."""
        return tuple(dict.fromkeys(rule.left for rule in self.rules))

    @cached_property
    def rules_of(self) -> dict[str, tuple[int, ...]]:
        """Nonterminal -> the numbers of its rules."""
        numbers: dict[str, list[int]] = {}
        for number, rule in enumerate(self.rules):
            numbers.setdefault(rule.left, []).append(number)
        return {left: tuple(found) for left, found in numbers.items()}

    def is_nonterminal(self, symbol: str) -> bool:
        """Whether a rule rewrites the symbol."""
        return symbol in self.rules_of

    def with_probabilities(self, weights: Sequence[float]) -> Grammar:
        """The same rules, their probabilities proportional to ``weights`` (equal where all 0)."""
        totals: dict[str, float] = {}
        for rule, weight in zip(self.rules, weights, strict=True):
            totals[rule.left] = totals.get(rule.left, 0.0) + weight
        shares = [
            weight / totals[rule.left]
            if totals[rule.left] > 0
            else 1 / len(self.rules_of[rule.left])
            for rule, weight in zip(self.rules, weights, strict=True)
        ]
        rules = (replace(rule, probability=p) for rule, p in zip(self.rules, shares, strict=True))
        return replace(self, rules=tuple(rules))


def format_grammar(grammar: Grammar) -> str:
    """The grammar as text, a nonterminal a line, the start symbol first.

    >>> print(format_grammar(read_grammar("S -> a A\\nA -> x | y | empty")))
    S -> a A
    A -> x [0.3333] | y [0.3333] | empty [0.3333]
    """
    order = sorted(grammar.nonterminals, key=lambda left: left != grammar.start)
    lines = []
    for left in order:
        rules = [grammar.rules[number] for number in grammar.rules_of[left]]
        chance = len(rules) > 1
        texts = [
            (" ".join(rule.right) or EMPTY) + (f" [{rule.probability:.4g}]" if chance else "")
            for rule in rules
        ]
        lines.append(f"{left} -> {' | '.join(texts)}")
    return "\n".join(lines)


def read_grammar(text: str, where: str = "grammar") -> Grammar:
    """A grammar from its text; the first line's left side is the start symbol.

    Alternatives without a probability share what the others leave; all are scaled to sum to 1.

    Raises
    ------
    GrammarError, with the line, where a line is no rule, a name is none, or nothing is there.
    """
    alternatives: list[tuple[str, tuple[str, ...], float | None]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        bare = line.split("#", 1)[0].strip()
        if bare:
            alternatives.extend(_read_line(bare, f"{where}:{number}"))
    if not alternatives:
        raise GrammarError(
            f"{where}: expected at least one rule such as 'S -> a B', found none."
            " Write the start symbol's rule first."
        )
    return Grammar(alternatives[0][0], tuple(_share_out(alternatives)))


def _read_line(line: str, where: str) -> Iterable[tuple[str, tuple[str, ...], float | None]]:
    left, arrow, rights = line.partition("->")
    left = left.strip()
    if not arrow or not _NAME.fullmatch(left) or left == EMPTY:
        raise GrammarError(
            f"{where}: expected 'NAME -> symbols', found {line!r}."
            " A name begins with a letter; alternatives are divided by '|'."
        )
    for alternative in rights.split("|"):
        match = _ALTERNATIVE.match(alternative.strip())
        symbols = tuple(match["right"].split()) if match else ()
        wrong = [name for name in symbols if not _NAME.fullmatch(name)]
        if match is None or not symbols or wrong or (EMPTY in symbols and len(symbols) > 1):
            raise GrammarError(
                f"{where}: expected names after '->', found {alternative.strip()!r}."
                f" Write '{EMPTY}' alone for the empty string, a probability as [0.5] at the end."
            )
        chance = _probability(match["probability"], where)
        yield left, () if symbols == (EMPTY,) else symbols, chance


def _probability(text: str | None, where: str) -> float | None:
    if text is None:
        return None
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0.0 <= value < float("inf"):
        raise GrammarError(
            f"{where}: expected a probability of 0 or more in brackets, found [{text}]."
            " Write it as [0.5]."
        )
    return value


def _share_out(alternatives: list[tuple[str, tuple[str, ...], float | None]]) -> Iterator[Rule]:
    given: dict[str, list[float | None]] = {}
    for left, _, chance in alternatives:
        given.setdefault(left, []).append(chance)
    for left, right, chance in alternatives:
        stated = [value for value in given[left] if value is not None]
        open_ones = len(given[left]) - len(stated)
        rest = max(0.0, 1.0 - sum(stated)) / open_ones if open_ones else 0.0
        total = sum(stated) + rest * open_ones
        value = rest if chance is None else chance
        yield Rule(left, right, value / total if total > 0 else 1 / len(given[left]))


def nullable_symbols(grammar: Grammar) -> frozenset[str]:
    """The nonterminals that derive the empty string."""
    return _deriving(grammar, ())


def productive_symbols(grammar: Grammar) -> frozenset[str]:
    """The symbols that derive a string of terminals: all terminals among them."""
    return _deriving(grammar, grammar.terminals)


def _deriving(grammar: Grammar, leaves: Iterable[str]) -> frozenset[str]:
    """These leaves, and the nonterminals that derive a string of nothing else."""
    found = set(leaves)
    while True:
        more = {
            rule.left
            for rule in grammar.rules
            if rule.left not in found and all(symbol in found for symbol in rule.right)
        }
        if not more:
            return frozenset(found)
        found |= more


def reachable_symbols(grammar: Grammar) -> frozenset[str]:
    """The symbols that a derivation from the start symbol can meet, the start among them."""
    found, waiting = {grammar.start}, [grammar.start]
    while waiting:
        for number in grammar.rules_of.get(waiting.pop(), ()):
            for symbol in grammar.rules[number].right:
                if symbol not in found:
                    found.add(symbol)
                    waiting.append(symbol)
    return frozenset(found)


def check_grammar(grammar: Grammar) -> None:
    """Refuse a grammar that derives nothing, or has rules that no derivation can use.

    Raises
    ------
    GrammarError, naming the symbols.
    """
    if not grammar.rules or not grammar.is_nonterminal(grammar.start):
        raise GrammarError(
            f"grammar: expected a rule for the start symbol {grammar.start!r}, found none."
            " Learn from captures that hold at least one sentence, or write the rule."
        )
    endless = sorted(set(grammar.nonterminals) - productive_symbols(grammar))
    if endless:
        raise GrammarError(
            f"grammar: expected every nonterminal to derive a string, but {', '.join(endless)}"
            " never ends. Add a rule that leads to terminals."
        )
    lost = sorted(set(grammar.nonterminals) - reachable_symbols(grammar))
    if lost:
        raise GrammarError(
            f"grammar: expected every nonterminal to be reached from {grammar.start!r}, but"
            f" {', '.join(lost)} never is. Use it in a rule, or take its rules out."
        )


def derive_by(grammar: Grammar, choices: Sequence[int]) -> Tree:
    """The tree whose rules, in preorder, are ``choices``: how a parse is stored and read back.

    Raises
    ------
    GrammarError where a choice does not rewrite its symbol, choices are missing or left over, or
        the grammar has no rule to begin with.
    """
    if not grammar.is_nonterminal(grammar.start):
        check_grammar(grammar)  # says that there is no rule to begin with
    waiting = list(choices)[::-1]
    tree = _build(grammar, waiting)
    if waiting:
        raise GrammarError(
            f"derivation: expected {len(choices) - len(waiting)} rules, found {len(choices)}."
            " The parse belongs to another grammar: parse again."
        )
    return tree


def _build(grammar: Grammar, waiting: list[int]) -> Tree:
    # open nodes as [symbol, rule, children so far]; no recursion, for derivations can be deep
    open_nodes: list[tuple[str, int, list[Tree]]] = []
    symbol = grammar.start
    while True:
        if grammar.is_nonterminal(symbol):
            if not waiting or waiting[-1] not in grammar.rules_of[symbol]:
                found = f"rule {waiting[-1]}" if waiting else "the end"
                raise GrammarError(
                    f"derivation: expected a rule of {symbol!r}, found {found}."
                    " The parse belongs to another grammar: parse again."
                )
            open_nodes.append((symbol, waiting.pop(), []))
        else:
            open_nodes[-1][2].append(Tree(symbol))
        while len(open_nodes[-1][2]) == len(grammar.rules[open_nodes[-1][1]].right):
            left, rule, children = open_nodes.pop()
            done = Tree(left, rule, tuple(children))
            if not open_nodes:
                return done
            open_nodes[-1][2].append(done)
        _, rule, children = open_nodes[-1]
        symbol = grammar.rules[rule].right[len(children)]


def choices_of(tree: Tree) -> tuple[int, ...]:
    """The rules of a tree in preorder: the inverse of :func:`derive_by`."""
    return tuple(node.rule for node in tree.nodes() if not node.is_leaf)
