"""The probability that a word may be taken as another, from WordNet's evidence and vectors.

Logistic regression over, for a word s and a target t: the root of every channel's evidence
(``nearby_words.pairs``), the log of their sum and of their largest, how many there are; three
cosines of sentence vectors, their square, their largest, and products of their mean with the
evidence (``products``); and how general and how frequent the target is, how frequent and how
ambiguous s is, and how much of either is motion. It is fitted on the tuning list: every pair of one
of its words and a word of the vocabulary with any evidence, right or wrong by the list.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.records import FloatArray
from nearby_words.pairs import CHANNELS, Lexicon, evidence

PENALTY = 0.5
"""C of scikit-learn; 0.2, 0.5 and 1 were alike on the tuning list, cross-validated."""
MOST_EVIDENCE = 1.5
"""Evidence of one channel at most. Chosen by hand; not tuned."""
MOTION = frozenset({4, 29, 33, 35, 38})
"""noun.act; verbs of body, sport, contact, motion."""
N_SENSES = 4
"""Senses that count in how much of a word is motion."""


@dataclass(frozen=True)
class Similarity:
    """Sentence vectors: rows of words, array (sentences, words, dimensions); None without."""

    rows: Mapping[str, int]
    vectors: FloatArray | None

    def cosines(self, word: str, targets: Sequence[str]) -> FloatArray:
        """Array (targets, sentences)."""
        if self.vectors is None:
            return np.zeros((len(targets), 0))
        rows = [self.rows[t] for t in targets]
        one = self.vectors[:, self.rows[word]].astype(np.float64)
        return np.einsum("sd,snd->ns", one, self.vectors[:, rows].astype(np.float64))


@dataclass(frozen=True)
class Model:
    """How features become a probability."""

    coefficients: FloatArray
    constant: float

    def probabilities(self, features: FloatArray) -> FloatArray:
        """Array (pairs,) of array (pairs, features)."""
        return 1.0 / (1.0 + np.exp(-(features @ self.coefficients + self.constant)))


@dataclass(frozen=True)
class Targets:
    """Features of a target: target -> (how general, how frequent, how much motion)."""

    facts: Mapping[str, tuple[float, float, float]]


def target_facts(words: Iterable[str], lexicon: Lexicon) -> Targets:
    """General: the log of how many definitions it heads. Frequent: of its count in texts."""
    counts = lexicon.wordnet.counts
    return Targets({
        w: (
            float(np.log1p(len(lexicon.named_as_head.get(w, ()))) / 5.0),
            float(np.log1p(counts.get(w, 0)) / 8.0),
            _motion(w, lexicon),
        )
        for w in words
    })  # fmt: skip


def pair_features(
    word: str,
    evidence_of: Mapping[str, FloatArray],
    lexicon: Lexicon,
    similarity: Similarity,
    known: Targets,
) -> tuple[list[str], FloatArray]:
    """The targets that have evidence, sorted, and array (targets, features)."""
    targets = sorted(evidence_of)
    if not targets:
        return [], np.zeros((0, n_features(similarity)))
    channels = np.stack([evidence_of[t] for t in targets])
    moving, senses = _motion(word, lexicon), len(lexicon.wordnet.senses.get(word, ()))
    frequent = np.log1p(lexicon.wordnet.counts.get(word, 0)) / 8.0
    facts = np.array([known.facts[t] for t in targets])
    of_word = np.array([frequent, moving, np.sqrt(senses) / 5.0])
    cosines, total = similarity.cosines(word, targets), np.log(0.02 + channels.sum(axis=1))
    n_kinds = (channels > 0.02).sum(axis=1) / 5.0
    features = np.column_stack([
        np.sqrt(np.minimum(channels, MOST_EVIDENCE)),
        total,
        np.log(0.02 + channels.max(axis=1)),
        n_kinds,
        cosines,
        facts,
        facts[:, 2] * moving,
        np.broadcast_to(of_word, (len(targets), 3)),
        products(cosines, total, n_kinds, moving),
    ])  # fmt: skip
    return targets, features


def products(
    cosines: FloatArray, total: FloatArray, n_kinds: FloatArray, moving: float
) -> FloatArray:
    """What cosines mean together with the evidence: array (targets, 5), no columns without them.

    Of the mean m and the largest cosine of a target: 3 m^2, the largest, and m times the log of all
    evidence, the number of its kinds, and how much of the word is motion. Cross-validated on the
    tuning list they raised first answers right from .746 to .748 among the words of the CMU
    captions and from .777 to .791 with usual words, as part of FLATTENING 0.5.
    """
    if not cosines.shape[1]:
        return np.zeros((len(cosines), 0))
    mean = cosines.mean(axis=1)
    return np.column_stack(
        [3.0 * mean**2, mean * total, cosines.max(axis=1), mean * n_kinds, mean * moving]
    )


def n_features(similarity: Similarity) -> int:
    """Columns of :func:`pair_features`."""
    n_vectors = 0 if similarity.vectors is None else len(similarity.vectors)
    return len(CHANNELS) + 10 + (n_vectors + 5 if n_vectors else 0)


def training_pairs(
    tuning: Mapping[str, frozenset[str]],
    vocabulary: frozenset[str],
    lexicon: Lexicon,
    similarity: Similarity,
) -> tuple[FloatArray, np.ndarray, list[tuple[str, str]]]:
    """Features, whether right, and the words of every pair of the tuning list."""
    known = target_facts(vocabulary, lexicon)
    rows, right, pairs = [], [], []
    for word in sorted(tuning):
        evidence_of = {t: e for t, e in evidence(word, lexicon).items() if t in vocabulary}
        targets, features = pair_features(word, evidence_of, lexicon, similarity, known)
        rows.append(features)
        right += [t in tuning[word] for t in targets]
        pairs += [(word, t) for t in targets]
    return np.concatenate(rows), np.array(right), pairs


def fit(features: FloatArray, right: np.ndarray) -> Model:
    """Fit the regression."""
    from sklearn.linear_model import LogisticRegression

    fitted = LogisticRegression(C=PENALTY, max_iter=5000, tol=1e-8).fit(features, right)
    return Model(fitted.coef_[0], float(fitted.intercept_[0]))


def _motion(word: str, lexicon: Lexicon) -> float:
    senses = lexicon.wordnet.senses.get(word, ())[:N_SENSES]
    return sum(c for key, c in senses if lexicon.wordnet.synsets[key].field in MOTION)
