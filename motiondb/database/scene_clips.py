"""Which parts of captures show the actions of a motion grammar, by what people wrote.

A caption speaks for an action where it tells of this one only: what it tells holds all words of one
of the terminal's phrases, and of none of those that it is to be without. That the way turns or
ends is no other action: "walk, veer left" and "run, stop" show walking and running, and steps
that turn are welcome. A caption with times is about its part of the capture, one without about
the whole.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from motiondb import store
from motiondb.scene.motion_grammar import MotionGrammar, Terminal
from motiondb.words.vocabulary import split_actions, words_of

if TYPE_CHECKING:
    from motiondb.database.motion_db import MotionDB


_WAY = frozenset(("turn", "veer", "curve", "left", "right", "stop", "sudden", "suddenly", "degree"))
"""Words that tell of the way of an action, not of another one."""


@dataclass(frozen=True)
class ShownAction:
    """A part of a capture that shows an action, seconds; None for the whole."""

    capture: str
    start: float | None
    end: float | None


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


def find_actions(base: MotionDB, grammar: MotionGrammar) -> dict[str, tuple[ShownAction, ...]]:
    """For every terminal the parts of captures that show it, each once, in the order of names."""
    found: dict[str, dict[ShownAction, None]] = {t.name: {} for t in grammar.terminals}
    synonyms = store.load_synonyms(base.store)
    captions = store.load_captions(base.store)
    asked = {
        t.name: (_words(t.phrases, synonyms), _words(t.without, synonyms))
        for t in grammar.terminals
    }
    for info in base.captures():
        for caption in captions.get(info.capture_id, ()):
            told = _told(caption.words, synonyms)
            part = ShownAction(info.name, caption.start, caption.end)
            for name, (phrases, without) in asked.items():
                if _speaks(told, phrases, without):
                    found[name][part] = None
    return {name: tuple(parts) for name, parts in found.items()}


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
