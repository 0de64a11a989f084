"""Words that were not learned but are written: in later captions, and in tags.

Such a word has no model of motion. A capture whose caption or tag holds it gets the evidence of
a written word, and one whose captions or tag have other words gets that of a missing word
(``search.questions.by_words``). For the length of a question, the word is one more word of the
vocabulary, whose slope on motion is 0; its prior is the share of captures whose captions or tags
hold it. It may therefore be used anywhere in a question, and reasons add up. The word is not
stored.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from motiondb.language.vocabulary import words_of
from motiondb.learn.learned import Learned
from motiondb.meaning.by_words import UNWRITTEN, WRITTEN
from motiondb.meaning.calibration import usual
from motiondb.meaning.caption_evidence import caption_evidence
from motiondb.meaning.description_map import DescriptionMap
from motiondb.meaning.resemblance import MeaningSpace
from motiondb.meaning.word_map import WordMap, word_spreads
from motiondb.records import CaptureInfo, FloatArray

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
class LearnedWithMore(Learned):
    """A :class:`Learned` with further words after the learned ones."""

    base: Learned = field(kw_only=True)  # The learned model without them

    @cached_property
    def meaning_space(self) -> MeaningSpace:
        """What captures are compared with an example by, in learned words; see :class:`Learned`."""
        return self.base.meaning_space

    @cached_property
    def description_map(self) -> DescriptionMap | None:
        """Map to the learned words told of a motion; see :class:`Learned`."""
        return self.base.description_map


@dataclass(frozen=True, eq=False)
class LearnedWithWritten(LearnedWithMore):
    """A :class:`Learned` whose last words are written ones that were not learned."""

    added_words: tuple[WrittenWord, ...] = field(kw_only=True)  # Where each of them is written

    @cached_property
    def checked(self) -> NDArray[np.bool_]:
        """As for :class:`Learned`; written words are as sure as the captions of the database."""
        alone = self.started is None
        sure = self.base.checked.all() if alone else self.word_certainty is not None
        added = np.full(len(self.added_words), sure, dtype=bool)
        return np.concatenate([self.base.checked, added])

    @cached_property
    def motion_log_odds(self) -> dict[int, FloatArray]:
        """Log-odds of all words from the motion alone; the usual ones for written words."""
        added = usual(self.word_map)[-len(self.added_words) :]
        return {
            capture: np.concatenate([odds, np.broadcast_to(added, (len(odds), len(added)))], axis=1)
            for capture, odds in self.base.motion_log_odds.items()
        }

    @cached_property
    def written(self) -> dict[int, FloatArray]:
        """Log-odds that captions add, and tags for the words that they hold."""
        said = caption_evidence(self.described, self.segments, self.rows, self.word_numbers)
        evidence = {c: values.copy() for c, values in said.items()}
        first = len(self.base.association.words)
        for column, word in enumerate(self.added_words, start=first):
            keys = {tag.partition("=")[0] for tag in word.tags}
            if not keys:
                continue
            for capture, rows in self.rows.items():
                tagged = not keys.isdisjoint(self.captures[capture].tags)
                if capture not in word.captures and not tagged:
                    continue
                values = evidence.setdefault(
                    capture, np.zeros((rows.stop - rows.start, len(self.word_numbers)))
                )
                in_caption = values[:, column] == WRITTEN
                values[:, column] = WRITTEN if capture in word.captures else UNWRITTEN
                values[in_caption, column] = WRITTEN
        return evidence

    def widened(self, values: FloatArray) -> FloatArray:
        """Values of all words; 0 for written words, of which the motion says nothing."""
        added = np.zeros((*values.shape[:-1], len(self.added_words)))
        return np.concatenate([self.base.widened(values), added], axis=-1)


def written_words(learned: Learned) -> dict[str, WrittenWord]:
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


def with_written(
    learned: Learned, written: Mapping[str, WrittenWord], wanted: Collection[str]
) -> Learned:
    """The learned model, with one more word for every given word that is written somewhere.

    `wanted`: Lemmas; those that are not written anywhere, or already in the vocabulary, are left
    out.
    """
    chosen = tuple(
        written[word]
        for word in dict.fromkeys(wanted)
        if word in written and word not in learned.word_numbers
    )
    if not chosen or learned.fitted_word_map is None:
        return learned
    n = max(len(learned.rows), 1)
    share = np.array([len(word.captures) / n for word in chosen])
    values = {f.name: getattr(learned, f.name) for f in fields(Learned)}
    values["fitted_word_map"] = _with_silent_words(learned.fitted_word_map, share, n)
    association = learned.association
    none = np.zeros((len(association.translation), len(chosen)))
    values["association"] = replace(
        association,
        words=(*association.words, *(word.word for word in chosen)),
        counts=np.concatenate([association.counts, [len(word.captures) for word in chosen]]),
        translation=np.concatenate([association.translation, none], axis=1),
    )
    return LearnedWithWritten(**values, base=learned, added_words=chosen)


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
