"""The semantic rules of a scene in one table of numbers for compiled code.

A row is one rule f_k of a sequence of a player's actions. All players that it is about are resolved
to a player's number or a point on the ground::

    kind      what is measured: POSITION, DIRECTION, SYNCHRONISATION, DISTANCE, LINE; UNMET if
              nobody fills a role: then f = 1
    player    whose rule it is; first, last: the actions, half-open
    moment    AT_START (first frame of the actions), AT_END (their last frame), AT_EVENT (the event
              of the first action, or the middle of its clip), THROUGHOUT (mean over the frames),
              ON_THE_WAY (the frame at which ``fraction`` of the distance has been covered)
    target    a player, or POINT (x, z), or HEADING (theta in ``x``); other, other_x, other_z: the
              second end of a line
    near, far of a distance, metres; lag of a synchronisation, seconds, NaN for a ball's flight
    partner   of a synchronisation, whose actions are ``partners[partner_first:partner_last]``; the
              action that fulfils the rule best counts
    weight    c_k: f_k / c_k is the row's part of -log P(Y)

A table depends on the trees alone, not on clips and places. It is computed again when the structure
changes, and not when clips are exchanged.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 3.1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.records import IntArray
from motiondb.scene.language.semantic_rules import (
    DirectionRule,
    DistanceRule,
    LineRule,
    PositionRule,
    SemanticRule,
    SynchronisationRule,
)

POSITION, DIRECTION, SYNCHRONISATION, DISTANCE, LINE, UNMET = range(6)
AT_START, AT_END, AT_EVENT, THROUGHOUT, ON_THE_WAY = range(5)
POINT, HEADING = -1, -2

KINDS: dict[type, int] = {
    PositionRule: POSITION,
    DirectionRule: DIRECTION,
    SynchronisationRule: SYNCHRONISATION,
    DistanceRule: DISTANCE,
    LineRule: LINE,
}  # Number of each kind of rule

UNMET_WEIGHT = 0.1  # c_k of a rule whose role nobody fills: it costs 10, like a broken distance

ROW = np.dtype(
    [(name, np.int64) for name in ("kind", "player", "first", "last", "moment")]
    + [("fraction", np.float64), ("target", np.int64), ("x", np.float64), ("z", np.float64)]
    + [("other", np.int64), ("other_x", np.float64), ("other_z", np.float64)]
    + [("near", np.float64), ("far", np.float64), ("lag", np.float64)]
    + [(name, np.int64) for name in ("partner", "partner_first", "partner_last")]
    + [("weight", np.float64)]
)  # Fields of a row, each aligned to 8 bytes


@dataclass(frozen=True, eq=False)
class RuleTable:
    """The rules of a scene."""

    players: tuple[str, ...]  # Names in the order of the diagram; the rows hold their indices
    actions: tuple[tuple[str, ...], ...]  # The action string of every player
    rows: NDArray[np.void]
    partners: IntArray  # (n,), int: actions that synchronisation rules may refer to
    # (n, 4), int: player, action, player, action of those who are meant to touch
    contacts: IntArray
    rules: tuple[SemanticRule, ...]  # The rule that each row was made from; also for unmet rules
    # (rules,), int: the class of the player's expression that the row belongs to, or -1
    items: IntArray
    stray: int = 0  # Number of actions of all players that belong to no class
