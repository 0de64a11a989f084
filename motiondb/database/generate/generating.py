"""Motion from a sentence: words to symbols, symbols to a trajectory, real segments along it.

Methods: ``stitched`` (real segments that follow the trajectory, seams blended, feet held),
``trajectory`` (the most probable smooth trajectory itself) and ``montecarlo`` (every frame drawn by
itself, as paper A prints it).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb import store
from motiondb.database.ask.word_search import understand
from motiondb.database.generate import hearing
from motiondb.database.generate.action_symbols import decode_actions, word_numbers
from motiondb.database.learn.learned import Learned
from motiondb.errors import QueryError
from motiondb.generate import clarity, contact, generation_model, series, stitching, trajectory
from motiondb.pose import pose_vectors, rotation
from motiondb.pose.features import FEATURE_STEP
from motiondb.records import FloatArray, IntArray, Motion, MotionSymbols
from motiondb.symbols import hmm
from motiondb.words import decoding
from motiondb.words.question.known import KnownQuestion
from motiondb.words.question.plain import plain_actions
from motiondb.words.question.tree import NotUsed

METHODS = ("stitched", "trajectory", "montecarlo")
MEMBERS = 60
"""Segments per symbol that take part: the likeliest ones."""
WORD_WEIGHT = 3.0
LENGTH_WEIGHT = 1.0
ATTEMPTS = 4
"""Times that a motion is made at most until every action is heard in it."""
HEARD = 0.5
"""Mean probability from which on a word counts as heard."""
JOIN_WEIGHT = 0.5


@dataclass(frozen=True, eq=False)
class Generated:
    """A motion and how it came about.

    Attributes
    ----------
    motion : on the canonical body. symbols : the decoded sequence; positions : per symbol the
        number of its action. decodings : per action. recognised : symbols found again in it.
    provenance : per frame. question : the sentence as it was understood.
    spans : first and last + 1 frame of every action.
    not_used : what of the sentence the motion takes no account of.
    """

    motion: Motion
    symbols: tuple[int, ...]
    positions: tuple[int, ...]
    actions: tuple[tuple[str, ...], ...]
    decodings: tuple[decoding.Decoding, ...]
    recognised: tuple[int, ...]
    provenance: store.Provenance
    question: KnownQuestion
    spans: tuple[tuple[int, int], ...] = ()
    not_used: tuple[NotUsed, ...] = ()

    @property
    def unknown(self) -> Mapping[str, tuple[str, ...]]:
        """Words not understood, with the nearest known ones."""
        return self.question.unknown


def generate(learned: Learned, text: str, seed: int, method: str = "stitched") -> Generated:
    """Make a motion that shows what a sentence says.

    Raises
    ------
    QueryError
        for an unknown method, no known word, or words that no symbols can show.
    """
    if method not in METHODS:
        raise QueryError(f"method: expected one of {', '.join(METHODS)}, found {method!r}.")
    question = understand(learned, text)
    said, left_out = plain_actions(question.tree)
    actions = [action for action in said if action]
    if not actions:
        raise QueryError(
            f"generate: expected an action to show, found only what not to show in {text!r}. "
            "Say what the motion is to show."
        )
    made = _best_attempt(learned, actions, seed, method)
    provenance = store.to_provenance(learned.database, made.captures, made.frames, edits=made.edits)
    return Generated(
        made.motion, tuple(int(s) for s in made.symbols), made.positions, tuple(actions),
        made.decodings, tuple(int(s) for s in made.found), provenance, question, made.spans,
        (*question.not_used, *left_out),
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Attempt:
    """A motion made of certain symbols, where its frames come from, and how it is heard.

    clarities : per action, log c (see ``generate.clarity``). unclear : per action, the symbol that
        shows it least, where the action is not heard.
    """

    motion: Motion
    symbols: IntArray
    positions: tuple[int, ...]
    decodings: tuple[decoding.Decoding, ...]
    captures: IntArray
    frames: FloatArray
    edits: tuple[str, ...]
    spans: tuple[tuple[int, int], ...]
    found: IntArray
    clarities: tuple[float, ...]
    unclear: Mapping[int, int]


def _best_attempt(
    learned: Learned, actions: Sequence[Sequence[str]], seed: int, method: str
) -> _Attempt:
    """Make the motion, hear it, and make what is not heard anew without its least clear symbol.

    The attempt whose actions are clearest on average is kept.
    """
    avoided: list[set[int]] = [set() for _ in actions]
    best: _Attempt | None = None
    for _ in range(ATTEMPTS):
        attempt = _attempt(learned, actions, avoided, seed, method)
        if best is None or np.mean(attempt.clarities) > np.mean(best.clarities):
            best = attempt
        if not attempt.unclear:
            break
        for action, symbol in attempt.unclear.items():
            avoided[action].add(symbol)
    assert best is not None
    return best


def _attempt(
    learned: Learned,
    actions: Sequence[Sequence[str]],
    avoided: Sequence[set[int]],
    seed: int,
    method: str,
) -> _Attempt:
    rng = np.random.default_rng(seed)
    symbols, positions, decodings = decode_actions(learned, actions, avoided)
    model = _Model(learned, symbols)
    if method == "stitched":
        motion, captures, frames, edits, lengths = _stitched(
            learned, model, symbols, positions, actions, rng
        )
    else:
        motion, lengths = _from_model(model, symbols, rng, method)
        captures = np.full(motion.n_frames, -1)
        frames = np.zeros(motion.n_frames)
        edits = (method,) * motion.n_frames
    probabilities, found = hearing.hear(learned, motion)
    clarities, unclear = _hear_actions(learned, actions, probabilities, symbols, positions, lengths)
    return _Attempt(
        motion, symbols, tuple(positions), tuple(decodings), captures, frames, edits,
        _spans(positions, lengths), found, clarities, unclear,
    )  # fmt: skip


def _hear_actions(
    learned: Learned,
    actions: Sequence[Sequence[str]],
    probabilities: FloatArray,
    symbols: IntArray,
    positions: Sequence[int],
    lengths: Sequence[int],
) -> tuple[tuple[float, ...], dict[int, int]]:
    """How clear every action is, and the least clear symbol of those that are not heard."""
    bounds = np.minimum(np.cumsum([0, *lengths]), len(probabilities) - 1)
    clarities, unclear = [], {}
    for number, action in enumerate(actions):
        asked = word_numbers(learned, action)
        own = [k for k, position in enumerate(positions) if position == number]
        stretch = probabilities[bounds[own[0]] : bounds[own[-1] + 1] + 1]
        clarities.append(hearing.log_clarity(stretch, asked))
        if not hearing.is_heard(stretch, asked, HEARD):
            parts = [probabilities[bounds[k] : bounds[k + 1] + 1] for k in own]
            least = int(np.argmin([hearing.log_clarity(part, asked) for part in parts]))
            unclear[number] = int(symbols[own[least]])
    return tuple(clarities), unclear


def _spans(positions: Sequence[int], lengths: Sequence[int]) -> tuple[tuple[int, int], ...]:
    """Frames of every action, from the frames of every symbol.

    >>> _spans([0, 0, 1], [10, 5, 20])
    ((0, 15), (15, 35))
    """
    totals = np.bincount(positions, weights=lengths).astype(int)
    ends = np.cumsum(totals)
    return tuple((int(end - total), int(end)) for end, total in zip(ends, totals))


class _Model:
    """The used symbols' segments and finer HMMs; kept together because all methods need both."""

    def __init__(self, learned: Learned, sequence: IntArray) -> None:
        self.used = np.unique(sequence)
        self.number = {int(s): n for n, s in enumerate(self.used)}
        self.members = [_members(learned, int(s)) for s in self.used]
        ids = {int(learned.segments.capture_ids[i]) for rows in self.members for i in rows}
        motions = {c: store.load_motion(learned.database, c) for c in sorted(ids)}
        self.paths = {c: pose_vectors.to_path(m) for c, m in motions.items()}
        self.leg_lengths = {c: m.leg_length for c, m in motions.items()}
        local = np.concatenate([turned for _, turned in self.paths.values()])
        self.means = pose_vectors.mean_rotations(local)
        self.vectors = {c: _vectors(self.paths[c], self.means) for c in self.paths}
        self.symbols = self._fine(learned)

    def segment(self, learned: Learned, row: int) -> tuple[int, int, int]:
        """Capture and frames of a row of the segment table."""
        table = learned.segments
        return int(table.capture_ids[row]), int(table.starts[row]), int(table.ends[row])

    def _fine(self, learned: Learned) -> MotionSymbols:
        segments, states = [], []
        for s, rows in zip(self.used, self.members):
            vectors, paths = [], []
            for row in rows:
                capture, start, end = self.segment(learned, row)
                features = learned.features(capture)[
                    start // FEATURE_STEP : -(-end // FEATURE_STEP)
                ]
                path = hmm.viterbi(learned.symbols, int(s), features)
                vectors.append(self.vectors[capture][start:end])
                paths.append(np.repeat(path, FEATURE_STEP)[: end - start])
            segments.append(vectors)
            states.append(paths)
        return generation_model.generation_symbols(
            segments, states, int(learned.symbols.n_states.max())
        )

    def series(self, sequence: IntArray) -> series.Series:
        """The finer HMMs of a symbol sequence, joined."""
        return series.join_series(self.symbols, np.array([self.number[int(s)] for s in sequence]))


def _members(learned: Learned, symbol: int) -> IntArray:
    """Rows of the likeliest segments of a symbol."""
    rows = np.flatnonzero(learned.segments.symbols == symbol)
    if len(rows) == 0:
        raise QueryError(
            f"symbol {symbol}: expected segments in the database, found none. Learn again."
        )
    order = np.argsort(-learned.segments.log_likelihoods[rows], kind="stable")
    return np.sort(rows[order[:MEMBERS]])


def _vectors(path: tuple[FloatArray, FloatArray], means: FloatArray) -> FloatArray:
    turning = pose_vectors.TURNING
    relative = rotation.multiply(rotation.conjugate(means)[turning], path[1][:, turning])
    return np.concatenate([path[0], rotation.log(relative).reshape(len(path[0]), -1)], axis=1)


def _trajectory(model: _Model, sequence: IntArray) -> tuple[FloatArray, IntArray]:
    """The most probable trajectory (frames, D) and per frame its position in the sequence."""
    joined = model.series(sequence)
    states = np.repeat(np.arange(len(joined.self_loops)), series.expected_durations(joined))
    means, covars = joined.means[states], joined.covars[states]
    values = trajectory.most_probable(means, covars)
    n_dims = values.shape[1]
    values = trajectory.widen(values, means[:, :n_dims], covars[:, :n_dims])
    return values, joined.positions[states]


def _from_model(
    model: _Model, sequence: IntArray, rng: np.random.Generator, method: str
) -> tuple[Motion, list[int]]:
    """The motion, and the frames of every symbol."""
    if method == "trajectory":
        values, owner = _trajectory(model, sequence)
    else:
        joined = model.series(sequence)
        states = series.sample_states(joined, rng)
        n_dims = joined.means.shape[1] // 3
        values = series.sample_outputs(joined, states, rng)[:, :n_dims]
        owner = joined.positions[states]
    leg_length = float(np.median(list(model.leg_lengths.values())))
    motion = pose_vectors.from_vectors(values, model.means, leg_length=leg_length)
    motion = contact.lock_feet(motion) if method == "trajectory" else motion
    return motion, np.bincount(owner, minlength=len(sequence)).tolist()


def _stitched(
    learned: Learned,
    model: _Model,
    sequence: IntArray,
    positions: Sequence[int],
    actions: Sequence[Sequence[str]],
    rng: np.random.Generator,
) -> tuple[Motion, IntArray, FloatArray, tuple[str, ...], list[int]]:
    values, owner = _trajectory(model, sequence)
    scale = np.concatenate(list(model.vectors.values())).std(axis=0) + 1e-6
    costs = [_word_costs(learned, word_numbers(learned, action)) for action in actions]
    candidates = []
    for k, symbol in enumerate(sequence):
        rows = model.members[model.number[int(symbol)]]
        said = costs[positions[k]][rows]
        candidates.append(_candidates(learned, model, rows, values[owner == k], said, scale, rng))
    chosen = stitching.choose(candidates, JOIN_WEIGHT)
    pieces = [
        stitching.Piece(int(c.captures[i]), int(c.starts[i]), int(c.ends[i]))
        for c, i in zip(candidates, chosen)
    ]
    stitched = stitching.stitch(pieces, model.paths)
    lengths = [model.leg_lengths[piece.capture] for piece in pieces]
    motion = pose_vectors.from_path(
        stitched.path, stitched.rotations, leg_length=float(np.median(lengths))
    )
    motion = contact.lock_feet(motion)
    edits = tuple("foot lock" if s == 1 else f"blend {s:.2f}, foot lock" for s in stitched.shares)
    frames = stitched.frames.astype(float)
    return motion, stitched.captures, frames, edits, [piece.end - piece.start for piece in pieces]


def _candidates(
    learned: Learned,
    model: _Model,
    rows: IntArray,
    part: FloatArray,
    said: FloatArray,
    scale: FloatArray,
    rng: np.random.Generator,
) -> stitching.Candidates:
    """Real segments for one position, with their costs; the seed breaks ties between likes.

    said : array (rows,), what their words cost.
    """
    places = np.array([model.segment(learned, row) for row in rows])
    targets, entries, continuations = [], [], []
    for capture, start, end in places:
        vectors = model.vectors[int(capture)]
        targets.append(_distance(vectors[start:end], part, scale))
        entries.append(_edge(vectors, int(start), scale))
        continuations.append(_edge(vectors, int(end), scale))
    noise = rng.uniform(0.0, 0.3, size=len(rows))
    return stitching.Candidates(
        places[:, 0], places[:, 1], places[:, 2],
        np.array(entries), np.array(continuations), np.array(targets) + said + noise,
    )  # fmt: skip


def _distance(segment: FloatArray, part: FloatArray, scale: FloatArray) -> float:
    """Mean squared difference over twelve moments of both, in spreads, and of their lengths."""
    moments = np.linspace(0.0, 1.0, 12)
    a = segment[np.round(moments * (len(segment) - 1)).astype(int)]
    b = part[np.round(moments * (len(part) - 1)).astype(int)]
    ratio = float(np.log(len(segment) / len(part)))
    return float(np.mean(((a - b) / scale) ** 2)) + LENGTH_WEIGHT * ratio**2


def _word_costs(learned: Learned, asked: IntArray) -> FloatArray:
    """What showing an action by each segment costs: array (segments,), at least 0.

    log(1 + exp(-log-odds)) a word for how little it is said of the segment's surroundings, what
    people wrote included, and what the segment shows that was not asked for.
    """
    odds = np.concatenate([learned.takes[c].windows for c in learned.rows])[:, asked]
    unsaid = np.logaddexp(0.0, -odds).mean(axis=1)
    unasked = clarity.log_unasked(learned.segment_probabilities, asked)
    return np.asarray(WORD_WEIGHT * (unsaid - clarity.UNASKED_SHARE * unasked))


def _edge(vectors: FloatArray, frame: int, scale: FloatArray) -> FloatArray:
    """Pose and velocity at a frame, in spreads: what must fit at a seam."""
    frame = min(frame, len(vectors) - 1)
    before = vectors[max(frame - 1, 0)]
    pose = vectors[frame] / scale
    speed = (vectors[frame] - before)[4:] / scale[4:] * 5.0
    return np.concatenate([pose, speed]) / np.sqrt(len(pose))
