"""Length units of captures: given, or found from the size of the body.

The unit is the one, among those in use, that brings the body nearest (in ratio) to a leg of 0.83 m,
hip to ankle, as a person of 1.70 m has. Neighbours in the list differ by a factor of 2.2 or more,
so legs between 0.56 m and 1.23 m (1.15 m to 2.5 m of height) are read rightly; a small child in
centimetres may be mistaken for a person in inches; give the unit in this case.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from motiondb.body.joint_names import joint_map
from motiondb.errors import CaptureError, SkeletonError
from motiondb.files.text import number, quoted
from motiondb.records import FloatArray, Skeleton

INCH = 0.0254  # Metres
UNITS: Mapping[str, float] = MappingProxyType(
    {"m": 1.0, "cmu": INCH / 0.45, "inch": INCH, "cm": 0.01, "mm": 0.001}
)  # Metres per unit. "cmu" is the CMU database's own scale: inches divided by 0.45
TYPICAL_LEG = 0.83
"""Hip to ankle of an adult, metres: half of a height of 1.70 m, less the height of the ankle."""
TYPICAL_CHAIN = 1.15
"""Longest chain of bones from the root (to a hand or a foot) of an adult, metres."""
DOUBTFUL = 1.6
"""A body larger or smaller than typical by this ratio is noted. Legs of 0.52 m to 1.33 m pass: this
covers adults and children from about six years."""
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


def find_unit(
    skeleton: Skeleton, joint_positions: FloatArray | None = None
) -> tuple[float, tuple[str, ...]]:
    """Estimate the length unit of a skeleton from the size of its body, with notes."""
    offsets = skeleton.offsets
    if joint_positions is not None:
        offsets = np.median(joint_positions[:: max(1, len(joint_positions) // 100)], axis=0)
    size, typical = body_size(skeleton, np.linalg.norm(offsets, axis=-1))
    if not 1e-9 < size < 1e9:
        return 1.0, ("The skeleton has no size; its unit is taken to be the metre.",)
    unit = min(UNITS.values(), key=lambda metres: abs(math.log(size * metres / typical)))
    ratio = size * unit / typical
    if not 1 / DOUBTFUL < ratio < DOUBTFUL:
        return unit, (
            f"The length unit is a guess ({unit:.4g} m): the body would be {ratio:.2g} times "
            "the usual size. Give the unit if it matters.",
        )
    return unit, ()


def body_size(skeleton: Skeleton, lengths: FloatArray) -> tuple[float, float]:
    """Return the size of the body in file units, and the same size of an adult in metres."""
    try:
        roles = joint_map(skeleton)
    except SkeletonError:
        roles = {}
    legs = []
    for side in "lr" if roles else "":
        leg = _path_length(skeleton, lengths, roles[f"{side}_ankle"], roles[f"{side}_hip"])
        if leg > 0:
            legs.append(leg)
    if legs:
        return float(np.mean(legs)), TYPICAL_LEG
    chains = _chain_lengths(skeleton, lengths)
    ends = [chains[joint] + math.hypot(*offset) for joint, offset in skeleton.end_sites]
    return max([*chains, *ends]), TYPICAL_CHAIN


def _chain_lengths(skeleton: Skeleton, lengths: FloatArray) -> list[float]:
    """Length of the bones from the root to every joint; parents come before children."""
    chains: list[float] = []
    for parent, length in zip(skeleton.parents.tolist(), lengths.tolist()):
        chains.append(chains[parent] + length if parent >= 0 else 0.0)
    return chains


def _path_length(skeleton: Skeleton, lengths: FloatArray, joint: int, above: int) -> float:
    """Return the length of the bones from joint ``above`` to a joint; 0 if it is not above."""
    total = 0.0
    while joint != above:
        parent = int(skeleton.parents[joint]) if joint >= 0 else -1
        if parent < 0:
            return 0.0
        total += float(lengths[joint])
        joint = parent
    return total
