"""Guards whose acts are over go with whom they guard, instead of standing where these ended.

A distance for guarding is a rule of the action that guards. Somebody who was screened and of whom
nothing more is drawn breaks no rule by standing while the other runs away. So, as a rest, they take
steps of the actions that the grammar gives them unasked, found by a beam search in the finished
scene, in which everybody else is where they are shown. A string of clips costs

    seams + _CLIP for each + frames out of the bounds / _OUTSIDE + turns away from the other

as if the guard stood after it to the end of the scene; to stand at once is the shortest string.
Nobody is touched, and where a rule of somebody else would fail, the guard stands.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.records import FloatArray, IntArray
from motiondb.scene.clips.clip_cutting import compose
from motiondb.scene.clips.clips import ClipLibrary
from motiondb.scene.energy.binding import RuleTable
from motiondb.scene.polish.path_editing import COMFORT
from motiondb.scene.timing.playing import AT_REST
from motiondb.scene.timing.timeline import guard_bounds, guarded

_OUTSIDE = 5.0  # Frames out of the bounds that cost as much as a seam of 10 cm. Chosen by hand
_CLIP = 0.2  # Cost of a clip
_CATCH_UP = 12.0  # Frames in which somebody catches up with a metre: 2.5 m/s
_INSIDE = 0.3  # Metres by which a guard aims inside the bounds, for the other goes on
_ASIDE = np.radians(60.0)  # A turn away from the other that costs 1 at the end, and while guarding
_MOVING = 2.0  # Cost of standing still in the middle of a step
_CELL = np.array([0.3, 0.3, 0.8])  # Places, m and rad, that count as alike
_BEAM, _TRIED, _SORTED, _MOST = 8, 16, 1500, 16
"""Strings kept, continuations of each that are looked at frame by frame, those of which these are
chosen, and most clips."""


@dataclass(frozen=True, eq=False)
class _String:
    """Clips behind a guard's acts: entries, cost, cost if it ends here, where and when it ends."""

    entries: tuple[int, ...]
    cost: float
    ending: float
    place: FloatArray  # (3,), m and rad
    frame: int

    @property
    def total(self) -> float:
        """The cost of the string if nothing follows."""
        return self.cost + self.ending


@dataclass(frozen=True, eq=False)
class _Chase:
    """Whom a guard follows, and with what."""

    library: ClipLibrary
    last: int  # The entry that the string begins behind
    entries: IntArray  # (n,), int: entries to choose from
    guards: NDArray[np.bool_]  # (n,), bool: whether each is of an action that attends to the other
    bounds: tuple[float, float]
    target: FloatArray  # (frames, 2), m: where the other is shown
    others: FloatArray  # (players, frames, 2), m: where all others are shown
    clear: FloatArray  # (players,), m: how far from each the guard stays

    @property
    def end(self) -> int:
        """The frames of the scene."""
        return len(self.target)

    def outside(self, places: FloatArray, frames: IntArray, inside: float = 0.0) -> FloatArray:
        """Return how far places (n, 2) are out of the bounds at frames of the scene, m."""
        apart = np.linalg.norm(places - self.target[frames], axis=1)
        near, far = self.bounds
        inside = min(inside, (far - near) / 4.0)
        return np.asarray(np.maximum(np.maximum(near + inside - apart, apart - far + inside), 0.0))

    def aside(self, place: FloatArray, frames: IntArray) -> FloatArray:
        """Return the turns of places (n, 3) away from the other at frames, in units of _ASIDE."""
        away = self.target[frames] - place[:, :2]
        off = place[:, 2] - np.arctan2(away[:, 0], away[:, 1])
        return np.asarray(np.abs(np.mod(off + np.pi, 2.0 * np.pi) - np.pi) / _ASIDE)

    def ending(self, entry: int, place: FloatArray, frame: int, moved: bool) -> float:
        """Return the cost of standing at a place from a frame to the end of the scene."""
        left = np.arange(min(frame, self.end), self.end)
        cost = float((self.outside(place[None, :2], left) > 0.0).sum()) / _OUTSIDE
        if moved:
            cost += float(self.aside(place[None], np.array([min(frame, self.end - 1)]))[0])
            rest = self.library.rest
            stops = len(rest) > 0 and rest[self.library.seam_class[entry], 1] > AT_REST
            cost += _MOVING * bool(stops)
        return cost


def chase(
    library: ClipLibrary,
    table: RuleTable,
    player: int,
    entries: IntArray,
    places: FloatArray,
    since: int,
) -> tuple[int, ...]:
    """Return the clips with which a guard follows whom they guard from a frame on; () for none.

    Shapes: `entries` (actions,); `places` (players, frames, 3), m and rad.
    """
    target, bounds = guarded(table, player), guard_bounds(table)
    if target < 0 or bounds is None or since >= places.shape[1]:
        return ()
    plain = np.array([one.stretch == 1.0 for one in library.source])
    plain &= np.asarray(library.event_frame) < 0
    names = [name for name in table.unasked[player] if name in library.terminals]
    some = [np.arange(library.of(n).start, library.of(n).stop) for n in names]
    some = [one[plain[one]] for one in some]
    follows = [np.full(len(one), table.activity.follows(n)) for n, one in zip(names, some)]
    others = np.delete(places, player, axis=0)[:, :, :2]
    here = places[player, since]
    apart = np.linalg.norm(others[:, since] - here[:2], axis=1)
    one = _Chase(
        library,
        int(entries[-1]),
        np.concatenate([np.zeros(0, np.int64), *some]),
        np.concatenate([np.zeros(0, bool), *follows]),
        bounds,
        places[target, :, :2],
        others,
        np.minimum(apart - 0.02, 2.0 * COMFORT),
    )
    return _search(one, here, since) if len(one.entries) else ()


def _search(one: _Chase, here: FloatArray, since: int) -> tuple[int, ...]:
    """Return the entries of the cheapest string from a place and a frame on."""
    best = _String((), 0.0, one.ending(one.last, here, since, False), here, since)
    beam = [best] if best.total > 0.0 else []
    while beam and len(beam[0].entries) < _MOST:
        grown = [new for each in beam for new in _grown(one, each)]
        best = min([best, *grown], key=lambda each: each.total)
        beam = _spread(one, [each for each in grown if each.cost < best.total])
    return best.entries


def _spread(one: _Chase, grown: Sequence[_String]) -> list[_String]:
    """Return the strings that look best, of those that end at about the same place one."""

    def looks(each: _String) -> float:
        frame = np.array([min(each.frame, one.end - 1)])
        metres = float(one.outside(each.place[None, :2], frame)[0])
        left = min(metres * _CATCH_UP, one.end - each.frame)
        return each.cost + min(left / _OUTSIDE, each.ending)

    kept: dict[tuple[int, ...], _String] = {}
    for each in sorted(grown, key=looks):
        x, z, theta = np.rint(each.place / _CELL).astype(int).tolist()
        kept.setdefault((x, z, theta, each.frame // 15), each)
        if len(kept) == _BEAM:
            break
    return list(kept.values())


def _grown(one: _Chase, since: _String) -> list[_String]:
    """Return a string with one more clip each, those that look best."""
    library, entries = one.library, one.entries
    kinds = np.asarray(library.seam_class)
    before = kinds[since.entries[-1] if since.entries else one.last]
    seams = np.asarray(library.seam)[before, kinds[entries]].astype(float)
    steps = np.asarray(library.step, dtype=float)[entries]
    ends = compose(since.place, steps)
    lasts = np.asarray(library.n_frames)[entries].astype(np.int64)
    frames = since.frame + lasts
    fits = frames < one.end
    at = np.minimum(frames, one.end - 1)
    off = one.outside(ends[:, :2], at, _INSIDE)
    look = seams + np.where(off > 0.0, off * _CATCH_UP + lasts, 0.0) / _OUTSIDE
    look[~fits | _in_the_way(one, since, ends, at)] = np.inf
    turned = look + one.aside(ends, at)
    turned[one.guards] -= 0.5
    tried = {k for each in (look, turned) for k in _unlike(each, ends)}
    new = (_with(one, since, k, float(seams[k])) for k in sorted(tried) if np.isfinite(look[k]))
    return [each for each in new if each is not None]


def _unlike(costs: FloatArray, ends: FloatArray) -> list[int]:
    """Return the clips (n,) of least cost, one of those that end (n, 3) alike."""
    some = (
        np.argpartition(costs, _SORTED)[:_SORTED] if len(costs) > _SORTED else np.arange(len(costs))
    )
    order = some[np.argsort(costs[some])]
    cells = np.rint(ends[order] / _CELL).astype(np.int64) @ (1, 10_000, 100_000_000)
    firsts = np.unique(cells, return_index=True)[1]
    return [int(k) for k in order[np.sort(firsts)[:_TRIED]]]


def _in_the_way(
    one: _Chase, since: _String, ends: FloatArray, frames: IntArray
) -> NDArray[np.bool_]:
    """Return whether somebody stands at the ends (n, 3) or half way to them: array (n,)."""
    touched = np.zeros(len(ends), dtype=bool)
    for share in (0.5, 1.0):
        at = since.place[:2] + share * (ends[:, :2] - since.place[:2])
        when = (since.frame + share * (frames - since.frame)).astype(np.int64)
        for other, clear in zip(one.others, one.clear, strict=True):
            touched |= np.linalg.norm(at - other[when], axis=1) < clear
    return touched


def _with(one: _Chase, since: _String, k: int, seam: float) -> _String | None:
    """Return a string with one more clip, looked at in all its frames; None if it touches."""
    entry = int(one.entries[k])
    places = compose(since.place, one.library.path_of(entry))
    frames = since.frame + np.arange(len(places))
    away = np.linalg.norm(one.others[:, frames] - places[None, :, :2], axis=2)
    if (away < one.clear[:, None]).any():
        return None
    cost = since.cost + seam + _CLIP
    cost += float((one.outside(places[:, :2], frames) > 0.0).sum()) / _OUTSIDE
    if one.guards[k]:
        cost += float(one.aside(places, frames).mean())
    place = compose(since.place, np.asarray(one.library.step, dtype=float)[entry])
    frame = since.frame + len(places)
    ending = one.ending(entry, place, frame, True)
    return _String((*since.entries, entry), cost, ending, place, frame)
