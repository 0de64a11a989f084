"""Everything that ``learn`` derives, as one frozen record without the store."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from motiondb.learn.drift import DriftBaseline
from motiondb.learn.knowledge import Started
from motiondb.meaning import extents
from motiondb.meaning.calibration import Certainties
from motiondb.meaning.counting import Counted
from motiondb.meaning.edge_map import EdgeMap
from motiondb.meaning.motion_judge import MotionJudge
from motiondb.meaning.place_fitting import Places
from motiondb.meaning.pooled_map import PooledMap
from motiondb.meaning.score_vectors import ScoreSpace
from motiondb.meaning.word_map import WordMap
from motiondb.records import (
    Association,
    FloatArray,
    MotionSymbols,
    SegmentTable,
    SymbolSpace,
)
from motiondb.symbols.acquisition import AcquisitionSettings
from motiondb.symbols.feature_space import FeatureSpace


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
    # Contexts of activities; None in databases of versions that did not learn them
    context_space: extents.ContextSpace | None = None
    # Calibrated map from score vectors to words; None if no words were written
    fitted_word_map: WordMap | None = None
    certainties: Certainties = field(default_factory=Certainties)
    # (symbols l, words m) -> number of described intervals of this shape
    lengths: Mapping[tuple[int, int], int] = field(default_factory=dict)
    # Exact counts; None in databases of versions that did not keep them
    counted: Counted | None = None
    # Lemmas that the dictionary gave for the words of captions
    lemmas: Mapping[str, str] = field(default_factory=dict)
    # How the symbols cut a motion into segments
    cutting: AcquisitionSettings = field(default_factory=AcquisitionSettings)
    # (updates,): objective after every accepted update, bits; decreasing
    description_lengths: FloatArray = field(default_factory=lambda: np.zeros(0))
    # The baseline of drift; None in databases of versions that did not keep it
    drift_baseline: DriftBaseline | None = None
    # Where in their takes the actions of captions happen, as ``learn`` found them; None if no words
    # were written, and in databases of versions that did not learn them
    places: Places | None = None
    # Knowledge of another database that it learned with. Then symbols and feature space are that
    # knowledge's, and association, transitions, lengths and word map join its sums with ``counted``
    started: Started | None = None
    # Decides which words a generated motion shows; None if no words were written, and in databases
    # of versions without a judge
    judge: MotionJudge | None = None
    # Evidence for words at each frame, by which intervals are refined; None where no words were
    # written, and in databases of versions that did not learn it
    edges: EdgeMap | None = None
    # Second opinion on the words of an interval, for the resemblance to an example; None if no
    # words were written, with a start, and in databases of versions that did not learn it
    pooled: PooledMap | None = None
    # (2,) or None: calibration of words told of a motion; None in the same cases: then the word map
    # tells them
    description_calibration: FloatArray | None = None
