"""From captions and queries to sequences of motion words.

A text is split into *actions* (at commas, full stops, "then", "and"), and each action into words.
Compounds are split (CamelCase, run/jog, 90-degree), numbers and stop words are left out, and every
other word is replaced by its lemma and by the user's canonical synonym. A piece of text with only
directions and body parts belongs to the action before it: "walks forward and backward" is one
action. "X while Y" is one action, "X after Y" is Y, then X. In a query the word ``?`` means any
action; it becomes an empty action.

**A user's table of synonyms**: lines ``word = canonical word``. A tab may replace ``=``; blank
lines and text after ``#`` are ignored. A canonical word may itself have an entry: chains are
followed to their end.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from difflib import get_close_matches
from unicodedata import combining, normalize

import numpy as np

from motiondb.errors import SheetError
from motiondb.language.lemmas import VERBS, lemma
from motiondb.language.phrases import phrases
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
self direction task act acts acting where whose whom why how because since although though whereas
unless whether could should may might must shall let lets gonna wanna gotta everyone everybody
anyone anybody folk folks guys individual individuals participant participants lady ladies
gentleman gentlemen dude kid kids children adult adults yourself myself themselves ourselves mine
yours theirs please afterwards afterward subsequently thereafter meanwhile eventually actually
completely totally fully entirely perfectly absolutely consecutively successively
basically simply maybe perhaps somehow somewhat rather quite such yes thanks thank least most
exactly
"""
STOP_WORDS = frozenset(_STOP_WORDS.split())
"""Stop words: they describe no motion. Directions and body parts are never among them."""

_MODIFIERS = """
left right forward backward up down over under around through out off into across behind above
below straight back front side sideways both upper lower inside outside away near far high low arm
hand leg foot knee head hip shoulder elbow chin ankle body chest wrist finger toe waist quick
quickly slow slowly fast large small wide big sudden suddenly stationary circular overhead theone
mostoften leastoften
"""
MODIFIERS = frozenset(_MODIFIERS.split())
"""Lemmas of manner, direction and body parts: alone they belong to the action before."""
_TRAVELS_TEXT = """
walk run jog sprint dash step stride stroll march sneak tiptoe limp stagger stumble shuffle wander
pace trot gallop skip hop jump leap crawl creep move go travel slide dribble sidestep amble saunter
mosey hike stalk advance retreat hurry rush scurry scuttle waddle strut trudge hobble lope
"""
TRAVELS = frozenset(_TRAVELS_TEXT.split())
"""Words for travelling over the ground. Other actions have directions that are not travelled: a
person can lean back, reach forward and look left in place."""

IN_PLACE = "stationary"
"""The word for "in place" and "on the spot": "walk in place" is (walk, stationary)."""
IN_A_CIRCLE = "circular"  # Likewise for "in a circle" and "around in circles"
SINGLE = "theone"  # Likewise for "on one leg"; no word, so that none is lost
OVERHEAD = "overhead"  # Likewise for "above the head", and "in the air" of hands
BOX = "thebox"  # For a box that is a thing: to box is another word
OUT_ASIDE, OUT_AHEAD = "outaside", "outahead"  # For arms out to the sides, and in front
MOST_OFTEN, LEAST_OFTEN = "mostoften", "leastoften"  # For "the most jumps", "the fewest jumps"
FIGURE_EIGHT = "figureeight"  # For "in a figure eight": not a number of times
_SAID = {
    FIGURE_EIGHT: "in a figure eight",
    **{"hiphop": "hip hop", "thumbsup": "thumbs up", "highfive": "high five"},
    "allfours": "on all fours",
    "takeoff": "take off from",
    **{OUT_ASIDE: "out to the side", OUT_AHEAD: "out in front"},
    IN_PLACE: "in place",
    IN_A_CIRCLE: "in a circle",
    SINGLE: "one",
    **{MOST_OFTEN: "most often", LEAST_OFTEN: "least often"},
    BOX: "a box",
    OVERHEAD: "above the head",
}

WILDCARD = "?"
_BREAK = re.compile(r"[,;.!\n]+|\b(?:and\s+then|then|and|followed\s+by|before)\b", re.IGNORECASE)
_AFTER = re.compile(r"\bafter\b", re.IGNORECASE)
_CAMEL = re.compile(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")
_WORD = re.compile(r"[^\W\d_]+(?:'[^\W\d_]+)?")
_WILD = re.compile(r"(?:(?<=[\s,;.])|^)\?(?=[\s,;.?]|$)")
SAME = (
    ("backward roll", "backward somersault", "back somersault"),
    ("forward roll", "somersault"),
    ("stand still", "idle"),
    ("squat", "deep knee bend", "knee bend"),
    ("goosestep", "march"),
    ("martial art", "karate"),
    ("push up", "pushup", "pressup", "press up"),
    ("sit up", "situp"),
    ("pull up", "pullup", "chinup", "chin up"),
    ("jumping jack", "star jump"),
    ("descend", "come down", "come back down"),
    *((f"jump {one}", f"flying {one}") for one in ("kick", "knee", "punch")),
)
"""Phrases that name the same motion: one of which a database knows stands for the others."""
_LEAST_PART = 3  # Letters of the shorter part of a compound: "as" and "in" begin many words
_PARTICLES = frozenset(["under", "over", "out", "off", "down", "for", "with"])
"""First parts that change the meaning of a verb: "understand" is not to stand."""
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
    >>> join_phrases("runs in place"), join_phrases("a dance in place of a walk")
    ('runs stationary', 'a dance in place of a walk')
    >>> join_phrases("walks around in circles"), join_phrases("run in a wide circle")
    ('walks circular', 'run circular')
    """
    text = normalize("NFC", text).translate(_APOSTROPHES)
    return phrases("caption").replaced(text)


def as_said(word: str) -> str:
    """A word as people write it.

    >>> as_said(IN_PLACE), as_said("walk"), as_said("crosslegged")
    ('in place', 'walk', 'cross-legged')
    """
    return _SAID.get(word) or re.sub(r"(?<=\w)(?=(?:legged|footed)$)", "-", word)


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


def written_otherwise(
    text: str,
    known: Collection[str],
    synonyms: Mapping[str, str] | None = None,
    lemmas: Mapping[str, str] | None = None,
    together: Callable[[Sequence[str | None]], bool] = lambda _: True,
) -> tuple[str, dict[str, str]]:
    """A text in which words that are not known are written as known ones; old to new spelling.

    Tried in this order: another phrase for the same motion (``SAME``), the word without its
    accents, a compound written apart ("handstand"), and a compound written as one ("side step").
    Words that are known stay. `together`: Whether captions say some known words of one action.

    >>> written_otherwise("idle, then a handstand", {"stand", "still", "hand"})
    ('stand still, then a hand stand', {'idle': 'stand still', 'handstand': 'hand stand'})
    >>> written_otherwise("cross-over", {"crossover", "over"})
    ('crossover', {'cross-over': 'crossover'})
    """
    text = join_phrases(text)
    tokens = list(_WORD.finditer(text))
    words = [motion_word(token.group(), synonyms or {}, lemmas) for token in tokens]
    changed: dict[str, str] = {}
    pieces, at, k = [], 0, 0
    while k < len(tokens):
        number, phrase = _known_phrase(text, tokens[k:], words[k:], known, together)
        if phrase:
            start, end = tokens[k].start(), tokens[k + number - 1].end()
            changed[text[start:end]] = phrase
            pieces += [text[at:start], phrase]
            at = end
        k += max(number, 1)
    return "".join([*pieces, text[at:]]), changed


def _known_phrase(
    text: str,
    tokens: Sequence[re.Match[str]],
    words: Sequence[str | None],
    known: Collection[str],
    together: Callable[[Sequence[str | None]], bool],
) -> tuple[int, str]:
    """Number of the first words that another phrase of known words replaces, and the phrase."""
    for group in SAME:
        forms = {phrase: [motion_word(one, {}) for one in phrase.split()] for phrase in group}
        asked = [phrase for phrase in group if list(words[: len(forms[phrase])]) == forms[phrase]]
        stands = [p for p in group if known_all(forms[p], known) and together(forms[p])]
        if asked and stands and asked[0] not in stands:
            return len(forms[asked[0]]), stands[0]
    first = words[0]
    if first is not None and first not in known:
        plain = lemma(without_accents(first))
        if plain in known:
            return 1, plain
        longest = max(map(len, known), default=0)
        for cut in range(_LEAST_PART, min(len(first) - _LEAST_PART, longest) + 1):
            if first[:cut] not in known:
                continue
            parts = first[:cut], lemma(first[cut:])
            has_verb = not VERBS.isdisjoint(parts) and parts[0] not in _PARTICLES
            if has_verb and known_all(parts, known):
                return 1, " ".join(parts)
    if first is not None and _follows(text, tokens) and not known_all(words[:2], known):
        whole = lemma(tokens[0].group().lower() + tokens[1].group().lower())
        if whole in known:
            return 2, whole
    return 0, ""


def without_accents(word: str) -> str:
    """A word without accents and other marks on its letters.

    >>> without_accents("jeté"), without_accents("walk")
    ('jete', 'walk')
    """
    return "".join(letter for letter in normalize("NFD", word) if not combining(letter))


def _follows(text: str, tokens: Sequence[re.Match[str]]) -> bool:
    """Whether the second word follows the first one after a space or a hyphen."""
    return len(tokens) > 1 and text[tokens[0].end() : tokens[1].start()] in (" ", "-")


def known_all(words: Iterable[str | None], known: Collection[str]) -> bool:
    """Whether all words are known; ``None``, a word that describes no motion, is not."""
    return all(word is not None and word in known for word in words)


def nearest_words(word: str, known: Iterable[str]) -> tuple[str, ...]:
    """Known words of similar spelling, the most similar first; none for what stands for a phrase.

    >>> nearest_words("wlak", ["walk", "run", "talk"]), nearest_words(BOX, ["box"])
    (('walk',), ())
    """
    if as_said(word) != word:
        return ()
    return tuple(get_close_matches(word, sorted(known), n=3, cutoff=0.6))


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


def say_not_understood(missing: Collection[str]) -> str:
    """The first words of an answer to a question of which a head is not understood; "" if all are.

    >>> say_not_understood(["clapping"])
    "not understood: 'clapping'"
    """
    return f"not understood: {', '.join(map(repr, missing))}" if missing else ""


def nothing_known(text: str, unknown: Mapping[str, tuple[str, ...]]) -> str:
    """Return the error for a question without any known word.

    >>> nothing_known("wlak", {"wlak": ("walk",)})
    "query: expected a word that is in the captions, found 'wlak'. Perhaps walk."
    """
    if not unknown:
        return (
            f"query: expected words that describe a motion, found {text!r}. "
            "Ask for example for 'walk, turn left, sit down'."
        )
    near = [as_said(near) for word, words in unknown.items() for near in words]
    near = [word for word in near if word not in " ".join(map(as_said, unknown)).split()]
    hint = (
        f"Perhaps {' or '.join(dict.fromkeys(near))}."
        if near
        else "`motiondb words` lists the words that are known."
    )
    found = ", ".join(repr(as_said(word)) for word in unknown)
    return f"query: expected a word that is in the captions, found {found}. {hint}"


def say_unknown(word: str, near: Sequence[str] = (), where: str = "in the captions") -> str:
    """The sentence for a word that is not known, with the known words that may be meant.

    >>> say_unknown("wlak", ["walk"])
    "'wlak' is not in the captions; left out; perhaps walk"
    >>> say_unknown(IN_PLACE)
    "'in place' is not in the captions; left out"
    """
    return f"{as_said(word)!r} is not {where}; left out" + say_perhaps(near)


def say_perhaps(near: Sequence[str]) -> str:
    """The known words that may be meant by an unknown one, as the end of a sentence."""
    return f"; perhaps {' or '.join(map(as_said, near))}" if near else ""


def parse_synonyms(text: str, source: str = "synonyms") -> dict[str, str]:
    r"""Read a table of synonyms.

    >>> parse_synonyms("jog = run\nstroll\twalk  # slowly")
    {'jog': 'run', 'stroll': 'walk'}
    """
    table: dict[str, str] = {}
    lines: dict[str, int] = {}
    faults: list[str] = []
    for number, raw in enumerate(text.lstrip("\ufeff").splitlines(), start=1):
        line = raw.split("#", 1)[0].strip()
        if not line:
            continue
        pair = _pair(line)
        if pair is None:
            faults.append(
                f"{source}:{number}: expected 'word = canonical word', found {line!r}. "
                "Write one word on each side of '=' or of a tab."
            )
        elif table.get(pair[0], pair[1]) != pair[1]:
            faults.append(
                f"{source}:{number}: expected one canonical word for {pair[0]!r}, found "
                f"{pair[1]!r} beside {table[pair[0]]!r} of line {lines[pair[0]]}. Leave one out."
            )
        elif pair[0] != pair[1]:
            table[pair[0]], lines[pair[0]] = pair[1], number
    ends = _ends(table)
    faults += [
        f"{source}:{lines[word]}: expected synonyms that end in a word, found a circle through "
        f"{word!r}. Leave one of its lines out."
        for word in table
        if ends[word] is None
    ]
    if faults:
        raise SheetError("\n".join(faults))
    return {word: ends[word] or word for word in table}


def _pair(line: str) -> tuple[str, str] | None:
    sides = [side.strip() for side in re.split(r"=|\t+", line)]
    if len(sides) != 2 or not all(re.fullmatch(r"[^\W\d_]+", side) for side in sides):
        return None
    return lemma(sides[0]), lemma(sides[1])


def _ends(table: dict[str, str]) -> dict[str, str | None]:
    """End of the chain that starts at each word, None if it leads into a cycle."""
    ends: dict[str, str | None] = {}
    for start in table:
        chain: dict[str, None] = {}
        word = start
        while word in table and word not in ends and word not in chain:
            chain[word] = None
            word = table[word]
        end = None if word in chain else ends.get(word, word)
        ends.update(dict.fromkeys(chain, end))
    return ends
