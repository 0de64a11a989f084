"""From what people write to sequences of motion words.

A caption or a query is cut into *actions* (at commas, full stops, "then", "and"), and each action
into words: compounds are taken apart (CamelCase, run/jog, 90-degree), numbers and words that say
nothing of the motion are left out, what remains is brought to its lemma (``words.lemmas``) and
through the user's synonyms. Words of direction and body parts are kept, and a piece that holds
nothing else belongs to the action before it: "walks forward and backward" is one action. "X while
Y" is one action, "X after Y" is Y, then X. A topic before a dash belongs to the first action.

In a query ``?`` as a word stands for any action; its place is kept as an empty action.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np

from motiondb.errors import QueryError
from motiondb.records import IntArray
from motiondb.words.lemmas import VERBS, lemma

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
"""Words that say nothing of a motion; never directions or body parts."""

_MODIFIERS = """
left right forward backward up down over under around through out off into across behind above
below straight back front side sideways both upper lower inside outside away near far high low arm
hand leg foot knee head hip shoulder elbow chin ankle body chest wrist finger toe waist quick
quickly slow slowly fast large small wide big sudden suddenly
"""
MODIFIERS = frozenset(_MODIFIERS.split())
"""Lemmas that tell how or where, not what: on their own they belong to the action before."""

WILDCARD = "?"
_BREAK = re.compile(r"[,;.!\n]+|\b(?:and\s+then|then|and|followed\s+by|before)\b", re.IGNORECASE)
_AFTER = re.compile(r"\bafter\b", re.IGNORECASE)
_CAMEL = re.compile(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")
_WORD = re.compile(r"[^\W\d_]+(?:'[^\W\d_]+)?")
_WILD = re.compile(r"(?:(?<=[\s,;.])|^)\?(?=[\s,;.?]|$)")
_PHRASES = ((re.compile(r"\blay[\s-]+ups?\b", re.IGNORECASE), "layup"),)
_APOSTROPHES = str.maketrans({"’": "'", "`": "'"})


@dataclass(frozen=True)
class ParsedQuery:
    """A question in words, as far as it is understood.

    Attributes
    ----------
    words : known words in order, without wildcards.
    actions : known words of every action in order; () asks for any action. An action of which no
        word is known is left out.
    unknown : from each word that is not known to the nearest known ones, best first.
    """

    words: tuple[str, ...]
    actions: tuple[tuple[str, ...], ...]
    unknown: dict[str, tuple[str, ...]]


def split_actions(
    text: str,
    synonyms: Mapping[str, str] | None = None,
    lemmas: Mapping[str, str] | None = None,
) -> list[list[str]]:
    """Cut a text into actions, each a list of words; a wildcard is an empty list.

    Parameters
    ----------
    text : str
        A caption or a query.
    synonyms : dict, optional
        Lemma -> canonical lemma.
    lemmas : dict, optional
        Lemmas that the dictionary gave earlier (:func:`motiondb.words.lemmas.lemma`).

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


def forms_of(text: str) -> list[str]:
    """The words of a text as they are written, in lower case and with those that say nothing.

    >>> forms_of("A dancer's CartWheels")
    ['a', 'dancer', 'cart', 'wheels']
    """
    text = text.translate(_APOSTROPHES)
    for phrase, word in _PHRASES:
        text = phrase.sub(word, text)
    tokens = _WORD.findall(_CAMEL.sub(" ", text))
    return [token.lower().split("'")[0] for token in tokens]


def parse_query(
    text: str,
    known: Collection[str],
    synonyms: Mapping[str, str] | None = None,
    lemmas: Mapping[str, str] | None = None,
) -> ParsedQuery:
    """Understand a question as far as the vocabulary goes.

    Parameters
    ----------
    text : str
        What the user asks.
    known : collection of str
        The vocabulary.
    synonyms : dict, optional
        Lemma -> canonical lemma.
    lemmas : dict, optional
        Lemmas that the dictionary gave earlier (:func:`motiondb.words.lemmas.lemma`).

    Raises
    ------
    QueryError : where no word of the question is known; names the nearest known ones.

    >>> parse_query("walk, sti", ["sit", "walk"])
    ParsedQuery(words=('walk',), actions=(('walk',),), unknown={'sti': ('sit',)})
    """
    table = known if isinstance(known, (set, frozenset, dict)) else frozenset(known)
    actions, unknown = [], {}
    for action in split_actions(text, synonyms, lemmas):
        found = tuple(word for word in action if word in table)
        unknown.update({w: nearest_words(w, known) for w in action if w not in table})
        if found or not action:
            actions.append(found)
    words = tuple(word for action in actions for word in action)
    if not words:
        raise QueryError(_nothing_known(text, unknown))
    return ParsedQuery(words, tuple(actions), unknown)


def nearest_words(word: str, known: Iterable[str], limit: int = 3) -> tuple[str, ...]:
    """Known words that are spelt like a word, best first; none where nothing is near.

    >>> nearest_words("wlak", ["walk", "run", "talk"])
    ('walk',)
    """
    return tuple(get_close_matches(word, sorted(known), n=limit, cutoff=0.6))


def count_words(captions: Iterable[Sequence[str]]) -> tuple[tuple[str, ...], IntArray]:
    """The vocabulary, sorted, and array (words,) of the number of captions that hold each word.

    >>> words, counts = count_words([["walk", "turn", "walk"], ["walk"]])
    >>> words, counts.tolist()
    (('turn', 'walk'), [1, 2])
    """
    counter = Counter(word for caption in captions for word in set(caption))
    words = tuple(sorted(counter))
    return words, np.array([counter[word] for word in words], dtype=np.int64)


def word_numbers(words: Iterable[str], vocabulary: Sequence[str]) -> IntArray:
    """Numbers of words in a vocabulary, in order; words that it lacks are left out.

    >>> word_numbers(["walk", "moonwalk", "sit"], ("sit", "walk")).tolist()
    [1, 0]
    """
    numbers = {word: number for number, word in enumerate(vocabulary)}
    return np.array([numbers[word] for word in words if word in numbers], dtype=np.int64)


def _pieces(text: str) -> list[str]:
    """Stretches of text between the borders of actions, wildcards among them, in order of time."""
    text = text.translate(_APOSTROPHES)
    for phrase, word in _PHRASES:
        text = phrase.sub(word, text)
    text = _WILD.sub(",\0,", text)
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
    words = []
    for token in _WORD.findall(_CAMEL.sub(" ", piece)):
        token = token.lower().split("'")[0]
        if token in STOP_WORDS or len(token) < 2:
            continue
        word = synonyms.get(token) or lemma(token, lemmas)
        word = synonyms.get(word, word)
        if word not in STOP_WORDS or word in VERBS:
            words.append(word)
    return words


def _nothing_known(text: str, unknown: Mapping[str, tuple[str, ...]]) -> str:
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
    return f"query: expected a known word, found {', '.join(unknown)}. {hint}"
