"""The first scene: derivations that do what the diagram asks, with any clips.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 5, "Bootstrapping".
"""

from __future__ import annotations

import math

import numpy as np

from motiondb.errors import SceneError
from motiondb.records import IntArray
from motiondb.scene.derivations import Derivation, Derivations
from motiondb.scene.expressions import g_user
from motiondb.scene.scene_arrays import scene_state
from motiondb.scene.scene_chain import Play
from motiondb.scene.scene_state import PlayerState, SceneState
from motiondb.scene.start_placement import place_start
from motiondb.scene.tree_shapes import exchanged, tree_shape


def bootstrap(play: Play, rng: np.random.Generator) -> SceneState:
    """A random scene of g_user = 0: derivations and clips by chance, origins and delays by rule."""
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


_TRIES = 1000


def first_derivation(derivations: Derivations, rng: np.random.Generator, most: int) -> Derivation:
    """A random derivation that fits the expression, of 1 to ``most`` actions.

    Raises
    ------
    SceneError where none of many is short enough.
    """
    start, last = derivations.grammar.start, derivations.n_states - 1
    for _ in range(_TRIES):
        found = derivations.draw(start, 0, [last], rng, most)
        if found is not None and found.actions:
            return found
    raise SceneError(
        f"grammar: expected strings from {start} of 1 to {most} actions, found none in {_TRIES}"
        " draws. Allow more actions, or ask for fewer things."
    )


def wandering_bootstrap(
    derivations: Derivations, rng: np.random.Generator, steps: int, weight: float
) -> tuple[Derivation, IntArray]:
    """The paper's bootstrapping: Metropolis-Hastings by P(X) until the string fits.

    A node is drawn uniformly and derived anew by the rules' probabilities, whatever is asked. P(X)
    is taken relative to these probabilities, or long strings would win by their number. What
    :func:`bootstrap` is compared with; a scene begins with that.

    Parameters
    ----------
    steps : at most so many. weight : w_1, -log P(X) = g_user / w_1.

    Returns
    -------
    the last derivation, and array (at most steps + 1,), g_user before each step and at the end.
    """
    grammar = derivations.grammar
    expression = [item.actions for item in derivations.items]
    free = Derivations(grammar, ())
    shape = tree_shape(grammar, _free(free, grammar.start, rng).rules)
    missing = [g_user(shape.actions, expression)]
    while len(missing) <= steps and (missing[-1] > 0 or not shape.actions):
        node = int(rng.integers(len(shape.rules)))
        new = _free(free, shape.symbols[node], rng)
        after = exchanged(grammar, shape, node, new.rules)
        lacks = g_user(after.actions, expression)
        gain = (missing[-1] - lacks) / weight + math.log(len(shape.rules) / len(after.rules))
        if gain >= 0.0 or rng.random() < math.exp(gain):
            shape = after
            missing.append(lacks)
        else:
            missing.append(missing[-1])
    return Derivation(shape.rules, shape.actions), np.array(missing)


def _free(free: Derivations, symbol: str, rng: np.random.Generator) -> Derivation:
    found = free.draw(symbol, 0, [0], rng)
    while found is None:
        found = free.draw(symbol, 0, [0], rng)
    return found
