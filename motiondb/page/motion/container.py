"""Motions as compact binary: positions in 16 bits, contacts in 2.

::

    bytes 0-3    "MDBM"
    bytes 4-7    length H of the header, unsigned, little-endian
    8 to 8 + H   header: JSON, padded with spaces so that 8 + H is a multiple of 4
    then         payload; the offsets in the header count from here

The header names the points with their parents and radii, and the tracks. A track of a body holds
int16 (frames, 26, 3), little-endian: position = origin + scale * value. Its contacts are uint8
(frames,), bit 0 the left foot and bit 1 the right. A track of a ball holds int16 (frames, 3). A
motion of 30 s has 142 kB; positions within 20 m are accurate to 0.2 mm.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motiondb.page.motion import figure
from motiondb.records import MOTION_FPS, FloatArray

MAGIC = b"MDBM"
MEDIA_TYPE = "application/x-motiondb"
_STEPS = 32767  # Largest value of a signed integer of 16 bits


@dataclass(frozen=True, eq=False)
class Track:
    """A body or a ball in the container."""

    name: str  # Name that is shown
    ref: str  # Ref of the motion or scene that the track belongs to
    # (frames, points, 3) or (frames, 3): positions in metres; the second shape is that of a ball
    points: FloatArray
    # (frames, 2) or None: whether the left and the right foot are on the ground
    contacts: NDArray[np.bool_] | None = None
    start: float = 0.0  # Time of the first frame in the take, seconds
    fps: float = MOTION_FPS
    team: str = ""  # Team of a player of a scene, or ""
    leg_length: float | None = None  # The performer's leg length, metres


def body_track(
    name: str, ref: str, shown: figure.Figure, start: float = 0.0, fps: float = MOTION_FPS
) -> Track:
    """Return the track of a figure, at the same or a lower frame rate."""
    kept = figure.thinned(len(shown.points), MOTION_FPS, fps)
    rate = min(fps, MOTION_FPS)
    return Track(
        name,
        ref,
        shown.points[kept],
        shown.contacts[kept],
        start,
        rate,
        leg_length=shown.leg_length,
    )


def pack(tracks: Sequence[Track]) -> bytes:
    """Return the container of some tracks as bytes."""
    payload: list[bytes] = []
    length = 0

    def store(data: bytes) -> int:
        nonlocal length
        at = length
        padded = data + bytes(-len(data) % 4)
        payload.append(padded)
        length += len(padded)
        return at

    rows = [_pack_track(track, store) for track in tracks]
    header = {
        "format": 1,
        "points": figure.POINTS,
        "parents": figure.PARENTS,
        "radii": figure.RADII,
        "tracks": rows,
    }
    text = json.dumps(header, ensure_ascii=False).encode("utf-8", "replace")
    text += b" " * (-len(text) % 4)
    return MAGIC + len(text).to_bytes(4, "little") + text + b"".join(payload)


def _pack_track(track: Track, store: Callable[[bytes], int]) -> dict[str, Any]:
    is_ball = track.points.ndim == 2
    origin, scale, values = quantise(track.points)
    facts = {
        "name": track.name,
        "ref": track.ref,
        "kind": "ball" if is_ball else "body",
        "team": track.team or None,
        "frames": len(track.points),
        "fps": track.fps,
        "start": round(track.start, 4),
        "offset": store(values.tobytes()),
        "origin": [float(x) for x in origin],
        "scale": [float(x) for x in scale],
        "contacts": None,
    }
    if is_ball:
        return facts | {"radius": figure.BALL_RADIUS}
    if track.contacts is not None:
        bits = track.contacts[:, 0].astype(np.uint8) | (track.contacts[:, 1].astype(np.uint8) << 1)
        facts["contacts"] = store(bits.tobytes())
    length = track.leg_length
    return facts | {"leg_length": length if length and math.isfinite(length) else None}


def quantise(points: FloatArray) -> tuple[FloatArray, FloatArray, NDArray[np.int16]]:
    """Return origin, scale and 16-bit values of points: position = origin + scale * value.

    Shapes: `points` (..., 3); result (3,).
    """
    flat = points.reshape(-1, 3)
    if not len(flat):
        return np.zeros(3), np.ones(3), np.zeros(points.shape, dtype="<i2")
    low, high = flat.min(axis=0), flat.max(axis=0)
    origin = (low + high) / 2.0
    scale = np.maximum((high - low) / (2.0 * _STEPS), 1e-9)
    values = np.clip(np.round((points - origin) / scale), -_STEPS, _STEPS)
    return origin, scale, values.astype("<i2")


def read_tracks(data: bytes) -> list[Track]:
    """Return the tracks of a container, as :func:`pack` gives it."""
    length = int.from_bytes(data[4:8], "little")
    header: dict[str, Any] = json.loads(data[8 : 8 + length])
    payload = data[8 + length :]
    return [_read_track(row, len(header["points"]), payload) for row in header["tracks"]]


def _read_track(row: dict[str, Any], n_points: int, payload: bytes) -> Track:
    frames = row["frames"]
    shape = (frames, 3) if row["kind"] == "ball" else (frames, n_points, 3)
    values = np.frombuffer(payload, "<i2", math.prod(shape), row["offset"]).reshape(shape)
    contacts = None
    if row["contacts"] is not None:
        bits = np.frombuffer(payload, np.uint8, frames, row["contacts"])
        contacts = np.stack([bits & 1, bits >> 1], axis=1).astype(bool)
    return Track(
        row["name"],
        row["ref"],
        values * np.array(row["scale"]) + np.array(row["origin"]),
        contacts,
        row["start"],
        row["fps"],
        row["team"] or "",
        row.get("leg_length"),
    )
