"""Segments, motion symbols, their space and their words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from motiondb import hmmlearn_models
from motiondb.records.arrays import Float32Array, FloatArray, IntArray

if TYPE_CHECKING:
    from hmmlearn.hmm import GaussianHMM


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
            If a model is not left-to-right, or has other covariances.
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
    # (segments, columns), float32: see ``search.movement``; no columns where none was computed
    movement: Float32Array = field(default_factory=lambda: np.zeros((0, 0), dtype=np.float32))

    def __post_init__(self) -> None:
        """Give segments without movement an array without columns."""
        if self.movement.size == 0:
            none = np.zeros((len(self.starts), 0), dtype=np.float32)
            object.__setattr__(self, "movement", none)


@dataclass(frozen=True, eq=False)
class SymbolSpace:
    """Distances between the symbols, their coordinates and clusters."""

    distances: FloatArray  # (symbols, symbols): nats per frame, symmetric, zero diagonal
    variances: FloatArray  # (symbols, symbols): variance of each distance's Monte-Carlo estimate
    coordinates: FloatArray  # (symbols, dimensions): from multidimensional scaling
    stress: FloatArray  # (tried dimensions,): normalised stress of 1, 2, ... dimensions
    clusters: IntArray  # (symbols,): cluster of every symbol
    weights: FloatArray  # (clusters,): weights of the Gaussian mixture
    means: FloatArray  # (clusters, dimensions): means of the Gaussian mixture
    covars: FloatArray  # (clusters, dimensions, dimensions): covariances of the Gaussian mixture


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

    :mod:`motiondb.learn.parameter_arrays` turns it into typed records
    (``motiondb.learn.learned_model.LearnedModel``) and back; nothing else reads ``parameters``.
    """

    run_id: int  # Run that made it
    symbols: MotionSymbols
    segments: SegmentTable
    space: SymbolSpace  # Tables of the symbol space
    association: Association
    transition_counts: FloatArray  # (symbols + 1, symbols + 1): table ``transition_count``
    # Table ``parameter``: further arrays (float64) and texts (JSON) by name
    parameters: dict[str, FloatArray | str] = field(default_factory=dict)
