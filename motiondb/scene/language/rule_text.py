"""Semantic rules in text: ``SYMBOLS in NONTERMINAL: rule, rule``; see :mod:`.grammar_file`."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from motiondb.scene.language.motion_grammar import ROLES
from motiondb.scene.language.semantic_rules import (
    END,
    START,
    THROUGHOUT,
    DirectionRule,
    DistanceRule,
    LineRule,
    Moment,
    PositionRule,
    SemanticRule,
    SynchronisationRule,
)
from motiondb.scene.language.tokens import Cursor, Token

WEIGHT_UNITS: dict[str, str] = {
    "position": "length",
    "direction": "angle",
    "distance": "",
    "line": "length",
    "synchronisation": "time",
}  # The kinds of rule, and the quantity in which their weights are measured; "" for no unit

_LEAST, _MOST = 1e-6, 1e6
"""Limits of weights. A weight outside is a slip: one term of the sum would hide all others."""

_LONGEST_LAG = 60.0
"""Longest lag of a synchronisation, s. No scene lasts so long that two actions could be farther
apart."""

_UNSTATED = math.nan  # Marks a rule without a weight until the whole file has been read


@dataclass(frozen=True)
class Draft:
    """A rule as written."""

    kind: str  # The kind of rule
    rule: SemanticRule  # The rule; its weight is NaN and its moment "" if the text names none
    symbols: tuple[Token, ...]  # The symbols that the rule is attached to
    within: Token | None  # The nonterminal below which it holds
    targets: tuple[Token, ...]  # Names of the places and roles that it is about
    actions: tuple[Token, ...]  # Names of the partner's actions


def read_rules(cursor: Cursor) -> list[Draft]:
    """Read all rules of a statement."""
    symbols = [_name_token(cursor, "a symbol of the grammar")]
    while cursor.meets(","):
        symbols.append(_name_token(cursor, "a symbol of the grammar"))
    within = _name_token(cursor, "a nonterminal") if cursor.meets("in") else None
    cursor.expect(":", "Write 'SYMBOL: rule' or 'SYMBOL in NONTERMINAL: rule'.")
    drafts: list[Draft] = []
    while not drafts or cursor.meets(","):
        kind, rule, targets, actions = _read_rule(cursor)
        drafts.append(Draft(kind, rule, tuple(symbols), within, tuple(targets), tuple(actions)))
    return drafts


def _name_token(cursor: Cursor, what: str) -> Token:
    token = cursor.here
    cursor.name(what, "Write a name.")
    return token


def _read_rule(cursor: Cursor) -> tuple[str, SemanticRule, list[Token], list[Token]]:
    """Read one rule: its kind, the rule, its targets and its actions."""
    kind = cursor.name("a kind of rule", "See the format of grammars.", tuple(WEIGHT_UNITS))
    cursor.expect("(", f"Write what the rule is about: {kind}(...).")
    targets: list[Token] = []
    actions: list[Token] = []
    moment = Moment("")
    rule: SemanticRule
    if kind == "position":
        rule = PositionRule(_target(cursor, targets), moment, _UNSTATED)
    elif kind == "direction":
        rule = DirectionRule(_facing(cursor, targets), moment, _UNSTATED)
    elif kind == "distance":
        target = _target(cursor, targets)
        near, far = _bounds(cursor)
        rule = DistanceRule(target, near, far, moment, _UNSTATED)
    elif kind == "line":
        first = _target(cursor, targets)
        cursor.expect(",", "A line has two ends: line(opponent, rim).")
        rule = LineRule(first, _target(cursor, targets), moment, _UNSTATED)
    else:
        partner = cursor.name("a role", "Write whom it is about.", ROLES)
        lag = _partners(cursor, actions)
        names = tuple(token.text for token in actions)
        rule = SynchronisationRule(partner, names, lag, moment, _UNSTATED)
    cursor.expect(")", "Close the bracket of the rule.")
    return kind, _with_tail(cursor, rule, kind), targets, actions


def _target(cursor: Cursor, targets: list[Token]) -> str:
    targets.append(_name_token(cursor, "a place or a role"))
    return targets[-1].text


def _facing(cursor: Cursor, targets: list[Token]) -> str | float:
    token = cursor.here
    if token.kind == "number":
        heading = cursor.quantity("angle", "a heading")
        if abs(heading) > 2.0 * math.pi:
            cursor.fail("a heading from -360 to 360 deg", "A whole turn leads nowhere.", token)
        return heading
    return _target(cursor, targets)


def _bounds(cursor: Cursor) -> tuple[float, float]:
    advice = "Write <= 2.5 m, >= 1.5 m, or 0.5 m .. 2 m."
    cursor.expect(",", advice)
    token = cursor.here
    if cursor.meets("<", "<="):
        near, far = 0.0, cursor.quantity("length", "a distance")
    elif cursor.meets(">", ">="):
        near, far = cursor.quantity("length", "a distance"), math.inf
    else:
        near = cursor.quantity("length", "a distance, or one of < <= > >=")
        cursor.expect("..", advice)
        far = cursor.quantity("length", "a distance")
    if not 0.0 <= near <= far:
        cursor.fail("distances of 0 or more, the nearer first", advice, token)
    return near, far


def _partners(cursor: Cursor, actions: list[Token]) -> float | None:
    advice = "Write synchronisation(receiver, catch, flight) or (opponent, push, 0 s)."
    cursor.expect(",", advice)
    while not actions or cursor.meets("|"):
        actions.append(_name_token(cursor, "an action of the partner"))
    cursor.expect(",", advice)
    if cursor.meets("flight"):
        return None
    token = cursor.here
    lag = cursor.quantity("time", "a time, or 'flight'")
    if abs(lag) > _LONGEST_LAG:
        cursor.fail(f"a time from -{_LONGEST_LAG:g} to {_LONGEST_LAG:g} s", advice, token)
    return lag


def _with_tail(cursor: Cursor, rule: SemanticRule, kind: str) -> SemanticRule:
    """Read the moment and the weight that may follow a rule."""
    if cursor.meets("at"):
        advice = f"Write 'at {START}', 'at {END}', or 'at' and an event."
        rule = replace(rule, moment=Moment(cursor.name("a moment", advice)))
    elif cursor.meets(THROUGHOUT):
        rule = replace(rule, moment=Moment(THROUGHOUT))
    if cursor.meets("weight"):
        rule = replace(rule, weight=read_weight(cursor, WEIGHT_UNITS[kind]))
    return rule


def read_weight(cursor: Cursor, kind: str) -> float:
    """Read a weight: a quantity above 0, with a unit if its kind has one."""
    token = cursor.here
    advice = "Write the deviation that costs 1; it must be above 0."
    value = cursor.quantity(kind, "a weight") if kind else cursor.number("a weight", advice)
    if value <= 0.0:
        cursor.fail("a weight above 0", advice, token)
    if not _LEAST <= value <= _MOST:
        cursor.fail(f"a weight from {_LEAST:g} to {_MOST:g}", advice, token)
    return value
