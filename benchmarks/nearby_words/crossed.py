"""The tuning list answered by models that were fitted without the word: what the model gets wrong.

Nothing of the key is looked at. The folds are of words, by a sum of their letters.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping

import numpy as np

from nearby_words.methods import Method
from nearby_words.model import Similarity, fit, pair_features, target_facts
from nearby_words.pairs import Lexicon, base, evidence

N_FOLDS = 8
"""Folds of the words of the tuning list. With 2 and 4 the answers are as good as with 8."""


def by_others(
    tuning: Mapping[str, frozenset[str]],
    vocabulary: frozenset[str],
    sources: tuple[Lexicon, Similarity],
    never: frozenset[tuple[str, str]],
    shares: Mapping[str, float],
) -> Method:
    """Answer every word of the tuning list by the model of the other folds.

    ``never`` are pairs of opposites, and ``shares`` what the probability of some targets is
    multiplied by, as for the table.
    """
    lexicon, similarity = sources
    facts = target_facts(vocabulary, lexicon)
    pairs = {
        word: pair_features(
            word,
            {t: e for t, e in evidence(word, lexicon).items() if t in vocabulary},
            lexicon, similarity, facts,
        )
        for word in sorted(tuning)
    }  # fmt: skip
    told: dict[str, list[tuple[str, float]]] = {}
    for fold in range(N_FOLDS):
        others = [w for w in pairs if _fold(w) != fold]
        right = np.array([t in tuning[w] for w in others for t in pairs[w][0]])
        model = fit(np.concatenate([pairs[w][1] for w in others]), right)
        for word in (w for w in pairs if _fold(w) == fold and pairs[w][0]):
            targets, features = pairs[word]
            chances = model.probabilities(features) * [shares.get(t, 1.0) for t in targets]
            told[word] = sorted(
                ((t, float(p)) for t, p in zip(targets, chances)
                 if not {(base(word), t), (word, t)} & never),
                key=lambda pair: (-pair[1], pair[0]),
            )  # fmt: skip

    def answer(word: str, known: frozenset[str]) -> list[tuple[str, float]]:
        return [(t, p) for t, p in told.get(word, []) if t in known and t not in (word, base(word))]

    return answer


def _fold(word: str) -> int:
    return zlib.crc32(f"f{word}".encode()) % N_FOLDS
