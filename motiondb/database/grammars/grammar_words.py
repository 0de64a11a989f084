"""Give terminals a meaning: words and motion symbols of the segments they label.

The name of a terminal is a letter without a meaning. If the database has learned words, the words
of a terminal are those that are more probable in its segments than in all segments of the same
takes, by the difference

    p(word | segments of the terminal) - p(word | all segments).

The probabilities are those of :mod:`motiondb.search.described_segments`: by the captions
that people wrote, and otherwise by the motion. A word whose place only the alignment of a whole
caption gives has no probability. If the database has learned motion symbols, a terminal also gets
the symbols that cover most of the time of its segments. The database therefore keeps a single table
of motion symbols.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motiondb.database.learned_grammar import LearnedGrammar
from motiondb.learn.learned import Learned
from motiondb.records import FloatArray
from motiondb.search.described_segments import segment_words

N_WORDS = 2  # Most words of a terminal
LEAST_PROBABILITY = 0.25  # Least probability of a word in the segments of a terminal
LEAST_GAIN = 0.05  # Least difference from the probability in all segments


@dataclass(frozen=True)
class Meaning:
    """Words and motion symbols of a terminal."""

    # Words with their probability in the segments of the terminal, the largest difference first;
    # None where no own caption has checked the probability (``learning.start.checking``), and where
    # only the alignment of captions of whole takes says that the segments show the word
    words: tuple[tuple[str, float | None], ...] = ()
    # Motion symbols with their share of the time of the segments, the largest share first
    symbols: tuple[tuple[int, float], ...] = ()

    @property
    def text(self) -> str:
        """The words without their probabilities.

        >>> Meaning((("turn", 0.9), ("left", 0.5))).text
        'turn left'
        """
        return " ".join(word for word, _ in self.words)


def terminal_meanings(
    learned: Learned | None, grammar: LearnedGrammar, numbers: Mapping[int, int]
) -> tuple[Meaning, ...]:
    """Return the meaning of each terminal.

    `numbers`: Take -> number of its capture, for the takes whose captures are in the database.
    """
    if learned is None:
        return (Meaning(),) * len(grammar.terminals.names)
    shares = terminal_shares(learned, grammar, numbers)
    known = learned.association.words if shares.words.size else ()
    return tuple(
        Meaning(_words(row, shares.usual, known, learned.checked & ~aligned), _symbols(symbols))
        for row, aligned, symbols in zip(shares.words, shares.aligned, shares.symbols)
    )


@dataclass(frozen=True, eq=False)
class Shares:
    """The symbols and words of the segments of each terminal."""

    # (terminals, words): probability of each word in the segments of each terminal; no columns
    # without a word map
    words: FloatArray
    # (terminals, words): whether more than half of the probability of a word comes from the
    # alignment of captions
    aligned: NDArray[np.bool_]
    usual: FloatArray  # (words,): probability of each word in all segments
    symbols: FloatArray  # (terminals, symbols): share of the time that each motion symbol covers


def terminal_shares(
    learned: Learned, grammar: LearnedGrammar, numbers: Mapping[int, int]
) -> Shares:
    """Return the words and motion symbols that the segments of each terminal show.

    `numbers`: Take -> number of its capture, for the takes whose captures are in the database.
    """
    terminals = grammar.terminals
    n = len(terminals.names)
    takes = {take: capture for take, capture in numbers.items() if capture in learned.rows}
    symbols = np.zeros((n, learned.symbols.n_symbols))
    has_words = learned.fitted_word_map is not None
    words = np.zeros((n, len(learned.association.words) if has_words else 0))
    by_alignment = np.zeros_like(words)
    frames = np.zeros(n)
    for take, capture in takes.items():
        segments = np.flatnonzero(terminals.takes == take)
        rows = learned.rows[capture]
        starts, ends = learned.segments.starts[rows], learned.segments.ends[rows]
        shared = np.minimum(terminals.ends[segments][:, None], ends) - np.maximum(
            terminals.starts[segments][:, None], starts
        )
        shared = np.maximum(shared, 0).astype(float)
        labels = terminals.labels[segments]
        np.add.at(frames, labels, shared.sum(axis=1))
        worn = np.zeros((len(starts), symbols.shape[1]))
        worn[np.arange(len(starts)), learned.segments.symbols[rows]] = 1.0
        np.add.at(symbols, labels, shared @ worn)
        if has_words:
            shown = segment_words(learned, capture)
            np.add.at(words, labels, shared @ shown.probabilities)
            np.add.at(by_alignment, labels, shared @ (shown.probabilities * shown.aligned))
    usual = words.sum(axis=0) / max(frames.sum(), 1.0)
    frames = np.maximum(frames, 1.0)[:, None]
    return Shares(words / frames, by_alignment > words / 2.0, usual, symbols / frames)


def terminals_for(learned: Learned, shares: Shares, word: str) -> tuple[int, ...]:
    """Return the numbers of the terminals that show a word; () if none does.

    A terminal shows a word that is more probable in its segments than in all segments of the takes.
    Without a word map, the probability of a word is that of the association, given the motion
    symbols of the terminal.
    """
    number = learned.association.words.index(word)
    if shares.words.size:
        row, usual = shares.words[:, number], float(shares.usual[number])
    else:
        row = shares.symbols @ learned.association.translation[1:, number]
        usual = float(row.mean())
    shown = (row >= LEAST_PROBABILITY) & (row - usual >= LEAST_GAIN)
    return tuple(np.flatnonzero(shown).tolist())


def _words(
    row: FloatArray, usual: FloatArray, known: tuple[str, ...], checked: NDArray[np.bool_]
) -> tuple[tuple[str, float | None], ...]:
    """Select the words of a terminal; `row`, `usual`, `checked` (words,)."""
    gain = row - usual
    order = np.argsort(-gain, kind="stable")[:N_WORDS]
    return tuple(
        (known[w], float(row[w]) if checked[w] else None)
        for w in order
        if row[w] >= LEAST_PROBABILITY and gain[w] >= LEAST_GAIN
    )


def _symbols(shares: FloatArray) -> tuple[tuple[int, float], ...]:
    """Select at most three motion symbols that each cover at least a tenth of the time."""
    order = np.argsort(-shares, kind="stable")[:3]
    return tuple((int(s), float(shares[s])) for s in order if shares[s] >= 0.1)
