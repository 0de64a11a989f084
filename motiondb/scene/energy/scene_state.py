"""A scene as it is sampled: for every player a tree of actions, a clip for each, a place and time.

An instance Y of an action string puts one clip after the other: where the first begins is free (the
origin, a ground transform), and so is when (the delay); everything else follows from the clips.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), sections 3.1 and 5. Print does not say where a string of clips begins.
"""

from __future__ import annotations

from dataclasses import dataclass

from motiondb.grammar.cfg.context_free import Tree
from motiondb.records import IntArray


@dataclass(frozen=True, eq=False)
class PlayerState:
    """One player.

    Attributes
    ----------
    tree : derivation of the action string, which is its leaves.
    entries : array (actions,), numbers of clips in the library, one for each action.
    origin : x, z (metres) and heading (radians, from +z towards +x) of the first clip's beginning.
    delay : frames, 0 or more, for which the player stands before the first clip begins.
    """

    tree: Tree
    entries: IntArray
    origin: tuple[float, float, float]
    delay: int = 0


@dataclass(frozen=True, eq=False)
class SceneState:
    """All players, in the order of the diagram."""

    players: tuple[PlayerState, ...]

    @property
    def trees(self) -> tuple[Tree, ...]:
        """The players' derivations."""
        return tuple(player.tree for player in self.players)
