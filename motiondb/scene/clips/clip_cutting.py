"""What people show, cut into the pieces that a scene is put together from.

A capture of "run" goes from rest to rest over many steps; a motion grammar's terminal is a unit
action, such as half a cycle of walking. So that an action can be chained and can be short:

* the still frames before and after the action are dropped;
* an action that travels, without an instant of its own, is cut where feet strike the ground; a
  first step out of rest and a last one into rest are pieces of their own kind;
* an action that goes on in place (dribbling, guarding, waiting) is cut where hands catch the
  ball, or else into equal pieces;
* pieces of one and of two spans are made (in place also four), so that there are long ones too;
* an action with an instant (a shot's release), a turn and a short action stay whole.

Cuts are taken from events that people wrote down, or else from the feet
(:mod:`motiondb.generate.contact`).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from motiondb.pose.features import runs
from motiondb.records import Event, Motion
from motiondb.scene.clips.body_frames import WRISTS, BodyFrames

WHOLE, START, MIDDLE, STOP = "whole", "start", "middle", "stop"
"""Kinds of pieces: an uncut action; out of rest, in the flow, and into rest."""

STILL_SPEED = 0.12
"""Mean speed of the joints, metres a second, below which a body stands still."""
MOVING = 0.25
"""Share of the frames of an action that must move for its still ends to be no part of it."""
REST_TRAVEL = 0.5
"""Ground speed of the pelvis, metres a second, below which a clip begins or ends at rest."""
TRAVEL = 1.0
"""Metres that an action which travels comes away from where it begins."""
TURNED = np.radians(45.0)
"""An action that turns by more stays whole."""
GOES_ON = 60
"""Frames of an action that goes on in place, at least; 2 s."""
PIECE = 24
"""Frames of a piece of such an action where nothing tells where to cut."""
SHORTEST = 6
MARGIN = 2
"""Still frames that are kept before and after an action."""
AROUND = 45
"""Frames of an action that are kept before and after its instant, at most."""


@dataclass(frozen=True, eq=False)
class ShownMotion:
    """A part of a capture that shows an action.

    Attributes
    ----------
    terminal, event : the action's name and the name of its instant, "" where it has none.
    capture, licence : the capture's name and licence.
    motion : of the whole capture; frames [start, end) show the action.
    events : instants of the whole capture, frames of the motion.
    """

    terminal: str
    capture: str
    motion: Motion
    start: int
    end: int
    event: str = ""
    events: tuple[Event, ...] = ()
    licence: str = ""


@dataclass(frozen=True, order=True)
class Piece:
    """Frames [start, end) of a capture, and which part of the action they are."""

    start: int
    end: int
    kind: str = WHOLE


def cut_action(shown: ShownMotion, frames: BodyFrames) -> list[Piece]:
    """The pieces of an action, in the order of time; see the module."""
    start, end = without_rest(frames, shown.start, shown.end)
    going = travels(frames, start, end)
    turns = bool(abs(frames.places[end - 1, 2] - frames.places[start, 2]) > TURNED)
    if shown.event or (turns and not going) or not (going or end - start >= GOES_ON):
        return [_around_instant(shown, frames, start, end)]
    cuts = _foot_strikes(shown, frames) if going else _catches(shown)
    cuts = _spread([c for c in cuts if start < c < end], start, end)
    if going:
        return _steps(frames, start, end, cuts)
    if len(cuts) < 2:
        count = max(1, round((end - start) / PIECE))
        cuts = np.linspace(start, end, count + 1).round().astype(int).tolist()[1:-1]
    return _spans([start, *cuts, end], (1, 2, 4))


def travels(frames: BodyFrames, start: int, end: int) -> bool:
    """Whether the body comes TRAVEL metres away from where it was, in frames [start, end)."""
    away = frames.places[start:end, :2] - frames.places[start, :2]
    return bool(np.hypot(away[:, 0], away[:, 1]).max() >= TRAVEL)


def without_rest(frames: BodyFrames, start: int, end: int) -> tuple[int, int]:
    """[start, end) without its still ends; as it is where nearly all of it is still (waiting)."""
    moving = frames.speeds[start:end] > STILL_SPEED
    if moving.mean() < MOVING:
        return start, end
    first, last = int(np.argmax(moving)), len(moving) - int(np.argmax(moving[::-1]))
    return start + max(first - MARGIN, 0), start + min(last + MARGIN, len(moving))


def instant(shown: ShownMotion, frames: BodyFrames, start: int, end: int) -> tuple[int, str]:
    """The frame of an action's instant within [start, end), and where it is known from.

    Of several catches or contacts the first counts, of several releases the last. Where nobody
    wrote it down, it is taken from the wrists: for a catch the frame in which they are farthest
    ahead of the body, for a release or a contact that in which one is farthest ahead and up.

    Returns
    -------
    (-1, "") where the action has no instant; else the frame of the capture and "events" or
    "wrists".
    """
    if not shown.event:
        return -1, ""
    known = sorted(e.frame for e in shown.events if e.name == shown.event)
    inside = [frame for frame in known if start <= frame < end]
    if inside:
        return (inside[-1] if shown.event == "release" else inside[0]), "events"
    if shown.event == "catch":
        ahead = frames.joints[start:end, WRISTS, 2].mean(axis=1)
        return start + int(np.argmax(ahead)), "wrists"
    return farthest_up(frames, start, end), "wrists"


def farthest_up(frames: BodyFrames, start: int, end: int) -> int:
    """The frame of [start, end) in which a wrist is farthest ahead and up."""
    wrists = frames.joints[start:end, WRISTS]
    return start + int(np.argmax((wrists[:, :, 1] + wrists[:, :, 2]).max(axis=1)))


def _around_instant(shown: ShownMotion, frames: BodyFrames, start: int, end: int) -> Piece:
    """An action with its instant: widened to hold it, cut down to AROUND frames about it."""
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


def _catches(shown: ShownMotion) -> list[int]:
    return sorted({e.frame for e in shown.events if e.name == "catch"})


def _spread(cuts: Iterable[int], start: int, end: int) -> list[int]:
    """The cuts that leave at least SHORTEST frames between one another and to the ends."""
    kept: list[int] = []
    for cut in cuts:
        if cut - (kept[-1] if kept else start) >= SHORTEST and end - cut >= SHORTEST:
            kept.append(cut)
    return kept


def _steps(frames: BodyFrames, start: int, end: int, cuts: list[int]) -> list[Piece]:
    """Pieces of a travelling action between foot strikes, and out of and into rest."""
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
    """Pieces from edge to edge, over every number of spans that is asked for."""
    pairs = {(edges[k], edges[k + n]) for n in lengths for k in range(len(edges) - n)}
    return [Piece(a, b, MIDDLE) for a, b in sorted(pairs)]


def _pelvis_speed(frames: BodyFrames, frame: int) -> float:
    return float(np.linalg.norm(frames.velocities[frame, 0, [0, 2]]))
