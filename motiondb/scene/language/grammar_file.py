"""Reading motion grammars from text: a small format that people can read and write.

A statement is one line. It continues where a line ends with ``,``, ``:`` or ``|``, or where the
next line begins with ``|``. ``#`` begins a comment. The order of statements is free::

    grammar carrying                       # its name
    start S                                # or: start S_A for attack
    place object, goal                     # places whose positions a scene gives

    S -> Walk Carry Walk                   # rules of order; | divides alternatives
    Walk -> walk+                          # X* X+ X? and ( ) repeat, [0.3] is a probability,
                                           # (x & y & z) is all of them in any order,
    Carry -> pickup carry* putdown         # empty is the empty string

    walk := "walk", "stroll"               # words that find clips of the action
    pickup := "pick up" without "fight" event contact    # and the instant that rules look at

    carry := "carry" when asked                          # only where a diagram asks for it
    punch := terminal f of boxing                        # segments of a learned grammar
    duck := "duck" event lowest(head)                    # an instant found in the motion

    pickup: direction(object) weight 20 deg, distance(object, <= 50 cm)      # rules of space
    walk in Walk: line(object, goal) throughout                              # below Walk only
    S: position(goal) at end               # of everything that S derives

    weight collision 0.1                   # of the terms that belong to no action
    weight position 0.3 m                  # of all position rules without a weight

The other statements (``verb``, ``role``, ``object``, ``ground``, ``mark``, ``rest``, ``answers``)
are those of :mod:`.activity_text`.

Semantic rules are ``position(TARGET)``, ``direction(TARGET)`` or ``direction(90 deg)``,
``distance(TARGET, <= 2.5 m)``, ``>=``, ``0.5 m .. 2 m``, ``line(TARGET, TARGET)`` and
``synchronisation(ROLE, ACTION | ACTION, LAG)``, where the lag is a time or ``flight``. A target is
a place, a role of the grammar, or ``receiver``, ``opponent``, ``partner`` or ``target``.
``direction`` may say at which angle: ``direction(partner, 90 deg)``. What an action does with the
object stands among its rules: ``take(ball)``, ``keep``, ``give``, ``send(ball, rim)``, ``put``. A
rule may be followed by ``at start``, ``at end``, ``at EVENT`` or ``throughout``, and by ``weight``
with a unit: the deviation that costs 1. Without a moment, a rule looks at the event of its
terminal, or throughout where the terminal has none.

Repetitions become auxiliary nonterminals named after the left side: ``Walk.1``. The bounds of a
distance are inclusive, whether written ``<`` or ``<=``.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

from motiondb.body import body
from motiondb.errors import SceneError, suggestion
from motiondb.grammar.cfg.context_free import EMPTY, Grammar, productive_symbols, share_out
from motiondb.scene.language.activity import DEEDS, PLAYER, ROLES
from motiondb.scene.language.activity_text import (
    STATEMENTS,
    ActivityDraft,
    finished,
    read_answers,
    read_deed,
    read_place,
)
from motiondb.scene.language.motion_grammar import Annotation, MotionGrammar, Start, Terminal
from motiondb.scene.language.production_text import read_alternatives
from motiondb.scene.language.semantic_rules import (
    END,
    EVENT,
    INSTANTS,
    NEAREST,
    START,
    THROUGHOUT,
    DirectionRule,
    DistanceRule,
    LineRule,
    Moment,
    PositionRule,
    SemanticRule,
    SynchronisationRule,
    Weights,
)
from motiondb.scene.language.tokens import Cursor, Token, refuse, statements

# Semantic rules in text: ``SYMBOLS in NONTERMINAL: rule, rule``.

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


def read_rules(cursor: Cursor, activity: ActivityDraft) -> list[Draft]:
    """Read all rules of a statement; deeds and answers go into the ``activity``."""
    symbols = [_name_token(cursor, "a symbol of the grammar")]
    while cursor.meets(","):
        symbols.append(_name_token(cursor, "a symbol of the grammar"))
    if cursor.meets("answers"):
        read_answers(cursor, tuple(symbols), activity)
        return []
    within = _name_token(cursor, "a nonterminal") if cursor.meets("in") else None
    cursor.expect(":", "Write 'SYMBOL: rule' or 'SYMBOL in NONTERMINAL: rule'.")
    drafts: list[Draft] = []
    first = True
    while first or cursor.meets(","):
        first = False
        if cursor.here.text in DEEDS:
            read_deed(cursor, tuple(symbols), activity)
            continue
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
        facing = _facing(cursor, targets)
        turn = cursor.quantity("angle", "an angle") if targets and cursor.meets(",") else 0.0
        rule = DirectionRule(facing, moment, _UNSTATED, turn)
    elif kind == "distance":
        target = _target(cursor, targets)
        near, far = _bounds(cursor)
        rule = DistanceRule(target, near, far, moment, _UNSTATED)
    elif kind == "line":
        first = _target(cursor, targets)
        cursor.expect(",", "A line has two ends: line(opponent, rim).")
        rule = LineRule(first, _target(cursor, targets), moment, _UNSTATED)
    else:
        targets.append(cursor.here)
        partner = cursor.name("a role", "Write whom it is about.")
        lag = _partners(cursor, actions)
        names = tuple(token.text for token in actions)
        rule = SynchronisationRule(partner, names, lag, moment, _UNSTATED)
    cursor.expect(")", "Close the bracket of the rule.")
    return kind, _with_tail(cursor, rule, kind), targets, actions


def read_event(cursor: Cursor, advice: str) -> str:
    """Read an event of a sheet, or an instant such as ``nearest(r_wrist, partner.head)``."""
    token = cursor.here
    name = cursor.name("an event", advice)
    if not cursor.meets("("):
        return name
    if name not in INSTANTS:
        cursor.fail(f"one of {', '.join(INSTANTS)} before '('", advice, token)
    joints = [_joint(cursor)]
    if name == NEAREST:
        cursor.expect(",", "Write nearest(r_wrist, partner.head).")
        whose = "partner." if cursor.meets("partner") and cursor.expect(".", "") else ""
        joints.append(whose + _joint(cursor))
    cursor.expect(")", "Close the bracket.")
    return f"{name}({', '.join(joints)})"


def _joint(cursor: Cursor) -> str:
    return cursor.name("a joint", "See the joints of the canonical body.", body.JOINTS)


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
        rule = replace(rule, moment=Moment(read_event(cursor, advice)))
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


_SLACK = 0.02
"""Tolerance of sums of probabilities. Written probabilities are rounded: 0.33, three times, is
0.99."""
_STATEMENT = "a statement such as 'S -> run', 'run := \"run\"' or 'run: position(goal)'"


class _Text:
    """The part of a file read so far."""

    def __init__(self, where: str) -> None:
        self.where = where
        self.name = ""
        self.starts: list[tuple[Start, Token]] = []
        self.activity = ActivityDraft()
        self.alternatives: list[tuple[str, tuple[str, ...], float | None]] = []
        self.lines: dict[str, Token] = {}
        self.used: dict[str, Token] = {}
        self.terminals: dict[str, tuple[Terminal, Token]] = {}
        self.rules: list[Draft] = []
        self.kinds: dict[str, float] = {}
        self.weights: dict[str, float] = {}
        self.said: dict[str, int] = {}


def read_motion_grammar(text: str, where: str = "grammar") -> MotionGrammar:
    """Read a motion grammar from its text."""
    reading = _Text(where)
    for cursor in statements(text, where):
        _read_statement(cursor, reading)
    _check(reading)
    place = {
        left: k for k, left in enumerate(dict.fromkeys(row[0] for row in reading.alternatives))
    }
    by_left = sorted(reading.alternatives, key=lambda row: place[row[0]])
    rules = tuple(share_out(by_left))
    grammar = Grammar(reading.starts[0][0].symbol, rules, tuple(reading.terminals))
    _refuse_endless(grammar, reading)
    annotations = tuple(_annotations(reading))
    linked = [
        (a.symbol, a.rule)
        for a in annotations
        if isinstance(a.rule, SynchronisationRule) and a.symbol in reading.terminals
    ]
    replies = [(symbol, rule.partner, rule.actions) for symbol, rule in linked]
    flights = [(symbol, rule.actions) for symbol, rule in linked if rule.lag is None]
    return MotionGrammar(
        reading.name or where,
        tuple(start for start, _ in reading.starts),
        grammar,
        tuple(terminal for terminal, _ in reading.terminals.values()),
        annotations,
        tuple(reading.activity.places),
        Weights(**reading.weights),
        finished(reading.activity, tuple(reading.terminals), replies, flights),
    )


def _read_statement(cursor: Cursor, reading: _Text) -> None:
    """Read one statement and add it to the part read so far."""
    first, second = cursor.here, cursor.after
    if first.kind != "name":
        cursor.fail(_STATEMENT, "Begin the line with a name; comments begin with '#'.")
    if second.text == "->":
        _read_production(cursor, reading)
    elif second.text == ":=":
        _read_terminal(cursor, reading)
    elif second.text in (":", ",", "in", "answers"):
        reading.rules.extend(read_rules(cursor, reading.activity))
    else:
        _read_keyword(cursor, reading)
    cursor.done("Write one statement a line.")


def _read_keyword(cursor: Cursor, reading: _Text) -> None:
    """Read a statement that begins with its own word."""
    first, second = cursor.here, cursor.after
    if cursor.meets("grammar"):
        cursor.once(reading.said, "grammar", "'grammar' once", first)
        reading.name = cursor.name("the grammar's name", "Write one name.")
    elif cursor.meets("start"):
        _read_start(cursor, reading)
    elif cursor.meets("place"):
        read_place(cursor, reading.activity)
        while cursor.meets(","):
            read_place(cursor, reading.activity)
    elif first.text in STATEMENTS and second.kind in ("name", "number"):
        cursor.take()
        STATEMENTS[first.text](cursor, reading.activity)
    elif cursor.meets("weight"):
        _read_weight(cursor, reading)
    else:
        words = ("grammar", "start", "place", "weight", *STATEMENTS)
        near = suggestion(first.text, words).strip()
        cursor.fail(_STATEMENT, near or "The first name must be followed by '->', ':=' or ':'.")


def _read_production(cursor: Cursor, reading: _Text) -> None:
    token = cursor.take()
    if token.text == EMPTY:
        cursor.fail("a nonterminal before '->'", f"'{EMPTY}' means the empty string.", token)
    reading.lines.setdefault(token.text, token)
    cursor.take()
    for left, right, chance in read_alternatives(cursor, token.text, reading.used):
        reading.lines.setdefault(left, token)
        reading.alternatives.append((left, right, chance))


def _read_terminal(cursor: Cursor, reading: _Text) -> None:
    token = cursor.take()
    cursor.take()
    if token.text in reading.terminals:
        line = reading.terminals[token.text][1].line
        cursor.fail(
            "a terminal that is not declared yet",
            f"Line {line} declares it: write all its words there.",
            token,
        )
    learned = ("", "")
    if cursor.meets("terminal"):
        advice = f"Write {token.text} := terminal f of boxing."
        name = cursor.take().text if cursor.here.kind == "text" else cursor.name("its name", advice)
        cursor.expect("of", advice)
        learned = name, cursor.name("the name of a learned grammar", advice)
    elif cursor.here.kind != "text":
        cursor.fail(
            "quoted words that find the action's clips", f'Write {token.text} := "{token.text}".'
        )
    phrases = () if learned[0] else _phrases(cursor)
    without = _phrases(cursor) if cursor.meets("without") else ()
    event = ""
    if cursor.meets("event"):
        event = read_event(cursor, "Write 'event release', or 'event lowest(head)'.")
    asked = cursor.meets("when") and bool(cursor.expect("asked", "Write 'when asked'."))
    terminal = Terminal(token.text, phrases, without, event, asked, learned)
    reading.terminals[token.text] = terminal, token


def _phrases(cursor: Cursor) -> tuple[str, ...]:
    """Read quoted words, divided by commas."""
    phrases: list[str] = []
    while not phrases or cursor.meets(","):
        if cursor.here.kind != "text" or not cursor.here.text.strip():
            cursor.fail("words in quotes", 'Write them as "pick up".')
        phrases.append(cursor.take().text)
    return tuple(phrases)


def _read_start(cursor: Cursor, reading: _Text) -> None:
    token = cursor.here
    symbol = cursor.name("a start symbol", "Write 'start S', or 'start S for attack'.")
    team = ""
    if cursor.meets("for"):
        team = cursor.name("a role", "Write 'start S for leader'.")
        reading.activity.roles.setdefault(team, "")
    for known, earlier in reading.starts:
        if known.team in ("", team):
            whom = f"the role {team}" if team else "everybody"
            advice = f"Line {earlier.line} says where {known.team or 'everybody'} begins already."
            cursor.fail(f"one start symbol for {whom}", advice, token)
    reading.starts.append((Start(symbol, team), token))


def _read_weight(cursor: Cursor, reading: _Text) -> None:
    kinds = (*WEIGHT_UNITS, "user", "smooth", "collision", "effort")
    token = cursor.here
    kind = cursor.name("what the weight is for", "See the format.", kinds)
    unit = "length" if kind == "effort" else WEIGHT_UNITS.get(kind, "")
    cursor.once(reading.said, f"weight {kind}", f"the weight of {kind} once", token)
    value = read_weight(cursor, unit)
    (reading.kinds if kind in WEIGHT_UNITS else reading.weights)[kind] = value


def _check(reading: _Text) -> None:
    """Check that every name is declared, once and in one sense."""
    where, lefts = reading.where, {left for left, _, _ in reading.alternatives}
    if not lefts:
        refuse(where, "at least one rule such as 'S -> run'", "none", "Write the rules of order.")
    if not reading.starts:
        refuse(where, "a line 'start SYMBOL'", "none", f"Write 'start {min(lefts)}', for example.")
    for start, token in reading.starts:
        _known(start.symbol, lefts, "a start symbol that has a rule", token, where)
    for name, (_, token) in reading.terminals.items():
        if name in lefts:
            advice = f"{name} has rules, so it is a nonterminal: name one of the two otherwise."
            _refuse_at(token, where, "a terminal", advice)
    _check_probabilities(reading)
    known = lefts | set(reading.terminals)
    for name, token in reading.used.items():
        what = "a nonterminal with rules, or a terminal declared with ':='"
        _known(name, known, what, token, where, f'Write {name} := "{name}" for an action.')
    for draft in reading.rules:
        _check_rule_names(draft, known, lefts, reading)
    activity = reading.activity
    roles = {*ROLES, *activity.roles, PLAYER}
    things = {activity.thing.name} if activity.thing else set()
    known_as = {
        "action": ("an action declared with ':='", set(reading.terminals)),
        "role": ("a role", roles),
        "place": ("a place", set(activity.places)),
        "object": ("the object", things),
        "aim": ("a place or a role", {*activity.places, *roles, *things}),
    }
    for token, kind in activity.named:
        what, names = known_as[kind]
        _known(token.text, names, what, token, where, f"Declare {token.text} in a line of its own.")


def _check_rule_names(draft: Draft, known: set[str], lefts: set[str], reading: _Text) -> None:
    """Check that the symbols, targets and actions of a semantic rule are declared."""
    where = reading.where
    for token in draft.symbols:
        _known(token.text, known, "a symbol of the grammar", token, where)
    if draft.within is not None:
        _known(draft.within.text, lefts, "a nonterminal", draft.within, where)
    for token in draft.targets:
        thing = reading.activity.thing
        things = [thing.name] if thing else []
        targets = {*ROLES, *reading.activity.roles}
        if draft.kind != "synchronisation":
            targets |= {*reading.activity.places, *things}
        advice = f"Declare it: 'place {token.text}'."
        _known(token.text, targets, "a place or a role", token, where, advice)
    for token in draft.actions:
        _known(token.text, set(reading.terminals), "a terminal", token, where)


def _check_probabilities(reading: _Text) -> None:
    """Check that stated probabilities of a symbol's alternatives leave a share for the others."""
    rows: dict[str, list[float | None]] = {}
    for left, _, chance in reading.alternatives:
        rows.setdefault(left, []).append(chance)
    for left, chances in rows.items():
        stated = [chance for chance in chances if chance is not None]
        total, all_stated = math.fsum(stated), len(stated) == len(chances)
        if stated and (total > 1.0 + _SLACK or (all_stated and total < 1.0 - _SLACK)):
            what = f"probabilities of {left} that sum to {'' if all_stated else 'less than '}1"
            token, advice = reading.lines[left], "Correct them, or leave some of them out."
            place = f"{reading.where}:{token.line}:{token.column}"
            refuse(place, what, f"a sum of {total:g}", advice)
        if stated and not all_stated and total > 1.0 - 1e-9:
            token = reading.lines[left]
            advice = "Leave a remainder for the alternatives without a probability."
            what = f"probabilities of {left} that sum to less than 1"
            refuse(f"{reading.where}:{token.line}:{token.column}", what, f"{total:g}", advice)


def _known(
    name: str, known: Iterable[str], expected: str, token: Token, where: str, advice: str = ""
) -> None:
    """Refuse a name that is not among the known ones, and suggest a similar one."""
    if name not in known:
        near = suggestion(name, sorted(known)).strip()
        _refuse_at(
            token, where, expected, near or advice or "Write its rules, or correct the name."
        )


def _refuse_at(token: Token, where: str, expected: str, advice: str) -> None:
    refuse(f"{where}:{token.line}:{token.column}", expected, str(token), advice)


def _refuse_endless(grammar: Grammar, reading: _Text) -> None:
    """Refuse nonterminals that derive no finite string."""
    productive = productive_symbols(grammar)
    for left in grammar.nonterminals:
        if left not in productive:
            token = reading.lines[left]
            raise SceneError(
                f"{reading.where}:{token.line}:{token.column}: expected {left} to end in actions,"
                f" but every rule of it leads to a symbol that never ends."
                f" Add an alternative of terminals, such as '| {EMPTY}'."
            )


def _annotations(reading: _Text) -> Iterable[Annotation]:
    """Yield every rule at each of its symbols, with default moments and weights filled in."""
    for draft in reading.rules:
        for symbol in draft.symbols:
            within = draft.within.text if draft.within else ""
            rule = _completed(draft.rule, draft, symbol.text, reading)
            yield Annotation(symbol.text, rule, within, symbol.line)


def _completed(rule: SemanticRule, draft: Draft, symbol: str, reading: _Text) -> SemanticRule:
    """Return the rule with its default weight and moment filled in."""
    if math.isnan(rule.weight):
        default = reading.kinds.get(draft.kind, type(rule).weight)
        rule = replace(rule, weight=default)
    event = reading.terminals[symbol][0].event if symbol in reading.terminals else ""
    if isinstance(rule, SynchronisationRule):
        if rule.moment.name not in ("", event):
            what, token = "a synchronisation at the events of both", draft.symbols[0]
            _refuse_at(token, reading.where, what, f"Leave 'at {rule.moment.name}' out.")
        return replace(rule, moment=Moment(event or EVENT))
    if rule.moment.name:
        if rule.moment.name not in (START, END, THROUGHOUT, event):
            _refuse_moment(rule.moment.name, draft, symbol, reading)
        return rule
    return replace(rule, moment=Moment(event or THROUGHOUT))


def _refuse_moment(moment: str, draft: Draft, symbol: str, reading: _Text) -> None:
    """Refuse an instant that the symbol's clips do not have; its rule would never be evaluated."""
    token, known = draft.symbols[0], reading.terminals.get(symbol)
    event = known[0].event if known else ""
    what = f"a moment of {symbol} ({', '.join([START, END, THROUGHOUT, *([event] * bool(event))])})"
    advice = f"Write 'event {moment}' after the words of {symbol}." if known else ""
    advice = advice if not event else f"Write 'at {event}'."
    place = f"{reading.where}:{token.line}:{token.column}"
    refuse(place, what, repr(moment), advice or "Name the instant at one of its actions.")
