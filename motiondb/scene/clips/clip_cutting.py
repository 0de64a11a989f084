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
* an action with an event (the release of a shot), a turn and a short action stay whole.

Cuts are taken from annotated events, or else from the contacts of the feet
(:mod:`motiondb.generate.contact`).

The constants below were chosen by hand, by looking at the pieces of the sample captures; none was
tuned on a benchmark.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from motiondb.body.features import runs
from motiondb.records import Event, Motion
from motiondb.scene.clips.body_frames import WRISTS, BodyFrames

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
    if shown.event == "catch":
        ahead = frames.joints[start:end, WRISTS, 2].mean(axis=1)
        return start + int(np.argmax(ahead)), "wrists"
    return farthest_up(frames, start, end), "wrists"


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


def _catches(shown: ShownMotion) -> list[int]:
    return sorted({e.frame for e in shown.events if e.name == "catch"})


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
