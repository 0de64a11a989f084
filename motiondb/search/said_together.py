"""Which words of an action are searched together, as some caption says them of one action.

=====================  =====================================================================
question               searched
=====================  =====================================================================
walk, backward         both words: some caption says both of one action
sit down on a stool    "sit stool", which a caption says; *down* is measured
wave the left hand     "wave": hands are what waves; the side is measured
climb up a ladder      "climb ladder": who climbs goes up, though one caption of five says it
boxing punches         "box" and "punch" at once, since no caption says both of one action
drink while standing   "drink"; standing is measured where somebody drinks
stand up, walk away    "stand up"; after that, walking is measured
walk, then kneel       "walk"; after that, kneeling is measured
stand on tiptoe        "tiptoe"; standing is measured
walk up the steps      "climb step", where captions say this; *up* is measured
=====================  =====================================================================

So a conjunction is judged by what is known of each of its words, and of the motion. A direction, a
limb or a size that is neither said with its action nor measured is left out, and told.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from motiondb.language.lemmas import VERBS
from motiondb.language.question.readings import Part, Reading
from motiondb.language.question.tree import LIMBS, SIDES
from motiondb.language.vocabulary import MODIFIERS, TRAVELS
from motiondb.learn.checking import LEAST_CHECKING
from motiondb.meaning.limb_sides import LEGS, limb_held
from motiondb.meaning.postures import posture_of
from motiondb.search.asked_words import AskedWords

STANDING = frozenset(("stand", "sit", "still"))
"""Words of postures in which something else is done: who stands still and waves moves an arm."""
LEAVING = frozenset(("away", "off", "along", "onward"))  # Said of travelling, and true of it
GENERAL = frozenset(("go", "move", "travel", "come", "head", "do", "get"))
"""Verbs that say no more than the direction beside them."""
_UP = frozenset(("up", "down"))
_WALKS = frozenset(("walk", "go", "run", "jog", "come", "move", "step", "march"))
_ARMS_TEXT = """
beckon block box brush catch chop clap clean dribble drink eat gesture grab hit hold juggle knock
lift open parry pass pick point pour pull punch push reach salute scratch screw shoot signal slap
stir strike sweep throw touch type unscrew wash wave wipe write
"""
_LEGS_TEXT = "kick walk run jog sprint step hop jump march skip tiptoe"
_GOES: dict[str, frozenset[str]] = {
    "up": frozenset(["climb", "jump", "hop", "leap"]),
    "down": frozenset(["bow", "bend", "crouch", "squat", "kneel", "duck", "dive"]),
}
"""Verbs that say already where they go, so that few captions do."""
_WITH = {"arm": frozenset(_ARMS_TEXT.split()), "leg": frozenset(_LEGS_TEXT.split())}
"""Actions of arms and legs, of which these need not be said."""


@dataclass(frozen=True)
class Searched:
    """Readings in the words that are searched, and what became of the others."""

    readings: tuple[Reading, ...]
    apart: tuple[str, ...] = ()  # Words, or those said together, that no caption says of one action
    left: tuple[str, ...] = ()  # Words that are neither searched nor measured


def searched_together(
    asked: AskedWords,
    readings: Sequence[Reading],
    only: tuple[str, ...],
    leaving: Collection[tuple[str, ...]],
    seen: Collection[tuple[str, ...]],
    measured: Callable[[Sequence[str]], Collection[str]],
) -> Searched:
    """The readings of a question in the words that are searched.

    `only`: as in ``AskedQuestion``. `leaving`: Actions that leave ("walk" of "walk away"), which
    are measured where they follow another one. `seen`: Actions that are measured alone.
    `measured`: The words of an action that are.
    """
    listed = asked.learned.listed_actions
    counts = {action for actions in listed.values() for action in actions}
    is_known = len(listed) >= LEAST_CHECKING  # else captions are too few to tell
    apart, left = list[str](), list[str]()

    def said(words: Collection[str]) -> bool:
        numbers = {asked.learned.word_numbers.get(asked.likeliest(word), -1) for word in words}
        return -1 in numbers or any(numbers <= action for action in counts)

    def actions(part: Part) -> Part:
        found = [action for action in part.actions if action not in seen]
        if not found and part.actions:
            return replace(part, actions=(), said=part.actions)
        found = [a for a in found if len(part.actions) == 1 or not {*a} <= STANDING] or found
        searched = list[tuple[str, ...]]()
        stands = dict[tuple[str, ...], list[tuple[str, ...]]]()
        for action in found:
            if is_known and "climb" in asked.learned.word_numbers:
                action = _as_climbed(action, said)
            learned = tuple(word for word in action if word in asked.numbers) or action
            groups, lost = _groups(learned, said) if is_known else (_unimplied(learned), [])
            stood = [group for group in groups if {*group} <= STANDING]
            acts = any(not VERBS.isdisjoint(group) for group in groups if group not in stood)
            if stood and acts and _UP.isdisjoint(action):  # "stand on tiptoe", not "on a stool"
                stands[action] = groups
                groups = [group for group in groups if group not in stood]
            searched += groups
            apart.extend(" ".join(group) for group in groups if len(groups) > 1)
            spoken = only or action
            known = {*measured(spoken), *_implied(spoken)} - _free_limbs(spoken)
            left.extend(word for word in lost if word not in known)
            if {"sit", "still"} <= {*action} and not part.seconds:
                left.append("still")  # which is measured of who sits for some seconds
        now = tuple(dict.fromkeys(searched))
        asked_for = tuple(one for action in part.actions for one in stands.get(action, [action]))
        return part if now == part.actions else replace(part, actions=now, said=asked_for)

    def parts(reading: Reading) -> tuple[Part, ...]:
        first, *later = map(actions, reading.parts)
        leaves = [len(part.actions) == 1 and part.actions[0] in leaving for part in later]
        measured_later = (
            replace(part, actions=(), said=part.actions) if one else part
            for part, one in zip(later, leaves)
        )
        return (first, *measured_later) if first.actions or first.said else (first, *later)

    changed = tuple(replace(reading, parts=parts(reading)) for reading in readings)
    excluded = [action for one in readings for e in one.exclusions for action in e.actions]
    left += [w for action in excluded if SIDES.isdisjoint(action) for w in _free(action)]
    return Searched(changed, tuple(dict.fromkeys(apart)), tuple(dict.fromkeys(left)))


def _as_climbed(
    action: tuple[str, ...], said: Callable[[Collection[str]], bool]
) -> tuple[str, ...]:
    """Who walks up or down something climbs it, where captions say so and not how one walks.

    >>> _as_climbed(("walk", "up", "step"), lambda words: "climb" in words)
    ('climb', 'up', 'step')
    >>> _as_climbed(("walk", "up", "down"), lambda words: "climb" in words)
    ('walk', 'up', 'down')
    """
    ways = [k for k, pair in enumerate(pairwise(action)) if pair[0] in _WALKS and pair[1] in _UP]
    if not ways:
        return action
    before, behind = action[: ways[0]], action[ways[0] + 1 :]
    if MODIFIERS.issuperset((*before, *behind)) or said(action):
        return action
    climbed = (*before, "climb", *behind)
    return climbed if said([word for word in climbed if word not in _UP]) else action


def _groups(
    action: tuple[str, ...], said: Callable[[Collection[str]], bool]
) -> tuple[list[tuple[str, ...]], list[str]]:
    """The words of an action in groups that captions say, and those that are left out.

    >>> _groups(("sit", "down", "stool"), lambda words: "down" not in words)
    ([('sit', 'stool')], ['down'])
    >>> _groups(("box", "punch"), lambda words: len(words) < 2)
    ([('box',), ('punch',)], [])
    """
    borne = {*limb_held(action), *_ways_said(action)}
    borne |= {"still"} if "sit" in action else set()  # who sits is seldom said to be still
    action = tuple(word for word in action if word not in borne)
    if len(action) < 2 or said(action):
        return [action], []
    heads = [word for word in action if word not in MODIFIERS]
    if len(heads) < len(action):
        heads = [word for word in heads if word not in GENERAL]
    if not heads:
        return [tuple(word for word in action if word not in GENERAL)], []
    if not said(heads):
        return _said_groups([word for word in action if word in MODIFIERS or word in heads], said)
    kept = list(heads)
    for word in action:
        if word in MODIFIERS and said([*kept, word]):
            kept.append(word)
    ordered = tuple(word for word in action if word in kept)
    return [ordered], [w for w in action if w not in kept and w not in GENERAL]


def _said_groups(
    words: Sequence[str], said: Callable[[Collection[str]], bool]
) -> tuple[list[tuple[str, ...]], list[str]]:
    """Words that captions do not say together, in the longest groups that they do; those left out.

    A direction or limb stays with the action beside it, if captions say it of that.

    >>> _said_groups(("hand", "stand", "walk"), lambda words: "walk" not in words or len(words) < 2)
    ([('hand', 'stand'), ('walk',)], [])
    """
    groups, waiting, lost = list[list[str]](), list[str](), list[str]()
    for word in words:
        if groups and said([*groups[-1], word]):
            groups[-1].append(word)
        elif word in MODIFIERS:
            waiting.append(word)
        else:
            before = [one for one in waiting if said([one, word])]
            lost += [one for one in waiting if one not in before]
            groups.append([*before, word])
            waiting = []
    return [tuple(group) for group in groups], [*lost, *waiting]


def _free_limbs(action: Sequence[str]) -> set[str]:
    """The limbs that an action moves and its verb does not say: arms that swing, not the swinger.

    That they move is measured; that this is what the verb says is not.

    >>> _free_limbs(("swing", "both", "arm")), _free_limbs(("wave", "both", "arm"))
    ({'arm'}, set())
    """
    heads = {*action} - MODIFIERS - GENERAL
    return _free(action) if heads else set()


def _free(action: Sequence[str]) -> set[str]:
    """The limbs of an action that neither its verb says nor a posture."""
    if posture_of(action) or limb_held(action):
        return set()
    return set(LIMBS.intersection(action)) - _implied(action)


def _unimplied(action: tuple[str, ...]) -> list[tuple[str, ...]]:
    """An action without what its verb says already, as one group."""
    implied = _implied(action)
    return [tuple(word for word in action if word not in implied) or action]


def _ways_said(action: Sequence[str]) -> set[str]:
    """The way that the verb of an action says already."""
    return {way for way, verbs in _GOES.items() if way in action and not verbs.isdisjoint(action)}


def _implied(action: Sequence[str]) -> set[str]:
    """The words of an action that its verb says already: the hand of who waves.

    >>> sorted(_implied(("wave", "left", "hand"))), _implied(("swing", "arm"))
    (['hand', 'left'], set())
    """
    implied = LEAVING.intersection(action) if not TRAVELS.isdisjoint(action) else set[str]()
    implied |= _ways_said(action)
    for limb in LIMBS.intersection(action):
        if not _WITH["leg" if limb in LEGS else "arm"].isdisjoint(action):
            implied |= {limb, *SIDES.intersection(action)}
    return set(implied)
