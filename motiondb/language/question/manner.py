"""How an action is done: from adverbs to the words that captions may have for them.

An adverb in -ly is represented by its adjective (slowly: slow, happily: happy, gently: gentle). The
caption words for it are searched among the adjective, the adverb and, for speed, the words of the
same meaning.
"""

from __future__ import annotations

from collections.abc import Mapping

from motiondb.language.lemmas import FORMS

SPEEDS = (
    ("slow", "slowly"),
    ("fast", "quick", "quickly", "rapid", "rapidly", "brisk", "briskly", "speedy", "speedily"),
)  # Words of speed that mean the same, adjectives and adverbs
_SPEED_WORDS = frozenset(word for group in SPEEDS for word in group)
_NO_ADVERBS_TEXT = """
ally anomaly apply assembly belly bully butterfly comply curly daily doily dolly early elderly
family filly firefly fly folly friendly gully holly homely imply jelly jolly likely lily lonely
lovely lively monthly multiply only rally rely reply silly sly supply tally ugly weekly wobbly
woolly yearly
"""
_NO_ADVERBS = frozenset(_NO_ADVERBS_TEXT.split())  # Words in -ly that are not adverbs of manner
_LOST_LE = frozenset(("gent", "humb", "simp", "nimb", "subt", "doub", "trip", "amp"))
"""Stems of adverbs whose adjective ends in -le."""


def manner_of(word: str, base: str | None = None) -> str | None:
    """The adjective of a word that says how something is done, or None for any other word.

    >>> [manner_of(w) for w in ("slowly", "happily", "gently", "belly", "laterally")]
    ['slow', 'happy', 'gentle', None, None]
    >>> manner_of("faster", "fast")
    'fast'
    """
    word = word.lower()
    base = word if base is None else base
    if base in _SPEED_WORDS or not word.endswith("ly"):
        return _adjective(base) if base in _SPEED_WORDS else None
    if word in _NO_ADVERBS or word in FORMS or len(word) < 5:
        return None
    return _adjective(word)


def forms_of_manner(manner: str) -> tuple[str, ...]:
    """Words that captions may use for a manner, nearest first.

    >>> forms_of_manner("happy")
    ('happy', 'happily')
    >>> forms_of_manner("quick")[:4]
    ('quick', 'quickly', 'fast', 'rapid')
    """
    same = next((group for group in SPEEDS if manner in group), ())
    return tuple(dict.fromkeys((manner, adverb_of(manner), *same)))


def known_manner(manner: str, counts: Mapping[str, int]) -> str | None:
    """The word for a manner that most captions have; None if no caption has one.

    >>> known_manner("slow", {"slowly": 2, "slow": 5}), known_manner("angry", {"slow": 5})
    ('slow', None)
    """
    known = [word for word in forms_of_manner(manner) if counts.get(word, 0) > 0]
    return max(known, key=lambda word: counts[word]) if known else None


def _adjective(adverb: str) -> str:
    """The adjective of an adverb in -ly; any other word is one already."""
    if not adverb.endswith("ly"):
        return adverb
    stem = adverb[:-2]
    if stem.endswith("ical"):
        return stem[:-2]
    if stem.endswith("i"):
        return stem[:-1] + "y"
    return stem + "le" if stem in _LOST_LE else stem


def adverb_of(adjective: str) -> str:
    """The adverb of an adjective; an adverb in -ly is itself.

    >>> [adverb_of(word) for word in ("slow", "happy", "gentle", "energetic", "fast", "slowly")]
    ['slowly', 'happily', 'gently', 'energetically', 'fast', 'slowly']
    """
    if adjective == "fast" or adjective.endswith("ly"):
        return adjective
    if adjective.endswith("y"):
        return adjective[:-1] + "ily"
    if adjective.endswith("le"):
        return adjective[:-1] + "y"
    return adjective + ("ally" if adjective.endswith("ic") else "ly")
