"""Chains over scenes: their frequencies beside exact distributions, and who is linked to whom.

Frequencies are compared by chi-square at fixed seeds, on samples thinned so far that their
autocorrelation is spent. The tolerance, p > 0.001, is what a right sampler misses at one seed in a
thousand. Tried on wrong ratios of jumps: without q, p is below 1e-100 at every seed; without s it
is .24, 1e-4 and 7e-4 at the three seeds, so that one of them alone would not notice; the worked
ratio of :mod:`.test_chain_steps` is what holds s.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest
from scene_energy import energy

from motiondb.grammar.cfg.context_free import derive_by
from motiondb.records import MOTION_FPS
from motiondb.scene.energy.binding import ROW, SYNCHRONISATION, bind
from motiondb.scene.energy.rule_kernels import lateness
from motiondb.scene.energy.scene_arrays import PlayerState, SceneState
from motiondb.scene.language.grammar_file import read_motion_grammar
from motiondb.scene.language.tactics_file import read_diagram
from motiondb.scene.sampling.clip_choice import clip_groups
from motiondb.scene.sampling.metropolis import (
    DELAY,
    MEET,
    SMOOTH,
    VARIANT,
    linked,
)
from motiondb.scene.sampling.play import Prices, make_play
from motiondb.scene.sampling.scene_chain import Chain

TOY = read_motion_grammar(
    """
    grammar toy
    start S
    place goal
    S -> A B
    A -> a [0.7] | b [0.3]
    B -> c [0.6] | d A [0.4]
    a := "a"
    b := "b"
    c := "c"
    d := "d"
    a, b, d: position(goal) at end weight 1.5 m
    c: direction(goal) at end weight 60 deg
    """,
    "toy.grammar",
)
ALONE = read_diagram(
    'diagram "toy"\ngrammar toy\ncourt 20 x 20\nplace goal at 0 2\nplayer P at 0 0\n', "toy.tactics"
)
EXCHANGES = np.array([1.0, 1.0, 1.0, 1.0, 1.0, 1.0])


def only(*kinds: int) -> np.ndarray:
    """Running sums of equal shares of some kinds of steps."""
    shares = np.zeros(6)
    shares[list(kinds)] = 1.0 / len(kinds)
    sums = np.cumsum(shares)
    sums[kinds[-1] :] = 1.0
    return sums


def toy_play(wandering, tails: float = 0.0):
    library = wandering(["a", "b", "c", "d"], each=2, seed=3)
    play = make_play(ALONE, TOY, library)
    return library, replace(play, tails=tails)


def toy_state(play, rules: tuple[int, ...], entries) -> SceneState:
    tree = derive_by(play.derivations[0].grammar, rules)
    return SceneState((PlayerState(tree, np.array(entries), (0.0, 0.0, 0.2), 0),))


def exact_states(library, play, grammar, derivations, temperature=1.0) -> dict[tuple, float]:
    """Every scene of some derivations with its probability, clips relative to uniform draws."""
    actual = {}
    for rules in derivations:
        tree = derive_by(play.derivations[0].grammar, rules)
        table = bind(ALONE, grammar, [tree])
        for entries in product(*(library.of(action) for action in tree.leaves())):
            state = toy_state(play, rules, entries)
            error = energy(state, play.library, table, grammar.weights, play.every).total
            actual[rules, entries] = math.exp(-error / temperature) * 0.5 ** len(entries)
    whole = sum(actual.values())
    return {key: value / whole for key, value in actual.items()}


def count_states(chain: Chain, rounds: int, every: int, *steps: Callable[[], object]) -> Counter:
    """How often each scene is met where some steps are taken in turn, every so many rounds."""
    seen: Counter = Counter()
    for step in range(rounds):
        for take in steps:
            take()
        if step % every == every - 1:
            entries = tuple(chain.scene.entry[0, : chain.scene.n_clips[0]].tolist())
            seen[chain.shapes[0].rules, entries] += 1
    return seen


def p_value(seen: Counter, exact: dict[tuple, float]) -> float:
    """Of a chi-square test; states expected fewer than five times count as one."""
    from scipy.stats import chisquare

    assert set(seen) <= set(exact)
    n = sum(seen.values())
    many = [key for key, p in exact.items() if n * p >= 5]
    counts = [seen[key] for key in many]
    wanted = [n * exact[key] for key in many]
    if len(many) < len(exact):
        counts.append(n - sum(counts))
        wanted.append(n - sum(wanted))
    return float(chisquare(counts, wanted).pvalue)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_frequencies_of_the_outer_loop_are_exact_without_the_inner(wandering, seed: int) -> None:
    library, play = toy_play(wandering)
    derivations = [(0, 1, 3), (0, 2, 3), *((0, x, 4, y) for x in (1, 2) for y in (1, 2))]
    exact = exact_states(library, play, TOY, derivations)
    assert len(exact) == 40
    assert max(exact.values()) < 0.5
    groups = clip_groups(play.library, TOY.weights.smooth, 1.0)
    chain = Chain(play, toy_state(play, (0, 1, 3), (0, 4)), np.random.default_rng(seed))
    seen = count_states(  # in three rounds a jump at the root is tried about once
        chain, 3000, 3,
        lambda: chain.move(chain.jump, 0, groups, 1.0, EXCHANGES, 0.0),
        lambda: chain.walk(2, groups, 1.0, EXCHANGES),
    )  # fmt: skip
    assert p_value(seen, exact) > 0.001


LINKS = read_motion_grammar(
    """
    grammar links
    start S
    place goal
    S -> A c
    A -> B A [0.3] | d A [0.2] | B [0.5]
    B -> a [0.7] | b [0.3]
    a := "a"
    b := "b"
    c := "c"
    d := "d"
    a, b, d: position(goal) at end weight 1.5 m
    c: direction(goal) at end weight 60 deg
    """,
    "links.grammar",
)


@pytest.mark.parametrize("seed", [1, 2])
def test_frequencies_of_growths_alone_are_exact(wandering, seed: int) -> None:
    library = wandering(["a", "b", "c", "d"], each=2, seed=3)
    play = replace(make_play(ALONE, LINKS, library, 4), tails=0.0)
    derivations = []
    for before in [(), (4,), (2,), *product((4, 2), repeat=2)]:
        for parts in product((4, 5), repeat=before.count(4)):
            links = iter(parts)
            rules = [0, *(r for x in before for r in ((1, next(links)) if x == 4 else (2,)))]
            derivations.append((*rules, 3, 4))  # the end of a chain stays
    exact = exact_states(library, play, LINKS, derivations)
    assert len(exact) == 4 + 3 * 8 + 9 * 16
    groups = clip_groups(play.library, LINKS.weights.smooth, 1.0)
    chain = Chain(play, toy_state(play, (0, 3, 4), (0, 4)), np.random.default_rng(seed))
    seen = count_states(  # links that are put in are taken away, and others come
        chain, 4000, 4,
        lambda: chain.move(chain.grow, 0, groups, 1.0, EXCHANGES, 0.0),
        lambda: chain.walk(4, groups, 1.0, EXCHANGES),
    )  # fmt: skip
    assert p_value(seen, exact) > 0.001


@pytest.mark.parametrize("seed", [1, 2])
def test_frequencies_of_recastings_alone_are_exact(wandering, seed: int) -> None:
    library, play = toy_play(wandering)
    exact = exact_states(library, play, TOY, [(0, 1, 4, 2)])
    groups = clip_groups(play.library, TOY.weights.smooth, 1.0)
    chain = Chain(play, toy_state(play, (0, 1, 4, 2), (0, 6, 2)), np.random.default_rng(seed))
    # in three rounds every clip is drawn anew about twice
    seen = count_states(
        chain, 3000, 3, lambda: chain.move(chain.recast, 0, groups, 1.0, EXCHANGES, 0.0)
    )
    assert len(seen) > 4
    assert p_value(seen, exact) > 0.001


@pytest.mark.parametrize(
    ("kinds", "temperature"), [((0,), 1.0), ((SMOOTH,), 1.0), ((SMOOTH, VARIANT), 2.0)]
)
def test_frequencies_of_clip_steps_are_exact(wandering, kinds, temperature: float) -> None:
    library = wandering(["a", "b", "c", "d"], each=4, seed=8)
    library.seam_class[:] = np.repeat(np.arange(8), 2)  # two variants of each clip
    play = replace(make_play(ALONE, TOY, library), tails=0.0)
    exact = exact_states(library, play, TOY, [(0, 1, 3)], temperature)
    groups = clip_groups(play.library, TOY.weights.smooth, temperature)
    chain = Chain(play, toy_state(play, (0, 1, 3), (0, 8)), np.random.default_rng(4))
    shares = only(*kinds)
    seen = count_states(chain, 1500, 1, lambda: chain.walk(25, groups, temperature, shares))
    assert p_value(seen, exact) > 0.001


PAIR = read_motion_grammar(
    """
    grammar pair
    start S for attack
    start S for defence
    S -> a
    a := "a" event contact
    a: synchronisation(opponent, a, 0.2 s) weight 0.4 s
    """,
    "pair.grammar",
)
TWO = read_diagram(
    'diagram "pair"\ngrammar pair\ncourt 20 x 20\nattack P at 0 0\ndefence Q at 3 0\n',
    "pair.tactics",
)


@pytest.mark.parametrize("kinds", [(DELAY,), (MEET,), (DELAY, MEET)])
def test_frequencies_of_delays_are_exact(wandering, kinds) -> None:
    library = wandering(["a"], each=2, seed=1)
    price = 0.1  # so that delays stay small and can be listed
    prices = Prices(delay=price, duration=0.05, action=0.5, stray=0.25)
    play = make_play(TWO, PAIR, library, prices=prices)
    trees = [derive_by(d.grammar, (0,)) for d in play.derivations]
    places = [(0.0, 0.0, 0.0), (3.0, 0.0, 0.0)]

    def state(delays):
        return SceneState(
            tuple(
                PlayerState(tree, np.array([k]), at, d)
                for k, (tree, at, d) in enumerate(zip(trees, places, delays, strict=True))
            )
        )

    start = Chain(play, state((0, 0)), np.random.default_rng(0))
    first, second = (play.library.clips["event"][k] for k in (0, 1))
    lengths = [play.library.clips["n_frames"][k] for k in (0, 1)]
    exact, others = {}, 2 * (0.5 + 0.25)  # two actions, which nothing in the diagram asks for
    for p, q in product(range(150), repeat=2):
        later = (q + second - p - first) / MOTION_FPS
        errors = abs(later - 0.2) / 0.4 + abs(-later - 0.2) / 0.4
        frames = max(p + lengths[0], q + lengths[1])
        exact[p, q] = math.exp(-errors - price * (p + q) - 0.05 * frames - others)
    whole = sum(exact.values())
    binned: dict[tuple, float] = {}
    for (p, q), value in exact.items():
        key = (p // 4, q // 4)
        binned[key] = binned.get(key, 0.0) + value / whole
    assert start.energy == pytest.approx(-math.log(exact[0, 0]), abs=1e-9)
    groups = clip_groups(play.library, PAIR.weights.smooth, 1.0)
    seen: Counter = Counter()
    for _ in range(1500):
        start.walk(60, groups, 1.0, only(*kinds))
        seen[tuple((start.scene.begin[:, 0] // 4).tolist())] += 1
    assert p_value(seen, binned) > 0.001


def test_meeting_is_meeting(wandering) -> None:
    library = wandering(["a"], each=2, seed=1)
    play = make_play(TWO, PAIR, library)
    chain = Chain(play, _standing(play, 40, 9), np.random.default_rng(0))
    meant = int(chain.scene.meant[0])
    frames = round(lateness(chain.scene, play.library, 0, meant))
    after = Chain(play, _standing(play, 40 + frames, 9), np.random.default_rng(0))
    assert frames != 0
    assert after.scene.cost[0] == pytest.approx(0.0, abs=1e-9)


def test_whom_synchronisations_link_are_one_group() -> None:
    """P and Q by a rule, R and S by another of R's, T by none."""
    row = np.zeros(2, dtype=ROW)
    row["kind"], row["player"], row["partner"] = SYNCHRONISATION, (1, 2), (0, 3)
    scene = SimpleNamespace(rows=row.view(np.recarray))
    assert [linked.py_func(scene, player) for player in range(5)] == [
        0b11,
        0b11,
        0b1100,
        0b1100,
        16,
    ]


def _standing(play, *delays: int) -> SceneState:
    trees = [derive_by(d.grammar, (0,)) for d in play.derivations]
    return SceneState(
        tuple(
            PlayerState(tree, np.array([0]), (float(k), 0.0, 0.0), delay)
            for k, (tree, delay) in enumerate(zip(trees, delays, strict=True))
        )
    )
