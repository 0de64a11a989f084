"""Search for words that are hidden from the captions, by the known words that replace them.

Folds, captures and word map are those of ``quality_tasks/words.py``: five folds by performer,
symbols learned once from all motion without words. A word of the gallery's captions is hidden from
the training captions; it is searched through the table, with all other words known, and the gallery
is ranked by the virtual word. Words that the table does not take are not asked. Ranks are of whole
captures.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motiondb.language import vocabulary
from motiondb.language.nearby.table import NearbyTable
from motiondb.meaning.word_map import WordMap, fit_word_map
from motiondb.records import FloatArray
from motiondb.search.asked_words import mixture, with_virtual_words
from motiondb.search.takings import Taking, take_word
from quality_protocol.captures import Capture, load_cmu, performer_folds, without_copies
from quality_protocol.recognition import recognise

LEAST_TRAINED, LEAST_SHOWN = 3, 2
"""Captures of a word that must be trained and shown, as in quality_tasks/words.py."""


@dataclass(frozen=True, eq=False)
class Shown:
    """vectors (captures, columns), presence (captures, words), names of words, folds, groups."""

    vectors: FloatArray
    presence: NDArray[np.bool_]
    names: tuple[str, ...]
    folds: NDArray[np.int64]
    groups: NDArray[np.int64]


@dataclass(frozen=True)
class Hidden:
    """A word that was hidden in a fold: average precisions by what it was taken as, by the word
    itself had it been known (NaN: too rare in training), by chance and by a shuffled table."""

    word: str
    taking: Taking
    taken: float
    known: float
    chance: float
    shuffled: float
    n_right: int
    n_gallery: int


def load_shown(data: Path, seed: int) -> Shown:
    """The CMU captures with words, as learned symbols see them."""
    captures: list[Capture] = without_copies(load_cmu(data))
    said = [{w for text in c.captions for w in vocabulary.words_of(text)} for c in captures]
    names = tuple(sorted(set().union(*said)))
    presence = np.array([[name in words for name in names] for words in said])
    seen = recognise(captures, np.ones(len(captures), dtype=bool), seed)
    performers = [c.performer for c in captures]
    groups = np.unique(performers, return_inverse=True)[1]
    there = presence.any(axis=1)
    return Shown(
        seen.vectors[there], presence[there], names,
        performer_folds(performers)[there], groups[there],
    )  # fmt: skip


def hide_words(shown: Shown, table: NearbyTable, seed: int) -> list[Hidden]:
    """Hide every word of every fold's gallery in turn."""
    rng = np.random.default_rng(seed)
    hidden = []
    for fold in np.unique(shown.folds):
        test = shown.folds == fold
        fit = fit_word_map(shown.vectors[~test], shown.presence[~test], shown.groups[~test])
        trained = shown.presence[~test].sum(axis=0)
        told = shown.presence[test]
        known = np.flatnonzero(trained >= LEAST_TRAINED).tolist()
        takings = {}
        for number in np.flatnonzero(told.sum(axis=0) >= LEAST_SHOWN):
            others = {shown.names[n] for n in known if n != number}
            taking = take_word(shown.names[number], others, table)
            if taking.is_taken and not told[:, number].all():
                takings[int(number)] = taking
        every = [
            t
            for w in table.words
            if (t := take_word(w, {shown.names[n] for n in known}, table)).is_taken
        ]  # entries of any English word: what a shuffled table answers
        for word, taking in takings.items():
            right = told[:, word]
            scores = _ask(taking, fit, shown, test)
            itself = fit.evidence(shown.vectors[test])[:, word]
            drawn = rng.integers(0, len(every), 20)
            hidden.append(Hidden(
                shown.names[word], taking, precision(scores, right),
                precision(itself, right) if trained[word] >= LEAST_TRAINED else float("nan"),
                float(np.mean([precision(rng.random(len(right)), right) for _ in range(200)])),
                float(np.mean([precision(_ask(every[d], fit, shown, test), right) for d in drawn])),
                int(right.sum()), len(right),
            ))  # fmt: skip
    return hidden


def precision(scores: FloatArray, right: NDArray[np.bool_]) -> float:
    """Average precision of a ranking.

    >>> round(precision(np.array([3.0, 2.0, 1.0]), np.array([True, False, True])), 3)
    0.833
    """
    hits = right[np.argsort(-scores, kind="stable")]
    share = np.cumsum(hits) / np.arange(1, len(hits) + 1)
    return float(share[hits].mean())


def _ask(taking: Taking, fit: WordMap, shown: Shown, test: NDArray[np.bool_]) -> FloatArray:
    virtual = with_virtual_words(fit, mixture([taking], shown.names))
    return np.asarray(virtual.log_odds(shown.vectors[test])[:, -1])
