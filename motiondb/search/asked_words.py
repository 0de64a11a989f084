"""The words that one question may use: those learned, and for its length others.

A word that was not learned has no model of motion of its own. Two kinds can be added:

* A *written* word stands in captions that came after learning, or in tags. A capture that holds it
  gets the evidence of a written word, one whose captions or tag have other words that of a missing
  word (:mod:`motiondb.meaning.word_evidence`). Its slope on motion is 0, its prior the share of
  captures that hold it.
* A *replaced* word stands for known words, see below. Its log-odds are the means of theirs,
  weighted by its shares.

An added word is a further column of every array over words, behind the learned ones, so that it may
stand anywhere in a question and reasons add up. It is neither stored nor used for learning.

**Words of a question that no caption holds, and the known words that may replace them.**

Notation: p_i the probability, from the table, that the known word i may replace the word. If the
largest p_i is TAKEN or more, the word is replaced by all known words with p_i of SUGGESTED or more,
with shares p_i / sum p, and with the probability max p. If the largest p_i is SUGGESTED or more,
the known words are only suggested. Otherwise the word is unknown; if it is not an English word
either, known words of similar spelling are suggested.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from motiondb.errors import UnknownWordsError
from motiondb.language.nearby.table import NearbyTable
from motiondb.language.question.parse import parse
from motiondb.language.question.readings import KnownQuestion, hold_to_known
from motiondb.language.vocabulary import (
    STOP_WORDS,
    forms_of,
    lemma,
    nearest_words,
    split_actions,
    words_of,
)
from motiondb.learn.learned import Learned
from motiondb.meaning.place_fitting import Written, interval_evidence
from motiondb.meaning.word_evidence import UNWRITTEN, WRITTEN, TakeEvidence, caption_evidence
from motiondb.meaning.word_map import WordMap, usual, word_spreads
from motiondb.records import CaptureInfo, FloatArray, IntArray

PLAIN_TAGS = frozenset({"licence", "capture", "segments", "fps", "skeleton"})
"""Tags whose values do not describe the motion."""
MOST_WORDS_OF_TAG = 4  # Largest number of words in a tag's value that counts as a label


@dataclass(frozen=True)
class WrittenWord:
    """A word that was not learned, and where it is written.

    Attributes
    ----------
    word : str
        Its lemma.
    tags : tuple of str
        Tags that hold it, such as "style=exhausted".
    captures : frozenset of int
        Numbers of the captures whose captions or tags hold it.
    in_captions : int
        Number of captures whose captions hold it.
    """

    word: str
    tags: tuple[str, ...]
    captures: frozenset[int]
    in_captions: int

    def sentence(self) -> str:
        """The sentence for the user.

        >>> WrittenWord("exhaust", ("style=exhausted",), frozenset({1, 2}), 0).sentence()
        "'exhaust' was not learned; found where it is written: style=exhausted (2 captures)"
        >>> WrittenWord("dash", (), frozenset({1}), 1).sentence()
        "'dash' was not learned; found where it is written: captions (1 capture)"
        """
        places = ", ".join([*(["captions"] if self.in_captions else []), *self.tags])
        n = len(self.captures)
        count = "1 capture" if n == 1 else f"{n} captures"
        return f"{self.word!r} was not learned; found where it is written: {places} ({count})"


@dataclass(frozen=True, eq=False)
class AddedColumns:
    """What arrays over words hold for the added words; captures by number."""

    word_map: WordMap  # Of the learned words, then the added ones
    counts: IntArray  # (added,): captures that hold each word, at least 1
    shares: FloatArray  # (learned words, added): weights of the learned words; 0 for written words
    checked: NDArray[np.bool_]  # (added,): whether own captions have checked their probabilities
    evidence: TakeEvidence  # Of the learned words, then the added ones
    likeness: FloatArray  # (captures, added): as ``Learned.likeness``; 0 for written words


@dataclass(frozen=True, eq=False)
class AskedWords:
    """The learned model with the words of one question: the learned ones, then added ones."""

    learned: Learned
    names: tuple[str, ...]  # All words by number
    written_words: tuple[WrittenWord, ...] = ()
    columns: AddedColumns | None = field(default=None, repr=False)  # None where nothing is added

    @cached_property
    def numbers(self) -> dict[str, int]:
        """Word -> its number."""
        return {word: number for number, word in enumerate(self.names)}

    @property
    def added(self) -> dict[str, int]:
        """Word that was not learned -> number of captures that hold it, at least 1."""
        if self.columns is None:
            return {}
        names = self.names[len(self.learned.association.words) :]
        return dict(zip(names, self.columns.counts.tolist()))

    @property
    def word_map(self) -> WordMap:
        """Map from score vectors to all words; NotLearnedError if no words were learned."""
        return self.learned.word_map if self.columns is None else self.columns.word_map

    @property
    def checked(self) -> NDArray[np.bool_]:
        """Which words' probabilities own captions have checked: array (words,)."""
        if self.columns is None:
            return self.learned.checked
        return np.concatenate([self.learned.checked, self.columns.checked])

    def is_known(self) -> NDArray[np.bool_]:
        """Which words some caption or tag holds now, or known words replace: array (words,)."""
        return np.append(self.learned.is_known(), np.ones(len(self.added), dtype=bool))

    @property
    def evidence(self) -> TakeEvidence:
        """Evidence of all words in all captures, from the motion, the captions and the tags."""
        return self.learned.evidence if self.columns is None else self.columns.evidence

    @property
    def likeness(self) -> FloatArray:
        """Likeness of all words to what every capture suggests: array (captures, words), nats."""
        own = self.learned.likeness
        if self.columns is None:
            return own
        return np.concatenate([own, self.columns.likeness], axis=1)

    @cached_property
    def said_places(self) -> Mapping[int, FloatArray]:
        """Evidence, in nats, that captions of intervals add: arrays (segments, words)."""
        if self.columns is None:
            return self.learned.said_places
        learned = self.learned
        said = Written(learned.captions, learned.synonyms, learned.lemmas, self.numbers)
        return interval_evidence(learned.segments, learned.rows, said)

    def widened(self, values: FloatArray) -> FloatArray:
        """Values of all words from those of the learned ones; 0 for written words: (..., words)."""
        if self.columns is None:
            return values
        return np.concatenate([values, values @ self.columns.shares], axis=-1)


def learned_words(learned: Learned) -> AskedWords:
    """The learned words alone."""
    return AskedWords(learned, learned.association.words)


def find_written(learned: Learned) -> dict[str, WrittenWord]:
    """Words that were not learned and are written in captions or tags: lemma -> where."""
    known = frozenset(learned.known_words)
    captions: dict[str, set[int]] = {}
    for capture, rows in learned.captions.items():
        for caption in rows:
            for word in words_of(caption.words, learned.synonyms, learned.lemmas):
                if word not in known and capture in learned.rows:
                    captions.setdefault(word, set()).add(capture)
    tags: dict[str, dict[str, set[int]]] = {}
    for capture in learned.rows:
        for word, tag in _tag_words(learned.captures[capture], learned.synonyms, learned.lemmas):
            if word not in known:
                tags.setdefault(word, {}).setdefault(tag, set()).add(capture)
    words = {}
    for word in sorted({*captions, *tags}):
        said, tagged = captions.get(word, set()), tags.get(word, {})
        everywhere = frozenset(said.union(*tagged.values()))
        words[word] = WrittenWord(word, tuple(sorted(tagged)), everywhere, len(said))
    return words


def _tag_words(
    info: CaptureInfo, synonyms: Mapping[str, str], lemmas: Mapping[str, str]
) -> Iterable[tuple[str, str]]:
    """Words of the tags of a capture, each with its tag."""
    for key, value in info.tags.items():
        if key in PLAIN_TAGS or len(value.split()) > MOST_WORDS_OF_TAG:
            continue
        for word in words_of(value, synonyms, lemmas):
            if word.isalpha():
                yield word, f"{key}={value}"


def written_words_of(
    learned: Learned,
    text: str,
    find: Callable[[], Mapping[str, WrittenWord]],
    table: NearbyTable | None,
) -> AskedWords:
    """The learned words, and the words of a question that are written but were not learned.

    `find` returns the words that are written (:func:`find_written`). It reads all captions and
    tags, so it is called only if a word of the question is not known. With a `table` of
    replacements, written words that replace a word of the question are added too.
    """
    known = frozenset(learned.known_words)
    asked = asked_forms(learned, text)
    if learned.fitted_word_map is None or known.issuperset(asked):
        return learned_words(learned)
    written = find()
    wanted = []
    for word, form in asked.items() if written else ():
        if word in known or word in written:
            wanted.append(word)
        elif table is not None:
            taking = take_word(form, known | written.keys(), table)
            wanted += [w for w, _ in taking.words] if taking.is_taken else []
    return with_written(learned, written, wanted)


def with_written(
    learned: Learned, written: Mapping[str, WrittenWord], wanted: Collection[str]
) -> AskedWords:
    """The learned words, and every wanted lemma that is written somewhere and was not learned."""
    chosen = tuple(
        written[word]
        for word in dict.fromkeys(wanted)
        if word in written and word not in learned.word_numbers
    )
    if not chosen or learned.fitted_word_map is None:
        return learned_words(learned)
    n_learned, n = len(learned.association.words), max(len(learned.rows), 1)
    share = np.array([len(word.captures) / n for word in chosen])
    word_map = _with_silent_words(learned.fitted_word_map, share, n)
    constant = usual(word_map)[n_learned:]
    # written words are as sure as the captions of the database
    alone = learned.started is None
    sure = bool(learned.checked.all()) if alone else learned.word_certainty is not None
    columns = AddedColumns(
        word_map,
        np.array([len(word.captures) for word in chosen], dtype=np.int64),
        np.zeros((n_learned, len(chosen))),
        np.full(len(chosen), sure),
        learned.evidence.with_columns(
            {c: np.tile(constant, (len(odds), 1)) for c, odds in learned.evidence.odds.items()},
            _written_columns(learned, chosen),
        ),
        np.zeros((len(learned.rows), len(chosen))),
    )
    names = (*learned.association.words, *(word.word for word in chosen))
    return AskedWords(learned, names, chosen, columns)


def _written_columns(learned: Learned, words: tuple[WrittenWord, ...]) -> dict[int, FloatArray]:
    """Log-odds that captions and tags add to words that were not learned: (segments, words)."""
    number = {word.word: n for n, word in enumerate(words)}
    columns = caption_evidence(learned.described, learned.segments, learned.rows, number)
    for n, word in enumerate(words):
        keys = {tag.partition("=")[0] for tag in word.tags}
        if not keys:
            continue
        for capture, rows in learned.rows.items():
            tagged = not keys.isdisjoint(learned.captures[capture].tags)
            if capture not in word.captures and not tagged:
                continue
            values = columns.setdefault(capture, np.zeros((rows.stop - rows.start, len(words))))
            in_caption = values[:, n] == WRITTEN
            values[:, n] = WRITTEN if capture in word.captures else UNWRITTEN
            values[in_caption, n] = WRITTEN
    return columns


def _with_silent_words(word_map: WordMap, share: FloatArray, n: int) -> WordMap:
    """A word map with further words that have these priors and are independent of the motion."""
    priors = np.clip(share, 0.5 / n, 1.0 - 0.5 / n)
    silent = np.zeros((len(word_map.weights), len(share)))
    return WordMap(
        np.concatenate([word_map.weights, silent], axis=1),
        np.concatenate([word_map.offsets, np.zeros(len(share))]),
        np.concatenate([word_map.priors, priors]),
        np.concatenate([word_map.spreads, word_spreads(priors)]),
        word_map.calibration,
        ridge=word_map.ridge,
    )


def with_replaced(asked: AskedWords, takings: Mapping[str, Taking]) -> AskedWords:
    """The same words, and every unknown word that known ones replace."""
    taken = {w: taking for w, taking in takings.items() if taking.is_taken}
    taken = {w: taking for w, taking in taken.items() if w not in asked.numbers}
    learned = asked.learned
    if not taken or learned.fitted_word_map is None:
        return asked
    shares = mixture(list(taken.values()), asked.names)
    n_learned = len(learned.association.words)
    # written words say nothing of the motion: their share adds 0
    evidence = asked.evidence.with_columns(
        {capture: odds @ shares for capture, odds in asked.evidence.odds.items()},
        {capture: said @ shares for capture, said in asked.evidence.written.items()},
    )
    likeness = asked.likeness @ shares
    # a replaced word is checked if all words are that replace it
    checked = np.asarray(~(shares[~asked.checked] > 0.0).any(axis=0))
    weights = shares[:n_learned]
    counts = np.append(learned.association.counts, list(asked.added.values()))
    counts = np.maximum(np.rint(counts @ shares), 1).astype(np.int64)
    before = asked.columns
    if before is not None:
        counts = np.concatenate([before.counts, counts])
        weights = np.concatenate([before.shares, weights], axis=1)
        checked = np.concatenate([before.checked, checked])
        likeness = np.concatenate([before.likeness, likeness], axis=1)
    word_map = with_virtual_words(asked.word_map, shares)
    columns = AddedColumns(word_map, counts, weights, checked, evidence, likeness)
    return AskedWords(learned, (*asked.names, *taken), asked.written_words, columns)


def mixture(takings: Collection[Taking], vocabulary: Collection[str]) -> FloatArray:
    """Shares of the known words in replaced words: array (vocabulary, takings), columns sum to 1.

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
    """A word map with a column for every replaced word; `shares` (words, replaced words).

    The log-odds of a replaced word are exactly the means, weighted by its shares, of those of its
    words: slopes over spreads, and the logits of the priors, are averaged, and its spread is 1.
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


TAKEN = 0.5
SUGGESTED = 0.3
"""Smallest probability of a replacement, and of a suggestion: docs/measured/nearby-words.md shows
how often each range of probabilities is right."""


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


def asked_forms(learned: Learned, text: str) -> dict[str, str]:
    """Words of a question: lemma -> word as written."""
    asked = split_actions(text, learned.synonyms, learned.lemmas)
    forms = [form for form in reversed(forms_of(text)) if form not in STOP_WORDS]  # no lemma needed
    written = {lemma(form, learned.lemmas): form for form in forms}
    return {word: written.get(word, word) for action in asked for word in action}


def find_takings(
    learned: Learned, text: str, table: NearbyTable, added: Collection[str] = ()
) -> dict[str, Taking]:
    """Lemma of every word that is in no caption -> its replacement or suggestions.

    `added`: words that are known to the question although they were not learned.
    """
    if learned.fitted_word_map is None:
        _ = learned.word_map  # raises NotLearnedError if no words were learned
    known = frozenset((*learned.known_words, *added))
    return {
        word: take_word(form, known, table)
        for word, form in asked_forms(learned, text).items()
        if word not in known and word not in learned.word_numbers
    }


def unknown_words(
    learned: Learned, text: str, table: NearbyTable, added: Collection[str] = ()
) -> dict[str, Taking]:
    """As :func:`find_takings`; a question without any known or replaced word is refused."""
    takings = find_takings(learned, text, table, added)
    _check_known(learned, text, takings, added)
    return takings


def leave_unknown(
    learned: Learned, text: str, table: NearbyTable, added: Collection[str] = ()
) -> dict[str, Taking]:
    """As :func:`unknown_words`, but nothing is replaced.

    Known words of similar spelling are suggested, only for words that are not English.
    """
    found = find_takings(learned, text, table, added)
    takings = {word: replace(taking, words=()) for word, taking in found.items()}
    _check_known(learned, text, takings, added)
    return takings


def with_likeliest(learned: Learned, takings: Mapping[str, Taking]) -> Learned:
    """The learned model, with the likeliest known words as synonyms of the words they replace.

    For requests of one sequence of symbols, which a mean of several words does not have.
    """
    likeliest = {word: taking.words[0][0] for word, taking in takings.items() if taking.is_taken}
    return replace(learned, synonyms={**learned.synonyms, **likeliest}) if likeliest else learned


def nearest_suggested(learned: Learned, text: str, table: NearbyTable) -> dict[str, str]:
    """The likeliest suggestion for every word that no caption holds, where there is one.

    Known words of like spelling are suggested only where the table has none.
    """
    suggested = {}
    for word, taking in find_takings(learned, text, table).items():
        known = [*(near for near, _ in taking.words), *taking.spelling]
        if known:
            suggested[word] = known[0]
    return suggested


def _check_known(
    learned: Learned, text: str, takings: Mapping[str, Taking], added: Collection[str]
) -> None:
    """Refuse a question without any known or replaced word."""
    known = frozenset((*learned.known_words, *added))
    if not takings or not known.isdisjoint(asked_forms(learned, text)):
        return
    if any(taking.is_taken for taking in takings.values()):
        return
    near = dict.fromkeys(
        word
        for taking in takings.values()
        for word in (*(w for w, _ in taking.words), *taking.spelling)
    )
    hint = (
        f"Did you mean {' or '.join(near)}?"
        if near
        else "`motiondb words` lists the words that are known."
    )
    raise UnknownWordsError(
        f"query: expected a known word, found {', '.join(map(repr, takings))}. {hint}"
    )


def understand(
    learned: Learned, text: str, added: Mapping[str, int] | None = None
) -> KnownQuestion:
    """Understand a question in the words that the database knows.

    `added`: words that are known to this question although they were not learned -> their counts.
    """
    counted = zip(learned.association.words, learned.association.counts)
    counts = {word: int(count) for word, count in counted if count > 0} | dict(added or {})
    return hold_to_known(parse(text, learned.synonyms, learned.lemmas), counts)
