"""Reader of C3D: marker positions as clips of joints (:mod:`.markers`).

Up is the axis that ``POINT:Y_SCREEN`` names, else the one that the motion shows. Lost are analog
channels, forces and events. A file with several performers gives a clip for each.
"""

from __future__ import annotations

from functools import cache

from motiondb.files.limits import AS_USUAL, ReadOptions
from motiondb.files.readers.c3d_file import read_c3d_file
from motiondb.files.readers.markers import MarkerFile, only_performer, read_markers
from motiondb.records import Clip


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


def read_c3d(data: bytes, path: object, options: ReadOptions = AS_USUAL) -> Clip:
    """Read the clip in the bytes of a C3D file."""
    return only_performer(read_c3d_takes(data, path, options), path, options)
