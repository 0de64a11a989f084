"""Pairs of words that are never taken for one another.

WordNet's antonyms hold between words; here they hold between the words of their synsets, of
adjectives like them, and of the verbs one step below, where these are usual senses of the words.
Pairs that WordNet lacks are in ``never.tsv``: body parts of another place, and a few movements.
"""

from __future__ import annotations

from collections.abc import Iterable

from nearby_words.pairs import base, opposites
from nearby_words.wordnet import WordNet, is_plain

LEAST = 0.15
"""A word represents a synset if at least this share of its uses has this meaning."""


def vetoes(wordnet: WordNet, more: Iterable[tuple[str, str]]) -> frozenset[tuple[str, str]]:
    """Pairs of lemmas, both ways round."""
    pairs: set[tuple[str, str]] = set()
    for key, other in opposites(wordnet):
        ones, others = _words(_around(key, wordnet), wordnet), _words([other], wordnet)
        pairs |= {(one, two) for one in ones for two in others}
    for synset in wordnet.synsets.values():
        for symbol, other, here, there in synset.pointers:
            if symbol == "!" and here:
                one, two = synset.words[here - 1], wordnet.synsets[other].words[there - 1]
                pairs |= {(a, b) for a in (one, base(one)) for b in (two, base(two))}
    pairs |= {(base(one), base(two)) for one, two in more}
    pairs |= {(two, one) for one, two in pairs}
    return frozenset((one, two) for one, two in pairs if one != two)


def _around(key: str, wordnet: WordNet) -> list[str]:
    synset = wordnet.synsets[key]
    symbols = {"adj": ("&",), "verb": ("~",), "adv": ()}.get(synset.part, ())
    return [key, *(other for symbol, other, _, _ in synset.pointers if symbol in symbols)]


def _words(keys: Iterable[str], wordnet: WordNet) -> set[str]:
    words = set()
    for key in keys:
        for word in wordnet.synsets[key].words:
            if is_plain(word) and dict(wordnet.senses.get(word, ())).get(key, 0.0) >= LEAST:
                words |= {word, base(word)}
    return words
