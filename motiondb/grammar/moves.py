"""Moves that rewrite rules: what can be exchanged, named, folded, united and written out.

Each kind of move looks over a rule set and gives moves with a first guess of the symbols they
save; a move makes the changed rule set, or None where it changes nothing. All keep the number of
nodes of every rule, so that the description length of the sentences can be read off again.

Sources: M. van Zaanen, "ABL: Alignment-Based Learning", COLING 2000, for exchange; P. Langley and
S. Stromsten, "Learning Context-Free Grammars with a Simplicity Bias", ECML 2000, for the others.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations

from motiondb.grammar.alignment import Slot, align
from motiondb.grammar.rule_set import Right, RuleSet

Move = Callable[[RuleSet], RuleSet | None]
Scored = tuple[float, Move]

LONGEST_CHUNK = 24
LONGEST_MEMBER = 3
"""Symbols of a string that may become a member of a class by its neighbours alone."""

_CROWD = 30
"""Where more strings than this stand between the same neighbours, these say nothing."""

_WORST = -8
"""Symbols that an exchange or a chunk may lose and still be tried."""


def chunk_saves(length: int, number: int) -> int:
    """Symbols saved by a nonterminal that stands for so many occurrences of a string."""
    return number * (length - 1) - length - 2


@dataclass(frozen=True)
class _Way:
    """One alignment of two right sides: its slots, the parts in them, what it saves if all new."""

    slots: tuple[Slot, ...]
    pairs: tuple[tuple[Right, Right], ...]
    parts: frozenset[Right]
    saved: int


@lru_cache(maxsize=1 << 17)
def _ways(one: Right, other: Right) -> tuple[_Way, ...]:
    """The alignments, without and with bias; none where nothing is common."""
    if set(one).isdisjoint(other):
        return ()
    found = []
    for slots in sorted({align(one, other, biased) for biased in (False, True)}):
        pairs = tuple((one[a:b], other[c:d]) for (a, b), (c, d) in slots)
        outside = len(one) - sum(len(x) for x, _ in pairs)
        saved = len(one) + len(other) + 2 - outside - len(slots)
        saved -= sum(_worth(x, y) for x, y in pairs)
        parts = frozenset(part for pair in pairs for part in pair)
        found.append(_Way(slots, pairs, parts, saved))
    return tuple(found)


def _worth(x: Right, y: Right) -> int:
    """Symbols of the two rules of a new nonterminal."""
    return len(x) + len(y) + 4


def exchanges(rule_set: RuleSet) -> Iterator[Scored]:
    """Pairs of right sides of one nonterminal, by the symbols that making them one would save."""
    homes: dict[Right, set[int]] = {}
    for left, right in rule_set.uses():
        homes.setdefault(right, set()).add(left)
    known = {*homes, *((left,) for left in rule_set.rules)}
    for left, rights in rule_set.rules.items():
        for one, other in combinations(sorted(rights), 2):
            for way in _ways(one, other):
                if known.isdisjoint(way.parts):
                    if way.saved > _WORST:
                        yield way.saved, exchange(left, one, other, way.slots, False)
                    continue
                saved = way.saved + sum(_known_worth(rule_set, homes, *pair) for pair in way.pairs)
                if saved > _WORST:
                    yield saved, exchange(left, one, other, way.slots, False)
                    if not way.parts.isdisjoint(homes):
                        yield saved, exchange(left, one, other, way.slots, True)


def _known_worth(rule_set: RuleSet, homes: dict[Right, set[int]], x: Right, y: Right) -> int:
    """Symbols that need not be written since a nonterminal has one part, or both, already."""
    x_alone, y_alone = _alone(rule_set, x), _alone(rule_set, y)
    if x_alone and y_alone:
        return _worth(x, y)
    if x_alone or y_alone:
        left, part = (x[0], y) if x_alone else (y[0], x)
        return _worth(x, y) - (0 if part in rule_set.rules[left] else len(part) + 2)
    if x in homes and y in homes and homes[x] & homes[y]:
        return _worth(x, y)
    return 0


def _alone(rule_set: RuleSet, part: Right) -> bool:
    return len(part) == 1 and part[0] in rule_set.rules


def exchange(left: int, one: Right, other: Right, slots: tuple[Slot, ...], widen: bool) -> Move:
    def move(rule_set: RuleSet) -> RuleSet | None:
        changed = rule_set.copy()
        rights = changed.rules[left]
        n_one, n_other = rights.pop(one), rights.pop(other)
        united: dict[int, int] = {}
        joint: list[int] = []
        i = 0
        for (a, b), (c, d) in slots:
            joint.extend(one[i:a])
            parts = ((one[a:b], n_one), (other[c:d], n_other))
            joint.append(_slot_symbol(changed, parts, united, widen))
            i = b
        joint.extend(one[i:])
        if joint == [left]:
            return None
        changed.add(left, tuple(joint), n_one + n_other)
        if united:
            changed.rename({symbol: _root(united, symbol) for symbol in united})
        return changed

    return move


def _slot_symbol(
    changed: RuleSet,
    parts: tuple[tuple[Right, int], tuple[Right, int]],
    united: dict[int, int],
    widen: bool,
) -> int:
    """The nonterminal that stands for two exchangeable parts, its rules counted."""
    (x, n_x), (y, n_y) = parts
    if _alone(changed, x) and _alone(changed, y):
        low, high = sorted((_root(united, x[0]), _root(united, y[0])))
        if low != high:
            united[high] = low
        return low
    for (part, _), (rest, n_rest) in (parts, parts[::-1]):
        if _alone(changed, part):
            changed.add(part[0], rest, n_rest)
            return part[0]
    home = _home(changed, x, y, widen)
    changed.add(home, x, n_x)
    changed.add(home, y, n_y)
    return home


def _home(changed: RuleSet, x: Right, y: Right, widen: bool) -> int:
    """The nonterminal that has both parts as rules; with ``widen`` one of them; or a new one."""
    others = [left for left in changed.rules if left != changed.start]
    both = [left for left in others if x in changed.rules[left] and y in changed.rules[left]]
    if both:
        return both[0]
    either = [left for left in others if x in changed.rules[left] or y in changed.rules[left]]
    return either[0] if widen and either else changed.new_symbol()


def _root(united: dict[int, int], symbol: int) -> int:
    while symbol in united:
        symbol = united[symbol]
    return symbol


def chunks(rule_set: RuleSet) -> Iterator[Scored]:
    """Strings that occur twice or more in right sides, by the symbols that naming them saves."""
    rights = [right for _, right in rule_set.uses()]
    places = [(k, a) for k, right in enumerate(rights) for a in range(len(right))]
    for length in range(2, LONGEST_CHUNK + 1):
        found: dict[Right, list[tuple[int, int]]] = {}
        for k, a in places:
            if a + length <= len(rights[k]):
                found.setdefault(rights[k][a : a + length], []).append((k, a))
        # what occurs once cannot occur twice when it is longer
        places = []
        for part, where in found.items():
            if len(where) < 2:
                continue
            places.extend(where)
            number = _apart(where, length)
            saved = chunk_saves(length, number)
            if number > 1 and saved > _WORST:
                yield saved, chunk(part)
        if not places:
            return


def _apart(where: list[tuple[int, int]], length: int) -> int:
    """How many occurrences, in rising order, do not overlap the one counted before."""
    number, end = 0, (-1, 0)
    for k, a in where:
        if (k, a) >= end:
            number += 1
            end = (k, a + length)
    return number


def chunk(part: Right) -> Move:
    def move(rule_set: RuleSet) -> RuleSet | None:
        single = {part: 0}.keys()
        known = [
            left
            for left, rights in rule_set.rules.items()
            if left != rule_set.start and rights.keys() == single
        ]
        changed = rule_set.copy()
        symbol = known[0] if known else changed.new_symbol()
        number = replace_part(changed, part, symbol)
        changed.add(symbol, part, number)
        return changed

    return move


def replace_part(changed: RuleSet, part: Right, symbol: int) -> int:
    """Put ``symbol`` for ``part`` in all rules but its own; how many nodes that makes."""
    nodes = 0
    for left, right in list(changed.uses()):
        if left == symbol and right == part:
            continue
        written, number = _written(right, part, symbol)
        if number:
            count = changed.rules[left].pop(right)
            nodes += number * count
            changed.add(left, written, count)
    return nodes


def _written(right: Right, part: Right, symbol: int) -> tuple[Right, int]:
    length = len(part)
    if part and part[0] not in right:
        return right, 0
    found: list[int] = []
    number = i = 0
    while i < len(right):
        if right[i : i + length] == part:
            found.append(symbol)
            number += 1
            i += length
        else:
            found.append(right[i])
            i += 1
    return tuple(found), number


def foldings(rule_set: RuleSet) -> Iterator[Scored]:
    """Alternatives that also occur elsewhere, the longest first."""
    for left, rights in rule_set.rules.items():
        if left == rule_set.start:
            continue
        for part in rights:
            if part:
                yield float(len(part)), fold(left, part)


def fold(symbol: int, part: Right) -> Move:
    def move(rule_set: RuleSet) -> RuleSet | None:
        changed = rule_set.copy()
        number = replace_part(changed, part, symbol)
        if not number:
            return None
        changed.add(symbol, part, number)
        return None if (symbol,) in changed.rules[symbol] else changed

    return move


def classes(rule_set: RuleSet) -> Iterator[Scored]:
    """Pairs of strings that stand between the same neighbours, by how many they share."""
    places: dict[tuple[int, int], set[Right]] = {}
    for _, right in rule_set.uses():
        for a in range(len(right)):
            before = right[a - 1] if a else -1
            for b in range(a + 1, min(len(right), a + LONGEST_MEMBER) + 1):
                after = right[b] if b < len(right) else -2
                places.setdefault((before, after), set()).add(right[a:b])
    shared: Counter[tuple[Right, Right]] = Counter()
    for parts in places.values():
        if len(parts) <= _CROWD:
            shared.update(combinations(sorted(parts), 2))
    for (x, y), number in shared.items():
        if number > 1:
            yield float(number), _class(x, y)


def _class(x: Right, y: Right) -> Move:
    def move(rule_set: RuleSet) -> RuleSet | None:
        if _alone(rule_set, x) and _alone(rule_set, y):
            return union(x[0], y[0])(rule_set)
        for known, part in ((x, y), (y, x)):
            if _alone(rule_set, known):
                return fold(known[0], part)(rule_set)
        changed = rule_set.copy()
        home = _home(changed, x, y, False)
        for part in sorted((x, y), key=len, reverse=True):
            number = replace_part(changed, part, home)
            if not number:
                return None
            changed.add(home, part, number)
        return changed

    return move


def unions(rule_set: RuleSet) -> Iterator[Scored]:
    """Pairs of nonterminals that share right sides, by the symbols that their union saves."""
    homes: dict[Right, list[int]] = {}
    for left, right in rule_set.uses():
        if left != rule_set.start:
            homes.setdefault(right, []).append(left)
    saved: Counter[tuple[int, int]] = Counter()
    for right, lefts in homes.items():
        for pair in combinations(lefts, 2):
            saved[pair] += len(right) + 2
        if _alone(rule_set, right):
            for left in lefts:
                saved[left, right[0]] += 3
    for (one, other), symbols in saved.items():
        yield float(symbols), union(one, other)


def union(one: int, other: int) -> Move:
    def move(rule_set: RuleSet) -> RuleSet | None:
        changed = rule_set.copy()
        changed.rename({other: one})
        return changed

    return move


def unfoldings(rule_set: RuleSet) -> Iterator[Scored]:
    """Nonterminals that are used once, or have one rule, by the symbols writing them out saves."""
    references = rule_set.references()
    for left, rights in rule_set.rules.items():
        if left == rule_set.start:
            continue
        number = references[left]
        if len(rights) == 1:
            length = len(next(iter(rights)))
            yield float(length + 2 - number * (length - 1)), unfold(left)
        elif number == 1:
            yield 0.0, unfold_once(left)


def unfold(symbol: int) -> Move:
    def move(rule_set: RuleSet) -> RuleSet | None:
        changed = rule_set.copy()
        (part,) = changed.rules.pop(symbol)
        for left, right in list(changed.uses()):
            if symbol in right:
                count = changed.rules[left].pop(right)
                spelled = [s for old in right for s in (part if old == symbol else (old,))]
                changed.add(left, tuple(spelled), count)
        return changed

    return move


def unfold_once(symbol: int) -> Move:
    """Alternatives of a nonterminal that one rule uses, written into that rule."""

    def move(rule_set: RuleSet) -> RuleSet | None:
        (left, right), *_ = [use for use in rule_set.uses() if symbol in use[1]]
        changed = rule_set.copy()
        parts = changed.rules.pop(symbol)
        changed.rules[left].pop(right)
        place = right.index(symbol)
        for part, count in parts.items():
            changed.add(left, (*right[:place], *part, *right[place + 1 :]), count)
        return changed

    return move
