"""Possession of the ball over time, and by which hand, from a scene's actions and their events."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from motiondb.records import FloatArray, IntArray
from motiondb.scene.clips.clips import APART, ClipLibrary
from motiondb.scene.energy import binding as kinds
from motiondb.scene.energy.binding import RuleTable
from motiondb.scene.energy.scene_arrays import SceneState
from motiondb.scene.language.tactics import SHOTS
from motiondb.scene.timing.timeline import Timeline, measure

_SHORTEST, _PERIOD, _RAMP = 6, 20, 8
"""Frames: of the shortest dribble and bounce, from bounce to bounce if no events are known, and of
the transition between hands."""
_HANDS = {"l_wrist": 0, "r_wrist": 1}  # Number of the hand at each wrist


@dataclass(frozen=True)
class Bounce:
    """A bounce of the ball."""

    release: int  # Frame at which it leaves the hand
    catch: int  # Frame at which it is back
    hand: int  # 0 for the left, 1 for the right


@dataclass(frozen=True)
class Possession:
    """A player has the ball from frame ``since`` to ``until``, both included."""

    player: int  # Index of the player
    since: int
    until: int
    hand: int = 1  # The hand that releases it (0 left, 1 right), if the hands are apart
    dribbles: tuple[tuple[int, int], ...] = ()  # Intervals [start, end) of dribbling
    bounces: tuple[Bounce, ...] = ()

    def dribbled(self, n_frames: int) -> FloatArray:
        """Return 1 at frames of dribbling, else 0: array (frames,)."""
        shares = np.zeros(n_frames)
        for start, end in self.dribbles:
            shares[max(start, 0) : end] = 1.0
        return shares

    def one_handed(self, n_frames: int, gap: FloatArray) -> FloatArray:
        """Return 1 at frames when one hand has the ball: dribbling, or releasing hands apart."""
        shares = self.dribbled(n_frames)
        if self.until < n_frames - 1 and gap[self.until] > APART:
            shares[max(self.until - _RAMP, self.since) :] = 1.0
        return shares

    def hand_at(self, n_frames: int) -> IntArray:
        """Return which hand has the ball: array (frames,); it changes hands while it bounces."""
        hands = np.full(n_frames, self.hand)
        if self.bounces:
            hands[: self.bounces[-1].catch + _RAMP] = self.bounces[-1].hand
        for before, after in reversed(list(pairwise(self.bounces))):
            hands[: after.release + 1] = before.hand
        return hands


@dataclass(frozen=True)
class BallActs:
    """The course of the ball."""

    possessions: tuple[Possession, ...]
    shot: bool  # Whether the last ends with a shot
    rim: tuple[float, float] = (0.0, 0.0)  # x and z of the ring


def ball_acts(
    state: SceneState,
    library: ClipLibrary,
    table: RuleTable,
    timeline: Timeline,
) -> BallActs | None:
    """Return the holder of the ball over time; None if nobody passes, shoots or dribbles."""
    releases = sorted(_releases(table, timeline))
    holder, since = _first(table, releases), 0
    if holder < 0:
        return None
    possessions: list[Possession] = []
    for release, player, catch, partner, clip in releases:
        if player != holder or release <= since:
            continue
        hand = _hand(state, library, player, clip)
        possessions.append(
            _possession(state, library, table, timeline, (player, since, release, hand))
        )
        if partner < 0:
            return BallActs(tuple(possessions), True, _rim(table))
        holder, since = partner, max(catch, release + 1)
    last = (holder, since, timeline.n_frames - 1, 1)
    possessions.append(_possession(state, library, table, timeline, last))
    return BallActs(tuple(possessions), False)


def _releases(table: RuleTable, timeline: Timeline) -> list[tuple[int, int, int, int, int]]:
    """Return release frame, player, catch frame, partner (-1: a shot) and clip of each throw."""
    releases = []
    for number, row in enumerate(table.rows):
        if row["kind"] == kinds.SYNCHRONISATION and np.isnan(row["lag"]):
            clip = measure(table, number, timeline).partner_clip
            thrown = int(timeline.instants[row["player"]][row["first"]])
            caught = int(timeline.instants[row["partner"]][clip])
            releases.append(
                (thrown, int(row["player"]), caught, int(row["partner"]), int(row["first"]))
            )
    for player, actions in enumerate(table.actions):
        for clip, action in enumerate(actions):
            if action in SHOTS:
                releases.append((int(timeline.instants[player][clip]), player, -1, -1, clip))
    return releases


def _first(table: RuleTable, releases: list[tuple[int, int, int, int, int]]) -> int:
    """Return the first player with the ball: who releases it first, else who dribbles; or -1."""
    if releases:
        return releases[0][1]
    dribblers = [p for p, actions in enumerate(table.actions) if "dribble" in actions]
    return dribblers[0] if dribblers else -1


def _rim(table: RuleTable) -> tuple[float, float]:
    """Return the place that shots face."""
    for row in table.rows:
        shoots = table.actions[row["player"]][row["first"]] in SHOTS
        if shoots and row["kind"] == kinds.DIRECTION and row["target"] == kinds.POINT:
            return float(row["x"]), float(row["z"])
    return 0.0, 0.0


def _hand(state: SceneState, library: ClipLibrary, player: int, clip: int) -> int:
    """Return the hand of a clip's last release; the right one if no event says."""
    entry = int(state.players[player].entries[clip])
    events = library.events[library.seam_class[entry]] if library.events else ()
    hands = [_HANDS[e.joint] for e in events if e.name == "release" and e.joint in _HANDS]
    return hands[-1] if hands else 1


def _possession(
    state: SceneState,
    library: ClipLibrary,
    table: RuleTable,
    timeline: Timeline,
    what: tuple[int, int, int, int],
) -> Possession:
    """Return a possession with its dribbles and bounces."""
    player, since, until, hand = what
    dribbles: list[tuple[int, int]] = []
    bounces: list[Bounce] = []
    for clip, action in enumerate(table.actions[player]):
        begins, ends = int(timeline.begins[player][clip]), timeline.end_of(player, clip)
        start, end = max(begins, since), min(ends, until)
        if action != "dribble" or end - start < _SHORTEST:
            continue
        dribbles.append((start, end))
        for name, frame, side in _touches(state, library, player, clip, (begins, ends)):
            _touch(bounces, name, min(max(frame, start), end), side)
        if bounces and bounces[-1].catch < 0 and not _goes_on(table, player, clip):
            bounces[-1] = Bounce(bounces[-1].release, end, bounces[-1].hand)
    full = [b for b in bounces if b.catch - b.release >= _SHORTEST]
    return Possession(player, since, until, hand, tuple(dribbles), tuple(full))


def _goes_on(table: RuleTable, player: int, clip: int) -> bool:
    actions = table.actions[player]
    return clip + 1 < len(actions) and actions[clip + 1] == "dribble"


def _touch(bounces: list[Bounce], name: str, frame: int, side: int) -> None:
    """Begin a bounce at a release, end it at a catch."""
    open_ = bool(bounces) and bounces[-1].catch < 0
    if name == "release":
        if open_:
            bounces[-1] = Bounce(bounces[-1].release, frame, bounces[-1].hand)
        bounces.append(Bounce(frame, -1, side))
    elif open_:
        bounces[-1] = Bounce(bounces[-1].release, frame, side)


def _touches(
    state: SceneState,
    library: ClipLibrary,
    player: int,
    clip: int,
    shown: tuple[int, int],
) -> list[tuple[str, int, int]]:
    """Return releases and catches of a dribbling clip that is ``shown`` between two frames.

    Without annotated events there is one every 2/3 s.
    """
    entry = int(state.players[player].entries[clip])
    n_frames = int(library.n_frames[entry])
    events = library.events[library.seam_class[entry]] if library.events else ()
    touches = [
        (e.name, e.frame, _HANDS[e.joint])
        for e in sorted(events)
        if e.name in ("release", "catch") and e.joint in _HANDS
    ]
    if not touches:
        for frame in range(0, n_frames - _PERIOD // 2, _PERIOD):
            caught = min(frame + _PERIOD - 5, n_frames)
            touches += [("release", frame, 1), ("catch", caught, 1)]
    return [
        (name, round(shown[0] + frame * (shown[1] - shown[0]) / n_frames), side)
        for name, frame, side in touches
    ]
