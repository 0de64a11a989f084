"""The first scene: derivations that satisfy the diagram, with random clips.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 5, "Bootstrapping".
"""

from __future__ import annotations

import numpy as np

from motiondb.errors import SceneError
from motiondb.scene.energy.scene_arrays import scene_state
from motiondb.scene.energy.scene_state import PlayerState, SceneState
from motiondb.scene.energy.start_placement import place_start
from motiondb.scene.sampling.play import Play
from motiondb.scene.sampling.random_subtrees import Derivation, Derivations


def bootstrap(play: Play, rng: np.random.Generator) -> SceneState:
    """Return a random scene with g_user = 0: random strings and clips, best origins and delays."""
    players = []
    for player, (one, derivations) in enumerate(
        zip(play.binder.diagram.players, play.derivations, strict=True)
    ):
        rules = first_derivation(derivations, rng, play.most_actions).rules
        tree = play.derive(player, rules)
        entries = play.entries(tree.leaves(), rng)
        players.append(PlayerState(tree, entries, (one.at.x, one.at.z, 0.0), 0))
    trees = [player.tree for player in players]
    scene = play.arrays(SceneState(tuple(players)), play.binder.bind(trees))
    place_start(scene, play.library)
    return scene_state(scene, trees)


_TRIES = 1000  # Draws before giving up. A grammar that needs more has almost no short strings


def first_derivation(derivations: Derivations, rng: np.random.Generator, most: int) -> Derivation:
    """Return a random derivation that fits the expression, of 1 to ``most`` actions."""
    start, last = derivations.grammar.start, derivations.n_states - 1
    for _ in range(_TRIES):
        derivation = derivations.draw(start, 0, [last], rng, most)
        if derivation is not None and derivation.actions:
            return derivation
    raise SceneError(
        f"grammar: expected strings from {start} of 1 to {most} actions, found none in {_TRIES}"
        " draws. Allow more actions, or ask for fewer things."
    )
