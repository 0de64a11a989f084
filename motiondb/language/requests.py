"""From a request to what is requested: "show me clips where someone waves" is "someone waves".

Who types a question often frames it: an imperative to the program, a wish, a question whether there
are such captures, the word for a capture. Frames stand at the beginning, or are a capture's name
with a relative word ("clips in which"). *Light verbs* carry no movement of their own before the
noun of one: "goes for a run", "takes a step", "has a drink".
"""

from __future__ import annotations

import re
from functools import partial

from motiondb.language.lemmas import VERBS, lemma
from motiondb.language.phrases import phrases
from motiondb.language.question.tokens import MOST_CHARACTERS
from motiondb.language.vocabulary import LEAST_OFTEN, MOST_OFTEN, motion_word

_LOW = frozenset(("sit", "squat", "crouch", "kneel", "lie"))  # From where one stands up
_OBJECTS = frozenset(
    ("box", "fish", "guard", "mop", "screen", "stamp")
)  # Also things that one takes
_COUNTED = (("SEVERAL", "at least twice"), ("MOST", MOST_OFTEN), ("FEWEST", LEAST_OFTEN))
"""Names of phrases that say how often something is done, and the words for it."""
QUOTES = (('"', '"'), ("\u201c", "\u201d"), ("\u201e", "\u201c"))
"""Pairs of quotation marks, which may stand around a question."""


def unquote(text: str) -> str:
    """A question without quotation marks around it.

    >>> unquote('"walk, sit"'), unquote('walk')
    ('walk, sit', 'walk')
    """
    bare = text.strip()
    for opening, closing in QUOTES:
        if len(bare) > 1 and bare.startswith(opening) and bare.endswith(closing):
            return bare[1:-1]
    return text


def without_request(text: str) -> str:
    """What a request asks for, without quotation marks around it.

    >>> without_request("Show me clips where someone is drinking while standing")
    'someone is drinking while standing'
    >>> without_request("could you please find all captures of a cartwheel?")
    'a cartwheel?'
    >>> without_request("he goes for a slow walk and takes a box")
    'he  slow walk and takes a box'
    >>> without_request("a man looks for a key"), without_request("gives a box to her")
    ('a man looks for a key', 'gives a box to her')
    >>> without_request("breaks into a run"), without_request("walk up to a ladder")
    ('run', 'walk to a ladder')
    >>> without_request("a jog that slows down to a walk"), without_request("turns into a corner")
    ('a jog , then walk', 'turns into a corner')
    >>> without_request("runs with both arms up"), without_request("walks with hands on hips")
    ('runs while raising both arms ', 'walks while holding both hands on hips')
    >>> without_request("long takes of a waltz")
    'a waltz for a long time'
    >>> without_request("goes from lying on the floor to standing")
    'lying on the floor, then standing up'
    >>> without_request("starts standing and ends seated"), without_request("turns clockwise")
    ('standing , then sitting', 'turns to the right')
    >>> without_request("the arms drop"), without_request("jumps higher than 20 cm")
    ('the arms drop', 'jumps high higher than 20 cm')
    >>> without_request("runs, jumps, keeps running"), without_request("stands and keeps waving")
    ('runs, jumps, then running', 'stands and keeps waving')
    >>> without_request("squatting trials"), without_request("three examples of a walk-to-run")
    ('squatting', 'a walk, then run')
    """
    if len(text) > MOST_CHARACTERS:
        return text  # which is refused
    text = unquote(text).lstrip()
    table, named = phrases("request"), phrases("request").named
    framed = named("REQUEST").match(text)
    if framed is not None and framed.end() < len(text):
        text = text[framed.end() :]
    length = named("LENGTH").search(text)
    if length is not None:
        text = f"{named('LENGTH').sub('', text)} for a {'short' if length[1] else 'long'} time"
    begins = named("BEGINS").match(text) is not None
    text = named("NAMED_CAPTURES").sub("", named("OF_CAPTURES").sub("", text))
    text = named("FROM_ONE").sub(_in_order, named("BECOMES").sub(_change, text))
    text = table.replaced(named("FROM_TO").sub(_in_order, text))
    text = named("CONTINUES").sub(_again, text)
    text = named("LIGHT").sub(lambda found: "" if _names_motion(found[1]) else found[0], text)
    for name, often in _COUNTED:
        text = named(name).sub(partial(_as_often, often), text)
    ended = _after_no_action(text).lstrip()
    where = "end" if ended != text.lstrip() else "start" if begins else ""
    if where and named("IS_PLACED").search(ended) is None:
        return f"{ended} at the {where}"
    return ended


def _after_no_action(text: str) -> str:
    """What follows "then" where no action is said before it: "someone, then a jump"."""
    before, found, after = text.partition(", then")
    said = re.findall(r"[^\W\d_]+", before)
    return after if found and all(motion_word(word, {}) is None for word in said) else text


def _as_often(often: str, found: re.Match[str]) -> str:
    """An action with the word for how often it is done; what was found, unless it is one."""
    said = found[found.lastindex or 1]
    is_action = lemma(said) in VERBS - _OBJECTS - {"step"}
    return f"{said} {often}" if is_action else found[0]


def _change(found: re.Match[str]) -> str:
    """What comes before a change, and then the action after it, if its verb names one."""
    if lemma(found[1]) not in VERBS - _OBJECTS:
        return found[0]
    return ", then " if found.string[: found.start()].strip() else ""


def _again(found: re.Match[str]) -> str:
    """An action that goes on after another one; what was found, unless it was said before.

    Who stands and keeps waving does both at once.
    """
    before = re.findall(r"[^\W\d_]+", found.string[: found.start()])
    return f", then {found[1]}" if lemma(found[1]) in map(lemma, before) else found[0]


def _in_order(found: re.Match[str]) -> str:
    """One action, what is said of it, and then another; what was found, unless both are actions."""
    one, about, other = found.groups()
    first, second = lemma(one), lemma(other)
    if first == second or first == "start" or not {first, second} <= (VERBS - _OBJECTS) | _LOW:
        return found[0]
    ends = {"stand": " up" if first in _LOW else "", "sit": " down"}
    return f"{one}{about}, then {other}{ends.get(second, '')}"


def _names_motion(words: str) -> bool:
    """Whether the first of some words, but its adjective, names a movement ("two small steps")."""
    numeral = phrases("request").named("NUMERAL")
    said = [word for word in words.split() if numeral.fullmatch(word) is None]
    return any(lemma(word) in (VERBS | {"stride"}) - _OBJECTS for word in said[:2])
