"""Sampling a scene by simulated annealing: several chains, of which the best scene is kept.

A chain has the target P(Z)^(1/T). T begins high, where structures are found, and falls to a value
far below 1, where they are refined: the aim is a scene of low error and not a fair sample, which at
T = 1 has an error of about half a unit for every degree of freedom of the scene. The chains begin
with scenes of their own and know nothing of one another. At the end the best scene of all is cooled
to almost 0.

Chains at several temperatures that exchange their scenes (parallel tempering) were no better in the
same processor time (docs/decisions/chains-without-exchanges.md).

Each chain has its own random numbers, spawned from one generator, and blocks have fixed numbers of
steps: the same seed gives the same bytes, whatever the threads do. This module has no clock.
``progress`` is called after every round, and may stop.

Source: S. Kirkpatrick, C. Gelatt and M. Vecchi, "Optimization by simulated annealing", Science 220
(1983); K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 5.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from motiondb.errors import SceneError
from motiondb.records import FloatArray, IntArray
from motiondb.scene.energy.energy import evaluate
from motiondb.scene.energy.scene_arrays import PlayerState, SceneState, scene_state
from motiondb.scene.energy.start_placement import place_player, place_start
from motiondb.scene.language.expressions import MOST_ACTIONS
from motiondb.scene.language.tactics import Diagram, paired
from motiondb.scene.sampling.clip_choice import ClipGroups, tempered
from motiondb.scene.sampling.play import Play, Prices
from motiondb.scene.sampling.random_subtrees import Derivation, Derivations
from motiondb.scene.sampling.scene_chain import Chain

# The first scene: derivations that satisfy the diagram, with random clips.


def bootstrap(play: Play, rng: np.random.Generator) -> SceneState:
    """Return a random scene with g_user = 0: random strings and clips, best origins and delays.

    Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
    Forum 35 (2016), section 5, "Bootstrapping".
    """
    players = []
    for player, (one, derivations) in enumerate(
        zip(play.binder.diagram.players, play.derivations, strict=True)
    ):
        rules = first_derivation(derivations, rng, play.most_actions).rules
        tree = play.derive(player, rules)
        entries = play.entries(tree.leaves(), rng)
        players.append(PlayerState(tree, entries, (one.at.x, one.at.z, 0.0), 0))
    trees = [player.tree for player in players]
    scene = play.arrays(SceneState(tuple(players)), play.bind(trees))
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


USUAL = Prices(1 / 150, 1 / 90, action=0.25, stray=1.0, excess=2.0, standing=1 / 10)
"""Usual prices. 90 frames of a scene, 150 frames of a delay, or 4 actions cost as much as a rule at
its weight, so that players avoid unneeded actions."""

Progress = Callable[[int, float], bool]
"""Called with the number of rounds done and the best -log P(Z); returns whether to stop."""


@dataclass(frozen=True)
class SamplerSettings:
    """Settings of the sampling.

    The defaults were chosen by hand on the eight shipped diagrams; docs/measured/scenes.md has what
    they give.
    """

    chains: int = 4  # Number of chains
    temperature: float = 0.15  # The lowest
    # Factor of the temperature at the beginning; from there it comes down evenly in logarithms
    heat: float = 15.0
    warmth: float = 0.85  # Fraction of the rounds over which it comes down
    rounds: int = 70  # Number of blocks of every chain
    jumps: int = 25  # Structural jumps in a block
    inner: int = 200  # M, steps of the inner loop after each jump, before it is accepted
    steps: int = 200  # Steps with the structure fixed after each jump, accepted or not
    growth: float = 0.5  # Fraction of the jumps that insert or remove one link of a chain
    recasting: float = 0.25  # Fraction of the jumps that draw the clips of some actions again
    attention: float = 0.7  # Fraction of a jump's inner steps for the player who jumped
    # Weights of the kinds of inner steps, see :mod:`.metropolis`; need not sum to 1
    shares: tuple[float, ...] = (0.1, 0.35, 0.25, 0.18, 0.06, 0.06)
    patience: int = 20  # Rounds without a scene that is better by 1 % after which to stop
    cooling: int = 40_000  # Steps of the final cooling
    most_actions: int = MOST_ACTIONS  # Largest number of actions of a player
    prices: Prices = USUAL  # Prices of delays, frames, actions and large failures
    threads: int = 2  # Chains that run at the same time; no influence on the result

    def temperature_after(self, done: int) -> float:
        """Return the temperature after so many rounds."""
        left = max(0.0, 1.0 - done / (self.warmth * self.rounds))
        return float(self.temperature * self.heat**left)

    @property
    def sums(self) -> FloatArray:
        """Cumulative shares; the last is exactly 1."""
        sums = np.cumsum(self.shares) / sum(self.shares)
        sums[-1] = 1.0
        return np.asarray(sums)


@dataclass(frozen=True, eq=False)
class Trace:
    """The course of the sampling."""

    best: (
        FloatArray  # (rounds + 1,): the lowest -log P(Z) so far with all prices, at first the start
    )
    cooled: float  # The lowest after cooling
    final: float  # The same of that scene without prices except that of delays


def sample(
    play: Play,
    settings: SamplerSettings,
    rng: np.random.Generator,
    state: SceneState | None = None,
    progress: Progress | None = None,
) -> tuple[SceneState, Trace]:
    """Find a scene of low error.

    `state`: Where to begin; by default every chain begins with a random scene of g_user = 0.
    """
    *chain_rngs, last = rng.spawn(settings.chains + 1)
    chains = [Chain(play, state or bootstrap(play, one), one) for one in chain_rngs]
    smooth = play.grammar.weights.smooth
    best = [min(chain.energy for chain in chains)]
    since = 0
    with ThreadPoolExecutor(settings.threads) as pool:
        for done in range(1, settings.rounds + 1):
            temperature = settings.temperature_after(done - 1)
            groups = tempered(play.groups, play.library, smooth, temperature)
            list(pool.map(partial(_block, settings, temperature, groups), chains))
            best.append(min(chain.best for chain in chains))
            since = 0 if best[-1] < 0.99 * best[-1 - since - 1] else since + 1
            if since >= settings.patience or (progress is not None and progress(done, best[-1])):
                break
    cooled = _cooled(play, min(chains, key=lambda chain: chain.best).best_state, settings, last)
    free = replace(play, prices=Prices(delay=play.prices.delay))
    final = Chain(free, cooled.best_state, cooled.rng).energy
    return cooled.best_state, Trace(np.array(best), cooled.best, final)


def warm_up(play: Play, settings: SamplerSettings, rng: np.random.Generator) -> None:
    """Do every kind of step once on a separate scene, so that all loops are compiled."""
    chain = Chain(play, bootstrap(play, rng), rng)
    groups = tempered(play.groups, play.library, play.grammar.weights.smooth, 1.0)
    for step in (chain.grow, chain.recast, chain.jump):
        chain.move(step, 10, groups, 1.0, settings.sums, settings.attention)
    chain.walk(10, groups, 1.0, settings.sums)


def _block(settings: SamplerSettings, temperature: float, groups: ClipGroups, chain: Chain) -> None:
    """Run a block of a chain."""
    sums = settings.sums
    kinds = [settings.growth, settings.growth + settings.recasting]
    for _ in range(settings.jumps):
        kind = min(bisect_right(kinds, float(chain.rng.random())), 2)
        propose = (chain.grow, chain.recast, chain.jump)[kind]
        chain.move(propose, settings.inner, groups, temperature, sums, settings.attention)
        chain.note_best()
        chain.walk(settings.steps, groups, temperature, sums)
        chain.note_best()
    chain.assign_all()
    chain.note_best()


def _cooled(
    play: Play, state: SceneState, settings: SamplerSettings, rng: np.random.Generator
) -> Chain:
    """Return a chain that has cooled a scene with its structure fixed."""
    chain = Chain(play, state, rng)
    n, smooth = max(2, settings.cooling // 5000), play.grammar.weights.smooth
    for t in np.geomspace(settings.temperature, 0.01, n):
        groups = tempered(play.groups, play.library, smooth, float(t))
        chain.walk(settings.cooling // n, groups, float(t), settings.sums)
        chain.assign_all()
        chain.note_best()
    return chain


# From the scene of one diagram to a first scene of a changed diagram.

WARM = SamplerSettings(
    chains=1,
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
takes less than half a second; docs/measured/scenes.md has the times."""


def warm_start(
    state: SceneState, before: Diagram, play: Play, rng: np.random.Generator
) -> SceneState:
    """Return a first scene with g_user = 0 for ``play``'s diagram from a scene of ``before``.

    Players are identified by their names.

    A player whose string still satisfies the changed diagram keeps it, with its clips, and begins
    at the same place, moved with the player's circle. Any other player is derived again under the
    condition that the string fits (:mod:`.random_subtrees`); actions that were there before, in the
    same order, keep their clips. Sampling then continues from there (:data:`WARM`).

    Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
    Forum 35 (2016), section 6 ("The optimization performance ... depends heavily on the choice of
    the initial configuration").
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
    scene = play.arrays(SceneState(tuple(players)), play.bind(trees))
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
    [(0, 1), (2, 2)]
    """
    worth = [[1.0 if action == theirs else -1.0 for theirs in other] for action in one]
    return [(k, m) for k, m in paired(worth, len(other)) if k >= 0 and m >= 0]
