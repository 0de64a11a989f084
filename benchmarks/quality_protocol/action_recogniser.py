"""An outside recogniser of actions: one logistic regression for each word, on real captures.

It shares no symbols, places and words with motiondb: its words are those of the captions as
written, its features are pooled over windows of three seconds, and it is trained again without the
captures, or without all captures of the performers, that a motion was made from. Captures are dealt
out to folds; what is made from a capture is judged by the models without its fold.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.records import Float32Array, FloatArray, IntArray
from motiondb.symbols.feature_space import FeatureSpace
from quality_protocol.captures import Capture
from quality_protocol.judge import cut, pool

N_FOLDS = 8
"""Parts of the cross-validation that fits the calibration. Chosen by hand; not tuned."""


@dataclass(frozen=True, eq=False)
class Recogniser:
    """Windows of the real captures and the words of their captions.

    windows : array (windows, values), standardised. owners : array (windows,), number of the
    capture. said : array (captures, words). folds : array (captures,). space : whitening.
    """

    names: tuple[str, ...]
    performers: tuple[str, ...]
    words: tuple[str, ...]
    windows: FloatArray
    owners: IntArray
    said: NDArray[np.bool_]
    space: FeatureSpace
    mean: FloatArray
    spread: FloatArray

    def view(self, features: Float32Array) -> FloatArray:
        """Standardised windows of a motion's recognition features."""
        rows = np.array([pool(part) for part in cut(self.space.project(features))])
        return np.asarray((rows - self.mean) / self.spread)

    def fit(self, out: Collection[int]) -> Models:
        """Models without some captures; a word that no capture left says is never the first."""
        from sklearn.linear_model import LogisticRegression

        kept = ~np.isin(self.owners, list(out))
        x, y = self.windows[kept], self.said[self.owners[kept]]
        weights = np.full((x.shape[1] + 1, len(self.words)), 0.0)
        weights[-1] = -np.inf
        for w in np.flatnonzero(y.any(axis=0)):
            model = LogisticRegression(C=0.02, class_weight="balanced", max_iter=300)
            model.fit(x, y[:, w])
            weights[:-1, w], weights[-1, w] = model.coef_[0], model.intercept_[0]
        return Models(weights)


@dataclass(frozen=True, eq=False)
class Models:
    """weights : array (values + 1, words), the constants last."""

    weights: FloatArray

    def first(self, windows: FloatArray) -> int:
        """Number of the word of largest mean log-odds."""
        odds = windows @ self.weights[:-1] + self.weights[-1]
        return int(np.argmax(odds.mean(axis=0)))


def make_recogniser(
    captures: Sequence[Capture], words: Sequence[tuple[str, str]], space: FeatureSpace
) -> Recogniser:
    """A recogniser of words, given with the patterns by which captions say them."""
    kept = [c for c in captures if c.captions]
    texts = [re.sub(r"([a-z])([A-Z])", r"\1 \2", " ".join(c.captions)).lower() for c in kept]
    said = np.array([[bool(re.search(p, text)) for _, p in words] for text in texts])
    rows, owners = [], []
    for number, capture in enumerate(kept):
        for part in cut(space.project(capture.features)):
            rows.append(pool(part))
            owners.append(number)
    windows = np.array(rows)
    mean, spread = windows.mean(axis=0), windows.std(axis=0) + 1e-6
    return Recogniser(
        tuple(c.name for c in kept), tuple(c.performer for c in kept),
        tuple(word for word, _ in words), (windows - mean) / spread, np.array(owners), said,
        space, mean, spread,
    )  # fmt: skip


def fold_models(of: Recogniser, folds: IntArray) -> list[Models]:
    """Models without each fold of captures."""
    return [of.fit(np.flatnonzero(folds == fold)) for fold in range(int(folds.max()) + 1)]


def capture_folds(of: Recogniser, rng: np.random.Generator) -> IntArray:
    """Folds of captures, dealt out at random."""
    return rng.permutation(len(of.names)) % N_FOLDS


def performer_folds(of: Recogniser) -> IntArray:
    """One fold a performer."""
    return np.unique(of.performers, return_inverse=True)[1]
