"""Random changes of rules in arrays: what an annealed search tries (see ``annealing``).

Each try looks over the rows of a table and writes the changed rows into one of the spare
``tables``; it gives the rows filled (0 where there is nothing to change), the end of the text, and
which table. A nonterminal is never put into its own rules or those it leads to.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from motiondb.grammar.induction.rewriting import (
    edit_places,
    occurrences,
    replace,
    unite,
    write_out,
    write_out_once,
)
from motiondb.grammar.induction.rule_arrays import LEFT, LENGTH, OFFSET, below

LONGEST_CHUNK = 10
LONGEST_MEMBER = 4


@njit(cache=True)
def next_bits(state):  # type: ignore[no-untyped-def]
    """The next 64 random bits."""
    state[0] += np.uint64(0x9E3779B97F4A7C15)
    z = state[0]
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


@njit(cache=True)
def draw(state, n):  # type: ignore[no-untyped-def]
    """A random number from 0 up to, not including, n."""
    return np.int64(next_bits(state) >> np.uint64(33)) % n


@njit(cache=True)
def chance(state):  # type: ignore[no-untyped-def]
    return np.float64(next_bits(state) >> np.uint64(11)) * 2.0**-53


@njit(cache=True)
def change(table, text, filled, end, n_terminals, alternatives, spared, tables, state):  # type: ignore[no-untyped-def]
    """One random change into ``tables[place]``: rows filled (0 for none), end, place."""
    kind = chance(state)
    if kind < 0.25:
        return _try_exchange(
            table, text, filled, end, n_terminals, alternatives, spared, tables, state
        )
    if kind < 0.55:
        return _try_class(
            table, text, filled, end, n_terminals, alternatives, spared, tables, state
        )
    if kind < 0.7:
        return _try_chunk(
            table, text, filled, end, n_terminals, alternatives, spared, tables, state
        )
    r = draw(state, filled)
    symbol = table[r, LEFT]
    if symbol == n_terminals:
        return 0, end, 0
    if kind < 0.82:
        return _try_fold(table, text, filled, end, n_terminals, r, spared, tables, state)
    if kind < 0.92:
        other = table[draw(state, filled), LEFT]
        if other in (symbol, n_terminals):
            return 0, end, 0
        n, end = unite(table, text, filled, end, tables[0], min(symbol, other), max(symbol, other))
        return n, end, 0
    if alternatives[symbol - n_terminals] == 1:
        n, end = write_out(table, text, filled, end, tables[0], symbol)
        return n, end, 0
    uses = 0
    for k in range(filled):
        offset = table[k, OFFSET]
        for d in range(offset, offset + table[k, LENGTH]):
            uses += text[d] == symbol
    if uses != 1:
        return 0, end, 0
    n, end = write_out_once(table, text, filled, end, tables[0], symbol)
    return n, end, 0


@njit(cache=True)
def _unused(alternatives, n_terminals):  # type: ignore[no-untyped-def]
    for k in range(1, alternatives.size):
        if alternatives[k] == 0:
            return k + n_terminals
    return -1


@njit(cache=True)
def _home(table, text, filled, n_terminals, part, length, state):  # type: ignore[no-untyped-def]
    """A nonterminal, not the start, that has the part as an alternative; -1 where none has."""
    shift = draw(state, filled)
    for d in range(filled):
        r = (d + shift) % filled
        if table[r, LENGTH] == length and table[r, LEFT] > n_terminals:
            same = True
            for k in range(length):
                if text[table[r, OFFSET] + k] != text[part + k]:
                    same = False
                    break
            if same:
                return table[r, LEFT]
    return -1


@njit(cache=True)
def _symbol_for(table, text, filled, n_terminals, alternatives, one, x, other, y, state):  # type: ignore[no-untyped-def]
    """The nonterminal for two parts: one of them, the home of one, any, or a new one."""
    way = chance(state)
    if way < 0.5:
        if x == 1 and text[one] > n_terminals:
            return text[one]
        if y == 1 and text[other] > n_terminals:
            return text[other]
    way = chance(state)
    if way < 0.65:
        first = way < 0.4
        for turn in range(2):
            if (turn == 0) == first:
                home = _home(table, text, filled, n_terminals, one, x, state)
            else:
                home = _home(table, text, filled, n_terminals, other, y, state)
            if home >= 0:
                return home
    elif way < 0.75:
        left = table[draw(state, filled), LEFT]
        if left != n_terminals:
            return left
    return _unused(alternatives, n_terminals)


@njit(cache=True)
def _try_exchange(table, text, filled, end, n_terminals, alternatives, spared, tables, state):  # type: ignore[no-untyped-def]
    a = draw(state, filled)
    left = table[a, LEFT]
    if alternatives[left - n_terminals] < 2:
        return 0, end, 0
    b, shift = a, draw(state, filled)
    for d in range(filled):
        r = (d + shift) % filled
        if r != a and table[r, LEFT] == left:
            b = r
            break
    n, m = table[a, LENGTH], table[b, LENGTH]
    one, other = table[a, OFFSET], table[b, OFFSET]
    least = min(n, m)
    p = q = 0
    if chance(state) < 0.5:
        while p < least and text[one + p] == text[other + p]:
            p += 1
        while q < least - p and text[one + n - 1 - q] == text[other + m - 1 - q]:
            q += 1
    else:
        while q < least and text[one + n - 1 - q] == text[other + m - 1 - q]:
            q += 1
        while p < least - q and text[one + p] == text[other + p]:
            p += 1
    if p + q == 0:
        return 0, end, 0
    if chance(state) < 0.1:  # what is shared may be shared by chance
        if chance(state) < 0.5:
            p -= draw(state, p + 1)
        else:
            q -= draw(state, q + 1)
        if p + q == 0:
            return 0, end, 0
    x, y = n - p - q, m - p - q
    return _join(
        table, text, filled, end, n_terminals, alternatives, spared, tables, state, a, p, x, b, p, y
    )


@njit(cache=True)
def _join(  # type: ignore[no-untyped-def]
    table, text, filled, end, n_terminals, alternatives, spared, tables, state, a, i, x, b, j, y
):
    """Two parts in two places become one nonterminal."""
    one, other = table[a, OFFSET] + i, table[b, OFFSET] + j
    symbol = _symbol_for(table, text, filled, n_terminals, alternatives, one, x, other, y, state)
    if symbol < 0:
        return 0, end, 0
    single = y == 1 and text[other] > n_terminals
    if x == 1 and text[one] == symbol and single and text[other] != symbol:
        n, end = unite(table, text, filled, end, tables[0], symbol, text[other])
        return n, end, 0
    below(table, text, filled, n_terminals, symbol, spared)
    if spared[table[a, LEFT] - n_terminals] or spared[table[b, LEFT] - n_terminals]:
        return 0, end, 0
    n, end = edit_places(table, text, filled, end, tables[0], a, i, x, b, j, y, symbol)
    return n, end, 0


@njit(cache=True)
def _try_class(table, text, filled, end, n_terminals, alternatives, spared, tables, state):  # type: ignore[no-untyped-def]
    a = draw(state, filled)
    n = table[a, LENGTH]
    i = draw(state, n + 1)
    x = draw(state, min(LONGEST_MEMBER, n - i) + 1)
    offset = table[a, OFFSET]
    before = text[offset + i - 1] if i > 0 else -1
    after = text[offset + i + x] if i + x < n else -2
    if before == -1 and after == -2:
        return 0, end, 0
    shift = draw(state, filled)
    b = j = y = -1
    for d in range(filled):
        r = (d + shift) % filled
        start, m = table[r, OFFSET], table[r, LENGTH]
        turn = draw(state, m + 1)
        for e in range(m + 1):
            k = (e + turn) % (m + 1)
            if (text[start + k - 1] if k > 0 else -1) != before:
                continue
            for length in range(min(LONGEST_MEMBER, m - k) + 1):
                if (text[start + k + length] if k + length < m else -2) != after:
                    continue
                if length == x and _same(text, offset + i, start + k, x):
                    continue
                if r == a and k < i + x + 1 and i < k + length + 1:
                    continue
                b, j, y = r, k, length
                break
            if b >= 0:
                break
        if b >= 0:
            break
    if b < 0 or x + y == 0:
        return 0, end, 0
    if a == b and j < i:
        i, j, x, y = j, i, y, x
    if x == 0 or y == 0 or chance(state) < 0.4:
        return _join(
            table, text, filled, end, n_terminals, alternatives, spared, tables, state,
            a, i, x, b, j, y,
        )  # fmt: skip
    one, other = table[a, OFFSET] + i, table[b, OFFSET] + j
    symbol = _symbol_for(table, text, filled, n_terminals, alternatives, one, x, other, y, state)
    if symbol < 0:
        return 0, end, 0
    if x == 1 and y == 1 and text[one] > n_terminals and text[other] > n_terminals:
        found, end = unite(table, text, filled, end, tables[0], text[one], text[other])
        return found, end, 0
    source, found, place = table, filled, 0
    for turn in range(2):
        # the longer first: the shorter may be part of it
        part, length = (one, x) if (turn == 0) == (x >= y) else (other, y)
        if length == 1 and text[part] == symbol:
            continue
        below(source, text, found, n_terminals, symbol, spared)
        found, end = replace(
            source, text, found, end, tables[place], part, length, symbol, spared, -1, n_terminals
        )
        if found < 0:
            return 0, end, 0
        source, place = tables[place], 1 - place
    return found, end, 1 - place


@njit(cache=True)
def _same(text, one, other, length):  # type: ignore[no-untyped-def]
    same = True
    for k in range(length):
        same = same and text[one + k] == text[other + k]
    return same


@njit(cache=True)
def _try_chunk(table, text, filled, end, n_terminals, alternatives, spared, tables, state):  # type: ignore[no-untyped-def]
    a = draw(state, filled)
    n = table[a, LENGTH]
    if n < 2:
        return 0, end, 0
    i = draw(state, n - 1)
    length = 2 + draw(state, min(LONGEST_CHUNK, n - i) - 1)
    part = table[a, OFFSET] + i
    number = 0
    for r in range(filled):
        number += occurrences(text, table[r, OFFSET], table[r, LENGTH], part, length)
    home = _home(table, text, filled, n_terminals, part, length, state)
    way = chance(state)
    symbol = home
    if home < 0 and way < 0.2:
        symbol = table[draw(state, filled), LEFT]
    elif home < 0 and number >= 2:
        symbol = _unused(alternatives, n_terminals)
    if symbol <= n_terminals:
        return 0, end, 0
    below(table, text, filled, n_terminals, symbol, spared)
    found, end = replace(
        table, text, filled, end, tables[0], part, length, symbol, spared, -1, n_terminals
    )
    return found, end, 0


@njit(cache=True)
def _try_fold(table, text, filled, end, n_terminals, r, spared, tables, state):  # type: ignore[no-untyped-def]
    part, length, symbol = table[r, OFFSET], table[r, LENGTH], table[r, LEFT]
    if length == 0:
        return 0, end, 0
    below(table, text, filled, n_terminals, symbol, spared)
    only = -1
    if chance(state) < 0.4:
        shift = draw(state, filled)
        for d in range(filled):
            k = (d + shift) % filled
            if not spared[table[k, LEFT] - n_terminals] and occurrences(
                text, table[k, OFFSET], table[k, LENGTH], part, length
            ):
                only = k
                break
    found, end = replace(
        table, text, filled, end, tables[0], part, length, symbol, spared, only, n_terminals
    )
    return found, end, 0
