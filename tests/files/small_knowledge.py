"""Knowledge of three symbols and three words, made up, for tests."""

from __future__ import annotations

import numpy as np

from motiondb.body.features import N_FEATURES
from motiondb.language.translation.explanation import ExpectedCounts
from motiondb.learn.knowledge import Knowledge, Origin, Taught
from motiondb.meaning.extents import ContextSpace
from motiondb.meaning.regression import Certainties, Certainty
from motiondb.meaning.score_vectors import ScoreSpace
from motiondb.meaning.word_map import word_moments
from motiondb.records import MotionSymbols, SymbolSpace
from motiondb.symbols.feature_space import FeatureSpace
from motiondb.symbols.settings import RecutSettings

WORDS = ("jump", "run", "walk")
N_SYMBOLS, N_DIMS = 3, 2
N_COLUMNS = N_SYMBOLS + 5 * N_DIMS + 3 + 5 * N_DIMS + 87
ORIGIN = Origin("small", "0.1.0", 12, 12, 3, 60.5, {"CMU": 12}, ({"kind": "learn", "seed": 0},), "")


def small_rows(seed: int = 0, n: int = 12) -> tuple[np.ndarray, np.ndarray]:
    """Vectors of length 1 and presence of the three words, some of each."""
    rng = np.random.default_rng(seed)
    vectors = rng.normal(size=(n, N_COLUMNS))
    vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
    presence = np.arange(n)[:, None] % 3 == np.arange(3)
    return np.round(vectors * 2.0**16) / 2.0**16, presence


def small_taught(seed: int = 0) -> Taught:
    vectors, presence = small_rows(seed)
    rng = np.random.default_rng(seed + 100)
    return Taught(
        words=WORDS,
        said=np.array([4, 4, 4]),
        seconds=np.array([1.0, 2.5, 4.0]),
        transitions=rng.integers(1, 9, (N_SYMBOLS + 1, N_SYMBOLS + 1)).astype(float),
        shapes={(2, 1): 8, (3, 2): 4},
        expected=ExpectedCounts(
            rng.integers(1, 9, (N_SYMBOLS + 1, 3)).astype(float),
            {(2, 1): np.array([[1.0, 4.0, 3.0]]), (3, 2): np.ones((2, 4))},
            12,
        ),
        moments=word_moments(vectors, presence),
        ridge=0.3,
        calibration=np.array([4.0, 1.0, -0.5]),
        information=np.diag([3.0, 2.0, 1.0]),
        certainties=Certainties(
            Certainty(np.array([0.7]), -0.3, 2.5), Certainty(np.array([4.0, 0.2]), -2.0, np.nan)
        ),
    )


def small_knowledge(seed: int = 0) -> Knowledge:
    rng = np.random.default_rng(seed + 200)
    distances = np.array([[0.0, 1.0, 2.0], [1.0, 0.0, 1.5], [2.0, 1.5, 0.0]])
    return Knowledge(
        origin=ORIGIN,
        feature_space=FeatureSpace(np.zeros(N_FEATURES), rng.normal(size=(N_FEATURES, N_DIMS))),
        symbols=MotionSymbols(
            np.array([2, 2, 1]),
            np.array([[0.5, 0.75], [0.25, 0.5], [0.5, 0.0]]),
            rng.normal(size=(N_SYMBOLS, 2, N_DIMS)),
            np.ones((N_SYMBOLS, 2, N_DIMS)),
        ),
        cutting=RecutSettings(20.0, 8),
        space=SymbolSpace(
            distances, np.zeros((3, 3)), rng.normal(size=(3, 2)), np.array([0.5, 0.25]),
            np.array([0, 0, 1]), np.array([0.75, 0.25]), np.zeros((2, 2)),
            np.stack([np.eye(2)] * 2),
        ),
        score_space=ScoreSpace(np.zeros(N_COLUMNS), np.ones(N_COLUMNS)),
        context_space=ContextSpace(
            np.zeros(N_FEATURES), np.zeros(2 * N_FEATURES), np.ones((2 * N_FEATURES, 4))
        ),
        taught=small_taught(seed),
    )  # fmt: skip
