"""Everything about one capture: what it needs, what is wrong with it, and what cannot be told.

Boxes that stand for what was not captured are written for other programs as JSON values and as
MJCF, in the world of the capture's file: metres, its own axis up.

Whether unit and rate are as the file says: flights show gravity, legs show the unit. In flight the
centre of mass falls with g = 9.81 m/s2. A file that plays at the speed s shows s^2 g, one whose
lengths are times u shows u g. One flight is not enough: toes that point, and parts that were not
captured, fool it. At least three flights that agree are.
"""

from __future__ import annotations

from collections.abc import Sequence
from xml.sax.saxutils import quoteattr

import numpy as np

from motiondb.body import rotation, world
from motiondb.body.features import runs
from motiondb.quality.faults import faults
from motiondb.quality.measured import LEAST_FRAMES, MOST_FPS, Measured, measure
from motiondb.quality.supports import supports
from motiondb.records import FILE, Box, Finding, FloatArray, Quality

KEPT = 0.86
KEPT_WITH = {
    "bends": 0.05,
    "falls": 0.28,
    "floats": 0.13,
    "frozen": 0.07,
    "gap": 0.50,
    "jumps": 0.39,
    "names": 0.03,
    "noise": 0.15,
    "rate": 0.13,
    "rest pose": 0.23,
    "seam": 0.13,
    "sinks": 0.38,
    "slides": 0.03,
    "swapped": 0.05,
    "through": 0.50,
    "unit": 0.02,
}
"""Probability that a second without findings, and with one, has no fault, where as many seconds
have one as not: benchmarks/capture_quality.py, which has no gaps and no limbs in the trunk. Things
that are needed do not lower it, nor does where the floor of the file is: one shift mends it."""


BREAK, BESIDE_BREAK = 0.2, 0.2
"""Metres by which a leg jumps that is in a wrong place before or after it; seconds around it."""
_LEG = ("hip", "knee", "ankle", "toe")


def assess(points: FloatArray, fps: float, has_toes: bool = True) -> Quality:
    """Say what a capture lacks, from its joints (frames, 21, 3), metres, y up, NaN where unseen."""
    m = measure(points, fps, has_toes)
    n_seconds = max(1, int(np.ceil(len(points) / fps - 1e-9)))
    if m is None:
        reason = "some joints never have a place, or not all at once"
        if len(points) / max(1, round(fps / MOST_FPS)) < LEAST_FRAMES:
            reason = f"too few frames, {len(points)}"
        return Quality((), (f"cannot say anything: {reason}",), np.full(n_seconds, 0.5), 0.0, ())
    found, doubted = unit_findings(m), dict[Finding, Finding]()
    flown = flights(m)
    if not found:
        rate = rate_finding(flown, m.n / m.fps, "the capture")
        needs = supports(m)
        every = faults(m)
        doubted = {need: by for need in needs if (by := _breaks(need, every))}
        needs = [need for need in needs if need not in doubted]
        stands = any(each.part == "feet" for each in needs)
        wrong = [each for each in every if not (stands and each.kind == "floor tilts")]
        found = needs + wrong + ([rate] if rate else falls(m))
    found.sort(key=lambda each: (each.start, each.kind))
    numbers = np.array([_number(found, s) for s in range(n_seconds)])
    open_ = [f"cannot say that it {need.sentence}: {by.sentence}" for need, by in doubted.items()]
    return Quality(tuple(found), (*_untold(m, flown), *open_), numbers, m.floor, flown)


def _breaks(need: Finding, faults: Sequence[Finding]) -> Finding | None:
    """The jump of a leg with which something that is needed begins or ends.

    A leg in a wrong place stands on nothing; a body that is cut from a seat did sit.
    """
    for fault in faults:
        low, high = fault.start - BESIDE_BREAK, fault.end + BESIDE_BREAK
        jumps = fault.kind == "jumps" and fault.part.endswith(_LEG) and fault.measure >= BREAK
        if jumps and (low <= need.start <= high or low <= need.end <= high):
            return fault
    return None


def _untold(m: Measured, flown: tuple[tuple[float, float], ...]) -> tuple[str, ...]:
    out = []
    if not flown:
        out.append("cannot say whether the rate is right: no jump")
    elif len(flown) < LEAST_FLIGHTS:
        out.append(f"cannot say whether the rate is right: only {len(flown)} of 3 jumps")
    if m.fps < 50.0:
        out.append(
            f"cannot say whether limbs turn at once by less than {40000 / m.fps**2:.0f} cm, or the "
            f"body jumps by less than {10000 / m.fps**2:.0f} cm: {m.fps:g} frames a second"
        )
    if abs(m.floor) >= 0.25:
        out.append("cannot say whether the whole capture floats: the floor is not at height 0")
    return tuple(out)


def _number(found: list[Finding], second: int) -> float:
    """The number of a second: the smallest of its findings."""
    kinds = {f.kind for f in found if f.start < second + 1 and f.end > second}
    return min((KEPT_WITH[kind] for kind in kinds if kind in KEPT_WITH), default=KEPT)


def turned(box: Box, up: str) -> Box:
    """A box of a world with y up, in the world in which another axis is up.

    >>> turned(Box((1.0, 0.2, 3.0), (0.4, 0.4, 0.5)), "z").centre
    (1.0, -3.0, 0.2)
    """
    back = rotation.conjugate(world.to_y_up(up))
    x, y, z = rotation.rotate(back, np.array(box.centre)).round(6).tolist()
    a, b, c = np.abs(rotation.rotate(back, np.array(box.size))).round(6).tolist()
    return Box((x, y, z), (a, b, c))


def to_values(findings: Sequence[Finding], up: str) -> list[dict[str, object]]:
    """Every box with what it is and when, as values of JSON."""
    return [
        {
            "kind": f.kind,
            "start": round(f.start, 3),
            "end": round(f.end, 3),
            "sentence": f.sentence,
            "centre": list(box.centre),
            "size": list(box.size),
        }
        for f in findings
        for box in (turned(each, up) for each in f.boxes)
    ]


def to_mjcf(findings: Sequence[Finding], up: str, name: str) -> str:
    """The boxes as fixed geoms of an MJCF model, whose sizes are half lengths."""
    lines = ["<!-- written by motiondb -->", f"<mujoco model={quoteattr(name)}>", "  <worldbody>"]
    for number, (each, room) in enumerate((f, box) for f in findings for box in f.boxes):
        box = turned(room, up)
        place = " ".join(f"{c:.4f}" for c in box.centre)
        half = " ".join(f"{c / 2.0:.4f}" for c in box.size)
        lines.append(f"    <!-- {each.sentence.replace('--', '-')} -->")
        lines.append(
            f'    <geom name="{each.kind.replace(" ", "_")}_{number}" type="box" '
            f'pos="{place}" size="{half}" rgba="0.9 0.7 0.5 0.6"/>'
        )
    return "\n".join([*lines, "  </worldbody>", "</mujoco>", ""])


G = 9.81
LEGS = (0.40, 1.2)  # Metres: children of two years to the tallest
RATES = (0.80, 1.25)  # Speeds that flights do not tell from 1
LEAST_FLIGHTS = 3
_CLEAR, _FLIGHT_SECONDS = 0.05, 0.07
_AGREE = 0.15
FALLS = 1.7  # Of g; of 561 real captures none reaches 1.4 in more than a hundredth of its frames
_UNITS = {
    "millimetres read as metres": 1000.0,
    "centimetres read as metres": 100.0,
    "inches read as metres": 39.37,
    "millimetres read as centimetres": 10.0,
    "feet read as metres": 3.281,
    "centimetres read as inches": 2.54,
    "inches read as centimetres": 1.0 / 2.54,
    "metres read as feet": 0.3048,
    "centimetres read as millimetres": 0.1,
    "metres read as inches": 0.0254,
    "metres read as centimetres": 0.01,
    "metres read as millimetres": 0.001,
}


def unit_findings(m: Measured) -> list[Finding]:
    """That the legs have no length of a person's, with the nearest confusion of units."""
    if LEGS[0] <= m.leg <= LEGS[1]:
        return []
    name, factor = min(_UNITS.items(), key=lambda row: abs(np.log(m.leg / row[1] / 0.85)))
    bound = LEGS[0] if m.leg < LEGS[0] else LEGS[1]
    words = f"legs are {m.leg:.3g} m long, as of {name}: lengths are {factor:.3g} times too large"
    seconds = m.n / m.fps
    return [Finding("unit", FILE, 0.0, seconds, m.leg, "m", bound, "body", words)]


def flights(m: Measured) -> tuple[tuple[float, float], ...]:
    """Gravity (m/s2) and its standard error of every flight that can be believed.

    It rises and falls, nothing rests meanwhile, and a parabola fits it.
    """
    out = []
    for start, end in runs(m.low > _CLEAR * m.k):
        a, b = start + 1, end - 1
        n = b - a
        if n < max(5.0, _FLIGHT_SECONDS * m.fps) or start == 0 or end == m.n:
            continue
        t = np.arange(n) / m.fps
        t -= t.mean()
        design = np.stack([np.ones(n), t, -t * t / 2.0], axis=1)
        fit, *_ = np.linalg.lstsq(design, m.com[a:b], rcond=None)
        left = m.com[a:b, 1] - design @ fit[:, 1]
        spread = float(np.sqrt((left**2).sum() / max(1, n - 3)))
        error = float(np.sqrt(np.linalg.inv(design.T @ design)[2, 2])) * max(spread, 0.001)
        path = float(np.ptp(m.x[a:b], axis=0).max(axis=-1).min())
        g = float(fit[2, 1])
        rises = m.com_fit[1][a, 1] > 0.0 > m.com_fit[1][b - 1, 1]
        fits = error < 0.35 * abs(g) and spread < 0.012 * m.k
        if g > 0.0 and rises and fits and path > 0.03 * m.k and not m.missing[a:b].any():
            out.append((g, error))
    return tuple(out)


def speed_of(rows: Sequence[tuple[float, float]]) -> tuple[float, float] | None:
    """The speed at which flights play, and how far it may be wrong; None if they do not agree.

    The speed is the square root of a gravity over g; the one is taken that most others agree with
    within 15 %, and these have to be at least three and more than half.

    >>> speed_of([(9.7, 0.2), (9.9, 0.2), (9.8, 0.3)])[0] > 0.98
    True
    >>> speed_of([(9.7, 0.2), (9.9, 0.2)]) is None
    True
    """
    if len(rows) < LEAST_FLIGHTS:
        return None
    logs = 0.5 * np.log(np.array([g for g, _ in rows]) / G)
    errors = np.array([max(0.03, 0.5 * error / g) for g, error in rows])
    near = np.abs(logs[:, None] - logs) < _AGREE
    centre = int(near.sum(axis=1).argmax())
    agree = near[centre]
    if agree.sum() < LEAST_FLIGHTS or 2 * agree.sum() <= len(rows):
        return None
    middle = float(np.average(logs[agree], weights=errors[agree] ** -2.0))
    spread = max(float(logs[agree].std()), 0.02) / np.sqrt(agree.sum())
    return float(np.exp(middle)), float(np.exp(middle) * spread)


def rate_finding(rows: Sequence[tuple[float, float]], seconds: float, whose: str) -> Finding | None:
    """That flights fall too fast or too slowly, with the factor; None if not, or if unknown."""
    found = speed_of(rows)
    if found is None or RATES[0] <= found[0] <= RATES[1]:
        return None
    speed, _ = found
    g = G * speed**2
    words = (
        f"{whose} plays at {speed:.2g} times its speed, or its lengths are {speed**2:.2g} times "
        f"what they were: {len(rows)} flights fall with {g:.1f} m/s2"
    )
    bound = RATES[0] if speed < 1.0 else RATES[1]
    return Finding("rate", FILE, 0.0, seconds, speed, "times", bound, "body", words)


def falls(m: Measured) -> list[Finding]:
    """That the centre of mass falls faster than gravity lets it."""
    if m.n < m.fps / 2.0:
        return []
    pull = float(np.percentile(-m.com_fit[2][:, 1], 99)) / G
    if pull < FALLS:
        return []
    words = f"the body falls with {pull * G:.0f} m/s2, faster than it can: is the rate too high?"
    return [Finding("falls", FILE, 0.0, m.n / m.fps, pull * G, "m/s2", FALLS * G, "body", words)]


def performer_rate(
    rows: Sequence[tuple[float, float]], whose: str
) -> tuple[float | None, float | None, str]:
    """The speed at which somebody's captures play, how far it may be wrong, and a sentence."""
    found = speed_of(rows)
    if found is None:
        reason = "no jump" if not rows else f"{len(rows)} jumps that do not agree"
        if 0 < len(rows) < LEAST_FLIGHTS:
            reason = f"only {len(rows)} of 3 jumps"
        return None, None, f"cannot say whether the rate of {whose!r} is right: {reason}"
    said = rate_finding(rows, 0.0, repr(whose))
    if said is not None:
        return *found, said.sentence
    g = G * found[0] ** 2
    return *found, f"the rate of {whose!r} is right: {len(rows)} jumps fall with {g:.1f} m/s2"
