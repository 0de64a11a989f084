"""Rules rewritten as long as the description length falls.

Alignment-based learning proposes; description length disposes. From a rule set, the moves are

* *exchange*: two right sides of one nonterminal are aligned and become one; each pair of unequal
  parts becomes the alternatives of a nonterminal (an existing one where its rules allow);
* *chunk*: a string that occurs repeatedly in right sides becomes a nonterminal of its own;
* *fold*: an alternative of a nonterminal is replaced by it wherever else it occurs;
* *unite*: two nonterminals that share a right side become one;
* *unfold*: a nonterminal with one rule, or used once, is written out again.

The move that saves most bits is taken, until none saves any. No move may break the laws of the
rule set, so nothing becomes cyclic. The order in which moves are looked at depends on the rules
alone, never on the order in which sentences came.

Sources: M. van Zaanen, "ABL: Alignment-Based Learning", COLING 2000, for exchange; P. Langley and
S. Stromsten, "Learning Context-Free Grammars with a Simplicity Bias", ECML 2000, for moves that
are judged by description length.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from itertools import combinations

from motiondb.grammar.alignment import Slot, align
from motiondb.grammar.rule_set import Right, RuleSet

Move = Callable[[RuleSet], RuleSet | None]
Scored = tuple[float, Move]

LONGEST_CHUNK = 24
_TRIED = 10
"""Moves of each kind that are counted exactly in a round, the most promising by symbols saved."""

_WORST = -8
"""Symbols that an exchange or a chunk may lose and still be tried."""

_LEAST_GAIN = 1e-9


def compact(rule_set: RuleSet, *, width: int = 8, patience: int = 4) -> RuleSet:
    """The rule set of fewest bits that a beam of moves finds.

    The ``width`` best rule sets are kept and all moves tried on each; a step may lose bits, since
    some structures pay only once they are complete. It ends when ``patience`` steps in a row have
    found nothing better than the best.
    """
    best = rule_set
    best_bits = rule_set.bits()
    beam = [(best_bits, best)]
    seen: set[tuple[float, int]] = set()
    idle = 0
    while beam and idle < patience:
        found: list[tuple[float, RuleSet]] = []
        for _, current in beam:
            for changed in _neighbours(current):
                bits = changed.bits()
                key = round(bits, 6), sum(map(len, changed.rules.values()))
                if key not in seen:
                    seen.add(key)
                    found.append((bits, changed))
        found.sort(key=lambda pair: pair[0])
        beam = []
        for bits, changed in found:
            if changed.lawful():
                beam.append((bits, changed))
                if len(beam) == width:
                    break
        idle += 1
        if beam and beam[0][0] < best_bits - _LEAST_GAIN:
            best_bits, best = beam[0]
            idle = 0
    return best


def trim(rule_set: RuleSet) -> RuleSet:
    """Write out every nonterminal that has one rule and is used once: it never saves anything."""
    current = rule_set.copy()
    while True:
        references = current.references()
        idle = [
            left
            for left, rights in current.rules.items()
            if left != current.start and len(rights) == 1 and references[left] == 1
        ]
        if not idle:
            return current
        spelled = {left: current.rules.pop(left).popitem()[0] for left in idle}
        old, current.rules = current.rules, {}
        for left, rights in old.items():
            for right, count in rights.items():
                current.add(left, _spelled_out(right, spelled), count)


def _spelled_out(right: Right, spelled: Mapping[int, Right]) -> Right:
    while any(symbol in spelled for symbol in right):
        right = tuple(s for old in right for s in spelled.get(old, (old,)))
    return right


def _neighbours(current: RuleSet) -> Iterator[RuleSet]:
    for kind in (exchanges, chunks, unions, foldings, unfoldings):
        promising = sorted(kind(current), key=lambda scored: -scored[0])[:_TRIED]
        for _, move in promising:
            changed = move(current)
            if changed is not None:
                yield changed


@lru_cache(maxsize=1 << 18)
def _aligned(one: Right, other: Right, biased: bool) -> tuple[Slot, ...]:
    return align(one, other, biased)


def exchanges(rule_set: RuleSet) -> Iterator[Scored]:
    """Pairs of right sides of one nonterminal, by the symbols that making them one would save."""
    homes: dict[Right, list[int]] = {}
    for left, right in rule_set.uses():
        homes.setdefault(right, []).append(left)
    for left, rights in rule_set.rules.items():
        for one, other in combinations(sorted(rights), 2):
            if not set(one) & set(other):
                continue
            ways = {_aligned(one, other, biased) for biased in (False, True)}
            for slots in sorted(ways):
                saved = _symbols_saved(rule_set, homes, one, other, slots)
                if saved > _WORST:
                    yield saved, _exchange(left, one, other, slots, False)
                    if any(one[a:b] in homes or other[c:d] in homes for (a, b), (c, d) in slots):
                        yield saved, _exchange(left, one, other, slots, True)


def _symbols_saved(
    rule_set: RuleSet, homes: dict[Right, list[int]], one: Right, other: Right, slots: tuple
) -> float:
    outside = len(one) - sum(b - a for (a, b), _ in slots)
    saved = len(one) + len(other) + 4 - (outside + len(slots) + 2)
    for (a, b), (c, d) in slots:
        x, y = one[a:b], other[c:d]
        x_known, y_known = _alone(rule_set, x), _alone(rule_set, y)
        if x_known and y_known:
            continue
        if x_known or y_known:
            known, part = (x, y) if x_known else (y, x)
            saved -= 0 if part in rule_set.rules[known[0]] else len(part) + 2
        elif not set(homes.get(x, ())) & set(homes.get(y, ())):
            saved -= len(x) + len(y) + 4
    return saved


def _alone(rule_set: RuleSet, part: Right) -> bool:
    return len(part) == 1 and part[0] in rule_set.rules


def _exchange(
    left: int, one: Right, other: Right, slots: tuple[Slot, ...], widen: bool
) -> Move:
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
    ends: dict[Right, int] = {}
    counts: Counter[Right] = Counter()
    place = 0
    for _, right in rule_set.uses():
        for length in range(2, min(len(right), LONGEST_CHUNK) + 1):
            for a in range(len(right) - length + 1):
                part = right[a : a + length]
                if ends.get(part, -1) <= place + a:
                    ends[part] = place + a + length
                    counts[part] += 1
        place += len(right) + 1
    for part, number in counts.items():
        saved = number * (len(part) - 1) - len(part) - 2
        if number > 1 and saved > _WORST:
            yield saved, _chunk(part)


def _chunk(part: Right) -> Move:
    def move(rule_set: RuleSet) -> RuleSet | None:
        single = {part: 0}.keys()
        known = [
            left
            for left, rights in rule_set.rules.items()
            if left != rule_set.start and rights.keys() == single
        ]
        changed = rule_set.copy()
        symbol = known[0] if known else changed.new_symbol()
        number = _replace(changed, part, symbol)
        changed.add(symbol, part, number)
        return changed

    return move


def _replace(changed: RuleSet, part: Right, symbol: int) -> int:
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
                yield float(len(part)), _fold(left, part)


def _fold(symbol: int, part: Right) -> Move:
    def move(rule_set: RuleSet) -> RuleSet | None:
        changed = rule_set.copy()
        number = _replace(changed, part, symbol)
        if not number:
            return None
        changed.add(symbol, part, number)
        return None if (symbol,) in changed.rules[symbol] else changed

    return move


def unions(rule_set: RuleSet) -> Iterator[Scored]:
    """Pairs of nonterminals that share right sides, by the symbols that their union saves."""
    others = [left for left in rule_set.rules if left != rule_set.start]
    for one, other in combinations(others, 2):
        shared = rule_set.rules[one].keys() & rule_set.rules[other].keys()
        if shared or (other,) in rule_set.rules[one] or (one,) in rule_set.rules[other]:
            yield float(sum(len(right) + 2 for right in shared)), _union(one, other)


def _union(one: int, other: int) -> Move:
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
            yield float(length + 2 - number * (length - 1)), _unfold(left)
        elif number == 1:
            yield 0.0, _unfold_once(left)


def _unfold(symbol: int) -> Move:
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


def _unfold_once(symbol: int) -> Move:
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
