"""The learned model of a database without motion and captions: symbols, words, counts, and origin.

:class:`Knowledge` holds what another database needs to begin with: the feature space and the
symbols, which it adopts, and what was learned from captions (:class:`Taught`): sums over captions,
which do not reveal single captures or captions. :class:`Started` is the same inside a database that
learned with it, with the user's synonyms applied to its words.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import cached_property
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from motiondb.language.translation.explanation import ExpectedCounts
from motiondb.meaning.calibration import Certainties
from motiondb.meaning.extents import ContextSpace
from motiondb.meaning.score_vectors import ScoreSpace
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
