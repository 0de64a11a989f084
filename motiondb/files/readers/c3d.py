"""Reader of C3D: marker positions as clips of joints (:mod:`.markers`).

Up is the axis that ``POINT:Y_SCREEN`` names, else the one that the motion shows. Lost are analog
channels and forces. A file with several performers gives a clip for each.
"""

from __future__ import annotations

import re
from functools import cache

from motiondb.files.limits import AS_USUAL, ReadOptions
from motiondb.files.readers.c3d_file import read_c3d_file
from motiondb.files.readers.markers import MarkerFile, only_performer, read_markers
from motiondb.records import MOTION_FPS, Clip, Event


def read_c3d_takes(data: bytes, path: object, options: ReadOptions = AS_USUAL) -> dict[str, Clip]:
    """Read the clip of each performer in the bytes of a C3D file; "" for the only one."""
    return read_markers(c3d_markers(data, path, options), len(data), path, options)


def c3d_markers(data: bytes, path: object, options: ReadOptions = AS_USUAL) -> MarkerFile:
    """Read the markers in the bytes of a C3D file."""
    file = read_c3d_file(data, path, options.skip_bad_frames)
    track = cache(file.track)  # a file may hold hundreds of points that are no markers
    notes = file.notes + (file.rate_notes if options.fps is None else ())
    return MarkerFile(
        file.labels, file.n_frames, track, file.fps, file.unit, file.up, "z", "c3d", notes
    )


def c3d_events(data: bytes, path: object, fps: float, take: str = "") -> list[Event]:
    """Read the events in the bytes of a C3D file, at 30 a second, that lie within its frames.

    Strikes of the foot and heel are ``foot_strike``, toe off is ``foot_off``, with the ankle of the
    side that the context names. `fps`: the rate at which the frames are read. `take`: the performer
    whose events are read; those without a subject are everybody's.
    """
    file = read_c3d_file(data, path, skip_bad=True)
    found = []
    for event in file.events:
        frame = round(event.frame / fps * MOTION_FPS)
        if not 0 <= event.frame < file.n_frames or (take and event.subject not in ("", take)):
            continue
        side = {"left": "l_ankle", "right": "r_ankle"}.get(event.context.lower(), "")
        name = "_".join(event.label.lower().split())
        if short := re.fullmatch(r"([lr])_?(hs|to)", name):
            side = f"{short[1]}_ankle"
            name = {"hs": "foot_strike", "to": "foot_off"}[short[2]]
        if re.fullmatch(r"(foot|heel|initial)_?(strike|contact)", name):
            found.append(Event(frame, "foot_strike", side, "ground"))
        elif re.fullmatch(r"(foot|toe)_?off", name):
            found.append(Event(frame, "foot_off", side, "ground"))
        else:
            sided = f"{event.context.lower()}_{name}" if side else name
            found.append(Event(frame, sided))
    return found


def read_c3d(data: bytes, path: object, options: ReadOptions = AS_USUAL) -> Clip:
    """Read the clip in the bytes of a C3D file."""
    return only_performer(read_c3d_takes(data, path, options), path, options)
