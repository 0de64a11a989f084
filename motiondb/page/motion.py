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

The browser draws a figure of 26 points: the 21 joints of the canonical body and the ends of head,
hands and feet. It finds the rotations of its mannequin from them; where it cannot draw one, there
is a capsule from each point to its parent.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body, retarget, rotation
from motiondb.body.contacts import find_contacts
from motiondb.records import MOTION_FPS, FloatArray, IntArray, Motion

if TYPE_CHECKING:
    from motiondb.scene.language.tactics import Diagram
    from motiondb.scene.polish.polish import PolishedScene

MAGIC = b"MDBM"
MEDIA_TYPE = "application/x-motiondb"
_STEPS = 32767  # Largest value of a signed integer of 16 bits
POINTS: tuple[str, ...] = (
    *body.JOINTS,
    *(f"{body.JOINTS[joint].replace('wrist', 'hand')}_end" for joint, _ in body.END_SITES),
)  # Names of the points, in their order in arrays
PARENTS: tuple[int, ...] = (*body.PARENTS.tolist(), *(joint for joint, _ in body.END_SITES))
"""Index of each point's parent, -1 for the pelvis."""
_RADII = {
    "pelvis": 0.0,
    "hip": 0.10,
    "knee": 0.075,
    "ankle": 0.052,
    "toe": 0.042,
    "toe_end": 0.032,
    "spine": 0.115,
    "chest": 0.125,
    "neck": 0.06,
    "head": 0.055,
    "head_end": 0.095,
    "collar": 0.06,
    "shoulder": 0.062,
    "elbow": 0.047,
    "wrist": 0.037,
    "hand_end": 0.035,
}
"""Radius of the capsule that ends at each point, metres. They look like an adult's."""


RADII = tuple(_RADII[point[2:] if point[1] == "_" else point] for point in POINTS)
"""Radius of the capsule from each point to its parent, metres; 0 for the pelvis."""
_ENDS = [n for n, point in enumerate(POINTS) if point.endswith("_end")]
_MOST_STEP = 0.3  # Metres that a point moves in a frame at most; more is a fault of the capture
BALL_RADIUS = 0.12  # Radius of an object without a size, metres


def points_of(motion: Motion) -> FloatArray:
    """Return the points of a motion: array (frames, 26, 3).

    Metres on the standard body, right-handed world frame, y up, ground at y = 0.
    """
    positions, rotations = retarget.motion_positions(motion)
    ends = [
        positions[:, joint] + rotation.rotate(rotations[:, joint], np.array(offset))
        for joint, offset in body.END_SITES
    ]
    return np.concatenate([positions, np.stack(ends, axis=1)], axis=1)


def facing_forward(points: FloatArray) -> FloatArray:
    """Return points moved and turned so that the first frame is at the origin and faces +z.

    Shapes: `points` (frames, 26, 3).
    """
    left, right = POINTS.index("l_hip"), POINTS.index("r_hip")
    across = points[0, left] - points[0, right]
    heading = np.arctan2(
        -across[2], across[0]
    )  # angle of the axis to the left, which is +x when facing +z
    c, s = np.cos(-heading), np.sin(-heading)
    moved = points - points[0, 0] * np.array([1.0, 0.0, 1.0])
    x, z = moved[..., 0], moved[..., 2]
    return np.stack([c * x + s * z, moved[..., 1], c * z - s * x], axis=-1)


@dataclass(frozen=True, eq=False)
class BestFrames:
    """The part of a motion in which the body moves most, and the pose that shows it."""

    first: int
    stop: int  # The frame after the last
    pose: int  # The frame of the pose
    speed: float  # Mean speed of the points against the pelvis in the part, metres per second
    shape: FloatArray  # (11,): the pose as `shapes_of` gives it


def _at_ease() -> FloatArray:
    """Return the points of the standard body that stands with hanging arms: (1, 26, 3)."""
    offsets = [*body.OFFSETS, *(np.array(offset) for _, offset in body.END_SITES)]
    points = np.zeros((len(POINTS), 3))
    for n, (name, parent, offset) in enumerate(zip(POINTS, PARENTS, offsets)):
        if name[2:] in ("elbow", "wrist", "hand_end"):
            offset = np.array([0.0, -np.linalg.norm(offset), 0.0])
        points[n] = (0.0 if parent < 0 else points[parent]) + offset
    points[:, 1] -= points[:, 1].min()
    return points[None]


AT_EASE = _at_ease()


def shapes_of(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return poses as numbers, and how far each is from standing at ease: a raised leg, a seat.

    The numbers are the distances of head, hands and feet from the pelvis, and the heights of these
    and of the pelvis, metres; they do not depend on place or heading.

    Shapes: `points` (frames, 26, 3); result (frames, 11) and (frames,).
    """
    reach = np.linalg.norm(points[:, _ENDS] - points[:, :1], axis=-1)
    shapes = np.concatenate([reach, points[:, _ENDS, 1], points[:, 0, 1:2]], axis=1)
    ease = shapes[:1] if points is AT_EASE else shapes_of(AT_EASE)[0]
    return shapes, np.abs(shapes - ease).sum(axis=1)


def best_moment(points: FloatArray, length: int) -> BestFrames:
    """Return the part of `length` frames, or fewer, in which most happens.

    Its pose is the one farthest from standing at ease, as `shapes_of` says.

    Shapes: `points` (frames, 26, 3), at 30 frames a second.
    """
    seen = points - points[:, :1]
    shapes, unlike = shapes_of(points)
    steps = np.minimum(np.linalg.norm(np.diff(seen, axis=0), axis=-1), _MOST_STEP).mean(axis=-1)
    total = np.concatenate([[0.0], np.cumsum(steps)])
    n_steps = min(max(length, 1), len(points)) - 1
    moved = total[n_steps:] - total[: len(total) - n_steps]
    first = int(np.argmax(moved))
    stop = first + n_steps + 1
    pose = first + int(np.argmax(unlike[first:stop]))
    speed = float(moved[first]) / max(n_steps, 1) * MOTION_FPS
    return BestFrames(first, stop, pose, speed, shapes[pose])


def thinned(n_frames: int, fps: float, wanted: float) -> IntArray:
    """Return the indices of the frames to keep at a lower rate: array (frames,).

    >>> thinned(5, 30.0, 15.0).tolist()
    [0, 2, 4]
    """
    if wanted >= fps:
        return np.arange(n_frames)
    count = int(np.ceil(n_frames * wanted / fps))
    return np.minimum(np.round(np.arange(count) * fps / wanted).astype(np.int64), n_frames - 1)


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
    radius: float = BALL_RADIUS  # Of a ball, metres
    moment: float | None = None  # Of a thumbnail: time in the take of the pose that shows it


def body_track(
    name: str, ref: str, motion: Motion, start: float = 0.0, fps: float = MOTION_FPS
) -> Track:
    """Return the track of a motion, at the same or a lower frame rate."""
    points = points_of(motion)
    contacts = find_contacts(points[:, : len(body.JOINTS)])
    whole = Track(name, ref, points, contacts, start, leg_length=float(motion.leg_length))
    return part_of(whole, 0, len(points), fps)


def part_of(track: Track, low: int, high: int, fps: float) -> Track:
    """Return frames [low, high) of a track, at the same or a lower frame rate."""
    kept = low + thinned(max(high - low, 0), MOTION_FPS, fps)
    return replace(
        track,
        points=track.points[kept],
        contacts=None if track.contacts is None else track.contacts[kept],
        start=track.start + low / MOTION_FPS,
        fps=min(fps, MOTION_FPS),
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
        "points": POINTS,
        "parents": PARENTS,
        "radii": RADII,
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
        "moment": track.moment,
    }
    if is_ball:
        return facts | {"radius": track.radius}
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
        row.get("radius", BALL_RADIUS),
        row.get("moment"),
    )


def scene_tracks(
    motions: Mapping[str, Motion],
    teams: Mapping[str, str],
    ball: FloatArray,
    ref: str,
    size: float = 2.0 * BALL_RADIUS,
) -> list[Track]:
    """Return the tracks of a scene: its players with their roles, and the object (frames, 3)."""
    tracks = [
        replace(body_track(name, ref, motion), team=teams[name]) for name, motion in motions.items()
    ]
    if len(ball):
        tracks.append(Track("ball", ref, ball, radius=size / 2.0))
    return tracks


def pack_scene(polished: PolishedScene, diagram: Diagram, ref: str) -> bytes:
    """Return the motions of a polished scene as a container; no report is needed."""
    motions = {player.player: player.motion for player in polished.players}
    teams = {player.name: player.team for player in diagram.players}
    ball = polished.ball
    if ball is None:
        return pack(scene_tracks(motions, teams, np.zeros((0, 3)), ref))
    return pack(scene_tracks(motions, teams, ball.positions, ref, ball.size))
