"""What is loaded from the store: the learned model, frames, nearby words, grammars, copies.

Frames and outlines of captures are made once, and kept in the cache beside the database. Features
are not kept: they are made from the motions when ``learn`` or a question needs them.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from hashlib import sha256
from importlib import resources
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, BinaryIO, cast

import numpy as np
from numpy.typing import NDArray

from motiondb import store
from motiondb.answers.plain import extended
from motiondb.body.features import (
    FEATURE_STEP,
    N_FEATURES,
    features_of_motions,
    recognition_features,
)
from motiondb.errors import NotLearnedError
from motiondb.language.nearby.table import NearbyTable, read_table
from motiondb.learn.checking import given_certainties
from motiondb.learn.joining import with_segments
from motiondb.learn.learned import PREPARED, Learned, Prepared, prepare
from motiondb.learn.learned_model import LearnedModel, from_stored
from motiondb.learn.recognition import (
    FeaturePool,
    FramePool,
    describe_segments,
    frame_rows,
    recognise_capture,
)
from motiondb.meaning.counting import capture_rows, join_tables, take_rows
from motiondb.meaning.word_evidence import WhenAsked
from motiondb.records import (
    MOTION_FPS,
    Float32Array,
    FloatArray,
    IntArray,
    Motion,
    Relation,
    SegmentTable,
)
from motiondb.workers import HERE, Workers, is_array, runs, trusted

if TYPE_CHECKING:
    from motiondb.grammar.cfg.context_free import Grammar
    from motiondb.grammar.terminals.terminals import Terminals

TABLE = "words.table"  # The shipped table of nearby words
FEATURE_SECONDS = 1e-5  # Time of one processor for a frame; decides only how work is divided
SEGMENTS = "segments"  # Name of scores and movement of all segments in that cache
PLACES = "places"  # Name of the fitted maps of places there
MAPS = "maps"  # End of the names of the fitted maps to captions and words there
_AT_ONCE = 64  # Captures whose features are made together: bounds memory
FRAMES = "frames"  # Name of the frames of all captures in the cache of the database


def load_without_rows(opened: store.Store) -> Learned:
    """The learned model and the catalogue, without scores and movement of segments.

    Neither motions nor scores are looked at, which may lie elsewhere.
    """
    with store.reading(opened):
        if not store.is_learned(opened):
            raise NotLearnedError(
                f"{opened.path}: expected a database that has learned, found only captures. "
                "Run motiondb learn first."
            )
        model = from_stored(store.load_learning(opened, scores=False))
        certainties = given_certainties(model.certainties, model.counted)
        infos = {info.capture_id: info for info in store.load_captures(opened) if info.has_body}
        return Learned(
            **{**vars(model), "certainties": certainties},
            captures=infos,
            captions={n: said for n, said in store.load_captions(opened).items() if n in infos},
            synonyms=store.load_synonyms(opened),
            source=str(opened.path),
        )


def load_learned(opened: store.Store, model: Learned, pool: Callable[[], FramePool]) -> Learned:
    """Load the data that questions need, all of one revision.

    `model`: That of :func:`load_without_rows`.

    `pool`: Gives the frames; captures that it lacks, whose motions cannot be read, are left out.
    """
    with store.reading(opened):
        places = pool().places
        held = _segment_rows(opened, model)
        lacking = set(model.segments.capture_ids.tolist()) - set(held.capture_ids.tolist())
        lacking |= model.captures.keys() - places.keys()
        damaged = {n: info.name for n, info in model.captures.items() if n in lacking}
        if damaged:
            sound = ~np.isin(model.segments.capture_ids, list(damaged))
            model = with_segments(model, take_rows(model.segments, sound))
        return replace(
            model,
            segments=_with_rows(model, held),
            captures={n: info for n, info in model.captures.items() if n not in damaged},
            captions={n: said for n, said in model.captions.items() if n not in damaged},
            damaged=damaged,
        )


def _segment_rows(
    opened: store.Store,
    model: LearnedModel,
    ready: Mapping[int, store.Made] = MappingProxyType({}),
) -> store.CaptureRows:
    """Scores and movement of the segments of a model, side by side, from the cache."""
    make = partial(_make_segment_rows, opened, model)
    return store.cached_segment_rows(opened, SEGMENTS, make, ready)


def _with_rows(model: LearnedModel, held: store.CaptureRows) -> SegmentTable:
    """The segments of a model with their scores and movement, of which more may be held."""
    table, n_symbols = model.segments, model.symbols.n_symbols
    parts = ((0, n_symbols), (n_symbols, held.rows.shape[1]))
    scores, movement = (cast(Float32Array, held.rows.columns(*part)) for part in parts)
    which = np.isin(held.capture_ids, table.capture_ids)
    if not which.all():  # without those of captures that are damaged
        inside = np.repeat(which, np.diff(held.bounds))
        scores, movement = scores[inside], movement[inside]
    return replace(table, scores=scores, movement=movement)


def _make_segment_rows(
    opened: store.Store, model: LearnedModel, captures: Sequence[int]
) -> dict[int, store.Made]:
    """Scores and movement of the segments of some captures, side by side."""
    rows, table = capture_rows(model.segments), model.segments
    made, every = dict[int, store.Made](), store.load_scores(opened, captures)
    for capture, motion in store.readable_motions(opened, every):
        features, scores = recognition_features(motion), every[capture]
        starts, ends = table.starts[rows[capture]], table.ends[rows[capture]]
        cut = starts // FEATURE_STEP, -(-ends // FEATURE_STEP)
        moving = describe_segments(model.feature_space.project(features), features, *cut)
        made[capture] = np.concatenate([scores, moving], axis=1), 0.0
    return made


def segments_of(
    opened: store.Store, model: LearnedModel, captures: Collection[int]
) -> SegmentTable:
    """The segments of some captures with scores and movement, also within a transaction.

    Without those whose motion is damaged and whose rows are not in the cache.
    """
    make = partial(_make_segment_rows, opened, model)
    found = store.cached_segment_rows(opened, SEGMENTS, make, only=captures)
    table = take_rows(model.segments, np.isin(model.segments.capture_ids, found.capture_ids))
    n_columns = model.symbols.n_symbols
    none = np.zeros((0, len(model.score_space.mean)), dtype=np.float32)
    rows = found.rows[:] if len(found.rows) else none
    return replace(table, scores=rows[:, :n_columns], movement=rows[:, n_columns:])


def keep_what_follows(
    opened: store.Store, model: LearnedModel, features: FeaturePool, numbers: Mapping[int, int]
) -> None:
    """Put into the cache what follows from a model that was just saved, until the next ``learn``.

    These are frames of its captures, scores and movement of its segments, and the fitted maps.

    `numbers`: Capture number -> the number that it has among the features.
    """
    table, rows = model.segments, capture_rows(model.segments)

    def of_capture(capture: int) -> store.Made:
        inside = rows[capture]
        return np.concatenate([table.scores[inside], table.movement[inside]], axis=1), 0.0

    with store.reading(opened):
        if store.load_learning_size(opened).run_id == model.run_id:
            framed = WhenAsked(
                numbers, lambda n: (frame_rows(model, features.of_capture(numbers[n])), 0.0)
            )
            pool = load_frames(opened, model, framed)
            _segment_rows(opened, model, WhenAsked(rows, of_capture))
            learned = load_learned(opened, load_without_rows(opened), lambda: pool)
            _place_arrays(opened, learned)
            _map_arrays(opened, learned)


FramesMade = tuple[NDArray[Any], float]
"""Frames (frames, dimensions + 10) of a capture, and 0."""


def load_frames(
    opened: store.Store,
    model: LearnedModel,
    ready: Mapping[int, FramesMade] = MappingProxyType({}),
) -> FramePool:
    """What questions look at in the frames of all captures, from the cache where possible.

    `ready`: Frames that were computed already, by number of the capture.
    """
    make = partial(make_frames, model)
    held = store.cached_rows(opened, FRAMES, make, ready, frames_mark(model))
    none = np.zeros((0, model.symbols.means.shape[2] + 10), dtype=np.float32)
    rows = cast(Float32Array, held.rows) if len(held.rows) else none

    def features(capture: int) -> Float32Array:
        return recognition_features(store.unflatten_motion(store.load_poses(opened, capture)))

    return FramePool(held.capture_ids, held.bounds, rows, features)


def frames_mark(model: LearnedModel) -> str:
    """What frames follow from beside the motions: the projection of the features."""
    space = model.feature_space
    return sha256(space.mean.tobytes() + space.projection.tobytes()).hexdigest()


def make_frames(model: LearnedModel, motions: Sequence[Motion]) -> list[FramesMade]:
    """Frames of some motions, in their order."""
    return [(frame_rows(model, part), 0.0) for part in features_of_motions(motions)]


def features_in(
    file: BinaryIO, opened: store.Store, numbers: Mapping[int, int], workers: Workers = HERE
) -> FeaturePool:
    """Features of the captures whose motion can be read, which lie in a file until they are needed.

    `numbers`: Capture number -> the number that it has in the pool.
    """
    captures, lengths = sorted(numbers, key=lambda capture: numbers[capture]), dict[int, int]()
    for first in range(0, len(captures), _AT_ONCE):
        motions = dict(store.readable_motions(opened, captures[first : first + _AT_ONCE]))
        for (capture, motion), part in zip(motions.items(), _made_by(workers, motions.values())):
            file.write(part.data)
            lengths[numbers[capture]] = motion.n_frames
    bounds = np.cumsum([0, *(-(-n // FEATURE_STEP) for n in lengths.values())], dtype=np.int64)
    rows = store.FileRows(file, (int(bounds[-1]), N_FEATURES), np.float32)
    columns = (np.array(list(each), dtype=np.int64) for each in (lengths, lengths.values()))
    return FeaturePool(next(columns), bounds, cast(Float32Array, rows), next(columns))


def _made_by(workers: Workers, some: Iterable[Motion]) -> list[Float32Array]:
    """Features of some motions, in their order, by workers."""
    motions = list(some)
    pieces = runs(motions, workers.n_pieces(FEATURE_SECONDS * sum(m.n_frames for m in motions)))
    parts = trusted(workers, _are_features, features_of_motions, pieces)
    return [made for _, part in parts for made in part]


def _are_features(found: Sequence[Float32Array], motions: Sequence[Motion]) -> bool:
    """Whether features can be those of motions."""
    return all(
        is_array(features, (-(-motion.n_frames // FEATURE_STEP), N_FEATURES))
        for features, motion in zip(found, motions, strict=True)
    )


def _with_generated(opened: store.Store, learned: Learned) -> Learned:
    """The learned model, with segments of the generated captures if there are any."""
    generated = sorted(i.capture_id for i in learned.captures.values() if i.kind == "generated")
    if not generated:
        return learned
    tables = [recognise_capture(learned, c, store.load_motion(opened, c)) for c in generated]
    return replace(learned, segments=join_tables(learned.segments, *tables))


def searchable(opened: store.Store, learned: Learned) -> Learned:
    """The learned model with the generated captures, and what questions need of all captures."""
    every = _with_generated(opened, learned)
    return learned if every is learned else prepared(opened, every, "searched")


def prepared(opened: store.Store, learned: Learned, kind: str = "evidence") -> Learned:
    """The learned model with arrays of all captures from the cache of the database."""
    mark = f"{PREPARED} {store.learning_mark(opened)}{sorted(learned.damaged) or ''}"
    evidence = store.cached_arrays(opened, kind, lambda: prepare(learned), mark)
    # of the log-odds, questions look at few rows
    evidence |= {n: cast(Any, store.JoinedRows.of(a)) for n, a in evidence.items() if n == "odds"}
    places, maps = _place_arrays(opened, learned), _map_arrays(opened, learned, kind)
    return replace(learned, prepared=Prepared(learned, evidence, places, maps))


def _map_arrays(
    opened: store.Store, learned: Learned, kind: str = "evidence"
) -> Mapping[str, NDArray[Any]]:
    """The fitted maps from motions to captions and to words from the cache.

    `kind`: That of ``prepared``; words of generated captures count in the maps, too.
    """
    if learned.fitted_word_map is None:
        return {}
    performers = sha256(repr(list(learned.performers.items())).encode()).hexdigest()
    mark = f"{store.learning_mark(opened)} {performers} {sorted(learned.damaged) or ''}"
    return store.cached_arrays(opened, kind + MAPS, lambda: learned.map_arrays, mark)


def _place_arrays(opened: store.Store, learned: Learned) -> Mapping[str, NDArray[Any]]:
    """The fitted maps of places from the cache; they stay when other captures are added."""
    if learned.places is None:
        return {}
    make, mark = (lambda: learned.place_arrays), learned.places_digest
    return store.cached_arrays(opened, PLACES, make, mark, False)


@lru_cache(maxsize=1)
def nearby_table() -> NearbyTable:
    """The table that is shipped with motiondb; read once."""
    file = resources.files("motiondb.language.nearby").joinpath(TABLE)
    return read_table(file.read_bytes(), TABLE)


STEPS = "steps"  # Name of the times of all steps in the cache of the database


def load_steps(opened: store.Store) -> dict[int, FloatArray]:
    """The times at which feet strike: number of the capture -> seconds."""
    held = store.cached_rows(opened, STEPS, _make_steps)
    times = held.rows[:].astype(np.float64).ravel() if len(held.rows) else np.zeros(0)
    return dict(zip(held.capture_ids.tolist(), np.split(times, held.bounds[1:-1])))


def _make_steps(motions: Sequence[Motion]) -> list[tuple[Float32Array, float]]:
    """The times of the steps of some motions (steps, 1), in their order."""
    from motiondb.body import gait  # whoever asks for words does without

    made = []
    for motion in motions:
        points, _ = gait.over_ground(motion.joint_positions(), MOTION_FPS)
        made.append((gait.step_times(points, MOTION_FPS)[:, None].astype(np.float32), 0.0))
    return made


OUTLINES = "outlines"  # Name of the outlines of all captures in the cache of the database


OutlineMade = tuple[NDArray[np.int16], float]
"""Outline (frames, 12) of a capture, and how far from it a copy may be."""


def load_outlines(
    opened: store.Store, ready: Mapping[int, OutlineMade] = MappingProxyType({})
) -> store.CaptureRows:
    """Outlines of all captures, and how far from them a copy may be.

    `ready`: Those that were made already, by number of the capture.
    """
    return store.cached_rows(opened, OUTLINES, _make_outlines, ready)


def find_relations(
    opened: store.Store,
    new: set[str],
    workers: Workers = HERE,
    at_hand: Mapping[str, Motion] = MappingProxyType({}),
) -> tuple[list[Relation], dict[int, OutlineMade]]:
    """Copies, mirror images and cuts among the captures, of which at least one is new.

    Also gives the outlines of the new ones, by number of the capture.

    `new`: Names of captures. `at_hand`: Motions of some of them, by name: these are not loaded.
    """
    from motiondb.search import copies  # compiled code
    from motiondb.search.copy_outlines import N_AXES

    infos = store.load_captures(opened)
    ready = {
        info.capture_id: _make_outlines([at_hand[info.name]])[0]
        for info in infos
        if info.has_body and info.name in at_hand
    }
    held = load_outlines(opened, ready)
    place_of = {number: place for place, number in enumerate(held.capture_ids.tolist())}
    infos = [info for info in infos if info.capture_id in place_of]
    numbers = [info.capture_id for info in infos]

    def poses_of(n: int) -> Float32Array:
        return copies.copy_poses(store.load_motion(opened, numbers[n]))

    places = np.array([place_of[number] for number in numbers], dtype=np.int64)
    firsts, ends = held.bounds[places], held.bounds[places + 1]
    limbs = held.rows if len(held.rows) else np.zeros((0, N_AXES), dtype=np.int16)
    library = copies.Library(ends - firsts, held.values[places], firsts, limbs, poses_of)
    fresh = [n for n, info in enumerate(infos) if info.name in new]
    old = [n for n, info in enumerate(infos) if info.name not in new]
    found = copies.find_copies(library, fresh, None, workers)
    found += copies.find_copies(library, old, fresh, workers)
    relations = [
        Relation(
            infos[c.query].name,
            infos[c.take].name,
            c.kind,
            c.start / MOTION_FPS,
            c.end / MOTION_FPS,
            c.distance,
        )
        for c in found
    ]
    made = {
        numbers[n]: (held.rows[firsts[n] : ends[n]], float(held.values[places[n]])) for n in fresh
    }
    return relations, made


def _make_outlines(motions: Sequence[Motion]) -> list[OutlineMade]:
    """Outline and reach of some motions, in their order."""
    from motiondb.search import copies
    from motiondb.search.copy_outlines import outline

    poses = (copies.copy_poses(motion) for motion in motions)
    return [(outline(each), copies.reach(each)) for each in poses]


@dataclass(frozen=True, eq=False)
class LearnedGrammar:
    """The result of ``grammar learn``."""

    name: str
    """Name of the grammar."""
    sources: tuple[store.GrammarSource, ...]
    """The takes, numbered as in ``terminals.takes``."""
    terminals: Terminals
    """Segments of the takes and their terminals."""
    symbols: IntArray
    """The motion symbol from which each terminal was made, -1 where it was made from none."""
    grammar: Grammar
    """The rules, with their probabilities."""
    sentences: IntArray
    """Segments [first, end) of each sentence. The sentences follow one another, and no sentence
    spans two takes. Segments between them were left out as errors."""
    parses: tuple[tuple[int, ...], ...]
    """For each sentence the numbers of the rules of its tree, in preorder (``derive_by``)."""
    bits: Mapping[str, float] = field(default_factory=dict)
    """Name of each part of the description -> its length, bits."""
    run_id: int = 0
    """The run that learned the grammar; set when it is saved."""
    grammar_id: int = 0
    """Number of the grammar in the store; set when it is saved."""

    def string(self, first: int, end: int) -> tuple[str, ...]:
        """Return the names of the terminals of segments [first, end)."""
        return tuple(self.terminals.names[k] for k in self.terminals.labels[first:end])

    @property
    def strings(self) -> tuple[tuple[str, ...], ...]:
        """The sentences as strings of terminals."""
        return tuple(self.string(int(a), int(b)) for a, b in self.sentences)

    @property
    def takes(self) -> list[list[tuple[str, ...]]]:
        """The sentences of each take that has some, in the order of the takes."""
        firsts = self.terminals.takes[self.sentences[:, 0]].tolist()
        of_take: dict[int, list[tuple[str, ...]]] = {}
        for take, sentence in zip(firsts, self.strings, strict=True):
            of_take.setdefault(take, []).append(sentence)
        return list(of_take.values())

    @property
    def tints(self) -> dict[str, int]:
        """The tint number of each terminal, which is the same in all pictures of a grammar."""
        return {name: k for k, name in enumerate(self.terminals.names)}

    @property
    def stored(self) -> store.StoredGrammar:
        """The same as plain data, as the store keeps it."""
        parts = self.terminals
        return extended(
            store.StoredGrammar,
            self,
            terminals=parts.names,
            takes=parts.takes,
            starts=parts.starts,
            ends=parts.ends,
            labels=parts.labels,
            medoids=parts.medoids,
            objective=parts.objective,
            start=self.grammar.start,
            rules=tuple((rule.left, rule.right, rule.probability) for rule in self.grammar.rules),
        )


def load_learned_grammar(opened: store.Store, name: str) -> LearnedGrammar:
    """Load the grammar of this name, with its rules and terminals."""
    from motiondb.grammar.cfg.context_free import Grammar, Rule
    from motiondb.grammar.terminals.terminals import Terminals  # 0.1 s, in no other question

    stored = store.load_grammar(opened, name)
    rules = tuple(Rule(*rule) for rule in stored.rules)
    return extended(
        LearnedGrammar,
        stored,
        terminals=extended(Terminals, stored, names=stored.terminals),
        grammar=Grammar(stored.start, rules, stored.terminals),
    )
