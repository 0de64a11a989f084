"""The plan of a motion: a question's tree as a list of planned actions.

A planned action has one excerpt of motion, or several that are repetitions. The nodes of the tree
are honoured as follows:

    Action              an action; words of speed among its manners say how fast it is
    InOrder, Both       the actions one after the other
    AtOnce              one action that shows all parts
    AnyOf               one of the alternatives, drawn at random
    Without             an exclusion of every action of its part
    Repeated, Lasting   of one action: how often, how long; of several: the whole list again, or
                        equal shares of the time

Notes report what was decided and what cannot be shown.
"""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass, replace

import numpy as np

from motiondb.errors import QueryError
from motiondb.language.question.amounts import SPEEDS, Measure
from motiondb.language.question.readings import say, say_count, say_duration
from motiondb.language.question.tree import (
    Action,
    AmountNode,
    AnyOf,
    Anything,
    AtOnce,
    Both,
    InOrder,
    Lasting,
    Measured,
    Node,
    NotUsed,
    Repeated,
    Without,
    actions_of,
)
from motiondb.meaning.occurrences import beside_event, seen_event
from motiondb.meaning.postures import is_posture_alone, posture_of
from motiondb.records import MOTION_FPS

MOST_ACTIONS = 128
"""Largest number of actions of a sentence, counting repetitions, as in ``readings.MOST_PARTS``."""
MOST_TIMES = 50  # Largest number of repetitions of one action
MOST_SECONDS = 600.0
"""Largest duration of one action, seconds: longer motions are better joined elsewhere."""
NEAR_ENOUGH = 0.1  # Largest relative difference from a requested duration that still counts as met


@dataclass(frozen=True)
class Amount:
    """A number of repetitions or seconds: ``least`` to ``most``, None without an upper limit."""

    least: float
    most: float | None

    @property
    def wanted(self) -> float:
        """The amount to make: the lower limit, or half of the upper one where there is none.

        >>> Amount(3, 3).wanted, Amount(2, None).wanted, Amount(0, 3).wanted
        (3.0, 2.0, 1.5)
        """
        if self.least > 0.0 or self.most is None:
            return float(self.least)
        return float(self.most) / 2.0


def is_within(seconds: float, asked: Amount) -> bool:
    """Whether a duration is near enough to what was asked for; "at least" is meant strictly.

    >>> is_within(2.8, Amount(3, 3)), is_within(2.8, Amount(3, None)), is_within(3.4, Amount(3, 3))
    (True, False, False)
    """
    short = 0.0 if asked.most is None else NEAR_ENOUGH
    if seconds < asked.least * (1.0 - short) - 0.5 / MOTION_FPS:
        return False
    return asked.most is None or seconds <= max(asked.most, 0.1) * (1.0 + NEAR_ENOUGH)


def say_times(times: Amount) -> str:
    """A number of repetitions in words.

    >>> say_times(Amount(3, 3))
    '3 times'
    """
    return say_count(int(times.least), None if times.most is None else int(times.most))


_RESTS = (("stand",), ("sit",))


@dataclass(frozen=True)
class PlannedAction:
    """One action of a motion."""

    # Words of the actions that are shown at the same time; usually one group
    groups: tuple[tuple[str, ...], ...]
    speed: str = ""  # "slow", "fast", or "" if the sentence does not mention speed
    excluded: tuple[tuple[str, ...], ...] = ()  # Words of every action that must not be shown
    times: Amount | None = None
    seconds: Amount | None = None
    measure: Measure | None = None  # How far, how fast or by which angle
    beside: tuple[str, ...] = ()  # Words of the actions that "and" joins with it

    @property
    def words(self) -> tuple[str, ...]:
        """Words of all groups, each once."""
        return tuple(dict.fromkeys(word for group in self.groups for word in group))

    @property
    def posture(self) -> str:
        """The posture that it takes, if it does nothing else but stand or sit; "" for others."""
        each = self.posed  # of several groups, the same words once
        words = each[0] if len(each) == 1 else tuple(dict.fromkeys(w for one in each for w in one))
        return posture_of(words) if all(map(is_posture_alone, self.posed)) else ""

    def looked_for(self, known: Container[str]) -> str:
        """Its posture, or its clear event where no known word names it; "" for others."""
        is_event = len(self.groups) == 1 and not beside_event(self.words)
        return self.posture or (seen_event(self.words, known) if is_event else "")

    @property
    def posed(self) -> tuple[tuple[str, ...], ...]:
        """The groups but standing and sitting, in which a posture is held; all if none is left."""
        return tuple(group for group in self.groups if group not in _RESTS) or self.groups


def plan_sentence(
    tree: Node, rng: np.random.Generator
) -> tuple[tuple[PlannedAction, ...], tuple[str, ...], tuple[NotUsed, ...]]:
    """Plan the actions of a sentence.

    >>> walk, run = Action(("walk",), ("slow",)), Action(("run",))
    >>> found, _, _ = plan_sentence(InOrder((walk, Repeated(run, 3, 3))), np.random.default_rng(0))
    >>> [(a.words, a.speed, a.times) for a in found]
    [(('walk',), 'slow', None), (('run',), '', Amount(least=3, most=3))]
    """
    notes = _Notes([], [])
    planned = _plan(tree, rng, notes)
    if len(planned) > MOST_ACTIONS:
        raise QueryError(
            f"question: expected at most {MOST_ACTIONS} actions in order, found {len(planned):,}. "
            "Ask for fewer at a time."
        )
    return (tuple(planned), tuple(dict.fromkeys(notes.decided)), tuple(dict.fromkeys(notes.left)))


@dataclass(frozen=True)
class _Notes:
    """What is decided, and what is left out."""

    decided: list[str]
    left: list[NotUsed]


def speed_of(manner: str) -> str:
    """Whether a manner is a word of speed: "slow", "fast" or "".

    >>> speed_of("brisk"), speed_of("slowly"), speed_of("happy")
    ('fast', 'slow', '')
    """
    for name, group in zip(("slow", "fast"), SPEEDS):
        if manner in group:
            return name
    return ""


def _plan(node: Node, rng: np.random.Generator, notes: _Notes) -> list[PlannedAction]:
    match node:
        case Action():
            return _plan_action(node, notes)
        case Anything():
            notes.left.append(NotUsed("?", "no motion is made for an open action"))
            return []
        case AnyOf():
            chosen = int(rng.integers(len(node.parts)))
            others = [say(part) for n, part in enumerate(node.parts) if n != chosen]
            notes.decided.append(
                f"of the alternatives, {say(node.parts[chosen])!r} was drawn; another seed may "
                f"draw {' or '.join(map(repr, others))}"
            )
            return _plan(node.parts[chosen], rng, notes)
        case Without():
            excluded = _excluded(node.excluded, notes)
            below = _plan(node.part, rng, notes)
            return [replace(a, excluded=(*a.excluded, *excluded)) for a in below]
        case Repeated() | Lasting() | Measured():
            return _with_amount(_plan(node.part, rng, notes), node, notes)
        case AtOnce():
            return _at_once([_plan(part, rng, notes) for part in node.parts], node, notes)
        case InOrder():
            return [action for part in node.parts for action in _plan(part, rng, notes)]
        case Both():
            notes.decided.append(f"{say(node)!r}: made one after the other")
            planned = [action for part in node.parts for action in _plan(part, rng, notes)]
            words = [word for action in planned for word in action.words]
            return [replace(a, beside=tuple(w for w in words if w not in a.words)) for a in planned]


def _with_amount(
    actions: list[PlannedAction], node: AmountNode, notes: _Notes
) -> list[PlannedAction]:
    """Planned actions as often or as long as a node asks for."""
    match node:
        case Repeated():
            return _repeated(actions, node, notes)
        case Lasting():
            return _lasting(actions, node, notes)
        case Measured():
            if len(actions) == 1 and actions[0].measure is None:
                return [replace(actions[0], measure=node.measure)]
            notes.left.append(NotUsed(node.measure.say(), "one amount of one action is measured"))
            return actions


def _plan_action(node: Action, notes: _Notes) -> list[PlannedAction]:
    """One action; words of speed are not among the words to show."""
    speeds = [speed for word in node.all_words if (speed := speed_of(word))]
    words = tuple(word for word in node.all_words if not speed_of(word))
    if not words:
        notes.left.append(NotUsed(say(node), "it names no action"))
        return []
    return [PlannedAction((words,), speeds[0] if speeds else "")]


def _at_once(
    parts: Sequence[list[PlannedAction]], node: Node, notes: _Notes
) -> list[PlannedAction]:
    """Parts in the same interval: single actions go along with every action of the longest."""
    filled = [part for part in parts if part]
    if not filled:
        return []
    longest = max(filled, key=len)
    merged = list(longest)
    for part in filled:
        if part is longest:
            continue
        if len(part) > 1:
            notes.left.append(NotUsed(say(node), "orders at once are made one after the other"))
            merged += part
            continue
        second = part[0].measure
        if second is not None and any(action.measure for action in merged):
            notes.left.append(NotUsed(second.say(), "one amount of one action is measured"))
        merged = [_with_groups(action, part[0]) for action in merged]
    return merged


def _with_groups(action: PlannedAction, other: PlannedAction) -> PlannedAction:
    """Two actions as one that shows both."""
    return PlannedAction(
        tuple(dict.fromkeys((*action.groups, *other.groups))),
        action.speed or other.speed,
        (*action.excluded, *other.excluded),
        action.times or other.times,
        action.seconds or other.seconds,
        action.measure or other.measure,
    )


def _repeated(actions: list[PlannedAction], node: Repeated, notes: _Notes) -> list[PlannedAction]:
    amount = Amount(node.least, node.most)
    times = max(round(amount.wanted), 1)
    if times > MOST_TIMES:
        raise QueryError(
            f"question: expected at most {MOST_TIMES} repetitions, found {times:,}. "
            "Ask for fewer at a time."
        )
    if len(actions) == 1 and actions[0].times is None:
        return [replace(actions[0], times=amount)]
    if node.least < 1 and actions:
        notes.decided.append(f"{say_count(node.least, node.most)}: made {times} times")
    return actions * times


def _lasting(actions: list[PlannedAction], node: Lasting, notes: _Notes) -> list[PlannedAction]:
    if max(node.least, 0.0 if node.most is None else node.most) > MOST_SECONDS:
        raise QueryError(
            f"question: expected at most {MOST_SECONDS:g} seconds for an action, found "
            f"{say_duration(node.least, node.most)!r}. Ask for less at a time."
        )
    n = len(actions)
    if n > 1:
        notes.decided.append(f"{say_duration(node.least, node.most)}: shared by {n} actions")
    return [
        replace(
            action,
            seconds=Amount(node.least / n, None if node.most is None else node.most / n),
        )
        for action in actions
    ]


def _excluded(nodes: Sequence[Node], notes: _Notes) -> list[tuple[str, ...]]:
    """Words of the actions that must not be shown; how often and in which order does not count."""
    excluded = []
    for node in nodes:
        if not isinstance(node, (Action, Anything)):
            notes.decided.append(
                f"not {say(node)}: its actions are excluded in any order, number and duration"
            )
        excluded += [action.all_words for action in actions_of(node) if action.all_words]
    return excluded
