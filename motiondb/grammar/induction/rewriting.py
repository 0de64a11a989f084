"""Changes of rules in arrays: replace a part, merge two nonterminals, substitute a nonterminal.

Each change reads one table and writes another, ``goal``. New right sides are appended to the text
that both share (see :mod:`.rule_arrays`). Rows that do not change are copied first without
comparison; rows that change are compared with all others. Every change returns whether there was
room for it.
"""

from __future__ import annotations

from motiondb.grammar.induction.rule_arrays import (
    COUNT,
    LEFT,
    LENGTH,
    OFFSET,
    ROWS,
    SYMBOLS,
    Part,
    RuleTable,
    Substring,
    clear,
    copy_row,
    copy_rows,
    count_references,
    occurrences,
    put,
    same_symbols,
)
from motiondb.grammar.kernels import kernel
from motiondb.records import BoolArray, IntArray

_NOWHERE = -1  # ``first`` of a missing substring


@kernel
def replace(
    source: RuleTable, goal: RuleTable, part: Part, symbol: int, spared: BoolArray, only: int
) -> bool:
    """Replace a part by a nonterminal wherever it occurs, and make the part a rule of it.

    Parameters
    ----------
    source : RuleTable
        The rules.
    goal : RuleTable
        Filled with the changed rules.
    part : Part
        The part that is replaced.
    symbol : int
        The nonterminal.
    spared : array (nonterminals,)
        Left sides whose rules stay as they are.
    only : int
        The row to change, or -1 for all.
    """
    clear(goal, source)
    changed = goal.rows.shape[0]  # numbers of changed rows, kept at the far end of the goal
    for r in range(source.used[ROWS]):
        touched = False
        if (only < 0 or only == r) and not spared[source.rows[r, LEFT] - source.n_terminals]:
            touched = occurrences(source, r, part) > 0
        if touched:
            changed -= 1
            goal.rows[changed, 0] = r
        elif goal.used[ROWS] >= changed:
            return False
        else:
            copy_row(source, r, goal)
    nodes = 0
    for c in range(goal.rows.shape[0] - 1, changed - 1, -1):
        r = goal.rows[c, 0]
        room = source.rows[r, LENGTH] + part.length
        if goal.used[ROWS] + 2 >= c or not _has_room(goal, room):
            return False
        written, number = _write_replaced(source, goal.used[SYMBOLS], r, part, symbol)
        nodes += number * source.rows[r, COUNT]
        put(goal, written, source.rows[r, LEFT], source.rows[r, COUNT])
    return nodes == 0 or (_has_room(goal, part.length) and _put_part(goal, part, symbol, nodes))


@kernel
def _has_room(table: RuleTable, length: int) -> bool:
    """Return whether the text can hold ``length`` more symbols."""
    return bool(table.used[SYMBOLS] + length < table.text.size)


@kernel
def _write_replaced(
    source: RuleTable, end: int, r: int, part: Part, symbol: int
) -> tuple[int, int]:
    """Write a right side with a part replaced at ``end``; its length, and the replacements."""
    text = source.text
    number, written, k = 0, end, source.rows[r, OFFSET]
    stop = k + source.rows[r, LENGTH]
    while k < stop:
        if k + part.length <= stop and same_symbols(text, k, part.start, part.length):
            text[written] = symbol
            number += 1
            k += part.length
        else:
            text[written] = text[k]
            k += 1
        written += 1
    return written - end, number


@kernel
def _put_part(table: RuleTable, part: Part, symbol: int, nodes: int) -> bool:
    """Add the rule of a nonterminal whose right side is a part."""
    end = table.used[SYMBOLS]
    for d in range(part.length):
        table.text[end + d] = table.text[part.start + d]
    return put(table, part.length, symbol, nodes)


@kernel
def edit_substrings(
    source: RuleTable, goal: RuleTable, one: Substring, other: Substring, symbol: int
) -> bool:
    """Replace two substrings by a nonterminal, and make both rules of it.

    Parameters
    ----------
    source : RuleTable
        The rules.
    goal : RuleTable
        Filled with the changed rules.
    one : Substring
        The first substring. In one row, it must end before the second begins.
    other : Substring
        The second substring.
    symbol : int
        The nonterminal. A substring that is this symbol itself makes no rule.
    """
    rows = source.rows
    clear(goal, source)
    room = 3 * (rows[one.row, LENGTH] + rows[other.row, LENGTH]) + 8
    if source.used[ROWS] + 4 >= goal.rows.shape[0] or not _has_room(goal, room):
        return False
    for r in range(source.used[ROWS]):
        if r not in (one.row, other.row):
            copy_row(source, r, goal)
    if one.row == other.row:
        _put_edited(source, goal, one, other, symbol)
    else:
        none = Substring(one.row, _NOWHERE, 0)
        _put_edited(source, goal, one, none, symbol)
        _put_edited(source, goal, other, none, symbol)
    first = Part(rows[one.row, OFFSET] + one.first, one.length)
    second = Part(rows[other.row, OFFSET] + other.first, other.length)
    _put_part(goal, first, symbol, rows[one.row, COUNT])
    return _put_part(goal, second, symbol, rows[other.row, COUNT])


@kernel
def _put_edited(
    source: RuleTable, goal: RuleTable, one: Substring, other: Substring, symbol: int
) -> bool:
    """Add a row with the nonterminal in place of one or two of its substrings."""
    text = source.text
    written, k = goal.used[SYMBOLS], 0
    offset, length = source.rows[one.row, OFFSET], source.rows[one.row, LENGTH]
    while k <= length:
        if k in (one.first, other.first):
            text[written] = symbol
            written += 1
            k += one.length if k == one.first else other.length
            if k not in (one.first, other.first):
                continue
            # the part was empty: the symbol that stands there follows
        if k < length:
            text[written] = text[offset + k]
            written += 1
        k += 1
    left, nodes = source.rows[one.row, LEFT], source.rows[one.row, COUNT]
    return put(goal, written - goal.used[SYMBOLS], left, nodes)


@kernel
def merge(source: RuleTable, goal: RuleTable, symbol: int, other: int) -> bool:
    """Make two nonterminals one: ``other`` is renamed to ``symbol``."""
    rows, text = source.rows, source.text
    clear(goal, source)
    for r in range(source.used[ROWS]):
        if not _names(source, r, other):
            copy_row(source, r, goal)
    for r in range(source.used[ROWS]):
        if not _names(source, r, other):
            continue
        offset, length, end = rows[r, OFFSET], rows[r, LENGTH], goal.used[SYMBOLS]
        if not _has_room(goal, length):
            return False
        for k in range(length):
            old = text[offset + k]
            text[end + k] = symbol if old == other else old
        left = symbol if rows[r, LEFT] == other else rows[r, LEFT]
        put(goal, length, left, rows[r, COUNT])
    return True


@kernel
def _names(table: RuleTable, r: int, symbol: int) -> bool:
    """Whether a symbol occurs on either side of a row."""
    return bool(table.rows[r, LEFT] == symbol) or _uses(table, r, symbol) > 0


@kernel
def _uses(table: RuleTable, r: int, symbol: int) -> int:
    """Count how often a symbol occurs in the right side of a row."""
    number, offset = 0, table.rows[r, OFFSET]
    for k in range(offset, offset + table.rows[r, LENGTH]):
        number += table.text[k] == symbol
    return number


@kernel
def substitute(source: RuleTable, goal: RuleTable, symbol: int) -> bool:
    """Substitute a nonterminal wherever it occurs, and drop its rules.

    It has one rule or occurs once, so that it is known how often each new rule is used.
    """
    rows = source.rows
    clear(goal, source)
    n_rules = 0
    for r in range(source.used[ROWS]):
        n_rules += rows[r, LEFT] == symbol
        if rows[r, LEFT] != symbol and _uses(source, r, symbol) == 0:
            copy_row(source, r, goal)
    for r in range(source.used[ROWS]):
        number = _uses(source, r, symbol)
        if rows[r, LEFT] == symbol or number == 0:
            continue
        for rule in range(source.used[ROWS]):
            if rows[rule, LEFT] != symbol:
                continue
            if not _has_room(goal, rows[r, LENGTH] + number * rows[rule, LENGTH]):
                return False
            written = goal.used[SYMBOLS]
            for k in range(rows[r, LENGTH]):
                written = _write_symbol(source, rows[r, OFFSET] + k, written, symbol, rule)
            count = rows[r if n_rules == 1 else rule, COUNT]
            put(goal, written - goal.used[SYMBOLS], rows[r, LEFT], count)
    return True


@kernel
def _write_symbol(source: RuleTable, k: int, written: int, symbol: int, rule: int) -> int:
    """Write a symbol of the text at ``written``, or a right side for ``symbol``; return its end."""
    text = source.text
    if text[k] != symbol:
        text[written] = text[k]
        return written + 1
    for d in range(source.rows[rule, LENGTH]):
        text[written + d] = text[source.rows[rule, OFFSET] + d]
    return written + int(source.rows[rule, LENGTH])


@kernel
def tidy(table: RuleTable, spare: RuleTable, alternatives: IntArray, numbers: IntArray) -> bool:
    """Substitute nonterminals that never save bits: used once with one rule, or one symbol long.

    Parameters
    ----------
    table : RuleTable
        The rules; changed in place.
    spare : RuleTable
        Room for the work.
    alternatives : array (nonterminals,)
        Filled with the number of rules of each nonterminal.
    numbers : array (nonterminals,)
        Filled with the number of uses of each nonterminal.
    """
    while True:
        count_references(table, numbers)
        alternatives[:] = 0
        last = 0
        for r in range(table.used[ROWS]):
            left = table.rows[r, LEFT] - table.n_terminals
            alternatives[left] += 1
            last = max(last, left)
        idle = _idle_nonterminal(table, alternatives, numbers, last)
        if idle == 0:
            return True
        if not substitute(table, spare, idle + table.n_terminals):
            return False
        copy_rows(spare, table)


@kernel
def _idle_nonterminal(
    table: RuleTable, alternatives: IntArray, numbers: IntArray, last: int
) -> int:
    """Return a nonterminal to substitute, 0 for none.

    ``last`` is the greatest nonterminal that has rules.
    """
    idle = 0
    for k in range(1, last + 1):
        if alternatives[k] > 0 and numbers[k] <= (alternatives[k] == 1):
            idle = k
    for r in range(table.used[ROWS]):
        if table.rows[r, LENGTH] != 1:
            continue
        left = table.rows[r, LEFT] - table.n_terminals
        if alternatives[left] == 1 and left > 0:
            idle = left
        symbol = table.text[table.rows[r, OFFSET]] - table.n_terminals
        if symbol > 0 and idle == 0 and numbers[symbol] == 1:
            idle = symbol
    return idle
