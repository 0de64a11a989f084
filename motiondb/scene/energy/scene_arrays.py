"""A scene for compiled code: arrays that are changed in place, with one step of undo.

The place of every player is stored at every ``every``-th frame of the scene's clock (the grid),
where rules that hold throughout and collisions are evaluated. Frames before a player begins show
the first pose, frames after the last one the last pose.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motiondb.grammar.cfg.context_free import Tree
from motiondb.grammar.kernels import inlined, kernel
from motiondb.records import FloatArray, IntArray
from motiondb.scene.energy.binding import AT_EVENT, AT_START, UNMET, RuleTable
from motiondb.scene.energy.placement import ClipArrays, chain, clip_at, place_in_clip, put_origin
from motiondb.scene.language.expressions import Spans
from motiondb.scene.language.semantic_rules import Weights

# The state of sampling: for every player a tree of actions, their clips, a place and a time.


@dataclass(frozen=True, eq=False)
class PlayerState:
    """The sampled state of one player.

    An instance Y of an action string plays one clip after the other. Where the first clip begins is
    free (the origin, a ground transform), and so is when (the delay). Everything else follows from
    the clips.

    Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
    Forum 35 (2016), sections 3.1 and 5. The paper does not say where a string of clips begins.
    """

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


EVERY = 3
"""Frames between grid points while sampling; reports and tests may use all frames (1). Chosen by
hand: players move by at most 0.8 m in between."""
MOST_DELAY = 900  # Most frames that a player may stand before the first clip: 30 s
ANY_TIME = -1  # Reach of a rule that looks at a player at a time, not at one of their clips


class Changing(NamedTuple):
    """What a change of one player overwrites; the fields are those of :class:`SceneArrays`."""

    entry: IntArray
    begin: IntArray
    placed: FloatArray
    grid: FloatArray
    filled: IntArray
    cost: FloatArray
    seen: IntArray
    meant: IntArray
    seams: FloatArray
    overlaps: IntArray
    total: FloatArray


class SceneArrays(NamedTuple):
    """Arrays of P players, at most L clips each, R rules, G grid points."""

    entry: IntArray  # (P, L), int: clips, as entries of the library
    # (P, L + 1), int: first frame of every clip; after the last, the end. begin[:, 0] is the delay
    begin: IntArray
    # (P, L + 1, 5): x, z, theta, cos, sin where every clip begins; placed[:, 0] is the origin
    placed: FloatArray
    grid: FloatArray  # (P, G, 3): x, z, theta at frames 0, every, 2 every
    # (P,), int: number of grid points within the player's string; the last pose follows once
    filled: IntArray
    cost: FloatArray  # (R,): f_k / c_k, with the excess beyond 1 (:mod:`.energy`)
    seen: IntArray  # (R,), int: last frame at which the rule looks at others
    meant: IntArray  # (R,), int: the partner's clip that counts for a synchronisation
    seams: FloatArray  # (P, L): mismatch at the beginning of every clip, unweighted
    overlaps: IntArray  # (P, P), int: number of grid points at which two touch
    total: FloatArray  # (5,): -log P(Y), and its parts: rules, smoothness, collision, effort
    now: Changing  # The arrays above
    kept: Changing  # What they held before the last change of a player
    # (2,), int: the player who was changed last, or -1, and from which grid point, or -1 for none
    last: IntArray
    n_clips: IntArray  # (P,), int: number of clips of every player
    near: IntArray  # (P, P), int: 1 if two are meant to touch
    scale: FloatArray  # (4,): 1 / w_2, 1 / w_3, 1 / w_4, excess
    every: IntArray  # (1,), int: frames between grid points
    rows: NDArray[np.void]  # (R,), ROW: of the rule table
    partners: IntArray  # (n,), int: of the rule table
    contacts: IntArray  # (n, 4), int: of the rule table
    # (n, 2), int: for every player the rules that depend on them, and their reach: exchanging clip
    # k matters if k < reach (or :data:`ANY_TIME`)
    depends: IntArray
    depends_first: IntArray  # (P + 1,), int: first row of ``depends`` of each player


def empty_scene(
    state: SceneState,
    library: ClipArrays,
    table: RuleTable,
    weights: Weights,
    every: int = EVERY,
    excess: float = 0.0,
) -> SceneArrays:
    """Return the arrays of a scene with its clips, origins and delays, not yet evaluated."""
    players = state.players
    n, most = len(players), max(len(player.entries) for player in players)
    longest = _longest(state, library) + max(MOST_DELAY, *(p.delay for p in players))
    n_grid, n_rules = longest // every + 2, len(table.rows)
    depends, depends_first = _dependencies(table, n)
    scale = [1.0 / weight for weight in (weights.smooth, weights.collision, weights.effort)]
    now = Changing(
        entry=np.zeros((n, most), np.int64),
        begin=np.zeros((n, most + 1), np.int64),
        placed=np.zeros((n, most + 1, 5)),
        grid=np.zeros((n, n_grid, 3)),
        filled=np.zeros(n, np.int64),
        cost=np.zeros(n_rules),
        seen=np.zeros(n_rules, np.int64),
        meant=np.zeros(n_rules, np.int64),
        seams=np.zeros((n, most)),
        overlaps=np.zeros((n, n), np.int64),
        total=np.zeros(5),
    )
    scene = SceneArrays(
        *now,
        now=now,
        kept=Changing._make(array.copy() for array in now),
        last=np.array([-1, -1]),
        n_clips=np.array([len(player.entries) for player in players]),
        near=_near(table, n),
        scale=np.array([*scale, excess]),
        every=np.array([every]),
        rows=table.rows,
        partners=table.partners,
        contacts=table.contacts,
        depends=depends,
        depends_first=depends_first,
    )
    for number, player in enumerate(players):
        scene.entry[number, : len(player.entries)] = player.entries
        scene.begin[number, 0] = player.delay
        put_origin(scene.placed[number], *player.origin)
    return scene


def scene_state(
    scene: SceneArrays, trees: Sequence[Tree], spans: Sequence[Spans | None] | None = None
) -> SceneState:
    """Return the clips, origins and delays in the arrays, with the trees that they belong to.

    ``spans`` are the actions of each player's items, if they were chosen.
    """
    players = []
    for number, tree in enumerate(trees):
        x, z, theta = scene.placed[number, 0, :3].tolist()
        entries = scene.entry[number, : scene.n_clips[number]].copy()
        chosen = spans[number] if spans else None
        delay = int(scene.begin[number, 0])
        players.append(PlayerState(tree, entries, (x, z, theta), delay, chosen))
    return SceneState(tuple(players))


def _longest(state: SceneState, library: ClipArrays) -> int:
    """Return the frames of the longest string if each clip were the longest of its action."""
    most = library.clips["most"]
    return max(int(most[np.asarray(player.entries)].sum()) for player in state.players)


def _near(table: RuleTable, n: int) -> IntArray:
    near = np.zeros((n, n), np.int64)
    for one, _, other, _ in table.contacts:
        near[one, other] = near[other, one] = 1
    return near


def _dependencies(table: RuleTable, n_players: int) -> tuple[IntArray, IntArray]:
    """Return for every player the rules that depend on them, and their reach; see SceneArrays."""
    reach = np.full((n_players, len(table.rows)), ANY_TIME - 1)
    _fill_reach(table.rows, table.partners, reach)
    players, rules = np.nonzero(reach >= ANY_TIME)
    firsts = np.searchsorted(players, np.arange(n_players + 1))
    return np.column_stack([rules, reach[players, rules]]), firsts


@kernel
def _fill_reach(rows: NDArray[np.void], partners: IntArray, reach: IntArray) -> None:
    """Fill in how far each player (P, R) matters to each rule; below ANY_TIME if not at all."""
    for r in range(len(rows)):
        row = rows[r]
        if row.kind == UNMET:
            continue
        for n in range(row.partner_first, row.partner_last):
            reach[row.partner, r] = max(reach[row.partner, r], partners[n] + 1)
        for looked_at in (row.target, row.other):
            if looked_at >= 0:
                reach[looked_at, r] = ANY_TIME
        own = row.last
        if row.moment in (AT_START, AT_EVENT):
            own = row.first + int(row.moment == AT_EVENT)
        reach[row.player, r] = max(own, reach[row.player, r])


# Where the players of a scene are: their clips, the seams between them, and the grid.


@inlined
def place_of(
    scene: SceneArrays, library: ClipArrays, player: int, frame: int
) -> tuple[float, float, float]:
    """Return where a player is at a frame of the scene: x, z, theta."""
    begin = scene.begin[player]
    k = clip_at(begin, scene.n_clips[player], frame)
    clip = library.clips[scene.entry[player, k]]
    inside = min(max(frame - begin[k], 0), clip.n_frames - 1)
    return place_in_clip(scene.placed[player], library.path, clip.path_start + inside, k)


@kernel
def place_string(scene: SceneArrays, library: ClipArrays, player: int, k: int) -> None:
    """Place everything after clip ``k`` (-1: everything) of a player; update seams and grid."""
    place_clips(scene, library, player, k)
    place_grid(scene, library, player, k, first_point(scene, player, k))


@inlined
def place_clips(scene: SceneArrays, library: ClipArrays, player: int, k: int) -> None:
    """Place what follows clip ``k`` (-1: everything) of a player; update seams, not the grid."""
    n, since = scene.n_clips[player], max(k, 0)
    entry = scene.entry[player]
    chain(scene.placed[player], scene.begin[player], entry, library.clips, since, n)
    for m in range(max(since, 1), n if k < 0 else min(k + 2, n)):
        before, after = library.clips[entry[m - 1]].seam, library.clips[entry[m]].seam
        scene.seams[player, m] = library.seams[before, after]


@inlined
def first_point(scene: SceneArrays, player: int, k: int) -> int:
    """Return the first point of a player's grid that a change of clip ``k`` (-1: of all) moves."""
    return 0 if k < 0 else int(-(-scene.begin[player, k] // scene.every[0]))


@inlined
def place_grid(scene: SceneArrays, library: ClipArrays, player: int, k: int, g: int) -> None:
    """Fill a player's grid from point ``g`` on, from the places of clip ``k`` and later ones."""
    n, since, every = scene.n_clips[player], max(k, 0), scene.every[0]
    entry, begin, placed = scene.entry[player], scene.begin[player], scene.placed[player]
    grid = scene.grid[player]
    while g * every < begin[0]:
        grid[g, 0], grid[g, 1], grid[g, 2] = placed[0, 0], placed[0, 1], placed[0, 2]
        g += 1
    for m in range(since, n):
        row = library.clips[entry[m]].path_start - begin[m]
        c, s, x, z, theta = placed[m, 3], placed[m, 4], placed[m, 0], placed[m, 1], placed[m, 2]
        while g * every < begin[m + 1]:
            at = row + g * every
            px, pz = library.path[at, 0], library.path[at, 1]
            grid[g, 0], grid[g, 1] = x + px * c + pz * s, z - px * s + pz * c
            grid[g, 2] = theta + library.path[at, 2]
            g += 1
    scene.filled[player] = g
    clip = library.clips[entry[n - 1]]
    last = clip.path_start + clip.n_frames - 1
    grid[g, 0], grid[g, 1], grid[g, 2] = place_in_clip(placed, library.path, last, n - 1)
