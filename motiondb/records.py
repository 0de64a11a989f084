"""The frozen records that the stages hand to one another.

World frame everywhere: right-handed, y up, metres, seconds. Rotations are unit quaternions
(w, x, y, z). Frame intervals are half-open, [start, end). ``parents`` holds -1 for the root and
every parent stands before its children.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Float32Array = NDArray[np.float32]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

MOTION_FPS = 30.0
"""Frames per second of every canonical :class:`Motion`."""


@dataclass(frozen=True, eq=False)
class Skeleton:
    """Joints of one capture file, as the file has them.

    Attributes
    ----------
    names : joint names, in file order; parents come before children.
    parents : array (joints,), index of the parent, -1 for the root.
    offsets : array (joints, 3), metres, from the parent in the parent's frame at zero rotation.
    end_sites : (joint, (x, y, z)) for every end site, metres in that joint's frame.
    channels : per joint the names of its channels in file order, in BVH spelling
        ("Xposition", "Zrotation", ...); empty where a joint has none.
    """

    names: tuple[str, ...]
    parents: IntArray
    offsets: FloatArray
    end_sites: tuple[tuple[int, tuple[float, float, float]], ...] = ()
    channels: tuple[tuple[str, ...], ...] = ()


@dataclass(frozen=True, eq=False)
class Clip:
    """One capture, on its own skeleton and at its own frame rate.

    Attributes
    ----------
    skeleton : see :class:`Skeleton`.
    fps : frames per second.
    local_rotations : array (frames, joints, 4), unit quaternions w, x, y, z, relative to the
        parent.
    root_positions : array (frames, 3), metres, world frame, y up.
    joint_positions : array (frames, joints, 3) or None; where a file moves joints below the root,
        the translation of each joint in its parent's frame, metres, in place of ``offsets``
        (the root's row repeats ``root_positions``).
    format : "bvh", "amc", "deepmimic", "amass" or "c3d".
    unit : metres per length unit of the file.
    notes : sentences about what the reader found odd and how it dealt with it.
    """

    skeleton: Skeleton
    fps: float
    local_rotations: FloatArray
    root_positions: FloatArray
    joint_positions: FloatArray | None = None
    format: str = "bvh"
    unit: float = 1.0
    notes: tuple[str, ...] = ()

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.root_positions)

    @property
    def duration(self) -> float:
        """Length in seconds, every frame lasting 1 / fps."""
        return self.n_frames / self.fps


@dataclass(frozen=True, eq=False)
class Motion:
    """A motion on the canonical body (``motiondb.pose.body``) at 30 frames a second.

    World frame: right-handed, y up, the ground at y = 0.

    Attributes
    ----------
    local_rotations : array (frames, 21, 4), float32
        Unit quaternions w, x, y, z, relative to the parent joint.
    root_positions : array (frames, 3), float32
        World positions of the pelvis, metres on the standard body: the performer's positions
        scaled by standard leg length / performer's leg length.
    leg_length : float
        The performer's leg length, hip to ankle, metres.
    notes : tuple of str
        Sentences about what was repaired when the capture was read.
    """

    local_rotations: Float32Array
    root_positions: Float32Array
    leg_length: float = 0.8
    notes: tuple[str, ...] = ()

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.root_positions)

    @property
    def duration(self) -> float:
        """Length in seconds; every frame lasts 1 / 30 s."""
        return self.n_frames / MOTION_FPS

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the 21 joints, in the order of all arrays; parents come before children."""
        from motiondb.pose.body import JOINTS

        return tuple(JOINTS)

    def joint_positions(self) -> FloatArray:
        """World positions of all joints: array (frames, 21, 3), metres on the standard body.

        Right-handed, y up. Multiply by ``leg_length / motiondb.pose.body.LEG_LENGTH`` for the
        performer's size.
        """
        from motiondb.pose.retarget import motion_positions

        return motion_positions(self)[0]


@dataclass(frozen=True, order=True)
class Segment:
    """A half-open interval of frames, [start, end), of one capture."""

    start: int
    end: int


@dataclass(frozen=True, eq=False)
class MotionSymbols:
    """A set of left-to-right Gaussian HMMs with diagonal covariances, padded to the longest.

    State k of symbol s exists where k < n_states[s]. A symbol starts in state 0; from state k it
    stays with probability ``self_loops[s, k]`` and goes to k + 1 (out of the symbol from the last
    state) with 1 - self_loops[s, k].

    Attributes
    ----------
    n_states : array (symbols,), int64.
    self_loops : array (symbols, max states), probability; 0 in the padding.
    means : array (symbols, max states, dimensions), feature units; 0 in the padding.
    covars : array (symbols, max states, dimensions), variances; 1 in the padding.
    """

    n_states: IntArray
    self_loops: FloatArray
    means: FloatArray
    covars: FloatArray

    @property
    def n_symbols(self) -> int:
        """Number of symbols."""
        return len(self.n_states)


@dataclass(frozen=True)
class Caption:
    """Words that a person wrote about a capture or a part of it (seconds; None: the whole)."""

    words: str
    start: float | None = None
    end: float | None = None


@dataclass(frozen=True, order=True)
class Event:
    """An instant of a capture: a foot strikes, a ball is released.

    Attributes
    ----------
    frame : of the canonical motion, at 30 a second.
    name : "foot_strike", "catch", "release", "contact", ... as people wrote it.
    joint : the canonical joint that takes part, "" where nobody said.
    other : what it has to do with ("ball", "ground", "opponent"), "" where nobody said.
    """

    frame: int
    name: str
    joint: str = ""
    other: str = ""


@dataclass(frozen=True, eq=False)
class CaptureInfo:
    """A row of the catalogue.

    Attributes
    ----------
    capture_id : number in the store.
    name : path below the added folder without its ending, such as ``16/16_01``.
    sha256 : digest of the file's bytes (and of its skeleton file's), hexadecimal.
    format : as in :class:`Clip`; ``kind`` is "captured" or "generated".
    fps, n_frames, duration : of the file, after what a sheet said; seconds.
    motion_frames : frames of the canonical motion.
    leg_length : metres.
    path : where the file stood when it was added.
    tags : performer, licence and every further column of the sheet.
    notes : what the reader found odd.
    """

    capture_id: int
    name: str
    sha256: str
    format: str
    kind: str
    fps: float
    n_frames: int
    duration: float
    motion_frames: int
    leg_length: float
    path: str
    run_id: int
    tags: dict[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Relation:
    """How one capture repeats another: kind "same", "mirror" or "cut"; seconds in ``other``."""

    capture: str
    other: str
    kind: str
    start: float
    end: float
    distance: float


@dataclass(frozen=True)
class Run:
    """What made a derived row: command, parameters, seed and version."""

    run_id: int
    kind: str
    parameters: dict[str, object]
    seed: int | None
    version: str
    started: str
    finished: str | None


@dataclass(frozen=True)
class Match:
    """One answer to a search: an interval of a capture, in seconds, and why it was found.

    ``score`` orders answers; ``probability`` that it shows what was asked, None where too little
    was written about the captures to tell (:mod:`motiondb.search.certainty`).
    """

    rank: int
    capture: str
    start: float
    end: float
    score: float
    words: tuple[str, ...] = ()
    reason: str = ""
    probability: float | None = None


@dataclass(frozen=True, eq=False)
class SegmentTable:
    """All segments of all captures with what the symbols say of them, a row a segment.

    Rows are ordered by capture, then start; the segments of a capture tile it.

    Attributes
    ----------
    capture_ids, starts, ends : arrays (segments,), int64; frames of the canonical motion.
    symbols : array (segments,), int64, the arg-max symbol (ties: lowest number).
    log_likelihoods : array (segments,), of that symbol, nats per frame.
    backgrounds : array (segments,), of the background model, nats per frame.
    scores : array (segments, symbols), float32, log-likelihood under every symbol, nats per frame.
    movement : array (segments, columns), float32, see ``search.movement``; no columns where none
        was computed.
    """

    capture_ids: IntArray
    starts: IntArray
    ends: IntArray
    symbols: IntArray
    log_likelihoods: FloatArray
    backgrounds: FloatArray
    scores: Float32Array
    movement: Float32Array = field(default_factory=lambda: np.zeros((0, 0), dtype=np.float32))

    def __post_init__(self) -> None:
        if self.movement.size == 0:
            none = np.zeros((len(self.starts), 0), dtype=np.float32)
            object.__setattr__(self, "movement", none)


@dataclass(frozen=True, eq=False)
class SymbolSpace:
    """Where the symbols lie with respect to one another.

    Attributes
    ----------
    distances : array (symbols, symbols), nats per frame, symmetric, zero diagonal.
    variances : array (symbols, symbols), variance of each distance's Monte-Carlo estimate.
    coordinates : array (symbols, dimensions), from multidimensional scaling.
    stress : array (tried dimensions,), normalised stress of 1, 2, ... dimensions.
    clusters : array (symbols,), int64.
    weights, means, covars : the Gaussian mixture: (clusters,), (clusters, dimensions),
        (clusters, dimensions, dimensions).
    """

    distances: FloatArray
    variances: FloatArray
    coordinates: FloatArray
    stress: FloatArray
    clusters: IntArray
    weights: FloatArray
    means: FloatArray
    covars: FloatArray


@dataclass(frozen=True, eq=False)
class Association:
    """IBM Model 2 from motion symbols (source) to words (target).

    Attributes
    ----------
    words : the vocabulary (lemmas), sorted; column numbers of ``translation``.
    counts : array (words,), in how many captions each word stands.
    translation : array (symbols + 1, words), t(word | symbol); row 0 is NULL, row s + 1 symbol s.
        Rows of symbols that were seen beside words sum to 1.
    alignment : (l, m) -> array (m, l + 1), a(i | j, l, m), column 0 is NULL, rows sum to 1.
    log_likelihoods : sum of log P(words | symbols) after every EM step of Model 1, then 2.
    """

    words: tuple[str, ...]
    counts: IntArray
    translation: FloatArray
    alignment: dict[tuple[int, int], FloatArray]
    log_likelihoods: FloatArray


@dataclass(frozen=True, eq=False)
class Learning:
    """Everything that ``learn`` derives from the catalogue; replaced as a whole.

    ``transition_counts`` : array (symbols + 1, symbols + 1), how often symbol column - 1 follows
    symbol row - 1; row 0 is the begin of a capture, column 0 its end. ``parameters`` : further
    arrays by name (feature means, projections, word maps), float64.
    """

    run_id: int
    symbols: MotionSymbols
    segments: SegmentTable
    space: SymbolSpace
    association: Association
    transition_counts: FloatArray
    parameters: dict[str, FloatArray] = field(default_factory=dict)
