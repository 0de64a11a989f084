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

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from motiondb import store
from motiondb.database.session import nearby_table
from motiondb.errors import SceneError
from motiondb.language.nearby.table import NearbyTable
from motiondb.language.vocabulary import split_actions, words_of
from motiondb.records import MOTION_FPS, Event, Motion
from motiondb.scene.clips.clip_cutting import (
    SHORTEST,
    BodyFrames,
    ShownMotion,
    body_frames,
    throw_frames,
)
from motiondb.scene.clips.clips import ClipLibrary, VariantSettings, make_library
from motiondb.scene.language.motion_grammar import MotionGrammar
from motiondb.search.asked_words import TAKEN, Taking, take_word

if TYPE_CHECKING:
    from motiondb.database.session import Session


# Replacement of words in a motion grammar's phrases that are in no caption by words that are.


Phrases = tuple[frozenset[str], ...]
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
    (:mod:`motiondb.search.asked_words`): by every known word whose probability is ``TAKEN`` or
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


def find_actions(
    session: Session, grammar: MotionGrammar, exact: bool = False
) -> dict[str, tuple[ShownAction, ...]]:
    """Return for every terminal the parts of captures that show it, each once."""
    return dict(find_with_words(session, grammar, exact).parts)


def find_with_words(session: Session, grammar: MotionGrammar, exact: bool = False) -> FoundActions:
    """Return the parts of captures that show each terminal, and what unknown words are taken as.

    `exact`: Whether words that no caption holds match nothing rather than being taken as known
    ones.
    """
    synonyms = store.load_synonyms(session.store)
    captions = _load_captions(session, synonyms)
    asked = {
        t.name: (_words(t.phrases, synonyms), _words(t.without, synonyms))
        for t in grammar.terminals
    }
    thrown = {t.name for t in grammar.terminals if t.event == _THROWN}
    parts = _shown(captions, asked, thrown)
    if exact or all(parts.values()):
        return FoundActions(parts, {})
    known = frozenset(word for one in captions for words in one.named for word in words)
    phrases = {name: yes for name, (yes, _) in asked.items()}
    missing = [name for name, of_one in parts.items() if not of_one]
    taken = take_phrases(phrases, missing, known, nearby_table())
    if not taken.phrases:
        return FoundActions(parts, {})
    again = {name: (taken.phrases.get(name, yes), no) for name, (yes, no) in asked.items()}
    more = _shown(captions, again, thrown)
    return FoundActions({**parts, **{name: more[name] for name in taken.phrases}}, taken.takings)


@dataclass(frozen=True)
class _Said:
    """A caption: its part of a capture, the actions that it names, and whether it may be cut."""

    part: ShownAction
    named: tuple[frozenset[str], ...]
    may_cut: bool


def _load_captions(session: Session, synonyms: Mapping[str, str]) -> list[_Said]:
    captions = store.load_captions(session.store)
    loaded = []
    for info in store.load_captures(session.store):
        of_one = captions.get(info.capture_id, ())
        timed = any(caption.start is not None for caption in of_one)
        for caption in of_one:
            part = ShownAction(info.name, caption.start, caption.end)
            may_cut = caption.start is not None or not timed
            loaded.append(_Said(part, _named_actions(caption.words, synonyms), may_cut))
    return loaded


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


# The clips of a motion grammar's terminals, from the captures of a database.


@dataclass(frozen=True, eq=False)
class SceneClips:
    """The clips of a grammar, and the motions of their captures by name.

    The captions determine which parts of captures show an action (:func:`find_with_words`). The
    annotated events, or else the motion, determine the time of its event and where it can be cut.
    The rest is done by :mod:`motiondb.scene.clips.clips`. Making a library takes a second or two,
    so the session keeps it until the database changes.
    """

    library: ClipLibrary
    motions: Mapping[str, Motion]


_Events = Mapping[int, tuple[Event, ...]]


def scene_clips(
    session: Session,
    grammar: MotionGrammar,
    settings: VariantSettings | None = None,
    exact: bool = False,
) -> SceneClips:
    """Return the clips of all terminals of a grammar.

    `exact`: Whether words that no caption holds match nothing rather than being taken as known
    ones.
    """
    chosen = settings or VariantSettings()
    return session.kept(
        ("scene clips", grammar, chosen, exact),
        lambda: _make(session, grammar, store.load_events(session.store), (chosen, exact)),
    )


def _make(
    session: Session, grammar: MotionGrammar, events: _Events, how: tuple[VariantSettings, bool]
) -> SceneClips:
    settings, exact = how
    infos = {
        info.name: info for info in store.load_captures(session.store) if info.kind == "captured"
    }
    actions = {
        terminal: _evenly([part for part in parts if part.capture in infos], settings.most)
        for terminal, parts in find_actions(session, grammar, exact).items()
    }
    names = sorted({part.capture for parts in actions.values() for part in parts})
    motions = {n: store.load_motion(session.store, infos[n].capture_id) for n in names}
    shown, seen = [], dict[str, BodyFrames]()
    for terminal in grammar.terminals:
        for part in actions[terminal.name]:
            start, end = _frames(part, motions[part.capture], seen)
            if end - start >= SHORTEST:
                info = infos[part.capture]
                shown.append(
                    ShownMotion(
                        terminal.name,
                        part.capture,
                        motions[part.capture],
                        start,
                        end,
                        terminal.event,
                        events.get(info.capture_id, ()),
                        info.tags.get("licence", ""),
                    )
                )
    _check_terminals(grammar, {one.terminal for one in shown})
    library = make_library(shown, [terminal.name for terminal in grammar.terminals], settings)
    used = sorted({source.capture for source in library.source})
    return SceneClips(library, {name: motions[name] for name in used})


def _evenly(parts: list[ShownAction], most: int) -> list[ShownAction]:
    """Return at most ``most`` of the parts, evenly spaced; each gives a piece or more."""
    chosen = np.linspace(0, len(parts) - 1, min(len(parts), max(most, 1))).round().astype(int)
    return [parts[k] for k in chosen]


def _frames(part: ShownAction, motion: Motion, seen: dict[str, BodyFrames]) -> tuple[int, int]:
    """Return the frames that show an action; ``seen`` keeps analysed captures with throws."""
    start = 0 if part.start is None else round(part.start * MOTION_FPS)
    end = motion.n_frames if part.end is None else round(part.end * MOTION_FPS)
    end = min(end, motion.n_frames)
    if not part.stretch or end - start < SHORTEST:
        return start, end
    if part.capture not in seen:
        seen[part.capture] = body_frames(motion)
    first, last = throw_frames(seen[part.capture], start, end)
    return (first, last) if part.stretch == THROW else (start, first)


def _check_terminals(grammar: MotionGrammar, shown: set[str]) -> None:
    """Refuse a grammar with terminals that no capture shows."""
    missing = [terminal for terminal in grammar.terminals if terminal.name not in shown]
    if not missing:
        return
    asked = "; ".join(
        f"{terminal.name} ({', '.join(map(repr, terminal.phrases)) or 'no phrase'}"
        + (f" without {', '.join(map(repr, terminal.without))}" if terminal.without else "")
        + ")"
        for terminal in missing
    )
    count = "a terminal" if len(missing) == 1 else f"{len(missing)} terminals"
    raise SceneError(
        f"{grammar.name}: expected captures for every terminal, found none for {count}: {asked}."
        " Add captures whose words say so, one action a caption (motiondb words set CAPTURE), or"
        " change the phrases in the grammar's file."
    )
