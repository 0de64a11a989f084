"""A player of a polished scene, with the origin of every frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb.records import FloatArray, IntArray, Motion
from motiondb.scene.polish.joint_edits import joint_edits
from motiondb.scene.polish.splicing import Spliced
from motiondb.scene.timing.time_editing import TimeMap


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
        said += ["waits" if part.waits else "", "way edited, feet held"]
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
