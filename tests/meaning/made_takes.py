"""Takes and captions made up for the tests of this room."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motiondb.meaning.place_map import (
    RIDGE,
    FittedPlaces,
    ListedTakes,
    PlaceMap,
    spreads_of,
    take_weights,
)
from motiondb.meaning.regression import fit_ridge, prepare
from motiondb.meaning.score_vectors import unit
from motiondb.meaning.word_evidence import TakeScores
from motiondb.records import FloatArray


def take(
    windows: list[list[float]], whole: tuple[float, ...] | list[float] = (0.0, 0.0, 0.0)
) -> TakeScores:
    """A capture of segments of 10 frames; windows: a row a segment, a column a word."""
    starts = 10 * np.arange(len(windows))
    return TakeScores(starts, starts + 10, np.array(windows), np.array(whole))


WALK_TURN_SIT = take(
    [[4.0, -4, -4], [4, -4, -4], [4, -4, -4], [-4, 4, -4], [-4, -4, 4], [-4, -4, 4]], (2.0, 1, 3)
)


def all_of(*log_odds: float) -> float:
    """Log-odds of the product of probabilities, the long way."""
    probability = np.prod([1 / (1 + np.exp(-odds)) for odds in log_odds])
    return float(np.log(probability / (1 - probability)))


def made_captions(n: int, seed: int = 0) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Vectors (n, 6) of length 1, and which of five words their captions hold, at least one."""
    rng = np.random.default_rng(seed)
    presence = rng.random((n, 5)) < 0.4
    presence[:, 0] |= ~presence.any(axis=1)
    return unit(rng.normal(size=(n, 6))), presence


def weights_of(takes: ListedTakes) -> FloatArray:
    """The weights of the rows of some takes."""
    return take_weights(takes.seconds, takes.owners)


def map_places(vectors: FloatArray, shown: FloatArray, weights: FloatArray) -> PlaceMap:
    """The map of places (rows, words), fitted anew: the slow twin of leaving rows out."""
    slopes, constants = fit_ridge(vectors, shown, RIDGE, weights)
    mean = weights @ shown / weights.sum()
    return PlaceMap(slopes, constants - mean, spreads_of(mean))


def fit_places(takes: ListedTakes, shown: FloatArray) -> FittedPlaces:
    """The regression to places (rows, words), of all rows at once."""
    return FittedPlaces(prepare(takes.vectors, weights_of(takes), RIDGE).fit(shown))
