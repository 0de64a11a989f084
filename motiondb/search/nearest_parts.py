"""Answers to a path or a rhythm: the parts of captures that deviate least, also with words."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from motiondb.learn.learned import Learned
from motiondb.records import Match
from motiondb.search.asked_words import learned_words
from motiondb.search.by_example import ExampleAnswer
from motiondb.search.matches import mark_generated, shown_words, to_seconds


@dataclass(frozen=True)
class Part:
    """A part of a capture that is nearest to what was asked for."""

    capture: int
    start: int  # Frame, 30 a second
    end: int  # Frame + 1
    deviation: float  # What ranks, smaller is better
    said: str  # What of it was measured


@dataclass(frozen=True)
class Shown:
    """Where a capture shows words that are asked for beside a path or a rhythm."""

    said: str
    start: int  # Frame, 30 a second
    end: int  # Frame + 1


def answer_parts(
    learned: Learned,
    parts: Iterable[Part],
    most: float,
    limit: int,
    shown: Mapping[int, Shown] | None = None,
) -> ExampleAnswer:
    """The answer to a question: one part of each capture, best first.

    `most`: Largest deviation that is no miss. `shown`: Capture -> where it shows the words, with
    which its part must have a frame in common.
    """
    ranked = sorted(parts, key=lambda one: (one.deviation, one.capture))
    if shown is not None:
        ranked = [
            o for o in ranked if o.start < shown[o.capture].end and o.end > shown[o.capture].start
        ]
    matches = tuple(
        _match(learned, rank, one, shown[one.capture].said if shown else "")
        for rank, one in enumerate(ranked[:limit], start=1)
    )
    return ExampleAnswer(matches, 1.0 - ranked[0].deviation if ranked else None, 1.0 - most)


def _match(learned: Learned, rank: int, one: Part, more: str) -> Match:
    return Match(
        rank,
        learned.captures[one.capture].name,
        *to_seconds(learned, one.capture, one.start, one.end),
        1.0 - one.deviation,
        shown_words(learned_words(learned), one.capture, one.start, one.end)
        if learned.has_words
        else (),
        "; ".join(filter(None, (one.said, more, mark_generated(learned, one.capture)))),
    )
