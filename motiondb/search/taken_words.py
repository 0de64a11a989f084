"""The learned model, extended by unknown words that may be replaced by known ones.

A taken word is an unknown word that known words replace. For the length of a question, it is one
more word of the vocabulary: its log-odds, translation probabilities and counts are the means,
weighted by its shares, of those of the words that replace it (``words.nearby.taking``). It is
neither stored nor used for learning.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from motiondb.errors import UnknownWordsError
from motiondb.language.lemmas import lemma
from motiondb.language.nearby.table import NearbyTable
from motiondb.language.vocabulary import forms_of, split_actions
from motiondb.learn.learned import Learned
from motiondb.meaning.caption_map import CaptionMap
from motiondb.records import Association, FloatArray
from motiondb.search.taking import Taking, mixture, take_word, with_virtual_words
from motiondb.search.written_words import LearnedWithMore, WrittenWord, with_written


@dataclass(frozen=True, eq=False)
class LearnedWithTaken(LearnedWithMore):
    """A :class:`Learned` whose last words are taken ones."""

    # (words, taken words): weights of the known words in every taken word; columns sum to 1
    shares: FloatArray = field(kw_only=True)

    @cached_property
    def checked(self) -> NDArray[np.bool_]:
        """As for :class:`Learned`; a taken word is checked if all words are that it is taken as."""
        taken = ~(self.shares[~self.base.checked] > 0.0).any(axis=0)
        return np.concatenate([self.base.checked, taken])

    @cached_property
    def motion_log_odds(self) -> dict[int, FloatArray]:
        """Log-odds of all words from the motion alone; see :class:`Learned`."""
        return {c: self._mixed(odds) for c, odds in self.base.motion_log_odds.items()}

    @cached_property
    def written(self) -> dict[int, FloatArray]:
        """Log-odds that captions add; see :class:`Learned`."""
        return {c: self._mixed(odds) for c, odds in self.base.written.items()}

    @cached_property
    def caption_map(self) -> CaptionMap | None:
        """Map to whole captions, of the known words; see :class:`Learned`."""
        return self.base.caption_map

    @cached_property
    def suggested_captions(self) -> FloatArray:
        """Captions that the motion suggests, of the known words; see :class:`Learned`."""
        return self.base.suggested_captions

    def widened(self, values: FloatArray) -> FloatArray:
        """Values of all words; those of taken words are weighted means (:class:`Learned`)."""
        return self._mixed(self.base.widened(values))

    def _mixed(self, values: FloatArray) -> FloatArray:
        return np.concatenate([values, values @ self.shares], axis=-1)


def take_unknown(
    learned: Learned, text: str, table: NearbyTable
) -> tuple[Learned, dict[str, Taking]]:
    """Replace the words of a question that no caption holds by known words."""
    takings = unknown_words(learned, text, table)
    return with_taken(learned, takings), takings


def add_written(
    learned: Learned,
    text: str,
    find: Callable[[], Mapping[str, WrittenWord]],
    table: NearbyTable | None,
) -> Learned:
    """The learned model, with the words of a question that are written but were not learned.

    `find`: Returns the words that are written
    (:func:`motiondb.search.written_words.written_words`). It reads all captions and tags, so it is
    called only if a word of the question is not known.

    `table`: The table of replacements of words. If it is given, written words that replace a word
    of the question are added too.
    """
    known = frozenset(learned.known_words)
    asked = _asked_forms(learned, text)
    if learned.fitted_word_map is None or known.issuperset(asked):
        return learned
    written = find()
    if not written:
        return learned
    wanted = []
    for word, form in asked.items():
        if word in known or word in written:
            wanted.append(word)
        elif table is not None:
            taking = take_word(form, known | written.keys(), table)
            wanted += [w for w, _ in taking.words] if taking.is_taken else []
    return with_written(learned, written, wanted)


def _asked_forms(learned: Learned, text: str) -> dict[str, str]:
    """Words of a question: lemma -> word as written."""
    asked = split_actions(text, learned.synonyms, learned.lemmas)
    written = {lemma(form, learned.lemmas): form for form in reversed(forms_of(text))}
    return {word: written.get(word, word) for action in asked for word in action}


def replace_unknown(
    learned: Learned, text: str, table: NearbyTable
) -> tuple[Learned, dict[str, Taking]]:
    """Replace the words of a question that no caption holds by the most likely known words.

    For requests of one sequence of symbols; parameters and result as in :func:`take_unknown`.
    """
    takings = unknown_words(learned, text, table)
    likeliest = {w: taking.words[0][0] for w, taking in takings.items() if taking.is_taken}
    if not likeliest:
        return learned, takings
    return replace(learned, synonyms={**learned.synonyms, **likeliest}), takings


def nearest_suggested(learned: Learned, text: str, table: NearbyTable) -> dict[str, str]:
    """The likeliest suggestion for every word that no caption holds, where there is one.

    Known words of like spelling are suggested only where the table has none; parameters as
    :func:`take_unknown`.
    """
    suggested = {}
    for word, taking in made_of_unknown(learned, text, table).items():
        known = [*(near for near, _ in taking.words), *taking.spelling]
        if known:
            suggested[word] = known[0]
    return suggested


def leave_unknown(
    learned: Learned, text: str, table: NearbyTable
) -> tuple[Learned, dict[str, Taking]]:
    """Leave out the words of a question that no caption holds.

    Known words of similar spelling are suggested only for words that are not English; parameters
    and result as in :func:`take_unknown`.
    """
    takings = {w: replace(t, words=()) for w, t in made_of_unknown(learned, text, table).items()}
    _check_known(learned, text, takings)
    return learned, takings


def unknown_words(learned: Learned, text: str, table: NearbyTable) -> dict[str, Taking]:
    """Lemma of every word that is in no caption -> its replacement or suggestions."""
    takings = made_of_unknown(learned, text, table)
    _check_known(learned, text, takings)
    return takings


def made_of_unknown(learned: Learned, text: str, table: NearbyTable) -> dict[str, Taking]:
    """As :func:`unknown_words`, but a question without any known or taken word is not refused."""
    if learned.fitted_word_map is None:
        _ = learned.word_map  # raises NotLearnedError if no words were learned
    known = frozenset(learned.known_words)
    return {
        word: take_word(form, known, table)
        for word, form in _asked_forms(learned, text).items()
        if word not in known and word not in learned.word_numbers
    }


def _check_known(learned: Learned, text: str, takings: Mapping[str, Taking]) -> None:
    """Refuse a question without any known or taken word."""
    asked = _asked_forms(learned, text)
    nothing_known = asked.keys().isdisjoint(learned.known_words)
    if takings and nothing_known and not any(t.is_taken for t in takings.values()):
        raise UnknownWordsError(_refusal(takings))


def _refusal(takings: Mapping[str, Taking]) -> str:
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
    return f"query: expected a known word, found {', '.join(map(repr, takings))}. {hint}"


def with_taken(learned: Learned, takings: Mapping[str, Taking]) -> Learned:
    """The learned model, with one more word for every replaced word."""
    number = learned.word_numbers
    taken = {
        word: taking for word, taking in takings.items() if taking.is_taken and word not in number
    }
    if not taken or learned.fitted_word_map is None:
        return learned
    shares = mixture(list(taken.values()), learned.association.words)
    values = {f.name: getattr(learned, f.name) for f in fields(Learned)}
    values["association"] = _with_words(learned.association, tuple(taken), shares)
    values["fitted_word_map"] = with_virtual_words(learned.fitted_word_map, shares)
    return LearnedWithTaken(**values, base=learned, shares=shares)


def _with_words(
    association: Association, words: tuple[str, ...], shares: FloatArray
) -> Association:
    """An association with more words; a taken word counts at least once, so that it is known."""
    counts = np.maximum(np.rint(association.counts @ shares), 1).astype(association.counts.dtype)
    return replace(
        association,
        words=(*association.words, *words),
        counts=np.concatenate([association.counts, counts]),
        translation=np.concatenate(
            [association.translation, association.translation @ shares], axis=1
        ),
    )
