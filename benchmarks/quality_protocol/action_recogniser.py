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
    capture. said : array (captures, words). one_action : array (captures, words, words), whether
    a caption names one action by both words. space : whitening.
    """

    names: tuple[str, ...]
    performers: tuple[str, ...]
    words: tuple[str, ...]
    windows: FloatArray
    owners: IntArray
    said: NDArray[np.bool_]
    one_action: NDArray[np.bool_]
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
    one_action = np.array([_names_of_one_action(c.captions, words) for c in kept])
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
        one_action, space, mean, spread,
    )  # fmt: skip


def one_action_phrases(caption: str) -> list[str]:
    """The parts of a description that each name one action.

    Descriptions of the index are lists with commas, under a heading before a dash. Those in
    capitals ("Run Jump Stop") list actions without commas, and sentences tell several: neither is
    split.

    >>> one_action_phrases("dance - small jetes, attitude/arabesque")
    ['dance small jetes', 'dance attitude/arabesque']
    >>> one_action_phrases("run/jog, veer left"), one_action_phrases("Run Duck Underneath")
    (['run/jog', 'veer left'], [])
    """
    if caption != caption.lower():
        return []
    heading, _, rest = caption.partition(" - ")
    if not rest:
        return [part.strip() for part in heading.split(",")]
    return [f"{heading} {part.strip()}" for part in rest.split(",")]


def _names_of_one_action(
    captions: Sequence[str], words: Sequence[tuple[str, str]]
) -> NDArray[np.bool_]:
    """Whether a caption names one action by both words: array (words, words)."""
    together = np.zeros((len(words), len(words)), dtype=bool)
    for phrase in (p for caption in captions for p in one_action_phrases(caption)):
        there = np.array([bool(re.search(pattern, phrase)) for _, pattern in words])
        together |= there[:, None] & there[None]
    return together


def fold_models(of: Recogniser, folds: IntArray) -> list[Models]:
    """Models without each fold of captures."""
    return [of.fit(np.flatnonzero(folds == fold)) for fold in range(int(folds.max()) + 1)]


def capture_folds(of: Recogniser, rng: np.random.Generator) -> IntArray:
    """Folds of captures, dealt out at random."""
    return rng.permutation(len(of.names)) % N_FOLDS


def performer_folds(of: Recogniser) -> IntArray:
    """One fold a performer."""
    return np.unique(of.performers, return_inverse=True)[1]
