"""Motion from a sentence: words to symbols, symbols to a trajectory, real segments along it.

Methods: ``stitched`` (real segments that follow the trajectory, seams blended, feet held),
``trajectory`` (the most probable smooth trajectory itself) and ``montecarlo`` (every frame drawn by
itself, as paper A prints it).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from motiondb import store
from motiondb.database.counting import described_intervals
from motiondb.database.learned import Learned, decode, recognise
from motiondb.errors import QueryError
from motiondb.generate import contact, generation_model, series, stitching, trajectory
from motiondb.pose import pose_vectors, rotation
from motiondb.pose.features import FEATURE_STEP
from motiondb.records import Association, FloatArray, IntArray, Motion, MotionSymbols
from motiondb.symbols import hmm
from motiondb.words import decoding, vocabulary

METHODS = ("stitched", "trajectory", "montecarlo")
MEMBERS = 60
"""Segments per symbol that take part: the likeliest ones."""
LENGTHS = (2, 4)
"""Fewest and most symbols of one action."""
SAID_WEIGHT = 3.0
"""w: how much more than t counts what the symbol's own segments say."""
UNSAID = 1e-4
"""Most that NULL may say of a word: what is asked for is to be seen."""
WORD_WEIGHT = 3.0
JOIN_WEIGHT = 0.5


@dataclass(frozen=True, eq=False)
class Generated:
    """A motion and how it came about.

    Attributes
    ----------
    motion : on the canonical body. symbols : the decoded sequence; positions : per symbol the
        number of its action. decodings : per action. recognised : symbols found again in it.
    provenance : per frame. unknown : words not understood, with the nearest known ones.
    spans : first and last + 1 frame of every action.
    """

    motion: Motion
    symbols: tuple[int, ...]
    positions: tuple[int, ...]
    actions: tuple[tuple[str, ...], ...]
    decodings: tuple[decoding.Decoding, ...]
    recognised: tuple[int, ...]
    provenance: store.Provenance
    unknown: Mapping[str, tuple[str, ...]]
    spans: tuple[tuple[int, int], ...] = ()


def generate(learned: Learned, text: str, seed: int, method: str = "stitched") -> Generated:
    """Make a motion that shows what a sentence says.

    Raises
    ------
    QueryError
        for an unknown method, no known word, or words that no symbols can show.
    """
    if method not in METHODS:
        raise QueryError(f"method: expected one of {', '.join(METHODS)}, found {method!r}.")
    query = vocabulary.parse_query(text, learned.known_words, learned.synonyms)
    actions = [action for action in query.actions if action]
    rng = np.random.default_rng(seed)
    symbols, positions, decodings = _decode_actions(learned, actions)
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
    found = recognise(learned, motion)[3]
    return Generated(
        motion, tuple(int(s) for s in symbols), tuple(positions), tuple(actions),
        tuple(decodings), tuple(int(s) for s in found),
        store.to_provenance(learned.database, captures, frames, edits=edits), query.unknown,
        _spans(positions, lengths),
    )  # fmt: skip


def _spans(positions: Sequence[int], lengths: Sequence[int]) -> tuple[tuple[int, int], ...]:
    """Frames of every action, from the frames of every symbol.

    >>> _spans([0, 0, 1], [10, 5, 20])
    ((0, 15), (15, 35))
    """
    totals = np.bincount(positions, weights=lengths).astype(int)
    ends = np.cumsum(totals)
    return tuple((int(end - total), int(end)) for end, total in zip(ends, totals))


def _decode_actions(
    learned: Learned, actions: Sequence[Sequence[str]]
) -> tuple[IntArray, list[int], list[decoding.Decoding]]:
    """Symbols of all actions; each decoding starts where the one before it ended."""
    symbols: list[int] = []
    positions: list[int] = []
    decodings = []
    association = _spoken_association(learned)
    lengths = _typical_lengths(learned, actions)
    for number, action in enumerate(actions):
        for length in dict.fromkeys((lengths[number], 1)):  # one symbol, where none ever followed
            decoded = decode(
                learned,
                _said_throughout(action, length),
                after=symbols[-1] if symbols else None,
                last=number == len(actions) - 1,
                length=length,
                association=association,
            )
            if decoded is not None:
                break
        if decoded is None:
            raise QueryError(
                f"generate: expected symbols for {' '.join(action)!r}, found none that the words "
                "ever stood beside. Add captures with these words and learn again."
            )
        symbols += decoded.symbols
        positions += [number] * len(decoded.symbols)
        decodings.append(decoded)
    return np.array(symbols), positions, decodings


def _said_throughout(action: Sequence[str], n_symbols: int) -> list[str]:
    """The words of an action as often as it has symbols: it is to be seen all the while, not once.

    >>> _said_throughout(["turn", "left"], 3)
    ['turn', 'left', 'turn', 'left']
    """
    return list(action) * -(-n_symbols // len(action))


def _spoken_association(learned: Learned) -> Association:
    """How well a symbol shows a word, in place of t(word | symbol): (t + w said) * said.

    Captions speak of whole captures, so t alone cannot tell the jump from the standing before it;
    the word map, which compares captures with and without the word, can. ``said`` is the geometric
    mean of what it gives the symbol's segments on average and what it gives the clearest of them:
    those are what generation shows. Rows need not sum to 1: a symbol that shows nothing clearly
    says nothing.
    """
    said = np.sqrt(learned.spoken * learned.clearest)
    t = learned.smoothed_association.translation.copy()
    t[0] = np.minimum(t[0], UNSAID)
    t[1:] = (t[1:] + SAID_WEIGHT * said) * said
    return replace(learned.smoothed_association, translation=t)


def _typical_lengths(learned: Learned, actions: Sequence[Sequence[str]]) -> list[int]:
    """How many symbols an action takes: the median over captures described with its words."""
    captions = store.load_captions(learned.database)
    described = described_intervals(learned.segments, captions, learned.synonyms)
    if not described:
        raise QueryError(
            "generate: expected captures with words, found none. Write some down (motiondb words "
            "set) and learn again."
        )
    lengths = []
    for action in actions:
        said = [d for d in described if set(action) <= set(d.words)]
        said = said or [d for d in described if set(action) & set(d.words)] or described
        typical = np.median([(d.high - d.low) / d.n_actions for d in said])
        lengths.append(int(np.clip(np.ceil(typical), *LENGTHS)))
    return lengths


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
    number = {word: n for n, word in enumerate(learned.association.words)}
    candidates = []
    for k, symbol in enumerate(sequence):
        rows = model.members[model.number[int(symbol)]]
        words = [number[w] for w in actions[positions[k]]]
        candidates.append(_candidates(learned, model, rows, values[owner == k], words, scale, rng))
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
    words: Sequence[int],
    scale: FloatArray,
    rng: np.random.Generator,
) -> stitching.Candidates:
    """Real segments for one position, with their costs; the seed breaks ties between likes."""
    places = np.array([model.segment(learned, row) for row in rows])
    targets, entries, continuations = [], [], []
    for row, (capture, start, end) in zip(rows, places):
        vectors = model.vectors[int(capture)]
        targets.append(_distance(vectors[start:end], part, scale) + _unsaid(learned, row, words))
        entries.append(_edge(vectors, int(start), scale))
        continuations.append(_edge(vectors, int(end), scale))
    noise = rng.uniform(0.0, 0.3, size=len(rows))
    return stitching.Candidates(
        places[:, 0], places[:, 1], places[:, 2],
        np.array(entries), np.array(continuations), np.array(targets) + noise,
    )  # fmt: skip


def _distance(segment: FloatArray, part: FloatArray, scale: FloatArray) -> float:
    """Mean squared difference over twelve moments of both, in spreads."""
    moments = np.linspace(0.0, 1.0, 12)
    a = segment[np.round(moments * (len(segment) - 1)).astype(int)]
    b = part[np.round(moments * (len(part) - 1)).astype(int)]
    return float(np.mean(((a - b) / scale) ** 2))


def _unsaid(learned: Learned, row: int, words: Sequence[int]) -> float:
    """How little the words are said of a segment's surroundings: log(1 + exp(-log-odds)) a word."""
    capture = int(learned.segments.capture_ids[row])
    odds = learned.takes[capture].windows[row - learned.rows[capture].start, list(words)]
    return WORD_WEIGHT * float(np.mean(np.logaddexp(0.0, -odds)))


def _edge(vectors: FloatArray, frame: int, scale: FloatArray) -> FloatArray:
    """Pose and velocity at a frame, in spreads: what must fit at a seam."""
    frame = min(frame, len(vectors) - 1)
    before = vectors[max(frame - 1, 0)]
    pose = vectors[frame] / scale
    speed = (vectors[frame] - before)[4:] / scale[4:] * 5.0
    return np.concatenate([pose, speed]) / np.sqrt(len(pose))
