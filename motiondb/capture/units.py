"""Length units of captures: given, or found from the size of the body.

The unit is the one, among those in use, that brings the body nearest (in ratio) to a leg of 0.83 m,
hip to ankle, as a person of 1.70 m has. Neighbours in the list differ by a factor of 2.2 or more,
so legs between 0.56 m and 1.23 m (1.15 m to 2.5 m of height) are read rightly; a small child in
centimetres may be taken for a person in inches: then give the unit.
"""

from __future__ import annotations

import math

import numpy as np

from motiondb.errors import CaptureError, SkeletonError
from motiondb.pose.joint_names import joint_map
from motiondb.records import FloatArray, Skeleton

INCH = 0.0254
UNITS: dict[str, float] = {
    "m": 1.0,
    "cmu": INCH / 0.45,
    "inch": INCH,
    "cm": 0.01,
    "mm": 0.001,
}
"""Metres per unit. "cmu" is the CMU database's own scale: inches divided by 0.45."""
TYPICAL_LEG = 0.83
"""Hip to ankle of an adult, metres."""
TYPICAL_CHAIN = 1.15
"""Longest chain of bones from the root (to a hand or a foot) of an adult, metres."""
DOUBTFUL = 1.6
"""A body larger or smaller than typical by this ratio is noted."""


def unit_from_name(name: str) -> float:
    """Metres per unit from a name or a number.

    >>> unit_from_name("cm"), unit_from_name("0.5")
    (0.01, 0.5)
    """
    key = {"in": "inch", "inches": "inch", "metre": "m", "meter": "m"}.get(
        name.lower(), name.lower()
    )
    if key in UNITS:
        return UNITS[key]
    try:
        value = float(name)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0):
        known = ", ".join(UNITS)
        raise CaptureError(
            "unit", f"expected one of {known} or a number of metres, found {name!r}. Give one."
        )
    return value


def find_unit(
    skeleton: Skeleton, joint_positions: FloatArray | None = None
) -> tuple[float, tuple[str, ...]]:
    """Metres per unit of a skeleton whose offsets are still in the file's unit, and notes.

    Parameters
    ----------
    skeleton : offsets in the unit of the file.
    joint_positions : array (frames, joints, 3) or None, as in a clip, in the unit of the file.
    """
    offsets = skeleton.offsets
    if joint_positions is not None:
        offsets = np.median(joint_positions[:: max(1, len(joint_positions) // 100)], axis=0)
    size, typical = _body_size(skeleton, np.linalg.norm(offsets, axis=-1))
    if size <= 0:
        return 1.0, ("The skeleton has no size; its unit is taken to be the metre.",)
    unit = min(UNITS.values(), key=lambda metres: abs(math.log(size * metres / typical)))
    ratio = size * unit / typical
    if not 1 / DOUBTFUL < ratio < DOUBTFUL:
        return unit, (
            f"The length unit is a guess ({unit:.4g} m): the body would be {ratio:.2g} times "
            "the usual size. Give the unit if it matters.",
        )
    return unit, ()


def _body_size(skeleton: Skeleton, lengths: FloatArray) -> tuple[float, float]:
    """Size of the body in file units, and what that size is of an adult, in metres."""
    try:
        roles = joint_map(skeleton)
    except SkeletonError:
        roles = {}
    legs = []
    for side in "lr" if roles else "":
        ankle, hip = roles[f"{side}_ankle"], roles[f"{side}_hip"]
        leg = _path_length(skeleton, lengths, ankle, hip)
        if leg > 0:
            legs.append(leg)
    if legs:
        return float(np.mean(legs)), TYPICAL_LEG
    chains = [_path_length(skeleton, lengths, j, -1) for j in range(len(lengths))]
    ends = [chains[joint] + float(np.linalg.norm(offset)) for joint, offset in skeleton.end_sites]
    return max([*chains, *ends]), TYPICAL_CHAIN


def _path_length(skeleton: Skeleton, lengths: FloatArray, joint: int, above: int) -> float:
    """Length of the bones from joint ``above`` (-1: the root) down to a joint; 0 if not above."""
    total = 0.0
    while joint != above:
        parent = int(skeleton.parents[joint]) if joint >= 0 else -1
        if parent < 0:
            return total if above < 0 and joint >= 0 else 0.0
        total += float(lengths[joint])
        joint = parent
    return total
