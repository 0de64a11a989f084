"""Context-free grammars as records: rules, derivation trees, their text, checks.

A grammar G = {V, Sigma, R, S} has nonterminals V, terminals Sigma, production rules R and a start
symbol S in V. A rule rewrites one nonterminal into a string of terminals and nonterminals, which
may be empty. Symbols are names; a name is a nonterminal if and only if a rule has it on its left.

In the text form each line is a rule. Alternatives are separated by ``|``, ``empty`` is the empty
string, and alternatives that are not equally likely have a probability in brackets::

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

EMPTY = "empty"  # The empty string in the text of a grammar; no symbol may have this name

_MAX_QUOTED = 200  # Characters of a wrong text that a message quotes
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_'.-]*|<[0-9]+>")
_ALTERNATIVE = re.compile(r"(?P<right>[^\[\]]*)(?:\[(?P<probability>[0-9.eE+-]+)\])?")


class GrammarError(MotionDBError):
    """A grammar, or a string given to it, is not valid."""


@dataclass(frozen=True)
class Rule:
    """A rule ``left -> right`` with its ``probability`` among the rules of ``left``."""

    left: str
    right: tuple[str, ...]
    probability: float = 1.0

    def __str__(self) -> str:
        """Return the rule as text, without its probability."""
        return f"{self.left} -> {' '.join(self.right) or EMPTY}"


@dataclass(frozen=True)
class Tree:
    r"""A derivation; ``rule`` is the number of the rule that rewrites ``symbol``, -1 at a leaf.

    >>> toy = read_grammar("S -> a B c\nB -> b | empty")
    >>> print(derive_by(toy, (0, 1)))
    S(a B(b) c)
    """

    symbol: str
    rule: int = -1
    children: tuple[Tree, ...] = ()

    def __str__(self) -> str:
        """Return the tree as one line, with the children of each nonterminal in brackets."""
        parts: list[str] = []
        waiting: list[Tree | str] = [self]
        while waiting:  # a loop, because derivations can be too deep for recursion
            item = waiting.pop()
            if isinstance(item, str):
                parts.append(item)
            elif item.is_leaf:
                parts.append(item.symbol)
            else:
                inner: list[Tree | str] = [f"{item.symbol}("]
                for number, child in enumerate(item.children):
                    inner += [" ", child] if number else [child]
                waiting.extend(reversed([*inner, ")"]))
        return "".join(parts)

    @property
    def is_leaf(self) -> bool:
        """Whether this is a terminal."""
        return self.rule < 0

    def leaves(self) -> tuple[str, ...]:
        """Return the string that the tree derives."""
        terminals: list[str] = []
        waiting = [self]
        while waiting:
            tree = waiting.pop()
            if tree.is_leaf:
                terminals.append(tree.symbol)
            waiting.extend(reversed(tree.children))
        return tuple(terminals)

    def nodes(self) -> Iterator[Tree]:
        """Yield all nodes in preorder."""
        waiting = [self]
        while waiting:
            tree = waiting.pop()
            yield tree
            waiting.extend(reversed(tree.children))


@dataclass(frozen=True)
class Grammar:
    """A start symbol and rules.

    The order of the rules is kept; their numbers identify them.
    """

    start: str
    rules: tuple[Rule, ...]
    # All terminals of the rules, and possibly others that occur in no rule
    terminals: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Add the terminals of the rules that are missing."""
        used = {symbol for rule in self.rules for symbol in rule.right} - set(self.nonterminals)
        missing = sorted(used - set(self.terminals))
        object.__setattr__(self, "terminals", (*self.terminals, *missing))

    @cached_property
    def nonterminals(self) -> tuple[str, ...]:
        """Nonterminals V in the order of their first rules."""
        return tuple(dict.fromkeys(rule.left for rule in self.rules))

    @cached_property
    def rules_of(self) -> dict[str, tuple[int, ...]]:
        """Numbers of the rules of each nonterminal."""
        numbers: dict[str, list[int]] = {}
        for number, rule in enumerate(self.rules):
            numbers.setdefault(rule.left, []).append(number)
        return {left: tuple(rules) for left, rules in numbers.items()}

    def is_nonterminal(self, symbol: str) -> bool:
        """Whether a rule rewrites the symbol."""
        return symbol in self.rules_of

    def with_probabilities(self, weights: Sequence[float]) -> Grammar:
        """Return the same rules, probabilities proportional to ``weights`` (equal if all are 0)."""
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
    r"""Return the grammar as text, a nonterminal a line, the start symbol first.

    >>> print(format_grammar(read_grammar("S -> a A\nA -> x | y | empty")))
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


def read_grammar(text: str) -> Grammar:
    """Read a grammar from its text; the first line's left side is the start symbol.

    Alternatives without a probability share the remainder equally; all are scaled to sum to 1. One
    that is written several times has the sum of its shares.
    """
    alternatives: list[tuple[str, tuple[str, ...], float | None]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        bare = line.split("#", 1)[0].strip()
        if bare:
            alternatives.extend(_read_line(bare, f"grammar:{number}"))
    if not alternatives:
        raise GrammarError(
            "grammar: expected at least one rule such as 'S -> a B', found none."
            " Write the start symbol's rule first."
        )
    return Grammar(alternatives[0][0], tuple(share_out(alternatives)))


def _read_line(line: str, where: str) -> Iterable[tuple[str, tuple[str, ...], float | None]]:
    """Yield the alternatives of a line: left side, right side, probability."""
    left, arrow, rights = line.partition("->")
    left = left.strip()
    if not arrow or not _NAME.fullmatch(left) or left == EMPTY:
        raise GrammarError(
            f"{where}: expected 'NAME -> symbols', found {line[:_MAX_QUOTED]!r}."
            " A name begins with a letter; alternatives are divided by '|'."
        )
    for alternative in rights.split("|"):
        match = _ALTERNATIVE.fullmatch(alternative.strip())
        symbols = tuple(match["right"].split()) if match else ()
        wrong = [name for name in symbols if not _NAME.fullmatch(name)]
        if match is None or not symbols or wrong or (EMPTY in symbols and len(symbols) > 1):
            raise GrammarError(
                f"{where}: expected names after '->', found {alternative.strip()[:_MAX_QUOTED]!r}."
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


def share_out(alternatives: list[tuple[str, tuple[str, ...], float | None]]) -> Iterator[Rule]:
    """Yield every rule once; those without a probability get equal shares of the remainder.

    >>> for rule in read_grammar("S -> a | a | b").rules:
    ...     print(rule.right, round(rule.probability, 3))
    ('a',) 0.667
    ('b',) 0.333
    """
    given: dict[str, list[float | None]] = {}
    for left, _, chance in alternatives:
        given.setdefault(left, []).append(chance)
    shares: dict[str, tuple[float, float]] = {}  # of an alternative without one, and the sum of all
    for left, chances in given.items():
        stated = [value for value in chances if value is not None]
        n_open = len(chances) - len(stated)
        rest = max(0.0, 1.0 - sum(stated)) / n_open if n_open else 0.0
        shares[left] = rest, sum(stated) + rest * n_open
    summed: dict[tuple[str, tuple[str, ...]], float] = {}
    for left, right, chance in alternatives:
        rest, total = shares[left]
        value = rest if chance is None else chance
        share = value / total if total > 0 else 1 / len(given[left])
        summed[left, right] = summed.get((left, right), 0.0) + share
    for (left, right), probability in summed.items():
        yield Rule(left, right, probability)


def nullable_symbols(grammar: Grammar) -> frozenset[str]:
    """Return the nonterminals that derive the empty string."""
    return _deriving(grammar, ())


def productive_symbols(grammar: Grammar) -> frozenset[str]:
    """Return the symbols that derive a string of terminals, all terminals among them."""
    return _deriving(grammar, grammar.terminals)


def _deriving(grammar: Grammar, leaves: Iterable[str]) -> frozenset[str]:
    """Return these leaves, and the nonterminals that derive a string of leaves only."""
    return frozenset(derived_symbols(grammar.rules, leaves))


def derived_symbols(rules: Iterable[Rule], leaves: Iterable[str]) -> set[str]:
    """The leaves and every symbol that rules derive from them, in time linear in the rules."""
    deriving = set(leaves)
    missing: list[int] = []
    lefts: list[str] = []
    users: dict[str, list[int]] = {}  # symbol -> rules that wait for it
    complete: list[str] = []
    for rule in rules:
        absent = set(rule.right) - deriving
        for symbol in absent:
            users.setdefault(symbol, []).append(len(lefts))
        missing.append(len(absent))
        lefts.append(rule.left)
        if not absent:
            complete.append(rule.left)
    while complete:
        symbol = complete.pop()
        if symbol in deriving:
            continue
        deriving.add(symbol)
        for number in users.get(symbol, ()):
            missing[number] -= 1
            if not missing[number]:
                complete.append(lefts[number])
    return deriving


def reachable_symbols(grammar: Grammar) -> frozenset[str]:
    """Return the symbols that derivations from the start symbol can reach, the start included."""
    reached, waiting = {grammar.start}, [grammar.start]
    while waiting:
        for number in grammar.rules_of.get(waiting.pop(), ()):
            for symbol in grammar.rules[number].right:
                if symbol not in reached:
                    reached.add(symbol)
                    waiting.append(symbol)
    return frozenset(reached)


def check_grammar(grammar: Grammar) -> None:
    """Refuse a grammar that derives nothing, or has rules that no derivation can use."""
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
    """Return the tree whose rules, in preorder, are ``choices``.

    This is how a parse is stored and read back.
    """
    if not grammar.is_nonterminal(grammar.start):
        check_grammar(grammar)  # raises if there is no rule to begin with
    waiting = list(choices)[::-1]
    tree = _build(grammar, waiting)
    if waiting:
        raise GrammarError(
            f"derivation: expected {len(choices) - len(waiting)} rules, found {len(choices)}."
            " The parse belongs to another grammar: parse again."
        )
    return tree


def _build(grammar: Grammar, waiting: list[int]) -> Tree:
    """Build a tree from rules in reverse preorder, which are removed from ``waiting``."""
    # open nodes as [symbol, rule, children so far]; no recursion, for derivations can be deep
    open_nodes: list[tuple[str, int, list[Tree]]] = []
    symbol = grammar.start
    while True:
        if grammar.is_nonterminal(symbol):
            if not waiting or waiting[-1] not in grammar.rules_of[symbol]:
                rest = f"rule {waiting[-1]}" if waiting else "the end"
                raise GrammarError(
                    f"derivation: expected a rule of {symbol!r}, found {rest}."
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
    """Return the rules of a tree in preorder: the inverse of :func:`derive_by`."""
    return tuple(node.rule for node in tree.nodes() if not node.is_leaf)
