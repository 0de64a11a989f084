"""The paper's procedure for scenes, as far as it is described, for comparison with ours.

One chain at T = 1. Algorithm 1: a subtree is chosen by its error (10), derived again by the rules'
probabilities, and drawn until P(X') > 0, that is until the string satisfies the diagram; then M
steps of the inner loop exchange clips, chosen by their errors and drawn uniformly; the outcome is
accepted by (9). After every step everything is evaluated from nothing. What print does not say is
as in ours: where and when a string begins is a variable, proposed by Gaussians (0.15 m, 8 degrees,
4 frames) in a fifth of the inner steps each, and begins in closed form; strings have at most 40
actions. The energy is the same compiled one.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 5.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from motiondb.database.scenes.scene_texts import SceneText
from motiondb.grammar.kernels import kernel
from motiondb.records import FloatArray
from motiondb.scene.clips.clips import ClipLibrary
from motiondb.scene.energy.energy import evaluate, token_errors
from motiondb.scene.energy.placement import ClipArrays, put_origin
from motiondb.scene.energy.scene_arrays import MOST_DELAY, SceneArrays
from motiondb.scene.sampling.annealing import bootstrap
from motiondb.scene.sampling.clip_choice import clip_groups, uniform_entry
from motiondb.scene.sampling.metropolis import FRAMES, PUSH, TURN, chosen_by, gaussian
from motiondb.scene.sampling.play import make_play
from motiondb.scene.sampling.random_subtrees import Derivation, Derivations
from motiondb.scene.sampling.scene_chain import Chain

INNER = 400
"""M. The paper does not print it; ours has the same number after a jump."""
DRAWS = 8
"""Random numbers a step, more than any step uses."""


class FreeDerivations(Derivations):
    """Subtrees by the rules' probabilities alone; None if the string does not fit."""

    def __init__(self, full: Derivations) -> None:
        super().__init__(full.grammar, full.items)
        self.free = Derivations(full.grammar, ())
        self.refused = 0

    def draw(
        self,
        symbol: str,
        since: int,
        ends: Sequence[int],
        rng: np.random.Generator,
        most: int = 10_000,
    ) -> Derivation | None:
        """A subtree that leads from ``since`` to one of ``ends`` by chance, or None."""
        drawn = self.free.draw(symbol, 0, [0], rng, most)
        if drawn is None or self.run(drawn.actions, since)[-1] not in ends:
            self.refused += 1
            return None
        return drawn


class PaperChain(Chain):
    """A chain whose inner loop evaluates from nothing."""

    def _walk(self, scene: SceneArrays, steps: int, *_: Any) -> None:
        errors = np.zeros(scene.entry.shape)
        draws = self.rng.random((steps, DRAWS))
        walk_from_nothing(scene, self.play.library, draws, errors, np.zeros_like(errors))


def run(
    text: SceneText, library: ClipLibrary, rng: np.random.Generator, seconds: float
) -> dict[str, Any]:
    """The best error by processor seconds, and how many jumps were drawn and taken."""
    play = make_play(text.diagram, text.grammar, library)
    began = time.process_time()
    start = bootstrap(play, rng)
    free = tuple(FreeDerivations(one) for one in play.derivations)
    chain = PaperChain(replace(play, derivations=free), start, rng)
    groups = clip_groups(play.library, text.grammar.weights.smooth, 1.0)
    none = np.zeros(6)
    curve, drawn, taken = [(time.process_time() - began, chain.best)], 0, 0
    while curve[-1][0] < seconds:
        for _ in range(20):
            taken += chain.move(chain.jump, INNER, groups, 1.0, none, 0.0)
            drawn += 1
            chain.note_best()
        curve.append((time.process_time() - began, chain.best))
    return {
        "curve": curve[:: max(len(curve) // 200, 1)] + curve[-1:],
        "error": chain.best,
        "seconds": curve[-1][0],
        "drawn": drawn,
        "did not fit": sum(one.refused for one in free),
        "taken": taken,
    }


@kernel
def walk_from_nothing(
    scene: SceneArrays,
    library: ClipArrays,
    draws: FloatArray,
    errors: FloatArray,
    after: FloatArray,
) -> None:
    """The inner loop at T = 1; every step evaluates the whole scene."""
    energy = evaluate(scene, library)
    total = token_errors(scene, library, errors)
    for u in draws:
        player, k = chosen_by(errors, scene.n_clips, u[1] * total)
        old, delay = scene.entry[player, k], scene.begin[player, 0]
        x, z, theta = scene.placed[player, 0, :3]
        if u[0] < 0.6:
            scene.entry[player, k] = uniform_entry(library, old, u[2])
        elif u[0] < 0.8:
            right, ahead = gaussian(u[2], u[3])
            turn = TURN * gaussian(u[4], u[5])[0]
            put_origin(scene.placed[player], x + PUSH * right, z + PUSH * ahead, theta + turn)
        else:
            moved = delay + round(FRAMES * gaussian(u[2], u[3])[0])
            if moved < 0 or moved > MOST_DELAY:
                continue
            scene.begin[player, 0] = moved
        now = evaluate(scene, library)
        gain = energy - now
        new_total = token_errors(scene, library, after)
        if u[0] < 0.6:
            gain += math.log(after[player, k] / new_total) - math.log(errors[player, k] / total)
        if gain >= 0.0 or u[6] < math.exp(gain):
            energy, total = now, new_total
            for p in range(len(scene.n_clips)):
                for m in range(scene.n_clips[p]):
                    errors[p, m] = after[p, m]
            continue
        scene.entry[player, k] = old
        scene.begin[player, 0] = delay
        put_origin(scene.placed[player], x, z, theta)
    evaluate(scene, library)
