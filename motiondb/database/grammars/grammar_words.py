"""What terminals mean: the words the database knows for their segments, and the motion symbols.

A terminal is a letter; "a" says nothing. Where the database has learned words, the words of a
terminal are those that are likelier at its segments than elsewhere in the same takes: p(word |
segments of the terminal) - p(word | all segments), over the probabilities that search looks at,
people's written words included. Where it has learned symbols, a terminal maps to the symbols that
its segments wear most of the time, so that there is one table of symbols.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from motiondb import store
from motiondb.learning.learned import Learned
from motiondb.records import FloatArray

N_WORDS = 2
LEAST_PROBABILITY = 0.25
LEAST_GAIN = 0.05


@dataclass(frozen=True)
class Meaning:
    """Words with their probabilities at a terminal's segments, best first; symbols with shares."""

    words: tuple[tuple[str, float], ...] = ()
    symbols: tuple[tuple[int, float], ...] = ()

    @property
    def text(self) -> str:
        """The words alone.

        >>> Meaning((("turn", 0.9), ("left", 0.5))).text
        'turn left'
        """
        return " ".join(word for word, _ in self.words)


def terminal_meanings(
    learned: Learned | None, grammar: store.LearnedGrammar, numbers: Mapping[int, int]
) -> tuple[Meaning, ...]:
    """Return a meaning for each terminal; empty ones where the database has not learned.

    numbers : take -> capture, for takes whose captures are there.
    """
    terminals = grammar.terminals
    n = len(terminals.names)
    if learned is None:
        return (Meaning(),) * n
    takes = {take: capture for take, capture in numbers.items() if capture in learned.rows}
    symbols = np.zeros((n, learned.symbols.n_symbols))
    has_words = learned.fitted_word_map is not None
    words = np.zeros((n, len(learned.association.words) if has_words else 0))
    frames = np.zeros(n)
    for take, capture in takes.items():
        own = np.flatnonzero(terminals.takes == take)
        rows = learned.rows[capture]
        starts, ends = learned.segments.starts[rows], learned.segments.ends[rows]
        shared = np.minimum(terminals.ends[own][:, None], ends) - np.maximum(
            terminals.starts[own][:, None], starts
        )
        shared = np.maximum(shared, 0).astype(float)
        labels = terminals.labels[own]
        np.add.at(frames, labels, shared.sum(axis=1))
        worn = np.zeros((len(starts), symbols.shape[1]))
        worn[np.arange(len(starts)), learned.segments.symbols[rows]] = 1.0
        np.add.at(symbols, labels, shared @ worn)
        if has_words:
            odds = np.clip(learned.takes[capture].windows, -50.0, 50.0)
            np.add.at(words, labels, shared @ (1.0 / (1.0 + np.exp(-odds))))
    usual = words.sum(axis=0) / max(frames.sum(), 1.0)
    frames = np.maximum(frames, 1.0)[:, None]
    known = learned.association.words if has_words else ()
    return tuple(
        Meaning(_words(row, usual, known), _symbols(shares))
        for row, shares in zip(words / frames, symbols / frames)
    )


def _words(
    row: FloatArray, usual: FloatArray, known: tuple[str, ...]
) -> tuple[tuple[str, float], ...]:
    gain = row - usual
    order = np.argsort(-gain, kind="stable")[:N_WORDS]
    return tuple(
        (known[w], float(row[w]))
        for w in order
        if row[w] >= LEAST_PROBABILITY and gain[w] >= LEAST_GAIN
    )


def _symbols(shares: FloatArray) -> tuple[tuple[int, float], ...]:
    order = np.argsort(-shares, kind="stable")[:3]
    return tuple((int(s), float(shares[s])) for s in order if shares[s] >= 0.1)
