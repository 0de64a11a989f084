"""Casting: the shortest string of actions for each player of a diagram, or why there is none.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 4.
"""

from __future__ import annotations

from collections.abc import Sequence

from motiondb.errors import SceneError
from motiondb.grammar.cfg.context_free import Tree, reachable_symbols
from motiondb.scene.language.activity import OPPONENT, PARTNER, ROLES, TARGET
from motiondb.scene.language.expressions import MOST_ACTIONS, Item, exact_actions, expressions
from motiondb.scene.language.motion_grammar import MotionGrammar
from motiondb.scene.language.semantic_rules import RULE_NAMES, SemanticRule
from motiondb.scene.language.tactics import Diagram, Element
from motiondb.scene.services.services import plan
from motiondb.scene.services.times import check_times


def cast(diagram: Diagram, grammar: MotionGrammar, where: str = "") -> dict[str, Tree]:
    """Return for each player the shortest string of the grammar that fits the diagram (g_user = 0).

    `where`: Name of the diagram's file, for messages; by default the name of the diagram.
    """
    where = where or diagram.name
    _check_places(diagram, grammar, where)
    check_times(diagram, where)
    return {
        name: _cast_player(diagram, grammar, name, items, where)
        for name, items in expressions(diagram).items()
    }


def try_cast(
    diagram: Diagram, grammar: MotionGrammar, where: str = ""
) -> tuple[dict[str, Tree], dict[str, str]]:
    """Cast every player by itself.

    `where`: Name of the diagram's file, for messages; by default the name of the diagram.
    """
    where = where or diagram.name
    _check_places(diagram, grammar, where)
    check_times(diagram, where)
    trees, faults = {}, {}
    for name, items in expressions(diagram).items():
        try:
            trees[name] = _cast_player(diagram, grammar, name, items, where)
        except SceneError as error:
            faults[name] = str(error)
    return trees, faults


def _cast_player(
    diagram: Diagram, grammar: MotionGrammar, name: str, items: Sequence[Item], where: str
) -> Tree:
    """Return a player's shortest string, or raise a SceneError that names the player."""
    player = diagram.player[name]
    try:
        start = grammar.start_of(player.team)
    except SceneError as error:
        raise SceneError(f"{where}:{player.line}: '{player.team} {name}': {error}") from None
    if len(items) > MOST_ACTIONS:
        raise SceneError(
            f"{where}:{player.line}: '{name}': expected at most {MOST_ACTIONS} things to do,"
            f" found {len(items)}. Make a scene of each part of the play."
        )
    _check_roles(diagram, grammar, name, start, items, where)
    return _planned(diagram, grammar, name, start, items, where)


def _planned(
    diagram: Diagram,
    grammar: MotionGrammar,
    name: str,
    start: str,
    items: Sequence[Item],
    where: str,
) -> Tree:
    """Return a player's shortest string, or raise a SceneError at the first impossible act."""
    goals = [item.actions for item in items]
    try:
        return plan(grammar, (), goals, start)
    except SceneError as error:
        reason = str(error)
    last = 1
    while last < len(items):
        try:
            plan(grammar, (), goals[:last], start)
        except SceneError:
            break
        last += 1
    element = items[last - 1].element
    line = diagram.elements[element].line if element >= 0 else diagram.player[name].line
    wanted = "".join(str(item) for item in items)
    raise SceneError(
        f"{where}:{line}: expected of {name} what the grammar {grammar.name} allows, found"
        f" {wanted}. {reason}"
    )


def _check_places(diagram: Diagram, grammar: MotionGrammar, where: str) -> None:
    """Refuse a diagram without a place that the grammar's rules need."""
    known = dict(diagram.places)
    for place in grammar.places:
        if place not in known and place not in diagram.player:
            raise SceneError(
                f"{where}: expected the place {place!r}, which rules of the grammar"
                f" {grammar.name} are about, found {', '.join(known)}. Add 'place {place} at 0 0'."
            )


def _check_roles(
    diagram: Diagram,
    grammar: MotionGrammar,
    name: str,
    start: str,
    items: Sequence[Item],
    where: str,
) -> None:
    """Refuse an action that a player may do, if nobody fills a role of its rules."""
    above = reachable_symbols(grammar.started(start))
    asked: dict[str, list[Item | None]] = {}
    for item in items:
        for action in item.actions if item.element >= 0 else ():
            asked.setdefault(action, []).append(item)
    closed = set(exact_actions(diagram, grammar, name)) - set(asked)
    roles = {*ROLES, *(role for role, _ in grammar.activity.roles)}
    acts = [(a, i) for a in grammar.terminal for i in asked.get(a, [None])]
    for action, one in acts:
        if action not in above or action in closed or (one and one.other):
            continue
        element = diagram.elements[one.element] if one else None
        for rule in grammar.rules_of(action, above):
            about = [getattr(rule, part, "") for part in ("target", "partner", "first", "second")]
            for role in dict.fromkeys(each for each in about if isinstance(each, str)):
                if role not in roles:
                    continue
                filled = diagram.filled(role, name, element)
                if role == TARGET:
                    filled = filled or grammar.activity.aim(action)
                if not filled:
                    _refuse_role(diagram, name, (action, element), (role, rule), where)


def _refuse_role(
    diagram: Diagram,
    name: str,
    done: tuple[str, Element | None],
    asked: tuple[str, SemanticRule],
    where: str,
) -> None:
    action, element = done
    role, rule = asked
    line = element.line if element else diagram.player[name].line
    who = {OPPONENT: "an opponent", PARTNER: "a partner", TARGET: "a target"}.get(role, f"a {role}")
    advice = f"Add a player who is the {role}"
    advice = {
        OPPONENT: "Add a player of the other team",
        TARGET: f"Write 'at' and a place behind {element or action}",
    }.get(role, advice)
    rest = ", or take the element out." if element else ", or the rule out of the grammar."
    raise SceneError(
        f"{where}:{line}: '{element or name}': expected {who} of {name}, whom the rule"
        f" {RULE_NAMES[type(rule)]} of {action} is about, found none. {advice}{rest}"
    )
