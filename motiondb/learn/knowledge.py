"""The learned model of a database without motion and captions: symbols, words, counts, and origin.

:class:`Knowledge` holds what another database needs to begin with: the feature space and the
symbols, which it adopts, and what was learned from captions (:class:`Taught`): sums over captions,
which do not reveal single captures or captions. :class:`Started` is the same inside a database that
learned with it, with the user's synonyms applied to its words.

Files of knowledge may come from untrusted sources. Everything that learning with them relies on is
checked (:func:`array_faults`): a file that passes may be useless, but it cannot make a calculation
fail or run for hours.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from functools import cached_property
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from motiondb.body.features import N_FEATURES
from motiondb.language.translation.explanation import ExpectedCounts
from motiondb.learn.codec import DeclaredArray, declared_arrays, square
from motiondb.meaning.extents import ContextSpace
from motiondb.meaning.regression import Certainties
from motiondb.meaning.score_vectors import ScoreSpace, block_sizes
from motiondb.meaning.word_map import WordMap, WordMoments, solve_word_map
from motiondb.records import LARGEST, Axes, FloatArray, IntArray, MotionSymbols, SymbolSpace, Within
from motiondb.symbols.feature_space import FeatureSpace
from motiondb.symbols.settings import RecutSettings


@dataclass(frozen=True)
class Origin:
    """The origin of knowledge."""

    name: str  # Name, such as "cmu"
    version: str  # Version of motiondb that learned it
    captures: int  # Number of captures that it was learned from
    captions: int  # Number of described intervals from which the words were learned
    performers: int
    seconds: float  # Duration of the captures
    licences: Mapping[str, int] = field(default_factory=dict)  # Licence of captures -> their number
    # The runs of ``learn``: kind, version, seed and parameters
    runs: tuple[Mapping[str, object], ...] = ()
    credit: str = ""  # The acknowledgement that the source asks for
    digest: str = ""  # SHA-256 of the file that it was read from; "" before it is written

    def facts(self) -> dict[str, Any]:
        """The origin as plain facts, for a file or JSON, without the digest of its own file."""
        facts = asdict(self)
        del facts["digest"]
        return {**facts, "licences": dict(self.licences), "runs": [dict(r) for r in self.runs]}


@dataclass(frozen=True, eq=False)
class Taught:
    """The model learned from captions, as sums over captions and captures."""

    words: tuple[str, ...]
    # Number of captions with each word
    said: Annotated[
        IntArray, Axes("words"), Within(1, LARGEST, "words that some caption holds", is_whole=True)
    ]
    # Median duration of an action that captions describe with the word
    seconds: Annotated[FloatArray, Axes("words"), Within(0.01, 1e5, "durations of actions above 0")]
    # As in ``counting.Counts``
    transitions: Annotated[
        FloatArray,
        Axes("symbols + 1", "symbols + 1"),
        Within(0.0, LARGEST, "counts of transitions of at least 0"),
    ]
    shapes: Mapping[tuple[int, int], int]  # (symbols l, words m) -> number of described intervals
    expected: ExpectedCounts
    moments: WordMoments  # Of the word map
    # Ridge and calibration of the word map
    ridge: Annotated[float, Within(1e-3, 1e3, "a ridge from 0.001 to 1000")]
    calibration: Annotated[FloatArray, Axes(3)]
    # Fisher information of the calibration, summed over the intervals and words
    information: Annotated[FloatArray, Axes(3, 3)]
    certainties: Certainties


@dataclass(frozen=True, eq=False)
class Knowledge:
    """Everything that a database starts from.

    Attributes
    ----------
    origin : Origin
        Its origin.
    feature_space : FeatureSpace
        Projection of recognition features.
    symbols : MotionSymbols
        Motion symbols.
    cutting : RecutSettings
        How the symbols cut a motion into segments.
    space : SymbolSpace
        Distances, coordinates and clusters of the symbols.
    score_space : ScoreSpace
        Standardisation of scores and movement.
    context_space : ContextSpace
        Contexts of activities.
    taught : Taught
        The model learned from captions.
    """

    origin: Origin
    feature_space: FeatureSpace
    symbols: MotionSymbols
    cutting: RecutSettings
    space: SymbolSpace
    score_space: ScoreSpace
    context_space: ContextSpace
    taught: Taught

    @property
    def words(self) -> tuple[str, ...]:
        """Its words, sorted."""
        return self.taught.words


@dataclass(frozen=True, eq=False)
class Started:
    """Knowledge that a database learned with."""

    knowledge: Knowledge  # The knowledge as it was read
    names: tuple[str, ...]  # The name of each of its words after the user's synonyms are applied

    @property
    def taught(self) -> Taught:
        """The model learned from captions there."""
        return self.knowledge.taught

    @cached_property
    def word_map(self) -> WordMap:
        """The word map of the start alone, with the start's names of words."""
        return solve_word_map(self.taught.moments, self.taught.ridge, self.taught.calibration)

    @cached_property
    def seconds(self) -> dict[str, float]:
        """Word -> median duration of an action that is described with it."""
        return dict(zip(self.names, self.taught.seconds.tolist()))

    @cached_property
    def said(self) -> dict[str, int]:
        """Word -> number of captions there that hold it."""
        totals: dict[str, int] = {}
        for name, count in zip(self.names, self.taught.said.tolist()):
            totals[name] = totals.get(name, 0) + count
        return totals

    def columns(self, words: tuple[str, ...]) -> NDArray[np.float64]:
        """Which of its words equals which of other words: array (its words, words), 0 or 1."""
        number = {word: n for n, word in enumerate(words)}
        chosen = np.zeros((len(self.names), len(words)))
        for row, name in enumerate(self.names):
            if name in number:
                chosen[row, number[name]] = 1.0
        return chosen


def begin(knowledge: Knowledge, synonyms: Mapping[str, str]) -> Started:
    """Return knowledge with the synonyms of a database (lemma -> lemma) applied to its words.

    Two words of the knowledge that are synonyms here become one; an interval whose caption holds
    both counts twice for it.
    """
    return Started(knowledge, tuple(synonyms.get(word, word) for word in knowledge.taught.words))


MOST_SYMBOLS, MOST_STATES, MOST_DIMENSIONS = 1_000, 64, 64
"""Bounds on sizes, so that memory and time stay small. ``learn`` makes at most 240 symbols of 6
states in 24 dimensions."""
MOST_WORDS = 5_000  # Bound on the number of words
LONGEST = 400  # Bound on symbols and words of a described interval
APART = ("origin", "taught.words")
"""Fields of knowledge that are not among the arrays of its file."""

Arrays = Mapping[str, FloatArray]


def array_faults(arrays: Arrays, n_words: int) -> list[str]:
    """The faults of the arrays of knowledge; empty for valid ones."""
    declared = declared_arrays(Knowledge, APART)
    faults = [*_names(arrays, declared)] or [*_finite(arrays, declared)]
    faults = faults or [*_sizes(arrays, n_words)] or [*_shapes(arrays, declared, n_words)]
    return faults or [*_ranges(arrays, declared), *_tables(arrays)] or [*_equations(arrays)]


def _names(arrays: Arrays, declared: list[DeclaredArray]) -> Iterator[str]:
    there = {one.optional for one in declared if one.name in arrays} | {""}
    missing = {one.name for one in declared if one.optional in there} - set(arrays)
    if missing:
        yield f"expected the array {min(missing)!r}, found none of this name"
    extra = set(arrays) - {one.name for one in declared}
    if extra:
        yield f"expected known arrays only, found {min(extra)!r}"


def _finite(arrays: Arrays, declared: list[DeclaredArray]) -> Iterator[str]:
    may_be_unknown = {one.name for one in declared if one.may_be_unknown}
    for name, values in arrays.items():
        if name in may_be_unknown and np.isnan(values).all():
            continue
        if not np.isfinite(values).all() or np.abs(values).max(initial=0.0) > LARGEST:
            yield f"expected finite numbers up to {LARGEST:g} in {name!r}, found others"


def _sizes(arrays: Arrays, n_words: int) -> Iterator[str]:
    means = arrays["symbols.means"]
    if means.ndim != 3:
        yield f"expected 'symbols.means' with 3 axes, found {means.ndim}"
        return
    bounds = (MOST_SYMBOLS, MOST_STATES, MOST_DIMENSIONS)
    names = ("symbols", "states", "dimensions")
    for what, size, most in zip(names, means.shape, bounds):
        if not 1 <= size <= most:
            yield f"expected 1 to {most} {what}, found {size}"
    if not 1 <= n_words <= MOST_WORDS:
        yield f"expected 1 to {MOST_WORDS} words, found {n_words}"
    if arrays["space.coordinates"].ndim != 2 or arrays["space.weights"].ndim != 1:
        yield "expected coordinates with 2 axes and weights of clusters with 1, found others"


def _shapes(arrays: Arrays, declared: list[DeclaredArray], n_words: int) -> Iterator[str]:
    symbols, states, dimensions = arrays["symbols.means"].shape
    columns = arrays["score_space.mean"].size
    sizes = {
        "symbols": symbols,
        "symbols + 1": symbols + 1,
        "states": states,
        "dimensions": dimensions,
        "columns": columns,
        "words": n_words,
        "features": N_FEATURES,
        "contexts": 2 * N_FEATURES,
        "axes": arrays["space.coordinates"].shape[1],
        "clusters": len(arrays["space.weights"]),
    }
    for one in declared:
        known = {**sizes, **(one.sizes or {})}
        shape = tuple(known[size] if isinstance(size, str) else size for size in one.shape)
        if one.is_symmetric:
            shape = (columns * (columns + 1) // 2,)
        actual = arrays[one.name].shape if one.name in arrays else shape
        if len(actual) != len(shape) or any(
            want not in (None, have) for want, have in zip(shape, actual)
        ):
            wanted = tuple("any" if n is None else n for n in shape)
            yield f"expected {one.name!r} of shape {wanted}, found {actual}"
    if columns < symbols or sum(block_sizes(columns - symbols)) != columns - symbols:
        yield f"expected columns of movement after {symbols} symbols, found {columns - symbols}"


def _ranges(arrays: Arrays, declared: list[DeclaredArray]) -> Iterator[str]:
    """Faults of ranges: those declared beside the fields, and those that need other fields."""
    expected: dict[str, bool] = {}  # what is expected -> whether it is so
    for one in declared:
        if one.within is not None:
            values, what = arrays[one.name], one.within.what
            sound = _within(values, one.within.low, one.within.high)
            sound &= not one.within.is_whole or _is_whole(values)
            expected[what] = expected.get(what, True) and sound
    n_states, states = arrays["symbols.n_states"], arrays["symbols.means"].shape[1]
    is_used = np.arange(states) < n_states[:, None]
    loops, covars = arrays["symbols.self_loops"][is_used], arrays["symbols.covars"][is_used]
    clusters, intervals = arrays["space.clusters"], float(arrays["taught.moments.n"])
    expected |= {
        f"numbers of states from 1 to {states}": _within(n_states, 1, states)
        and _is_whole(n_states),
        "self-loops from 0 to below 1": _within(loops, 0.0, np.nextafter(1.0, 0.0)),
        "variances of symbols above 0": _within(covars, 1e-6, LARGEST),
        "clusters that there are": _within(clusters, 0, len(arrays["space.weights"]) - 1)
        and _is_whole(clusters),
        "no word in more intervals than there are": _within(
            arrays["taught.moments.words"], 0.0, intervals + 0.5
        ),
        "a calibration that rises": _within(arrays["taught.calibration"][:1], 1e-3, 1e3),
    }
    yield from (f"expected {what}, found others" for what, sound in expected.items() if not sound)


def _within(values: FloatArray, low: float, high: float) -> bool:
    return bool(((values >= low) & (values <= high)).all())


def _is_whole(values: FloatArray) -> bool:
    return bool((values == np.rint(values)).all())


def _tables(arrays: Arrays) -> Iterator[str]:
    """Faults of the tables of shapes (symbols l, words m)."""
    name = "taught.expected.alignment"
    shapes, sizes, values = (arrays[f"{name}.{part}"] for part in ("keys", "sizes", "values"))
    lengths = arrays["taught.shapes"]
    if shapes.shape[1:] != (2,) or sizes.shape != shapes.shape:
        yield f"expected 2 columns in '{name}.keys' and '{name}.sizes', found others"
        return
    pairs = np.concatenate([shapes, lengths[:, :2]])
    if not (_within(pairs, 1, LONGEST) and _is_whole(pairs)):
        yield f"expected intervals of 1 to {LONGEST} symbols and words, found others"
        return
    if len(np.unique(shapes, axis=0)) != len(shapes):
        yield "expected every shape of an alignment once, found one twice"
    if (sizes != shapes[:, ::-1] + [0, 1]).any():
        yield f"expected m rows and l + 1 columns in '{name}.sizes', found others"
        return
    cells = int(sizes.prod(axis=1).sum())
    if cells != len(values):
        yield f"expected {cells} numbers in '{name}.values', found {len(values)}"
    if not _within(values, 0.0, LARGEST):
        yield "expected counts of alignments of at least 0, found others"
    if not (_within(lengths[:, 2], 1, LARGEST) and _is_whole(lengths[:, 2])):
        yield "expected counts of intervals of at least 1, found others"


def _equations(arrays: Arrays) -> Iterator[str]:
    """Whether the systems of equations of the word map and of the calibration can be solved."""
    n, vectors = float(arrays["taught.moments.n"]), arrays["taught.moments.vectors"]
    gram = square(arrays["taught.moments.gram"]) - np.outer(vectors, vectors) / n
    information = arrays["taught.information"]
    try:
        np.linalg.cholesky(gram + 0.05 * np.eye(len(gram)))
        np.linalg.cholesky(0.5 * (information + information.T) + 1e-6 * np.eye(3))
    except np.linalg.LinAlgError:
        yield "expected sums of squares of score vectors, found a matrix that cannot be one"
