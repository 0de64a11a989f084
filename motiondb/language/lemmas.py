"""One word for all forms of a word: walks, walking, walked and walker are all "walk".

There are three steps, and the first that gives a result is used: a short table of forms that motion
captions use and dictionaries treat otherwise (backwards, shot, sitting as a noun); regular endings
of common motion verbs (which also joins a noun of the doer with its verb: dancer, dance); the
dictionary of simplemma. The dictionary takes some 0.2 s to load, so it is loaded when a word first
needs it. Its lemmas for the words of captions are stored with the learned model
(:func:`dictionary_forms`) and handed to :func:`lemma`, so that a question needs the dictionary only
for words that the database has never seen.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache

_VERBS = """
balance ballet bend block bounce bow box break breakdance catch circle clap climb crawl crouch
dance dangle dash descend dip dive dodge drag dribble drink drive drop duck fall feint fight fish
flap flip fold gallop grab guard hang hit hold hop hug hurdle jab jerk jog juggle jump kick kneel
laugh lean leap lift limp lower lunge march mop nod pass pick pivot point pose pull punch push
raise reach rest roll rotate run salute scratch screen screw shake shoot shrug shuffle sit skate
skip slide slip sneak spin sprint squat stagger stamp stand start step stomp stop stretch stroke
stroll strike stumble sweep swim swing throw tilt tiptoe toss touch trip trot turn twirl twist
unscrew vault veer walk wash wave wipe zigzag
"""
VERBS = frozenset(_VERBS.split())
"""Motion verbs whose regular forms are recognised without the dictionary."""

FORMS = {
    "arching": "arch",
    "backwards": "backward",
    "backflips": "backflip",
    "bent": "bend",
    "brought": "bring",
    "downward": "down",
    "downwards": "down",
    "forwards": "forward",
    "jetes": "jete",
    "laid": "lie",
    "lateral": "sideways",
    "laterally": "sideways",
    "leftward": "left",
    "leftwards": "left",
    "lying": "lie",
    "ran": "run",
    "rightward": "right",
    "rightwards": "right",
    "sat": "sit",
    "shot": "shoot",
    "shots": "shoot",
    "sideway": "sideways",
    "sidewards": "sideways",
    "sideward": "sideways",
    "stood": "stand",
    "swung": "swing",
    "upward": "up",
    "upwards": "up",
}

_FIXED = """
left right forward backward up down over under around through out off into across behind above
below straight back front side sideways both upper lower inside outside away near far high low
"""
FIXED = frozenset(_FIXED.split())
"""Words that stay as they are: a dictionary would give the lemma leave for left, and low for
lower."""


def lemma(word: str, known: Mapping[str, str] | None = None) -> str:
    """Return the lemma of a word, or the word itself if none is known.

    >>> [lemma(word) for word in ("Walks", "running", "dancer", "boxing", "left", "backwards")]
    ['walk', 'run', 'dance', 'box', 'left', 'backward']
    """
    word = word.lower()
    ruled = _ruled_lemma(word)
    if ruled is not None:
        return ruled
    if known is not None and word in known:
        return known[word]
    return _dictionary_lemma(word)


def dictionary_forms(words: Iterable[str]) -> dict[str, str]:
    """Lemmas of those words that only the dictionary knows.

    >>> dictionary_forms(["walks", "cartwheels", "left"])
    {'cartwheels': 'cartwheel'}
    """
    forms = sorted({word.lower() for word in words})
    return {form: _dictionary_lemma(form) for form in forms if _ruled_lemma(form) is None}


@lru_cache(maxsize=20_000)
def _ruled_lemma(word: str) -> str | None:
    """The lemma, if tables and regular endings give it."""
    if word in FORMS:
        return FORMS[word]
    if word in FIXED or word in VERBS or not word.isalpha():
        return word
    return next((stem for stem in _stems(word) if stem in VERBS), None)


def _stems(word: str) -> list[str]:
    """Stems before a regular ending, with a doubled letter reduced and a silent e restored.

    >>> _stems("running")
    ['runn', 'run', 'runne']
    """
    stems = []
    for ending in ("ings", "ing", "ers", "er", "es", "ed", "s", "d"):
        if word.endswith(ending) and len(word) > len(ending) + 2:
            stem = word[: -len(ending)]
            stems.append(stem)
            if ending in ("s", "d"):
                continue
            if stem[-1] == stem[-2]:
                stems.append(stem[:-1])
            stems.append(stem + "e")
            break
    if word.endswith("es"):
        stems.append(word[:-1])
    if word.endswith("ies") or word.endswith("ied"):
        stems.append(word[:-3] + "y")
    return stems


@lru_cache(maxsize=20_000)
def _dictionary_lemma(word: str) -> str:
    """The lemma in simplemma's English dictionary, or the word itself."""
    from simplemma import lemmatize

    dictionary_form = lemmatize(word, lang="en").lower()
    return FORMS.get(dictionary_form, dictionary_form)
