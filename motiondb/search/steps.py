"""A question as a series of steps, each of which asks something of captures.

What a step asks can be told of captures one by one, such as which of them answer a question best.
So captures may lie in several places. Each place tells of its own. What they tell, joined, is
what one place with all captures would have told. What follows from all captures together is
decided between the steps.
"""

from __future__ import annotations

from collections.abc import Collection, Generator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias, TypeVar

from motiondb.search.seen_frames import Features

Asked = TypeVar("Asked")
AskedHere = TypeVar("AskedHere", contravariant=True)
Told = TypeVar("Told")
Answer = TypeVar("Answer")
Value = TypeVar("Value")


@dataclass(frozen=True, eq=False)
class Place:
    """Captures that are asked, in one place."""

    captures: Collection[int]  # Their numbers, in order
    # Recognition features of each; None where frames are not looked at
    features: Features | None = None

    def __post_init__(self) -> None:
        """Keep the numbers in their order, but so that one is looked up at once."""
        object.__setattr__(self, "captures", dict.fromkeys(self.captures))


class Step(Protocol[AskedHere, Told]):
    """What a question asks of captures."""

    def tell(self, asked: AskedHere, place: Place) -> Told:
        """What the captures of a place say to a question."""

    def join(self, told: Sequence[Told]) -> Told:
        """What the captures of all places say, from what those of each say."""


Steps: TypeAlias = Generator[tuple[Asked, Step[Any, Any]], Any, Answer]
"""Yields what is asked and each step of it, takes what is told, and returns the answer."""


def take(asked: Asked, step: Step[Any, Told]) -> Steps[Asked, Told]:
    """One step of a question; returns what is told."""
    told: Told = yield asked, step
    return told


def answer_here(steps: Steps[Any, Answer], place: Place) -> Answer:
    """The answer to a question where all captures are in one place."""
    try:
        asked, step = next(steps)
        while True:
            asked, step = steps.send(step.join([step.tell(asked, place)]))
    except StopIteration as end:
        answer: Answer = end.value
        return answer


def joined(told: Sequence[Mapping[int, Value]]) -> Mapping[int, Value]:
    """What several places tell of their captures, by number; that of one place as it is."""
    if len(told) == 1:
        return told[0]
    return {capture: value for each in told for capture, value in each.items()}
