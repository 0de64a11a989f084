"""The target of sampling: a diagram under a grammar with a library's clips, and prices.

The target is -log P(Z) of scenes with g_user = 0 and a limited number of actions a player. P(X), as
printed, does not depend on the length of strings, nor P(Y) on how long players stand before they
begin: a scene in which players dribble and pivot for a minute before they do what was drawn is as
probable as one without. So small prices may be added (:class:`Prices`).

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 5; the prices are ours.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from motiondb.grammar.cfg.context_free import Tree, choices_of, derive_by
from motiondb.records import IntArray
from motiondb.scene.energy.binding import Binder, RuleTable
from motiondb.scene.energy.energy import scene_arrays
from motiondb.scene.energy.placement import ClipArrays, clip_arrays
from motiondb.scene.energy.scene_arrays import EVERY, SceneArrays, SceneState
from motiondb.scene.language.expressions import MOST_ACTIONS, exact_actions
from motiondb.scene.language.motion_grammar import MotionGrammar
from motiondb.scene.language.tactics import Diagram
from motiondb.scene.sampling.clip_choice import ClipGroups, clip_groups
from motiondb.scene.sampling.random_subtrees import Derivations
from motiondb.scene.sampling.tree_growth import Chains, TreeShape, chains, tree_shape

if TYPE_CHECKING:
    from motiondb.scene.clips.clips import ClipLibrary


@dataclass(frozen=True)
class Prices:
    """Penalties that are added to -log P(Z); 1 is the cost of a rule that fails by its weight."""

    delay: float = 0.0  # For every frame that a player stands before they begin
    duration: float = 0.0  # For every frame until the last player's last
    action: float = 0.0
    stray: float = 0.0  # Additionally for every action that the diagram does not ask for
    # For every multiple of its weight by which a rule fails beyond the first. It does not apply to
    # synchronisations, because polishing bends time more easily than paths
    excess: float = 0.0
    # For every frame in which somebody who is to keep moving stands before or after their actions
    standing: float = 0.0


FREE = Prices()  # No prices: -log P(Z) as printed


@dataclass(frozen=True, eq=False)
class Play:
    """A diagram under a grammar with a library's clips."""

    binder: Binder  # Binds rules to trees
    derivations: tuple[Derivations, ...]  # For every player, in the order of the diagram
    library: ClipArrays
    groups: ClipGroups  # The clips by terminal and seam class, for no particular temperature
    first: dict[str, tuple[int, int]]  # For every terminal its entries [first, last) of the library
    most_actions: int = MOST_ACTIONS  # Largest number of actions of a player
    prices: Prices = FREE  # Prices of delays, frames and actions
    # Fraction of changes that keep the clips after the change in place, instead of those before
    tails: float = 0.5
    every: int = EVERY  # Frames between grid points

    @property
    def grammar(self) -> MotionGrammar:
        """The motion grammar."""
        return self.binder.grammar

    @cached_property
    def moving(self) -> tuple[int, ...]:
        """The players who are to keep moving."""
        diagram = self.binder.diagram
        kept = {one.player for one in diagram.stretches if not one.other}
        return tuple(n for n, name in enumerate(self.binder.names) if name in kept)

    @cached_property
    def chains(self) -> tuple[Chains, ...]:
        """Where the trees of every player can grow."""
        return tuple(chains(one) for one in self.derivations)

    def bind(self, trees: Sequence[Tree]) -> RuleTable:
        """Return the rules of the players' trees, with the first assignments that fit."""
        return self.binder.bind([self.binder.string(n, tree) for n, tree in enumerate(trees)])

    def derive(self, player: int, rules: Sequence[int]) -> Tree:
        """Return the tree of a player with these rules in preorder."""
        return derive_by(self.derivations[player].grammar, rules)

    def shape(self, player: int, tree: Tree) -> TreeShape:
        """Return the shape of a tree."""
        return tree_shape(self.derivations[player].grammar, choices_of(tree))

    def entries(self, actions: Sequence[str], rng: np.random.Generator) -> IntArray:
        """Return a uniformly drawn clip for every action."""
        ranges = np.array([self.first[action] for action in actions], dtype=np.int64)
        ranges = ranges.reshape(-1, 2)
        return rng.integers(ranges[:, 0], ranges[:, 1])

    def arrays(self, state: SceneState, table: RuleTable) -> SceneArrays:
        """Return a scene's arrays, evaluated."""
        weights = self.binder.grammar.weights
        excess = self.prices.excess
        return scene_arrays(state, self.library, table.weighed, weights, self.every, excess)

    def energy(self, scene: SceneArrays, table: RuleTable) -> float:
        """Return -log P(Z) of a scene with g_user = 0, which is that of P(Y), with all prices."""
        prices, begin = self.prices, scene.begin
        end = max(int(begin[p, n]) for p, n in enumerate(scene.n_clips.tolist()))
        price = prices.delay * int(begin[:, 0].sum()) + prices.duration * end
        price += prices.action * int(scene.n_clips.sum()) + prices.stray * table.stray
        for p in self.moving:
            stands = int(begin[p, 0]) + end - int(begin[p, scene.n_clips[p]])
            price += prices.standing * stands
        return float(scene.total[0]) + price


@lru_cache(maxsize=2)
def _arrays(library: ClipLibrary) -> tuple[ClipArrays, ClipGroups]:
    """Return a library for compiled code; the last two are kept, as making it is slow."""
    arrays = clip_arrays(library)
    return arrays, clip_groups(arrays, 1.0, 1.0)


_derivations = lru_cache(maxsize=64)(Derivations)


def make_play(
    diagram: Diagram,
    grammar: MotionGrammar,
    library: ClipLibrary,
    most_actions: int = MOST_ACTIONS,
    prices: Prices = FREE,
) -> Play:
    """Return the target of sampling for a diagram."""
    binder = Binder(diagram, grammar)
    derivations = tuple(
        _derivations(
            grammar.started(grammar.start_of(player.team)),
            items,
            exact_actions(diagram, grammar, player.name),
        )
        for player, items in zip(diagram.players, binder.items, strict=True)
    )
    ends = [int(end) for end in library.first]
    first = dict(zip(library.terminals, pairwise(ends), strict=True))
    arrays, groups = _arrays(library)
    return Play(binder, derivations, arrays, groups, first, most_actions, prices)
