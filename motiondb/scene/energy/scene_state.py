"""The state of sampling: for every player a tree of actions, their clips, a place and a time.

An instance Y of an action string plays one clip after the other. Where the first clip begins is
free (the origin, a ground transform), and so is when (the delay). Everything else follows from the
clips.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), sections 3.1 and 5. The paper does not say where a string of clips begins.
"""

from __future__ import annotations

from dataclasses import dataclass

from motiondb.grammar.cfg.context_free import Tree
from motiondb.records import IntArray


@dataclass(frozen=True, eq=False)
class PlayerState:
    """The sampled state of one player."""

    tree: Tree  # Derivation of the action string, which is its leaves
    entries: IntArray  # (actions,), int: entries of the library, one for each action
    # x, z and heading (from +z towards +x) where the first clip begins
    origin: tuple[float, float, float]
    delay: int = 0  # Frames, 0 or more, for which the player stands before the first clip
    # The actions of each item of the player's expression; None if none were chosen yet
    spans: tuple[tuple[int, int], ...] | None = None


@dataclass(frozen=True, eq=False)
class SceneState:
    """The sampled states of all players, in the order of the diagram."""

    players: tuple[PlayerState, ...]

    @property
    def trees(self) -> tuple[Tree, ...]:
        """The players' derivations."""
        return tuple(player.tree for player in self.players)
