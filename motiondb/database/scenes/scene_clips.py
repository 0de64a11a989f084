"""Which parts of captures show the actions of a motion grammar, by what people wrote.

A caption speaks for an action where it tells of this one only: what it tells holds all words of one
of the terminal's phrases, and of none of those that it is to be without. That the way turns or
ends is no other action: "walk, veer left" and "run, stop" show walking and running, and steps
that turn are welcome. A caption with times is about its part of the capture, one without about
the whole.

Where a caption tells of several actions in their order, each one of the grammar and one of them a
throw (its instant a release), hands show where the throw lies (see :mod:`~.clips.throws`): its
clip is from there, and what is told before comes from before. A capture of which other captions
say times does not need this.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from motiondb import store
from motiondb.scene.language.motion_grammar import MotionGrammar, Terminal
from motiondb.words.vocabulary import split_actions, words_of

if TYPE_CHECKING:
    from motiondb.database.session import Session


THROW, BEFORE = "throw", "before"
"""Stretches of a part of a capture: somebody throws, and what they do before they do."""
_THROWN = "release"

_WAY = frozenset(("turn", "veer", "curve", "left", "right", "stop", "sudden", "suddenly", "degree"))
"""Words that tell of the way of an action, not of another one."""


@dataclass(frozen=True)
class ShownAction:
    """A part of a capture that shows an action, seconds; None for the whole.

    ``stretch`` says which stretch of it where it shows other actions, too: THROW, or what is BEFORE
    a throw; "" for all of it.
    """

    capture: str
    start: float | None
    end: float | None
    stretch: str = ""


def shows(terminal: Terminal, caption: str, synonyms: Mapping[str, str] | None = None) -> bool:
    """Whether a caption says that its part of a capture shows the action.

    >>> shoot = Terminal("shoot", ("shoot", "jump shot"), ("fake",))
    >>> [shows(shoot, text) for text in ("takes a jump shot", "fakes a shot", "runs, shoots")]
    [True, False, False]
    >>> [shows(Terminal("walk", ("walk",)), text) for text in ("walk, veer left", "turn left")]
    [True, False]
    """

    told = _told(caption, synonyms)
    return _speaks(told, _words(terminal.phrases, synonyms), _words(terminal.without, synonyms))


def find_actions(session: Session, grammar: MotionGrammar) -> dict[str, tuple[ShownAction, ...]]:
    """For every terminal the parts of captures that show it, each once, in the order of names."""
    found: dict[str, dict[ShownAction, None]] = {t.name: {} for t in grammar.terminals}
    synonyms = store.load_synonyms(session.store)
    captions = store.load_captions(session.store)
    asked = {
        t.name: (_words(t.phrases, synonyms), _words(t.without, synonyms))
        for t in grammar.terminals
    }
    thrown = {t.name for t in grammar.terminals if t.event == _THROWN}
    for info in store.load_captures(session.store):
        of_one = captions.get(info.capture_id, ())
        timed = any(caption.start is not None for caption in of_one)
        for caption in of_one:
            told = _told(caption.words, synonyms)
            part = ShownAction(info.name, caption.start, caption.end)
            for name, (phrases, without) in asked.items():
                if _speaks(told, phrases, without):
                    found[name][part] = None
            if caption.start is not None or not timed:
                for name, stretch in _about_a_throw(told, asked, thrown):
                    found[name][replace(part, stretch=stretch)] = None
    return {name: tuple(parts) for name, parts in found.items()}


_Words = tuple[frozenset[str], ...]


def _about_a_throw(
    told: _Words, asked: Mapping[str, tuple[_Words, _Words]], thrown: set[str]
) -> list[tuple[str, str]]:
    """The actions of a caption that tells of a throw and others, each with its stretch."""
    shown = [{n for n, (yes, no) in asked.items() if _speaks((w,), yes, no)} for w in told]
    throws = [k for k, names in enumerate(shown) if names & thrown]
    if len(told) < 2 or not all(shown) or len(throws) != 1:
        return []
    at = throws[0]
    found = sorted(shown[at] & thrown)
    if any(no <= words for name in found for no in asked[name][1] for words in told):
        return []  # a feigned throw, which hands cannot tell from one
    before = set.intersection(*shown[:at]) if at else set()
    return [(name, THROW) for name in found] + [(name, BEFORE) for name in sorted(before)]


def _words(
    phrases: Iterable[str], synonyms: Mapping[str, str] | None
) -> tuple[frozenset[str], ...]:
    """The words of every phrase that has any."""
    return tuple(words for p in phrases if (words := frozenset(words_of(p, synonyms))))


def _told(caption: str, synonyms: Mapping[str, str] | None) -> tuple[frozenset[str], ...]:
    """The words of every action that a caption tells of."""
    actions = tuple(frozenset(words) for words in split_actions(caption, synonyms))
    return tuple(w for w in actions if not w <= _WAY) if len(actions) > 1 else actions


def _speaks(
    told: tuple[frozenset[str], ...],
    phrases: tuple[frozenset[str], ...],
    without: tuple[frozenset[str], ...],
) -> bool:
    return bool(told) and all(
        any(phrase <= words for phrase in phrases) and not any(no <= words for no in without)
        for words in told
    )
