"""Statements of a motion grammar (``motion_grammar.lark``): what was read, and what is refused.

Right sides are rewritten into plain rules with auxiliary nonterminals, which are named by the left
side, a dot and a number; names in a file contain no dot::

    X*   H -> empty | X H        X+   H -> X | X H
    X?   H -> empty | X          (x | y)   H -> x | y
    (x & y)   all of them in any order, each order equally probable: H -> x y | y x
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations, count
from typing import TYPE_CHECKING, ClassVar

from motiondb.body import body
from motiondb.errors import suggestion
from motiondb.grammar.cfg.context_free import EMPTY
from motiondb.scene.language.activity import (
    DEEDS,
    ROLES,
    Answers,
    Ground,
    Place,
    Rest,
    Step,
    Thing,
    Verb,
)
from motiondb.scene.language.motion_grammar import Start, Terminal
from motiondb.scene.language.semantic_rules import (
    INSTANTS,
    NEAREST,
    RULE_NAMES,
    DirectionRule,
    DistanceRule,
    LineRule,
    Moment,
    PositionRule,
    SemanticRule,
    Spot,
    SynchronisationRule,
)
from motiondb.scene.language.texts import HOW_FAR, UNITS, Quantity, Reading

if TYPE_CHECKING:
    from lark import Token

Alternative = tuple[str, tuple[str, ...], float | None]
"""Left side, right side, probability where one was written."""
Points = list[tuple[float, float, float]]
Names = tuple[str, ...]
Tokens = tuple["Token", ...]
Items = tuple[tuple["Token | Bracket", "Token | None"], ...]  # Each with its sign of repetition
Value = tuple["Token", "Token | None"]  # A number and its unit

WEIGHT_UNITS: dict[str, str] = {
    "position": "length",
    "direction": "angle",
    "distance": "",
    "line": "length",
    "synchronisation": "time",
}  # The kinds of rule, and the quantity in which their weights are measured; "" for no unit

_THINNEST, _WIDEST = 0.01, 20.0  # Limits of sizes and heights of objects and places, m
_ARC = 73  # Points of an arc
_LEAST, _MOST = 1e-6, 1e6
"""Limits of weights. A weight outside is a slip: one term of the sum would hide all others."""
_LONGEST_LAG = 60.0
"""Longest lag of a synchronisation, s. No scene lasts so long that two actions could be farther
apart."""
_UNSTATED = math.nan  # Marks a rule without a weight until the whole file has been read
_MOST_ORDERED = 8  # Most parts in any order: 2^8 nonterminals
_NOT_LINKS = ("then", "once", "for", "after")
_BEHIND_VERBS = ("then", "once", "to", "with", "at")  # What a link may be a slip of
_WEIGHT = "Write the deviation that costs 1; it must be above 0."


@dataclass(frozen=True)
class Draft:
    """A rule as written; its weight is NaN and its moment "" if the text names none."""

    rule: SemanticRule
    symbols: tuple[Token, ...]  # The symbols that the rule is attached to
    within: Token | None  # The nonterminal below which it holds


@dataclass(frozen=True)
class Bracket:
    """A bracket of a right side: one of its parts, or all of them in any order."""

    parts: tuple[Items, ...]
    is_ordered: bool = False


class GrammarReading(Reading):
    """The statements of a motion grammar read so far."""

    statement = "a statement such as 'S -> run', 'run := \"run\"' or 'run: position(goal)'"
    advice: ClassVar = {
        "_ARROW": "Write names, ( ) | & * + ? and probabilities as [0.5];"
        f" '{EMPTY}' is the empty string.",
        "_IS": 'Write run := "run", or run := terminal f of boxing.',
        "_GRAMMAR": "Write 'grammar carrying'.",
        "NAME": "The first name must be followed by '->', ':=' or ':'.",
        "_START": "Write 'start S', or 'start S for attack'.",
        "_VERB": "Write 'verb move = walk | run to X Z', or 'verb pass = throw to receiver'.",
        "_DISTANCE": HOW_FAR,
        "_LINE": "A line has two ends: line(opponent, rim).",
        "_SYNCHRONISATION": "Write synchronisation(receiver, catch, flight), or 0 s.",
        "_EVENT": "Write 'event release', or 'event lowest(head)'.",
        "_REST": "Write 'rest idle', 'rest hold with ball' or 'rest guard for guard'.",
        "_ROLE": "Write 'role leader, follower of leader'.",
        "_OBJECT": "Write 'object ball size 24 cm'.",
        "_GROUND": "Write 'ground 8 x 6', or 'ground half 15 x 14 from -7.5 -1.575'.",
        "_PLACE": "Write 'place object, goal', or 'place goal height 1 m size 3 x 2 m'.",
        "_MARK": "Write 'arc x z radius from to'.",
        "COLON": "Write rules such as position(goal), or distance(opponent, <= 2 m).",
    }
    expected: ClassVar = {
        "PART": "a symbol",
        "SYMBOL": "a symbol",
        "NONTERMINAL": "a nonterminal",
        "START": "a start symbol",
        "TEXT": "quoted words that find the action's clips",
        "LEARNED": "the name of a learned grammar",
        "TITLE": "the grammar's name",
        "VERB": "the verb's name",
        "WEIGHT": "what the weight is for",
        "NUMBER": "a number",
        "ACTION": "an action",
        "PARTNER": "a role",
        "TEAM": "a role",
        "ROLE": "a role",
        "TARGET": "a place or a role",
        "AIM": "a place or a role",
        "PLACE": "the name of a place",
        "WHERE": "a place",
        "OBJECT": "the object's name",
        "THING": "the object",
        "EVENT": "an event",
        "JOINT": "a joint",
        "X": "x, metres",
        "Z": "z, metres",
        "_BIG_X": "'X'",
        "_BIG_Z": "'Z'",
        **dict.fromkeys((*(f"_{kind.upper()}" for kind in WEIGHT_UNITS), "DEED"), "a kind of rule"),
    }
    behind = frozenset(("_ARROW", "_IS", "COLON", "COMMA", "_IN", "_ANSWERS"))

    def __init__(self, where: str, is_kept: bool = False) -> None:
        super().__init__(where, is_kept)
        self.name = ""
        self.starts: list[tuple[Start, Token]] = []
        self.alternatives: list[Alternative] = []
        self.plain: dict[tuple[str, Items], Names] = {}
        self.lines: dict[str, Token] = {}
        self.terminals: dict[str, tuple[Terminal, Token]] = {}
        self.drafts: list[Draft] = []
        self.weight: dict[str, float] = {}
        self.verbs: list[tuple[Verb, Token]] = []
        self.team: dict[str, str] = {}
        self.thing: Thing | None = None
        self.deeds: list[tuple[str, str, str]] = []
        self.rests: list[Rest] = []
        self.answers: list[Answers] = []
        self.place: dict[str, Place] = {}
        self.ground = Ground()
        self.marks: list[tuple[tuple[float, float, float], ...]] = []

    def _grammar(self, word: Token, name: Token) -> None:
        self.once(word, "grammar", "'grammar' once")
        self.name = str(name)

    def _begin(self, symbol: Token, team: Token | None) -> None:
        for known, earlier in self.starts:
            if known.team in ("", team or ""):
                whom = f"the role {team}" if team else "everybody"
                said = f"Line {earlier.line} says where {known.team or 'everybody'} begins already."
                self.fail(symbol, f"one start symbol for {whom}", said)
        if team:
            self.team.setdefault(str(team), "")
        self.starts.append((Start(str(symbol), str(team or "")), symbol))

    def _weight(self, kind: Token, value: Value) -> None:
        kinds = (*WEIGHT_UNITS, "user", "smooth", "collision", "effort")
        if kind not in kinds:
            self.unknown(kind, "what the weight is for", kinds, "See the format.")
        self.once(kind, f"weight {kind}", f"the weight of {kind} once")
        unit = "length" if kind == "effort" else WEIGHT_UNITS.get(kind, "")
        self.weight[str(kind)] = self._weighed(value, unit)

    def _weighed(self, value: Value, kind: str) -> float:
        number, unit = value
        units = UNITS.get(kind, {"": 1.0})
        size = self.number(number)
        if size <= 0.0:
            self.fail(number, "a weight above 0", _WEIGHT)
        if not _LEAST <= size <= _MOST:
            self.fail(number, f"a weight from {_LEAST:g} to {_MOST:g}", _WEIGHT)
        if (unit or "") not in units:
            what = f"a unit of {kind} ({', '.join(units)})" if kind else "a weight without a unit"
            self.fail(unit or number, what, _WEIGHT)
        return size * units[unit or ""]

    # production rules

    def _production(self, left: Token, *alternatives: tuple[Items, float | None]) -> None:
        if left == EMPTY:
            self.fail(left, "a nonterminal before '->'", f"'{EMPTY}' means the empty string.")
        self.lines.setdefault(str(left), left)
        helpers: list[Alternative] = []
        names = (
            f"{left}.{n}" for n in count(1 + sum(n.startswith(f"{left}.") for n in self.lines))
        )
        for parts, chance in alternatives:
            if (left, parts) not in self.plain:  # written again, it weighs more
                self.plain[left, parts] = self._plain(parts, names, helpers)
            self.alternatives.append((str(left), self.plain[left, parts], chance))
        self.alternatives += helpers
        for name, _, _ in helpers:
            self.lines.setdefault(name, left)

    def _alternative(self, sequence: Items, chance: Token | None) -> tuple[Items, float | None]:
        if chance is not None and not 0.0 < self.number(chance) <= 1.0:
            what = "a probability above 0 and at most 1"
            self.fail(chance, what, "Leave out what never happens.")
        return sequence, None if chance is None else float(chance)

    def _sequence(self, *items: tuple[Token | Bracket, Token | None]) -> Items:
        for part, sign in items:
            if not isinstance(part, Bracket) and part == EMPTY and (len(items) > 1 or sign):
                self.fail(part, f"'{EMPTY}' alone", self.advice["_ARROW"])
        return items

    def _ordered(self, opening: Token, *parts: Items) -> Bracket:
        if len(parts) > _MOST_ORDERED:
            what = f"at most {_MOST_ORDERED} parts in any order"
            self.fail(opening, what, self.advice["_ARROW"])
        return Bracket(parts, is_ordered=True)

    def _either(self, _: Token, *parts: Items) -> Bracket:
        return Bracket(parts)

    def _plain(self, sequence: Items, names: Iterator[str], helpers: list[Alternative]) -> Names:
        """Return the symbols of a sequence; rules of auxiliary nonterminals go into ``helpers``."""
        symbols = []
        for part, sign in sequence:
            if part == EMPTY:
                return ()
            symbol = str(part)
            if isinstance(part, Bracket):
                symbol = self._bracket(part, names, helpers)
            if sign:
                helper = next(names)
                least = (symbol,) if sign == "+" else ()
                most = (symbol,) if sign == "?" else (symbol, helper)
                helpers += [(helper, least, None), (helper, most, None)]
                symbol = helper
            symbols.append(symbol)
        return tuple(symbols)

    def _bracket(self, one: Bracket, names: Iterator[str], helpers: list[Alternative]) -> str:
        symbol = next(names)
        parts = [self._plain(sequence, names, helpers) for sequence in one.parts]
        if not one.is_ordered:
            helpers += [(symbol, part, None) for part in parts]
            return symbol
        left = {frozenset(range(len(parts))): symbol}
        for rest in _smaller(len(parts)):
            left[rest] = next(names)
        for rest, name in left.items():
            for k in sorted(rest):
                others = [left[rest - {k}]] if len(rest) > 1 else []
                helpers.append((name, (*parts[k], *others), None))
        return symbol

    # actions

    def _texts(self, *texts: Token) -> Names:
        for text in texts:
            if not text.strip('"').strip():
                self.fail(text, "words in quotes", 'Write them as "pick up".')
        return tuple(text.strip('"') for text in texts)

    def _learned(self, number: Token, grammar: Token) -> Terminal:
        return Terminal("", learned=(number.strip('"'), str(grammar)))

    def _terminal(
        self,
        name: Token,
        found: Names | Terminal,
        without: Names | None,
        event: str | None,
        asked: Token | None,
    ) -> None:
        if name in self.terminals:
            advice = f"Line {self.terminals[name][1].line} declares it: write all its words there."
            self.fail(name, "a terminal that is not declared yet", advice)
        learned = found.learned if isinstance(found, Terminal) else ("", "")
        phrases = found if isinstance(found, tuple) else ()
        made = Terminal(str(name), phrases, without or (), event or "", bool(asked), learned)
        self.terminals[str(name)] = made, name

    def _event(self, name: Token, first: str | None, second: str | None) -> str:
        if not first:
            return str(name)
        if name not in INSTANTS:
            near = suggestion(name, INSTANTS).strip() or self.advice["_EVENT"]
            self.fail(name, f"one of {', '.join(INSTANTS)} before '('", near)
        if (name == NEAREST) != bool(second):
            what = "two joints after 'nearest', one after others"
            self.fail(name, what, "Write nearest(r_wrist, partner.head).")
        return f"{name}({', '.join(filter(None, (first, second)))})"

    def _joint(self, whose: Token | None, _: Token | None, name: Token) -> str:
        if name not in body.JOINTS:
            advice = "See the joints of the canonical body."
            self.unknown(name, "a joint", body.JOINTS, advice)
        return f"partner.{name}" if whose else str(name)

    # rules of space and time

    def _symbols(self, first: Token, *others: Token) -> Tokens:
        self.tokens.append(first.update(type="SYMBOL"))
        return first, *others

    def _actions(self, *names: Token) -> Names:
        return tuple(map(str, names))

    def _rules(
        self, symbols: Tokens, within: Token | None, *rules: SemanticRule | tuple[str, str]
    ) -> None:
        for rule in rules:
            if isinstance(rule, tuple):
                for symbol in symbols:
                    what = f"one thing that {symbol} does with the object"
                    self.once(symbol, ("deed", str(symbol)), what)
                    self.deeds.append((str(symbol), *rule))
            else:
                self.drafts.append(Draft(rule, symbols, within))

    def _rule(self, rule: SemanticRule, moment: str | None, weight: Value | None) -> SemanticRule:
        kind = RULE_NAMES[type(rule)]
        if weight:
            rule = replace(rule, weight=self._weighed(weight, WEIGHT_UNITS[kind]))
        return replace(rule, moment=Moment(moment or ""))

    def _moment(self, *said: str) -> str:
        return str(said[-1])

    def _position(self, target: Token) -> SemanticRule:
        return PositionRule(str(target), weight=_UNSTATED)

    def _direction(self, target: Token | Quantity, turn: Quantity | None = None) -> SemanticRule:
        if isinstance(target, tuple):
            heading, token = target
            if abs(heading) > 2.0 * math.pi:
                self.fail(token, "a heading from -360 to 360 deg", "A whole turn leads nowhere.")
            return DirectionRule(heading, weight=_UNSTATED)
        return DirectionRule(str(target), weight=_UNSTATED, turn=turn[0] if turn else 0.0)

    def _distance(self, target: Token, bounds: tuple[float, float]) -> SemanticRule:
        return DistanceRule(str(target), *bounds, weight=_UNSTATED)

    def _line(self, first: Token, second: Token) -> SemanticRule:
        return LineRule(str(first), str(second), weight=_UNSTATED)

    def _synchronisation(
        self, partner: Token, actions: Names, lag: Token | Quantity
    ) -> SemanticRule:
        seconds = lag[0] if isinstance(lag, tuple) else None
        if isinstance(lag, tuple) and abs(lag[0]) > _LONGEST_LAG:
            what = f"a time from -{_LONGEST_LAG:g} to {_LONGEST_LAG:g} s"
            self.fail(lag[1], what, self.advice["_SYNCHRONISATION"])
        return SynchronisationRule(str(partner), actions, seconds, weight=_UNSTATED)

    def _deed(self, deed: Token, _: Token, to: Token | None) -> tuple[str, str]:
        if deed not in DEEDS:
            self.unknown(deed, "a kind of rule", (*WEIGHT_UNITS, *DEEDS), "See the format.")
        return str(deed), "" if to is None or to in ROLES else str(to)

    def _answers(self, symbols: Tokens, acts: Names, lag: Quantity | None) -> None:
        for symbol in symbols:
            for act in acts:
                self.once(
                    symbol, ("answers", str(symbol), act), f"once that {symbol} answers {act}"
                )
        self.answers.append(Answers(tuple(map(str, symbols)), acts, lag[0] if lag else 0.0))

    # the activity

    def _sized(self, length: Quantity | None) -> float:
        if length is None:
            return 0.0
        if not _THINNEST <= length[0] <= _WIDEST:
            self.fail(length[1], f"{_THINNEST:g} to {_WIDEST:g} m", "Correct the size.")
        return length[0]

    def _place(
        self,
        name: Token,
        at: Spot | None,
        height: Quantity | None,
        across: Token | None,
        size: Quantity | None,
    ) -> None:
        if name in ROLES:
            advice = f"{name} means a player: name the place otherwise."
            self.fail(name, "a name of a place", advice)
        self.once(name, ("place", name), "every place once")
        width, tall = self._sized(size), 0.0
        if across:
            width, tall = self.number(across), width
        self.place[str(name)] = Place(str(name), at, self._sized(height), width, tall)

    def _verb(self, name: Token, *parts: Step | Tokens) -> None:
        steps = tuple(part for part in parts if isinstance(part, Step))
        link, role, goes, with_object = "", "", False, False
        for way in (part for part in parts if not isinstance(part, Step)):
            if len(way) == 3:
                goes = True
            elif way[0] == "with" and link:
                self.tokens.append(way[1].update(type="THING"))
                with_object = True
            elif link or way[0] in _NOT_LINKS:
                what = "one word and role, 'to X Z', or 'with' and the object"
                self.fail(way[0], what, self.advice["_VERB"])
            elif near := self.slip(way[0], _BEHIND_VERBS):
                self.fail(way[0], repr(near), f"Did you mean {near}?")
            else:
                link, role = str(way[0]), str(way[1])
        self.verbs.append((Verb(str(name), steps, link, role, goes, with_object), name))

    def _step(self, actions: Names, again: Token | None) -> Step:
        return Step(actions, None if again is None else again == "*")

    def _role(self, name: Token, of: Token | None) -> None:
        if name in ROLES:
            self.fail(name, "another name", f"{str(name)!r} has its own meaning in rules.")
        self.once(name, ("role", name), "every role once")
        self.team[str(name)] = str(of or "")

    def _object(self, name: Token, size: Quantity | None, at: Token | None) -> None:
        if self.thing is not None:
            self.fail(name, "one object", f"The grammar has {self.thing.name!r} already.")
        self.thing = Thing(str(name), self._sized(size) or Thing.size, str(at or ""))

    def _ground(self, name: Token | None, extent: tuple[float, float], corner: Spot | None) -> None:
        width, length = extent
        self.once(self.tokens[-1], "ground", "'ground' once")
        corner = corner or Spot(-width / 2, -length / 2)
        self.ground = Ground(str(name or ""), width, length, corner.x, corner.z)

    def _mark(self, *parts: Points) -> None:
        mark = tuple(point for part in parts for point in part)
        self.once(self.tokens[-1], mark, "every mark once")
        self.marks.append(mark)

    def _arc(self, *numbers: Token) -> Points:
        x, z, r, a, b = map(self.number, numbers)
        turns = [math.radians(a + (b - a) * k / (_ARC - 1)) for k in range(_ARC)]
        return [(x + r * math.cos(t), 0.0, z + r * math.sin(t)) for t in turns]

    def _point(self, x: Token, y: Token, z: Token | None) -> Points:
        height, depth = (0.0, y) if z is None else (y, z)
        return [(self.number(x), float(height), self.number(depth))]

    def _rest(
        self, action: Token, thing: Token | None, doing: Names | None, after: Names | None
    ) -> None:
        rest = Rest(str(action), bool(thing), doing or (), after or ())
        self.once(action, rest, "every rest once")
        self.rests.append(rest)


def _smaller(n: int) -> Iterator[frozenset[int]]:
    """Yield the sets of 1 to n - 1 of n numbers, the larger ones first."""
    for size in range(n - 1, 0, -1):
        yield from map(frozenset, combinations(range(n), size))
