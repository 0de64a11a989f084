"""The frozen records that the stages hand to one another.

World frame everywhere: right-handed, y up, metres, seconds. Rotations are unit quaternions
(w, x, y, z). Frame intervals are half-open, [start, end). ``parents`` holds -1 for the root and
every parent comes before its children.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Annotated, Any, Self, cast

import numpy as np
from numpy.typing import NDArray

from motiondb import hmmlearn_models
from motiondb.errors import QueryError

if TYPE_CHECKING:
    from hmmlearn.hmm import GaussianHMM
FloatArray = NDArray[np.float64]
Float32Array = NDArray[np.float32]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]

POSE_STEP = 2.0**-17  # Places (m) and quaternions of captures are multiples: .01 mm, .001 degrees
MOTION_FPS = 30.0  # Frames per second of every canonical :class:`~motiondb.records.Motion`
LARGEST = 1e9  # Bound on every number of a file


class Sliced:
    """Frames that can be cut: ``motion[10:20]``."""

    def __getitem__(self, frames: slice) -> Self:
        if not isinstance(frames, slice) or frames.step not in (None, 1):
            raise TypeError(f"expected consecutive frames, such as motion[10:20], found [{frames}]")
        arrays = {name: each for name, each in vars(self).items() if isinstance(each, np.ndarray)}
        cut = {name: np.ascontiguousarray(value[frames]) for name, value in arrays.items()}
        if not len(cut["root_positions"]):
            raise QueryError(
                f"frames: expected some of {len(arrays['root_positions'])}, found none in "
                f"{frames.start}:{frames.stop}. Give others."
            )
        return cast(Self, replace(cast(Any, self), **cut))


class Axes:
    """Sizes of the axes of an array: numbers, names that mean one size throughout, or any (None).

    The half above the diagonal of a symmetric matrix is not stored.
    """

    def __init__(self, *sizes: int | str | None, symmetric: bool = False) -> None:
        self.sizes = sizes
        self.symmetric = symmetric


@dataclass(frozen=True)
class Within:
    """Bounds of the numbers of a field, and what a message says is expected of them."""

    low: float
    high: float
    what: str
    is_whole: bool = False  # Whether the numbers are integers


@dataclass(frozen=True)
class Sizes:
    """Sizes by name that hold in one field's record."""

    by_name: Mapping[str, int]


class MayBeUnknown:
    """A number that may be NaN."""


@dataclass(frozen=True, eq=False)
class Skeleton:
    """Joints of one capture file, as the file has them."""

    names: tuple[str, ...]  # Joint names, in file order; parents come before children
    parents: IntArray  # (joints,): index of the parent, -1 for the root
    # (joints, 3): metres, from the parent in the parent's frame at zero rotation
    offsets: FloatArray
    # Joint, and x, y, z in metres in that joint's frame, of every end site
    end_sites: tuple[tuple[int, tuple[float, float, float]], ...] = ()
    # Per joint the names of its channels in file order, in BVH spelling ("Xposition", "Zrotation",
    # ...); empty where the file has none: a BVH file then gets rotations Z, Y, X for every joint
    channels: tuple[tuple[str, ...], ...] = ()


@dataclass(frozen=True, eq=False)
class Clip(Sliced):
    """One capture, on its own skeleton and at its own frame rate."""

    skeleton: Skeleton
    """Joints of the file."""
    fps: float
    """Frames per second."""
    local_rotations: FloatArray
    """array (frames, joints, 4): unit quaternions w, x, y, z, relative to the parent."""
    root_positions: FloatArray
    """array (frames, 3): metres, world frame of the file."""
    joint_positions: FloatArray | None = None
    """array (frames, joints, 3) or None: where a file moves joints below the root: the translation
    of each joint in its parent's frame, metres, in place of ``offsets`` (the root's row repeats
    ``root_positions``)."""
    format: str = "bvh"
    """One of "bvh", "amc", "deepmimic", "amass", "c3d", "trc", "markers" (tables), "fbx",
    "movement", "robot", "opensim" or "positions"."""
    unit: float = 1.0
    """Metres per length unit of the file."""
    up: str = ""
    """The axis that points up in the arrays: "x", "y", "z", "-x", "-y" or "-z"; "" where neither
    the file nor its reader says it."""
    notes: tuple[str, ...] = ()
    """Sentences about unusual contents of the file and how the reader handled them."""

    def __repr__(self) -> str:
        joints = len(self.joint_names)
        return (
            f"Clip({self.format}, {self.n_frames} frames at {self.fps:g} a second, {joints} joints)"
        )

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.root_positions)

    @property
    def duration(self) -> float:
        """Length in seconds, every frame lasting 1 / fps."""
        return self.n_frames / self.fps

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, in the order of all arrays; parents come before children."""
        return self.skeleton.names

    def world_positions(self) -> FloatArray:
        """World positions of all joints at the clip's rate: array (frames, joints, 3), metres.

        In the world frame of the file, right-handed.
        """
        from motiondb.body.kinematics import clip_positions

        return clip_positions(self)[0]

    def world_rotations(self) -> FloatArray:
        """World rotations of all joints: array (frames, joints, 4), unit quaternions w, x, y, z."""
        from motiondb.body.kinematics import clip_positions

        return clip_positions(self)[1]


@dataclass(frozen=True, eq=False)
class Motion(Sliced):
    """A motion on the canonical body (``motiondb.body.body``) at 30 frames a second.

    World frame: right-handed, y up, the ground at y = 0.
    """

    local_rotations: Float32Array
    """array (frames, 21, 4), float32: unit quaternions w, x, y, z, relative to the parent joint."""
    root_positions: Float32Array
    """array (frames, 3), float32: world positions of the pelvis, metres on the standard body: the
    performer's positions scaled by standard leg length / performer's leg length."""
    leg_length: float = 0.8
    """The performer's leg length, hip to ankle, metres."""
    notes: tuple[str, ...] = ()
    """Sentences about repairs when the capture was read."""

    def __repr__(self) -> str:
        return f"Motion({self.n_frames} frames, {self.duration:.2f} s)"

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
        from motiondb.body.body import JOINTS

        return tuple(JOINTS)

    def joint_positions(self) -> FloatArray:
        """World positions of all joints: array (frames, 21, 3), metres on the standard body.

        Right-handed, y up. Multiply by ``leg_length / motiondb.body.body.LEG_LENGTH`` for the
        performer's size.
        """
        from motiondb.body.retarget import motion_positions

        return motion_positions(self)[0]


@dataclass(frozen=True)
class Caption:
    """Words that a person wrote about a capture or a part of it."""

    words: str
    """The text."""
    start: float | None = None
    """Start of the part, seconds; None: the start of the capture."""
    end: float | None = None
    """End of the part, seconds; None: the end of the capture."""


@dataclass(frozen=True, order=True)
class Event:
    """An instant of a capture: a foot strikes, a ball is released."""

    frame: int
    """Frame of the canonical motion, 30 a second."""
    name: str
    """Such as "foot_strike", "catch", "release", "contact", as people wrote it."""
    joint: str = ""
    """The canonical joint that takes part, "" where it is not known."""
    other: str = ""
    """What the joint touches ("ball", "ground", "opponent"), "" where it is not known."""

    @property
    def seconds(self) -> float:
        """Time of the event from the start of the capture, seconds."""
        return round(self.frame / MOTION_FPS, 3)


@dataclass(frozen=True, eq=False)
class CaptureInfo:
    """A row of the catalogue."""

    capture_id: int
    """Number in the store."""
    name: str
    """Path below the added folder without its ending, such as ``16/16_01``."""
    sha256: str
    """Digest of the file's bytes (and of its skeleton file's), hexadecimal."""
    format: str
    """As in :class:`Clip`."""
    kind: str
    """Either "captured" or "generated"."""
    fps: float
    """Frames per second of the file, or those that a sheet gives."""
    n_frames: int
    """Frames of the file."""
    duration: float
    """Seconds."""
    motion_frames: int
    """Frames of the canonical motion, 30 a second."""
    leg_length: float
    """The performer's, metres; 0 for markers without a body."""
    path: str
    """Path of the file when it was added."""
    run_id: int
    """Run that added it."""
    tags: dict[str, str] = field(default_factory=dict)
    """Performer, licence and every further column of the sheet."""
    notes: tuple[str, ...] = ()
    """What is unusual in the file."""

    @property
    def has_body(self) -> bool:
        """Whether it is the motion of a body; else it is kept as markers, or as series."""
        return self.leg_length > 0.0

    @property
    def is_captured(self) -> bool:
        """Whether it is captured motion of a body, from which can be learned."""
        return self.kind == "captured" and self.has_body


NEEDS, FAULT, FILE = "needs", "fault", "file"  # Families of findings: a thing that was not
# captured, a partner or a treadmill; not as a body moves; not the unit or rate of the file


@dataclass(frozen=True)
class Box:
    """Where something has to stand that was not captured: a box along the axes of the world."""

    centre: tuple[float, float, float]
    """x, y, z in metres, y up, in the world of the capture."""
    size: tuple[float, float, float]
    """Whole lengths along x, y and z, metres."""


@dataclass(frozen=True)
class Finding:
    """One thing that a capture lacks, from when to when, and how much of it."""

    kind: str
    """Such as "sits", "stands on", "hangs", "jumps", "frozen", "rate"."""
    family: str
    """One of ``NEEDS``, ``FAULT`` and ``FILE``."""
    start: float
    """Seconds from the beginning of the capture."""
    end: float
    """Seconds; the interval is half-open."""
    measure: float
    """What was measured, in `unit`."""
    unit: str
    """Such as "m", "m/s", "m/s2", "s" or "times"."""
    threshold: float
    """The value from which on it is said, in `unit`."""
    part: str
    """Of the body, such as "seat", "hands", "l_wrist"; "body": all of it."""
    sentence: str
    """The finding in words."""
    place: tuple[float, float, float] | None = None
    """Of the part, x, y, z in metres, y up; None: everywhere."""
    boxes: tuple[Box, ...] = ()
    """What has to stand there, where a place is known; a box a step."""


@dataclass(frozen=True, eq=False)
class Quality:
    """All that is said about one capture."""

    findings: tuple[Finding, ...]
    untold: tuple[str, ...]
    """What cannot be told, such as "cannot say whether the rate is right: no jump"."""
    seconds: FloatArray
    """array (seconds,): 0 to 1 for each second that was begun; not lowered by needs."""
    floor: float
    """Height of the floor in the world of the capture, metres."""
    flights: tuple[tuple[float, float], ...]
    """(gravity in m/s2, its standard error) of every flight that can be believed."""


@dataclass(frozen=True)
class Relation:
    """How one capture repeats another."""

    capture: str
    """Name of the capture."""
    other: str
    """Name of the capture that it repeats."""
    kind: str
    """One of "same", "mirror" or "cut"."""
    start: float
    """Start of the repeated part in ``other``, seconds."""
    end: float
    """End of the repeated part in ``other``, seconds."""
    distance: float
    """Mean distance between the poses of both (``motiondb.search.copies``)."""


@dataclass(frozen=True)
class DuplicateGroup:
    """Captures that repeat one another."""

    # Names: first the one to keep, then the others in the order in which they were added
    captures: tuple[str, ...]
    relations: tuple[Relation, ...]


@dataclass(frozen=True)
class Fit:
    """How well a rig follows a motion; lengths in metres of the rig."""

    scale: float  # Length of the rig's legs by those of the canonical body
    foot_error: float  # Mean distance of the ankles from their places in the motion
    most_foot_error: float
    hand_error: float  # Mean distance of the wrists from their places
    most_hand_error: float
    hands: str  # "in place", or "by the arm" where the arms have other proportions
    slip: float  # Mean ground speed of feet in contact, m/s
    slip_of_motion: float  # The same of the motion, on the canonical body scaled to the rig
    joints: int  # Joints of the rig
    driven: int  # Joints that the motion turns; others follow them


@dataclass(frozen=True)
class Run:
    """The run that made a derived row."""

    run_id: int  # Number of the run
    kind: str
    parameters: dict[str, object]  # Everything that decided the result
    seed: int | None  # Seed of the random generator
    version: str
    started: str  # Time in UTC, ISO 8601
    finished: str | None  # Time in UTC; None if the run was killed


@dataclass(frozen=True)
class MatchPart:
    """One part of an answer to words: its interval in a capture, with certainties."""

    words: str  # What the question asks for in this part
    start: float  # Begin, seconds; that of the whole capture if the place is unknown
    end: float  # End, seconds; that of the whole capture if the place is unknown
    # Probability that the capture shows it; None if it is not known
    probability: float | None = None
    # Probability that the interval shows it; None if it is not known
    interval_probability: float | None = None
    # "known", or "unknown" where only a caption of the whole capture speaks for it
    place: str = "known"


@dataclass(frozen=True)
class Match:
    """One answer to a search: an interval of a capture."""

    rank: int
    """1 for the best."""
    capture: str
    """Name of the capture."""
    start: float
    """Seconds."""
    end: float
    """Seconds."""
    score: float
    """Orders the answers, largest first; of actions in order and of what is measured, probable
    answers come first."""
    words: tuple[str, ...] = ()
    """Words that are learned or written for the interval, likeliest first."""
    reason: str = ""
    """Why it was found."""
    probability: float | None = None
    """Probability that the answer is right: for words, that the capture shows the requested
    actions; for an example, that the interval shows the same action. None if too little was
    written about the captures to learn it (:mod:`motiondb.meaning.regression`), or too few
    captions of the database have checked it (:mod:`motiondb.learn.checking`)."""
    interval_probability: float | None = None
    """For words: probability that the interval shows the requested actions; None if it is not
    known."""
    place: str = ""
    """For words: "known", or "unknown" where a part's place is; then the interval is the whole
    capture. "" for an example and for a search by symbols, which measure no place."""
    parts: tuple[MatchPart, ...] = ()
    """Parts of a question in words, in order."""
    in_order: bool | None = None
    """For actions in order: whether the capture is seen to show them in this order; None if the
    question asks for no order, or the motion does not tell."""
    contradicted: tuple[str, ...] = ()
    """What was measured in the motion against the question, such as "does not go backward", "moves
    the right hand, not the left", "turns left, which is excluded"."""


@dataclass(frozen=True, order=True)
class Segment:
    """A half-open interval of frames, [start, end), of one capture."""

    start: int
    end: int  # Last frame + 1


@dataclass(frozen=True, eq=False)
class MotionSymbols:
    """A set of left-to-right Gaussian HMMs with diagonal covariances, padded to the longest.

    State k of symbol s exists where k < n_states[s]. A symbol starts in state 0; from state k it
    stays with probability ``self_loops[s, k]`` and goes to k + 1 (out of the symbol from the last
    state) with 1 - self_loops[s, k].
    """

    n_states: Annotated[IntArray, Axes("symbols")]
    """array (symbols,): number of states."""
    self_loops: Annotated[FloatArray, Axes("symbols", "states")]
    """array (symbols, max states): probabilities; 0 in the padding."""
    means: Annotated[FloatArray, Axes("symbols", "states", "dimensions")]
    """array (symbols, max states, dimensions): feature units; 0 in the padding."""
    covars: Annotated[FloatArray, Axes("symbols", "states", "dimensions")]
    """array (symbols, max states, dimensions): variances; 1 in the padding."""

    def __repr__(self) -> str:
        _, states, dimensions = self.means.shape
        return f"MotionSymbols({self.n_symbols} symbols, {states} states, {dimensions} dimensions)"

    @property
    def n_symbols(self) -> int:
        """Number of symbols."""
        return len(self.n_states)

    def to_hmmlearn(self, symbol: int, *, exit_state: bool = True) -> GaussianHMM:
        """Translate a symbol to a ``hmmlearn.hmm.GaussianHMM`` of equal score.

        Parameters
        ----------
        symbol : int
            Number of the symbol.
        exit_state : bool, optional
            Whether the model gets a further state, absorbing and without frames, for a symbol that
            was left. Then ``score`` is exactly that of ``motiondb.symbols.hmm``. A model
            without it can be fitted and sampled by hmmlearn; see :mod:`motiondb.hmmlearn_models`.

        Raises
        ------
        MotionDBError
            If there is no such symbol.
        """
        hmmlearn_models.check_symbol(symbol, self.n_symbols)
        n = int(self.n_states[symbol])
        parts = (part[symbol, :n] for part in (self.self_loops, self.means, self.covars))
        return hmmlearn_models.to_hmmlearn(*parts, exit_state=exit_state)

    @classmethod
    def from_hmmlearn(cls, models: Sequence[GaussianHMM]) -> MotionSymbols:
        """Symbols from left-to-right models of hmmlearn, one a symbol.

        Parameters
        ----------
        models : sequence of hmmlearn.hmm.GaussianHMM
            Models with diagonal covariances, with or without exit states. Where there is none, the
            last self-loop is 1.

        Raises
        ------
        MotionDBError
            If a model is not left-to-right, has other covariances, or numbers that are no
            probabilities or not finite, as `fit` can leave them.
        """
        return cls(*hmmlearn_models.from_hmmlearn(models))


@dataclass(frozen=True, eq=False)
class SegmentTable:
    """All segments of all captures with their scores, one row per segment.

    Rows are ordered by capture, then start; the segments of a capture tile it.
    """

    capture_ids: IntArray  # (segments,): capture numbers
    starts: IntArray  # (segments,): first frames of the canonical motion, 30 a second
    ends: IntArray  # (segments,): last frames + 1
    symbols: IntArray  # (segments,): the most probable symbol (ties: lowest number)
    log_likelihoods: FloatArray  # (segments,): of that symbol, nats per frame
    backgrounds: FloatArray  # (segments,): of the background model, nats per frame
    # (segments, symbols), float32: log-likelihood under every symbol, nats per frame
    scores: Float32Array
    # (segments, columns), float32: see ``meaning.score_vectors``; no columns where none was
    # computed
    movement: Float32Array = field(default_factory=lambda: np.zeros((0, 0), dtype=np.float32))

    def __post_init__(self) -> None:
        """Give segments without movement an array without columns."""
        if self.movement.size == 0:
            none = np.zeros((len(self.starts), 0), dtype=np.float32)
            object.__setattr__(self, "movement", none)


@dataclass(frozen=True, eq=False)
class SymbolSpace:
    """Distances between the symbols, their coordinates and clusters."""

    # Nats per frame, symmetric, zero diagonal
    distances: Annotated[
        FloatArray, Axes("symbols", "symbols"), Within(0.0, LARGEST, "distances of at least 0")
    ]
    # Variance of each distance's Monte-Carlo estimate
    variances: Annotated[FloatArray, Axes("symbols", "symbols")]
    coordinates: Annotated[FloatArray, Axes("symbols", "axes")]  # From multidimensional scaling
    stress: Annotated[FloatArray, Axes(None)]  # Normalised stress of 1, 2, ... dimensions
    clusters: Annotated[IntArray, Axes("symbols")]  # Cluster of every symbol
    # Weights, means and covariances of the Gaussian mixture
    weights: Annotated[FloatArray, Axes("clusters")]
    means: Annotated[FloatArray, Axes("clusters", "axes")]
    covars: Annotated[FloatArray, Axes("clusters", "axes", "axes")]


@dataclass(frozen=True, eq=False)
class Association:
    """IBM Model 2 from motion symbols (source) to words (target)."""

    words: tuple[str, ...]  # The vocabulary (lemmas), sorted; column numbers of ``translation``
    counts: IntArray  # (words,): number of captions that hold each word
    # (symbols + 1, words): t(word | symbol); row 0 is NULL, row s + 1 symbol s. Rows of symbols
    # that were seen beside words sum to 1
    translation: FloatArray
    # (l, m) -> array (m, l + 1), a(i | j, l, m), column 0 is NULL, rows sum to 1
    alignment: dict[tuple[int, int], FloatArray]
    # (steps,): sum of log P(words | symbols) after every EM step of Model 1, then 2
    log_likelihoods: FloatArray


@dataclass(frozen=True, eq=False)
class StoredLearning:
    """The results of ``learn``, in the form of the tables of the store.

    :mod:`motiondb.learn.learned` turns it into a ``LearnedModel`` and back.
    """

    run_id: int  # Run that made it
    symbols: MotionSymbols
    segments: SegmentTable
    space: SymbolSpace  # Tables of the symbol space
    association: Association
    transition_counts: FloatArray  # (symbols + 1, symbols + 1): table ``transition_count``
    # Table ``parameter``: further arrays (float64) and texts (JSON) by name
    parameters: dict[str, FloatArray | str] = field(default_factory=dict)
