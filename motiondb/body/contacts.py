"""Which foot is on the ground: its ankle or toe is low and slow."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body, retarget
from motiondb.body.features import runs
from motiondb.records import MOTION_FPS, FloatArray, Motion

MAX_HEIGHT = 0.05  # Largest height of a foot in contact above its height in standing, metres
MAX_SPEED = 0.45  # Largest speed of a foot in contact, metres a second
TOE_HEIGHT = 0.02  # Height of a toe over the ground in a flat stance, metres
_I = body.INDEX
FEET = tuple(_I[f"{side}_{joint}"] for side in "lr" for joint in ("ankle", "toe"))
"""Joints by which contacts are detected."""


def find_contacts(positions: FloatArray) -> NDArray[np.bool_]:
    """Which foot, left or right, is on the ground: array (frames, 2); positions (frames, 21, 3)."""
    return steady((foot_heights(positions) < MAX_HEIGHT) & (_foot_speeds(positions) < MAX_SPEED))


def foot_heights(positions: FloatArray) -> FloatArray:
    """Height of the feet over the ground: array (frames, 2), m, of positions (frames, 21, 3)."""
    ankles, toes = positions[:, FEET[::2], 1], positions[:, FEET[1::2], 1]
    return np.minimum(ankles - body.ANKLE_HEIGHT, toes - TOE_HEIGHT)


def steady(contacts: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Contacts (frames, 2) without flicker."""
    return np.stack([_without_flicker(contacts[:, foot]) for foot in range(2)], axis=1)


def foot_slip(motion: Motion) -> float:
    """Mean ground speed of feet in contact, metres a second; 0 without contacts."""
    speeds = contact_speeds(motion)
    in_contact = speeds[np.isfinite(speeds)]
    return float(in_contact.mean()) if len(in_contact) else 0.0


def contact_speeds(motion: Motion) -> FloatArray:
    """Ground speed of feet in contact: array (frames, 2), metres a second; NaN without contact."""
    positions, _ = retarget.motion_positions(motion, FEET)
    return np.where(find_contacts(positions), _foot_speeds(positions), np.nan)


def _without_flicker(contact: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Close gaps of up to 2 frames and drop contacts of fewer than 4 frames."""
    kept = contact.copy()
    for start, end in runs(~contact):
        if end - start <= 2 and start > 0 and end < len(contact):
            kept[start:end] = True
    for start, end in runs(kept):
        if end - start < 4:
            kept[start:end] = False
    return kept


def _foot_speeds(positions: FloatArray) -> FloatArray:
    """Ground speed of the slower of ankle and toe: array (frames, 2), metres a second."""
    if len(positions) < 2:
        return np.zeros((len(positions), 2))
    places = positions[:, FEET][..., [0, 2]]
    speeds = np.linalg.norm(np.gradient(places, axis=0), axis=-1) * MOTION_FPS
    return np.minimum(speeds[:, ::2], speeds[:, 1::2])
