"""Whom declared guards guard, within which distance, and what they may do without being asked."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from motiondb.grammar.cfg.context_free import reachable_symbols
from motiondb.scene.language.expressions import expressions
from motiondb.scene.language.motion_grammar import MotionGrammar
from motiondb.scene.language.semantic_rules import DistanceRule

if TYPE_CHECKING:
    from motiondb.scene.energy.binding import RuleTable


def unasked_actions(grammar: MotionGrammar, team: str) -> tuple[str, ...]:
    """Return the actions of a role without an event or the object that nobody has to ask for."""
    known = reachable_symbols(grammar.started(grammar.start_of(team)))
    asked, activity = grammar.only_asked, grammar.activity
    free = (one.name for one in grammar.terminals if one.name in known and not one.event)
    return tuple(name for name in free if name not in asked and not activity.deed(name))


def guard_bounds(table: RuleTable) -> tuple[float, float] | None:
    """Return the bounds of the grammar's distance for guarding; None if it has none."""
    for said in table.annotations:
        if table.activity.follows(said.symbol) and isinstance(said.rule, DistanceRule):
            return said.rule.near, said.rule.far
    return None


def guarded(table: RuleTable, player: int, before: int | None = None) -> int:
    """Return whom a declared guard guards at last, or before an action; -1 if nobody is.

    It is the opponent of the last element drawn for them about one, else who was declared.
    """
    one = table.diagram.player[table.players[player]]
    if not one.guards or table.activity.leader_of(one.team):
        return -1
    drawn = [target for first, target in attends(table, player) if before is None or first < before]
    return drawn[-1] if drawn else table.players.index(one.guards)


def attends(table: RuleTable, player: int) -> Iterator[tuple[int, int]]:
    """Yield the first action of every element of a player about an opponent, and the opponent."""
    diagram, name = table.diagram, table.players[player]
    items = [item for item in expressions(diagram)[name] if item.element >= 0]
    rows = [first for _, who, first, _ in table.steps if who == player]
    for item, first in zip(items, rows, strict=True):
        own = diagram.elements[item.element].player == name
        if own and item.other and diagram.player[item.other].team != diagram.player[name].team:
            yield first, table.players.index(item.other)
