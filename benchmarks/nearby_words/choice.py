"""Which words the table of nearby words holds, and which of them may be answered.

Words that may be taken as something are held, the most usual first. Captions are made of usual
words, so what may be answered are the words counted most, those of the fields of motion first.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Sequence

from motiondb.language.lemmas import FIXED, VERBS, lemma
from motiondb.language.vocabulary import STOP_WORDS
from nearby_words.wordnet import WordNet, is_plain

N_WORDS = 24_000
"""Words of the table, the most common first. Chosen by hand for the size of the file."""
N_ANSWERS = 12_000
"""The most common words, which may be given as answers. Chosen by hand; not tuned."""
FIELDS = {
    **dict.fromkeys(
        (29, 33, 34, 35, 38), 4.0
    ),  # verbs of body, sport, consumption, contact, motion
    **dict.fromkeys((4, 5, 8, 0, 2), 2.0),  # acts, animals, the body; adjectives, adverbs
    **dict.fromkeys((6, 44), 1.0),  # artifacts, participles
}
"""What a word gains that is all of a field: 4 is worth some 50 counts. Chosen by hand."""


def plain_words(wordnet: WordNet) -> list[str]:
    """All words of letters that are no names and are not left out of questions, sorted."""
    return sorted(
        word for word in wordnet.senses
        if is_plain(word) and word not in wordnet.names and word not in STOP_WORDS
    )  # fmt: skip


def by_use(wordnet: WordNet) -> list[str]:
    """All plain words, the most usual in captions first."""
    named: Counter[str] = Counter()
    for synset in wordnet.synsets.values():
        named.update({lemma(word) for word in re.findall(r"[a-z]+", synset.gloss.lower())})
    plain = plain_words(wordnet)
    weights = {word: _weight(word, wordnet, named) for word in plain}
    return sorted(plain, key=lambda w: (-weights[w], w))


def answers(ordered: Sequence[str]) -> list[str]:
    """The lemmas that may be answered, sorted: of the most usual words, and all of motion."""
    lemmas = {lemma(w) for w in ordered[:N_ANSWERS]} | VERBS | FIXED
    return sorted(w for w in lemmas if is_plain(w) and w not in STOP_WORDS and lemma(w) == w)


def _weight(word: str, wordnet: WordNet, named: Counter[str]) -> float:
    """How usual a word is in captions: the log of its count in texts and in glosses, and of its
    senses, with what its fields gain."""
    gain = sum(
        chance * FIELDS.get(wordnet.synsets[key].field, 0.0) for key, chance in wordnet.senses[word]
    )
    usual = math.log1p(wordnet.counts.get(word, 0) + named[word])
    return usual + 0.5 * math.log(len(wordnet.senses[word])) + gain
