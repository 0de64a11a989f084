"""An outside judge of actions: logistic regression and time warping on real captures.

It shares no symbols and no words with motiondb: classes are verbs in the captions as written, and a
stretch of motion is judged by real captures of performers other than those it was made from.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.meaning import alignment
from motiondb.records import Float32Array, FloatArray, IntArray
from motiondb.symbols.feature_space import FeatureSpace
from quality_protocol.captures import Capture

CLASSES = {
    "walk": r"\bwalk", "run": r"\b(run|jog)", "jump": r"\b(jump|hop)", "dance": r"\b(danc|salsa)",
    "climb": r"\bclimb", "sit": r"\bsit", "kick": r"\bkick", "box": r"\b(box|punch)",
}  # fmt: skip
"""Class -> how captions say it; the class's name is what motiondb is asked for."""
WINDOW = 45
"""Feature frames (3 s) of the windows that logistic regression is trained on."""


@dataclass(frozen=True, eq=False)
class Judge:
    """Real captures of exactly one class.

    features : whitened, per capture. classes, performers : arrays (captures,).
    windows : array (windows, values), standardised pooled features; owners : array (windows,).
    """

    names: tuple[str, ...]
    features: tuple[Float32Array, ...]
    classes: IntArray
    performers: NDArray[np.str_]
    windows: FloatArray
    owners: IntArray
    space: FeatureSpace

    def without(self, performers: Collection[str]) -> NDArray[np.bool_]:
        """Captures of other performers."""
        return ~np.isin(self.performers, list(performers))

    def by_regression(self, stretches: Sequence[tuple[Float32Array, Collection[str]]]) -> IntArray:
        """Most probable class of whitened stretches, each beside performers to leave out."""
        from sklearn.linear_model import LogisticRegression

        models = {}
        answers = []
        for features, performers in stretches:
            left_out = frozenset(performers)
            if left_out not in models:
                kept = self.without(left_out)[self.owners]
                model = LogisticRegression(C=0.1, class_weight="balanced", max_iter=500)
                models[left_out] = model.fit(self.windows[kept], self._targets()[kept])
            model = models[left_out]
            odds = model.decision_function(self._view(features)).mean(axis=0)
            answers.append(int(model.classes_[np.argmax(odds)]))
        return np.array(answers)

    def by_warping(self, stretches: Sequence[tuple[Float32Array, Collection[str]]]) -> IntArray:
        """Class of the capture that holds the part nearest to a stretch's middle three seconds."""
        answers = []
        for features, performers in stretches:
            first = max(0, (len(features) - WINDOW) // 2)
            query = features[first : first + WINDOW]
            kept = np.flatnonzero(self.without(performers))
            distance = [alignment.best_part(query, self.features[n].T)[0] for n in kept]
            answers.append(int(self.classes[kept[int(np.argmin(distance))]]))
        return np.array(answers)

    def _targets(self) -> IntArray:
        return self.classes[self.owners]

    def _view(self, features: Float32Array) -> FloatArray:
        return np.array([pool(part) for part in cut(features)])


def make_judge(captures: Sequence[Capture], space: FeatureSpace) -> Judge:
    """A judge from the captures whose captions name exactly one class."""
    labels = [classes_of(c) for c in captures]
    chosen = [c for c, words in zip(captures, labels) if len(words) == 1]
    classes = np.array([words[0] for words in labels if len(words) == 1])
    features = tuple(space.project(c.features) for c in chosen)
    rows, owners = [], []
    for number, values in enumerate(features):
        for part in cut(values):
            rows.append(pool(part))
            owners.append(number)
    return Judge(
        tuple(CLASSES), features, classes, np.array([c.performer for c in chosen]),
        np.array(rows), np.array(owners), space,
    )  # fmt: skip


def classes_of(capture: Capture) -> list[int]:
    """Numbers of the classes that a capture's captions name."""
    text = re.sub(r"([a-z])([A-Z])", r"\1 \2", " ".join(capture.captions)).lower()
    return [n for n, pattern in enumerate(CLASSES.values()) if re.search(pattern, text)]


def cut(features: Float32Array) -> list[Float32Array]:
    """Windows of three seconds with half overlap; one if there is less."""
    starts = range(0, max(len(features) - WINDOW, 0) + 1, WINDOW // 2)
    return [features[a : a + WINDOW] for a in starts]


def pool(features: Float32Array) -> FloatArray:
    """Mean and spread, and the quartiles."""
    quantiles = np.quantile(features, (0.1, 0.5, 0.9), axis=0).ravel()
    return np.concatenate([features.mean(axis=0), features.std(axis=0), quantiles]).astype(float)
