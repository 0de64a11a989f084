"""What a capture needs that was not captured: seats, steps, bars, ladders, walls, partners.

Two rules find the times. (a) Nothing is within 9 cm
of the floor for 0.45 s, or within 6 cm for 0.65 s, and the centre of mass
does not fall as a thrown body does. (b) Something is on the floor, but centre of mass and centre of
pressure both lie more than 7 cm outside the outline of what touches it, for 0.45 s and with a slow
pelvis. What the thing is follows part by part from what rests meanwhile: feet, seat, hands. Each
part's time is then as long as it stays where it rested.

The centre of pressure is that of a point mass: c = (x, z) - (y - floor) a / (g + a_y).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from motiondb.quality.measured import FEET, SOLES, Measured, P, joined, long_runs, times
from motiondb.records import FAULT, NEEDS, Box, Finding, FloatArray

G = 9.81
CLEAR, CLEAR_SECONDS = 0.09, 0.45
LOW, LOW_SECONDS = 0.06, 0.65
OUTSIDE, OUTSIDE_SECONDS, OUTSIDE_SPEED = 0.07, 0.45, 0.35
_FREE = 0.6  # Of g; a body that falls faster than this is thrown, not held
_NEAR = 0.08  # Of the floor, to be touching it
_OFF = 0.05  # Over the floor, where a foot rests that nothing in the capture holds
_REST = 0.25  # Seconds for which a part has to rest
_STAYS = 0.07  # Metres within which it stays where it rested
_FOOT_RESTS, _STEP_SECONDS = 0.15, 0.2
_HOLDS = 0.4
_CLIMBS = 0.12  # Metres that a body rises past a hand that holds
_STANDS = 0.12  # Metres a second of a foot that bears the body; one that swings is slow for less
_RUNS = 0.8
_UPRIGHT = 0.6
_SIT_ANGLE = 45.0
_ANGLES = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
_DIRECTIONS = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)])


@dataclass(frozen=True)
class _Held:
    """A part that rests on something."""

    start: int  # Frames
    end: int
    place: FloatArray  # (3,), m
    height: float  # Over the floor, m
    over: float = 0.0  # Of a hand over the neck, m
    swings: bool = False  # Whether feet move meanwhile
    lies: bool = False  # Whether the trunk is level

    @property
    def frames(self) -> int:
        """Number of frames."""
        return self.end - self.start


def supports(m: Measured) -> list[Finding]:
    """Everything that the capture needs, by its beginning."""
    raised = _raised(m)
    leaning = _leaning(m)
    spans = joined(raised + leaning, 0.5 * m.fps)
    found: list[Finding] = []
    for start, end in spans:
        aloft = any(a < end and b > start for a, b in raised)
        found += _of_span(m, start, end, aloft)
    return _merged(found)


def _raised(m: Measured) -> list[tuple[int, int]]:
    """Frames in which nothing is near the floor and the body does not fall."""
    high = long_runs(m.low > CLEAR * m.k, CLEAR_SECONDS * m.fps)
    high += long_runs(m.low > LOW * m.k, LOW_SECONDS * m.fps)
    out = []
    for a, b in joined(high, 0.0):
        t = np.arange(b - a) / m.fps
        free = 0.0
        if b - a < m.fps:
            free = -2.0 * float(np.polyfit(t, m.com[a:b, 1], 2)[0])
        if free <= _FREE * G and not m.missing[a:b].all():
            out.append((a, b))
    return out


def _leaning(m: Measured) -> list[tuple[int, int]]:
    """Frames in which the body would tip over."""
    tips = outside(m) > OUTSIDE * m.k
    slow = m.pelvis_speed < OUTSIDE_SPEED * m.k
    return long_runs(tips & slow & ~m.missing, OUTSIDE_SECONDS * m.fps)


def outside(m: Measured) -> FloatArray:
    """How far centre of mass and of pressure lie outside of what touches the floor (frames,), m."""
    step = max(1, int(m.fps / 20.0))
    at = np.arange(0, m.n, step)
    x, near = m.x[at], m.h[at] < _NEAR * m.k
    radius = np.full(x.shape[1], 0.06 * m.k)
    radius[FEET] = 0.045 * m.k
    points, touching = [x[..., [0, 2]]], [near]
    for s in "lr":  # the heel, behind the ankle
        ankle, tip = x[:, P[f"{s}_ankle"]][:, [0, 2]], x[:, P[f"{s}_tip"]][:, [0, 2]]
        ahead = tip - ankle
        ahead /= np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-6)
        points.append((ankle - 0.06 * m.k * ahead)[:, None])
        touching.append(near[:, [P[f"{s}_ankle"]]])
    radius = np.concatenate([radius, [0.045 * m.k] * 2])
    mask = np.concatenate(touching, axis=1)
    reach = np.concatenate(points, axis=1) @ _DIRECTIONS + radius[:, None]
    reach = np.where(mask[..., None], reach, -np.inf).max(axis=1)
    com, _, accel = (part[at] for part in m.com_fit)
    mass = com[:, [0, 2]]
    lift = (com[:, 1:2] - m.floor) / np.maximum(G + accel[:, 1:2], 3.0)
    shift = -lift * accel[:, [0, 2]]
    pressure = np.where(np.linalg.norm(shift, axis=1, keepdims=True) < 0.5, mass + shift, mass)
    out = np.minimum(
        (mass @ _DIRECTIONS - reach).max(axis=1), (pressure @ _DIRECTIONS - reach).max(axis=1)
    )
    out = np.where(mask.any(axis=1), np.maximum(out, 0.0), 0.0)
    return np.repeat(out, step)[: m.n]


def _of_span(m: Measured, start: int, end: int, aloft: bool) -> list[Finding]:
    """One finding a body part that something holds between two frames."""
    seat = _seat(m, start, end, aloft)
    hands = _hands(m, start, end, seat) if aloft else []
    bearing = [*([seat] if seat else []), *(h for h in hands if _hangs(m, h))]
    feet = _feet(m, start, end, bearing) if aloft else []
    if aloft and not (feet or seat or hands):
        feet = _trodden(m, start, end)
    out = [_on_feet(m, feet, hands)] if feet else []
    out += [_sits(m, seat)] if seat else []
    out += [_by_hands(m, hands)] if hands else []
    return out or [_held(m, start, end, aloft)]


def _hangs(m: Measured, hand: _Held) -> bool:
    """Whether a hand holds the body while feet swing below."""
    return hand.swings and hand.over > 0.10 * m.k


def _feet(m: Measured, start: int, end: int, bearing: list[_Held]) -> list[_Held]:
    """Where a foot rests over the floor while no other part bears the body, lowest first."""
    out: list[_Held] = []
    bears = np.ones(end - start, dtype=np.bool_)
    for other in bearing:
        bears[max(0, other.start - start) : max(0, other.end - start)] = False
    for s in "lr":
        h = m.h[start:end, [P[f"{s}_toe"], P[f"{s}_ankle"]]].min(axis=1)
        still = m.rests[start:end, P[f"{s}_toe"]] & (h > _OFF * m.k) & bears
        for a, b in long_runs(still, _FOOT_RESTS * m.fps):
            place = np.median(m.x[start + a : start + b, P[f"{s}_toe"]], axis=0)
            height = float(np.median(h[a:b]))
            out.append(_Held(start + a, start + b, place, height))
    return sorted(out, key=lambda each: each.height)


def _trodden(m: Measured, start: int, end: int) -> list[_Held]:
    """Where a foot of a body that runs on is slowest, if it is slow for a moment."""
    soles = m.speed[start:end][:, SOLES]
    if m.pelvis_speed[start:end].min() < _RUNS * m.k:
        return []
    frame, foot = np.unravel_index(int(soles.argmin()), soles.shape)
    if soles[frame, foot] > 0.5 * m.pelvis_speed[start + frame]:
        return []
    at = start + int(frame)
    return [_Held(start, end, m.x[at, SOLES[foot]], float(m.h[at, SOLES].min()))]


def _seat(m: Measured, start: int, end: int, aloft: bool) -> _Held | None:
    """The longest time for which hips rest with raised thighs."""
    hips = [P["l_hip"], P["r_hip"]]
    still = (m.pelvis_speed < 0.3 * m.k) & (m.thigh > _SIT_ANGLE)
    still &= m.h[:, hips].min(axis=1) > _NEAR * m.k
    if not aloft:
        still &= m.upright > _UPRIGHT
    spans = long_runs(still[start:end], _REST * m.fps)
    if not spans:
        return None
    a, b = (start + edge for edge in max(spans, key=lambda span: span[1] - span[0]))
    middle = m.x[:, hips].mean(axis=1)
    place = np.median(middle[a:b], axis=0)
    height = float(np.median(m.h[a:b][:, hips].min(axis=1)))
    lies = float(np.median(m.upright[a:b])) < 0.4
    a, b = _while_there(middle, place, a, b)
    return _Held(a, b, place, height, lies=lies)


def _while_there(x: FloatArray, place: FloatArray, start: int, end: int) -> tuple[int, int]:
    """The interval around frames start to end for which x (frames, 3) stays at a place."""
    away = np.linalg.norm(x - place, axis=1) > _STAYS
    middle = (start + end) // 2
    before, after = np.flatnonzero(away[:start]), np.flatnonzero(away[max(end, middle) :])
    first = int(before[-1]) + 1 if len(before) else 0
    return first, max(end, middle) + int(after[0]) if len(after) else len(x)


def _hands(m: Measured, start: int, end: int, seat: _Held | None) -> list[_Held]:
    """Hands that stay at a place over the floor while the body moves, or hangs below."""
    out: list[_Held] = []
    for s in "lr":
        hand = P[f"{s}_hand"]
        own = [P[f"{side}_{name}"] for side in "lr" for name in ("hip", "knee")]
        away = np.linalg.norm(m.x[start:end, own] - m.x[start:end, hand, None], axis=2).min(axis=1)
        still = m.rests[start:end, hand] & (m.h[start:end, hand] > 0.5 * m.leg)
        still &= away > 0.2 * m.k
        for a, b in long_runs(still, _REST * m.fps):
            a, b = start + a, start + b
            place = np.median(m.x[a:b, hand], axis=0)
            over = float(np.median(m.x[a:b, hand, 1] - m.at("neck")[a:b, 1]))
            sits = seat is not None and a < seat.end and b > seat.start
            moves = b - a > _HOLDS * m.fps and np.ptp(m.com[a:b], axis=0).max() > 0.12 * m.k
            swings = not sits and (m.rests[a:b, FEET].any(axis=1).mean() < 0.5 or _sways(m, a, b))
            if (moves and not sits) or (over > 0.10 * m.k and (swings or sits)):
                out.append(_Held(a, b, place, float(place[1] - m.floor), over, swings))
    return out


def _sways(m: Measured, start: int, end: int) -> bool:
    """Whether no foot stands for a moment, and the body does not climb past a hand that holds."""
    stands = np.asarray((m.speed[start:end, FEET] < _STANDS * m.k).any(axis=1))
    level = np.ptp(m.com[start:end, 1]) < _CLIMBS * m.k
    return bool(
        level and end - start > 2 * _HOLDS * m.fps and not long_runs(stands, _HOLDS * m.fps)
    )


def _heights(m: Measured, feet: list[_Held]) -> list[list[_Held]]:
    """Places of feet by height: those that lie within 9 cm are one."""
    groups = [[each] for each in feet]
    while len(groups) > 1:
        gaps = [_level(b) - _level(a) for a, b in pairwise(groups)]
        at = int(np.argmin(gaps))
        if gaps[at] > 0.09 * m.k:
            break
        groups[at : at + 2] = [groups[at] + groups[at + 1]]
    long = [g for g in groups if sum(f.frames for f in g) >= _STEP_SECONDS * m.fps]
    return long or groups[-1:]


def _level(feet: list[_Held]) -> float:
    """Mean height of places of feet, by how long they rest."""
    return float(np.average([f.height for f in feet], weights=[f.frames for f in feet]))


def _on_feet(m: Measured, feet: list[_Held], hands: list[_Held]) -> Finding:
    """The finding that feet stand over the floor."""
    groups = _heights(m, feet)
    levels = [_level(group) for group in groups]
    start, end = min(f.start for f in feet), max(f.end for f in feet)
    top = groups[-1]
    kind, said = "stands on", f"stands on something {_cm(levels[0])} high"
    if len(levels) > 1:
        kind = "ladder" if _is_steep(groups) and hands else "steps"
        heights = ", ".join(f"{100 * y:.0f}" for y in levels)
        said = f"climbs {'rungs' if kind == 'ladder' else 'steps'} {heights} cm high"
    elif _rises_whole(m, start, levels[0]) or _rises_whole(m, end, -levels[0]):
        kind, said = "floats", f"floats {_cm(levels[0])} over the floor"
        return _finding(m, kind, said, (start, end), levels[0], "feet", top[0].place, (), FAULT)
    boxes = tuple(_step(m, group) for group in groups)
    return _finding(m, kind, said, (start, end), levels[-1], "feet", top[0].place, boxes)


def _step(m: Measured, feet: list[_Held]) -> Box:
    """A box under places of feet of one height; those of the place where they rest longest."""
    longest = max(feet, key=lambda each: each.frames).place
    places = np.array([f.place for f in feet if np.hypot(*(f.place - longest)[[0, 2]]) < 0.6 * m.k])
    size = np.maximum(np.ptp(places, axis=0)[[0, 2]], 0.1) + 0.2 * m.k
    return _box(m, (places.min(axis=0) + places.max(axis=0)) / 2.0, _level(feet), size)


def _is_steep(groups: list[list[_Held]]) -> bool:
    """Whether levels rise by more than they go on, as rungs do."""
    low, high = groups[0][0].place, groups[-1][-1].place
    return bool(high[1] - low[1] > np.hypot(*(high - low)[[0, 2]]))


def _rises_whole(m: Measured, frame: int, height: float) -> bool:
    """Whether feet and pelvis rise alike by a height around a frame, in 0.2 s."""
    half = max(1, round(0.15 * m.fps))
    a, b = max(0, frame - half), min(m.n - 1, frame + half)
    rise = (
        m.x[b, [P["l_toe"], P["r_toe"], P["l_hip"]], 1]
        - m.x[a, [P["l_toe"], P["r_toe"], P["l_hip"]], 1]
    )
    return bool((rise / height > 0.6).all() and (rise / height < 1.4).all()) and abs(height) < 0.3


def _sits(m: Measured, seat: _Held) -> Finding:
    """The finding that the seat rests on something."""
    box = _box(m, seat.place, seat.height, np.array([0.42, 0.42]) * max(m.k, 0.7))
    kind = "lies" if seat.lies else "sits"
    said = f"{kind} on something {_cm(seat.height)} high"
    return _finding(m, kind, said, (seat.start, seat.end), seat.height, "seat", seat.place, (box,))


def _by_hands(m: Measured, hands: list[_Held]) -> Finding:
    """The finding that hands hold on to something."""
    start, end = min(h.start for h in hands), max(h.end for h in hands)
    hanging = [h for h in hands if _hangs(m, h)]
    shown = hanging or hands
    best = max(shown, key=lambda h: h.frames)
    if hanging:
        kind, said = "hangs", f"hangs at {best.height:.2f} m"
        start, end = min(h.start for h in hanging), max(h.end for h in hanging)
    else:
        kind, said = "holds", f"holds on to something at {best.height:.2f} m"
    x, y, z = (float(c) for c in best.place)
    box = Box((x, y, z), (0.6, 0.05, 0.6) if kind == "holds" else (0.8, 0.05, 0.8))
    return _finding(m, kind, said, (start, end), best.height, "hands", best.place, (box,))


def _held(m: Measured, start: int, end: int, aloft: bool) -> Finding:
    """The finding that something holds the body, and no part says what."""
    pelvis = np.median(m.points[start:end, 0], axis=0)
    if aloft:
        height = float(np.median(m.low[start:end]))
        said = f"is held {_cm(height)} over the floor by something or somebody, or floats"
        return _finding(m, "held", said, (start, end), height, "body", pelvis)
    out = float(outside(m)[start:end].mean())
    said = f"leans on something or somebody, {_cm(out)} out of balance"
    return _finding(m, "leans", said, (start, end), out, "body", pelvis)


def _box(m: Measured, place: FloatArray, height: float, size: FloatArray) -> Box:
    """A box from the floor to a height, around a place (3,); its sizes along x and z."""
    centre = (float(place[0]), m.floor + height / 2.0, float(place[2]))
    return Box(centre, (float(size[0]), height, float(size[1])))


def _finding(  # noqa: PLR0913  the fields of a finding
    m: Measured,
    kind: str,
    said: str,
    frames: tuple[int, int],
    measure: float,
    part: str,
    place: FloatArray,
    boxes: tuple[Box, ...] = (),
    family: str = NEEDS,
) -> Finding:
    """A finding between two frames."""
    x, y, z = (float(c) for c in place)
    threshold = (OUTSIDE if kind == "leans" else CLEAR) * m.k
    span = frames[0] / m.fps, frames[1] / m.fps
    said = f"{said}, {times(*span)}"
    return Finding(kind, family, *span, measure, "m", threshold, part, said, (x, y, z), boxes)


def _merged(found: list[Finding]) -> list[Finding]:
    """Join findings of one kind that overlap or follow at once, at one height."""
    out: list[Finding] = []
    for each in sorted(found, key=lambda f: (f.kind, f.start)):
        last = out[-1] if out else None
        same = last is not None and last.kind == each.kind and last.part == each.part
        if (
            last is not None
            and same
            and each.start - last.end < 0.5
            and abs(each.measure - last.measure) < 0.07
        ):
            a, b = last.start, max(last.end, each.end)
            said = f"{last.sentence.rsplit(', ', 1)[0]}, {times(a, b)}"
            out[-1] = replace(last, end=b, sentence=said)
        else:
            out.append(each)
    return sorted(out, key=lambda f: f.start)


def _cm(metres: float) -> str:
    return f"{100.0 * metres:.0f} cm"
