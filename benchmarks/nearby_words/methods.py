"""Ways to take a word as known ones: the shipped table, and what it has to beat.

Every baseline gives a score to a pair of words; one logistic regression on the tuning list turns
the scores of a baseline into probabilities, so that all speak at the same thresholds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from difflib import SequenceMatcher

import numpy as np

from motiondb.language.nearby.table import NearbyTable
from nearby_words.model import Model, Similarity, fit, pair_features, target_facts, training_pairs
from nearby_words.pairs import Lexicon, base, evidence
from nearby_words.wordnet import WordNet

Method = Callable[[str, frozenset[str]], list[tuple[str, float]]]
"""From a word and the known lemmas to known lemmas with probabilities, likeliest first."""
Score = Callable[[str, str], float]
FAR = 8
"""Steps up that path similarity follows."""


def by_table(table: NearbyTable) -> Method:
    """The shipped table."""

    def answer(word: str, known: frozenset[str]) -> list[tuple[str, float]]:
        chances: dict[str, float] = {}
        for form in (word, base(word)):
            for target, chance in table.entry(form):
                if target in known and target not in (word, base(word)):
                    chances[target] = max(chance, chances.get(target, 0.0))
        return _ordered(chances)

    return answer


def by_score(
    score: Score, tuning: Mapping[str, frozenset[str]], vocabulary: frozenset[str]
) -> Method:
    """A baseline, calibrated on the tuning list."""
    from sklearn.linear_model import LogisticRegression

    pairs = [(w, t) for w in sorted(tuning) for t in sorted(vocabulary) if t not in (w, base(w))]
    values = np.array([[score(w, t)] for w, t in pairs])
    right = np.array([t in tuning[w] for w, t in pairs])
    fitted = LogisticRegression(C=100.0).fit(values, right)

    def answer(word: str, known: frozenset[str]) -> list[tuple[str, float]]:
        targets = sorted(known - {word, base(word)})
        chances = fitted.predict_proba(np.array([[score(word, t)] for t in targets]))[:, 1]
        return _ordered(dict(zip(targets, map(float, chances))))

    return answer


def by_model(
    lexicon: Lexicon, tuning: Mapping[str, frozenset[str]], vocabulary: frozenset[str]
) -> Method:
    """The builder's regression without sentence vectors: WordNet alone."""
    none = Similarity({}, None)
    features, right, _ = training_pairs(tuning, vocabulary, lexicon, none)
    model: Model = fit(features, right)
    facts = target_facts(vocabulary, lexicon)

    def answer(word: str, known: frozenset[str]) -> list[tuple[str, float]]:
        evidence_of = {t: e for t, e in evidence(word, lexicon).items() if t in known}
        targets, rows = pair_features(word, evidence_of, lexicon, none, facts)
        return _ordered(dict(zip(targets, map(float, model.probabilities(rows)))))

    return answer


def spelling(one: str, other: str) -> float:
    """How alike two words are spelt, as ``difflib`` has it."""
    return SequenceMatcher(None, one, other).ratio()


def path_similarity(wordnet: WordNet) -> Score:
    """1 / (1 + steps) on the shortest way over a common hypernym, over all senses; 0 without.

    Among ways of one length usual senses come first: a thousandth of the senses' probability.
    """
    above: dict[str, dict[str, tuple[int, float]]] = {}

    def hypernyms(word: str) -> dict[str, tuple[int, float]]:
        if word not in above:
            reached: dict[str, tuple[int, float]] = {}
            for key, chance in wordnet.senses.get(word, ()):
                level = [key]
                for steps in range(FAR):
                    for k in level:
                        reached[k] = min(reached.get(k, (99, 0.0)), (steps, -chance))
                    level = [
                        o for k in level for s, o, _, _ in wordnet.synsets[k].pointers
                        if s in ("@", "@i")
                    ]  # fmt: skip
            above[word] = reached
        return above[word]

    def score(one: str, other: str) -> float:
        ones, others = hypernyms(one) or hypernyms(base(one)), hypernyms(other)
        ways = [
            (ones[k][0] + others[k][0], ones[k][1] + others[k][1]) for k in ones.keys() & others
        ]
        if not ways:
            return 0.0
        steps, chance = min(ways)
        return 1.0 / (1.0 + steps) - 0.001 * chance

    return score


def cosine(similarity: Similarity) -> Score:
    """Mean cosine of sentence vectors over the sentences."""

    def score(one: str, other: str) -> float:
        assert similarity.vectors is not None
        if one not in similarity.rows or other not in similarity.rows:
            return 0.0
        a = similarity.vectors[:, similarity.rows[one]]
        b = similarity.vectors[:, similarity.rows[other]]
        return float((a * b).sum(axis=1).mean())

    return score


def _ordered(chances: Mapping[str, float]) -> list[tuple[str, float]]:
    return sorted(chances.items(), key=lambda pair: (-pair[1], pair[0]))
