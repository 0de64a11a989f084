"""From captions and queries to sequences of motion words.

A text is split into *actions* (at commas, full stops, "then", "and"), and each action into words.
Compounds are split (CamelCase, run/jog, 90-degree), numbers and stop words are left out, and every
other word is replaced by its lemma (:mod:`.lemmas`) and by the user's canonical synonym. Words of
direction and body parts are kept; a piece of text with no other words belongs to the action before
it: "walks forward and backward" is one action. "X while Y" is one action, "X after Y" is Y, then X.
A topic before a dash belongs to the first action.

In a query the word ``?`` means any action; it becomes an empty action.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches

import numpy as np

from motiondb.language.lemmas import VERBS, lemma
from motiondb.records import IntArray

_STOP_WORDS = """
a an the this that these those some any each another one two three four five six several few i me
my you your he him his she her it its we our they them their himself herself itself person persons
people human humans man men woman women guy girl boy child someone somebody subject actor
performer figure character who which what there here is are was were be been being am has have had
do does did doing done make makes making made get gets getting got perform performs performing
performed show shows showing give gives giving begin begins beginning continue continues keep
keeps try tries and or but then next while when after before during until as if so than not no
just very really of in on at by for from to with without like about onto upon per via again more
once twice time times almost approximately briefly finally first second last also too degree
degrees meter meters metre metres centimeter centimeters centimetre centimetres bit kind sort way
something anything thing things motion motions movement movements sequence can will would other
self direction task
"""
STOP_WORDS = frozenset(_STOP_WORDS.split())
"""Stop words: they describe no motion. Directions and body parts are never among them."""

_MODIFIERS = """
left right forward backward up down over under around through out off into across behind above
below straight back front side sideways both upper lower inside outside away near far high low arm
hand leg foot knee head hip shoulder elbow chin ankle body chest wrist finger toe waist quick
quickly slow slowly fast large small wide big sudden suddenly
"""
MODIFIERS = frozenset(_MODIFIERS.split())
"""Lemmas of manner, direction and body parts: alone they belong to the action before."""

WILDCARD = "?"
_BREAK = re.compile(r"[,;.!\n]+|\b(?:and\s+then|then|and|followed\s+by|before)\b", re.IGNORECASE)
_AFTER = re.compile(r"\bafter\b", re.IGNORECASE)
_CAMEL = re.compile(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")
_WORD = re.compile(r"[^\W\d_]+(?:'[^\W\d_]+)?")
_WILD = re.compile(r"(?:(?<=[\s,;.])|^)\?(?=[\s,;.?]|$)")
_PHRASES = (
    (re.compile(r"\blay[\s-]+ups?\b", re.IGNORECASE), "layup"),
    (
        re.compile(
            r"\b(?:get|gets|getting|got)\s+(?:back\s+)?up\b(?!\s+(?:on|onto|to|speed)\b)",
            re.IGNORECASE,
        ),
        "stand up",
    ),
)
_APOSTROPHES = str.maketrans({"’": "'", "`": "'"})


def split_actions(
    text: str,
    synonyms: Mapping[str, str] | None = None,
    lemmas: Mapping[str, str] | None = None,
) -> list[list[str]]:
    """Cut a text into actions, each a list of words; a wildcard is an empty list.

    >>> split_actions("A person walks, turns left, and then sits down.")
    [['walk'], ['turn', 'left'], ['sit', 'down']]
    >>> split_actions("walk, ?, sit")
    [['walk'], [], ['sit']]
    """
    actions: list[list[str]] = []
    for piece in _pieces(text):
        if piece == WILDCARD:
            actions.append([])
            continue
        words = _piece_words(piece, synonyms or {}, lemmas)
        if words and actions and actions[-1] and MODIFIERS.issuperset(words):
            actions[-1].extend(words)
        elif words:
            actions.append(words)
    return actions


def words_of(
    text: str,
    synonyms: Mapping[str, str] | None = None,
    lemmas: Mapping[str, str] | None = None,
) -> list[str]:
    """The motion words of a text in order; parameters as in :func:`split_actions`.

    >>> words_of("run/jog, 90-degree left turn")
    ['run', 'jog', 'left', 'turn']
    >>> words_of("KickFlipStumble"), words_of("bear (human subject)")
    (['kick', 'flip', 'stumble'], ['bear'])
    """
    return [word for action in split_actions(text, synonyms, lemmas) for word in action]


def motion_word(
    token: str, synonyms: Mapping[str, str], lemmas: Mapping[str, str] | None = None
) -> str | None:
    """Lemma of a word, or None if the word does not describe motion.

    >>> motion_word("Walks", {}), motion_word("the", {}), motion_word("strolls", {"stroll": "walk"})
    ('walk', None, 'walk')
    """
    token = token.lower().split("'")[0]
    if token in STOP_WORDS or len(token) < 2:
        return None
    word = synonyms.get(token) or lemma(token, lemmas)
    word = synonyms.get(word, word)
    return word if word not in STOP_WORDS or word in VERBS else None


def join_phrases(text: str) -> str:
    """A text with plain apostrophes, and with phrases in the words that name their movement.

    >>> join_phrases("don’t do a lay-up"), join_phrases("falls and gets back up")
    ("don't do a layup", 'falls and stand up')
    """
    text = text.translate(_APOSTROPHES)
    for phrase, word in _PHRASES:
        text = phrase.sub(word, text)
    return text


def split_compound(token: str) -> list[str]:
    """The words of a word written in CamelCase.

    >>> split_compound("KickFlip"), split_compound("walk")
    (['Kick', 'Flip'], ['walk'])
    """
    return _CAMEL.sub(" ", token).split()


def forms_of(text: str) -> list[str]:
    """Split a text into words in lower case, stop words included.

    >>> forms_of("A dancer's CartWheels")
    ['a', 'dancer', 'cart', 'wheels']
    """
    tokens = _WORD.findall(_CAMEL.sub(" ", join_phrases(text)))
    return [token.lower().split("'")[0] for token in tokens]


def nearest_words(word: str, known: Iterable[str], limit: int = 3) -> tuple[str, ...]:
    """Known words of similar spelling, the most similar first.

    >>> nearest_words("wlak", ["walk", "run", "talk"])
    ('walk',)
    """
    return tuple(get_close_matches(word, sorted(known), n=limit, cutoff=0.6))


def count_words(captions: Iterable[Sequence[str]]) -> tuple[tuple[str, ...], IntArray]:
    """Vocabulary, sorted, and array (words,) of the number of captions with each word.

    >>> words, counts = count_words([["walk", "turn", "walk"], ["walk"]])
    >>> words, counts.tolist()
    (('turn', 'walk'), [1, 2])
    """
    counter = Counter(word for caption in captions for word in set(caption))
    words = tuple(sorted(counter))
    return words, np.array([counter[word] for word in words], dtype=np.int64)


def _pieces(text: str) -> list[str]:
    """Pieces of text between the separators of actions, wildcards included, in order of time."""
    text = _WILD.sub(",\0,", join_phrases(text))
    pieces = []
    for piece in _BREAK.split(text):
        if piece.strip() == "\0":
            pieces.append(WILDCARD)
        else:
            pieces.extend(reversed(_AFTER.split(piece)))
    return pieces


def _piece_words(
    piece: str, synonyms: Mapping[str, str], lemmas: Mapping[str, str] | None
) -> list[str]:
    tokens = _WORD.findall(_CAMEL.sub(" ", piece))
    words = (motion_word(token, synonyms, lemmas) for token in tokens)
    return [word for word in words if word is not None]


def nothing_known(text: str, unknown: Mapping[str, tuple[str, ...]]) -> str:
    """Return the error for a question without any known word.

    >>> nothing_known("wlak", {"wlak": ("walk",)})
    "query: expected a known word, found 'wlak'. Did you mean walk?"
    """
    if not unknown:
        return (
            f"query: expected words that describe a motion, found {text!r}. "
            "Ask for example for 'walk, turn left, sit down'."
        )
    near = [word for words in unknown.values() for word in words]
    hint = (
        f"Did you mean {' or '.join(dict.fromkeys(near))}?"
        if near
        else ("`motiondb words` lists the words that are known.")
    )
    return f"query: expected a known word, found {', '.join(map(repr, unknown))}. {hint}"
