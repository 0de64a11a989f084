"""Replacement of words in a motion grammar's phrases that are in no caption by words that are.

If no caption shows a terminal, the captures are searched again with replaced words. Words of its
phrases that are in no caption are replaced by known ones (:mod:`motiondb.search.unknown_words`): by
every known word whose probability is ``TAKEN`` or more, the bound that holds for questions and for
generated motion too. The commands name every word that was taken, since a scene plays its clips
without a probability. A word is not replaced by one in a phrase of another terminal, because a
grammar with both distinguishes them. Excluding phrases ("without") do not change: an unknown word
excludes nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import product

from motiondb.language.nearby.table import NearbyTable
from motiondb.search.unknown_words import TAKEN, Taking, take_word

Phrases = tuple[frozenset[str], ...]
MOST_PHRASES = 50  # Phrases that one phrase may become. Chosen by hand, to bound the time


@dataclass(frozen=True)
class TakenPhrases:
    """What the phrases of terminals without clips are taken as."""

    phrases: Mapping[str, Phrases]  # Name of a terminal -> the phrases that it is asked for with
    takings: Mapping[str, Taking]  # Word that no caption holds -> what it is taken as


def take_phrases(
    asked: Mapping[str, Phrases],
    missing: Iterable[str],
    known: frozenset[str],
    table: NearbyTable,
) -> TakenPhrases:
    """Take the words of phrases that no caption holds."""
    phrases: dict[str, Phrases] = {}
    takings: dict[str, Taking] = {}
    for name in missing:
        others = {w for other, each in asked.items() if other != name for p in each for w in p}
        takeable = known - others
        here = {
            word: taking
            for phrase in asked[name]
            for word in sorted(phrase - known)
            if (taking := _sure(take_word(word, takeable, table))).words
        }
        replaced = dict.fromkeys(p for phrase in asked[name] for p in _taken(phrase, known, here))
        if replaced:
            phrases[name] = tuple(replaced)
            takings |= here
    return TakenPhrases(phrases, takings)


def _sure(taking: Taking) -> Taking:
    return replace(taking, words=tuple(pair for pair in taking.words if pair[1] >= TAKEN))


def _taken(
    phrase: frozenset[str], known: frozenset[str], takings: Mapping[str, Taking]
) -> list[frozenset[str]]:
    """The phrases that a phrase with unknown words becomes; none where a word is not taken."""
    if phrase <= known or not phrase - known <= takings.keys():
        return []
    choices = [
        [word] if word in known else [w for w, _ in takings[word].words] for word in sorted(phrase)
    ]
    return [frozenset(chosen) for chosen, _ in zip(product(*choices), range(MOST_PHRASES))]
