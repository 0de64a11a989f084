"""Casting: the shortest string of actions for each player of a diagram, or why there is none.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 4.
"""

from __future__ import annotations

from collections.abc import Sequence

from motiondb.errors import SceneError
from motiondb.grammar.cfg.context_free import Tree, reachable_symbols
from motiondb.scene.language.expressions import MOST_ACTIONS, Item, expressions
from motiondb.scene.language.motion_grammar import MotionGrammar
from motiondb.scene.language.semantic_rules import RULE_NAMES
from motiondb.scene.language.tactics import Diagram
from motiondb.scene.services.services import plan


def cast(diagram: Diagram, grammar: MotionGrammar, where: str = "") -> dict[str, Tree]:
    """Return for each player the shortest string of the grammar that fits the diagram (g_user = 0).

    `where`: Name of the diagram's file, for messages; by default the name of the diagram.
    """
    where = where or diagram.name
    _check_places(diagram, grammar, where)
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
    for item in items:
        _check_opponent(diagram, grammar, name, start, item, where)
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
        if place not in known:
            raise SceneError(
                f"{where}: expected the place {place!r}, which rules of the grammar"
                f" {grammar.name} are about, found {', '.join(known)}. Add 'place {place} at 0 0'."
            )


def _check_opponent(
    diagram: Diagram, grammar: MotionGrammar, name: str, start: str, item: Item, where: str
) -> None:
    """Refuse an action with a rule about an opponent if the player has none."""
    if item.element < 0 or item.other or diagram.opponent_of(name):
        return
    above = reachable_symbols(grammar.started(start))
    for action in item.actions:
        for rule in grammar.rules_of(action, above):
            about = [getattr(rule, part, "") for part in ("target", "partner", "first", "second")]
            if "opponent" in about:
                element = diagram.elements[item.element]
                raise SceneError(
                    f"{where}:{element.line}: '{element}': expected an opponent of {name},"
                    f" whom the rule {RULE_NAMES[type(rule)]} of {action} is about, found none."
                    " Add a player of the other team, or take the element out."
                )
