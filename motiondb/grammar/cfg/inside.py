"""The engine: what a grammar derives between any two states of an automaton, in one pass.

W(X, s, t) is the weight of the derivations of symbol X whose strings lead from state s to state t:
their sum, the greatest of them, or their number (the semirings of :mod:`.closure`). Parsing,
lengths, patterns, plans and diagrams differ by the automaton alone (:mod:`.automata`).

    for each state s, from the last to the first; for each later state t, from the nearest:
        base[X]     = weight of the edges from s to t that read X
        base[Y Z]  += W(Y, s, u) W(Z, u, t), for all tails Y Z and states u strictly between
        W(., s, t)  = base, followed by all chains of steps that leave neither s nor t

Edges never lead back, so W(X, s, s) depends only on what may stay in s, its loop class: one least
solution for each class (:meth:`.compiled.CompiledGrammar.staying`). A step from (s, t) to (s, t) is
a rule A -> B, or a tail one child of which stays in s or in t. The sum over all chains of such
steps, unit cycles and left recursion included, is one closure for each pair of classes. So nothing
is iterated, and the result is exact. Only blocks of several states (a pattern such as ``... a b
...``) are iterated (:mod:`.blocks`).

A cell (s, t) lists its symbols in ascending order with their values. A value is a number times a
power of two that the whole cell shares, so that long sentences do not underflow. A tail takes its
left child from a dense row of the cells that begin at s, and its right child from the list of
(u, t): Cocke, Younger and Kasami, on sparse cells.

With ``shift`` an edge may lie anywhere, as in the automaton of lengths, where W(X, s, t) depends on
t - s alone: then only the row of state 0 is filled.

Sources: Y. Bar-Hillel, M. Perles and E. Shamir, "On Formal Properties of Simple Phrase Structure
Grammars" (1961); M.-J. Nederhof and G. Satta, "Probabilistic Parsing as Intersection", IWPT 2003;
J. Goodman, "Semiring Parsing", Computational Linguistics 25 (1999).
"""

from __future__ import annotations

from functools import lru_cache
from math import frexp, inf, ldexp, log
from typing import NamedTuple

import numpy as np

from motiondb.grammar.cfg.automata import Automaton
from motiondb.grammar.cfg.closure import BEST, SUM
from motiondb.grammar.cfg.compiled import CompiledGrammar, Parts, Tails
from motiondb.grammar.cfg.context_free import GrammarError
from motiondb.grammar.kernels import kernel, maker, merged
from motiondb.records import FloatArray, IntArray

MOST_PRODUCTS = 500_000_000
"""Largest number of products of two cells' entries in a chart. They take 3 to 5 s, and a
sentence that is refused needs two charts, so the answer comes within 10 s. Learned grammars need
far fewer: a passage of 900 symbols takes 0.1 s."""
MOST_ENTRIES = 12_000_000
"""Largest number of entries of a chart: 192 MB, and twice that while the arrays grow."""


class Inside(NamedTuple):
    """The weights between the Q states of an automaton."""

    # Three arrays (Q, Q), of one row with ``shift``:
    begin: IntArray  # Index of the first entry of each cell
    end: IntArray  # Index after the last entry of each cell
    exponents: IntArray  # The power of two of each cell
    symbols: IntArray  # (entries,): symbol of each entry, ascending within a cell
    values: FloatArray  # (entries,): value of each entry, before the power of two of its cell
    staying: FloatArray  # (classes, S): weight of leading from a state to itself, by loop class
    loops: IntArray  # (Q,): loop class of each state, -1 where cells hold these weights, too
    shift: bool  # Whether the cell (s, t) is that of (0, t - s)

    def weight(self, symbol: int, s: int = 0, t: int = -1) -> float:
        """Return W of a symbol, from the first state to the last unless others are given."""
        value, exponent = find(self, symbol, s, t % len(self.loops))
        return ldexp(value, int(exponent))

    def log_weight(self, symbol: int, s: int = 0, t: int = -1) -> float:
        """Return log W of a symbol; -inf for 0."""
        return float(log_of(self, symbol, s, t % len(self.loops)))


class Rules(NamedTuple):
    """The rules of a compiled grammar."""

    by_right: Tails  # The tails of each right child
    left: IntArray  # (S,): left child of each symbol that is a tail, else -1
    right: IntArray  # (S,): right child of each symbol that is a tail, else -1
    rule_of: IntArray  # (S + 1,): index of the first rule of each symbol
    rule_right: IntArray  # (R,): right side of a rule, -1 for the empty string
    weights: FloatArray  # (R,): weight of a rule, or its logarithm
    parts: Parts  # Groups of symbols that derive one another
    first: int  # The first terminal


class Closures(NamedTuple):
    """What depends on loop classes, not on states."""

    staying: FloatArray  # (classes, S)
    pairs: IntArray  # (classes, classes): index of the chains of each pair
    starts: IntArray  # (pairs, S + 1)
    columns: IntArray
    values: FloatArray


class Work(NamedTuple):
    """Cells of one state as dense rows; values by symbol, and lists of symbols that have one."""

    row: FloatArray  # (Q, S): values of the cells that begin at the state
    splits: IntArray  # (Q,): list of the states where such a cell ends
    n_splits: IntArray  # (1,): length of this list
    base: FloatArray  # (S,): values of a cell before the chains
    full: FloatArray  # (S,): values of a cell after the chains
    touched: IntArray  # (S,): list of the symbols with a value in ``base``
    reached: IntArray  # (S,): list of the symbols with a value in ``full``


def inside(
    compiled: CompiledGrammar, automaton: Automaton, kind: int = SUM, *, shift: bool = False
) -> Inside:
    """Return the weights of all symbols between all states of an automaton.

    >>> from motiondb.grammar.cfg import automata
    >>> from motiondb.grammar.cfg.compiled import compile_grammar
    >>> from motiondb.grammar.cfg.context_free import read_grammar
    >>> made = compile_grammar(read_grammar("S -> S S [0.25] | a [0.75]"))
    >>> round(inside(made, automata.sentence(np.zeros(2, int), 1)).weight(made.start), 6)
    0.140625
    """
    loops = automaton.loops
    pairs: tuple[tuple[int, int], ...] = ((0, 0),) if len(loops) > 1 else ()
    if len(automaton.stays) > 1:
        later = [loops[s + 1 :] for s in range(len(loops))]
        met = {(c, d) for c, row in zip(loops.tolist(), later) if c >= 0 for d in set(row.tolist())}
        pairs = tuple(sorted(pair for pair in met if pair[1] >= 0))
    closures = _closures(compiled, kind, automaton.stays.tobytes(), len(automaton.stays), pairs)
    rules = rules_of(compiled, kind)
    how = kind == BEST, automaton, rules, closures, shift
    if len(automaton.bounds) > len(loops):
        made, is_whole = _fill(*how)
    else:
        from motiondb.grammar.cfg.blocks import fill_blocks

        made, is_whole = fill_blocks(*how)
    if not is_whole:
        raise GrammarError(
            f"sentence: expected a chart of at most {MOST_PRODUCTS:,} products and"
            f" {MOST_ENTRIES:,} entries, found more for {automaton.n_states - 1:,} symbols: too"
            " many symbols of the grammar derive the same spans. Give the sentence in parts, or use"
            " a grammar with fewer alternatives."
        )
    return made


@lru_cache(maxsize=64)
def rules_of(compiled: CompiledGrammar, kind: int) -> Rules:
    """Return the rules of a compiled grammar with the weights of a semiring."""
    return Rules(
        compiled.by_right,
        compiled.left,
        compiled.right,
        compiled.rule_of,
        compiled.rule_right,
        compiled.weights(kind),
        compiled.parts_first,
        compiled.n_nonterminals,
    )


@lru_cache(maxsize=64)
def _closures(
    compiled: CompiledGrammar, kind: int, stays: bytes, n: int, pairs: tuple[tuple[int, int], ...]
) -> Closures:
    """Return the weights of staying of each loop class, and the chains of pairs of classes."""
    classes = np.frombuffer(stays).reshape(n, -1)
    staying = np.array([compiled.staying(kind, terminals) for terminals in classes])
    staying = staying.reshape(n, compiled.n_symbols)
    numbers = np.full((n, n), -1)
    made = [compiled.chains(kind, staying[s], staying[t]) for s, t in pairs]
    for number, pair in enumerate(pairs):
        numbers[pair] = number
    offsets = np.cumsum([0, *(len(one.columns) for one in made)])
    none = [np.zeros(0, np.int64)]
    return Closures(
        staying,
        numbers,
        np.array([one.starts + used for one, used in zip(made, offsets)], dtype=np.int64).reshape(
            len(made), compiled.n_symbols + 1
        ),
        np.concatenate([one.columns for one in made] + none),
        np.concatenate([one.values for one in made] + [np.zeros(0)]),
    )


@kernel
def find(made: Inside, symbol: int, s: int, t: int) -> tuple[float, int]:
    """Return value and exponent of W of a symbol between two states; value 0 if it has none."""
    if s == t and made.loops[s] >= 0:
        return made.staying[made.loops[s], symbol], 0
    if made.shift:
        s, t = 0, t - s
    low, high = made.begin[s, t], made.end[s, t]
    while low < high:  # binary search
        middle = (low + high) // 2
        if made.symbols[middle] < symbol:
            low = middle + 1
        else:
            high = middle
    if low < made.end[s, t] and made.symbols[low] == symbol:
        return made.values[low], made.exponents[s, t]
    return 0.0, 0


@kernel
def log_of(made: Inside, symbol: int, s: int, t: int) -> float:
    """Return log W of a symbol between two states, -inf for 0."""
    value, exponent = find(made, symbol, s, t)
    return log(value) + exponent * log(2.0) if value > 0.0 else -inf


@maker
def _fill(
    best: bool, auto: Automaton, rules: Rules, closures: Closures, shift: bool
) -> tuple[Inside, bool]:
    """Fill all cells of an automaton without blocks of several states.

    Also returns whether they are complete, or grew too large.
    """
    made, work = empty_cells(auto, rules, closures.staying, shift)
    n, used, n_products = len(auto.loops), 0, 0
    for i in range(0 if shift else n - 1, -1, -1):
        row = (i, i + 1, n)
        made, used, more = fill_row(best, row, auto, rules, closures, made, used, work)
        empty_row(made, i, work)
        n_products += more
        if n_products > MOST_PRODUCTS or used > MOST_ENTRIES:
            return made, False
    return made, True


@maker
def empty_cells(
    auto: Automaton, rules: Rules, staying: FloatArray, shift: bool
) -> tuple[Inside, Work]:
    """Return empty cells, and room for the work."""
    n, n_symbols = len(auto.loops), len(rules.left)
    rows = 1 if shift else n
    cells, none = np.zeros((3, rows, n), np.int64), np.zeros(256, np.int64)
    made = Inside(cells[0], cells[1], cells[2], none, np.zeros(256), staying, auto.loops, shift)
    return made, Work(
        np.zeros((n, n_symbols)),
        np.zeros(n, np.int64),
        np.zeros(1, np.int64),
        np.zeros(n_symbols),
        np.zeros(n_symbols),
        np.zeros(n_symbols, np.int64),
        np.zeros(n_symbols, np.int64),
    )


@maker
def fill_row(
    best: bool,
    row: tuple[int, int, int],
    auto: Automaton,
    rules: Rules,
    closures: Closures,
    made: Inside,
    used: int,
    work: Work,
) -> tuple[Inside, int, int]:
    """Fill the cells from a state i to the states [first, last), of one ``row`` (i, first, last).

    Returns the weights, the number of entries so far, and the number of products, which is too
    large if the row was given up.
    """
    i, first, last = row
    edge, n_products = auto.starts[i], 0
    for j in range(first, last):
        begin, edge = _edges(auto.starts, auto.targets, i, j, edge)
        top = _top_exponent(made, work, (i, j), edge > begin)
        for e in range(begin, edge):
            symbol = rules.first + auto.terminals[e]
            work.touched[e - begin] = symbol
            work.base[symbol] = ldexp(auto.weights[e], -top)
        span = (i, j, top, edge - begin)
        n_touched, more = _combine(best, made, rules.by_right, rules.left, work, span)
        pair = closures.pairs[auto.loops[i], auto.loops[j]]
        n_reached = _climb(best, n_touched, closures, pair, work)
        n_products += more
        if n_products > MOST_PRODUCTS or used + n_reached > MOST_ENTRIES:
            return made, used, MOST_PRODUCTS + 1
        made = grown(made, used + n_reached)
        used = store(made, (i, j), used, work, n_reached, top)
        add_splits(made, i, (j, j + 1), work)
    return made, used, n_products


@kernel
def add_splits(made: Inside, i: int, states: tuple[int, int], work: Work) -> None:
    """List those of the states [first, last) where a cell that begins at i ends."""
    for t in range(states[0], states[1]):
        if made.begin[i, t] < made.end[i, t]:
            work.splits[work.n_splits[0]] = t
            work.n_splits[0] += 1


@kernel
def empty_row(made: Inside, i: int, work: Work) -> None:
    """Empty the dense row of the cells that begin at a state, and the list of their ends."""
    for place in range(work.n_splits[0]):
        j = work.splits[place]
        for entry in range(made.begin[i, j], made.end[i, j]):
            work.row[j, made.symbols[entry]] = 0.0
    work.n_splits[0] = 0


@merged
def _edges(starts: IntArray, targets: IntArray, i: int, j: int, edge: int) -> tuple[int, int]:
    """Return the first edge from i to j and the one after the last, of those from ``edge`` on."""
    while edge < starts[i + 1] and targets[edge] < j:
        edge += 1
    first = edge
    while edge < starts[i + 1] and targets[edge] == j:
        edge += 1
    return first, edge


@maker
def grown(made: Inside, needed: int) -> Inside:
    """Return the weights with room for more entries, if more are needed."""
    if needed <= len(made.symbols):
        return made
    more = max(needed - len(made.symbols), len(made.symbols))
    return Inside(
        made.begin,
        made.end,
        made.exponents,
        np.append(made.symbols, np.zeros(more, np.int64)),
        np.append(made.values, np.zeros(more)),
        made.staying,
        made.loops,
        made.shift,
    )


@kernel
def store(
    made: Inside, cell: tuple[int, int], used: int, work: Work, n_reached: int, top: int
) -> int:
    """Write ``full`` (emptied) as a cell and a row; return the number of entries so far."""
    full, reached, row = work.full, work.reached, work.row
    shift = _shift(full, reached, n_reached)
    made.begin[cell], made.exponents[cell] = used, top + shift
    _sort(reached, n_reached)
    for place in range(n_reached):
        symbol = reached[place]
        value = ldexp(full[symbol], -shift)
        made.symbols[used], made.values[used], row[cell[1], symbol] = symbol, value, value
        full[symbol] = 0.0
        used += 1
    made.end[cell] = used
    return used


@kernel
def _combine(
    best: bool,
    made: Inside,
    by_right: Tails,
    left: IntArray,
    work: Work,
    span: tuple[int, int, int, int],
) -> tuple[int, int]:
    """Add the tails between two states, split at every state, to ``base``.

    Returns the number of symbols with a value, and the number of products that were evaluated, of
    which a split is one.
    """
    i, j, top, n_touched = span
    starts, tails, row = by_right.starts, by_right.tails, work.row
    base, touched, symbols, values = work.base, work.touched, made.symbols, made.values
    n_products = work.n_splits[0]
    for place in range(work.n_splits[0]):
        k = work.splits[place]
        one, other = (0, j - k) if made.shift else (k, j)
        low, high = made.begin[one, other], made.end[one, other]
        if low == high:
            continue
        shift = made.exponents[i, k] + made.exponents[one, other] - top
        factor = ldexp(1.0, shift) if shift else 1.0
        for entry in range(low, high):
            symbol = symbols[entry]
            second = values[entry] * factor
            n_products += starts[symbol + 1] - starts[symbol]
            for t in range(starts[symbol], starts[symbol + 1]):
                tail = tails[t]
                first = row[k, left[tail]]
                if first == 0.0:  # no value; an infinite count times 0 would be NaN
                    continue
                value = first * second
                if value == 0.0:
                    continue
                if base[tail] == 0.0:
                    touched[n_touched] = tail
                    n_touched += 1
                base[tail] = max(base[tail], value) if best else base[tail] + value
    return n_touched, n_products


@merged
def _climb(best: bool, n_touched: int, closures: Closures, pair: int, work: Work) -> int:
    """Follow the chains from ``base`` (emptied) to ``full``; return the number of symbols."""
    base, full, starts = work.base, work.full, closures.starts
    n_reached = 0
    for place in range(n_touched):
        symbol = work.touched[place]
        for c in range(starts[pair, symbol], starts[pair, symbol + 1]):
            above, value = closures.columns[c], closures.values[c] * base[symbol]
            if value == 0.0:
                continue
            if full[above] == 0.0:
                work.reached[n_reached] = above
                n_reached += 1
            full[above] = max(full[above], value) if best else full[above] + value
        base[symbol] = 0.0
    return n_reached


@merged
def _sort(numbers: IntArray, n: int) -> None:
    """Shell's sort of n numbers in place: it compiles faster than a general one."""
    gap = n // 2
    while gap > 0:
        for i in range(gap, n):
            number, j = numbers[i], i
            while j >= gap and numbers[j - gap] > number:
                numbers[j] = numbers[j - gap]
                j -= gap
            numbers[j] = number
        gap //= 2


@merged
def _top_exponent(made: Inside, work: Work, cell: tuple[int, int], is_known: bool) -> int:
    """Return the greatest power of two among the products; that of an edge is 0."""
    (i, j), exponents, top = cell, made.exponents, 0
    for place in range(work.n_splits[0]):
        k = work.splits[place]
        one, other = (0, j - k) if made.shift else (k, j)
        if made.begin[one, other] < made.end[one, other]:
            exponent = exponents[i, k] + exponents[one, other]
            if not is_known or exponent > top:
                top, is_known = exponent, True
    return top


@kernel
def _shift(full: FloatArray, reached: IntArray, n_reached: int) -> int:
    """Return the power of two of the greatest finite value of a cell."""
    greatest = 0.0
    for place in range(n_reached):
        value = full[reached[place]]
        if value > greatest and value < inf:
            greatest = value
    return frexp(greatest)[1] if greatest > 0.0 else 0
