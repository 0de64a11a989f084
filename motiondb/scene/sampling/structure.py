"""A scene with everything that its derivations determine, and its best assignment of actions.

The actions of a string can fit the items of the player's expression in several ways; see
:func:`motiondb.scene.language.expressions.assignments`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from motiondb.grammar.cfg.context_free import Tree
from motiondb.scene.energy.rule_table import RuleTable
from motiondb.scene.energy.scene_arrays import SceneArrays
from motiondb.scene.energy.scene_state import SceneState
from motiondb.scene.language.expressions import Spans
from motiondb.scene.sampling.play import Play


class Structure(NamedTuple):
    """A scene with everything that its derivations determine."""

    scene: SceneArrays
    trees: list[Tree]
    table: RuleTable
    spans: list[Spans | None]  # The actions of each player's items


def least_error(
    play: Play,
    state: SceneState,
    trees: list[Tree],
    spans: Sequence[Spans | None],
    player: int,
) -> Structure:
    """Return a scene with that assignment of a player's actions to items that has the least error.

    All assignments of :meth:`.Binder.assignments` are evaluated, with the clips as they are.
    """
    best: Structure | None = None
    least = math.inf
    for chosen in play.binder.assignments(player, trees[player].leaves()):
        of = [*spans[:player], chosen, *spans[player + 1 :]]
        table = play.binder.bind(trees, of)
        scene = play.arrays(state, table)
        energy = play.energy(scene, table)
        if best is None or energy < least:
            best, least = Structure(scene, trees, table, of), energy
    assert best is not None  # a tree of a chain fits its player's expression
    return best
