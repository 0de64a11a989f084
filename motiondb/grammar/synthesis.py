"""Motion from a string of terminals: choose a segment for each terminal and join the segments.

Notation: position k of the string z_1 ... z_n has as candidates all segments i of terminal z_k. A
choice i_1 ... i_n costs

    J = sum over k of j(i_k, i_{k+1}),    j(i, i') = |continuation of i - entry of i'|^2

where the entry of a segment is its first pose and velocity, and its continuation is the pose and
velocity that follow it in its own take. Both are in units of the standard deviations over the
takes. Joining a segment and its true successor costs nothing. The paper chooses greedily; here the
best choice is found exactly by dynamic programming (:mod:`motiondb.generate.stitching`). A choice
without a seam replays a take; true successors then cost :data:`CONTINUING`, so that seams that are
cheaper are taken. Positions can be pinned to a segment, so that an edited string keeps its other
segments. At the two ends, segments that begin or end a sentence of the takes are preferred: others
may begin or stop in the middle of a step.

A motion of a wanted duration is a chain of sentences, as a take is
(:mod:`motiondb.grammar.derivation.derive`).

Segments are placed one after the other with blended seams. The position on the ground and the
heading continue across seams, and feet are fixed while they are in contact with the ground. For
every frame, the take and the frame that it comes from are recorded.

Source: J. P. Park, K. H. Lee and J. Lee, "Finding Syntactic Structures from Human Motion Data",
Computer Graphics Forum 30 (2011), section 6.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from motiondb.body import pose_vectors, rotation
from motiondb.body.contacts import contact_speeds, foot_slip
from motiondb.errors import QueryError
from motiondb.generate import contact, stitching
from motiondb.records import FloatArray, IntArray, Motion

if TYPE_CHECKING:
    from motiondb.grammar.terminals.terminals import Terminals

VELOCITY_WEIGHT = 5.0
"""Weight of velocities (differences between frames) relative to poses, both in units of standard
deviations."""
CONTINUING = 1.0
"""Cost of a true successor where all of them would replay a take. The best other successor costs
0.34 to 0.65 with whole actions and 0.83 with pose runs of the sample data, in the median."""
HELD = np.array([0, *range(4, pose_vectors.N_VALUES)])
"""Values of a pose vector whose velocity counts, the height and the joints: the others are
velocities already."""


@dataclass(frozen=True, eq=False)
class ClipSource:
    """The takes in the form that synthesis uses. A take whose capture was removed is missing."""

    # For each take the path values (frames, 4) and the heading-relative rotations (frames, 21, 4)
    paths: Mapping[int, tuple[FloatArray, FloatArray]]
    # (frames, values): for each take the pose and velocity at every frame, in units of standard
    # deviations
    edges: Mapping[int, FloatArray]
    leg_lengths: Mapping[int, float]  # Leg length of the actor of each take, metres


@dataclass(frozen=True)
class Choice:
    """A segment for each position, with the cost of the choice."""

    clips: tuple[int, ...]  # Numbers of the segments
    cost: float  # J, the sum of the join costs; no unit


@dataclass(frozen=True, eq=False)
class Synthesis:
    """A motion and the source of its frames."""

    motion: Motion  # The motion on the canonical body
    stretches: tuple[int, ...]  # Frames of each stretch that is taken from one take in a row
    spans: tuple[tuple[int, int], ...]  # Frames [start, end) of each position of the string
    # (frames,): take that each frame comes from; at a seam, the take of greater weight
    takes: IntArray
    frames: IntArray  # (frames,): frame in that take
    edits: tuple[str, ...]  # For each frame, how it was edited
    slip: float  # Mean ground speed of feet in contact, metres a second
    source_slip: float  # The same for the segments in their takes, metres per second


def clip_source(motions: Mapping[int, Motion]) -> ClipSource:
    """Prepare takes for synthesis."""
    if not motions:
        raise QueryError(
            "clips: expected captures of the grammar, found none left. Add them again."
        )
    paths = {take: pose_vectors.to_path(motion) for take, motion in motions.items()}
    means = pose_vectors.mean_rotations(np.concatenate([local for _, local in paths.values()]))
    vectors = {take: _vectors(path, means) for take, path in paths.items()}
    scale = np.concatenate(list(vectors.values())).std(axis=0) + 1e-6
    edges = {take: _edges(values, scale) for take, values in vectors.items()}
    return ClipSource(paths, edges, {take: m.leg_length for take, m in motions.items()})


def _vectors(path: tuple[FloatArray, FloatArray], means: FloatArray) -> FloatArray:
    turning = pose_vectors.TURNING
    relative = rotation.multiply(rotation.conjugate(means)[turning], path[1][:, turning])
    return np.concatenate([path[0], rotation.log(relative).reshape(len(path[0]), -1)], axis=1)


def _edges(vectors: FloatArray, scale: FloatArray) -> FloatArray:
    """Return pose and velocity at every frame (frames, values), for join costs.

    They are scaled so that a squared distance of poses is a mean over the values of a pose.
    """
    pose = vectors / scale
    speed = np.diff(vectors[:, HELD], axis=0, prepend=vectors[:1, HELD]) / scale[HELD]
    return np.concatenate([pose, VELOCITY_WEIGHT * speed], axis=1) / np.sqrt(pose.shape[1])


def clip_candidates(
    terminals: Terminals,
    string: Sequence[str],
    source: ClipSource,
    pinned: Mapping[int, int] | None = None,
    preferred: Mapping[int, IntArray] | None = None,
) -> tuple[list[stitching.Candidates], list[IntArray]]:
    """Return the candidate segments of each position of a string.

    `pinned`: Position to the segment that it must have. A segment that is not a candidate is
    ignored.

    `preferred`: Position to segments. If some of them are candidates, the others are left out.
    """
    if not string:
        raise QueryError("string: expected at least one terminal, found none. Name some.")
    number = {name: k for k, name in enumerate(terminals.names)}
    is_available = np.isin(terminals.takes, np.array(sorted(source.paths), dtype=np.int64))
    rows: dict[str, IntArray] = {}
    for name in dict.fromkeys(string):
        if name not in number:
            raise QueryError(f"{name!r}: expected a terminal of the grammar, found no such name.")
        rows[name] = np.flatnonzero((terminals.labels == number[name]) & is_available)
        if not len(rows[name]):
            raise QueryError(
                f"{name}: expected a capture with this terminal, found all of them removed."
                " Add them again, or learn the grammar again."
            )
    numbers = [rows[name] for name in string]
    for position, clips in (preferred or {}).items():
        kept = np.intersect1d(numbers[position], clips)
        numbers[position] = kept if len(kept) else numbers[position]
    for position, clip in (pinned or {}).items():
        if clip in rows[string[position]]:
            numbers[position] = np.array([clip])
    ready = {name: _candidates(terminals, candidates, source) for name, candidates in rows.items()}
    return [
        ready[name]
        if len(candidates) == len(rows[name])
        else _candidates(terminals, candidates, source)
        for name, candidates in zip(string, numbers)
    ], numbers


def _candidates(terminals: Terminals, rows: IntArray, source: ClipSource) -> stitching.Candidates:
    takes, starts, ends = (a[rows] for a in (terminals.takes, terminals.starts, terminals.ends))
    entries = [source.edges[int(t)][s] for t, s in zip(takes, starts)]
    after = [
        source.edges[int(t)][min(e, len(source.edges[int(t)]) - 1)] for t, e in zip(takes, ends)
    ]
    return stitching.Candidates(
        takes, starts, ends, np.array(entries), np.array(after), np.zeros(len(rows))
    )


def choose_clips(
    candidates: Sequence[stitching.Candidates],
    numbers: Sequence[IntArray],
    continuing: float = 0.0,
) -> Choice:
    """Return the choice of least J, found exactly; of equal choices the first in the takes.

    `continuing`: Cost of a true successor in J; it is left out of the cost that is returned.
    """
    picks = stitching.choose(candidates, continuing=continuing)
    chosen = [
        stitching.Candidates(*(values[pick : pick + 1] for values in vars(c).values()))
        for c, pick in zip(candidates, picks)
    ]
    cost = sum(float(stitching.join_costs(a, b)[0, 0]) for a, b in pairwise(chosen))
    return Choice(tuple(int(n[pick]) for n, pick in zip(numbers, picks)), cost)


def synthesise(terminals: Terminals, clips: Sequence[int], source: ClipSource) -> Synthesis:
    """Join segments to one motion.

    The motion has as many frames as the segments together. Outside the seams, poses are those of
    the takes, except where feet in contact with the ground are fixed.
    """
    rows = np.asarray(clips, dtype=np.int64)
    takes, starts, ends = (a[rows] for a in (terminals.takes, terminals.starts, terminals.ends))
    pieces = [stitching.Piece(int(t), int(s), int(e)) for t, s, e in zip(takes, starts, ends)]
    stitched = stitching.stitch(pieces, dict(source.paths))
    leg_length = float(np.median([source.leg_lengths[int(take)] for take in takes]))
    motion = contact.lock_feet(
        pose_vectors.from_path(stitched.path, stitched.rotations, (0.0, 0.0), 0.0, leg_length)
    )
    until = np.cumsum(ends - starts)
    return Synthesis(
        motion,
        tuple(piece.end - piece.start for piece in stitching.merge_pieces(pieces)),
        tuple((int(end - n), int(end)) for end, n in zip(until, ends - starts)),
        stitched.captures,
        stitched.frames,
        tuple("foot lock" if s == 1 else f"blend {s:.2f}, foot lock" for s in stitched.shares),
        foot_slip(motion),
        _source_slip(pieces, source),
    )


def _source_slip(pieces: Sequence[stitching.Piece], source: ClipSource) -> float:
    """Return the mean foot slip within the pieces, as in their takes; metres a second.

    A frame counts as often as it is used.
    """
    total, count = 0.0, 0
    speeds = {
        take: contact_speeds(pose_vectors.from_path(*source.paths[take]))
        for take in {piece.capture for piece in pieces}
    }
    for piece in pieces:
        part = speeds[piece.capture][piece.start : piece.end]
        total += float(np.nansum(part))
        count += int(np.isfinite(part).sum())
    return total / count if count else 0.0
