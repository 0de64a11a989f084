"""The frozen records that the stages hand to one another.

World frame everywhere: right-handed, y up, metres, seconds. Rotations are unit quaternions
(w, x, y, z). Frame intervals are half-open, [start, end). ``parents`` holds -1 for the root and
every parent stands before its children.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from motiondb import hmmlearn_models

if TYPE_CHECKING:
    from hmmlearn.hmm import GaussianHMM

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
    names : tuple of str
        Joint names, in file order; parents come before children.
    parents : array (joints,)
        Index of the parent, -1 for the root.
    offsets : array (joints, 3)
        Metres, from the parent in the parent's frame at zero rotation.
    end_sites : tuple of (int, (float, float, float))
        Joint, and x, y, z in metres in that joint's frame, of every end site.
    channels : tuple of tuple of str
        Per joint the names of its channels in file order, in BVH spelling ("Xposition",
        "Zrotation", ...); empty where a joint has none.
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
    skeleton : Skeleton
        Joints of the file.
    fps : float
        Frames per second.
    local_rotations : array (frames, joints, 4)
        Unit quaternions w, x, y, z, relative to the parent.
    root_positions : array (frames, 3)
        Metres, world frame, y up.
    joint_positions : array (frames, joints, 3) or None
        Where a file moves joints below the root: the translation of each joint in its parent's
        frame, metres, in place of ``offsets`` (the root's row repeats ``root_positions``).
    format : str
        "bvh", "amc", "deepmimic", "amass" or "c3d".
    unit : float
        Metres per length unit of the file.
    notes : tuple of str
        Sentences about what is unusual in the file and what the reader did about it.
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
    """A half-open interval of frames, [start, end), of one capture.

    Attributes
    ----------
    start : int
        First frame.
    end : int
        Last frame + 1.
    """

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
    n_states : array (symbols,)
        Number of states.
    self_loops : array (symbols, max states)
        Probabilities; 0 in the padding.
    means : array (symbols, max states, dimensions)
        Feature units; 0 in the padding.
    covars : array (symbols, max states, dimensions)
        Variances; 1 in the padding.
    """

    n_states: IntArray
    self_loops: FloatArray
    means: FloatArray
    covars: FloatArray

    @property
    def n_symbols(self) -> int:
        """Number of symbols."""
        return len(self.n_states)

    def to_hmmlearn(self, symbol: int, *, exit_state: bool = True) -> GaussianHMM:
        """Translate a symbol to a ``hmmlearn.hmm.GaussianHMM`` of equal score.

        With ``exit_state`` it has one further state, see :mod:`motiondb.hmmlearn_models`; a model
        without it can be fitted and sampled by hmmlearn. MotionDBError if there is no such symbol.
        """
        hmmlearn_models.check_symbol(symbol, self.n_symbols)
        n = int(self.n_states[symbol])
        parts = (part[symbol, :n] for part in (self.self_loops, self.means, self.covars))
        return hmmlearn_models.to_hmmlearn(*parts, exit_state=exit_state)

    @classmethod
    def from_hmmlearn(cls, models: Sequence[GaussianHMM]) -> MotionSymbols:
        """Symbols from left-to-right models of hmmlearn with diagonal covariances, one a symbol.

        Without an exit state the last self-loop is 1. MotionDBError for other models.
        """
        return cls(*hmmlearn_models.from_hmmlearn(models))


@dataclass(frozen=True)
class Caption:
    """Words that a person wrote about a capture or a part of it.

    Attributes
    ----------
    words : str
        The text.
    start : float or None
        Start of the part, seconds; None: the start of the capture.
    end : float or None
        End of the part, seconds; None: the end of the capture.
    """

    words: str
    start: float | None = None
    end: float | None = None


@dataclass(frozen=True, order=True)
class Event:
    """An instant of a capture: a foot strikes, a ball is released.

    Attributes
    ----------
    frame : int
        Frame of the canonical motion, 30 a second.
    name : str
        "foot_strike", "catch", "release", "contact", ... as people wrote it.
    joint : str
        The canonical joint that takes part, "" where it is not known.
    other : str
        What the joint touches ("ball", "ground", "opponent"), "" where it is not known.
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
    capture_id : int
        Number in the store.
    name : str
        Path below the added folder without its ending, such as ``16/16_01``.
    sha256 : str
        Digest of the file's bytes (and of its skeleton file's), hexadecimal.
    format : str
        As in :class:`Clip`.
    kind : str
        "captured" or "generated".
    fps : float
        Frames per second of the file, or those that a sheet gives.
    n_frames : int
        Frames of the file.
    duration : float
        Seconds.
    motion_frames : int
        Frames of the canonical motion, 30 a second.
    leg_length : float
        The performer's, metres.
    path : str
        Path of the file when it was added.
    run_id : int
        Run that added it.
    tags : dict
        Performer, licence and every further column of the sheet.
    notes : tuple of str
        What is unusual in the file.
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
    """How one capture repeats another.

    Attributes
    ----------
    capture : str
        Name of the capture.
    other : str
        Name of the capture that it repeats.
    kind : str
        "same", "mirror" or "cut".
    start : float
        Start of the repeated part in ``other``, seconds.
    end : float
        End of the repeated part in ``other``, seconds.
    distance : float
        Mean distance between the poses of both (``motiondb.search.copies``).
    """

    capture: str
    other: str
    kind: str
    start: float
    end: float
    distance: float


@dataclass(frozen=True)
class Run:
    """What made a derived row.

    Attributes
    ----------
    run_id : int
        Number of the run.
    kind : str
        Command.
    parameters : dict
        Everything that decided the result.
    seed : int or None
        Seed of the random generator.
    version : str
        Version of motiondb.
    started : str
        Time in UTC, ISO 8601.
    finished : str or None
        Time in UTC; None where the run was killed.
    """

    run_id: int
    kind: str
    parameters: dict[str, object]
    seed: int | None
    version: str
    started: str
    finished: str | None


@dataclass(frozen=True)
class MatchPart:
    """One part of an answer to words: where a capture shows it, and how sure that is.

    Attributes
    ----------
    words : str
        What the question asks for in this part.
    start, end : float
        Seconds; those of the whole capture where the place is unknown.
    probability : float or None
        Probability that the capture shows it; None where it is not known.
    interval_probability : float or None
        Probability that the interval shows it; None where it is not known.
    place : str
        "known", or "unknown" where only a caption of the whole capture speaks for it.
    """

    words: str
    start: float
    end: float
    probability: float | None = None
    interval_probability: float | None = None
    place: str = "known"


@dataclass(frozen=True)
class Match:
    """One answer to a search: an interval of a capture.

    Attributes
    ----------
    rank : int
        1 for the best.
    capture : str
        Name of the capture.
    start : float
        Seconds.
    end : float
        Seconds.
    score : float
        Orders the answers, largest first.
    words : tuple of str
        Words of the question that the capture shows, or words of the interval.
    reason : str
        Why it was found.
    probability : float or None
        Probability that the answer is right: of words, that the capture shows what was asked; of an
        example, that the interval does. None where too little was written about the captures to
        learn it (:mod:`motiondb.search.certainty`).
    interval_probability : float or None
        Of words: probability that the interval shows what was asked; None where it is not known.
    place : str
        "known", or "unknown" where a part's place is; then the interval is the whole capture.
    parts : tuple of MatchPart
        Parts of a question in words, in order.
    """

    rank: int
    capture: str
    start: float
    end: float
    score: float
    words: tuple[str, ...] = ()
    reason: str = ""
    probability: float | None = None
    interval_probability: float | None = None
    place: str = "known"
    parts: tuple[MatchPart, ...] = ()


@dataclass(frozen=True, eq=False)
class SegmentTable:
    """All segments of all captures with their scores, one row per segment.

    Rows are ordered by capture, then start; the segments of a capture tile it.

    Attributes
    ----------
    capture_ids : array (segments,)
        Capture numbers.
    starts : array (segments,)
        First frames of the canonical motion, 30 a second.
    ends : array (segments,)
        Last frames + 1.
    symbols : array (segments,)
        The most probable symbol (ties: lowest number).
    log_likelihoods : array (segments,)
        Of that symbol, nats per frame.
    backgrounds : array (segments,)
        Of the background model, nats per frame.
    scores : array (segments, symbols), float32
        Log-likelihood under every symbol, nats per frame.
    movement : array (segments, columns), float32
        See ``search.movement``; no columns where none was computed.
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
        """Give segments without movement an array without columns."""
        if self.movement.size == 0:
            none = np.zeros((len(self.starts), 0), dtype=np.float32)
            object.__setattr__(self, "movement", none)


@dataclass(frozen=True, eq=False)
class SymbolSpace:
    """Distances between the symbols, their coordinates and clusters.

    Attributes
    ----------
    distances : array (symbols, symbols)
        Nats per frame, symmetric, zero diagonal.
    variances : array (symbols, symbols)
        Variance of each distance's Monte-Carlo estimate.
    coordinates : array (symbols, dimensions)
        From multidimensional scaling.
    stress : array (tried dimensions,)
        Normalised stress of 1, 2, ... dimensions.
    clusters : array (symbols,)
        Cluster of every symbol.
    weights : array (clusters,)
        Weights of the Gaussian mixture.
    means : array (clusters, dimensions)
        Means of the Gaussian mixture.
    covars : array (clusters, dimensions, dimensions)
        Covariances of the Gaussian mixture.
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
    words : tuple of str
        The vocabulary (lemmas), sorted; column numbers of ``translation``.
    counts : array (words,)
        Number of captions that hold each word.
    translation : array (symbols + 1, words)
        t(word | symbol); row 0 is NULL, row s + 1 symbol s. Rows of symbols that were seen beside
        words sum to 1.
    alignment : dict
        (l, m) -> array (m, l + 1), a(i | j, l, m), column 0 is NULL, rows sum to 1.
    log_likelihoods : array (steps,)
        Sum of log P(words | symbols) after every EM step of Model 1, then 2.
    """

    words: tuple[str, ...]
    counts: IntArray
    translation: FloatArray
    alignment: dict[tuple[int, int], FloatArray]
    log_likelihoods: FloatArray


@dataclass(frozen=True, eq=False)
class StoredLearning:
    """What ``learn`` derives, as the tables of the store hold it.

    :mod:`motiondb.learning.parameter_arrays` turns it into typed records
    (``motiondb.learning.learned.LearnedModel``) and back; nothing else reads ``parameters``.

    Attributes
    ----------
    run_id : int
        Run that made it.
    symbols : MotionSymbols
        Table ``symbol_state``.
    segments : SegmentTable
        Tables of segments.
    space : SymbolSpace
        Tables of the symbol space.
    association : Association
        Tables of words.
    transition_counts : array (symbols + 1, symbols + 1)
        Table ``transition_count``.
    parameters : dict
        Table ``parameter``: further arrays by name, float64.
    """

    run_id: int
    symbols: MotionSymbols
    segments: SegmentTable
    space: SymbolSpace
    association: Association
    transition_counts: FloatArray
    parameters: dict[str, FloatArray] = field(default_factory=dict)
