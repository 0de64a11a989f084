"""A player of a polished scene, with the origin of every frame."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body
from motiondb.records import FloatArray, IntArray, Motion
from motiondb.scene.polish.splicing import Spliced
from motiondb.scene.timing.scheduling import TimeMap

# Frames in which arms and heads were edited after the clips were spliced.


FOLLOWS = "follows: "  # Before the action, in the edits of frames behind the last action
LEAST = math.radians(1.0)
"""Smallest turn of a joint, rad, that counts as an edit. Chosen by hand: a smaller one cannot be
seen."""
_EDITS = {
    "hands brought to the ball": ("l_shoulder", "l_elbow", "r_shoulder", "r_elbow"),
    "head turned": ("neck", "head"),
}


def joint_edits(spliced: Motion, finished: Motion) -> dict[str, NDArray[np.bool_]]:
    """Return in which frames a finished motion was edited: arrays (frames,), by the edit.

    >>> from motiondb.body import rotation
    >>> local = np.tile(rotation.IDENTITY, (2, len(body.JOINTS), 1))
    >>> still = Motion(local.astype(np.float32), np.zeros((2, 3), np.float32), 0.9)
    >>> local[1, body.INDEX["neck"]] = rotation.from_axis_angle([0.0, 1.0, 0.0], 0.1)
    >>> looks = Motion(local.astype(np.float32), still.root_positions, 0.9)
    >>> {edit: frames.tolist() for edit, frames in joint_edits(still, looks).items()}
    {'hands brought to the ball': [False, False], 'head turned': [False, True]}

    Hands are moved to the ball and heads turned to it (:mod:`motiondb.scene.thing.thing_flight`). A
    frame counts as edited if a joint differs from the spliced motion's by more than one degree.
    """
    before, after = (m.local_rotations.astype(np.float64) for m in (spliced, finished))
    cosines = np.abs(np.sum(before * after, axis=2))  # of half the turn; q and -q are one rotation
    turned = cosines < math.cos(LEAST / 2.0)
    return {
        edit: turned[:, [body.INDEX[joint] for joint in joints]].any(axis=1)
        for edit, joints in _EDITS.items()
    }


@dataclass(frozen=True, eq=False)
class Placed:
    """One player of the polished scene, with the origin of each frame."""

    player: str
    motion: Motion
    captures: tuple[str, ...]  # Source captures of the frames
    licences: tuple[str, ...]
    source_numbers: IntArray  # (frames,), int: index into ``captures``
    source_frames: FloatArray  # (frames,): frame of the capture; may lie between two
    # (frames,): frames of the source per frame; 0 if a pose is held, negative where waiting is
    # played backwards
    warps: FloatArray
    edits: tuple[str, ...]  # The edits of each frame
    # (frames,), int: the player's action that it belongs to; waiting belongs to the first or the
    # last
    clips: IntArray


def place_player(
    name: str,
    bodies: tuple[Motion, Motion],
    spliced: Spliced,
    times: TimeMap,
    actions: tuple[str, ...],
) -> Placed:
    """Return a player with the origin of each frame; ``bodies`` before and after joint edits."""
    motion, moved = bodies[1], joint_edits(*bodies)
    clock = np.arange(motion.n_frames, dtype=float)
    source = times.source_at(clock)
    at = spliced.rows(source)
    held = at != source + spliced.lead
    frames, rate = spliced.shown_frames(at)
    nearest = np.rint(at).astype(np.int64)
    numbers, shares = spliced.part[nearest].tolist(), spliced.shares[nearest].tolist()
    sources = [part.source for part in spliced.parts]
    captures = tuple(dict.fromkeys(sources[number].capture for number in numbers))
    licence = {source.capture: source.licence for source in sources}
    edits = []
    for frame, (number, share) in enumerate(zip(numbers, shares, strict=True)):
        part = spliced.parts[number]
        said = [part.source.edit, f"blend {share:.2f}" if share < 1.0 else ""]
        said += ["waits" if part.waits else "", f"{FOLLOWS}{part.action}" if part.action else ""]
        said.append("way edited, feet held")
        said += [edit for edit, frames in moved.items() if frames[frame]]
        edits.append(", ".join(word for word in said if word))
    return Placed(
        name,
        motion,
        captures,
        tuple(licence[capture] for capture in captures),
        np.array([captures.index(sources[number].capture) for number in numbers]),
        frames,
        np.where(held, 0.0, rate * times.slope_at(clock)),
        tuple(edits),
        np.clip([spliced.parts[number].clip for number in numbers], 0, len(actions) - 1),
    )
