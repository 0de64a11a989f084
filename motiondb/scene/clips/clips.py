"""The library of clips that a scene is made of, in a few arrays.

Notation: the library has K entries. Entry k is a piece of a capture, as it is or edited (mirrored,
bent, stretched), of terminal[k]. Entries are sorted by terminal, so that those of terminal t are
first[t] to first[t + 1], and drawing one of them uniformly is drawing one integer. Which entry may
follow which depends on poses, and bending and stretching do not change poses. So the cost of a seam
is stored by clip, ``seam[seam_class[a], seam_class[b]]``, and not by entry.

Places on the ground are (x, z, theta), see :mod:`.clip_cutting`. "In the entry frame"
means relative to the place of the body in the clip's first frame. ``step`` leads from there to the
frame after the last one, where the next clip begins.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), section 3.1 (clips of a terminal) and section 6 (key frames of events).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from motiondb.body import pose_vectors, retarget, rotation
from motiondb.errors import SceneError
from motiondb.records import MOTION_FPS, Event, Float32Array, FloatArray, IntArray, Motion
from motiondb.scene.clips.clip_cutting import (
    START,
    STOP,
    WRISTS,
    BodyFrames,
    Piece,
    ShownMotion,
    body_frames,
    compose,
    cut_action,
    instant,
    inverse,
    travels,
)

# Variants of clips: the path of a clip on the ground, bent and stretched.


def _radians(*degrees: float) -> tuple[float, ...]:
    return tuple(math.radians(angle) for angle in degrees)


@dataclass(frozen=True)
class VariantSettings:
    """Which variants are made of every clip.

    The values were chosen by hand: bends and stretches beyond these look wrong in pictures.

    A capture follows its own path; a scene needs others. A variant of a clip has

        heading'(t) = heading(t) + bend * t / n                     bend in radians, n frames
        step'(t)    = stretch * R(bend * (t + 1/2) / n) step(t)     the steps between frames

    so that its poses, relative to their places on the ground, are those of the clip. Feet slide by
    the edit of the path; polishing removes this.

    Travelling clips are bent and stretched. Those that begin or end at rest may turn farther,
    because people turn with their first step. Clips in place are turned a little.
    """

    bends: tuple[float, ...] = _radians(-40, -20, -10, 0, 10, 20, 40)  # Bends of clips that travel
    # Factors of the steps of clips that travel
    stretches: tuple[float, ...] = (0.7, 0.85, 1.0, 1.15, 1.3)
    # Bends of first and last steps
    rest_bends: tuple[float, ...] = _radians(-90, -60, -40, -20, 0, 20, 40, 60, 90)
    turns: tuple[float, ...] = _radians(-30, -15, 0, 15, 30)  # Bends of clips that stay in place
    mirror: bool = True  # Whether mirror images are made
    # Approximate largest number of pieces of one terminal before variants, separately for those
    # that travel and those that stay. Above it, captures are left out evenly
    most: int = 96


TRAVELS = 0.3  # Distance between the ends of a piece, m, from which on it counts as travelling
STEPS = 0.1  # The same for a first or last step, m
MOST_TURNING = math.radians(240.0)
"""Fastest bend, rad/s. Chosen by hand: people who run turn no faster."""


def edits_of(path: FloatArray, kind: str, settings: VariantSettings) -> FloatArray:
    """Return the variants of a piece.

    Shapes: `path` (n + 1, 3), m and rad; result (variants, 2), rad and factor.
    """
    way, seconds = float(np.hypot(path[-1, 0], path[-1, 1])), (len(path) - 1) / MOTION_FPS
    bends = settings.bends if way >= TRAVELS else settings.turns
    bends = settings.rest_bends if kind in (START, STOP) and way >= STEPS else bends
    stretches = settings.stretches if way >= TRAVELS else (1.0,)
    return np.array(
        [
            (bend, stretch)
            for bend in bends
            if abs(bend) <= MOST_TURNING * seconds + 1e-9
            for stretch in stretches
        ]
    ).reshape(-1, 2)


def edited_paths(path: FloatArray, edits: FloatArray) -> FloatArray:
    """Return the path of every variant: array (variants, n + 1, 3), from path (n + 1, 3).

    >>> straight = np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    >>> edited_paths(straight, np.array([[np.pi, 0.5]])).round(6).tolist()
    [[[0.0, 0.0, 0.0], [0.5, 0.0, 3.141593]]]
    """
    return _edited(path, np.linspace(0.0, 1.0, len(path)), edits)


def edited_stretch(path: FloatArray, shares: FloatArray, bend: float, stretch: float) -> FloatArray:
    """Return one variant's path (frames, 3); frame t has turned by ``shares[t] * bend``."""
    return np.asarray(_edited(path, shares, np.array([[bend, stretch]]))[0])


def _edited(path: FloatArray, shares: FloatArray, edits: FloatArray) -> FloatArray:
    turn = edits[:, :1] * shares
    middle = (turn[:, 1:] + turn[:, :-1]) / 2.0
    step = np.diff(path[:, :2], axis=0)
    c, s = edits[:, 1:] * np.cos(middle), edits[:, 1:] * np.sin(middle)
    steps = np.stack([step[:, 0] * c + step[:, 1] * s, step[:, 1] * c - step[:, 0] * s], axis=-1)
    edited = np.empty((len(edits), len(path), 3))
    edited[:, 0, :2] = path[0, :2]
    edited[:, 1:, :2] = path[0, :2] + np.cumsum(steps, axis=1)
    edited[:, :, 2] = path[:, 2] + turn
    return edited


# The cost of a seam: how badly one clip follows another.

POSE_SCALE = 0.10  # Distance of joints, m, that costs 1. Chosen by hand: a viewer sees the blend
VELOCITY_SCALE = 1.0  # Difference of velocities, m/s, that costs 1
_BLOCK = 128  # Clips compared at once. It bounds the memory; the result does not depend on it


@dataclass(frozen=True, eq=False)
class SeamEnds:
    """The beginnings and ends of clips.

    Notation: clip a ends in the frame after its last one, with joints x and velocities v seen from
    its place on the ground. Clip b begins with x' and v'. The cost is 0 if b truly follows a in its
    capture; otherwise

        g(a, b) = mean_j |x_j - x'_j| / POSE_SCALE  +  mean_j |v_j - v'_j| / VELOCITY_SCALE

    over the 21 joints: 1 for joints that are 10 cm apart, or differ by 1 m/s, on average. The form
    is that of J. Lee, J. Chai, P. Reitsma, J. Hodgins and N. Pollard, "Interactive control of
    avatars animated with human motion data" (SIGGRAPH 2002). The paper on motion grammars names
    pose and velocity and gives no weights; ours were chosen by hand.
    """

    captures: IntArray  # (clips,), int: a number per capture, and another one for its mirror image
    starts: IntArray  # (clips,), int: first frame in the capture
    ends: IntArray  # (clips,), int: frame after the last one
    # (clips, 2, joints, 3), m and m/s: joints and velocities at the first frame
    entries: FloatArray
    # (clips, 2, joints, 3), m and m/s: joints and velocities at the frame after the last
    exits: FloatArray


def seam_costs(clips: SeamEnds) -> Float32Array:
    """Return g(a, b) of every clip a and b: array (clips, clips), float32; see the module."""
    scales = np.array([POSE_SCALE, VELOCITY_SCALE])[:, None, None]
    exits = (clips.exits / scales).astype(np.float32)
    entries = (clips.entries / scales).astype(np.float32)
    n_clips, n_joints = len(exits), exits.shape[2]
    costs = np.zeros((n_clips, n_clips), dtype=np.float32)
    for low in range(0, n_clips, _BLOCK):
        for what in range(2):
            for joint in range(n_joints):
                a, b = exits[low : low + _BLOCK, what, joint], entries[:, what, joint]
                square = np.square(a[:, None, 0] - b[None, :, 0])
                square += np.square(a[:, None, 1] - b[None, :, 1])
                square += np.square(a[:, None, 2] - b[None, :, 2])
                costs[low : low + _BLOCK] += np.sqrt(square)
    costs /= n_joints
    same = clips.captures[:, None] == clips.captures[None, :]
    costs[same & (clips.ends[:, None] == clips.starts[None, :])] = 0.0
    return costs


def rest_costs(clips: SeamEnds) -> Float32Array:
    """Return the costs of starting every clip from standing, and of stopping after it.

    It is the cost of a seam between equal poses, one of them without velocity.

    Shapes: result (clips, 2), float32.
    """
    ends = np.stack([clips.entries[:, 1], clips.exits[:, 1]], axis=1)
    speeds = np.linalg.norm(ends, axis=-1).mean(axis=-1)
    return np.asarray(speeds / VELOCITY_SCALE, dtype=np.float32)


Int32Array = NDArray[np.int32]

_SIDES = {"left": "right", "right": "left"}
_ONE_HANDED = "release"


@dataclass(frozen=True)
class ClipSource:
    """The origin of an entry."""

    capture: str  # Name of the capture
    start: int  # Its first frame in the capture
    end: int  # The frame after its last one
    mirrored: bool = False  # Whether left and right are exchanged
    bend: float = 0.0  # Turn over the whole entry
    stretch: float = 1.0  # Factor of the steps
    licence: str = ""  # Licence of the capture
    # How the event is known: "events" if annotated, "wrists" if estimated from them, "motion" if
    # the grammar says how, "" if the action has none
    instant: str = ""

    @property
    def edit(self) -> str:
        """The edits of the capture's frames, for provenance; "" for nothing.

        >>> ClipSource("run", 0, 9, mirrored=True, bend=np.radians(20), stretch=0.85).edit
        'mirror, bend 20 deg, stretch 0.85'
        """
        done = ["mirror"] if self.mirrored else []
        done += [f"bend {np.degrees(self.bend):.0f} deg"] if self.bend else []
        done += [f"stretch {self.stretch:g}"] if self.stretch != 1.0 else []
        return ", ".join(done)


@dataclass(frozen=True, eq=False)
class ClipLibrary:
    """All entries of all terminals: T terminals, K entries, C clips (see the module)."""

    terminals: tuple[str, ...]  # Names of the terminals
    terminal: Int32Array  # (K,), int32: index into ``terminals``, ascending
    first: Int32Array  # (T + 1,), int32: the entries of terminal t are first[t]:first[t + 1]
    n_frames: Int32Array  # (K,), int32: frames, 30 a second
    step: FloatArray  # (K, 3), m and rad: from an entry's first frame to where the next clip begins
    # (K,), int32: frame of the event counted from the entry's first; -1 if there is none, then the
    # middle counts
    event_frame: Int32Array
    path_start: Int32Array  # (K,), int32: row of ``path`` of an entry's first frame
    path: FloatArray  # (sum of frames, 3), m and rad: places of all frames in the entry frame
    seam: Float32Array  # (C, C), float32: cost of a seam
    seam_class: Int32Array  # (K,), int32: the clip of an entry
    # (K, 3), m: x, y, z in the entry frame of the ball at the event: the mean of the wrists, or the
    # wrist that has the ball if they are far apart
    hand: FloatArray
    source: tuple[ClipSource, ...]  # The origins of the entries
    # Events of each of the C clips, frames counted from its first
    events: tuple[tuple[Event, ...], ...] = ()
    # (C, 2), float32: cost of a seam from standing in a clip's first pose to the clip, and from the
    # clip to standing in the pose after its last: for players who begin later or end earlier than
    # others
    rest: Float32Array = field(default_factory=lambda: np.zeros((0, 2), dtype=np.float32))

    def of(self, terminal: str) -> range:
        """Return the entries of a terminal by its name."""
        number = self.terminals.index(terminal)
        return range(int(self.first[number]), int(self.first[number + 1]))

    def path_of(self, entry: int) -> FloatArray:
        """Return the places of an entry's frames in the entry frame, array (n_frames, 3)."""
        begin = int(self.path_start[entry])
        return self.path[begin : begin + int(self.n_frames[entry])]

    def instant_of(self, entry: int) -> int:
        """Return the frame at which rules look, counted from the first: the event or the middle."""
        event = int(self.event_frame[entry])
        return event if event >= 0 else (int(self.n_frames[entry]) - 1) // 2


@dataclass(frozen=True, eq=False)
class _Clip:
    """A piece before its variants; ``event`` is a frame of the capture, -1 for none."""

    terminal: int
    capture: int
    frames: BodyFrames
    piece: Piece
    source: ClipSource
    event: int
    joint: str
    events: tuple[Event, ...]
    thrown: bool


def make_library(
    shown: Sequence[ShownMotion],
    terminals: Sequence[str],
    settings: VariantSettings | None = None,
) -> ClipLibrary:
    """Cut captures into clips; mirror, bend and stretch these; and compare all their ends.

    `shown`: Parts of captures. Parts of one capture must hold the same ``motion`` object, or it is
    analysed more than once.

    `terminals`: Names in the order of the library; one without a clip has no entries.
    """
    settings = settings or VariantSettings()
    clips = _clips(shown, tuple(terminals), settings)
    clips.sort(key=lambda clip: clip.terminal)
    paths: list[FloatArray] = []
    sources: list[ClipSource] = []
    kinds: list[int] = []
    hands: list[FloatArray] = []
    for number, clip in enumerate(clips):
        piece = clip.piece
        path = clip.frames.path(piece.start, piece.end)
        edits = edits_of(path, piece.kind, settings)
        edited = edited_paths(path, edits)
        paths.extend(edited)
        kinds.extend([number] * len(edits))
        sources.extend(
            replace(clip.source, bend=bend, stretch=stretch) for bend, stretch in edits.tolist()
        )
        hands.append(_hands(clip, edited))
    kind = np.array(kinds, dtype=np.int32)
    terminal = np.array([clip.terminal for clip in clips], dtype=np.int32)[kind]
    lengths = np.array([len(path) - 1 for path in paths], dtype=np.int32)
    ends = _ends(clips)
    events = [c.event - c.piece.start if c.event >= 0 else -1 for c in clips]
    return ClipLibrary(
        terminals=tuple(terminals),
        terminal=terminal,
        first=np.searchsorted(terminal, np.arange(len(terminals) + 1)).astype(np.int32),
        n_frames=lengths,
        step=np.array([path[-1] for path in paths]).reshape(-1, 3),
        event_frame=np.array(events, dtype=np.int32)[kind],
        path_start=(np.cumsum(lengths) - lengths).astype(np.int32),
        path=np.concatenate([path[:-1] for path in paths]) if paths else np.zeros((0, 3)),
        seam=seam_costs(ends),
        seam_class=kind,
        hand=np.concatenate(hands) if hands else np.zeros((0, 3)),
        source=tuple(sources),
        events=tuple(clip.events for clip in clips),
        rest=rest_costs(ends),
    )


def _clips(
    shown: Sequence[ShownMotion], terminals: tuple[str, ...], settings: VariantSettings
) -> list[_Clip]:
    """Return all clips before their variants, with mirror images, about ``most`` a terminal."""
    analysed: dict[int, BodyFrames] = {}
    for one in shown:
        if id(one.motion) not in analysed:
            analysed[id(one.motion)] = body_frames(one.motion)
    numbers = {key: number for number, key in enumerate(analysed)}
    clips: list[_Clip] = []
    for one in _enough(shown, analysed, settings.most):
        frames, number = analysed[id(one.motion)], terminals.index(one.terminal)
        clips.extend(
            _clip(one, piece, frames, number, numbers[id(one.motion)])
            for piece in cut_action(one, frames)
        )
    if not settings.mirror:
        return clips
    images = [frames.mirrored() for frames in analysed.values()]
    return clips + [
        _mirrored(clip, other, images[clip.capture], len(analysed))
        for clip, other in ((c, _image_of(terminals, c)) for c in clips)
        if other is not None
    ]


def _enough(
    shown: Sequence[ShownMotion], analysed: Mapping[int, BodyFrames], most: int
) -> list[ShownMotion]:
    """Return parts of every terminal with ``most`` pieces, apart for travelling and standing."""
    kinds: dict[tuple[str, bool], list[tuple[ShownMotion, int]]] = {}
    for one in shown:
        frames = analysed[id(one.motion)]
        kind = one.terminal, travels(frames, one.start, one.end)
        kinds.setdefault(kind, []).append((one, len(cut_action(one, frames))))
    return [one for counted in kinds.values() for one in _evenly(counted, most)]


def _evenly(counted: list[tuple[ShownMotion, int]], most: int) -> list[ShownMotion]:
    """Return evenly spaced parts that together have at most ``most`` pieces; at least one part."""
    for count in range(len(counted), 1, -1):
        chosen = [counted[k] for k in np.linspace(0, len(counted) - 1, count).round().astype(int)]
        if sum(pieces for _, pieces in chosen) <= most:
            return [one for one, _ in chosen]
    return [one for one, _ in counted[:1]]


def _clip(
    shown: ShownMotion, piece: Piece, frames: BodyFrames, terminal: int, capture: int
) -> _Clip:
    event, known = instant(shown, frames, piece.start, piece.end)
    inside = tuple(
        replace(e, frame=e.frame - piece.start)
        for e in sorted(shown.events)
        if piece.start <= e.frame < piece.end
    )
    joints = [e.joint for e in inside if e.name == shown.event and e.frame == event - piece.start]
    source = ClipSource(shown.capture, piece.start, piece.end, licence=shown.licence, instant=known)
    joint = joints[0] if joints and known == "events" else ""
    thrown = shown.event == _ONE_HANDED
    return _Clip(terminal, capture, frames, piece, source, event, joint, inside, thrown)


def _image_of(terminals: tuple[str, ...], clip: _Clip) -> int | None:
    """Return the terminal that a clip's mirror image shows (pivot_right for pivot_left), or None.

    Shots and passes have no mirror image: the ball would be thrown with the other hand.
    """
    name = terminals[clip.terminal]
    if clip.thrown:
        return None
    image = "_".join(_SIDES.get(part, part) for part in name.split("_"))
    return terminals.index(image) if image in terminals else None


def _mirrored(clip: _Clip, terminal: int, image: BodyFrames, n_captures: int) -> _Clip:
    events = tuple(replace(e, joint=_other_side(e.joint)) for e in clip.events)
    return replace(
        clip,
        terminal=terminal,
        capture=clip.capture + n_captures,
        frames=image,
        source=replace(clip.source, mirrored=True),
        joint=_other_side(clip.joint),
        events=events,
    )


def _other_side(joint: str) -> str:
    return {"l": "r", "r": "l"}[joint[0]] + joint[1:] if joint[:2] in ("l_", "r_") else joint


APART = 0.4
"""Distance between the wrists, m, above which one of them has the ball. Chosen by hand: a ball is
0.24 m wide."""


def _hands(clip: _Clip, paths: FloatArray) -> FloatArray:
    """Return the position of the ball of every variant, array (variants, 3), in the entry frame."""
    piece = clip.piece
    frame = clip.event if clip.event >= 0 else (piece.start + piece.end - 1) // 2
    wrists = clip.frames.joints[min(frame, clip.frames.n_frames - 1), WRISTS]
    ball = wrists.mean(axis=0)
    if clip.joint in ("l_wrist", "r_wrist") and np.linalg.norm(wrists[0] - wrists[1]) > APART:
        ball = wrists["lr".index(clip.joint[0])]
    place = compose(paths[:, frame - piece.start], np.array([ball[0], ball[2], 0.0]))
    return np.column_stack([place[:, 0], np.full(len(place), ball[1]), place[:, 1]])


def _ends(clips: Sequence[_Clip]) -> SeamEnds:
    def state(clip: _Clip, frame: int) -> FloatArray:
        inside = min(frame, clip.frames.n_frames - 1)
        return np.stack([clip.frames.joints[inside], clip.frames.velocities[inside]])

    shape = (len(clips), 2, 21, 3)
    return SeamEnds(
        np.array([c.capture for c in clips], dtype=np.int64),
        np.array([c.piece.start for c in clips], dtype=np.int64),
        np.array([c.piece.end for c in clips], dtype=np.int64),
        np.array([state(c, c.piece.start) for c in clips]).reshape(shape),
        np.array([state(c, c.piece.end) for c in clips]).reshape(shape),
    )


# The poses of a library entry: frames of its capture, mirrored, bent and stretched.


def source_frames(source: ClipSource, n_frames: int, before: int = 0, after: int = 0) -> IntArray:
    """Return the frames of an entry's capture, with more frames at both ends for blending.

    Before the beginning and after the end of the capture its first and last frames are repeated.

    Shapes: result (before + frames + after,), int.

    Only polishing needs poses; sampling uses places alone.
    """
    frames = np.arange(source.start - before, source.end + after)
    return np.asarray(np.clip(frames, 0, n_frames - 1))


def clip_motion(
    source: ClipSource,
    motions: Mapping[str, Motion],
    at: tuple[float, float, float] = (0.0, 0.0, 0.0),
    before: int = 0,
    after: int = 0,
) -> Motion:
    """Return the motion of an entry, placed on the ground.

    `before`: Frames of the capture added before the entry, for blending. They are stretched like
    the entry, and bend no further.
    """
    motion = captured(source, motions)
    motion = retarget.mirror(motion) if source.mirrored else motion
    frames = source_frames(source, motion.n_frames, before, after)
    local, heading = pose_vectors.heading_rotations(motion)
    root = motion.root_positions[frames].astype(np.float64)
    path = np.column_stack([root[:, 0], root[:, 2], heading[frames]])
    length = source.end - source.start
    shares = np.clip((np.arange(len(frames)) - before) / length, 0.0, 1.0)
    path = edited_stretch(path, shares, source.bend, source.stretch)
    placed = compose(compose(np.asarray(at), inverse(path[before])), path)
    turned = local[frames]
    turned[:, 0] = rotation.multiply(pose_vectors.yaw(placed[:, 2]), turned[:, 0])
    positions = np.column_stack([placed[:, 0], root[:, 1], placed[:, 1]])
    return Motion(
        rotation.unroll(turned).astype(np.float32),
        positions.astype(np.float32),
        motion.leg_length,
        motion.notes,
    )


def captured(source: ClipSource, motions: Mapping[str, Motion]) -> Motion:
    """Return the motion of the capture that a clip was taken from."""
    if source.capture not in motions:
        raise SceneError(
            f"{source.capture}: expected the capture that a clip was taken from, found none of"
            " this name. Add it again, or make the scene again."
        )
    return motions[source.capture]
