"""Who has the object over time, and in which hand, from a scene's actions and their events."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from motiondb.records import FloatArray, IntArray
from motiondb.scene.clips.clips import APART, ClipLibrary
from motiondb.scene.energy import binding as kinds
from motiondb.scene.energy.binding import RuleTable
from motiondb.scene.energy.scene_arrays import SceneState
from motiondb.scene.language.activity import (
    BOUNCE,
    GIVE,
    PUT,
    SEND,
    STRIKE,
    TAKE,
    Place,
    Thing,
)
from motiondb.scene.language.possession import first_holder
from motiondb.scene.timing.timeline import Timeline, measure

_SHORTEST, _PERIOD, _RAMP = 6, 20, 8
"""Frames: of the shortest dribble and bounce, from bounce to bounce if no events are known, and of
the transition between hands."""
_HEAD = 0.25  # Width of a head as a target, m
_HANDS = {"l_wrist": 0, "r_wrist": 1}  # Number of the hand at each wrist


@dataclass(frozen=True)
class Bounce:
    """A bounce of the ball."""

    release: int  # Frame at which it leaves the hand
    catch: int  # Frame at which it is back
    hand: int  # 0 for the left, 1 for the right


@dataclass(frozen=True)
class Aim:
    """Where something is sent or put, or where it lies."""

    name: str
    # x, height and z, m, of the middle of a place; of a player's head ``player`` says whose
    at: tuple[float, float, float] = (0.0, 0.0, 0.0)
    width: float = 0.0  # m
    upright: bool = False
    player: int = -1

    @property
    def on_the_ground(self) -> tuple[float, float]:
        """Its x and z, m."""
        return self.at[0], self.at[2]


@dataclass(frozen=True)
class Possession:
    """A player has the object from frame ``since`` to ``until``, both included."""

    player: int  # Index of the player
    since: int
    until: int
    hand: int = 1  # The hand that releases it (0 left, 1 right), if the hands are apart
    dribbles: tuple[tuple[int, int], ...] = ()  # Intervals [start, end) of dribbling
    bounces: tuple[Bounce, ...] = ()
    left: str = ""  # How it leaves the hands: give, send or put; "" if it does not
    aim: Aim | None = None  # Where it is sent or put
    # Who took it while the player had it and bears it, too: players, each with first and last frame
    helpers: tuple[tuple[int, int, int], ...] = ()

    @property
    def is_struck(self) -> bool:
        """Whether it leaves from where it lies or flies, and is never in the hands."""
        return self.since == self.until

    def dribbled(self, n_frames: int) -> FloatArray:
        """Return 1 at frames of dribbling, else 0: array (frames,)."""
        shares = np.zeros(n_frames)
        for start, end in self.dribbles:
            shares[max(start, 0) : end] = 1.0
        return shares

    def one_handed(self, n_frames: int, gap: FloatArray) -> FloatArray:
        """Return 1 at frames when one hand has the object: dribbling, or releasing hands apart."""
        shares = self.dribbled(n_frames)
        if self.until < n_frames - 1 and gap[self.until] > APART:
            shares[max(self.until - _RAMP, self.since) :] = 1.0
        return shares

    def hand_at(self, n_frames: int) -> IntArray:
        """Return which hand has the object: array (frames,); it changes hands while it bounces."""
        hands = np.full(n_frames, self.hand)
        if self.bounces:
            hands[: self.bounces[-1].catch + _RAMP] = self.bounces[-1].hand
        for before, after in reversed(list(pairwise(self.bounces))):
            hands[: after.release + 1] = before.hand
        return hands


@dataclass(frozen=True)
class ThingActs:
    """The course of the object."""

    possessions: tuple[Possession, ...]
    thing: Thing
    lies: Aim | None = None  # Where it lies at first; None if somebody has it


@dataclass(frozen=True)
class _Deed:
    """Something that is done with the object at a frame."""

    frame: int
    player: int
    clip: int
    deed: str
    partner: int = -1  # To whom it is given
    caught: int = -1  # When it arrives there


def thing_acts(
    state: SceneState,
    library: ClipLibrary,
    table: RuleTable,
    timeline: Timeline,
) -> ThingActs | None:
    """Return the holder of the object over time; None if nobody does anything with it."""
    thing = table.activity.thing
    if thing is None:
        return None
    deeds = sorted(_deeds(table, timeline), key=lambda deed: deed.frame)
    place = table.places.get(thing.at)
    name = first_holder(table.diagram)
    holder, since = table.players.index(name) if name else -1, 0
    if holder < 0 and not place and not any(deed.deed == TAKE for deed in deeds):
        return None
    possessions: list[Possession] = []

    def had(until: int, hand: int, left: str = "", aim: Aim | None = None) -> None:
        of = _possession(state, library, table, timeline, (holder, since, until, hand))
        helpers = _helpers(of, deeds) if place else ()
        possessions.append(replace(of, left=left, aim=aim, helpers=helpers))

    for deed in deeds:
        if deed.deed == TAKE:
            if holder < 0 and deed.frame > since:
                holder, since = deed.player, deed.frame
            continue
        if deed.deed == STRIKE and holder < 0:
            holder, since = deed.player, deed.frame
        elif deed.player != holder or deed.frame <= since:
            continue
        aim = None if deed.deed == GIVE else aim_of(table, deed.player, deed.clip)
        left = SEND if deed.deed == STRIKE else deed.deed
        had(deed.frame, _hand(state, library, deed.player, deed.clip), left, aim)
        holder, since = deed.partner, max(deed.caught, deed.frame + 1)
    if holder >= 0:
        had(timeline.n_frames - 1, 1)
    return ThingActs(tuple(possessions), thing, _lying(place, thing) if place else None)


def _helpers(of: Possession, deeds: Sequence[_Deed]) -> tuple[tuple[int, int, int], ...]:
    """Return who takes what another has, and bears it until they do something else with it."""
    found: dict[int, tuple[int, int, int]] = {}
    for deed in deeds:
        if deed.player != of.player and of.since <= deed.frame <= of.until:
            if deed.deed == TAKE:
                found.setdefault(deed.player, (deed.player, deed.frame, of.until))
            elif deed.player in found:
                found[deed.player] = *found[deed.player][:2], deed.frame
    return tuple(found.values())


def _lying(place: Place, thing: Thing) -> Aim:
    spot = place.at
    assert spot is not None
    return Aim(place.name, (spot.x, place.height + thing.size / 2.0, spot.z), place.width)


def aim_of(table: RuleTable, player: int, clip: int) -> Aim | None:
    """Return where a clip sends or puts the object; None if nothing says so."""
    name = table.aims.get((player, clip), "")
    if name in table.players:
        return Aim(name, width=_HEAD, player=table.players.index(name))
    place = table.places.get(name)
    if place is None or place.at is None:
        return None
    at = place.at.x, place.height, place.at.z
    return Aim(name, at, place.width, place.is_upright)


def _deeds(table: RuleTable, timeline: Timeline) -> Iterator[_Deed]:
    """Yield what is done with the object, in no order."""
    given: dict[tuple[int, int], tuple[int, int]] = {}
    for number, row in enumerate(table.rows):
        player, clip = int(row["player"]), int(row["first"])
        if row["kind"] != kinds.SYNCHRONISATION:
            continue
        if table.activity.deed(table.actions[player][clip]) == GIVE:
            # other actions may be linked with one that gives, such as an answer to it
            partner, theirs = int(row["partner"]), measure(table, number, timeline).partner_clip
            if table.activity.deed(table.actions[partner][theirs]) == TAKE:
                given[player, clip] = partner, theirs
    caught = set(given.values())
    for player, actions in enumerate(table.actions):
        for clip, action in enumerate(actions):
            deed, frame = table.activity.deed(action), int(timeline.instants[player][clip])
            if (player, clip) in given:
                partner, theirs = given[player, clip]
                arrives = int(timeline.instants[partner][theirs])
                yield _Deed(frame, player, clip, deed, partner, arrives)
            elif deed in (SEND, STRIKE, PUT) or (deed == TAKE and (player, clip) not in caught):
                yield _Deed(frame, player, clip, deed)


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
        if table.activity.deed(action) != BOUNCE or end - start < _SHORTEST:
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
    return clip + 1 < len(actions) and table.activity.deed(actions[clip + 1]) == BOUNCE


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
