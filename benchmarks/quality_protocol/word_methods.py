"""Every method of the word tasks, motiondb's and the baselines', trained on one fold.

A method gets the training captures with their words and the gallery without; settings (ridge, C,
neighbours) are chosen by leaving performers out inside the training part.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.language.question.readings import Part, Reading
from motiondb.meaning import word_map
from motiondb.meaning.by_question import search_take
from motiondb.meaning.description_map import (
    fit_description_calibration,
    fit_description_map,
    score_probabilities,
)
from motiondb.meaning.score_vectors import unit
from motiondb.records import FloatArray
from quality_protocol import baselines as base
from quality_protocol.captures import performer_folds
from quality_protocol.recognition import Recognised

Fit = Callable[[FloatArray, NDArray[np.bool_], FloatArray, float], FloatArray]


@dataclass(frozen=True, eq=False)
class Fold:
    """train, gallery: places of captures; words: array (captures, words); who performs each;
    names of the words."""

    train: NDArray[np.int64]
    gallery: NDArray[np.int64]
    words: NDArray[np.bool_]
    performers: tuple[str, ...]
    names: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Answers:
    """A method's answers on one fold.

    word_scores, described : arrays (gallery, words), ranks captures for a word, words for a
        capture. asked : actions (lists of words) -> array (gallery,).
    probabilities : array (gallery, words) or None.
    """

    word_scores: FloatArray
    described: FloatArray
    asked: Callable[[Sequence[Sequence[int]]], FloatArray]
    probabilities: FloatArray | None = None


def mean_of_words(scores: FloatArray) -> Callable[[Sequence[Sequence[int]]], FloatArray]:
    """A caption's score is the mean over its words."""
    return lambda actions: scores[:, [w for action in actions for w in action]].mean(axis=1)


def motiondb_answers(
    seen: Recognised,
    fold: Fold,
    likeness: bool = True,
    told_by: str = "description map",
) -> Answers:
    """The product: word map and caption map, then search in every gallery capture.

    ``likeness``: whether words add their likeness to what the motion suggests. ``told_by``: the
    map that tells words; "caption map" (by the shares of suggested captions) or "word map" instead.
    """
    groups = np.unique([fold.performers[t] for t in fold.train], return_inverse=True)[1]
    fit = word_map.fit_word_map(seen.vectors[fold.train], fold.words[fold.train], groups)
    captions = seen.captions(fold.train, fold.words[fold.train], fold.names)
    if likeness:
        takes = seen.hear(fit, captions, fold.gallery)
    else:  # each is searched alone, so that its likeness to the mean is 0
        takes = [take for g in fold.gallery for take in seen.hear(fit, captions, [int(g)])]

    number = {name: n for n, name in enumerate(fold.names)}

    def ask(actions: Sequence[Sequence[int]]) -> FloatArray:
        parts = tuple(
            Part((tuple(fold.names[word] for word in action),), repeat_of=k)
            for k, action in enumerate(actions)
        )
        hits = [search_take(take, [Reading(parts)], number) for take in takes]
        return np.array([-np.inf if hit is None else hit.log_odds for hit in hits])

    words = np.stack([ask([[w]]) for w in range(fold.words.shape[1])], axis=1)
    vectors = seen.vectors[fold.gallery]
    if told_by == "word map":
        return Answers(words, fit.log_odds(vectors), ask, fit.probabilities(vectors))
    if told_by == "caption map":
        return Answers(words, captions.shares(vectors), ask)
    known = seen.vectors[fold.train], fold.words[fold.train], groups
    scores = fit_description_map(*known).scores(vectors)
    told = score_probabilities(scores, fit_description_calibration(*known))
    return Answers(words, scores, ask, told)


def logistic_answers(features: FloatArray, fold: Fold) -> Answers:
    """One logistic regression a word; C chosen inside."""
    x, y = features[fold.train], fold.words[fold.train]
    strength = choose(x, y, fold, base.logistic, (0.3, 3.0, 30.0))
    odds = base.logistic(x, y, features[fold.gallery], strength)
    return Answers(odds, odds, mean_of_words(odds), 1.0 / (1.0 + np.exp(-odds)))


def window_answers(windows: tuple[FloatArray, NDArray[np.int64]], fold: Fold) -> Answers:
    """Logistic regression on windows, mean log-odds of a capture's windows."""
    rows, owner = unit(windows[0]), windows[1]
    inside = np.isin(owner, fold.train)
    odds = base.logistic(rows[inside], fold.words[owner[inside]], rows, 3.0)
    means = np.stack([odds[owner == g].mean(axis=0) for g in fold.gallery])
    return Answers(means, means, mean_of_words(means), 1.0 / (1.0 + np.exp(-means)))


def ridge_answers(features: FloatArray, fold: Fold) -> Answers:
    """Ridge from pooled features to the words' presence."""
    x, y = features[fold.train], fold.words[fold.train]
    strength = choose(x, y, fold, _ridge, (0.1, 0.3, 1.0, 3.0))
    predicted = _ridge(x, y, features[fold.gallery], strength)
    spread = np.sqrt(y.mean(axis=0) * (1 - y.mean(axis=0))) + 1e-9
    standard = (predicted - y.mean(axis=0)) / spread
    return Answers(predicted, predicted, mean_of_words(standard), np.clip(predicted, 0.0, 1.0))


def tf_idf_answers(features: FloatArray, fold: Fold) -> Answers:
    """Ridge from pooled features to TF-IDF; captions by cosine."""
    x, y = features[fold.train], fold.words[fold.train]
    strength = choose(x, y, fold, _tf_idf_ridge, (0.1, 0.3, 1.0, 3.0))
    predicted = _tf_idf_ridge(x, y, features[fold.gallery], strength)
    return Answers(predicted, predicted, _cosine(unit(predicted), base.tf_idf(y)[1]))


def canonical_answers(features: FloatArray, fold: Fold) -> Answers:
    """CCA between pooled features and TF-IDF; captions by the mean of their words' cosines."""
    x, y = features[fold.train], fold.words[fold.train]
    n_axes = choose(x, y, fold, _tf_idf_canonical, (4, 8, 16, 32))
    predicted = _tf_idf_canonical(x, y, features[fold.gallery], n_axes)
    return Answers(predicted, predicted, _cosine(predicted, base.tf_idf(y)[1]))


def neighbour_answers(similarity: FloatArray, fold: Fold) -> Answers:
    """Captions of the nearest captures; their number chosen inside."""
    y, inner = fold.words[fold.train], similarity[np.ix_(fold.train, fold.train)]
    folds = performer_folds([fold.performers[t] for t in fold.train], 4)
    reached = {}
    for n in (3, 5, 10, 20):
        predicted = np.zeros(y.shape)
        for k in np.unique(folds):
            rest = folds != k
            predicted[~rest] = base.neighbours(
                inner[np.ix_(~rest, rest)], y[rest].astype(np.float64), n
            )
        reached[n] = word_map.precision(predicted, y)
    n_best = max(reached, key=lambda n: reached[n])
    between = similarity[np.ix_(fold.gallery, fold.train)]
    votes = base.neighbours(between, y.astype(np.float64), n_best) + 1e-6 * y.mean(axis=0)
    rows, idf = base.tf_idf(y)
    return Answers(votes, votes, _cosine(unit(base.neighbours(between, rows, n_best)), idf), votes)


def random_answers(fold: Fold, rng: np.random.Generator) -> Answers:
    """No knowledge at all."""
    scores = rng.random((len(fold.gallery), fold.words.shape[1]))
    return Answers(scores, scores, lambda _actions: rng.random(len(fold.gallery)))


def choose(
    x: FloatArray, y: NDArray[np.bool_], fold: Fold, fit: Fit, settings: Sequence[float]
) -> float:
    """The setting that ranks best with performers of the training part left out."""
    folds = performer_folds([fold.performers[t] for t in fold.train], 4)
    common = y.sum(axis=0) >= 3
    reached: Mapping[float, float] = {}
    for setting in settings:
        predicted = np.zeros((len(y), int(common.sum())))
        for k in np.unique(folds):
            rest = folds != k
            predicted[~rest] = fit(x[rest], y[rest][:, common], x[~rest], setting)
        reached = {**reached, setting: word_map.precision(predicted, y[:, common])}
    return max(reached, key=lambda s: reached[s])


def _ridge(x: FloatArray, y: NDArray[np.bool_], test: FloatArray, strength: float) -> FloatArray:
    return base.ridge(x, y.astype(np.float64), test, strength)


def _tf_idf_ridge(
    x: FloatArray, y: NDArray[np.bool_], test: FloatArray, strength: float
) -> FloatArray:
    return base.ridge(x, base.tf_idf(y)[0], test, strength)


def _tf_idf_canonical(
    x: FloatArray, y: NDArray[np.bool_], test: FloatArray, n_axes: float
) -> FloatArray:
    captures, words = base.canonical(x, base.tf_idf(y)[0], test, int(n_axes))
    return captures @ words.T


def _cosine(rows: FloatArray, idf: FloatArray) -> Callable[[Sequence[Sequence[int]]], FloatArray]:
    def ask(actions: Sequence[Sequence[int]]) -> FloatArray:
        words = list({w for action in actions for w in action})
        return rows[:, words] @ idf[words]

    return ask
