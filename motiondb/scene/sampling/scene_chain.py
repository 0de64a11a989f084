"""A Markov chain over whole scenes: derivations, clips, places and times (the outer loop).

The target is P(Z)^(1/T) = P(X)^(1/T) P(Y)^(1/T) over scenes with g_user = 0 and a limited number of
actions a player, relative to drawing every action's clip uniformly (so that an action with many
clips weighs no more than one with few). Without that limit P(X), as printed, is no distribution:
every longer string that fits has the same weight. Prices may be added (:mod:`.play`).

A jump chooses a nonterminal node v of one of the trees by its error, s(v) = E(v) / sum E. It
derives the node again so that the following actions remain possible (:mod:`.random_subtrees`),
draws the clips of the new actions by their seams, keeps the place and time of either the part
before or, with equal probability, the part after, and does M steps of the inner loop. It is
accepted with probability

    min(1, exp((E_old - E_new) / T) * [s'(v) q(old subtree)] / [s(v) q(new subtree)])

where q are products of rule probabilities and, for M = 0, of the clips relative to uniform draws. A
growth inserts one link into a chain A -> B A of a tree, or removes one, and keeps all other actions
and clips (:mod:`.tree_growth`); its acceptance is the same with s one over the number of nodes
where it could have been. A recasting keeps all actions and draws the clips of some of them again.
The reverse move is the one at the same v, so detailed balance holds for each v by itself, exactly
for M = 0. With M > 0 the clips at the end are not those that were drawn, and the ratio is that of
the paper, of the trees alone: the chain is then a good optimiser but not an exact sampler. Neither
is the paper's.

A string may fit its player's expression in several ways: which of its walks is which of the
diagram's. Of these the one with the least error is taken (:meth:`Chain.assign`).

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 5, algorithm 1.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from motiondb.grammar.cfg.context_free import Tree
from motiondb.records import FloatArray, IntArray
from motiondb.scene.clips.clip_cutting import compose, inverse
from motiondb.scene.energy.binding import BoundString, RuleTable
from motiondb.scene.energy.energy import token_errors
from motiondb.scene.energy.scene_arrays import PlayerState, SceneArrays, SceneState, scene_state
from motiondb.scene.sampling.clip_choice import ClipGroups, smooth_string
from motiondb.scene.sampling.metropolis import DRAWS, EVERYBODY, Focus, Walk, walk
from motiondb.scene.sampling.play import Play
from motiondb.scene.sampling.tree_growth import (
    TreeShape,
    exchanged,
    places,
    subtree_errors,
    tree_shape,
)

# A scene with everything that its derivations determine, and its best assignment of actions.


class Structure(NamedTuple):
    """A scene with everything that its derivations determine.

    The actions of a string can fit the items of the player's expression in several ways; see
    :func:`motiondb.scene.language.expressions.assignments`.
    """

    scene: SceneArrays
    table: RuleTable
    strings: list[BoundString]  # Of each player the tree, and the actions of their items


def least_error(
    play: Play, state: SceneState, known: Structure, player: int, tree: Tree
) -> Structure:
    """Return a scene with that assignment of a tree's actions to items that has the least error.

    All assignments of :meth:`motiondb.scene.energy.binding.Binder.assignments` are evaluated, with
    the clips as they are. What is ``known`` need not be bound again.
    """
    best: Structure | None = None
    least = math.inf
    old = known.strings[player]
    for chosen in play.binder.assignments(player, tree.leaves()):
        bound, table = known.strings, known.table
        if tree is not old.tree or chosen != old.spans:
            string = play.binder.string(player, tree, chosen)
            bound = [*bound[:player], string, *bound[player + 1 :]]
            table = play.binder.bind(bound)
        scene = play.arrays(state, table)
        energy = play.energy(scene, table)
        if best is None or energy < least:
            best, least = Structure(scene, table, bound), energy
    assert best is not None  # a tree of a chain fits its player's expression
    return best


AROUND = 3
"""Clips before and after an inserted or removed link that the following inner steps favour."""
TRIAL, HOPELESS = 60, 30.0
"""Inner steps after which a jump is given up if it is worse by more than so many temperatures. Of
3000 jumps of two diagrams, 2 % of those that are accepted after 200 steps are given up, and about
half of the others."""
LONGEST = 5  # Largest number of actions whose clips are drawn again together


class Offer(NamedTuple):
    """Another structure that is proposed."""

    player: int  # Whose tree or clips change
    shape: TreeShape  # Of the tree
    structure: Structure
    near: tuple[int, int]  # Clips [since, until) of the player that the inner steps favour
    log_ratio: float  # log q(old) / q(new), but for the choice of the reverse move
    # From the scene after the inner steps, and all shapes: log of that choice's probability
    log_back: Callable[[SceneArrays, Sequence[TreeShape]], float] = lambda _scene, _shapes: 0.0


Propose = Callable[[ClipGroups, bool], Offer | None]
"""From the groups of clips, and whether the ratio is to be exact."""


class Chain:
    """A Markov chain: its state, its random numbers, and the best scene so far."""

    def __init__(self, play: Play, state: SceneState, rng: np.random.Generator) -> None:
        self.play, self.rng = play, rng
        self.shapes = [play.shape(number, tree) for number, tree in enumerate(state.trees)]
        new = [player.spans is None for player in state.players]
        self.strings = [
            play.binder.string(
                number,
                player.tree,
                player.spans or next(iter(play.binder.assignments(number, shape.actions)), None),
            )
            for number, (player, shape) in enumerate(zip(state.players, self.shapes, strict=True))
        ]
        self.table = play.binder.bind(self.strings)
        self.scene = play.arrays(state, self.table)
        for player in np.flatnonzero(new).tolist():
            self.assign(player)
        self.best = math.inf
        self.best_state = state
        self.note_best()

    @property
    def energy(self) -> float:
        """-log P(Z) with g_user = 0, which is that of P(Y), with all prices."""
        return self.play.energy(self.scene, self.table)

    @property
    def state(self) -> SceneState:
        """The current scene."""
        trees = [string.tree for string in self.strings]
        return scene_state(self.scene, trees, [string.spans for string in self.strings])

    def assign(self, player: int) -> bool:
        """Assign a player's actions to their items with the least error; return if it changed.

        It only lowers the error, so a chain with such steps is not an exact sampler. Most strings
        can be assigned in one way only.
        """
        before = self.energy
        if len(self.play.binder.assignments(player, self.shapes[player].actions)) < 2:
            return False
        tree = self.strings[player].tree
        known = Structure(self.scene, self.table, self.strings)
        best = least_error(self.play, self.state, known, player, tree)
        if self.play.energy(best.scene, best.table) >= before - 1e-9:
            return False
        self.scene, self.table, self.strings = best
        return True

    def assign_all(self) -> None:
        """Assign the actions of every player, one after another, with the least error."""
        for player in range(len(self.strings)):
            self.assign(player)

    def note_best(self) -> None:
        """Keep the current scene if it is the best so far."""
        if self.energy < self.best:
            self.best, self.best_state = self.energy, self.state

    def walk(
        self,
        steps: int,
        groups: ClipGroups,
        temperature: float,
        shares: FloatArray,
        focus: Focus = EVERYBODY,
    ) -> None:
        """Do inner steps with the structure fixed; ``focus`` favours some clips of a player."""
        self._walk(self.scene, steps, groups, temperature, shares, focus)

    def _walk(
        self,
        scene: SceneArrays,
        steps: int,
        groups: ClipGroups,
        temperature: float,
        shares: FloatArray,
        focus: Focus,
    ) -> None:
        if steps == 0:
            return
        errors, play = np.zeros(scene.entry.shape), self.play
        prices = play.prices.delay, play.prices.duration
        how = Walk(temperature, shares, *focus, *prices, play.tails, errors, errors.copy())
        draws = self.rng.random((steps, DRAWS))
        walk(scene, play.library, groups, draws, how)

    def move(
        self,
        propose: Propose,
        steps: int,
        groups: ClipGroups,
        temperature: float,
        shares: FloatArray,
        attention: float,
    ) -> bool:
        """Propose another structure, do ``steps`` inner steps, and accept it or stay.

        ``propose`` is :meth:`jump`, :meth:`grow` or :meth:`recast`; returns whether it was
        accepted.
        """
        offer = propose(groups, steps == 0)
        if offer is None:
            return False
        player, new = offer.player, offer.structure
        focus = (player, *offer.near, attention)
        trial = min(steps, TRIAL)
        self._walk(new.scene, trial, groups, temperature, shares, focus)
        if steps > trial:
            gap = self.play.energy(new.scene, new.table) - self.energy
            if gap > HOPELESS * temperature:
                return False
            self._walk(new.scene, steps - trial, groups, temperature, shares, focus)
        shapes = [*self.shapes[:player], offer.shape, *self.shapes[player + 1 :]]
        log_ratio = offer.log_ratio + offer.log_back(new.scene, shapes)
        gain = (self.energy - self.play.energy(new.scene, new.table)) / temperature + log_ratio
        if gain < 0.0 and self.rng.random() >= math.exp(gain):
            return False
        self.shapes = shapes
        self.scene, self.table, self.strings = new
        return True

    def jump(self, groups: ClipGroups, exact: bool) -> Offer | None:
        """Derive a node of a tree again, chosen by its error."""
        play = self.play
        errors = self._subtree_errors(self.scene, self.shapes)
        sums = np.cumsum(np.concatenate(errors))
        drawn = float(self.rng.random()) * sums[-1]
        node = min(int(np.searchsorted(sums, drawn, "right")), len(sums) - 1)
        player = 0
        while node >= len(errors[player]):
            node -= len(errors[player])
            player += 1
        shape, derivations = self.shapes[player], play.derivations[player]
        end, first, last = shape.spans[node].tolist()
        since = derivations.run(shape.actions[:first])[-1]
        ends = derivations.ends_before(shape.actions[last:])
        kept = len(shape.actions) - (last - first)
        room = play.most_actions - kept
        new = derivations.draw(shape.symbols[node], since, ends, self.rng, room)
        if new is None or kept + len(new.actions) == 0:
            return None
        after = exchanged(derivations.grammar, shape, node, new.rules)
        ratio = derivations.log_probability(shape.rules[node:end])
        ratio -= derivations.log_probability(new.rules)
        ratio -= math.log(errors[player][node] / sums[-1])

        def log_back(scene: SceneArrays, shapes: Sequence[TreeShape]) -> float:
            back = self._subtree_errors(scene, shapes)
            return math.log(back[player][node] / sum(e.sum() for e in back))

        offer = self._offer(player, after, (first, last), new.actions, groups, exact)
        return offer and offer._replace(
            near=(0, play.most_actions), log_ratio=offer.log_ratio + ratio, log_back=log_back
        )

    def grow(self, groups: ClipGroups, exact: bool) -> Offer | None:
        """Insert or remove a link of a chain in one of the trees."""
        growing = bool(self.rng.random() < 0.5)
        nodes = places(self.play.chains, self.shapes, growing)
        if not nodes:
            return None
        player, node = nodes[int(self.rng.integers(len(nodes)))]
        old, known = self.shapes[player], self.play.chains[player]
        room = self.play.most_actions - len(old.actions)
        linked = known.grown(old, node, room, self.rng) if growing else known.shrunk(old, node)
        if linked is None:
            return None
        ratio = linked.log_ratio + math.log(len(nodes))

        def log_back(_: SceneArrays, shapes: Sequence[TreeShape]) -> float:
            return -math.log(len(places(self.play.chains, shapes, not growing)))

        shape = tree_shape(self.play.derivations[player].grammar, linked.rules)
        offer = self._offer(player, shape, linked.span, linked.actions, groups, exact)
        return offer and offer._replace(log_ratio=offer.log_ratio + ratio, log_back=log_back)

    def recast(self, groups: ClipGroups, exact: bool) -> Offer | None:
        """Draw the clips of some consecutive actions again by their seams.

        Steps in continuous motion cannot be exchanged one by one, because each fits its neighbours
        only.
        """
        n_clips = self.scene.n_clips
        player = int(np.searchsorted(np.cumsum(n_clips), self.rng.integers(n_clips.sum()), "right"))
        n = int(n_clips[player])
        first = int(self.rng.integers(n))
        span = first, min(first + int(self.rng.integers(2, 1 + LONGEST)), n)
        shape = self.shapes[player]
        return self._offer(player, shape, span, shape.actions[slice(*span)], groups, exact)

    def _subtree_errors(self, scene: SceneArrays, shapes: Sequence[TreeShape]) -> list[FloatArray]:
        """Return E of all nodes of all players' trees."""
        errors = np.zeros(scene.entry.shape)
        token_errors(scene, self.play.library, errors)
        errors_of_players = []
        for player, shape in enumerate(shapes):
            node_errors = np.empty(len(shape.rules))
            subtree_errors(shape.children, errors[player], node_errors)
            errors_of_players.append(node_errors)
        return errors_of_players

    def _offer(
        self,
        player: int,
        shape: TreeShape,
        span: tuple[int, int],
        actions: Sequence[str],
        groups: ClipGroups,
        exact: bool,
    ) -> Offer | None:
        """Return the scene with other actions in ``span``, and the log ratio of their clips."""
        play, state = self.play, self.state
        entries, log_ratio = self._clips(player, span, actions, groups)
        same = shape is self.shapes[player]
        tree = self.strings[player].tree if same else play.derive(player, shape.rules)
        one = self._respelled(player, tree, span, entries)
        if one is None:
            return None
        players = (*state.players[:player], one, *state.players[player + 1 :])
        known = Structure(self.scene, self.table, self.strings)
        new = least_error(play, SceneState(players), known, player, tree)
        near = max(span[0] - AROUND, 0), span[0] + len(actions) + AROUND
        return Offer(player, shape, new, near, log_ratio if exact else 0.0)

    def _clips(
        self, player: int, span: tuple[int, int], actions: Sequence[str], groups: ClipGroups
    ) -> tuple[IntArray, float]:
        """Return clips for new actions, and log(q(old) / q(new)) relative to uniform draws."""
        play, n = self.play, int(self.scene.n_clips[player])
        entries, seams = self.scene.entry[player, :n], play.library.clips["seam"]
        before = int(seams[entries[span[0] - 1]]) if span[0] > 0 else -1
        after = int(seams[entries[span[1]]]) if span[1] < n else -1
        ratio, clips = 0.0, entries[:0]
        gone = self.shapes[player].actions[span[0] : span[1]]
        for sign, names, old in ((1, gone, entries[span[0] : span[1]]), (-1, actions, None)):
            ranges = np.array([play.first[name] for name in names], np.int64).reshape(-1, 2)
            rng = self.rng if old is None else None
            clips, log_probability = smooth_string(groups, ranges, before, after, rng, old)
            uniform = -float(np.log(ranges[:, 1] - ranges[:, 0]).sum())
            ratio += sign * (log_probability - uniform)
        return clips, ratio

    def _respelled(
        self, player: int, tree: Tree, span: tuple[int, int], entries: IntArray
    ) -> PlayerState | None:
        """Return a player with other clips in ``span``; None if they had to begin before time 0."""
        scene, clips = self.scene, self.play.library.clips
        first, last = span
        n = int(scene.n_clips[player])
        old = scene.entry[player, :n]
        spelled = np.concatenate([old[:first], entries, old[last:]])
        origin, delay = scene.placed[player, 0, :3], int(scene.begin[player, 0])
        if self.rng.random() < self.play.tails:  # what stands behind stays
            delay += int(clips["n_frames"][old[first:last]].sum())
            delay -= int(clips["n_frames"][entries].sum())
            here = scene.placed[player, last, :3]
            for entry in entries[::-1]:
                clip = clips[entry]
                step = np.array([clip["x"], clip["z"], clip["theta"]])
                here = compose(here, inverse(step))
            origin = compose(compose(here, inverse(scene.placed[player, first, :3])), origin)
        if delay < 0:
            return None
        return PlayerState(tree, spelled, tuple(origin.tolist()), delay)
