"""Motion along a sequence of symbols: stitched from real segments, or drawn from the HMMs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motiondb.generate import clarity, contact, series, stitching, trajectory
from motiondb.learning.learned import Learned
from motiondb.learning.making.action_symbols import word_numbers
from motiondb.learning.making.segment_material import SegmentMaterial, place_of
from motiondb.pose import pose_vectors
from motiondb.records import FloatArray, IntArray, Motion

WORD_WEIGHT = 3.0
"""Weight of the words beside the distance from the trajectory. Chosen by hand; not tuned."""
LENGTH_WEIGHT = 1.0
"""Weight of the squared log-ratio of lengths. Chosen by hand; not tuned."""
JOIN_WEIGHT = 0.5
"""Weight of join costs beside target costs. Chosen by hand; not tuned."""
TIE_COST = 0.3
"""Largest random cost, so that seeds choose between segments that fit about equally well. Chosen by
hand; not tuned."""


@dataclass(frozen=True, eq=False)
class SymbolPlan:
    """Symbols that are to be shown, one after the other.

    Attributes
    ----------
    symbols : array (symbols,)
        The symbols in their order.
    positions : tuple of int
        Per symbol the number of its action.
    actions : tuple of tuple of str
        Words of every action.
    """

    symbols: IntArray
    positions: tuple[int, ...]
    actions: tuple[tuple[str, ...], ...]


@dataclass(frozen=True, eq=False)
class SequenceMotion:
    """A motion along a sequence of symbols, with the origin of its frames.

    Attributes
    ----------
    motion : Motion
        On the canonical body.
    captures : array (frames,)
        Capture that each frame comes from; -1 where drawn from the HMMs.
    frames : array (frames,)
        Frame of that capture, 30 a second; 0 where drawn.
    edits : tuple of str
        Per frame what was done to it.
    lengths : tuple of int
        Frames of every symbol.
    """

    motion: Motion
    captures: IntArray
    frames: FloatArray
    edits: tuple[str, ...]
    lengths: tuple[int, ...]


def _trajectory(material: SegmentMaterial, sequence: IntArray) -> tuple[FloatArray, IntArray]:
    """The most probable trajectory (frames, D) and per frame its position in the sequence."""
    joined = material.series(sequence)
    states = np.repeat(np.arange(len(joined.self_loops)), series.expected_durations(joined))
    means, covars = joined.means[states], joined.covars[states]
    values = trajectory.most_probable(means, covars)
    n_dims = values.shape[1]
    values = trajectory.widen(values, means[:, :n_dims], covars[:, :n_dims])
    return values, joined.positions[states]


def model_motion(
    material: SegmentMaterial, sequence: IntArray, rng: np.random.Generator, method: str
) -> SequenceMotion:
    """Motion from the HMMs alone.

    Parameters
    ----------
    material : SegmentMaterial
        HMMs of the symbols.
    sequence : array (symbols,)
        The symbols in their order.
    rng : numpy.random.Generator
        Draws states and frames where the method is "montecarlo".
    method : str
        "trajectory" (most probable smooth trajectory) or "montecarlo" (every frame drawn).
    """
    if method == "trajectory":
        values, owner = _trajectory(material, sequence)
    else:
        joined = material.series(sequence)
        states = series.sample_states(joined, rng)
        n_dims = joined.means.shape[1] // 3
        values = series.sample_outputs(joined, states, rng)[:, :n_dims]
        owner = joined.positions[states]
    leg_length = float(np.median(list(material.leg_lengths.values())))
    motion = pose_vectors.from_vectors(values, material.means, leg_length=leg_length)
    motion = contact.lock_feet(motion) if method == "trajectory" else motion
    return SequenceMotion(
        motion,
        np.full(motion.n_frames, -1),
        np.zeros(motion.n_frames),
        (method,) * motion.n_frames,
        tuple(np.bincount(owner, minlength=len(sequence)).tolist()),
    )


def stitched_motion(
    learned: Learned, material: SegmentMaterial, plan: SymbolPlan, rng: np.random.Generator
) -> SequenceMotion:
    """Motion of real segments that follow the most probable trajectory and show the words.

    Parameters
    ----------
    learned : Learned
        What was learned.
    material : SegmentMaterial
        Segments of the symbols.
    plan : SymbolPlan
        Symbols and the actions that they show.
    rng : numpy.random.Generator
        Breaks ties between segments that fit equally well.
    """
    values, owner = _trajectory(material, plan.symbols)
    scale = np.concatenate(list(material.vectors.values())).std(axis=0) + 1e-6
    costs = [_word_costs(learned, word_numbers(learned, action)) for action in plan.actions]
    candidates = []
    for k, symbol in enumerate(plan.symbols):
        rows = material.rows(int(symbol))
        wanted = _Wanted(values[owner == k], costs[plan.positions[k]][rows], scale)
        places = np.array([place_of(learned, row) for row in rows])
        candidates.append(_candidates(material, places, wanted, rng))
    chosen = stitching.choose(candidates, JOIN_WEIGHT)
    pieces = [
        stitching.Piece(int(c.captures[i]), int(c.starts[i]), int(c.ends[i]))
        for c, i in zip(candidates, chosen)
    ]
    stitched = stitching.stitch(pieces, dict(material.paths))
    lengths = [material.leg_lengths[piece.capture] for piece in pieces]
    motion = pose_vectors.from_path(
        stitched.path, stitched.rotations, leg_length=float(np.median(lengths))
    )
    return SequenceMotion(
        contact.lock_feet(motion),
        stitched.captures,
        stitched.frames.astype(float),
        tuple("foot lock" if s == 1 else f"blend {s:.2f}, foot lock" for s in stitched.shares),
        tuple(piece.end - piece.start for piece in pieces),
    )


@dataclass(frozen=True, eq=False)
class _Wanted:
    """What the segments of one position are compared with.

    ``part``: array (frames, values), the trajectory's part. ``word_costs``: array (segments,).
    ``scale``: array (values,), spread of pose vectors.
    """

    part: FloatArray
    word_costs: FloatArray
    scale: FloatArray


def _candidates(
    material: SegmentMaterial, places: IntArray, wanted: _Wanted, rng: np.random.Generator
) -> stitching.Candidates:
    """Real segments for one position, with their costs.

    ``places``: array (segments, 3), capture, first frame, last frame + 1.
    """
    scale = wanted.scale
    targets, entries, continuations = [], [], []
    for capture, start, end in places:
        vectors = material.vectors[int(capture)]
        targets.append(_distance(vectors[start:end], wanted.part, scale))
        entries.append(_edge(vectors, int(start), scale))
        continuations.append(_edge(vectors, int(end), scale))
    noise = rng.uniform(0.0, TIE_COST, size=len(places))
    return stitching.Candidates(
        places[:, 0], places[:, 1], places[:, 2],
        np.array(entries), np.array(continuations),
        np.array(targets) + wanted.word_costs + noise,
    )  # fmt: skip


def _distance(segment: FloatArray, part: FloatArray, scale: FloatArray) -> float:
    """Mean squared difference at twelve instants, in spreads, and the cost of unequal lengths."""
    moments = np.linspace(0.0, 1.0, 12)
    a = segment[np.round(moments * (len(segment) - 1)).astype(int)]
    b = part[np.round(moments * (len(part) - 1)).astype(int)]
    ratio = float(np.log(len(segment) / len(part)))
    return float(np.mean(((a - b) / scale) ** 2)) + LENGTH_WEIGHT * ratio**2


def _word_costs(learned: Learned, asked: IntArray) -> FloatArray:
    """Cost of showing an action by each segment: array (segments,), at least 0.

    Per word log(1 + exp(-log-odds)) in the window around the segment, captions included, and the
    cost of what the segment shows that was not asked for.
    """
    odds = np.concatenate([learned.takes[c].windows for c in learned.rows])[:, asked]
    unsaid = np.logaddexp(0.0, -odds).mean(axis=1)
    unasked = clarity.log_unasked(learned.segment_probabilities, asked)
    return np.asarray(WORD_WEIGHT * (unsaid - clarity.UNASKED_SHARE * unasked))


def _edge(vectors: FloatArray, frame: int, scale: FloatArray) -> FloatArray:
    """Pose and velocity at a frame, in spreads; these must agree at a seam."""
    frame = min(frame, len(vectors) - 1)
    before = vectors[max(frame - 1, 0)]
    pose = vectors[frame] / scale
    speed = (vectors[frame] - before)[4:] / scale[4:] * 5.0
    return np.concatenate([pose, speed]) / np.sqrt(len(pose))
