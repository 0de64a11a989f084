"""Sampling a scene: several chains at different temperatures that exchange their scenes.

Chain n has the target P(Z)^(1/T_n). Between blocks of a fixed number of steps, chains of
neighbouring temperatures exchange their scenes with probability

    min(1, exp((E_n - E_(n+1)) (1/T_n - 1/T_(n+1)))),      E = -log P(Z)                     (11)

Hot chains find structures, cold ones settle them. The lowest temperature is far below 1: what is
wanted is a scene of low error, not a fair draw, which at T = 1 has an error of about half a unit
for every freedom that the scene has. All chains begin hotter and come down; meanwhile exchanges
keep to the temperatures at which they end, so that low errors go to cold chains sooner than balance
would have it. At the end the best scene is cooled down to nothing.

Each chain has random numbers of its own, spawned from one generator, and blocks have fixed numbers
of steps: the same seed gives the same bytes, whatever the threads do. Nothing here has a clock:
``progress`` is told after every round, and may stop.

Source: C. J. Geyer, "Markov chain Monte Carlo maximum likelihood", Proceedings of the 23rd
Symposium on the Interface (1991); K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character
Animation", Computer Graphics Forum 35 (2016), section 5.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from motiondb.errors import SceneError
from motiondb.records import FloatArray, IntArray
from motiondb.scene.clips.clips import ClipLibrary
from motiondb.scene.energy.scene_state import SceneState
from motiondb.scene.language.expressions import MOST_ACTIONS
from motiondb.scene.language.motion_grammar import MotionGrammar
from motiondb.scene.language.tactics import Diagram
from motiondb.scene.sampling.bootstrap import bootstrap
from motiondb.scene.sampling.clip_choice import ClipGroups, tempered
from motiondb.scene.sampling.metropolis import KINDS
from motiondb.scene.sampling.play import Play, Prices, make_play
from motiondb.scene.sampling.scene_chain import Chain

USUAL = Prices(delay=1 / 150, duration=1 / 90, action=0.25, stray=1.0, excess=2.0)
"""Nothing is done without need, and nothing takes long: 90 frames cost as much as a rule at its
weight."""

Progress = Callable[[int, float], bool]
"""Told how many rounds are done and the best -log P(Z); whether to stop."""


@dataclass(frozen=True)
class SamplerSettings:
    """How to sample.

    Attributes
    ----------
    temperatures : ascending, one chain each; one alone is a single chain.
    heat : all temperatures begin so many times as high and come down evenly (in logarithms) over
        the first part of the rounds, ``warmth`` of them; 1 for plain tempering.
    rounds : blocks between exchanges.
    jumps : structural jumps in a block; ``inner`` : M, steps of the inner loop after each;
        ``steps`` : steps with the structure fixed after each jump, taken or not.
    growth, recasting : shares of the jumps that only put one link into a chain, or take one away,
        and that only draw the clips of a stretch anew.
    attention : share of a jump's inner steps that look at the player who jumped.
    shares : of the kinds of inner steps, see :data:`.metropolis.KINDS`; need not sum to 1.
    patience : rounds without a better scene (by 1 %) after which to stop.
    cooling : steps of the final cooling. most_actions : of a player.
    prices : of delays, frames, actions and failing far.
    threads : chains that run at the same time; of no influence on the result.
    """

    temperatures: tuple[float, ...] = (0.15, 0.2, 0.27, 0.36)
    heat: float = 15.0
    warmth: float = 0.85
    rounds: int = 70
    jumps: int = 25
    inner: int = 200
    steps: int = 200
    growth: float = 0.5
    recasting: float = 0.25
    attention: float = 0.7
    shares: tuple[float, ...] = (0.1, 0.35, 0.25, 0.18, 0.06, 0.06)
    patience: int = 20
    cooling: int = 40_000
    most_actions: int = MOST_ACTIONS
    prices: Prices = USUAL
    threads: int = 2

    def __post_init__(self) -> None:
        rising = all(a < b for a, b in zip(self.temperatures, self.temperatures[1:], strict=False))
        if not self.temperatures or self.temperatures[0] <= 0.0 or not rising:
            raise SceneError(
                "temperatures: expected ascending numbers above 0, found"
                f" {', '.join(map(str, self.temperatures)) or 'none'}. Try 0.15, 0.2, 0.3."
            )
        if len(self.shares) != len(KINDS) or min(self.shares) < 0.0 or sum(self.shares) <= 0.0:
            raise SceneError(
                f"shares: expected {len(KINDS)} numbers of 0 or more ({', '.join(KINDS)}), found"
                f" {self.shares}. Leave them out for the usual ones."
            )
        links, clips = self.growth, self.recasting
        if not (min(links, clips) >= 0.0 and links + clips <= 1.0):
            raise SceneError(
                "growth, recasting: expected shares of the jumps, 0 or more that sum to at most 1,"
                f" found {links:g} and {clips:g}. Leave them out for the usual ones."
            )
        if not (self.rounds >= 1 and 0.0 < self.warmth <= 1.0):
            raise SceneError(
                "rounds, warmth: expected at least 1 round, and a share above 0 of them to be warm,"
                f" found {self.rounds} and {self.warmth:g}. Leave them out for the usual ones."
            )

    def ladder(self, done: int) -> tuple[float, ...]:
        """The temperatures when so many rounds are done."""
        left = max(0.0, 1.0 - done / (self.warmth * self.rounds))
        return tuple(float(t * self.heat**left) for t in self.temperatures)

    @property
    def sums(self) -> FloatArray:
        """Running sums of the shares, the last exactly 1."""
        sums = np.cumsum(self.shares) / sum(self.shares)
        sums[-1] = 1.0
        return np.asarray(sums)


@dataclass(frozen=True, eq=False)
class Trace:
    """How the sampling went.

    Attributes
    ----------
    energies : array (rounds + 1, chains), -log P(Z) with all prices, by temperature; row 0 is the
        start.
    best : array (rounds + 1,), the best of them so far. cooled : the same after cooling. final : of
        that scene, of all prices only that of delays.
    jumps : array (chains, 3), by chain: tried, refused as too long or too early, taken.
    steps : array (kinds, 2), inner steps of all chains, tried and taken.
    exchanges : array (chains - 1, 2), tried and taken, by temperature.
    """

    energies: FloatArray
    best: FloatArray
    cooled: float
    final: float
    jumps: IntArray
    steps: IntArray
    exchanges: IntArray


@dataclass
class _Ladder:
    """Which chain has which temperature; ``order[n]`` is the chain of temperature n."""

    chains: list[Chain]
    order: list[int]
    exchanges: IntArray
    temperatures: tuple[float, ...] = ()
    groups: list[ClipGroups] = field(default_factory=list)

    def heat(self, play: Play, temperatures: tuple[float, ...]) -> None:
        """Set the temperatures."""
        if temperatures != self.temperatures:
            smooth = play.grammar.weights.smooth
            self.groups = [tempered(play.groups, play.library, smooth, t) for t in temperatures]
            self.temperatures = temperatures


def sample(
    state: SceneState | None,
    library: ClipLibrary,
    diagram: Diagram,
    grammar: MotionGrammar,
    settings: SamplerSettings,
    rng: np.random.Generator,
    progress: Progress | None = None,
) -> tuple[SceneState, Trace]:
    """Find a scene of low error.

    Parameters
    ----------
    state : where to begin; None: every chain from a random scene with g_user = 0.
    progress : is told after each round, and may stop.

    Returns
    -------
    the best scene, and how it was found.

    Raises
    ------
    SceneError where the grammar has no string that fits what the diagram asks of a player.
    """
    play = make_play(diagram, grammar, library, settings.most_actions, settings.prices)
    *own, exchanging, last = rng.spawn(len(settings.temperatures) + 2)
    chains = [Chain(play, state or bootstrap(play, one), one) for one in own]
    exchanges = np.zeros((len(chains) - 1, 2), np.int64)
    ladder = _Ladder(chains, list(range(len(chains))), exchanges)
    energies = [[chain.energy for chain in chains]]
    best = [min(energies[0])]
    since = 0
    with ThreadPoolExecutor(settings.threads) as pool:
        for done in range(1, settings.rounds + 1):
            ladder.heat(play, settings.ladder(done - 1))
            list(pool.map(partial(_block, ladder, settings), range(len(chains))))
            energies.append([chains[c].energy for c in ladder.order])
            best.append(min(chain.best for chain in chains))
            exchange(
                ladder.order, energies[-1], settings.temperatures, exchanging, ladder.exchanges
            )
            since = 0 if best[-1] < 0.99 * best[-1 - since - 1] else since + 1
            if since >= settings.patience or (progress is not None and progress(done, best[-1])):
                break
    found = _cooled(play, min(chains, key=lambda chain: chain.best).best_state, settings, last)
    return found.best_state, _trace(ladder, energies, best, found)


def _block(ladder: _Ladder, settings: SamplerSettings, n: int) -> None:
    """A block of the chain at temperature n."""
    chain, groups = ladder.chains[ladder.order[n]], ladder.groups[n]
    temperature, sums = ladder.temperatures[n], settings.sums
    kinds = [settings.growth, settings.growth + settings.recasting]
    for _ in range(settings.jumps):
        kind = min(bisect_right(kinds, float(chain.rng.random())), 2)
        (chain.grow, chain.recast, chain.jump)[kind](
            settings.inner, groups, temperature, sums, settings.attention
        )
        chain.note_best()
        chain.walk(settings.steps, groups, temperature, sums)
        chain.note_best()


def exchange(
    order: list[int],
    energies: Sequence[float],
    temperatures: Sequence[float],
    rng: np.random.Generator,
    counts: IntArray,
) -> None:
    """Let neighbours exchange their scenes by (11), from the hottest pair down.

    Parameters
    ----------
    order : which chain has which temperature; changed in place.
    energies : -log P(Z) by temperature, before.
    counts : array (chains - 1, 2), tried and taken are added.
    """
    by_temperature = list(energies)
    for n in range(len(order) - 2, -1, -1):
        cold, hot = by_temperature[n], by_temperature[n + 1]
        gain = (cold - hot) * (1.0 / temperatures[n] - 1.0 / temperatures[n + 1])
        counts[n, 0] += 1
        if gain >= 0.0 or rng.random() < math.exp(gain):
            counts[n, 1] += 1
            order[n], order[n + 1] = order[n + 1], order[n]
            by_temperature[n], by_temperature[n + 1] = hot, cold


def _cooled(
    play: Play, state: SceneState, settings: SamplerSettings, rng: np.random.Generator
) -> Chain:
    """A scene cooled down with its structure fixed."""
    chain = Chain(play, state, rng)
    n, smooth = max(2, settings.cooling // 5000), play.grammar.weights.smooth
    for t in np.geomspace(settings.temperatures[0], 0.01, n):
        groups = tempered(play.groups, play.library, smooth, float(t))
        chain.walk(settings.cooling // n, groups, float(t), settings.sums)
        chain.note_best()
    return chain


def _trace(ladder: _Ladder, energies: list[list[float]], best: list[float], found: Chain) -> Trace:
    jumps = [(c.jumps.tried, c.jumps.refused, c.jumps.taken) for c in ladder.chains]
    steps = np.sum([chain.jumps.steps for chain in ladder.chains], axis=0)
    delays = Prices(delay=found.play.prices.delay)
    return Trace(
        np.array(energies),
        np.array(best),
        found.best,
        Chain(replace(found.play, prices=delays), found.best_state, found.rng).energy,
        np.array(jumps, dtype=np.int64),
        steps,
        ladder.exchanges,
    )
