"""Where excerpts are cut: what must agree at a seam, and excerpts with moved cuts.

At a seam these must agree: the height of the pelvis, because who sits must go on sitting at that
height; its velocity over the ground and its turning; the places and the velocities of the feet
relative to it, which say which foot carries the body and where in a step it is; and the pose. A
difference of ``HEIGHT``, ``SPEED``, ``TURNING``, ``FOOT`` or ``FOOT_SPEED`` costs as much as one of
the whole pose by a standard deviation.

A cut may be moved by up to half a second, inwards or outwards. A movement without a period is a
gesture: it should not be cut where the hands and feet move as fast as it ever does.

Long cyclic movements that vary: other excerpts in place of a cycle that is repeated.

An excerpt that is shorter than the duration asked for is lengthened by a loop
(:mod:`motiondb.generate.cycles`). Where the loop would be played more than twice, other excerpts of
the action take the place of the repetitions. They begin alike where the loop ends and end alike
where it begins, and are chosen by dynamic programming (:mod:`motiondb.generate.stitching`): their
scores, their seams, how much their speed over the ground differs from that of the loop (so that
nobody stops on the way), how much their length differs from an equal share of what is to be filled,
and a random cost, so that the same one is seldom played again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.ndimage import uniform_filter1d

from motiondb.body import body, kinematics
from motiondb.body.contacts import FEET
from motiondb.body.features import runs
from motiondb.generate import stitching
from motiondb.generate.action_sources import Source
from motiondb.generate.cycles import find_period
from motiondb.generate.excerpts import TOLERANCE, Excerpt, Layout
from motiondb.records import MOTION_FPS, FloatArray, IntArray

HEIGHT, SPEED, TURNING = 0.08, 0.4, 1.5  # Metres, m/s, rad/s
FOOT, FOOT_SPEED = 0.3, 1.2  # Metres, m/s; of ankle and toe together
POSE_SPEED = 5.0  # Weight of the change of a pose in a frame relative to the pose
MOST_MOVED = 16  # Frames by which a cut may be moved
STEP, COARSE_STEP = 2, 8  # Frames between cuts that are tried: one cut is moved, or both are
FINE = 4  # Frames by which chosen cuts are moved again, one by one
LEAST_LEFT = 60  # Fewest frames (2 s) that moved cuts leave of an excerpt
MARGIN_LEFT = 8  # Frames by which an excerpt of a measured word may be cut
MOVED_COST = 0.02  # Cost of a frame by which a cut is moved, nats
ROUGH, ROUGH_WEIGHT, MOST_ROUGH = 0.25, 10.0, 8.0
"""Change of the speed over the ground in a frame, m/s, from which on an excerpt costs more, and the
nats of 1 m/s: captures may hold still for some frames, or skip some."""
BREAK = 0.6  # Change of the speed over the ground in a frame, m/s, at which a capture breaks
RESTLESS_WEIGHT = 1.5  # Cost of a cut in the quickest moment of a gesture, nats
_ENDS = [0, *(body.INDEX[f"{side}_{joint}"] for side in "lr" for joint in ("ankle", "wrist"))]


def edges_of(
    path: FloatArray, rotations: FloatArray, vectors: FloatArray, scale: FloatArray
) -> FloatArray:
    """What must agree at a seam, at every frame and after the last: array (frames + 1, values).

    The squared distance of two rows is a cost. `path` (frames, 4) and `rotations` (frames, 21, 4)
    of a capture, its pose vectors (frames, values) and their standard deviations (values,).
    """
    feet = _feet(path, rotations)
    poses = vectors[:, 4:] / scale[4:] / np.sqrt(vectors.shape[1] - 4)
    columns = [
        _on(path[:, :1]) / HEIGHT,
        _held(path[:, 1:3]) / SPEED,
        _held(path[:, 3:]) / TURNING,
        _on(feet) / (FOOT * np.sqrt(2.0)),
        _held(_changes(feet)) * MOTION_FPS / (FOOT_SPEED * np.sqrt(2.0)),
        _on(poses),
        _held(_changes(poses)) * POSE_SPEED,
    ]
    return np.concatenate(columns, axis=1)


def _feet(path: FloatArray, rotations: FloatArray) -> FloatArray:
    """Places of ankles and toes relative to the pelvis along the heading: (frames, 12), m."""
    root = np.zeros((len(path), 3))
    places = kinematics.forward(body.PARENTS, body.OFFSETS, rotations, root, FEET)[0]
    return places[:, FEET].reshape(len(path), -1)


def _changes(values: FloatArray) -> FloatArray:
    """Change of values (frames, n) to the next frame; the last one again at the end."""
    steps = np.diff(values, axis=0, append=values[-1:])
    if len(values) > 1:
        steps[-1] = steps[-2]
    return steps


def _on(values: FloatArray) -> FloatArray:
    """Values (frames, n), and those after the last frame at the last change."""
    return np.concatenate([values, values[-1:] + _changes(values)[-1:]])


def _held(values: FloatArray) -> FloatArray:
    """Values (frames, n), and the last ones once more."""
    return np.concatenate([values, values[-1:]])


def restlessness(positions: FloatArray) -> FloatArray:
    """Mean speed of pelvis, hands and feet: array (frames,), m/s; positions (frames, 21, 3)."""
    moves = _changes(positions[:, _ENDS].reshape(len(positions), -1)).reshape(len(positions), -1, 3)
    steps = np.linalg.norm(moves, axis=2).mean(axis=1) * MOTION_FPS
    return np.asarray(uniform_filter1d(steps, 5, mode="nearest"))


@dataclass(frozen=True, eq=False)
class Take:
    """A capture as cutting sees it."""

    edges: FloatArray  # (frames + 1, values): what must agree at a seam
    poses: FloatArray  # (frames, values): by which its period is found
    restless: FloatArray  # (frames,): see ``restlessness``
    speeds: FloatArray  # (frames,): speed over the ground, m/s

    @property
    def jumps(self) -> FloatArray:
        """Change of the speed over the ground to the next frame: array (frames,), m/s."""
        return jumps_of(self.speeds)


@dataclass(frozen=True)
class Position:
    """What may be moved at a position of a sequence."""

    is_first: bool
    is_last: bool
    is_directed: bool = False  # Whether a measured word says where it is cut
    is_timed: bool = False  # Whether a duration says how long it is


def jumps_of(speeds: FloatArray) -> FloatArray:
    """Change of speeds (frames,) to the next frame: array (frames,)."""
    return np.abs(np.diff(speeds, append=speeds[-1:]))


def frame_values(source: Source, n_frames: int) -> FloatArray:
    """Value of the segment of every frame of a source's capture: array (frames,)."""
    which = np.searchsorted(source.ends, np.arange(n_frames), side="right")
    return source.values[np.minimum(which, len(source.values) - 1)]


def moved_cuts(
    excerpts: Sequence[Excerpt],
    takes: dict[int, Take],
    values: dict[int, FloatArray],
    costs: FloatArray,
    position: Position,
) -> tuple[stitching.Candidates, IntArray]:
    """Excerpts with moved cuts as candidates, and the number of the excerpt of each.

    `values`: capture -> value of every frame; `costs` (excerpts,).
    """
    rows: list[tuple[int, int, int]] = []
    targets: list[float] = []
    owner: list[int] = []
    for n, one in enumerate(excerpts):
        take, jumps = takes[one.capture], takes[one.capture].jumps
        period = find_period(take.poses[one.start : one.end])
        value = float(values[one.capture][one.start : one.end].mean())
        spans = _spans(one, len(take.poses), period, position)
        for start, end in [*spans, *_unbroken(one, jumps)]:
            cost = MOVED_COST * (abs(start - one.start) + abs(end - one.end))
            cost += value - float(values[one.capture][start:end].mean())
            rough = ROUGH_WEIGHT * (float(jumps[start:end].max()) - ROUGH)
            cost += float(np.clip(rough, 0.0, MOST_ROUGH))
            if period is None:
                cost += RESTLESS_WEIGHT * _unrest(take.restless, start, end)
            rows.append((one.capture, start, end))
            targets.append(float(costs[n]) - one.score + cost)
            owner.append(n)
    places = np.array(rows)
    entries = np.stack([takes[c].edges[a] for c, a, _ in rows])
    continuations = np.stack([takes[c].edges[b] for c, _, b in rows])
    candidates = stitching.Candidates(
        places[:, 0], places[:, 1], places[:, 2], entries, continuations, np.array(targets)
    )
    return candidates, np.array(owner)


def _spans(
    one: Excerpt, n_frames: int, period: int | None, position: Position
) -> list[tuple[int, int]]:
    """First frames and last frames + 1 of an excerpt with moved cuts, itself first."""
    ahead = not position.is_first or period is None
    behind = not position.is_last or period is None
    step = COARSE_STEP if ahead and behind else STEP
    moves = range(-MOST_MOVED, MOST_MOVED + 1, step)
    inwards = MARGIN_LEFT if position.is_directed else MOST_MOVED
    outwards = 0 if position.is_timed else MOST_MOVED
    least = min(LEAST_LEFT, one.end - one.start)
    spans = [(one.start, one.end)]
    for a in moves if ahead else (0,):
        for b in moves if behind else (0,):
            start, end = one.start + a, one.end - b
            fits = start >= 0 and end <= n_frames and end - start >= least
            fits = fits and one.keeps_core(start, end)
            if fits and (a or b) and -outwards <= min(a, b) and max(a, b) <= inwards:
                spans.append((start, end))
    return spans


def _unbroken(one: Excerpt, jumps: FloatArray) -> list[tuple[int, int]]:
    """The longest part of an excerpt without a break of its capture, if that is not all of it."""
    parts = runs(jumps[one.start : one.end] <= BREAK)
    first, behind = max(parts, key=lambda part: part[1] - part[0], default=(0, 0))
    if LEAST_LEFT / 2 <= behind - first < one.end - one.start - 1:
        # past the first frame after the jump, whose speed is not the capture's
        unbroken = one.start + first + (first > 0), one.start + behind
        return [unbroken] if one.keeps_core(*unbroken) else []
    return []


def _unrest(restless: FloatArray, start: int, end: int) -> float:
    """Speed at both cuts as a share of the quickest in between: 0 to 2."""
    most = float(restless[start:end].max()) + 1e-6
    return float(min(restless[start] / most, 1.0) + min(restless[end - 1] / most, 1.0))


def refine(
    chosen: Sequence[Excerpt], takes: dict[int, Take], fixed: Sequence[bool]
) -> list[Excerpt]:
    """Excerpts with the cuts of each seam moved to where both sides agree most.

    Cuts of `fixed` excerpts stay.
    """
    refined = list(chosen)
    for k, (before, after) in enumerate(pairwise(chosen)):
        if before.capture == after.capture and before.end == after.start:
            continue
        ends = _near(before.end, len(takes[before.capture].poses), fixed[k])
        starts = _near(after.start, len(takes[after.capture].poses) - 1, fixed[k + 1])
        apart = takes[before.capture].edges[ends][:, None] - takes[after.capture].edges[starts]
        a, b = np.unravel_index(int(np.argmin(np.sum(apart**2, axis=-1))), apart.shape[:2])
        refined[k] = replace(refined[k], end=int(ends[a]))
        refined[k + 1] = replace(refined[k + 1], start=int(starts[b]))
    return refined


def _near(frame: int, last: int, is_fixed: bool) -> IntArray:
    if is_fixed:
        return np.array([frame])
    return np.arange(max(frame - FINE, 0), min(frame + FINE, last) + 1)


LONG = 120  # Frames (4 s) from which on a movement is varied
LONGEST_INSERTED, SHORTEST_INSERTED = 75, 30
"""Frames of excerpts that are inserted, on average; captures of runs are short."""
PER_FRAME = 0.15  # Cost of a frame by which an excerpt is longer or shorter than its share, nats
UNEVEN = 20.0  # Cost of a speed that differs by that of the loop, or by ``SLOW``, nats
SLOW, AVERAGED = 0.5, 15  # Metres a second; frames over which the speed over the ground is averaged
RANDOM = 1.0  # Largest random cost of an excerpt, nats
AGAIN = 3.0  # Cost of an excerpt that shares frames with the first one, nats


def is_monotonous(layout: Layout) -> bool:
    """Whether a layout plays a loop more than twice, and long."""
    return len(layout.parts) > 2 and layout.n_frames > LONG and not layout.times


def vary(
    capture: int,
    layout: Layout,
    moved: tuple[stitching.Candidates, IntArray],
    takes: dict[int, Take],
    weights: tuple[float, float],
    is_last: bool,
    is_least: bool,
    rng: np.random.Generator,
) -> tuple[Layout, tuple[stitching.Piece, ...]]:
    """A layout without its repetitions, and the pieces between its two parts.

    `moved`: the excerpts with moved cuts that may be inserted, and the number of the excerpt of
    each; `weights`: of join costs, and their limit; `is_last`: whether no action follows, so that
    the end may be cut; `is_least`: whether the layout must not become shorter. If none fill the
    time, the layout as it is.
    """
    candidates, owner = moved
    first, last = layout.parts[0], layout.parts[-1]
    costs = candidates.targets + UNEVEN * _unevenness(candidates, takes, capture, layout.parts[1])
    shared = (candidates.starts < max(first[1], last[1])) & (candidates.ends > first[0])
    costs = costs + AGAIN * (shared & (candidates.captures == capture))
    costs = costs + rng.uniform(0.0, RANDOM, owner.max() + 1)[owner]
    candidates = replace(candidates, targets=costs)
    edges = takes[capture].edges
    ends = _only(capture, first, edges), _only(capture, last, edges)
    frames = sum(end - start for start, end in layout.parts[1:-1])
    fewest = max(round(frames / LONGEST_INSERTED), 1)
    for n in range(fewest, max(frames // SHORTEST_INSERTED, fewest) + 1):
        between = _insert(candidates, ends, frames, n, weights)
        missing = frames - sum(piece.end - piece.start for piece in between)
        end = max(last[1] + min(missing, 0), last[0] + 1) if is_last else last[1]
        short = last[1] + missing - end
        most = TOLERANCE * layout.n_frames
        if -most <= short <= (0.0 if is_least else most):
            return Layout((first, (last[0], end)), said_of(between)), between
    return layout, ()


def _insert(
    candidates: stitching.Candidates,
    ends: tuple[stitching.Candidates, stitching.Candidates],
    frames: int,
    n: int,
    weights: tuple[float, float],
) -> tuple[stitching.Piece, ...]:
    """The n excerpts of least cost between two ends that together have about `frames` frames."""
    lengths = candidates.ends - candidates.starts
    costs = candidates.targets + PER_FRAME * np.abs(lengths - frames / n)
    inner = [replace(candidates, targets=costs)] * n
    chosen = stitching.choose([ends[0], *inner, ends[1]], *weights)[1:-1]
    places = zip(candidates.captures[chosen], candidates.starts[chosen], candidates.ends[chosen])
    return tuple(stitching.Piece(int(c), int(a), int(b)) for c, a, b in places)


def _unevenness(
    candidates: stitching.Candidates, takes: dict[int, Take], capture: int, loop: tuple[int, int]
) -> FloatArray:
    """Mean difference of speed from a loop, as a share of its speed: array (candidates,)."""
    speed = float(takes[capture].speeds[loop[0] : loop[1]].mean())
    apart = {
        c: np.abs(uniform_filter1d(takes[c].speeds, AVERAGED, mode="nearest") - speed)
        for c in {*candidates.captures.tolist()}
    }
    rows = zip(candidates.captures.tolist(), candidates.starts, candidates.ends)
    return np.array([apart[c][a:b].mean() for c, a, b in rows]) / max(speed, SLOW)


def said_of(between: Sequence[stitching.Piece]) -> str:
    """How an excerpt is lengthened by others.

    >>> said_of([stitching.Piece(3, 10, 85)])
    'its cycles vary: 1 other excerpt is inserted'
    """
    n = len(between)
    return "its cycles vary: " + (
        "1 other excerpt is inserted" if n == 1 else f"{n} other excerpts are inserted"
    )


def _only(capture: int, part: tuple[int, int], edges: FloatArray) -> stitching.Candidates:
    """A part as the only candidate."""
    start, end = part
    return stitching.Candidates(
        np.array([capture]),
        np.array([start]),
        np.array([end]),
        edges[[start]],
        edges[[end]],
        np.zeros(1),
    )
