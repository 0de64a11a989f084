"""Parts of captures that a user chose, joined one after the other.

The seams are those of generated motion: what both sides of a seam differ by is spread over both
(:mod:`motiondb.generate.stitching`), and feet that stand are held (:mod:`.contact`). No part is
moved or cut: where a seam is rough, the report says so.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from motiondb.body import body, pose_vectors, retarget, rotation
from motiondb.body.contacts import find_contacts
from motiondb.errors import QueryError
from motiondb.generate import contact, stitching
from motiondb.generate.material import SequenceMotion
from motiondb.records import MOTION_FPS, FloatArray, Motion

ROUGH_GAP = 0.4
"""Largest distance of a joint, metres, of both sides of a seam above which the seam is called
rough: more than between two phases of a walk."""
_SHORTEST = 3  # Fewest frames of a part


@dataclass(frozen=True)
class Seam:
    """Where two parts meet."""

    seconds: float  # In the joined motion
    blended: float  # Seconds over which both sides are bent towards each other
    gap: float  # Largest distance of a joint between both sides before that, m
    speed_gap: float  # Difference of the speeds over the ground before that, m/s
    is_rough: bool  # Whether the poses are too far apart for a blend to look natural


@dataclass(frozen=True, eq=False)
class Joined:
    """A motion of parts of captures."""

    made: SequenceMotion
    seams: tuple[Seam, ...]


def join(motions: Sequence[Motion], parts: Sequence[stitching.Piece]) -> Joined:
    """Join parts of motions; the numbers of the pieces are places in ``motions``."""
    for number, part in enumerate(parts, start=1):
        if part.end - part.start < _SHORTEST:
            raise QueryError(
                f"part {number}: expected at least {_SHORTEST / MOTION_FPS:.1f} s, found "
                f"{(part.end - part.start) / MOTION_FPS:.2f} s. Choose a longer part."
            )
    sources = {n: pose_vectors.to_path(motion) for n, motion in enumerate(motions)}
    whole = stitching.stitch(parts, sources)
    motion = pose_vectors.from_path(whole.path, whole.rotations, leg_length=motions[0].leg_length)
    stands = {n: find_contacts(m.joint_positions()) for n, m in enumerate(motions)}
    contacts = np.array([stands[c][f] for c, f in zip(whole.captures.tolist(), whole.frames)])
    contacts[whole.shares < 1.0] = False  # there the feet of both sides may be far apart
    edits = tuple(
        "foot lock" if share == 1 else f"blend {share:.2f}, foot lock" for share in whole.shares
    )
    lengths = tuple(part.end - part.start for part in parts)
    made = SequenceMotion(
        contact.lock_feet(motion, contacts=contacts),
        whole.captures,
        whole.frames.astype(float),
        edits,
        lengths,
    )
    return Joined(made, tuple(_seams(parts, lengths, sources, whole)))


def _seams(
    parts: Sequence[stitching.Piece],
    lengths: Sequence[int],
    sources: dict[int, tuple[FloatArray, FloatArray]],
    whole: stitching.Stitched,
) -> list[Seam]:
    """Measure the seams before they were blended."""
    seams, ends = [], np.cumsum(lengths)[:-1].tolist()
    for (before, after), place in zip(pairwise(parts), ends):
        old, new = sources[before.capture], sources[after.capture]
        if (before.capture, before.end) == (after.capture, after.start):
            seams.append(Seam(place / MOTION_FPS, 0.0, 0.0, 0.0, False))
            continue
        last, first = before.end - 1, after.start
        gap = float(np.linalg.norm(_places(old, last) - _places(new, first), axis=-1).max())
        speeds = old[0][last, 1:3] - new[0][first, 1:3]
        bent = _bent(whole.shares, place)
        seams.append(
            Seam(
                round(place / MOTION_FPS, 3),
                round(bent / MOTION_FPS, 3),
                gap,
                float(np.hypot(*speeds)),
                gap > ROUGH_GAP,
            )
        )
    return seams


def _places(source: tuple[FloatArray, FloatArray], frame: int) -> FloatArray:
    """Return places (21, 3) relative to the ground below the pelvis, along the heading."""
    path, turned = source
    root = np.array([[0.0, path[frame, 0], 0.0]])
    local = turned[frame : frame + 1]
    motion = Motion(rotation.normalize(local).astype(np.float32), root.astype(np.float32))
    return np.asarray(retarget.motion_positions(motion)[0][0, : len(body.JOINTS)])


def _bent(shares: FloatArray, place: int) -> int:
    """Return how many frames around a seam are blended."""
    low = high = place
    while low > 0 and shares[low - 1] < 1.0:
        low -= 1
    while high < len(shares) and shares[high] < 1.0:
        high += 1
    return high - low
