"""Reading motion grammars from text: a small format that people can read and write.

A statement is one line. It continues where a line ends with ``,``, ``:`` or ``|``, or where the
next line begins with ``|``. ``#`` begins a comment. The order of statements is free::

    grammar carrying                       # its name
    start S                                # or: start S_A for attack
    place object, goal                     # places whose positions a scene gives

    S -> Walk Carry Walk                   # rules of order; | divides alternatives
    Walk -> walk+                          # X* X+ X? and ( ) repeat, [0.3] is a probability,
                                           # a | a | b is a twice as often as b,
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
describe the activity::

    verb move = walk | run to X Z          # a class of actions, and whether it leads somewhere
    verb move = dribble to X Z with ball   # the same word for who has the ball
    verb screen = walk | run then push_off on opponent to X Z
    verb fake = fake_shot*                 # * repeats, "once" does not
    role leader, follower of leader
    object cup size 8 cm at table          # where it lies at first; without, somebody has it
    place rim at 0 0 height 3.05 m size 45 cm
    place goal height 1 m size 3 x 2 m     # upright, which a diagram puts somewhere
    ground half 15 x 14 from -7.5 -1.575   # a name, width and length, least x and z in metres
    mark 0 0, 1 0, arc 0 0 1 0 90          # a line on it: points, arcs x z radius from to (degrees)
    rest idle                              # also: with ball, for ACTION, after ACTION
    parry, duck answers punch | kick after 0.1 s

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
from dataclasses import replace
from typing import TYPE_CHECKING, NoReturn

from motiondb.errors import SceneError, suggestion
from motiondb.grammar.cfg.context_free import EMPTY, Grammar, productive_symbols, share_out
from motiondb.scene.language.activity import GIVE, PLAYER, ROLES, TAKE, Activity, Thing
from motiondb.scene.language.grammar_reading import Draft, GrammarReading
from motiondb.scene.language.motion_grammar import Annotation, MotionGrammar
from motiondb.scene.language.semantic_rules import (
    END,
    EVENT,
    RULE_NAMES,
    START,
    THROUGHOUT,
    Moment,
    SemanticRule,
    SynchronisationRule,
    Weights,
)
from motiondb.scene.language.texts import read_statements

if TYPE_CHECKING:
    from lark import Token

_SLACK = 0.02
"""Tolerance of sums of probabilities. Written probabilities are rounded: 0.33, three times, is
0.99."""


def read_motion_grammar(text: str, where: str = "grammar", is_kept: bool = False) -> MotionGrammar:
    """Read a motion grammar from its text.

    `is_kept`: Whether it is of a scene that an earlier version made, which allowed slips.
    """
    reading = GrammarReading(where, is_kept)
    read_statements("motion_grammar", text, reading)
    _check(reading)
    place = {row[0]: k for k, row in reversed(list(enumerate(reading.alternatives)))}
    by_left = sorted(reading.alternatives, key=lambda row: place[row[0]])
    terminals = tuple(terminal for terminal, _ in reading.terminals.values())
    rules = tuple(share_out(by_left))
    grammar = Grammar(reading.starts[0][0].symbol, rules, tuple(reading.terminals))
    _refuse_endless(grammar, reading)
    annotations = tuple(_annotations(reading))
    kinds = set(RULE_NAMES.values())
    return MotionGrammar(
        reading.name or where,
        tuple(start for start, _ in reading.starts),
        grammar,
        terminals,
        annotations,
        tuple(reading.place),
        Weights(**{kind: value for kind, value in reading.weight.items() if kind not in kinds}),
        _activity(reading, annotations),
    )


def _activity(reading: GrammarReading, annotations: Iterable[Annotation]) -> Activity:
    """Return the activity; a flight without an object is that of a ball."""
    thing, deeds = reading.thing, list(reading.deeds)
    said = {action for action, _, _ in deeds}
    linked = [
        (a.symbol, a.rule)
        for a in annotations
        if isinstance(a.rule, SynchronisationRule) and a.symbol in reading.terminals
    ]
    flights = [(symbol, rule.actions) for symbol, rule in linked if rule.lag is None]
    if flights:
        thing = thing or Thing("ball")
        thrown = [(action, GIVE, "") for action, _ in flights]
        thrown += [(one, TAKE, "") for _, caught in flights for one in caught]
        deeds += [deed for deed in dict.fromkeys(thrown) if deed[0] not in said]
    name, verbs = thing.name if thing else "", []
    for verb, token in reading.verbs:
        if verb.link == "with" and verb.role == name:  # not with somebody, but with the object
            verb = replace(verb, link="", role="", with_object=True)
        reading.once(token, ("verb", verb.name, verb.with_object), f"the verb {verb.name} once")
        verbs.append(verb)
    return Activity(
        tuple(reading.terminals),
        tuple(verbs),
        tuple(reading.team.items()),
        thing,
        tuple(dict.fromkeys(deeds)),
        tuple(reading.rests),
        tuple(reading.answers),
        tuple((symbol, rule.partner, rule.actions) for symbol, rule in linked),
        tuple(reading.place.values()),
        replace(reading.ground, marks=tuple(reading.marks)),
    )


def _check(reading: GrammarReading) -> None:
    """Check that every name is declared, once and in one sense."""
    where, lefts = reading.where, {left for left, _, _ in reading.alternatives}
    if not lefts:
        _refuse(where, "at least one rule such as 'S -> run'", "Write the rules of order.")
    if not reading.starts:
        _refuse(where, "a line 'start SYMBOL'", f"Write 'start {min(lefts)}', for example.")
    for name, (_, token) in reading.terminals.items():
        if name in lefts:
            advice = f"{name} has rules, so it is a nonterminal: name one of the two otherwise."
            reading.fail(token, "a terminal", advice)
    _check_probabilities(reading)
    _refuse_endless_answers(reading)
    actions = set(reading.terminals)
    roles = {*ROLES, *reading.team}
    things = {reading.thing.name} if reading.thing else set()
    places, about = set(reading.place), " or ".join(["a place", "a role", *things])
    known: dict[str, tuple[str, set[str], str]] = {
        "START": ("a start symbol that has a rule", lefts, "Write its rules."),
        "PART": (
            "a nonterminal with rules, or a terminal declared with ':='",
            {*lefts, *actions, EMPTY},
            'Write {0} := "{0}" for an action.',
        ),
        "SYMBOL": ("a symbol of the grammar", lefts | actions, "Write its rules."),
        "NONTERMINAL": ("a nonterminal", lefts, "Write its rules."),
        "TARGET": (about, roles | places | things, "Declare it: 'place {0}'."),
        "PARTNER": ("a role", roles, "Declare it: 'role {0}'."),
        "ACTION": ("an action declared with ':='", actions, ""),
        "ROLE": ("a role", {*roles, PLAYER}, ""),
        "WHERE": ("a place", places, ""),
        "THING": ("the object", things, ""),
        "AIM": ("a place or a role", {*places, *roles, PLAYER, *things}, ""),
    }
    for token in sorted(reading.tokens, key=lambda one: (one.line, one.column)):
        if token.type in known:
            what, names, advice = known[token.type]
            if token not in names:
                near = suggestion(token, sorted(names)).strip()
                advice = advice.format(token) or f"Declare {token} in a line of its own."
                advice = f"{token} is a role: name what it does." if token in roles else advice
                reading.fail(token, what, near or advice)


def _refuse(where: str, expected: str, advice: str) -> NoReturn:
    raise SceneError(f"{where}: expected {expected}, found none. {advice}")


def _check_probabilities(reading: GrammarReading) -> None:
    """Check that stated probabilities of a symbol's alternatives leave a share for the others."""
    rows: dict[str, list[float | None]] = {}
    for left, _, chance in reading.alternatives:
        rows.setdefault(left, []).append(chance)
    for left, chances in rows.items():
        stated = [chance for chance in chances if chance is not None]
        total, all_stated = math.fsum(stated), len(stated) == len(chances)
        what = f"probabilities of {left} that sum to {'' if all_stated else 'less than '}1"
        if stated and (total > 1.0 + _SLACK or (all_stated and total < 1.0 - _SLACK)):
            advice = "Correct them, or leave some of them out."
            reading.fail(reading.lines[left], what, advice, f"a sum of {total:g}")
        if stated and not all_stated and total > 1.0 - 1e-9:
            advice = "Leave a remainder for the alternatives without a probability."
            reading.fail(reading.lines[left], what, advice, f"{total:g}")


def _refuse_endless(grammar: Grammar, reading: GrammarReading) -> None:
    """Refuse nonterminals that derive no finite string."""
    productive = productive_symbols(grammar)
    for left in grammar.nonterminals:
        if left not in productive:
            what, found = f"{left} to end in actions", "only rules that lead to what never ends"
            advice = f"Add an alternative of terminals, such as '| {EMPTY}'."
            reading.fail(reading.lines[left], what, advice, found)


def _refuse_endless_answers(reading: GrammarReading) -> None:
    """Refuse acts whose answers must be answered without end, as no scene can."""
    ends: set[str] = set()
    for _ in reading.terminals:
        ends |= {
            act
            for act in reading.terminals
            if all(ends & set(said.answers) for said in reading.answers if act in said.acts)
        }
    advice = "An answer is the other player's: take it out, or allow one that needs no answer."
    for said in reading.answers:
        for act in (act for act in said.acts if act not in ends and act in reading.terminals):
            found = f"that {act} is answered by {' or '.join(said.answers)}, which is answered, too"
            what, token = "answers that come to an end", reading.terminals[act][1]
            reading.fail(token, what, advice, found)


def _annotations(reading: GrammarReading) -> Iterable[Annotation]:
    """Yield every rule at each of its symbols, with default moments and weights filled in."""
    for draft in reading.drafts:
        for token in draft.symbols:
            rule = _completed(draft, token, reading)
            key = (str(token), draft.within, replace(rule, weight=1.0))
            reading.once(token, key, f"every rule of {token} once")
            yield Annotation(str(token), rule, str(draft.within or ""), token.line or 0)


def _completed(draft: Draft, token: Token, reading: GrammarReading) -> SemanticRule:
    """Return the rule with its default weight and moment filled in."""
    rule, symbol = draft.rule, str(token)
    if math.isnan(rule.weight):
        weight = reading.weight.get(RULE_NAMES[type(rule)], type(rule).weight)
        rule = replace(rule, weight=weight)
    event = reading.terminals[symbol][0].event if symbol in reading.terminals else ""
    if isinstance(rule, SynchronisationRule):
        if rule.moment.name not in ("", event):
            advice = f"Leave 'at {rule.moment.name}' out."
            reading.fail(draft.symbols[0], "a synchronisation at the events of both", advice)
        return replace(rule, moment=Moment(event or EVENT))
    if moment := rule.moment.name:
        if moment not in (START, END, THROUGHOUT, event):
            moments = ", ".join([START, END, THROUGHOUT, *([event] * bool(event))])
            advice = "Name the instant at one of its actions."
            if symbol in reading.terminals:
                advice = f"Write 'event {moment}' after the words of {symbol}."
            advice = f"Write 'at {event}'." if event else advice
            advice = suggestion(moment, (START, END, THROUGHOUT)).strip() or advice
            what = f"a moment of {symbol} ({moments})"
            reading.fail(draft.symbols[0], what, advice, repr(moment))
        return rule
    return replace(rule, moment=Moment(event or THROUGHOUT))
