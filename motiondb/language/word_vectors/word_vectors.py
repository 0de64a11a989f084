"""Vectors of English words: words of similar meaning have similar directions.

The table has 41,000 English words and parts of words. A word that is not among them is split into
the longest known parts, from its beginning on: "moonwalk" is "moon" and "##walk"; its vector is the
mean of theirs. The vector of a sentence is the mean of those of its words, so the order of words is
lost.

Each vector is what a sentence model answers to the word alone, on 128 principal axes, weighted by
the logarithm of the word's rank by frequency and rounded to 8 bits. So sentences are compared
without the model, with NumPy alone. ``README.md`` in this folder says how the table is built.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources

import numpy as np
from numpy.typing import NDArray

from motiondb.records import FloatArray

ENTRIES, VECTORS = "entries.txt", "vectors.npy"


@dataclass(frozen=True, eq=False)
class WordVectors:
    """Words and parts of words, and their vectors."""

    numbers: Mapping[str, int]  # Entry -> its row; a part inside a word begins with ##
    table: NDArray[np.int8]  # (entries, axes)

    def of(self, words: Sequence[str]) -> FloatArray:
        """Vectors of words, of length 1: array (words, axes); 0 for words without known parts."""
        vectors = np.zeros((len(words), self.table.shape[1]))
        for row, word in enumerate(words):
            parts = split_word(plain(word), self.numbers)
            if parts:
                vectors[row] = self.table[parts].mean(axis=0, dtype=np.float64)
        lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
        return np.asarray(vectors / np.maximum(lengths, 1e-12))


def split_word(word: str, numbers: Mapping[str, int]) -> list[int]:
    """Numbers of the longest known parts of a word, from its beginning; [] if a rest has none.

    >>> split_word("moonwalk", {"moon": 0, "##walk": 1, "##w": 2}), split_word("moo", {"moon": 0})
    ([0, 1], [])
    """
    found: list[int] = []
    first = 0
    while first < len(word):
        before = "##" if first else ""
        ends = range(len(word), first, -1)
        last = next((end for end in ends if before + word[first:end] in numbers), None)
        if last is None:
            return []
        found.append(numbers[before + word[first:last]])
        first = last
    return found


NEAREST = 3  # Known words that stand for one that no caption holds


def shares_by_meaning(meanings: FloatArray, word: FloatArray) -> FloatArray:
    """Shares of the known words nearest to a word in meaning: array (known,), of sum 1, or 0.

    The NEAREST ones share in proportion to their cosines, as far as these are above 0.

    Shapes: `meanings` (known, axes), `word` (axes,): vectors of length 1.

    >>> shares_by_meaning(np.eye(2), np.array([0.6, 0.2])).round(2).tolist()
    [0.75, 0.25]
    """
    cosines = np.maximum(meanings @ word, 0.0)
    shares = np.zeros(len(cosines))
    nearest = np.argsort(-cosines, kind="stable")[:NEAREST]
    shares[nearest] = cosines[nearest]
    return shares / max(float(shares.sum()), 1e-12)


def plain(word: str) -> str:
    """A word in lower case without accents.

    >>> plain("Jeté")
    'jete'
    """
    marks = unicodedata.normalize("NFD", word.lower())
    return "".join(letter for letter in marks if unicodedata.category(letter) != "Mn")


@lru_cache(maxsize=1)
def word_vectors() -> WordVectors:
    """The table that is shipped with motiondb; read once."""
    folder = resources.files("motiondb.language.word_vectors")
    entries = folder.joinpath(ENTRIES).read_text(encoding="utf-8").splitlines()
    with resources.as_file(folder.joinpath(VECTORS)) as path:
        return WordVectors({entry: n for n, entry in enumerate(entries)}, np.load(path))
