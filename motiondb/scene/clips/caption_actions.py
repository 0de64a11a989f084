"""Which parts of captures show the actions of a motion grammar, by their captions.

A caption shows an action if all actions that it names are this one: each has all words of one of
the terminal's phrases, and of none of the phrases that the terminal excludes. Words about the path
name no other action: "walk, veer left" and "run, stop" show walking and running. A caption with
times is about its part of the capture, one without about the whole capture.

If a caption names several actions in order, all of them actions of the grammar and exactly one of
them a throw (its event is a release), the time of the throw is determined from the hands (see
:mod:`motiondb.scene.clips.clip_cutting`). Its clip begins there, and the actions named before it
come before. This is not done for captures with other captions that have times.

Words of phrases that no caption holds may be replaced by known ones (:func:`take_phrases`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product

import numpy as np

from motiondb.language.nearby.table import NearbyTable
from motiondb.language.vocabulary import split_actions, words_of
from motiondb.language.word_vectors.word_vectors import word_vectors
from motiondb.records import Caption
from motiondb.scene.language.motion_grammar import MotionGrammar
from motiondb.search.takings import TAKEN, Taking, take_word

Phrases = tuple[frozenset[str], ...]
_MOST_NEAR = 3  # Words that are named for an action without clips
MOST_PHRASES = 50  # Phrases that one phrase may become. Chosen by hand, to bound the time


@dataclass(frozen=True)
class TakenPhrases:
    """What the phrases of terminals without clips are taken as."""

    phrases: Mapping[str, Phrases]  # Name of a terminal -> the phrases that it is asked for with
    takings: Mapping[str, Taking]  # Word that no caption holds -> what it is taken as


def take_phrases(
    asked: Mapping[str, Phrases],
    missing: Iterable[str],
    known: frozenset[str],
    table: NearbyTable,
) -> TakenPhrases:
    """Take the words of phrases that no caption holds.

    If no caption shows a terminal, the captures are searched again with replaced words. Words of
    its phrases that are in no caption are replaced by known ones
    (:mod:`motiondb.search.takings`): by every known word whose probability is ``TAKEN`` or
    more, the bound that holds for questions and for generated motion too. The commands name every
    word that was taken, since a scene plays its clips without a probability. A word is not replaced
    by one in a phrase of another terminal, because a grammar with both distinguishes them.
    Excluding phrases ("without") do not change: an unknown word excludes nothing.
    """
    phrases: dict[str, Phrases] = {}
    takings: dict[str, Taking] = {}
    for name in missing:
        others = {w for other, each in asked.items() if other != name for p in each for w in p}
        takeable = known - others
        here = {
            word: taking
            for phrase in asked[name]
            for word in sorted(phrase - known)
            if (taking := _sure(take_word(word, takeable, table))).words
        }
        replaced = dict.fromkeys(p for phrase in asked[name] for p in _taken(phrase, known, here))
        if replaced:
            phrases[name] = tuple(replaced)
            takings |= here
    return TakenPhrases(phrases, takings)


def _sure(taking: Taking) -> Taking:
    return replace(taking, words=tuple(pair for pair in taking.words if pair[1] >= TAKEN))


def _taken(
    phrase: frozenset[str], known: frozenset[str], takings: Mapping[str, Taking]
) -> list[frozenset[str]]:
    """The phrases that a phrase with unknown words becomes; none where a word is not taken."""
    if phrase <= known or not phrase - known <= takings.keys():
        return []
    choices = [
        [word] if word in known else [w for w, _ in takings[word].words] for word in sorted(phrase)
    ]
    return [frozenset(chosen) for chosen, _ in zip(product(*choices), range(MOST_PHRASES))]


THROW, BEFORE = "throw", "before"
"""Sections of a part of a capture: a throw, and what comes before it."""
_THROWN = "release"

_Words = tuple[frozenset[str], ...]

_WAY = frozenset(("turn", "veer", "curve", "left", "right", "stop", "sudden", "suddenly", "degree"))
"""Words about the path of an action; they name no other action."""


@dataclass(frozen=True)
class ShownAction:
    """A part of a capture that shows an action.

    Attributes
    ----------
    capture : str
        Name of the capture.
    start : float or None, s
        Begin of the part; None for the begin of the capture.
    end : float or None, s
        End of the part; None for the end of the capture.
    stretch : str
        The section that shows the action if the part shows others too: THROW, or BEFORE a throw; ""
        for all of it.
    """

    capture: str
    start: float | None
    end: float | None
    stretch: str = ""


@dataclass(frozen=True)
class FoundActions:
    """What captions show of a motion grammar."""

    # Name of a terminal -> the parts of captures that show it, each once
    parts: Mapping[str, tuple[ShownAction, ...]]
    # Word of a phrase that no caption holds -> what it is taken as
    takings: Mapping[str, Taking]
    # Gives the words of captions that are nearest to each terminal without clips
    nearest: Callable[[], Mapping[str, tuple[str, ...]]] = dict


def find_actions(
    captioned: Iterable[tuple[str, Sequence[Caption]]],
    grammar: MotionGrammar,
    synonyms: Mapping[str, str],
    table: NearbyTable | None,
) -> FoundActions:
    """Return the parts of captures that show each terminal, and what unknown words are taken as.

    `captioned`: Names of captures, with their captions. `table`: Of nearby words; None if words
    that no caption holds match nothing rather than being taken as known ones.
    """
    captions = _said(captioned, synonyms)
    asked = {
        t.name: (_words(t.phrases, synonyms), _words(t.without, synonyms))
        for t in grammar.terminals
    }
    thrown = {t.name for t in grammar.terminals if t.event == _THROWN}
    parts = _shown(captions, asked, thrown)
    if table is None or all(parts.values()):
        return FoundActions(parts, {})
    known = frozenset(word for one in captions for words in one.named for word in words)
    phrases = {name: yes for name, (yes, _) in asked.items()}
    missing = [name for name, of_one in parts.items() if not of_one and phrases[name]]
    taken = take_phrases(phrases, missing, known, table)
    unknown = {name: phrases[name] for name in missing if name not in taken.phrases}
    nearest = partial(_nearest_words, unknown, known, table)
    if not taken.phrases:
        return FoundActions(parts, {}, nearest)
    again = {name: (taken.phrases.get(name, yes), no) for name, (yes, no) in asked.items()}
    more = _shown(captions, again, thrown)
    found = {**parts, **{name: more[name] for name in taken.phrases}}
    return FoundActions(found, taken.takings, nearest)


def _nearest_words(
    unknown: Mapping[str, Phrases], known: frozenset[str], table: NearbyTable
) -> dict[str, tuple[str, ...]]:
    """Return the nearest words of captions of some terminals."""
    return {name: nearest_words(phrases, known, table) for name, phrases in unknown.items()}


def nearest_words(phrases: Phrases, known: frozenset[str], table: NearbyTable) -> tuple[str, ...]:
    """Return the words of captions that are nearest to the phrases of an action, at most three.

    Words are near by the table of nearby words, else by meaning.
    """
    near: dict[str, None] = {}
    names = sorted(known)
    for word in sorted({w for phrase in phrases for w in phrase}):
        taking = take_word(word, known, table)
        listed = [word] if word in known else [w for w, _ in taking.words] or [*taking.spelling]
        if not listed and names and table.is_english(word):
            vectors = word_vectors()
            shares = vectors.of(names) @ vectors.of([word])[0]
            listed = [names[n] for n in np.argsort(-shares, kind="stable")[:2]]
        near |= dict.fromkeys(listed)
    return tuple(near)[:_MOST_NEAR]


@dataclass(frozen=True)
class _Said:
    """A caption: its part of a capture, the actions that it names, and whether it may be cut."""

    part: ShownAction
    named: tuple[frozenset[str], ...]
    may_cut: bool


def _said(
    captioned: Iterable[tuple[str, Sequence[Caption]]], synonyms: Mapping[str, str]
) -> list[_Said]:
    said = []
    for capture, captions in captioned:
        timed = any(caption.start is not None for caption in captions)
        for caption in captions:
            part = ShownAction(capture, caption.start, caption.end)
            may_cut = caption.start is not None or not timed
            said.append(_Said(part, _named_actions(caption.words, synonyms), may_cut))
    return said


def _shown(
    captions: Iterable[_Said], asked: Mapping[str, tuple[_Words, _Words]], thrown: set[str]
) -> dict[str, tuple[ShownAction, ...]]:
    """Return for every terminal the parts that captions say show it."""
    parts_of: dict[str, dict[ShownAction, None]] = {name: {} for name in asked}
    for one in captions:
        for name, (phrases, without) in asked.items():
            if _all_show(one.named, phrases, without):
                parts_of[name][one.part] = None
        if one.may_cut:
            for name, stretch in _about_a_throw(one.named, asked, thrown):
                parts_of[name][replace(one.part, stretch=stretch)] = None
    return {name: tuple(parts) for name, parts in parts_of.items()}


def _about_a_throw(
    named: _Words, asked: Mapping[str, tuple[_Words, _Words]], thrown: set[str]
) -> list[tuple[str, str]]:
    """Return the actions of a caption that names a throw and others, each with its section."""
    shown = [{n for n, (yes, no) in asked.items() if _all_show((w,), yes, no)} for w in named]
    throws = [k for k, names in enumerate(shown) if names & thrown]
    if len(named) < 2 or not all(shown) or len(throws) != 1:
        return []
    at = throws[0]
    with_throw = sorted(shown[at] & thrown)
    if any(no <= words for name in with_throw for no in asked[name][1] for words in named):
        return []  # a feigned throw, which hands cannot tell from one
    before = set.intersection(*shown[:at]) if at else set()
    return [(name, THROW) for name in with_throw] + [(name, BEFORE) for name in sorted(before)]


def _words(
    phrases: Iterable[str], synonyms: Mapping[str, str] | None
) -> tuple[frozenset[str], ...]:
    """Return the words of every phrase that has any."""
    return tuple(words for p in phrases if (words := frozenset(words_of(p, synonyms))))


def _named_actions(caption: str, synonyms: Mapping[str, str] | None) -> tuple[frozenset[str], ...]:
    """Return the words of every action that a caption names."""
    actions = tuple(frozenset(words) for words in split_actions(caption, synonyms))
    return tuple(w for w in actions if not w <= _WAY) if len(actions) > 1 else actions


def _all_show(
    named: tuple[frozenset[str], ...],
    phrases: tuple[frozenset[str], ...],
    without: tuple[frozenset[str], ...],
) -> bool:
    """Return whether all actions that a caption names are one action."""
    return bool(named) and all(
        any(phrase <= words for phrase in phrases) and not any(no <= words for no in without)
        for words in named
    )
