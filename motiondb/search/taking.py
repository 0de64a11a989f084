"""Replacement of a word that is in no caption by words of captions.

Notation: p_i the probability, from the table, that the known word i may replace the word. If the
largest p_i is TAKEN or more, the word is *taken*: it is replaced by all known words with p_i of
SUGGESTED or more, with shares p_i / sum p, and with the probability max p. If the largest p_i is
SUGGESTED or more, the known words are only suggested. Otherwise the word is unknown; if it is not
an English word either, known words of similar spelling are suggested.

In the word map the log-odds of a word are linear in the motion (``words.word_map``), so a taken
word is a virtual word, whose slope and constant are the means of those of its known words, weighted
by their shares. Reasons add up for it as for any word.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motiondb.language.lemmas import lemma
from motiondb.language.nearby.table import NearbyTable
from motiondb.language.vocabulary import nearest_words
from motiondb.meaning.word_map import WordMap
from motiondb.records import FloatArray

TAKEN = 0.5
SUGGESTED = 0.3
"""Smallest probability of a replacement, and of a suggestion. Chosen by hand;
docs/nearby-words.md shows how often each range of probabilities is right."""


@dataclass(frozen=True)
class Taking:
    """The replacement or the suggestions for a word that is in no caption.

    Attributes
    ----------
    word : str
        As it was written.
    words : tuple of (str, float)
        Known words, most likely first, each with the probability that it may replace the word; only
        those of SUGGESTED or more.
    spelling : tuple of str
        Known words of similar spelling, if the word is not English and ``words`` is empty.
    """

    word: str
    words: tuple[tuple[str, float], ...]
    spelling: tuple[str, ...] = ()

    @property
    def probability(self) -> float:
        """Probability that the most likely known word is right; 0 if there is none."""
        return self.words[0][1] if self.words else 0.0

    @property
    def is_taken(self) -> bool:
        """Whether the known words replace the word; otherwise they are only suggested."""
        return self.probability >= TAKEN

    @property
    def shares(self) -> tuple[float, ...]:
        """Weights of the known words in the virtual word; their sum is 1."""
        total = sum(p for _, p in self.words)
        return tuple(p / total for _, p in self.words)

    def sentence(self, where: str = "in the captions") -> str:
        """The sentence for the user.

        Probabilities are rounded down, so that none is printed as 1.

        Parameters
        ----------
        where : str
            Place where the word was searched.

        >>> Taking("stroll", (("walk", 0.995),)).sentence()
        "'stroll' is not in the captions; taken as walk (0.9)"
        """
        start = f"{self.word!r} is not {where}"
        said = " or ".join(f"{word} ({say_chance(p)})" for word, p in self.words)
        if self.is_taken:
            return f"{start}; taken as {said}"
        if self.words:
            return f"{start}; perhaps {said}"
        if self.spelling:
            return f"{start}; did you mean {' or '.join(self.spelling)}?"
        return start


def say_chance(probability: float) -> str:
    """A probability with one decimal, rounded down.

    >>> say_chance(0.995), say_chance(0.3), say_chance(0.06)
    ('0.9', '0.3', '0.0')
    """
    return f"{int(probability * 10.0 + 1e-6) / 10.0:.1f}"


def take_word(word: str, known: Collection[str], table: NearbyTable) -> Taking:
    """The known words that may replace a word."""
    if word.lower() in known:  # another word of the same form: "lay" is the past of "lie"
        word = lemma(word)
    forms = list(dict.fromkeys((word.lower(), lemma(word))))
    chances: dict[str, float] = {}
    for form in forms:
        for target, chance in table.entry(form):
            if target in known and target not in forms:
                chances[target] = max(chance, chances.get(target, 0.0))
    ordered = sorted(chances.items(), key=lambda pair: (-pair[1], pair[0]))
    likely = tuple((target, chance) for target, chance in ordered if chance >= SUGGESTED)
    if likely or any(table.is_english(form) for form in forms):
        return Taking(word, likely)
    return Taking(word, (), nearest_words(word, known))


def hints_of(suggested: Mapping[str, Taking]) -> dict[str, tuple[str, ...]]:
    """Unknown words that are not taken -> known words that may be meant, by sense or spelling.

    >>> hints_of({"circle": Taking("circle", ()), "hurl": Taking("hurl", (("shoot", 0.4),))})
    {'circle': (), 'hurl': ('shoot',)}
    """
    return {
        word: tuple(near for near, _ in taking.words) or taking.spelling
        for word, taking in suggested.items()
    }


def mixture(takings: Sequence[Taking], vocabulary: Sequence[str]) -> FloatArray:
    """Shares of the known words in taken words: array (vocabulary, takings), columns sum to 1.

    Arrays (..., vocabulary) that are linear in the words, such as log-odds of motion or of
    captions, get columns for the replaced words by ``x @ mixture``.

    >>> mixture([Taking("stroll", (("walk", 0.75), ("go", 0.25)))], ["go", "run", "walk"]).tolist()
    [[0.25], [0.0], [0.75]]
    """
    number = {word: n for n, word in enumerate(vocabulary)}
    shares = np.zeros((len(vocabulary), len(takings)))
    for column, taking in enumerate(takings):
        for (word, _), share in zip(taking.words, taking.shares):
            shares[number[word], column] = share
    return shares


def with_virtual_words(word_map: WordMap, shares: FloatArray) -> WordMap:
    """A word map with a further column for every taken word.

    The log-odds of a virtual word are exactly the means, weighted by its shares, of those of its
    words: slopes over spreads, and the logits of the priors, are averaged, and its spread is 1.

    Shapes: `shares` (words, taken words).
    """
    logits = np.log(word_map.priors) - np.log1p(-word_map.priors)
    priors = 1.0 / (1.0 + np.exp(-(logits @ shares)))
    return WordMap(
        np.concatenate([word_map.weights, (word_map.weights / word_map.spreads) @ shares], axis=1),
        np.concatenate([word_map.offsets, (word_map.offsets / word_map.spreads) @ shares]),
        np.concatenate([word_map.priors, priors]),
        np.concatenate([word_map.spreads, np.ones(shares.shape[1])]),
        word_map.calibration,
        ridge=word_map.ridge,
    )
