"""What WordNet says of taking one word for another: one number for every kind of relation.

For a word s with senses a (probability P(a|s)) and a target word t with senses b, a *channel* is a
kind of way from a to b, and its evidence is the sum over ways of

    P(a|s) * share * sqrt(P(b|t)),

where share is 1, or what a gloss or a branching relation gives every one of its words.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from motiondb.language.lemmas import lemma
from motiondb.language.vocabulary import STOP_WORDS
from motiondb.records import FloatArray
from nearby_words.wordnet import Synset, WordNet, gloss_words, is_plain

CHANNELS = (
    "same", "above", "above 2", "above 3", "below", "below 2", "beside", "similar", "similar 2",
    "related", "derived", "part", "head", "gloss", "head of", "gloss of", "phrase",
    "derived same", "derived above", "derived head", "derived gloss", "attribute",
    "gloss head's",
)  # fmt: skip
"""Kinds of ways, in the order of the columns."""
_NUMBER = {name: n for n, name in enumerate(CHANNELS)}
_UP, _DOWN = ("@", "@i"), ("~",)
_RELATED = ("$", "*", ">", "^")
_PARTS = ("%p", "#p")
LEAST_SENSE = 0.03
"""Senses less likely than this are not followed."""


@dataclass(frozen=True)
class Lexicon:
    """WordNet, and by synset its target words, gloss and who names it in glosses."""

    wordnet: WordNet
    targets: dict[str, tuple[tuple[str, float], ...]]
    glosses: dict[str, tuple[tuple[str, ...], tuple[str, ...]]]
    named_as_head: dict[str, tuple[str, ...]]
    named: dict[str, tuple[str, ...]]
    rarity: dict[str, float]


@lru_cache(maxsize=300_000)
def base(word: str) -> str:
    """The lemma under which the vocabulary files a word."""
    return lemma(word)


def make_lexicon(wordnet: WordNet) -> Lexicon:
    """Read every gloss once. Rarity is the idf of a lemma over glosses, 0 to 1."""
    glosses, heads_in, others_in = {}, defaultdict(list), defaultdict(list)
    numbers: Counter[str] = Counter()
    for key, synset in wordnet.synsets.items():
        heads, others = gloss_words(synset.definition, synset.part)
        head = tuple(dict.fromkeys(base(w) for w in heads if is_plain(w)))
        other = tuple(dict.fromkeys(base(w) for w in others if is_plain(w) and w not in STOP_WORDS))
        glosses[key] = head, other
        numbers.update({*head, *other})
        for w in head:
            heads_in[w].append(key)
        for w in other:
            others_in[w].append(key)
    n = len(glosses)
    rarity = {w: math.log(n / c) / math.log(n) for w, c in numbers.items()}
    strongest: dict[tuple[str, str], float] = {}
    for word, senses in wordnet.senses.items():
        if is_plain(word):
            for key, chance in senses:
                place = key, base(word)
                strongest[place] = max(strongest.get(place, 0.0), chance)
    targets: dict[str, list[tuple[str, float]]] = defaultdict(list)
    for (key, word), chance in strongest.items():
        targets[key].append((word, math.sqrt(chance)))
    return Lexicon(
        wordnet,
        {key: tuple(sorted(words)) for key, words in targets.items()},
        glosses,
        {w: tuple(keys) for w, keys in heads_in.items()},
        {w: tuple(keys) for w, keys in others_in.items()},
        rarity,
    )


def evidence(word: str, lexicon: Lexicon) -> dict[str, FloatArray]:
    """From each word that a word might be taken as to its evidence, array (channels,)."""
    channels_of: dict[str, FloatArray] = defaultdict(lambda: np.zeros(len(CHANNELS)))
    wordnet = lexicon.wordnet
    for key, chance in wordnet.senses.get(word, ()):
        if chance < LEAST_SENSE:
            continue

        def say(channel: str, other: str, share: float = 1.0, p: float = chance) -> None:
            for target, typical in lexicon.targets.get(other, ()):
                channels_of[target][_NUMBER[channel]] += p * share * typical

        def name(channel: str, target: str, share: float, p: float = chance) -> None:
            if target in wordnet.senses:
                channels_of[target][_NUMBER[channel]] += p * share

        _follow(key, lexicon, say, name)
    base_form = base(word)
    _reverse(base_form, lexicon, channels_of)
    channels_of.pop(base_form, None)
    channels_of.pop(word, None)
    return dict(channels_of)


Say = Callable[..., None]


def _follow(key: str, lexicon: Lexicon, say: Say, name: Say) -> None:
    synset = lexicon.wordnet.synsets[key]
    say("same", key)
    for word in synset.words:
        parts = [base(w) for w in word.split("_") if is_plain(w) and w not in STOP_WORDS]
        if "_" in word and parts:
            for n, part in enumerate(parts):
                name("phrase", part, (1.0 if n == 0 else 0.5) * lexicon.rarity.get(part, 1.0))
    _vertical(key, lexicon, say)
    similar = _others(synset, ("&",))
    for other in similar:
        say("similar", other)
        for second in _others(lexicon.wordnet.synsets[other], ("&",)):
            if second != key:
                say("similar 2", second)
    for other in _others(synset, _RELATED):
        say("related", other)
    for other in _others(synset, _PARTS):
        say("part", other)
    for other in _others(synset, ("=",)):
        say("attribute", other)
    for other in dict.fromkeys(_others(synset, ("+", "\\"))):
        _derived(other, lexicon, say, name)
    head, others = lexicon.glosses[key]
    _name_gloss("head", "gloss", head, others, lexicon, name)
    for word in head:
        for other, chance in lexicon.wordnet.senses.get(word, ())[:3]:
            say("gloss head's", other, chance)


def _vertical(key: str, lexicon: Lexicon, say: Say) -> None:
    """Up, down and beside."""
    synsets = lexicon.wordnet.synsets
    level = [key]
    for number, channel in enumerate(("above", "above 2", "above 3")):
        level = [o for k in level for o in _others(synsets[k], _UP)]
        for other in dict.fromkeys(level):
            say(channel, other)
            if number == 0:
                below = [o for o in _others(synsets[other], _DOWN) if o != key]
                for sister in below:
                    say("beside", sister, 1.0 / math.sqrt(len(below)))
    level = [key]
    for channel in ("below", "below 2"):
        level = [o for k in level for o in _others(synsets[k], _DOWN)]
        for other in dict.fromkeys(level):
            say(channel, other)


def _derived(key: str, lexicon: Lexicon, say: Say, name: Say) -> None:
    synset = lexicon.wordnet.synsets[key]
    say("derived", key)
    for other in [*_others(synset, _UP), *_others(synset, ("&", "="))]:
        say("derived above", other)
    for other in dict.fromkeys(_others(synset, ("+", "\\"))):
        say("derived same", other)
    head, others = lexicon.glosses[key]
    _name_gloss("derived head", "derived gloss", head, others, lexicon, name)


def _name_gloss(
    heads: str, rest: str, head: Iterable[str], others: Iterable[str], lexicon: Lexicon, name: Say
) -> None:
    for word in head:
        name(heads, word, lexicon.rarity.get(word, 0.0))
    others = list(others)
    for word in others:
        name(rest, word, lexicon.rarity.get(word, 0.0) / math.sqrt(len(others)))


def _reverse(base_form: str, lexicon: Lexicon, channels_of: dict[str, FloatArray]) -> None:
    """Words whose glosses contain the word."""
    for channel, table in (("head of", lexicon.named_as_head), ("gloss of", lexicon.named)):
        keys = table.get(base_form, ())
        for key in keys:
            for target, typical in lexicon.targets.get(key, ()):
                channels_of[target][_NUMBER[channel]] += typical**2 * lexicon.rarity[base_form]


def _others(synset: Synset, symbols: Iterable[str]) -> list[str]:
    return [other for symbol, other, _, _ in synset.pointers if symbol in symbols]


def opposites(wordnet: WordNet) -> Iterator[tuple[str, str]]:
    """Keys of synsets that hold antonyms, both ways."""
    for key, synset in wordnet.synsets.items():
        for other in _others(synset, ("!",)):
            yield key, other
