"""From the scene of one diagram to a first scene of a changed diagram.

A player whose string still satisfies the changed diagram keeps it, with its clips, and begins
at the same place, moved with the player's circle. Any other player is derived again under the
condition that the string fits (:mod:`.random_subtrees`); actions that were there before, in the
same order, keep their clips. Sampling then continues from there (:data:`WARM`).

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 6 ("The optimization performance ... depends heavily on the choice of the
initial configuration").
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motiondb.records import IntArray
from motiondb.scene.energy.energy import evaluate
from motiondb.scene.energy.scene_arrays import scene_state
from motiondb.scene.energy.scene_state import PlayerState, SceneState
from motiondb.scene.energy.start_placement import place_player
from motiondb.scene.language.tactics import Diagram
from motiondb.scene.sampling.bootstrap import first_derivation
from motiondb.scene.sampling.play import Play
from motiondb.scene.sampling.tempering import SamplerSettings

WARM = SamplerSettings(
    temperatures=(0.15,),
    heat=1.0,
    rounds=4,
    jumps=4,
    inner=300,
    steps=700,
    patience=2,
    cooling=10_000,
    threads=1,
)
"""Settings for continuing from a scene that is almost right. Chosen by hand so that a small change
takes less than half a second; docs/scenes-measured.md has the times."""


def warm_start(
    state: SceneState, before: Diagram, play: Play, rng: np.random.Generator
) -> SceneState:
    """Return a first scene with g_user = 0 for ``play``'s diagram from a scene of ``before``.

    Players are identified by their names.
    """
    old = {
        player.name: (player, player_before)
        for player, player_before in zip(before.players, state.players)
    }
    players: list[PlayerState] = []
    placed_anew = []
    for number, player in enumerate(play.binder.diagram.players):
        derivations = play.derivations[number]
        was, player_before = old.get(player.name, (player, None))
        x, z, theta = player_before.origin if player_before else (player.at.x, player.at.z, 0.0)
        origin = (x + (player.at.x - was.at.x), z + (player.at.z - was.at.z), theta)
        delay = player_before.delay if player_before else 0
        actions = player_before.tree.leaves() if player_before else ()
        if player_before and actions and derivations.fits(actions) and was.team == player.team:
            players.append(PlayerState(player_before.tree, player_before.entries, origin, delay))
            continue
        tree = play.derive(number, first_derivation(derivations, rng, play.most_actions).rules)
        entries = play.entries(tree.leaves(), rng)
        if player_before:
            _keep_clips(entries, tree.leaves(), player_before.entries, actions)
        players.append(PlayerState(tree, entries, origin, delay))
        placed_anew.append(number)
    trees = [player.tree for player in players]
    scene = play.arrays(SceneState(tuple(players)), play.binder.bind(trees))
    for number in placed_anew:
        place_player(scene, play.library, number, True)
    evaluate(scene, play.library)
    return scene_state(scene, trees)


def _keep_clips(
    entries: IntArray, actions: Sequence[str], old_entries: IntArray, old_actions: Sequence[str]
) -> None:
    """Give actions that the old string had, in its order, their old clips."""
    for k, m in common_actions(actions, old_actions):
        entries[k] = old_entries[m]


def common_actions(one: Sequence[str], other: Sequence[str]) -> list[tuple[int, int]]:
    """Return the indices of a longest common subsequence in both strings.

    >>> common_actions(["run", "catch", "shoot"], ["catch", "run", "shoot"])
    [(1, 0), (2, 2)]
    """
    lengths = np.zeros((len(one) + 1, len(other) + 1), dtype=np.int64)
    for i in range(len(one) - 1, -1, -1):
        for j in range(len(other) - 1, -1, -1):
            same = one[i] == other[j]
            both = lengths[i + 1, j + 1] + 1 if same else 0
            lengths[i, j] = max(both, lengths[i + 1, j], lengths[i, j + 1])
    pairs = []
    i = j = 0
    while i < len(one) and j < len(other):
        if one[i] == other[j] and lengths[i, j] == lengths[i + 1, j + 1] + 1:
            pairs.append((i, j))
            i, j = i + 1, j + 1
        elif lengths[i + 1, j] >= lengths[i, j + 1]:
            i += 1
        else:
            j += 1
    return pairs
