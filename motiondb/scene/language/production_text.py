"""The right sides of production rules in text: alternatives, repetitions, probabilities.

``A -> x (y | z)* w? | empty [0.2]`` is rewritten into plain rules with auxiliary nonterminals::

    X*   H -> empty | X H        X+   H -> X | X H
    X?   H -> empty | X          (x | y)   H -> x | y
    (x & y)   all of them in any order, each order equally probable: H -> x y | y x

An auxiliary nonterminal is named by the left side, a dot, and a number; names in a file contain no
dot.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

from motiondb.grammar.cfg.context_free import EMPTY
from motiondb.scene.language.tokens import Cursor, Token

Alternative = tuple[str, tuple[str, ...], float | None]
"""Left side, right side, probability where one was written."""

_DEEPEST = 50  # Most brackets inside one another: far from Python's limit of nested calls
_MOST_ORDERED = 8  # Most parts in any order: 2^8 nonterminals
_ADVICE = f"Write names, ( ) | & * + ? and probabilities as [0.5]; '{EMPTY}' is the empty string."


def read_alternatives(cursor: Cursor, left: str, used: dict[str, Token]) -> list[Alternative]:
    """Return all rules that the tokens after ``->`` describe."""
    alternatives: list[Alternative] = []
    helpers: list[Alternative] = []
    names = (f"{left}.{n}" for n in range(_next_number(used, left), 10**6))
    while True:
        symbols = _read_sequence(cursor, names, helpers, used)
        alternatives.append((left, symbols, _read_probability(cursor)))
        if not cursor.meets("|"):
            return [*alternatives, *helpers]


def _next_number(used: dict[str, Token], left: str) -> int:
    """Return the first free number of an auxiliary nonterminal of this left side."""
    return 1 + sum(name.startswith(f"{left}.") for name in used)


def _read_sequence(
    cursor: Cursor,
    names: Iterator[str],
    helpers: list[Alternative],
    used: dict[str, Token],
    depth: int = 0,
) -> tuple[str, ...]:
    """Read the symbols of one alternative; auxiliary rules are added to ``helpers``."""
    first = cursor.here
    if depth > _DEEPEST:
        cursor.fail(f"at most {_DEEPEST} brackets in one another", "Give the inner ones a name.")
    symbols: list[str] = []
    while cursor.here.kind == "name" or cursor.here.text == "(":
        token = cursor.here
        if cursor.meets("("):
            symbol = _read_bracket(cursor, names, helpers, used, depth)
        else:
            symbol = cursor.take().text
            if symbol != EMPTY:
                used.setdefault(symbol, token)
        symbols.append(_repeated(cursor, symbol, names, helpers, used))
    if not symbols:
        cursor.fail("a symbol", _ADVICE)
    if EMPTY in symbols:
        if len(symbols) > 1:
            cursor.fail(f"'{EMPTY}' alone", _ADVICE, first)
        return ()
    return tuple(symbols)


def _read_bracket(
    cursor: Cursor,
    names: Iterator[str],
    helpers: list[Alternative],
    used: dict[str, Token],
    depth: int,
) -> str:
    """Read what follows ``(``: alternatives, or parts in any order; return its nonterminal."""
    symbol, token = next(names), cursor.here
    used[symbol] = token
    parts = [_read_sequence(cursor, names, helpers, used, depth + 1)]
    sign = cursor.here.text
    while sign in ("|", "&") and cursor.meets(sign):
        parts.append(_read_sequence(cursor, names, helpers, used, depth + 1))
    if sign != "&":
        helpers.extend((symbol, part, None) for part in parts)
    else:
        if len(parts) > _MOST_ORDERED:
            cursor.fail(f"at most {_MOST_ORDERED} parts in any order", _ADVICE, token)
        left = {frozenset(range(len(parts))): symbol}  # what is still to come -> its nonterminal
        for rest in list(_smaller(len(parts))):
            left[rest] = next(names)
            used[left[rest]] = token
        for rest, name in left.items():
            for k in sorted(rest):
                others = [left[rest - {k}]] if len(rest) > 1 else []
                helpers.append((name, (*parts[k], *others), None))
    cursor.expect(")", "Close the bracket.")
    return symbol


def _smaller(n: int) -> Iterator[frozenset[int]]:
    """Yield the sets of 1 to n - 1 of n numbers, the larger ones first."""
    for size in range(n - 1, 0, -1):
        yield from map(frozenset, combinations(range(n), size))


def _repeated(
    cursor: Cursor,
    symbol: str,
    names: Iterator[str],
    helpers: list[Alternative],
    used: dict[str, Token],
) -> str:
    """Read a sign of repetition, and return the symbol or its auxiliary nonterminal."""
    token = cursor.here
    if symbol == EMPTY or not cursor.meets("*", "+", "?"):
        return symbol
    helper = next(names)
    used[helper] = token
    shapes: dict[str, tuple[tuple[str, ...], ...]] = {
        "*": ((), (symbol, helper)),
        "+": ((symbol,), (symbol, helper)),
        "?": ((), (symbol,)),
    }
    helpers.extend((helper, right, None) for right in shapes[token.text])
    return helper


def _read_probability(cursor: Cursor) -> float | None:
    """Read a probability in square brackets, or return None if there is none."""
    if not cursor.meets("["):
        return None
    token = cursor.here
    value = cursor.number("a probability", _ADVICE)
    if not 0.0 < value <= 1.0:
        cursor.fail("a probability above 0 and at most 1", "Leave out what never happens.", token)
    cursor.expect("]", "Close the bracket.")
    return value
