"""The canonical body on which all motions are compared.

21 joints in T-pose at zero rotation: y up, facing +z, left is +x, metres. The pelvis is the point
midway between the hips. Performers are scaled to ``LEG_LENGTH`` (hip to ankle). The proportions are
those of an average adult, rounded to a centimetre.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from motiondb.records import FloatArray, IntArray, Skeleton

_TABLE = (
    # joint, parent, offset from the parent (metres)
    ("pelvis", -1, (0.0, 0.0, 0.0)),
    ("l_hip", 0, (0.09, 0.0, 0.0)),
    ("l_knee", 1, (0.0, -0.43, 0.0)),
    ("l_ankle", 2, (0.0, -0.42, 0.0)),
    ("l_toe", 3, (0.0, -0.06, 0.14)),
    ("r_hip", 0, (-0.09, 0.0, 0.0)),
    ("r_knee", 5, (0.0, -0.43, 0.0)),
    ("r_ankle", 6, (0.0, -0.42, 0.0)),
    ("r_toe", 7, (0.0, -0.06, 0.14)),
    ("spine", 0, (0.0, 0.12, 0.0)),
    ("chest", 9, (0.0, 0.14, 0.0)),
    ("neck", 10, (0.0, 0.24, 0.0)),
    ("head", 11, (0.0, 0.10, 0.01)),
    ("l_collar", 10, (0.03, 0.18, 0.0)),
    ("l_shoulder", 13, (0.14, 0.0, 0.0)),
    ("l_elbow", 14, (0.28, 0.0, 0.0)),
    ("l_wrist", 15, (0.25, 0.0, 0.0)),
    ("r_collar", 10, (-0.03, 0.18, 0.0)),
    ("r_shoulder", 17, (-0.14, 0.0, 0.0)),
    ("r_elbow", 18, (-0.28, 0.0, 0.0)),
    ("r_wrist", 19, (-0.25, 0.0, 0.0)),
)

JOINTS: tuple[str, ...] = tuple(row[0] for row in _TABLE)  # Names of the canonical joints, in order
INDEX: Mapping[str, int] = MappingProxyType({name: number for number, name in enumerate(JOINTS)})
"""Name -> number of a canonical joint."""
PARENTS: IntArray = np.array([row[1] for row in _TABLE])
"""array (21,), the number of each joint's parent, -1 for the pelvis."""
OFFSETS: FloatArray = np.array([row[2] for row in _TABLE])
"""array (21, 3), metres, from the parent in the parent's frame."""
END_SITES: tuple[tuple[int, tuple[float, float, float]], ...] = (
    (INDEX["head"], (0.0, 0.18, 0.0)),
    (INDEX["l_wrist"], (0.17, 0.0, 0.0)),
    (INDEX["r_wrist"], (-0.17, 0.0, 0.0)),
    (INDEX["l_toe"], (0.0, -0.02, 0.06)),
    (INDEX["r_toe"], (0.0, -0.02, 0.06)),
)  # (joint, offset in its frame) of the ends of head, hands and feet, metres
LEG_LENGTH = 0.85  # Hip to ankle of the standard body, metres
ANKLE_HEIGHT = 0.08  # The ankle's height over the ground in a flat stance, metres
MIRROR: IntArray = np.array(
    [INDEX[{"l": "r", "r": "l"}[name[0]] + name[1:] if name[1] == "_" else name] for name in JOINTS]
)  # array (21,), for every joint the number of its mirror image


def standard_skeleton(leg_length: float = LEG_LENGTH) -> Skeleton:
    """Return the canonical body as a :class:`Skeleton` that writers accept."""
    scale = leg_length / LEG_LENGTH
    return Skeleton(
        names=JOINTS,
        parents=PARENTS,
        offsets=OFFSETS * scale,
        end_sites=tuple((j, (x * scale, y * scale, z * scale)) for j, (x, y, z) in END_SITES),
    )
