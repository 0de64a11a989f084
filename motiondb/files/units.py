"""Names of length units, and skeletons in another one."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

from motiondb.body.world import UNITS
from motiondb.errors import CaptureError
from motiondb.files.text import number, quoted
from motiondb.records import Skeleton

_OTHER_NAMES = MappingProxyType({"in": "inch", "inches": "inch", "metre": "m", "meter": "m"})


def unit_from_name(name: str) -> float:
    """Return the metres per unit of a name or a number.

    Raises
    ------
    CaptureError
        If it is neither a known name nor a positive number.

    >>> unit_from_name("cm"), unit_from_name("0.5")
    (0.01, 0.5)
    """
    key = _OTHER_NAMES.get(name.lower(), name.lower())
    if key in UNITS:
        return UNITS[key]
    value = number(name.strip())
    if value is None or value <= 0:
        known = ", ".join(UNITS)
        raise CaptureError(
            "unit",
            f"expected one of {known} or a number of metres, found {quoted(name)}. Give one.",
        )
    return value


def scaled(skeleton: Skeleton, factor: float) -> Skeleton:
    """Return a skeleton whose offsets and end sites are multiplied by a factor."""
    return replace(
        skeleton,
        offsets=skeleton.offsets * factor,
        end_sites=tuple(
            (joint, (x * factor, y * factor, z * factor)) for joint, (x, y, z) in skeleton.end_sites
        ),
    )
