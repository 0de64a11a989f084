"""Boxes that stand for what was not captured, for other programs: as JSON values, and as MJCF.

Both are in the world of the capture's file: metres, its own axis up.
"""

from __future__ import annotations

from collections.abc import Sequence
from xml.sax.saxutils import quoteattr

import numpy as np

from motiondb.body import rotation, world
from motiondb.records import Box, Finding


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
