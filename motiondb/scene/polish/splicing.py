"""A player's clips spliced into one motion, and shown in edited time on an edited path.

Every clip is taken from its capture with more frames at both ends, mirrored, bent and stretched
like its entry. Neighbours are cross-faded by :mod:`motiondb.generate.stitching`: their paths as
steps and turns, their poses as rotations relative to the heading. A player who waits does not
freeze: a clip in place is played forwards and backwards. The result has the frames of the string in
order, and the clip and frame that each comes from. To show it, time is read at the frames of the
scene (poses interpolated along the shortest arc), the edited path replaces the own one, and feet
are held where they stand.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body, features, kinematics, pose_vectors, retarget, rotation
from motiondb.body.contacts import FEET, find_contacts, foot_heights
from motiondb.body.features import runs
from motiondb.generate.contact import lock_feet
from motiondb.generate.stitching import BLEND_FRAMES, Piece, stitch
from motiondb.records import MOTION_FPS, FloatArray, IntArray, Motion
from motiondb.scene.clips.clip_cutting import compose, inverse, relative
from motiondb.scene.clips.clips import ClipSource, captured, clip_motion
from motiondb.scene.timing.playing import Part

# Small steps in place: feet stay where they are until the body has turned or moved too far.


SWING = 9  # Frames of a step: 0.3 s
LIFT = 0.07  # Height to which a stepping foot is raised, m
APART, TURNED = 0.09, np.radians(25.0)
"""Distance, m, and turn, rad, from its place at which a foot steps."""
_SETTLED, _SOLE = 0.015, 0.02
"""Distance, m, at which a foot needs no last step; lowest height of a toe, m."""
_I = body.INDEX


def footing(wanted: FloatArray, leading: bool) -> FloatArray:
    """Return both feet's places while a player stands: array (frames, 2, 4), x, y, z and heading.

    Shapes: `wanted` (frames, 2, 4), m and rad.

    >>> still = np.zeros((40, 2, 4))
    >>> bool((footing(still, True) == 0.0).all())
    True

    A body that is turned or shifted over a clip of standing would drag its feet or twist its legs.
    While a player waits, each foot has its own place. It stays there until it is 9 cm or 25 degrees
    from where the clip would have it. Then, if the other foot is down, it is lifted and set down
    within 0.3 s where the clip will have it. Before the wait ends, both feet step to where the next
    clip has them.
    """
    n_frames = len(wanted)
    positions = np.repeat(wanted[:1], n_frames, axis=0)
    floor = np.minimum(wanted[0, :, 1], np.quantile(wanted[:, :, 1], 0.2, axis=0))
    fading = np.clip(1.0 - np.arange(n_frames) / SWING, 0.0, 1.0)
    positions[:, :, 1] = floor + (wanted[0, :, 1] - floor) * fading[:, None]
    busy = 0
    for frame in range(1, n_frames - SWING):
        if frame < busy:
            continue
        off = [_off(positions[frame, foot], wanted[frame, foot]) for foot in range(2)]
        foot = int(np.argmax(off))
        left = n_frames - 1 - frame
        settle = leading and left in (SWING, 2 * SWING) and off[foot] > _SETTLED
        if off[foot] < APART and not settle:
            continue
        if leading and not settle and left < 3 * SWING:
            continue  # the last two steps are kept for the end
        landing = min(frame + SWING + SWING // 2, n_frames - 1)
        landing = n_frames - 1 if settle else landing
        _step(positions[:, foot], wanted[landing, foot], frame)
        busy = frame + SWING
    return positions


def _off(now: FloatArray, wanted: FloatArray) -> float:
    """Return how far a foot is from where it should be, m; 25 degrees count as 9 cm."""
    turn = abs(float(now[3] - wanted[3])) * APART / TURNED
    return max(float(np.hypot(now[0] - wanted[0], now[2] - wanted[2])), turn)


def _step(places: FloatArray, to: FloatArray, frame: int) -> None:
    """Lift a foot at ``frame``, set it down SWING frames later, and leave it there."""
    since = places[frame].copy()
    share = np.linspace(0.0, 1.0, SWING + 1)
    smooth = (share * share * (3.0 - 2.0 * share))[:, None]
    here = slice(frame, frame + SWING + 1)
    ground = places[here, 1].copy()
    places[here] = since + smooth * (to - since)
    far = min(1.0, float(np.hypot(*(to - since)[[0, 2]])) / APART + abs(to[3] - since[3]) / TURNED)
    places[here, 1] = ground + LIFT * far * np.sin(np.pi * share)
    places[frame + SWING :, [0, 2, 3]] = to[[0, 2, 3]]


def step_feet(motion: Motion, waits: NDArray[np.bool_]) -> Motion:
    """Return the motion with its feet standing or stepping while it ``waits``, array (frames,)."""
    if not waits.any():
        return motion
    positions, world = retarget.motion_positions(motion)
    wanted = _wanted(positions, world)
    target, moved = wanted.copy(), np.zeros(len(wanted), dtype=bool)
    for start, end in runs(waits):
        if end - start > SWING:
            target[start:end] = footing(wanted[start:end], end < len(wanted))
            moved[start:end] = True
    toes = positions[:, [_I["l_toe"], _I["r_toe"]], 1] - wanted[:, :, 1]
    target[:, :, 1] = np.maximum(target[:, :, 1], _SOLE - toes)
    turns = target[:, :, 3] - wanted[:, :, 3]
    return move_ankles(motion, (positions, world), target[:, :, :3], moved, turns)


def move_ankles(
    motion: Motion,
    joints: tuple[FloatArray, FloatArray],
    target: FloatArray,
    moved: NDArray[np.bool_],
    turns: FloatArray | None = None,
) -> Motion:
    """Return the motion with its ankles moved by two-bone inverse kinematics.

    Shapes: `target` (frames, 2, 3), m; `moved` (frames,), bool; `turns` (frames, 2), rad.
    """
    positions, world = joints
    local = motion.local_rotations.astype(np.float64)
    ahead = rotation.rotate(world[:, 0], np.broadcast_to([0.0, 0.0, 1.0], (len(world), 3)))
    for foot, side in enumerate("lr"):
        hip, knee, ankle = (_I[f"{side}_{j}"] for j in ("hip", "knee", "ankle"))
        upper, lower = kinematics.two_bone(
            positions[:, hip], positions[:, knee], positions[:, ankle], target[:, foot], ahead
        )
        new_hip = rotation.multiply(upper, world[:, hip])
        new_knee = rotation.multiply(lower, world[:, knee])
        new_ankle = world[:, ankle]
        if turns is not None:
            new_ankle = rotation.multiply(pose_vectors.yaw(turns[:, foot]), new_ankle)
        for joint, turned in (
            (hip, rotation.relative(world[:, 0], new_hip)),
            (knee, rotation.relative(new_hip, new_knee)),
            (ankle, rotation.relative(new_knee, new_ankle)),
        ):
            local[moved, joint] = turned[moved]
    return replace(motion, local_rotations=rotation.unroll(local).astype(np.float32))


def _wanted(positions: FloatArray, world: FloatArray) -> FloatArray:
    """Return ankles and the heading of the body: array (frames, 2, 4)."""
    heading = np.unwrap(features.headings(world))
    feet = positions[:, [_I["l_ankle"], _I["r_ankle"]]]
    return np.concatenate([feet, np.repeat(heading[:, None, None], 2, axis=1)], axis=2)


# Steps at seams: a foot that would slide from one place to another is lifted there.

LIFTED = 0.025  # Height, m, above which a foot is seen to be lifted
SLIDE = 0.05  # Shortest slide that becomes a step, m: shorter ones are hardly visible
_STILL = 0.3
"""Speed of a foot, m/s, up to which it does not slide. With .15, a slide could not be told from a
slow lift of the foot after it."""
_PAUSE = 2  # Frames of rest between two slides that are one step
_QUICKEST = 4  # Fewest frames between the ends of a step; a slide with less time is left
ANKLES = [body.INDEX["l_ankle"], body.INDEX["r_ankle"]]
TOES = [body.INDEX["l_toe"], body.INDEX["r_toe"]]


@dataclass(frozen=True)
class Slide:
    """A slide of a foot.

    Where two clips are blended in which the feet stand differently, a foot moves from the place of
    the one to that of the other within a few frames, on the ground. People take a step. So every
    slide, a run of frames in which the foot moves without being lifted, becomes a step: the foot
    stays where it was, is lifted, and is set down within 0.3 s where the next clip has it. If both
    feet slide at once, the one that has farther to go steps first, and the other as soon as it is
    down.
    """

    foot: int  # 0 for the left foot, 1 for the right
    start: int  # Last frame at the old place
    end: int  # First frame at the new place
    # Horizontal distance between the places: that of the ankle or the toe, whichever is smaller
    metres: float


def find_slides(joints: FloatArray, blended: NDArray[np.bool_]) -> list[Slide]:
    """Find where feet slide in blends, in the order of time.

    Shapes: `joints` (frames, 21, 3), m; `blended` (frames,), bool.
    """
    heights, slides = foot_heights(joints), []
    for foot in range(2):
        ends = joints[:, [ANKLES[foot], TOES[foot]]][:, :, [0, 2]]
        steps = np.linalg.norm(np.diff(ends, axis=0), axis=-1).min(axis=1) * MOTION_FPS
        moving = steps > _STILL  # from each frame to the next
        for start, end in runs(~moving):
            if start > 0 and end < len(moving) and end - start <= _PAUSE:
                moving[start:end] = True
        for start, end in runs(moving):
            inside = slice(start, end + 1)
            far = float(np.linalg.norm(ends[end] - ends[start], axis=-1).min())
            on_ground = heights[inside, foot].max() <= LIFTED
            short = end - start <= SWING  # a longer one is a low swing of a capture
            if on_ground and short and far > SLIDE and blended[inside].any():
                slides.append(Slide(foot, start, end, far))
    return sorted(slides, key=lambda slide: (slide.start, slide.foot))


def step_at_seams(motion: Motion, blended: NDArray[np.bool_]) -> Motion:
    """Return the motion with a step in place of each slide of a foot; `blended` (frames,), bool."""
    if not blended.any():
        return motion
    positions, world = retarget.motion_positions(motion)
    target = positions[:, ANKLES].astype(np.float64)
    slides = find_slides(positions, blended)
    for slide, (start, end) in zip(slides, _times(slides, foot_heights(positions) > LIFTED)):
        if end - start >= _QUICKEST:
            _lift(target[:, slide.foot], slide, start, end)
    moved = (target != positions[:, ANKLES]).any(axis=(1, 2))
    return move_ankles(motion, (positions, world), target, moved) if moved.any() else motion


def _times(slides: list[Slide], lifted: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return the first and the last frame of the step for each slide.

    A step takes SWING frames around its slide, or as many as the slide. Where both feet slide at
    once, each has SWING frames, before and after the middle. A step keeps to the frames around the
    slide in which its foot is not lifted.
    """
    times = []
    for slide in slides:
        middle = (slide.start + slide.end) // 2
        half = max(SWING, slide.end - slide.start) / 2.0
        start, end = round(middle - half), round(middle + half)
        for other in slides:
            if other.foot != slide.foot and other.start < slide.end and slide.start < other.end:
                middle = (slide.start + slide.end + other.start + other.end) // 4
                is_first = (-slide.metres, slide.foot) < (-other.metres, other.foot)
                start, end = (middle - SWING, middle) if is_first else (middle, middle + SWING)
        up = np.flatnonzero(lifted[:, slide.foot])
        before, after = up[up < slide.start], up[up > slide.end]
        least = int(before[-1]) + 1 if len(before) else 0
        most = int(after[0]) - 1 if len(after) else len(lifted) - 1
        times.append((max(start, least), min(end, most)))
    return times


def _lift(ankle: FloatArray, slide: Slide, start: int, end: int) -> None:
    """Hold an ankle, array (frames, 3), up to ``start``, and set it down again at ``end``."""
    first, last = min(slide.start, start), max(slide.end, end)
    frames = slice(first, last + 1)
    share = np.clip((np.arange(first, last + 1) - start) / (end - start), 0.0, 1.0)
    smooth = (share * share * (3.0 - 2.0 * share))[:, None]
    away = ankle[last, [0, 2]] - ankle[first, [0, 2]]
    ankle[frames, 0::2] = ankle[first, 0::2] + smooth * away
    ankle[frames, 1] += LIFT * min(1.0, slide.metres / APART) * np.sin(np.pi * share)


_MARGIN = 20
"""Frames of the capture around a clip that are used: for the blend, and for velocities at its
ends."""
_HALF = BLEND_FRAMES // 2  # Frames of a blend on each side of a seam


@dataclass(frozen=True, eq=False)
class Spliced:
    """A player's string as one sequence of frames, at the pace of the captures."""

    lead: int  # Frames of waiting before the string's first
    places: FloatArray  # (frames, 3), m and rad: the path as spliced, from the first clip's place
    heights: FloatArray  # (frames,), m: height of the pelvis
    # (frames, 21, 4): local rotations; that of the pelvis is relative to the heading
    rotations: FloatArray
    parts: tuple[Part, ...]
    part: IntArray  # (frames,), int: index of the part with the largest weight
    source_frames: IntArray  # (frames,), int: its frame of the capture
    shares: FloatArray  # (frames,): its weight; 1 away from seams
    # (frames, 2), bool: whether the left and the right foot stand in the capture
    contacts: NDArray[np.bool_]

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.heights)

    @property
    def waits(self) -> NDArray[np.bool_]:
        """Whether the player stands and waits: array (frames,)."""
        return np.array([part.waits for part in self.parts])[self.part]

    def rows(self, source: FloatArray) -> FloatArray:
        """Return rows of the arrays, possibly between two, at frames of the string, ends held."""
        return np.clip(source + self.lead, 0.0, self.n_frames - 1.0)

    def shown_frames(self, at: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the capture's frames at rows ``at``, and how many of them pass in a row.

        Between two rows of one part, the frame is interpolated. Where another part begins it is
        that of the nearer row, because there is no frame between those of two captures.
        """
        before, nearest = np.floor(at).astype(np.int64), np.rint(at).astype(np.int64)
        after = np.minimum(before + 1, self.n_frames - 1)
        same = (self.part[before] == self.part[after]) & (after > before)
        rate = np.where(same, self.source_frames[after] - self.source_frames[before], 0)
        return self.source_frames[nearest] + (at - nearest) * rate, np.where(same, rate, 1.0)


@dataclass(frozen=True, eq=False)
class Taken:
    """A source with its margins: path values, rotations, frames, contacts."""

    path: FloatArray
    rotations: FloatArray
    frames: IntArray
    contacts: NDArray[np.bool_]


Shelf = dict[tuple[ClipSource, bool], Taken]
"""Sources that were taken already, to be played, or to wait in (True)."""


def splice(
    parts: Sequence[Part],
    motions: Mapping[str, Motion],
    origin: FloatArray,
    shelf: Shelf | None = None,
) -> Spliced:
    """Return parts one after another, the string's first one beginning at ``origin``.

    Shapes: `origin` (3,), m and rad.

    `parts`: Of the string, with those before it, whose ``clip`` is -1, and after it.
    """
    shelf = {} if shelf is None else shelf
    played, pieces = {}, []
    shown: dict[int, IntArray] = {}
    stands: dict[int, NDArray[np.bool_]] = {}
    for number, part in enumerate(parts):
        key = part.source, part.waits
        if key not in shelf:
            shelf[key] = _taken(part.source, motions, part.waits)
        taken, start = shelf[key], 0 if part.waits else _HALF
        taken = _waiting(taken, part.n_frames) if part.waits else taken
        played[number] = taken.path, taken.rotations
        shown[number], stands[number] = taken.frames, taken.contacts
        pieces.append(Piece(number, start, start + part.n_frames))
    whole = stitch(pieces, played)
    begin = sum(part.n_frames for part in parts if part.clip < 0)
    frames = np.zeros(len(whole.path), dtype=np.int64)
    contacts = np.zeros((len(frames), 2), dtype=bool)
    for number, which in shown.items():
        here = whole.captures == number
        frames[here] = which[whole.frames[here]]
        contacts[here] = stands[number][whole.frames[here]]
    return Spliced(
        begin,
        _ways(whole.path, origin, begin),
        whole.path[:, 0],
        whole.rotations,
        tuple(parts),
        whole.captures,
        frames,
        whole.shares,
        contacts,
    )


def _taken(source: ClipSource, motions: Mapping[str, Motion], waits: bool) -> Taken:
    """Return a source's frames; with those that blend with its neighbours unless it is waiting."""
    inside, around = _cut(source, motions)
    if waits:
        path, turned = pose_vectors.to_path(clip_motion(inside, around))
        frames = source.start + np.arange(len(path))
        return Taken(path, turned, frames, np.zeros((len(path), 2), dtype=bool))
    moved = clip_motion(inside, around, before=_HALF, after=_HALF + 1)
    stands = _contacts(inside, around[source.capture], moved.n_frames)
    frames = source.start - _HALF + np.arange(moved.n_frames)
    return Taken(*pose_vectors.to_path(moved), frames, stands)


def _contacts(source: ClipSource, motion: Motion, n_frames: int) -> NDArray[np.bool_]:
    """Return the feet that stand in the capture at a clip and its margin: array (frames, 2)."""
    contacts = find_contacts(retarget.motion_positions(motion, FEET)[0])
    contacts = contacts[:, ::-1] if source.mirrored else contacts
    return contacts[np.clip(source.start - _HALF + np.arange(n_frames), 0, len(contacts) - 1)]


def _waiting(taken: Taken, n_frames: int) -> Taken:
    """Return a source played forwards and backwards for ``n_frames``."""
    length = len(taken.path)
    there = np.arange(n_frames) % max(2 * length - 2, 1)
    which = np.where(there < length, there, 2 * length - 2 - there)
    places = _ways(taken.path, np.zeros(3), 0)[which]
    values = np.zeros((n_frames, 4))
    values[:, 0] = taken.path[which, 0]
    values[:-1, 1:] = relative(places[1:], places[:-1]) * MOTION_FPS
    return Taken(values, taken.rotations[which], taken.frames[which], taken.contacts[which])


def _ways(path: FloatArray, origin: FloatArray, begin: int) -> FloatArray:
    """Return the path of path values (frames, 4) that is at ``origin`` at frame ``begin``."""
    turns = np.concatenate([[0.0], np.cumsum(path[:-1, 3])]) / MOTION_FPS
    c, s = np.cos(turns), np.sin(turns)
    x, z = path[:, 1], path[:, 2]
    steps = np.stack([x * c + z * s, z * c - x * s], axis=1)[:-1] / MOTION_FPS
    way = np.column_stack([np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)]), turns])
    return compose(compose(np.asarray(origin, dtype=float), inverse(way[begin])), way)


def _cut(source: ClipSource, motions: Mapping[str, Motion]) -> tuple[ClipSource, dict[str, Motion]]:
    """Return a clip's source relative to a part of its capture around it, and that part."""
    motion = captured(source, motions)
    first, last = max(source.start - _MARGIN, 0), min(source.end + _MARGIN, motion.n_frames)
    part = Motion(
        motion.local_rotations[first:last], motion.root_positions[first:last], motion.leg_length
    )
    inside = replace(source, start=source.start - first, end=source.end - first)
    return inside, {source.capture: part}


def show(spliced: Spliced, at: FloatArray, places: FloatArray) -> Motion:
    """Return the motion that shows rows ``at`` (frames,) on a path (frames, 3), with feet held.

    A player who waits stands, and takes small steps where the path turns or shifts. At seams, feet
    that would slide take a step.
    """
    before = np.floor(at).astype(np.int64)
    after = np.minimum(before + 1, spliced.n_frames - 1)
    share = at - before
    heights = (1.0 - share) * spliced.heights[before] + share * spliced.heights[after]
    local = rotation.slerp(
        spliced.rotations[before],
        spliced.rotations[after],
        np.repeat(share[:, None], len(body.JOINTS), axis=1),
    )
    local[:, 0] = rotation.multiply(pose_vectors.yaw(places[:, 2]), local[:, 0])
    root = np.column_stack([places[:, 0], heights, places[:, 1]])
    shown = Motion(
        rotation.unroll(local).astype(np.float32), root.astype(np.float32), body.LEG_LENGTH
    )
    waits = standing(spliced, at)
    nearest = np.rint(at).astype(np.int64)
    held = lock_feet(shown, waits, spliced.contacts[nearest])
    return step_at_seams(step_feet(held, waits), spliced.shares[nearest] < 1.0)


def standing(spliced: Spliced, at: FloatArray) -> NDArray[np.bool_]:
    """Return at which of the rows ``at`` the player waits and has come to rest: array (frames,)."""
    waits = spliced.waits[np.rint(at).astype(np.int64)]
    for start, end in runs(waits):
        if start > 0:
            waits[start : min(start + _HALF, end)] = False
    return waits
