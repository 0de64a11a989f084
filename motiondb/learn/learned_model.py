"""Everything that ``learn`` derives, as one frozen record without the store."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np

from motiondb.learn.codec import from_values, to_values
from motiondb.learn.drift import DriftBaseline
from motiondb.learn.knowledge import Started
from motiondb.meaning import extents
from motiondb.meaning.counting import Counted
from motiondb.meaning.edge_map import EdgeMap
from motiondb.meaning.motion_judge import MotionJudge
from motiondb.meaning.place_fitting import Places
from motiondb.meaning.regression import Certainties
from motiondb.meaning.resemblance import PooledMap
from motiondb.meaning.score_vectors import ScoreSpace
from motiondb.meaning.word_map import WordMap
from motiondb.records import (
    Association,
    Axes,
    FloatArray,
    MotionSymbols,
    SegmentTable,
    StoredLearning,
    SymbolSpace,
)
from motiondb.symbols.feature_space import FeatureSpace
from motiondb.symbols.settings import RecutSettings


@dataclass(frozen=True, eq=False)
class LearnedModel:
    """Everything that ``learn`` derives; the store keeps it as a whole."""

    run_id: int  # Run that made or last changed it
    symbols: MotionSymbols
    segments: SegmentTable  # Segments of all captures that were learned from or added since
    space: SymbolSpace  # Distances, coordinates and clusters of the symbols
    association: Association  # IBM Model 2 from symbols to words
    # (symbols + 1, symbols + 1): how often symbol column - 1 follows symbol row - 1; row 0 is the
    # begin of a capture, column 0 its end
    transition_counts: FloatArray
    feature_space: FeatureSpace  # Projection of recognition features
    score_space: ScoreSpace  # Standardisation of scores and movement
    context_space: extents.ContextSpace  # Contexts of activities
    counted: Counted  # Exact counts, from which the models of words follow
    # (symbols l, words m) -> number of described intervals of this shape
    lengths: Mapping[tuple[int, int], int]
    # Lemmas that the dictionary gave for the words of captions
    lemmas: Mapping[str, str]
    cutting: RecutSettings  # How the symbols cut a motion into segments
    drift_baseline: DriftBaseline  # The motion learned from, as drift is measured against it
    # (updates,): objective after every accepted update, bits; decreasing
    description_lengths: FloatArray = field(default_factory=lambda: np.zeros(0))
    certainties: Certainties = field(default_factory=Certainties)
    # Knowledge of another database that it learned with. Then symbols and feature space are that
    # knowledge's, and association, transitions, lengths and word map join its sums with ``counted``
    started: Started | None = None
    # The rest is None if no words were written.
    # Calibrated map from score vectors to words
    fitted_word_map: WordMap | None = None
    places: Places | None = None  # Where in their takes the actions of captions happen
    judge: MotionJudge | None = None  # Decides which words a generated motion shows
    edges: EdgeMap | None = None  # Evidence for words at each frame: where actions begin and end
    # Also None with a start: second opinion on the words of an interval, for the resemblance to an
    # example, and (2,) the calibration of the words of a motion
    pooled: PooledMap | None = None
    description_calibration: Annotated[FloatArray, Axes(2)] | None = None


TABLES = ("run_id", "symbols", "segments", "space", "association", "transition_counts")
"""Fields that have tables of the store; the others are in its table ``parameter``."""


def to_stored(model: LearnedModel) -> StoredLearning:
    """The stored form of the learned model; :func:`from_stored` is the inverse."""
    parameters = to_values(model, LearnedModel, without=TABLES)
    return StoredLearning(**{name: getattr(model, name) for name in TABLES}, parameters=parameters)


def from_stored(stored: StoredLearning) -> LearnedModel:
    """The learned model from its stored form."""
    given = {name: getattr(stored, name) for name in TABLES}
    return from_values(LearnedModel, stored.parameters, given=given)
