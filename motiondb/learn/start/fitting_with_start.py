"""Ridge and calibration of the joint word map, from own captions and the start.

As in :mod:`motiondb.meaning.maps.word_map`, predictions for own intervals are made without their
group: here by the joint map of the start and the other groups. The largest ridge whose ranking is
nearly the best is taken. The calibration is the start's, moved by the own predictions: the Fisher
information of the start's calibration, times the weight of the start, represents its data.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from motiondb.learn.start.joining import join_word_map, start_weight
from motiondb.learn.start.knowledge import Started
from motiondb.meaning.maps.word_map import RIDGES, TOLERANCE, WordMap, calibrate, precision
from motiondb.meaning.maps.word_moments import WordMoments, word_moments
from motiondb.records import FloatArray, IntArray

N_FOLDS = 5  # Folds of groups that are held out in turn
LEAST_INTERVALS = 10  # Own intervals below which ridge and calibration are the start's


@dataclass(frozen=True, eq=False)
class OwnRows:
    """Own described intervals and the start."""

    vectors: FloatArray  # (rows, columns): score vectors
    # (rows, words): which words of the joint vocabulary were written about each interval
    presence: NDArray[np.bool_]
    groups: IntArray  # (rows,): performers
    words: tuple[str, ...]
    started: Started

    @cached_property
    def moments(self) -> WordMoments:
        """Sums over all rows."""
        return word_moments(self.vectors, self.presence)

    def without(self, rows: NDArray[np.bool_], ridge: float, calibration: FloatArray) -> WordMap:
        """The joint word map without some own rows."""
        left = self.moments - word_moments(self.vectors[rows], self.presence[rows])
        return join_word_map(left, self.words, self.started, ridge, calibration)


def choose_ridge_and_calibration(own_rows: OwnRows) -> tuple[float, FloatArray]:
    """Ridge and calibration of the joint word map."""
    taught = own_rows.started.taught
    if len(own_rows.vectors) < LEAST_INTERVALS:
        return taught.ridge, taught.calibration
    here = own_rows.presence.any(axis=0) & ~own_rows.presence.all(axis=0)
    if not here.any():
        return taught.ridge, taught.calibration
    folds = _folds(own_rows.groups)
    maps = {
        ridge: [own_rows.without(folds == k, ridge, taught.calibration) for k in np.unique(folds)]
        for ridge in RIDGES
    }
    scores = {ridge: _predict(own_rows, folds, fits) for ridge, fits in maps.items()}
    reached = {
        ridge: precision(z[:, here], own_rows.presence[:, here]) for ridge, z in scores.items()
    }
    least = (1.0 - TOLERANCE) * max(reached.values())
    ridge = max(r for r, p in reached.items() if p >= least)
    logits = np.stack(
        [
            _logits(maps[ridge][place], own_rows)
            for place in np.searchsorted(np.unique(folds), folds)
        ]
    )
    calibration = calibrate(
        scores[ridge][:, here],
        logits[:, here],
        own_rows.presence[:, here].astype(np.float64),
        taught.calibration,
        start_weight(len(own_rows.vectors)) * taught.information,
    )
    return ridge, calibration


def _predict(own_rows: OwnRows, folds: IntArray, fits: list[WordMap]) -> FloatArray:
    """Evidence over spread of every word, by the map without the row's fold: (rows, words)."""
    z = np.zeros(own_rows.presence.shape)
    for fold, fit in zip(np.unique(folds), fits):
        inside = folds == fold
        z[inside] = fit.evidence(own_rows.vectors[inside]) / fit.spreads
    return z


def _logits(fit: WordMap, own_rows: OwnRows) -> FloatArray:
    priors: FloatArray = np.log(fit.priors) - np.log1p(-fit.priors)
    return priors[: own_rows.presence.shape[1]]


def _folds(groups: IntArray) -> IntArray:
    """Folds of whole groups; of single rows if there is one group only."""
    names, numbers = np.unique(groups, return_inverse=True)
    if len(names) < 2:
        return np.arange(len(groups)) % min(N_FOLDS, len(groups))
    return numbers % N_FOLDS
