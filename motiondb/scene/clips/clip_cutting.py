"""Captures cut into the pieces that scenes are made of.

A capture of "run" contains many steps from rest to rest, while a terminal of a motion grammar is a
unit action, such as half a cycle of walking. So that actions can be chained and can be short:

* the still frames before and after the action are dropped;
* an action that travels and has no event is cut where feet strike the ground; a first step from
  rest and a last one to rest are pieces of their own kinds;
* an action that continues in place (dribbling, guarding, waiting) is cut where hands catch the
  ball, or else into equal pieces;
* pieces of one and of two spans between cuts are made (in place also of four), so that there are
  long ones too;
* an action with an event (the release of a shot), a turn, a short action, and one in place that
  is done only when asked (a wave) stay whole.

Cuts are taken from annotated events, or else from the contacts of the feet
(:mod:`motiondb.body.contacts`).

The constants below were chosen by hand, by looking at the pieces of the sample captures; none was
tuned on a benchmark.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from motiondb.body import body, features, pose_vectors, retarget, rotation
from motiondb.body.contacts import find_contacts
from motiondb.body.features import runs
from motiondb.records import MOTION_FPS, Event, FloatArray, Motion
from motiondb.scene.language.semantic_rules import LOWEST, NEAREST

# Places on the ground with a heading, and their composition.


def compose(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return ``second``, given in the frame of ``first``, in the frame in which ``first`` is given.

    Shapes: `first`, `second` (..., 3), m and rad.

    >>> compose(np.array([1.0, 0.0, np.pi / 2]), np.array([0.0, 2.0, 0.0])).round(6).tolist()
    [3.0, 0.0, 1.570796]

    A place is (x, z, theta): metres and radians, theta from +z towards +x, so that ahead is (sin
    theta, cos theta). As a transform it maps coordinates in its own frame (x to the left of a
    viewer who looks along +z, z ahead) to the world::

        a b = (a.x + b.x cos a.th + b.z sin a.th,  a.z - b.x sin a.th + b.z cos a.th,  a.th + b.th)

    This is the group SE(2) with the axes of the ground. A test compares it with a yaw rotation in
    space.
    """
    first, second = np.broadcast_arrays(np.asarray(first, float), np.asarray(second, float))
    c, s = np.cos(first[..., 2]), np.sin(first[..., 2])
    x, z = second[..., 0], second[..., 1]
    return np.stack(
        [
            first[..., 0] + x * c + z * s,
            first[..., 1] - x * s + z * c,
            first[..., 2] + second[..., 2],
        ],
        axis=-1,
    )


def inverse(place: FloatArray) -> FloatArray:
    """Return the transform that undoes ``place``: array (..., 3).

    >>> place = np.array([3.0, -1.0, 0.7])
    >>> abs(compose(place, inverse(place))).round(12).tolist()
    [0.0, 0.0, 0.0]
    """
    place = np.asarray(place, dtype=float)
    c, s = np.cos(place[..., 2]), np.sin(place[..., 2])
    x, z = -place[..., 0], -place[..., 1]
    return np.stack([x * c - z * s, x * s + z * c, -place[..., 2]], axis=-1)


def relative(places: FloatArray, to: FloatArray) -> FloatArray:
    """Return places (..., 3) as seen from the place ``to`` (3,) or (..., 3)."""
    return compose(inverse(to), places)


# A capture as scenes use it: the place of the body on the ground, and its pose relative to it.

WRISTS = (body.INDEX["l_wrist"], body.INDEX["r_wrist"])  # Indices of the wrists among the 21 joints


@dataclass(frozen=True, eq=False)
class BodyFrames:
    """A motion, frame by frame, seen from its own places on the ground.

    Each frame has the place (x, z, heading) of the pelvis on the ground, the joints in the frame of
    that place (x left, y up, z ahead; the height of the root is kept), and their velocities.
    Velocities are rotated into the same frame but include the travel of the body, so that running
    and standing in the same pose are far apart.
    """

    places: FloatArray  # (frames, 3), m and rad: x, z and unwrapped heading in the world
    joints: FloatArray  # (frames, 21, 3), m: joints in the frame of the place
    # (frames, 21, 3), m/s: velocities relative to the world, along the axes of the place
    velocities: FloatArray
    # (frames, 2), bool: whether the left and the right foot is on the ground
    contacts: NDArray[np.bool_]

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.places)

    @cached_property
    def speeds(self) -> FloatArray:
        """Mean speed of all joints, array (frames,), m/s."""
        return np.asarray(np.linalg.norm(self.velocities, axis=2).mean(axis=1))

    def path(self, start: int, end: int) -> FloatArray:
        """Return the places of frames ``start`` to ``end``, both included, seen from the first.

        If the capture ends before ``end``, its last step is repeated, so that the last row is where
        the next clip begins.

        Shapes: result (end - start + 1, 3), m and rad.
        """
        inside = np.minimum(np.arange(start, end + 1), self.n_frames - 1)
        path = relative(self.places[inside], self.places[start])
        missing = end - (self.n_frames - 1)
        if missing > 0 and self.n_frames > start + 1:
            step = relative(self.places[-1], self.places[-2])
            for k in range(len(path) - missing, len(path)):
                path[k] = compose(path[k - 1], step)
        return path

    def mirrored(self) -> BodyFrames:
        """Return the mirror image, with left and right exchanged."""
        flip = np.array([-1.0, 1.0, 1.0])
        return BodyFrames(
            self.places * np.array([-1.0, 1.0, -1.0]),
            self.joints[:, body.MIRROR] * flip,
            self.velocities[:, body.MIRROR] * flip,
            self.contacts[:, ::-1],
        )


def body_frames(motion: Motion) -> BodyFrames:
    """Return a motion seen from its own places on the ground; see :class:`BodyFrames`."""
    positions, rotations = retarget.motion_positions(motion)
    headings = features.headings(rotations)
    places = np.column_stack([positions[:, 0, [0, 2]], headings])
    facing = pose_vectors.yaw(-headings)[:, None]
    ground = positions[:, :1] * np.array([1.0, 0.0, 1.0])
    return BodyFrames(
        places,
        rotation.rotate(facing, positions - ground),
        rotation.rotate(facing, features.velocity(positions, MOTION_FPS)),
        find_contacts(positions),
    )


WHOLE, START, MIDDLE, STOP = "whole", "start", "middle", "stop"
"""Kinds of pieces: an uncut action; from rest, in motion at both ends, and to rest."""

STILL_SPEED = 0.12  # Mean speed of the joints, m/s, below which a body stands still
MOVING = 0.25
"""Fraction of an action's frames that must move; otherwise the whole action is standing, and its
still ends are kept."""
REST_TRAVEL = 0.5  # Ground speed of the pelvis, m/s, below which a clip begins or ends at rest
TRAVEL = 1.0  # Largest distance from the start, m, from which on an action counts as travelling
TURNED = np.radians(45.0)
"""Change of heading, rad, above which an action that does not travel stays whole."""
GOES_ON = 60  # Fewest frames of an action that continues in place: 2 s
PIECE = 24  # Frames of a piece of such an action if no event determines the cut: 0.8 s
SHORTEST = 6  # Fewest frames of a piece: 0.2 s
MARGIN = 2  # Still frames that are kept before and after an action
PARTNER_AHEAD = 1.0  # Where a partner is looked for whose joint an event names, m ahead
AROUND = 45  # Most frames of an action that are kept before and after its event: 1.5 s


@dataclass(frozen=True, eq=False)
class ShownMotion:
    """A part of a capture that shows an action."""

    terminal: str  # Name of the action
    capture: str  # Name of the capture
    motion: Motion  # Motion of the whole capture
    start: int  # First frame that shows the action
    end: int  # Frame after the last one that shows it
    event: str = ""  # Name of the action's event, "" if it has none
    events: tuple[Event, ...] = ()  # Events of the whole capture, in frames of the motion
    licence: str = ""  # Licence of the capture
    is_whole: bool = False  # Whether nothing less than all of it shows the action in place


@dataclass(frozen=True, order=True)
class Piece:
    """A part of an action."""

    start: int  # First frame of the capture
    end: int  # Frame after the last one
    kind: str = WHOLE  # Which part of the action it is


def cut_action(shown: ShownMotion, frames: BodyFrames) -> list[Piece]:
    """Return the pieces of an action in the order of time; see the module."""
    start, end = without_rest(frames, shown.start, shown.end)
    going = travels(frames, start, end)
    turns = bool(abs(frames.places[end - 1, 2] - frames.places[start, 2]) > TURNED)
    if (
        shown.event
        or (turns and not going)
        or not (going or (end - start >= GOES_ON and not shown.is_whole))
    ):
        return [_around_instant(shown, frames, start, end)]
    catches = sorted({e.frame for e in shown.events if e.name == "catch"})
    cuts = _foot_strikes(shown, frames) if going else catches
    cuts = _spread([c for c in cuts if start < c < end], start, end)
    if going:
        return _steps(frames, start, end, cuts)
    if len(cuts) < 2:
        count = max(1, round((end - start) / PIECE))
        cuts = np.linspace(start, end, count + 1).round().astype(int).tolist()[1:-1]
    return _spans([start, *cuts, end], (1, 2, 4))


def travels(frames: BodyFrames, start: int, end: int) -> bool:
    """Return whether the body gets TRAVEL metres away from its start in frames [start, end)."""
    away = frames.places[start:end, :2] - frames.places[start, :2]
    return bool(np.hypot(away[:, 0], away[:, 1]).max() >= TRAVEL)


def without_rest(frames: BodyFrames, start: int, end: int) -> tuple[int, int]:
    """Return [start, end) without its still ends; unchanged if nearly all of it is still."""
    moving = frames.speeds[start:end] > STILL_SPEED
    if moving.mean() < MOVING:
        return start, end
    first, last = int(np.argmax(moving)), len(moving) - int(np.argmax(moving[::-1]))
    return start + max(first - MARGIN, 0), start + min(last + MARGIN, len(moving))


def instant(shown: ShownMotion, frames: BodyFrames, start: int, end: int) -> tuple[int, str]:
    """Return the frame of an action's event within [start, end), and how it is known.

    The first of several catches or contacts counts, and the last of several releases. Without an
    annotation, events are found from the wrists: a catch is where they are farthest ahead of the
    body, a release or a contact where one is farthest ahead and up.
    """
    if not shown.event:
        return -1, ""
    known = sorted(e.frame for e in shown.events if e.name == shown.event)
    inside = [frame for frame in known if start <= frame < end]
    if inside:
        return (inside[-1] if shown.event == "release" else inside[0]), "events"
    if "(" in shown.event:
        return start + found_instant(shown.event, frames.joints[start:end]), "motion"
    if shown.event == "catch":
        ahead = frames.joints[start:end, WRISTS, 2].mean(axis=1)
        return start + int(np.argmax(ahead)), "wrists"
    return farthest_up(frames, start, end), "wrists"


def found_instant(event: str, joints: FloatArray) -> int:
    """Return the frame of an event such as ``lowest(head)`` in joints (frames, 21, 3), m.

    Joints are seen from their own place: x to the left, y up, z ahead. A partner is looked for
    :data:`PARTNER_AHEAD` ahead, with joints as high as one's own at first.

    >>> up = np.zeros((3, 21, 3))
    >>> up[:, body.INDEX["head"], 1] = 1.6, 1.1, 1.5
    >>> found_instant("lowest(head)", up), found_instant("highest(head)", up)
    (1, 0)
    """
    name, _, said = event.rstrip(")").partition("(")
    of = [joint.strip() for joint in said.split(",")]
    one = joints[:, body.INDEX[of[0]]]
    if name != NEAREST:
        return int(np.argmin(one[:, 1]) if name == LOWEST else np.argmax(one[:, 1]))
    if of[1].startswith("partner."):
        height = joints[0, body.INDEX[of[1].removeprefix("partner.")], 1]
        other = np.array([0.0, height, PARTNER_AHEAD])
    else:
        other = joints[:, body.INDEX[of[1]]]
    return int(np.argmin(np.linalg.norm(one - other, axis=1)))


def farthest_up(frames: BodyFrames, start: int, end: int) -> int:
    """Return the frame of [start, end) in which a wrist is farthest ahead and up."""
    wrists = frames.joints[start:end, WRISTS]
    return start + int(np.argmax((wrists[:, :, 1] + wrists[:, :, 2]).max(axis=1)))


def _around_instant(shown: ShownMotion, frames: BodyFrames, start: int, end: int) -> Piece:
    """Return an action widened to include its event, cut to AROUND frames on each side of it."""
    frame, _ = instant(shown, frames, shown.start, shown.end)
    if frame < 0:
        return Piece(start, end)
    first = max(min(start, frame), frame - AROUND)
    return Piece(first, min(max(end, frame + 1), frame + AROUND))


def _foot_strikes(shown: ShownMotion, frames: BodyFrames) -> list[int]:
    known = [e.frame for e in shown.events if e.name == "foot_strike"]
    if known:
        return sorted(set(known))
    return sorted({a for foot in range(2) for a, _ in runs(frames.contacts[:, foot])})


def _spread(cuts: Iterable[int], start: int, end: int) -> list[int]:
    """Return the cuts that are at least SHORTEST frames from one another and from the ends."""
    kept: list[int] = []
    for cut in cuts:
        if cut - (kept[-1] if kept else start) >= SHORTEST and end - cut >= SHORTEST:
            kept.append(cut)
    return kept


def _steps(frames: BodyFrames, start: int, end: int, cuts: list[int]) -> list[Piece]:
    """Return pieces of a travelling action between foot strikes, and from and to rest."""
    if len(cuts) < 2:
        return [Piece(start, end)]
    from_rest = _pelvis_speed(frames, start) < REST_TRAVEL
    into_rest = _pelvis_speed(frames, end - 1) < REST_TRAVEL
    edges = [start] * from_rest + cuts + [end] * into_rest
    return [
        Piece(p.start, p.end, START if p.start == start else STOP if p.end == end else MIDDLE)
        for p in _spans(edges, (1, 2))
    ]


def _spans(edges: list[int], lengths: tuple[int, ...]) -> list[Piece]:
    """Return pieces from edge to edge, for every number of spans in ``lengths``."""
    pairs = {(edges[k], edges[k + n]) for n in lengths for k in range(len(edges) - n)}
    return [Piece(a, b, MIDDLE) for a, b in sorted(pairs)]


def _pelvis_speed(frames: BodyFrames, frame: int) -> float:
    return float(np.linalg.norm(frames.velocities[frame, 0, [0, 2]]))


# The frames in which a capture shows a throw, if its caption only says that there is one.

HELD = 0.3
"""Largest distance between the wrists with a ball in both hands, m. Chosen by hand: a ball is 0.24
m wide."""
LANDED = 25
"""Frames after which a jumping player is on the ground again. Chosen by hand on the sample
captures."""
_CHEST = body.INDEX["chest"]


def throw_frames(frames: BodyFrames, start: int, end: int) -> tuple[int, int]:
    """Return the frames [a, b) of a throw within [start, end); see the module.

    "dribble, shoot" names two actions and no times. More evidence comes from the hands: before a
    ball leaves them at frame r (where a wrist is farthest ahead and up), they come together around
    it, and afterwards they sink. Within frames [start, end) the throw is [a, b)::

        a   the first frame of the last interval before r in which the wrists are at most HELD apart
        b   the first frame after r + LANDED in which both wrists are below the chest

    with at most AROUND frames on either side of r. The frames before a show the actions that the
    caption names before the throw. The method fails if an earlier action looks like a throw, as a
    feigned shot does.
    """
    release = farthest_up(frames, start, end)
    wrists = frames.joints[start:end, WRISTS]
    together = np.linalg.norm(wrists[:, 0] - wrists[:, 1], axis=1) <= HELD
    held = np.flatnonzero(together[: release - start + 1])
    first = release - AROUND
    if len(held):
        apart = np.flatnonzero(~together[: held[-1]])
        first = max(first, start + (int(apart[-1]) + 1 if len(apart) else 0))
    landed = min(release + LANDED, end)
    chest = frames.joints[landed:end, _CHEST, 1]
    down = np.flatnonzero(frames.joints[landed:end, WRISTS, 1].max(axis=1) < chest)
    last = landed + int(down[0]) if len(down) else end
    return max(first, start), min(last, release + AROUND, end)
