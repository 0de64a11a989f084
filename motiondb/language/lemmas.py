"""The lemma of a word: walks, walking, walked and walker are all "walk".

In this order: a table of forms that motion captions use and dictionaries treat otherwise
(backwards, downwards) and of irregular pasts ("dove"); regular forms of common motion verbs
(dancer, dance) and of verbs that simplemma's dictionary treats otherwise; the dictionary itself.
It alone would call "crosses" a form of "crosse", and leave "wrestling" as it is.

Loading the dictionary costs .1 to .3 s, a third of a search, so its lemmas for the words of
captions are stored with the learned model (:func:`dictionary_forms`).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import lru_cache

_VERBS = """
balance ballet bend block bounce bow box break breakdance catch circle clap climb crawl crouch
dance dangle dash descend dip dive dodge drag dribble drink drive drop duck fall feint fight fish
flap flip fold gallop grab guard hang hit hold hop hug hurdle jab jerk jog juggle jump kick kneel
land laugh lean leap lift limp lower lunge march mop nod pass pick pivot point pose pull punch push
raise reach rest roll rotate run salute scratch screen screw shake shoot shrug shuffle sit skate
skip slide slip sneak spin sprint squat stagger stamp stand start step stomp stop stretch stroke
stroll strike stumble sweep swim swing throw tilt tiptoe toss touch trip trot turn twirl twist
unscrew vault veer walk wash wave wipe zigzag
"""
VERBS = frozenset(_VERBS.split())
"""Motion verbs whose regular forms are recognised without the dictionary."""

_IRREGULAR_TEXT = """
arise arose arisen, awake awoke awoken, bear bore borne, beat beaten, become became, begin began
begun, bend bent, bind bound, bite bitten, bleed bled, blow blew blown, break broke broken, breed
bred, bring brought, build built, burn burnt, buy bought, catch caught, choose chose chosen, cling
clung, come came, creep crept, deal dealt, dig dug, dive dove, do did done, draw drew drawn, drink
drank, drive drove driven, eat ate eaten, fall fell fallen, feed fed, feel felt, fight
fought, find found, flee fled, fling flung, fly flew flown, forget forgot forgotten, freeze froze
frozen, get got gotten, give gave given, go went gone, grow grew grown, hang hung, have had, hear
heard, hide hid hidden, hold held, keep kept, kneel knelt, know knew known, lead led, lean leant,
leap leapt, learn learnt, lend lent, lie laid lain, light lit, lose lost, make made, mean meant,
meet met, overtake overtook overtaken, pay paid, ride rode ridden, ring rang rung, rise rose
risen, run ran, say said, seek sought, sell sold, send sent, sew sewn, shake shook shaken, shear
shorn, shine shone, shoot shot, show shown, shrink shrank shrunk, sing sang sung, sink sank sunk,
sit sat, slay slew slain, sleep slept, slide slid, sling slung, slink slunk, smite smote smitten,
sneak snuck, sow sown, speak spoke spoken, speed sped, spend spent, spin spun, spit spat, spring
sprang sprung, stand stood, steal stole stolen, stick stuck, sting stung, stink stank stunk,
stride strode stridden, strike struck stricken, string strung, strive strove striven, swear swore
sworn, sweep swept, swell swollen, swim swam swum, swing swung, take took taken, teach taught,
tear tore torn, tell told, think thought, throw threw thrown, tread trod trodden, understand
understood, undo undid undone, wake woke woken, wear wore worn, weave wove woven, weep wept, win
won, wind wound, withdraw withdrew withdrawn, withstand withstood, wring wrung, write wrote
written
"""
_IRREGULAR = {
    form: verb for verb, *forms in map(str.split, _IRREGULAR_TEXT.split(",")) for form in forms
}
"""Irregular pasts. "Saw", "ground" and "drunk" stay: who saws, lies on the ground, walks so."""

_DEGREES = {
    form: word
    for word in ("fast", "slow", "quick", "brisk", "high", "long", "short", "small", "broad")
    for form in (f"{word}er", f"{word}est")
} | {"farther": "far", "farthest": "far", "further": "far", "furthest": "far", "lowest": "low"}
FORMS = (
    _IRREGULAR
    | _DEGREES
    | {
        "arching": "arch",
        "backwards": "backward",
        "backflips": "backflip",
        "downward": "down",
        "downwards": "down",
        "forwards": "forward",
        "jetes": "jete",
        "lateral": "sideways",
        "laterally": "sideways",
        "leftward": "left",
        "leftwards": "left",
        "lying": "lie",
        "playing": "play",
        "rightward": "right",
        "rightwards": "right",
        "shots": "shoot",
        "sideway": "sideways",
        "sidewards": "sideways",
        "sideward": "sideways",
        "upward": "up",
        "upwards": "up",
    }
)

_MORE_TEXT = """
backpack bake bathe bless bobsled bomb borrow breathe brew broadcast budge burst bus carve clip
clone close coat cope couple crave cross curtsy cut doze dress drown equip exercise fasten file
fill fit fix flood follow foxtrot furnish gather gaze glide graze greet groan grumble handle
harvest heal heat hobble hunt hurt jitterbug joyride kayak knit layer leapfrog live load mambo mow
muse nestle nurse nuzzle paddle patrol peddle pedal pierce pile pirouette plug plumb prance put
quickstep race rake remain repair reset retrieve ruin rumble rustle saute saw scale scissor scoop
scrape serve set shade shampoo shave shed shoo shovel shut sidestep smoke snatch sneeze snowmobile
spread squeeze stack staple steer straighten stride suckle tape tattoo trace trade transfer travel
tumble unclip unplug unstrap unwrap unzip waltz warn whiz wire wrestle zip
"""
MORE_VERBS = frozenset(_MORE_TEXT.split()) | frozenset(_IRREGULAR.values())
"""Verbs of which simplemma lacks regular forms, or gives them another lemma ("crosse")."""

_FIXED = """
left right forward backward up down over under around through out off into across behind above
below straight back front side sideways both upper lower inside outside away near far high low
stationary circular overhead theone
"""
FIXED = frozenset(_FIXED.split())
"""Words that stay as they are: a dictionary would give the lemma leave for left, and low for
lower."""


def lemma(word: str, known: Mapping[str, str] | None = None) -> str:
    """Return the lemma of a word, or the word itself if none is known.

    >>> [lemma(word) for word in ("Walks", "running", "dancer", "boxing", "left", "backwards")]
    ['walk', 'run', 'dance', 'box', 'left', 'backward']
    >>> [lemma(word) for word in ("bored", "wounded", "drunk", "drank")]
    ['bored', 'wounded', 'drunk', 'drink']
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
    return next((base for base in _bases(word, _ENDINGS) if base in VERBS), None)


_OF_VERBS = ("ing", "ed", "es", "s")
_ENDINGS = ("ings", "ing", "ers", "er", "es", "ed", "s")
_VOWELS = "aeiou"


def _bases(word: str, endings: Iterable[str]) -> list[str]:
    """Words of which a word is a regular form with one of the endings, in their order.

    >>> _bases("running", ["ing"]), _bases("hoping", ["ing"]), _bases("ties", ["es", "s"])
    (['runn', 'run', 'runne'], ['hope'], ['tie'])
    """
    found = []
    for ending in endings:
        stem = word.removesuffix(ending)
        if stem == word or len(stem) < 2:
            continue
        bases = [stem, stem[:-1], stem + "e"]
        bases += [stem[:-1] + "y"] if stem[-1] == "i" else []
        bases += [stem[:-1] + "ie"] if ending == "ing" and stem[-1] == "y" else []
        found += [base for base in bases if len(base) > 2 and word in _forms(base, ending)]
    return found


def _forms(base: str, ending: str) -> tuple[str, ...]:
    """The regular forms of a verb with an ending, of which some verbs have two.

    >>> _forms("hop", "ing"), _forms("cross", "es"), _forms("travel", "ed"), _forms("carry", "s")
    (('hopping',), ('crosses',), ('traveled', 'travelled'), ())
    """
    is_y = base[-1] == "y" and base[-2] not in _VOWELS
    if ending in ("es", "s"):
        hisses = base.endswith(("s", "x", "z", "ch", "sh", "o"))
        if (ending == "es") != (hisses or is_y):
            return ()
        return (base[:-1] + "ies" if is_y else base + ending,)
    if base.endswith("ie") and ending.startswith("ing"):
        return (base[:-2] + "y" + ending,)
    if base[-1] == "e":
        keeps = ending.startswith("ing") and base.endswith(("ee", "oe", "ye"))
        return ((base if keeps else base[:-1]) + ending,)
    if is_y and not ending.startswith("ing"):
        return (base[:-1] + "i" + ending,)
    doubles = (
        base[-1] not in _VOWELS + "wxy"
        and base[-2] in _VOWELS
        and (len(base) < 3 or base[-3] not in _VOWELS or base[-3:-1] == "ui")
    )
    if not doubles:
        return (base + ending,)
    doubled = base + base[-1] + ending
    return (doubled,) if len(re.findall("[aeiouy]+", base)) == 1 else (base + ending, doubled)


@lru_cache(maxsize=20_000)
def _dictionary_lemma(word: str) -> str:
    """A verb of the table as it is, or of which a word is a regular form; else simplemma's."""
    if word in MORE_VERBS:
        return word
    bases = _bases(word, _OF_VERBS)
    verb = next((base for base in bases if base in MORE_VERBS), None)
    base = verb or _simplemma(word)
    if base in FORMS and base in bases:  # "bored" is no form of "bear"
        return word
    return FORMS.get(base, base)


@lru_cache(maxsize=20_000)
def _simplemma(word: str) -> str:
    from simplemma import lemmatize

    return lemmatize(word, lang="en").lower()


@lru_cache(maxsize=20_000)
def is_also_verb(word: str) -> bool:
    """Whether a word can be a verb: whether the dictionary has a form of it in -ing or -ed.

    >>> [is_also_verb(word) for word in ("eat", "juggle", "pizza", "zombie")]
    [True, True, False, False]
    """
    if word in VERBS or word in MORE_VERBS:
        return True
    stems = (word, word.removesuffix("e"), word + word[-1:])
    return any(_simplemma(stem + end) == word for stem in stems for end in ("ing", "ed"))
