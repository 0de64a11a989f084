"""Joint centres computed from the markers of the usual full-body set.

The set is Vicon's Plug-in Gait (LASI RASI, LPSI RPSI or SACR, LKNE LANK LTOE LHEE, LSHO LELB LWRA
LWRB, C7 CLAV STRN T10, LFHD RFHD LBHD RBHD); the CMU database's names of the pelvis (LFWT RFWT LBWT
RBWT) are accepted too. Notation: W is the distance between LASI and RASI; left, up and ahead are
the axes of the pelvis (left: RASI to LASI; ahead: from the middle of the back markers, orthogonal).

- hip: from the middle of LASI and RASI 0.36 W to the side, 0.19 W back, 0.30 W down (Bell,
  Brand, Pedersen, Human Movement Science 8, 1989);
- knee and ankle: 5 cm and 4 cm from the marker towards the middle, along the pelvis's left axis
  made orthogonal to the bone;
- shoulder: 5 cm below the marker along the trunk; elbow: its marker; wrist: between its markers;
- neck: between C7 and CLAV; chest: between T10 and STRN; head: middle of the head's markers.

These are plain regressions: good to 1 to 4 cm, enough to recognise a motion, not for clinical use.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from motiondb.body import body, rotation
from motiondb.records import FloatArray

Markers = Mapping[str, FloatArray]  # Marker name -> array (frames, 3), metres, y up

ALIASES = MappingProxyType(
    {
        "LFWT": "LASI",
        "RFWT": "RASI",
        "LBWT": "LPSI",
        "RBWT": "RPSI",
        "SACRUM": "SACR",
        "CV7": "C7",
    }
)  # Other names -> the names used here
REQUIRED = ("LASI", "RASI", "LKNE", "RKNE", "LANK", "RANK", "LSHO", "RSHO", "LELB", "RELB")
"""Markers that every joint set needs; the back of the pelvis and the neck are needed as well."""
USED = (
    *REQUIRED,
    "LPSI",
    "RPSI",
    "SACR",
    "LTOE",
    "RTOE",
    "LHEE",
    "RHEE",
    "LWRA",
    "LWRB",
    "RWRA",
    "RWRB",
    "C7",
    "CLAV",
    "STRN",
    "T10",
    "LFHD",
    "RFHD",
    "LBHD",
    "RBHD",
)
_KNEE, _ANKLE, _SHOULDER = 0.05, 0.04, 0.05
"""Metres from the marker to the joint centre: half the width of an adult's knee and ankle with the
radius of the marker, and the depth of the shoulder joint below the skin. Rounded to a centimetre;
not tuned."""
_CHEST_SHARE, _SPINE_SHARE, _HEAD_SHARE = 0.55, 0.45, 0.4
"""Positions of joints without markers, as fractions from the pelvis to the neck (chest), to the
chest (spine), and beyond the neck along the trunk (head); close to those of the canonical body."""
_FOREARM_SHARE, _COLLAR_SHARE = 0.9, 0.2
"""Length of the forearm by the upper arm, and the collar's place from neck to shoulder: close to
the canonical body."""
_TOE_AHEAD, _TOE_DOWN = 0.14, 0.06  # Metres from the ankle to the toe joint on the canonical body


def missing_markers(names: frozenset[str] | set[str]) -> list[str]:
    """Return what a set of marker names lacks, as messages say it.

    >>> missing_markers(set(USED) - {"LKNE", "C7", "SACR"})
    ['LKNE']
    >>> missing_markers(set(REQUIRED))
    ['LPSI and RPSI, or SACR', 'C7 or CLAV']
    """
    missing = [name for name in REQUIRED if name not in names]
    if "SACR" not in names and not {"LPSI", "RPSI"} <= names:
        missing.append("LPSI and RPSI, or SACR")
    if not {"C7", "CLAV"} & names:
        missing.append("C7 or CLAV")
    return missing


def joint_centres(markers: Markers) -> FloatArray:
    """Compute the canonical joints of markers; `markers` (frames, 3); result (frames, 21, 3)."""
    left, up, ahead, front = _pelvis_axes(markers)
    width = np.median(np.linalg.norm(markers["LASI"] - markers["RASI"], axis=-1))
    points: dict[str, FloatArray] = {}
    for side, sign in (("l", 1.0), ("r", -1.0)):
        hip = front + width * (0.36 * sign * left - 0.19 * ahead - 0.30 * up)
        points[f"{side}_hip"] = hip
        points |= _leg(markers, side, sign * left, hip)
    points["pelvis"] = (points["l_hip"] + points["r_hip"]) / 2.0
    points["neck"] = _mean(markers, "C7", "CLAV")
    if {"T10", "STRN"} <= set(markers):
        points["chest"] = _mean(markers, "T10", "STRN")
    else:
        points["chest"] = points["pelvis"] + _CHEST_SHARE * (points["neck"] - points["pelvis"])
    points["spine"] = points["pelvis"] + _SPINE_SHARE * (points["chest"] - points["pelvis"])
    trunk = points["neck"] - points["chest"]
    heads = [name for name in ("LFHD", "RFHD", "LBHD", "RBHD") if name in markers]
    beyond = points["neck"] + _HEAD_SHARE * trunk
    points["head"] = _mean(markers, *heads) if heads else beyond
    for side in "lr":
        points |= _arm(markers, side, rotation.normalize(trunk), points["neck"])
    return np.stack([points[name] for name in body.JOINTS], axis=1)


def _pelvis_axes(markers: Markers) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the axes left, up and ahead (frames, 3), and the middle of the front markers."""
    front = _mean(markers, "LASI", "RASI")
    both = {"LPSI", "RPSI"} <= set(markers)
    back = _mean(markers, "LPSI", "RPSI") if both else markers["SACR"]
    left = rotation.normalize(markers["LASI"] - markers["RASI"])
    up = rotation.normalize(np.cross(front - back, left))
    return left, up, np.cross(left, up), front


def _leg(
    markers: Markers, side: str, outward: FloatArray, hip: FloatArray
) -> dict[str, FloatArray]:
    """Return knee, ankle and toe of a side; ``outward`` is the pelvis's axis to that side."""
    letter = side.upper()
    knee_marker, ankle_marker = markers[f"{letter}KNE"], markers[f"{letter}ANK"]
    knee = knee_marker - _KNEE * _orthogonal(outward, knee_marker - hip)
    ankle = ankle_marker - _ANKLE * _orthogonal(outward, ankle_marker - knee_marker)
    toe = markers.get(f"{letter}TOE")
    if toe is None:
        heel = markers.get(f"{letter}HEE")
        shin = rotation.normalize(ankle - knee)
        ahead = rotation.normalize(np.cross(shin, outward) * (1.0 if side == "l" else -1.0))
        if heel is not None:
            ahead = rotation.normalize(_orthogonal(ankle - heel, shin))
        toe = ankle + _TOE_AHEAD * ahead + _TOE_DOWN * shin
    return {f"{side}_knee": knee, f"{side}_ankle": ankle, f"{side}_toe": toe}


def _arm(
    markers: Markers, side: str, trunk_up: FloatArray, neck: FloatArray
) -> dict[str, FloatArray]:
    """Return collar, shoulder, elbow and wrist of a side."""
    letter = side.upper()
    shoulder = markers[f"{letter}SHO"] - _SHOULDER * trunk_up
    elbow = markers[f"{letter}ELB"]
    wrists = [name for name in (f"{letter}WRA", f"{letter}WRB") if name in markers]
    wrist = _mean(markers, *wrists) if wrists else elbow + _FOREARM_SHARE * (elbow - shoulder)
    collar = neck + _COLLAR_SHARE * (shoulder - neck)
    return {
        f"{side}_collar": collar,
        f"{side}_shoulder": shoulder,
        f"{side}_elbow": elbow,
        f"{side}_wrist": wrist,
    }


def _mean(markers: Markers, *names: str) -> FloatArray:
    """Return the mean (frames, 3) of those of the named markers that are present."""
    present = [markers[name] for name in names if name in markers]
    return np.asarray(np.mean(present, axis=0))


def _orthogonal(vector: FloatArray, direction: FloatArray) -> FloatArray:
    """Return the unit vector along the part of ``vector`` that is orthogonal to ``direction``."""
    along = rotation.normalize(direction)
    return rotation.normalize(vector - np.sum(vector * along, axis=-1, keepdims=True) * along)
