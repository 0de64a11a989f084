"""The inner loop: exchange clips, move and delay players, by Metropolis-Hastings at temperature T.

With the structure fixed, the target is P(Y)^(1/T) over clips, origins and delays, relative to
drawing every clip uniformly from its terminal, origins on the plane and circle, and delays in whole
frames. (-log P(Y) does not depend on how long players stand before they begin, nor on the duration
of the scene; small prices of delays and of frames are added to it.) A step is one of

    EXCHANGE  an action chosen by its error e, a clip drawn uniformly (the paper's Q_I):
              ratio [e'_k / sum e'] / [e_k / sum e]
    SMOOTH    an action drawn uniformly, a clip by its seams (:mod:`.clip_choice`)
    VARIANT   an action drawn uniformly, another bend or stretch of the same clip
    PLACE     a player rotated about the beginning of one of their clips and moved, by Gaussians
    DELAY     the beginning of a player moved by some frames, or, as often, of all players linked
              by synchronisations, so that they stay synchronous
    MEET      a delay drawn around the one that fulfils a synchronisation, with heavy tails

A SMOOTH or VARIANT step draws whether the clips before or those after the exchanged one stay in
place, and independently which of them stay in time. To keep those after it, the origin is moved by
a rigid motion, which preserves volumes, so that the ratio is that of the clips alone.

All functions are compiled and release the global lock. Random numbers are uniform numbers drawn by
:class:`numpy.random.Generator` before the loop.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 5, algorithm 1, lines 8 to 16. The steps other than EXCHANGE are ours.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from motiondb.grammar.kernels import kernel, merged
from motiondb.records import FloatArray, IntArray
from motiondb.scene.energy.binding import SYNCHRONISATION
from motiondb.scene.energy.energy import change, start_of, token_errors, undo
from motiondb.scene.energy.placement import ClipArrays
from motiondb.scene.energy.rule_kernels import lateness
from motiondb.scene.energy.scene_arrays import MOST_DELAY, SceneArrays
from motiondb.scene.sampling.clip_choice import (
    ClipGroups,
    smooth_entry,
    uniform_entry,
    variant_entry,
)

# Places, times and random numbers that the steps of the inner loop are made of, compiled.


@kernel
def origin_for_tail(
    scene: SceneArrays, library: ClipArrays, player: int, k: int, entry: int
) -> tuple[float, float, float]:
    """Return the origin that keeps everything after clip ``k`` in place when ``k`` is exchanged."""
    clip = library.clips[entry]
    start, here, end = scene.placed[player, 0], scene.placed[player, k], scene.placed[player, k + 1]
    theta = end[2] - clip.theta
    c, s = math.cos(theta), math.sin(theta)
    x, z = end[0] - (clip.x * c + clip.z * s), end[1] - (clip.z * c - clip.x * s)
    turn = theta - here[2]
    c, s = math.cos(turn), math.sin(turn)
    dx, dz = start[0] - here[0], start[1] - here[1]
    return x + dx * c + dz * s, z - dx * s + dz * c, start[2] + turn


@kernel
def gaussian(u: float, v: float) -> tuple[float, float]:
    """Return two standard normal numbers from two uniform ones (Box and Muller)."""
    radius = math.sqrt(-2.0 * math.log(1.0 - u))
    return radius * math.cos(2.0 * math.pi * v), radius * math.sin(2.0 * math.pi * v)


@kernel
def linked(scene: SceneArrays, player: int) -> int:
    """Return the players linked with one by synchronisations, itself too: bit p for player p."""
    group, before = 1 << player, 0
    while group != before:
        before = group
        for row in scene.rows:
            if row.kind == SYNCHRONISATION and (group >> row.player | group >> row.partner) & 1:
                group |= 1 << row.player | 1 << row.partner
    return group


EXCHANGE, SMOOTH, VARIANT, PLACE, DELAY, MEET = range(6)

PUSH = 0.15
"""Standard deviation of the translation of a PLACE step, m. Chosen by hand: half the weight of a
position."""
TURN = math.radians(8.0)
"""Standard deviation of the rotation of a PLACE step, rad. Chosen by hand: less than half the
weight of a direction."""
FRAMES = 4.0
"""Standard deviation of a DELAY step, frames. Chosen by hand: about the weight of a
synchronisation."""
DRAWS = 9  # Random numbers that a step may use
TAIL = 2.0
"""Half width of the Cauchy distribution of a MEET step, frames: the accepted error of a
synchronisation."""


Focus = tuple[int, int, int, float]
"""A player, the clips [since, until) of theirs, and the fraction of inner steps for that player."""
EVERYBODY: Focus = (-1, 0, 0, 0.0)  # A focus on no player in particular


class Walk(NamedTuple):
    """Settings and work space of a walk."""

    temperature: float
    shares: FloatArray  # (6,): cumulative probabilities of the kinds of steps; the last is 1
    focus: int  # A player, or -1
    since: int  # First clip of the player in focus that SMOOTH and VARIANT steps exchange
    until: int  # The clip after the last of these
    attention: float  # Probability of choosing the player in focus before drawing from all actions
    delay: float  # Price of every frame of every player's delay
    duration: float  # Price of every frame of the scene
    # Probability that SMOOTH and VARIANT steps keep the clips after the exchanged one in place
    tails: float
    errors: FloatArray  # (P, L): work space for the errors of the clips
    after: FloatArray  # (P, L): the same for a proposed scene


@kernel
def walk(
    scene: SceneArrays,
    library: ClipArrays,
    groups: ClipGroups,
    draws: FloatArray,
    how: Walk,
) -> float:
    """Do one step for each row of random numbers, and return -log P(Y) at the end.

    Parameters
    ----------
    scene : SceneArrays
        The scene; changed in place.
    library : ClipArrays
        The clips.
    groups : ClipGroups
        The clips by terminal and seam class.
    draws : array (steps, DRAWS)
        Uniform random numbers in [0, 1).
    how : Walk
        Settings and work space.
    """
    known, total = False, 0.0
    for u in draws:
        kind = 0
        while kind < MEET and u[0] >= how.shares[kind]:
            kind += 1
        if kind == EXCHANGE:
            if not known:
                total = token_errors(scene, library, how.errors)
            taken, total = _exchange(scene, library, u, how, total)
            known = True
        elif kind <= VARIANT:
            taken = _clip_step(scene, library, groups, u, how, kind)
        elif kind == PLACE:
            taken = _place_step(scene, library, u, how)
        elif kind == DELAY:
            taken = _delay_step(scene, library, u, how)
        else:
            taken = _meet_step(scene, library, u, how)
        known = known and (kind == EXCHANGE or not taken)
    return float(scene.total[0])


@kernel
def accepts(u: float, gain: float) -> bool:
    """Return whether to accept a step with log ratio ``gain``; ``u`` is uniform in [0, 1)."""
    return gain >= 0.0 or u < math.exp(gain)


@kernel
def room(u: float, temperature: float) -> float:
    """Return by how much -log P may rise for :func:`accepts`."""
    return -temperature * math.log(max(u, 1e-300))


@kernel
def price(scene: SceneArrays, how: Walk, player: int, later: int, longer: int) -> float:
    """Return the price of delays and frames if a player began ``later`` and took ``longer``."""
    waited, end = later, 0
    for p in range(len(scene.n_clips)):
        waited += scene.begin[p, 0]
        more = later + longer if p == player else 0
        end = max(end, scene.begin[p, scene.n_clips[p]] + more)
    return float(how.delay * waited + how.duration * end)


@kernel
def chosen_by(errors: FloatArray, n_clips: IntArray, left: float) -> tuple[int, int]:
    """Return the player and action at the point ``left`` of the cumulative errors."""
    player, k = 0, 0
    for p in range(len(n_clips)):
        for m in range(n_clips[p]):
            player, k = p, m
            if left < errors[p, m]:
                return player, k
            left -= errors[p, m]
    return player, k


@merged
def _exchange(
    scene: SceneArrays, library: ClipArrays, u: FloatArray, how: Walk, total: float
) -> tuple[bool, float]:
    """Do an EXCHANGE step; return whether it was accepted, and the new sum of errors."""
    player, k = chosen_by(how.errors, scene.n_clips, u[1] * total)
    before = float(scene.total[0]) + price(scene, how, 0, 0, 0)
    old = scene.entry[player, k]
    new = uniform_entry(library, old, u[2])
    back = -math.log(how.errors[player, k] / total)
    cost = price(scene, how, player, 0, library.clips[new].n_frames - library.clips[old].n_frames)
    limit = before + room(u[3], how.temperature) + how.temperature * back - cost
    now = change(scene, library, player, k, new, start_of(scene, player), limit) + cost
    if now == math.inf:
        undo(scene)
        return False, total
    new_total = token_errors(scene, library, how.after)
    ratio = math.log(how.after[player, k] / new_total) + back
    if accepts(u[3], (before - now) / how.temperature + ratio):
        for p in range(len(scene.n_clips)):
            for m in range(scene.n_clips[p]):
                how.errors[p, m] = how.after[p, m]
        return True, new_total
    undo(scene)
    return False, total


@kernel
def _any_player(scene: SceneArrays, u: float, how: Walk) -> int:
    """Return a player, drawn by their number of actions, or the one in focus."""
    if how.focus >= 0:
        if u < how.attention:
            return how.focus
        u = (u - how.attention) / (1.0 - how.attention)
    n_all = 0
    for n in scene.n_clips:
        n_all += n
    left = int(u * n_all)
    player = 0
    while left >= scene.n_clips[player]:
        left -= scene.n_clips[player]
        player += 1
    return player


@merged
def _clip_step(
    scene: SceneArrays,
    library: ClipArrays,
    groups: ClipGroups,
    u: FloatArray,
    how: Walk,
    kind: int,
) -> bool:
    """Do a SMOOTH or VARIANT step; return whether it was accepted."""
    player = _any_player(scene, u[1], how)
    n = scene.n_clips[player]
    k = int(u[2] * n)
    if player == how.focus:
        k = how.since + int(u[2] * (min(how.until, n) - how.since))
    old = scene.entry[player, k]
    ratio = 0.0
    if kind == SMOOTH:
        before = library.clips[scene.entry[player, k - 1]].seam if k > 0 else -1
        after = library.clips[scene.entry[player, k + 1]].seam if k + 1 < n else -1
        new, ratio = smooth_entry(groups, old, before, after, u[3])
    else:
        new = variant_entry(groups, old, u[3])
    x, z, theta, delay = start_of(scene, player)
    if u[4] < how.tails:
        x, z, theta = origin_for_tail(scene, library, player, k, new)
    longer = library.clips[new].n_frames - library.clips[old].n_frames
    later = -longer if u[5] < how.tails else 0
    energy = float(scene.total[0]) + price(scene, how, 0, 0, 0)
    cost = price(scene, how, player, later, longer)
    limit = energy + room(u[6], how.temperature) + how.temperature * ratio - cost
    now = change(scene, library, player, k, new, (x, z, theta, delay + later), limit) + cost
    if accepts(u[6], (energy - now) / how.temperature + ratio):
        return True
    undo(scene)
    return False


@merged
def _place_step(scene: SceneArrays, library: ClipArrays, u: FloatArray, how: Walk) -> bool:
    """Do a PLACE step of 0.1 to 3 times the usual size; return whether it was accepted."""
    player = _any_player(scene, u[1], how)
    m = int(u[2] * (scene.n_clips[player] + 1))
    size = 10.0 ** (1.5 * u[3] - 1.0)
    right, ahead = gaussian(u[4], u[5])
    turn = TURN * size * gaussian(u[6], 0.5 * u[7])[0]
    start, pivot = scene.placed[player, 0], scene.placed[player, m]
    c, s = math.cos(turn), math.sin(turn)
    dx, dz = start[0] - pivot[0], start[1] - pivot[1]
    x = pivot[0] + dx * c + dz * s + PUSH * size * right
    z = pivot[1] - dx * s + dz * c + PUSH * size * ahead
    energy = float(scene.total[0])
    limit = energy + room(u[8], how.temperature)
    begin = (x, z, start[2] + turn, scene.begin[player, 0])
    now = change(scene, library, player, -1, 0, begin, limit)
    if accepts(u[8], (energy - now) / how.temperature):
        return True
    undo(scene)
    return False


@merged
def _delay_step(scene: SceneArrays, library: ClipArrays, u: FloatArray, how: Walk) -> bool:
    """Do a DELAY step of 0.3 to 10 times the usual size; return whether it was accepted."""
    player = _any_player(scene, u[1], how)
    size = FRAMES * 10.0 ** (1.5 * u[2] - 0.5)
    frames = round(size * gaussian(u[3], u[4])[0])
    together = linked(scene, player) if u[6] < 0.5 else 1 << player
    for p in range(len(scene.n_clips)):
        if together >> p & 1 and not 0 <= scene.begin[p, 0] + frames <= MOST_DELAY:
            return False
    energy = float(scene.total[0]) + price(scene, how, 0, 0, 0)
    now = _shift_all(scene, library, together, frames) + price(scene, how, 0, 0, 0)
    if accepts(u[5], (energy - now) / how.temperature):
        return True
    _shift_all(scene, library, together, -frames)
    return False


@kernel
def _shift_all(scene: SceneArrays, library: ClipArrays, players: int, frames: int) -> float:
    """Let players (bits) begin later by some frames; return the new -log P(Y)."""
    for p in range(len(scene.n_clips)):
        if players >> p & 1:
            x, z, theta, delay = start_of(scene, p)
            change(scene, library, p, -1, 0, (x, z, theta, delay + frames), math.inf)
    return float(scene.total[0])


@merged
def _meet_step(scene: SceneArrays, library: ClipArrays, u: FloatArray, how: Walk) -> bool:
    """Do a MEET step: a delay drawn around the one that fulfils a synchronisation.

    The fulfilling delay depends on everything but the delay itself, as long as the same clip of the
    partner counts. If another would count, the step is rejected.
    """
    if len(scene.rows) == 0:
        return False
    r = int(u[1] * len(scene.rows))
    row = scene.rows[r]
    if row.kind != SYNCHRONISATION or row.player == row.partner:
        return False
    player, sign = (row.player, 1) if u[2] < 0.5 else (row.partner, -1)
    meant = scene.meant[r]
    delay = scene.begin[player, 0]
    wanted = delay + sign * round(lateness(scene, library, r, meant))
    new = wanted + round(TAIL * math.tan(math.pi * (u[3] - 0.5)))
    energy = float(scene.total[0]) + price(scene, how, 0, 0, 0)
    ratio = _tail(delay - wanted) - _tail(new - wanted)
    cost = price(scene, how, player, new - delay, 0)
    limit = energy + room(u[4], how.temperature) + how.temperature * ratio - cost
    x, z, theta, _ = start_of(scene, player)
    now = change(scene, library, player, -1, 0, (x, z, theta, new), limit) + cost
    if scene.meant[r] == meant and accepts(u[4], (energy - now) / how.temperature + ratio):
        return True
    undo(scene)
    return False


@kernel
def _tail(frames: int) -> float:
    """Return the log probability of a rounded Cauchy number."""
    high, low = math.atan((frames + 0.5) / TAIL), math.atan((frames - 0.5) / TAIL)
    return math.log(high - low)
