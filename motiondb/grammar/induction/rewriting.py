"""Changes of rules in arrays: parts replaced, places edited, nonterminals united and written out.

Each change reads the rows of one table and writes those of another; new right sides are appended
to the text that both share (see ``rule_arrays``). Rows that do not change are copied first and
compared with none; those that change are compared with all. Every function gives the rows filled
and the end of the text; -1 rows where there was no room.
"""

from __future__ import annotations

from numba import njit

from motiondb.grammar.induction.rule_arrays import COUNT, LEFT, LENGTH, OFFSET, put, references


@njit(cache=True)
def occurrences(text, offset, length, part, part_length):  # type: ignore[no-untyped-def]
    """How often a part stands in a right side, none overlapping the one before."""
    number, k = 0, offset
    last = offset + length - part_length
    while k <= last:
        same = True
        for d in range(part_length):
            if text[k + d] != text[part + d]:
                same = False
                break
        if same:
            number += 1
            k += part_length
        else:
            k += 1
    return number


@njit(cache=True)
def replace(  # type: ignore[no-untyped-def]
    source, text, filled, end, goal, part, part_length, symbol, spared, only, n_terminals
):
    """Put ``symbol`` for a part (a place in the text) wherever it stands, and make it its rule.

    spared : (nonterminals,), left sides whose rules stay as they are. only : a row, or -1 for all.
    """
    n = 0
    changed = goal.shape[0]  # numbers of changed rows, kept at the far end of the goal
    for r in range(filled):
        touched = False
        if (only < 0 or only == r) and not spared[source[r, LEFT] - n_terminals]:
            touched = occurrences(text, source[r, OFFSET], source[r, LENGTH], part, part_length) > 0
        if touched:
            changed -= 1
            goal[changed, 0] = r
        else:
            if n >= changed:
                return -1, end
            goal[n] = source[r]
            n += 1
    nodes = 0
    for c in range(goal.shape[0] - 1, changed - 1, -1):
        r = goal[c, 0]
        if n + 2 >= c or end + source[r, LENGTH] + part_length >= text.size:
            return -1, end
        written, k = end, source[r, OFFSET]
        stop = k + source[r, LENGTH]
        while k < stop:
            same = k + part_length <= stop
            if same:
                for d in range(part_length):
                    if text[k + d] != text[part + d]:
                        same = False
                        break
            if same:
                text[written] = symbol
                nodes += source[r, COUNT]
                k += part_length
            else:
                text[written] = text[k]
                k += 1
            written += 1
        n, end = put(goal, text, n, end, written - end, source[r, LEFT], source[r, COUNT])
    if nodes > 0:
        if end + part_length >= text.size:
            return -1, end
        for d in range(part_length):
            text[end + d] = text[part + d]
        n, end = put(goal, text, n, end, part_length, symbol, nodes)
    return n, end


@njit(cache=True)
def edit_places(source, text, filled, end, goal, a, i, x, b, j, y, symbol):  # type: ignore[no-untyped-def]
    """Put ``symbol`` for x symbols at place i of row a and y at j of row b: both are its rules.

    In one row, the first place must end before the second begins. A part that is the symbol
    itself makes no rule.
    """
    n = 0
    if filled + 4 >= goal.shape[0] or end + 3 * (source[a, LENGTH] + source[b, LENGTH]) + 8 >= (
        text.size
    ):
        return -1, end
    for r in range(filled):
        if r != a and r != b:
            goal[n] = source[r]
            n += 1
    if a == b:
        n, end = _write(source, text, n, end, goal, a, i, x, j, y, symbol)
    else:
        n, end = _write(source, text, n, end, goal, a, i, x, -1, 0, symbol)
        n, end = _write(source, text, n, end, goal, b, j, y, -1, 0, symbol)
    for d in range(x):
        text[end + d] = text[source[a, OFFSET] + i + d]
    n, end = put(goal, text, n, end, x, symbol, source[a, COUNT])
    for d in range(y):
        text[end + d] = text[source[b, OFFSET] + j + d]
    return put(goal, text, n, end, y, symbol, source[b, COUNT])


@njit(cache=True)
def _write(source, text, n, end, goal, r, i, x, j, y, symbol):  # type: ignore[no-untyped-def]
    written, k = end, 0
    offset, length = source[r, OFFSET], source[r, LENGTH]
    while k <= length:
        if k in (i, j):
            text[written] = symbol
            written += 1
            k += x if k == i else y
            if k in (i, j):  # an empty part: what stands there follows
                if k < length:
                    text[written] = text[offset + k]
                    written += 1
                k += 1
        else:
            if k < length:
                text[written] = text[offset + k]
                written += 1
            k += 1
    return put(goal, text, n, end, written - end, source[r, LEFT], source[r, COUNT])


@njit(cache=True)
def unite(source, text, filled, end, goal, symbol, other):  # type: ignore[no-untyped-def]
    """One nonterminal for two: ``other`` is renamed to ``symbol``."""
    n = 0
    if filled >= goal.shape[0]:
        return -1, end
    for turn in range(2):
        for r in range(filled):
            offset, length = source[r, OFFSET], source[r, LENGTH]
            touched = source[r, LEFT] == other
            for k in range(offset, offset + length):
                touched = touched or text[k] == other
            if turn == 0 and not touched:
                goal[n] = source[r]
                n += 1
            if turn == 0 or not touched:
                continue
            if end + length >= text.size:
                return -1, end
            for k in range(length):
                found = text[offset + k]
                text[end + k] = symbol if found == other else found
            left = symbol if source[r, LEFT] == other else source[r, LEFT]
            n, end = put(goal, text, n, end, length, left, source[r, COUNT])
    return n, end


@njit(cache=True)
def write_out(source, text, filled, end, goal, symbol):  # type: ignore[no-untyped-def]
    """A nonterminal with one rule is written out wherever it stands; its rule goes."""
    own = -1
    for r in range(filled):
        if source[r, LEFT] == symbol:
            own = r
    n = 0
    for turn in range(2):
        for r in range(filled):
            if r == own:
                continue
            offset, length = source[r, OFFSET], source[r, LENGTH]
            number = 0
            for k in range(offset, offset + length):
                number += text[k] == symbol
            if turn == 0 and number == 0:
                goal[n] = source[r]
                n += 1
            if turn == 0 or number == 0:
                continue
            if end + length + number * source[own, LENGTH] >= text.size:
                return -1, end
            written = end
            for k in range(offset, offset + length):
                if text[k] != symbol:
                    text[written] = text[k]
                    written += 1
                else:
                    for d in range(source[own, LENGTH]):
                        text[written] = text[source[own, OFFSET] + d]
                        written += 1
            n, end = put(goal, text, n, end, written - end, source[r, LEFT], source[r, COUNT])
    return n, end


@njit(cache=True)
def write_out_once(source, text, filled, end, goal, symbol):  # type: ignore[no-untyped-def]
    """The alternatives of a nonterminal that stands in one place, written into its rule."""
    user, place, n = -1, 0, 0
    for r in range(filled):
        offset = source[r, OFFSET]
        for k in range(source[r, LENGTH]):
            if text[offset + k] == symbol:
                user, place = r, k
    for r in range(filled):
        if r != user and source[r, LEFT] != symbol:
            goal[n] = source[r]
            n += 1
    offset, length = source[user, OFFSET], source[user, LENGTH]
    for r in range(filled):
        if source[r, LEFT] != symbol:
            continue
        if n >= goal.shape[0] or end + length + source[r, LENGTH] >= text.size:
            return -1, end
        written = end
        for k in range(length):
            if k != place:
                text[written] = text[offset + k]
                written += 1
            else:
                for d in range(source[r, LENGTH]):
                    text[written] = text[source[r, OFFSET] + d]
                    written += 1
        n, end = put(goal, text, n, end, written - end, source[user, LEFT], source[r, COUNT])
    return n, end


@njit(cache=True)
def tidy(table, text, filled, end, spare, n_terminals, alternatives, numbers):  # type: ignore[no-untyped-def]
    """Write out what is never worth a nonterminal: one rule used once, a rule that is one symbol.

    ``spare`` is a table for the work. Fills alternatives and references, as far as they are used.
    """
    while True:
        references(table, text, filled, n_terminals, numbers)
        alternatives[:] = 0
        for r in range(filled):
            alternatives[table[r, LEFT] - n_terminals] += 1
        idle, once = 0, False
        for k in range(1, numbers.size):
            if alternatives[k] > 0 and numbers[k] <= (alternatives[k] == 1):
                idle = k
        for r in range(filled):
            left = table[r, LEFT] - n_terminals
            if table[r, LENGTH] == 1 and alternatives[left] == 1 and left > 0:
                idle = left
            if table[r, LENGTH] == 1 and text[table[r, OFFSET]] > n_terminals and idle == 0:
                symbol = text[table[r, OFFSET]] - n_terminals
                if numbers[symbol] == 1:
                    idle, once = symbol, True
        if idle == 0:
            return filled, end
        if once:
            filled, end = write_out_once(table, text, filled, end, spare, idle + n_terminals)
        else:
            filled, end = write_out(table, text, filled, end, spare, idle + n_terminals)
        if filled < 0:
            return filled, end
        table[:filled] = spare[:filled]
