"""Everything about one capture: what it needs, what is wrong with it, and what cannot be told.

Boxes that stand for what was not captured, for other programs: as JSON values, and as MJCF.

Both are in the world of the capture's file: metres, its own axis up.
"""

from __future__ import annotations

from collections.abc import Sequence
from xml.sax.saxutils import quoteattr

import numpy as np

from motiondb.body import rotation, world
from motiondb.quality.faults import faults
from motiondb.quality.measured import Measured, measure
from motiondb.quality.rates import LEAST_FLIGHTS, falls, flights, rate_finding, unit_findings
from motiondb.quality.supports import supports
from motiondb.records import Box, Finding, FloatArray, Quality

KEPT = 0.87
KEPT_WITH = {
    "falls": 0.28,
    "floats": 0.10,
    "frozen": 0.05,
    "gap": 0.50,
    "jumps": 0.38,
    "names": 0.04,
    "noise": 0.02,
    "rate": 0.13,
    "rest pose": 0.19,
    "seam": 0.14,
    "sinks": 0.45,
    "slides": 0.03,
    "swapped": 0.04,
    "through": 0.50,
    "unit": 0.01,
}
"""Probability that a second without findings, and with one, has no fault, where as many seconds
have one as not: benchmarks/capture_quality.py, which has no gaps and no limbs in the trunk. Things
that are needed do not lower it, nor does where the floor of the file is: one shift mends it."""


def assess(points: FloatArray, fps: float, has_toes: bool = True) -> Quality:
    """Say what a capture lacks, from its joints (frames, 21, 3), metres, y up, NaN where unseen."""
    m = measure(points, fps, has_toes)
    n_seconds = max(1, int(np.ceil(len(points) / fps - 1e-9)))
    if m is None:
        untold = ("cannot say anything: too few frames in which all joints have a place",)
        return Quality((), untold, np.full(n_seconds, 0.5), 0.0, ())
    found = unit_findings(m)
    flown = flights(m)
    if not found:
        rate = rate_finding(flown, m.n / m.fps, "the capture")
        found = supports(m) + faults(m) + ([rate] if rate else falls(m))
    found.sort(key=lambda each: (each.start, each.kind))
    numbers = np.array([_number(found, s) for s in range(n_seconds)])
    return Quality(tuple(found), _untold(m, flown), numbers, m.floor, flown)


def _untold(m: Measured, flown: tuple[tuple[float, float], ...]) -> tuple[str, ...]:
    out = []
    if not flown:
        out.append("cannot say whether the rate is right: no jump")
    elif len(flown) < LEAST_FLIGHTS:
        out.append(f"cannot say whether the rate is right: only {len(flown)} of 3 jumps")
    if m.fps < 50.0:
        out.append(
            "cannot say whether single joints jump for longer than a frame by less than "
            f"{40000 / m.fps**2:.0f} cm: {m.fps:g} frames a second"
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
